"""One wrong number does not decide: it is named and left out, and the diagnosis stays what it was."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_cases import found, measured, named, robot, with_points

from workbench.campaign import load_campaign, write_campaign
from workbench.campaign.planned import random_poses
from workbench.campaign.problem import problem_of
from workbench.cli.main import main
from workbench.diagnosis import run
from workbench.diagnosis.first_look import first_look
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.weighing.components import cause_components
from workbench.effects.unnamed.loads import OwnWeights
from workbench.files.faults import InputError, read_text
from workbench.files.toml import read_toml
from workbench.report.content import content
from workbench.report.terminal import short_verdict
from workbench.robot.description import load_robot
from workbench.robot.loads import wrenches
from workbench.robot.rigid_plant import arrays

POSE = 7


@cache
def clean(**options):
    campaign = measured("ur5", poses=40, loads=(), **options)
    return campaign, prepare(campaign)


def spoilt(change, **options):
    campaign, _ = clean(**options)
    points = campaign.points.copy()
    change(points)
    return with_points(campaign, points)


def put(where, value):
    return lambda points: points.__setitem__(where, value)


def move(where, by):
    return lambda points: points.__setitem__(where, points[where] + by)


def many(points):
    rng = np.random.default_rng(5)
    rows = rng.permutation(40)[:8]
    points[rows] += rng.normal(size=(8, 3, 3)) * 10 ** rng.uniform(-1, 3, (8, 1, 1))


SPOILT = {
    "a point 300 m off": (move((POSE, 1), [0, 300.0, 0]), {str(POSE + 1)}),
    "a point at the end of the world": (put((POSE, 1), 1e250), {str(POSE + 1)}),
    "zeros": (put((POSE, 1), 0.0), {str(POSE + 1)}),
    "half a point": (put((POSE, 1, 2), np.nan), {str(POSE + 1)}),
    "a whole pose": (move(POSE, [0, 0, 0.3]), {str(POSE + 1)}),
    "two poses exchanged": (lambda z: z.__setitem__([3, 9], z[[9, 3]]), {"4", "10"}),
    "many of all sizes": (many, {str(i + 1) for i in np.random.default_rng(5).permutation(40)[:8]}),
    "a whole target": (put((slice(None), 2), np.random.default_rng(6).normal(size=(40, 3))), {None}),
}


@pytest.mark.parametrize(("case", "state_sigma"), [(case, i % 2 == 0) for i, case in enumerate(SPOILT)])
def test_gross_outliers_are_named_and_change_nothing(case, state_sigma):
    change, poses = SPOILT[case]
    _, before = clean(state_sigma=state_sigma)
    after = prepare(spoilt(change, state_sigma=state_sigma))
    assert not before.faults
    assert {fault.pose_id for fault in after.faults} == poses
    assert {fault.kind for fault in after.faults} == {"outlier"}
    assert after.noise.sigma_mm == pytest.approx(before.noise.sigma_mm, rel=0.15)
    off = after.geometry.state.geometry - before.geometry.state.geometry
    std = np.sqrt(np.diag(before.geometry.covariance)[before.geometry.columns.geometry_slice])
    assert np.max(np.abs(off.ravel()[before.geometry.columns.geometry]) / std) < 2


def test_a_joint_beyond_all_measure_leaves_its_pose_out():
    campaign, before = clean()
    q = campaign.poses.q.copy()
    q[POSE, 2] = 1e300
    after = prepare(campaign.with_poses(q=q))
    assert [fault.pose_id for fault in after.faults] == [str(POSE + 1)]
    assert len(after.problem.q) == len(before.problem.q) - 1


def test_an_instrument_moved_by_far_is_two_set_ups():
    after = prepare(spoilt(move(slice(25, None), [0.3, -0.2, 0.1])))
    assert [(fault.kind, fault.pose_id) for fault in after.faults] == [("moved_instrument", "26")]
    assert after.problem.campaign.poses.setup.tolist() == [0] * 25 + [1] * 15


def test_one_point_300_m_off_changes_no_cause():
    hidden = ("gear_eccentricity:joint=joint_2,variant=1,amplitude=4e-4,phase=0.4",)
    campaign = measured("kr500", hidden, poses=40, loads=(250.0,))
    points = campaign.points.copy()
    points[POSE, 0] += [300.0, 0, 0]
    before, after = found(campaign), found(with_points(campaign, points))
    assert named(before)
    assert named(after) == named(before)
    assert after.verdict == before.verdict
    assert after.stages[-1].heldout_rms_mm == pytest.approx(before.stages[-1].heldout_rms_mm, rel=0.05)


def test_the_test_campaign_is_cleaned_by_the_same_rules():
    campaign, _ = clean()
    other = measured("ur5", poses=40, loads=(), seed=2)
    # the same robot and instrument: one campaign, its halves
    train, test = campaign.some(np.arange(25)), campaign.some(np.arange(25, 40))
    points = test.points.copy()
    points[4] += [0.3, 0, 0]
    before = diagnose(train, test).diagnosis.test
    after = diagnose(train, with_points(test, points)).diagnosis.test
    assert before is not None
    assert after is not None
    assert before.faults == ()
    assert before.all_rms_mm == pytest.approx(before.after_rms_mm)
    assert {fault.pose_id for fault in after.faults} == {"30"}
    assert after.after_rms_mm == pytest.approx(before.after_rms_mm, rel=0.1)
    assert after.all_rms_mm == pytest.approx(300 / np.sqrt(15), rel=0.01)
    assert other.points.shape == campaign.points.shape


def test_a_joint_that_bears_nothing_but_rounding_is_no_cause_of_a_yield():
    _, prepared = clean()
    borne = np.abs(prepared.geometry.line.prediction.load.local[:, -2, 5])
    assert 0 < borne.max() < 1e-12  # N·m: the hand's weight is on the last axis
    found = cause_components(prepared.geometry, run.testable(prepared.problem)[0])
    yielding = {one.key[1].joint for one in found if one.key[0] == "joint_compliance"}
    assert yielding
    assert prepared.problem.arm.names[-1] not in yielding


def test_six_dof_targets_that_were_not_said_are_noticed():
    campaign, _ = clean()
    rng = np.random.default_rng(3)
    exact = measured("ur5", poses=40, loads=(), sigma=0.0, state_sigma=False)
    points = exact.points + rng.normal(0, 3e-5, (40, 1, 3))  # one error for all targets of a pose
    (said,) = [note for note in prepare(with_points(exact, points)).notes if "pose = true" in note]
    assert "T1, T2, T3 never change" in said
    assert not any("pose = true" in note for note in prepare(campaign).notes)


@pytest.mark.parametrize(("order", "said"), [(1, "the pose before"), (-1, "the pose after")])
def test_a_stretch_of_poses_shifted_by_a_row_is_recognised(order, said):
    stretch = np.arange(10, 18)
    faults = prepare(spoilt(lambda z: z.__setitem__(stretch, z[np.roll(stretch, order)]))).faults
    assert [fault.pose_id for fault in faults] == [str(n + 1) for n in stretch]
    assert {fault.kind for fault in faults} == {"shifted_pose"}
    assert all(
        f"fit the joints of {said}: pose_id is mixed up between poses 11 and 18" in f.what for f in faults
    )


def test_a_file_of_six_dof_targets_is_taken_as_such(tmp_path):
    exact = measured("ur5", poses=20, loads=(), sigma=0.0, state_sigma=False)
    bodies = exact.points + np.random.default_rng(3).normal(0, 3e-5, (20, 1, 3))
    loaded = load_campaign(write_campaign(tmp_path / "six", with_points(exact, bodies)))
    assert loaded.six_dof
    (said,) = [line for line in loaded.warnings if "pose = true" in line]
    assert "distances between T1, T2, T3 never change" in said
    one_by_one = measured("ur5", poses=20, loads=())
    assert not load_campaign(write_campaign(tmp_path / "three", one_by_one)).six_dof


def test_a_noise_in_micrometres_is_told_before_and_after_the_fit(tmp_path):
    """30 for 0.03 mm: targets that were measured one by one are no 6-D measurement for that."""
    one_by_one = measured("ur5", poses=40, loads=())
    path = write_campaign(tmp_path / "c", replace(one_by_one, noise_sigma=0.03))
    campaign = load_campaign(path)
    assert not campaign.six_dof
    (said,) = [line for line in first_look(campaign).remarks if "stated noise" in line]
    assert "noise of 30 mm per axis is" in said
    assert "is it in mm?" in said
    told = diagnose(campaign).diagnosis
    assert told.noise.left_mm is not None
    assert told.noise.left_mm < 1
    assert "the fit leaves 0." in short_verdict(told, None)
    usual = measured("ur5", poses=40, loads=())
    assert not any("stated noise" in line for line in first_look(usual).remarks)
    assert diagnose(usual).diagnosis.noise.left_mm is None


def test_points_in_inches_beside_a_campaign_in_millimetres_are_told_as_that(tmp_path):
    """Distances in them change by less than the noise in millimetres: no 6-D measurement for that."""
    rng = np.random.default_rng(11)
    each = [measured("ur5", q=random_poses(robot("ur5"), 16, rng), loads=()) for _ in range(2)]
    each[1] = with_points(each[1], each[1].points / 25.4)
    each = [replace(one, noise_sigma=3e-4) for one in each]
    paths = [write_campaign(tmp_path / name, one) for name, one in zip("ab", each, strict=True)]
    with pytest.raises(InputError) as refused:
        prepare([load_campaign(path) for path in paths])
    (fault,) = refused.value.faults
    assert fault.place == f"{paths[1]}: points"
    assert "only if they are inches, not millimetres" in fault.what


def test_too_few_poses_are_refused_and_few_are_remarked():
    campaign, _ = clean()
    with pytest.raises(InputError, match="do not identify it; measure 15 poses or more"):
        prepare(campaign.some(np.arange(4)))
    assert any(
        "8 different poses give 48 numbers" in note for note in prepare(campaign.some(np.arange(8))).notes
    )


def test_a_fit_that_predicts_badly_is_no_proof_that_nothing_is_missing():
    """By so few poses geometry explains anything: that is no sentence about the robot."""
    few = diagnose(measured("kr500", poses=7, loads=())).diagnosis
    assert few.headline.startswith("Too few poses to say")
    assert "Nothing is missing" not in few.headline
    said = content(few)
    assert said["verdict"]["label"] == "Too few poses"
    assert said["verdict"]["kind"] != "nothing_missing"
    assert "needed" not in said["no_cause"]
    assert said["next_command"].startswith("workbench plan")
    _, tile, _ = said["tiles"]  # page and headline have one number for one thing
    assert f"{tile['before']} → {tile['after']} mm RMS." in few.headline
    more = diagnose(measured("kr500", poses=40, loads=())).diagnosis
    assert more.headline.startswith("Nothing is missing")
    assert content(more)["verdict"]["label"] == "Nothing is missing"
    assert content(more)["next_command"].startswith("workbench compensate")


def test_a_noise_below_that_of_any_instrument_is_not_believed():
    fine = replace(measured("ur5", poses=40, loads=(), targets=1), noise_sigma=2e-8)
    prepared = prepare(fine)
    assert any("Is it in mm?" in note for note in prepared.notes)
    assert prepared.noise.sigma_mm == pytest.approx(1e-3)


def without_masses(campaign, folder):
    urdf = folder / "light.urdf"
    text = re.sub(r'<mass value="[^"]*"', '<mass value="0"', campaign.robot.urdf.read_text(encoding="utf-8"))
    urdf.write_text(text, encoding="utf-8")
    return replace(campaign, robot=replace(campaign.robot, urdf=urdf))


def test_an_arm_that_bends_under_masses_that_its_model_lacks_is_no_gear_that_errs(tmp_path):
    soft = tuple(f"joint_compliance:joint=joint_{j},compliance=2e-5" for j in (2, 3))
    campaign = measured("irb120", soft, poses=80, loads=())
    found = diagnose(without_masses(campaign, tmp_path)).diagnosis
    (rest,) = found.causes
    assert rest.cause == "unknown"
    assert rest.structure == "depends on weights beyond joint_2, which the model lacks"
    assert found.stages[-1].heldout_rms_mm < 1.2 * np.sqrt(3) * 0.03


def joint_by_joint(middle=(0.8, -1.2, 1.2, 0.3, 0.6, 0.2)):
    """(36, 6) [rad] six poses of every joint, the others where they are in the middle."""
    q = np.tile(middle, (36, 1))
    for j, width in enumerate((1.0, 0.7, 0.7, 3.0, 1.2, 3.0)):
        q[6 * j : 6 * j + 6, j] += np.linspace(-width, width, 6)
    return q


def sagging(problem):
    """(N, n) [rad] joints 2 and 3 give by 3 mrad per metre of lever of a weight at the flange."""
    error = np.zeros_like(problem.q)
    for one in OwnWeights.sites(problem)[:2]:
        error[:, problem.joint(one.where.joint)] = 3e-3 * one.x(problem)
    return error


@pytest.mark.parametrize("seed", [1, 2])
def test_a_stretched_arm_that_sags_under_masses_that_its_model_lacks_is_no_outlier(tmp_path, seed):
    rigid = measured("kr500", q=joint_by_joint(), loads=())
    light = problem_of(without_masses(rigid, tmp_path))
    campaign = measured(
        "kr500", joints=lambda _: sagging(light), q=joint_by_joint(), loads=(), state_sigma=False, seed=seed
    )
    assert not prepare(without_masses(campaign, tmp_path)).faults


def test_the_torque_of_any_masses_is_a_sum_of_the_functions_for_masses_that_a_model_lacks(tmp_path):
    campaign = measured("kr500", poses=40, loads=())
    heavy, light = problem_of(campaign), problem_of(without_masses(campaign, tmp_path))
    torque = heavy.arm.own(wrenches(heavy.arm, heavy.rigid, replace(heavy.loads, compensator=None)).local)
    sites = OwnWeights.sites(light)
    assert [str(one.where.joint) for one in sites] == [f"joint_{j}" for j in range(2, 7)]
    for one in sites:
        (basis,) = one.motion(light).values()
        own = torque[:, heavy.joint(one.where.joint)]
        left = own - basis @ np.linalg.lstsq(basis, own, rcond=None)[0]
        assert np.abs(left).max() < 1e-9 * np.abs(torque).max()
    assert not OwnWeights.sites(heavy)


def test_a_model_without_masses_is_told(tmp_path):
    """An arm that bends under a weight that the model has not looks like a gear that errs."""
    campaign, _ = clean()
    light = without_masses(campaign, tmp_path)
    assert any("has no masses" in note for note in diagnose(light).diagnosis.notes)
    assert not any("has no masses" in note for note in diagnose(campaign).diagnosis.notes)


def test_loads_that_no_arm_carries_are_said():
    heavy = measured("kr500", poses=30, loads=(250.0,))
    with pytest.raises(InputError, match="comes to no rest; check masses"):
        prepare(replace(heavy, load_mass=np.array([0.0, 1e7])))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<mass value="', '<mass value="x', "mass: value = 'x4' is not a number"),
        ('<mass value="', '<mass value="-', "mass: -4 kg is no mass; state what the link weighs"),
        ('lower="-', 'lower="9', "the lower one comes first"),
        ('lower="-', 'lower="x', "is not a number; mend the URDF"),
    ],
)
def test_what_is_wrong_with_a_urdf_has_place_and_mend(tmp_path, old, new, said):
    ours = load_robot("ur5")
    (tmp_path / "ur5.urdf").write_text(ours.urdf.read_text().replace(old, new, 1))
    (tmp_path / "ur5.toml").write_text(ours.path.read_text())
    with pytest.raises(InputError) as caught:
        arrays(load_robot(tmp_path / "ur5.toml"))
    assert said in str(caught.value)
    assert "bazel" not in str(caught.value)


def test_files_that_never_end_or_act_in_a_terminal_are_refused(tmp_path, capsys):
    from pathlib import Path

    with pytest.raises(InputError, match="is a device"):
        read_text(Path("/dev/zero"))
    file = tmp_path / "a.toml"
    file.write_text('title = "\\u001b[31m"\nname = "' + "n" * 10_000 + '"\n')
    with pytest.raises(InputError) as caught:
        read_toml(file)
    assert len(caught.value.faults) == 2
    assert "\x1b" not in str(caught.value)
    campaign = write_campaign(tmp_path / "c", clean()[0])
    table = campaign.parent / "poses.csv"
    table.write_text(table.read_text().replace("\n8,", "\n\x1b[31m8,"))
    assert main(["diagnose", str(campaign)]) == 2
    assert "has the control character '\\x1b'" in capsys.readouterr().err


def test_an_effect_without_a_place_is_asked_for_one(capsys, tmp_path):
    """Nothing was said that cannot sit there."""
    assert main(["simulate", "ur5", "--random", "3", "--effect", "backlash", "--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert "backlash: does not say where it sits; possible: joint=shoulder_pan_joint" in told
