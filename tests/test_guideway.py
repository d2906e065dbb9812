"""What a sliding joint does beside its travel, and again and again along it, in forms that no effect has."""

from dataclasses import replace
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
from diagnosis_cases import found, measured, named, robot

from workbench import compare, load_robot, predict, write_outcome
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.diagnosis.run import diagnose
from workbench.effects.acting import Acting
from workbench.effects.guideway import Guideway
from workbench.robot.kinematics import frames
from workbench.simulation.export import export

MODELS = Path(__file__).resolve().parents[1] / "models"

SECTIONS = np.array([0.0, 0.11, 0.27, 0.38, 0.5])  # m, where straight pieces of a column meet
OFF = 1e-4 * np.array(
    [
        [0.0, 1.5, -0.5, 1.0, -1.0],
        [0.0, -1.0, 0.5, 0.5, -0.5],
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 2.0, 1.0, -1.5, 0.5],
        [0.0, 0.5, -2.0, 0.0, 1.5],
        [0.0, -1.0, 1.0, 1.0, -1.0],
    ]
)  # m and rad, on the axes of the joint that the carriage carries


def strays(problem):
    """The carriage of joint 2 runs on straight sections that meet at angles."""
    return {18 + i: np.interp(problem.q[:, 1], SECTIONS, off) for i, off in enumerate(OFF)}


def case_of(poses=20):
    arm = robot("cylindrical")
    return problem_of(planned(arm, random_poses(arm, poses, np.random.default_rng(2))))


def test_a_carriage_moves_as_a_body_on_its_joints_axes():
    """Rolled by the guide it turns about the travel, shifted across it keeps its attitude."""
    case = case_of()
    one = next(e for e in Guideway.sites(case) if e.where.joint == "joint_3")
    rest = frames(case.arm, case.q)
    along = rest.axes[:, 3, 2]  # (N, 3) the way that joint 3 slides
    for name, turns in (("roll", True), ("amplitude", False)):
        values = one.given({name: 1e-5})
        moved = frames(case.arm, case.q, Acting(((one, values),)).direct(case))
        turn = np.einsum("nij,nkj->nik", moved.R[-1], rest.R[-1])
        about = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=1)
        shift = moved.p[4] - rest.p[4]
        if turns:
            assert np.abs(about).max() > 5e-6
            assert np.abs(np.cross(about, along)).max() < 1e-9
            assert np.abs(shift).max() < 1e-9
        else:
            assert np.abs(about).max() < 1e-9
            assert np.abs(shift).max() > 5e-6
            assert np.abs((shift * along).sum(axis=1)).max() < 1e-9


def test_a_guide_that_is_not_straight_is_named_and_corrected(tmp_path):
    campaign = measured("cylindrical", motion=strays, poses=90, loads=(20.0,))
    outcome = diagnose(campaign)
    told = outcome.diagnosis
    assert named(told) == {("joint_map", "joint_2"): "named"}
    (cause,) = told.causes
    assert "guide" in cause.title
    assert told.headline.startswith("Found: guide error in joint_2.")
    assert "guide" in cause.variant
    assert {p.name: p.unit for p in cause.parameters} == {
        "amplitude": "m", "along": "m", "tilt": "rad", "roll": "rad",
    }  # fmt: skip
    _, geometry, final = told.stages
    assert final.heldout_rms_mm < 0.6 * geometry.heldout_rms_mm
    write_outcome(outcome, tmp_path)
    model = load_robot(tmp_path / "model.toml")
    poses = campaign.poses.q[:10].copy()
    inside = np.median(predict(model, poses).corrected)
    poses[:, 1] += 5.0  # where no guide was measured
    assert np.median(predict(model, poses).corrected) > 1.5 * inside


def test_a_guide_that_is_the_same_in_two_campaigns_is_no_change():
    whole = measured("cylindrical", motion=strays, poses=80, loads=(20.0,))
    halves = [whole.some(np.arange(first, whole.n_poses, 2)) for first in (0, 1)]
    told = compare(
        [replace(half, title=title) for half, title in zip(halves, ("first", "later"), strict=True)]
    )
    assert not [change for change in told.changes if change.status == "named"]


def test_what_repeats_along_a_travel_is_named_with_its_period():
    """A pinion that runs out, not quite as a sine."""

    def pinion(problem):
        phase = 2 * np.pi * problem.q[:, 1] / 0.0628 + 0.4
        return np.eye(3)[1] * (4e-5 * (np.sin(phase) + 0.15 * np.sin(2 * phase)))[:, None]

    told = found(measured("cylindrical", joints=pinion, poses=90, loads=(20.0,)))
    assert named(told) == {("gear_kinematic_error", "joint_2"): "named"}
    (cause,) = told.causes
    assert cause.where.order == pytest.approx(2 * np.pi / 0.0628, rel=1e-2)  # 8 cycles were measured
    assert cause.parameters[0].unit == "m"
    assert cause.parameters[0].value == pytest.approx(4e-5, rel=0.2)
    assert "mm of its travel" in cause.sentence
    assert "turn" not in cause.sentence


def test_a_rack_grows_from_where_it_is_held():
    """Warmer at one end than at the other."""
    warm = np.linspace(14.0, 34.0, 180)

    def grows(problem):
        way = problem.q[:, 1] - 0.35
        return np.eye(3)[1] * (problem.warmth * 1.2e-5 * way * (1 + 0.2 * way))[:, None]

    campaign = measured("cylindrical", joints=grows, poses=90, loads=(20.0,), temperature=warm, sigma=1e-5)
    told = found(campaign)
    assert named(told) == {("thermal_growth", "joint_2"): "named"}
    size, shift = told.causes[0].parameters
    assert size.value == pytest.approx(1.2e-5, rel=0.2)
    assert -shift.value / size.value == pytest.approx(0.35, abs=0.08)
    assert "rack" in told.causes[0].sentence


def test_an_exported_rack_errs_over_all_that_it_travels(tmp_path):
    """A turn and a metre are not the same: a rail is longer than 6.28 m."""
    folder = Path(copytree(MODELS / "cylindrical", tmp_path / "rail"))
    urdf, toml = folder / "cylindrical.urdf", folder / "cylindrical.toml"
    text = urdf.read_text(encoding="utf-8")
    urdf.write_text(text.replace('upper="0.5" effort="5000"', 'upper="9.5" effort="5000"'), encoding="utf-8")
    found = '\n[[effects]]\ncause = "gear_ratio"\njoint = "joint_2"\nvalues = { relative = 1e-4 }\n'
    toml.write_text(toml.read_text(encoding="utf-8") + found, encoding="utf-8")
    poses = planned(load_robot(toml), np.tile([[0.3, 0.2, 0.35]], (3, 1)))
    written = export(toml, "drake", tmp_path / "out", campaign=poses)
    (file,) = (one for one in written.files if one.name == "effects.npz")
    with np.load(file) as data:
        (curve,) = (data[key] for key in data.files if key.startswith("gear/1/1/"))
    assert curve[0, -1] == pytest.approx(9.5)
    assert np.ptp(curve[1]) == pytest.approx(9.5e-4)
