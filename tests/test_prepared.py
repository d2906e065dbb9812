"""One preparation: a plan sees the data faults that a diagnosis sees, and starts from the same fit."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_cases import measured, with_points
from held_hand import held

from workbench import Truth, load_robot, parse_effect, planned, random_poses, simulate
from workbench.campaign import load_campaign, write_campaign
from workbench.campaign.data import Target
from workbench.campaign.parted import parted
from workbench.campaign.problem import problem_of
from workbench.cli.main import main
from workbench.diagnosis import prepared
from workbench.diagnosis.data_faults.moved_setup import jump, moved_by
from workbench.diagnosis.data_faults.wild_points import _frozen
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.weighing.places_of_steps import likely_steps, places
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.unnamed.at_once import stands_anew
from workbench.files.faults import InputError
from workbench.identification.fit import refit
from workbench.identification.heldout import heldout
from workbench.measurement.design import plan
from workbench.measurement.design.prior_information import from_campaign
from workbench.simulation.virtual_campaign import random_geometry

MOVED = "moved_instrument"
LATE = 75  # poses before the instrument was moved


def untouched(points):
    pass


def moved(points):
    points[LATE:] += [8e-4, -6e-4, 0.0]


def slightly(points):
    points[30:] += [2.6e-4, 0.0, 0.0]


def late(points):
    points[47:] += [1e-4, -4e-5, 0.0]


def late_and_back(points):
    late(points)
    points[64:] -= [1e-4, 2e-5, 3e-5]


def wild(points):
    points[7, 1] += [0.2, 0, 0.1]


def swapped_and_moved(points):
    points[11, [0, 2]] = points[11, [2, 0]]
    moved(points)


def spoilt(change, **options):
    campaign = measured(**options)
    points = campaign.points.copy()
    change(points)
    return with_points(campaign, points)


def test_a_step_that_causes_hide_is_found_beside_them():
    """What soft joints leave of geometry alone is far more than the step makes."""
    campaign = spoilt(late, poses=40, effects=("joint_compliance:joint=joint_3,relative=0.8",))
    assert not prepared.prepare(campaign).faults
    found = diagnose(campaign).diagnosis
    assert [(fault.kind, fault.pose_id) for fault in found.faults] == [("moved_instrument", "48")]
    assert [cause.label for cause in found.causes] == ["joint_compliance(joint_3)"]


def test_steps_that_causes_hide_are_found_at_once():
    """As where an arm is measured in several sittings that nobody wrote down."""
    campaign = spoilt(late_and_back, poses=40, effects=("joint_compliance:joint=joint_3,relative=0.8",))
    at = refit(prepared.prepare(campaign).geometry, JointCompliance.sites(problem_of(campaign)))
    base, *_ = likely_steps(at)
    steps = sorted((stands_anew(step) for step, _ in base), key=lambda step: step.first)
    assert [step.first for step in steps] == [47, 64]  # and no third
    both = refit(at, [*at.model.effects, *steps])
    one = refit(both, [*at.model.effects, steps[1]])  # as where the first brings nothing on poses held out
    assert moved_by(one, steps[0]) == pytest.approx(moved_by(both, steps[0]), rel=0.01)
    found = diagnose(campaign).diagnosis
    assert [(one.kind, one.pose_id) for one in found.faults] == [(MOVED, "48"), (MOVED, "65")]
    sizes = [float(re.findall(r"steps by (\S+) mm", one.what)[0]) for one in found.faults]
    assert sizes == pytest.approx([0.108, 0.106], rel=0.2)  # not what they make of all poses


def test_a_plan_takes_a_moved_instrument_for_two_set_ups(tmp_path, capsys):
    campaign = spoilt(moved)
    known = from_campaign(campaign)
    assert known.fit.chi2 / known.fit.point_rows < 1.2
    assert known.problem.campaign.poses.setup.tolist() == [0] * LATE + [1] * (len(campaign.poses.q) - LATE)
    (fault,) = plan(campaign, 8, quick=True).to_json()["faults"]
    assert (fault["kind"], fault["pose_id"]) == ("moved_instrument", str(LATE + 1))
    (size,) = re.findall(r"steps by (\S+) mm", fault["what"])
    assert float(size) == pytest.approx(1.0, abs=0.03)
    source, out = str(write_campaign(tmp_path, campaign)), str(tmp_path / "new.csv")
    call = ["plan", source, "--poses", "8", "--quick", "--out", out]
    assert main(call) == 0
    assert f"Data fault: moved_instrument at pose {LATE + 1}" in capsys.readouterr().out
    assert main([*call, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["faults"] == [fault]


def test_returns_to_few_places_place_no_frame_anew():
    """A step needs poses enough before and after it that differ, however often each was measured."""
    assert places(np.repeat(np.arange(7), 10)) == []
    assert places(np.repeat(np.arange(12), 10)) == list(range(41, 80))
    assert places(np.arange(20)) == list(range(5, 16))


@pytest.mark.parametrize(("poses", "targets"), [(110, 1), (60, 2)])
def test_an_instrument_that_moved_is_found_with_few_targets(poses, targets):
    """The step itself is most of what scatters there: it must stand out of what it leaves."""
    campaign = spoilt(slightly, poses=poses, targets=targets, loads=())
    assert [(f.kind, f.pose_id) for f in prepared.prepare(campaign).faults] == [("moved_instrument", "31")]


@pytest.mark.parametrize("first", [14, 17, 50])
def test_an_instrument_that_moved_early_or_late_is_not_many_wild_points(first):
    """All points before it, or after, are few enough to be taken for wild."""

    def few(points):
        points[:first] += [2.5e-4, -2e-4, 1e-4]

    found = prepared.prepare(spoilt(few, poses=64, targets=2, loads=()))
    assert ("moved_instrument", str(first + 1)) in [(f.kind, f.pose_id) for f in found.faults]
    assert len(found.faults) <= 2  # of the few poses of a set-up one may look wild
    assert found.geometry.chi2 / found.geometry.point_rows < 1.2


def azimuth(problem):
    """(N, n) [rad]: an encoder of joint_1 as no form has it, by far the largest error."""
    q = problem.q
    return 1e-3 * np.sin(4 * q[:, :1] + 0.6) ** 3 * (np.arange(q.shape[1]) == 0)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_error_of_a_joint_by_which_poses_are_ordered_is_no_step(seed):
    campaign = measured(poses=80, targets=2, loads=(), joints=azimuth, seed=seed)
    ordered = campaign.some(np.argsort(campaign.poses.q[:, 0]))
    assert not [f for f in prepared.prepare(ordered).faults if f.kind != "outlier"]


def by_a_ur5(q, length, off, sigma, rng, seed):
    """Joints q of a UR5 that is off by `off` [m, rad], one target of unknown place on a tool's length [m]."""
    plan = planned(load_robot("ur5"), q, targets=(Target("C"),))
    geometry = random_geometry(problem_of(plan).arm, rng, off, off)
    truth = Truth(geometry=geometry, targets=np.array([[0.0, 0.02, length]]), sigma=sigma)
    return simulate(plan, truth, seed=seed, state_sigma=False)


def other_way_up(seed):
    """A hand held upright for 45 poses, then 15 with the tool the other way up: before, a place of the target
    along its axis is one of the frame."""
    rng = np.random.default_rng(seed)
    shift = rng.uniform(-0.25, 0.25, (60, 3))
    turn = np.zeros((60, 3))
    turn[:, 2] = rng.uniform(-1.0, 1.0, 60)
    q = held(shift, turn)
    q[45:] = random_poses(load_robot("ur5"), 15, rng)
    return by_a_ur5(q, 0.3, 2e-3, 2e-4, rng, seed)


@pytest.mark.parametrize("seed", [*(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2)), 3])
def test_a_tool_the_other_way_up_is_no_jump(seed):
    """What the first poses do not determine, they do not predict."""
    assert jump(problem_of(other_way_up(seed))) is None


@pytest.mark.parametrize(
    ("change", "options"),
    [
        (untouched, {"torque_sigma": 20.0}),
        (wild, {}),
        (moved, {"state_sigma": False, "targets": 1}),
        (swapped_and_moved, {}),
    ],
    ids=["torque", "wild", "moved without noise", "swapped and moved"],
)
def test_plan_and_diagnosis_start_from_the_same(change, options):
    campaign = spoilt(change, **options)
    outcome, known = diagnose(campaign), from_campaign(campaign)
    assert outcome.diagnosis.verdict == "nothing_missing"  # so its last fit is that of the geometry
    ours, theirs = known.fit, outcome.fit
    assert np.array_equal(ours.model.problem.campaign.poses.setup, theirs.model.problem.campaign.poses.setup)
    np.testing.assert_array_equal(ours.model.problem.campaign.points, theirs.model.problem.campaign.points)
    assert np.array_equal(ours.state.geometry, theirs.state.geometry)
    assert np.array_equal(ours.noise.sigma, theirs.noise.sigma)
    assert np.array_equal(ours.noise.joint, theirs.noise.joint)
    assert np.array_equal(ours.whitener, theirs.whitener)
    assert known.faults == outcome.diagnosis.faults


def test_a_campaign_of_many_poses_is_fitted_on_a_part_and_tried_on_another(monkeypatch):
    robot = load_robot("cylindrical")
    q = np.tile(random_poses(robot, 60, np.random.default_rng(3)), (2, 1))
    plan = planned(robot, q)
    wheel = parse_effect("gear_eccentricity:joint=joint_1,variant=1,amplitude=5e-4", problem_of(plan))
    campaign = simulate(plan, Truth(effects=(wheel,), sigma=2e-5), seed=4)
    monkeypatch.setattr(prepared, "MOST_POSES", 50)
    found = diagnose(campaign).diagnosis
    assert [finding.label for finding in found.causes] == ["gear_eccentricity(joint_1)"]
    assert found.n_poses == 50
    assert found.test is not None
    assert found.test.n_points == 50 * len(campaign.targets)
    assert found.test.after_rms_mm < 1.5 * 1e3 * 2e-5 * np.sqrt(3)
    assert any("fitted on 50 poses" in note for note in found.notes)


def test_repeats_stay_in_one_part_unless_they_are_most_of_it():
    robot = load_robot("cylindrical")
    q = random_poses(robot, 30, np.random.default_rng(3))
    own, rest = parted(planned(robot, np.concatenate([q, q])), 40)
    assert rest is not None
    assert (len(own.poses), len(rest.poses)) == (40, 20)
    assert not {tuple(row) for row in own.poses.q} & {tuple(row) for row in rest.poses.q}
    one_place = planned(robot, np.repeat(q[:1], 60, axis=0))
    assert [len(part.poses) for part in parted(one_place, 40) if part] == [40, 20]
    assert parted(one_place, 60) == (one_place, None)


@pytest.mark.parametrize("repeats", [1, 10])
def test_a_pose_less_leaves_the_others_in_their_parts(repeats: int) -> None:
    """Repeats of a position stay together, or are drawn each for itself where they are many."""
    robot = load_robot("cylindrical")
    q = np.repeat(random_poses(robot, 400 // repeats, np.random.default_rng(3)), repeats, axis=0)
    campaign = planned(robot, q)
    fewer = campaign.some(np.delete(np.arange(400), 17))
    for one, other in zip(parted(campaign, 80), parted(fewer, 80), strict=True):
        assert one is not None
        assert other is not None
        assert len(set(one.poses.ids) ^ set(other.poses.ids)) <= repeats + 2


def test_what_is_off_together_in_one_angle_is_no_outlier():
    """A flat bump in one joint takes every point there off by twenty times the noise; one point is wild."""
    campaign = measured(poses=120)
    joint = campaign.robot.joint_names.index("joint_1")
    q = campaign.poses.q[:, joint]
    there = np.abs(q - np.quantile(q, 0.8)) < 0.1 * np.ptp(q)
    points = campaign.points.copy()
    points[there] += [4e-4, -4e-4, 3e-4]
    alone = int(np.flatnonzero(there)[3])
    points[alone, 1] += [0.02, 0.0, 0.01]
    faults = prepared.prepare(with_points(campaign, points)).faults
    assert there.sum() > 15
    assert [(fault.kind, fault.pose_id, fault.target) for fault in faults] == [
        ("outlier", campaign.poses.ids[alone], "T2")
    ]


def test_exact_data_with_exact_repeats_are_diagnosed():
    campaign = measured("cylindrical", poses=40, loads=(), state_sigma=False)
    model = diagnose(campaign).fit
    exact = model.model.predict(model.state)
    later = np.arange(2.0 * len(exact))  # at another time: no copies
    twice = campaign.some(np.tile(np.arange(len(exact)), 2)).with_poses(
        ids=tuple(f"P{i}" for i in range(len(later))), time=later
    )
    found = diagnose(with_points(twice, np.concatenate([exact, exact]))).diagnosis
    assert found.verdict == "nothing_missing"
    assert found.noise.source == "repeats"


def renamed(campaign, pose, target):
    """One point under a name that nobody declared."""
    points = np.pad(campaign.points, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan)
    shots = np.pad(campaign.shots, ((0, 0), (0, 1)))
    points[pose, -1], points[pose, target] = points[pose, target], np.nan
    shots[pose, -1], shots[pose, target] = shots[pose, target], 0
    return replace(campaign, points=points, shots=shots, targets=(*campaign.targets, Target("abc")))


def test_a_target_or_a_set_up_that_was_mistyped_is_left_out_and_told():
    campaign = measured()
    usual = prepared.prepare(campaign)
    before = rms(heldout(usual.geometry))
    mistyped = prepared.prepare(renamed(campaign, 7, 1))
    (fault,) = mistyped.faults
    assert (fault.kind, fault.pose_id, fault.target) == ("rare_target", "8", "abc")
    assert "1 position of the joints" in fault.what
    assert [target.name for target in mistyped.problem.campaign.targets] == ["T1", "T2", "T3"]
    assert rms(heldout(mistyped.geometry)) == pytest.approx(before, rel=0.02)
    setup = np.zeros(len(campaign.poses), np.int64)
    setup[7] = 1
    other = prepared.prepare(replace(campaign.with_poses(setup=setup), setup_names=("", "mornng")))
    (fault,) = other.faults
    assert (fault.kind, fault.pose_id) == ("rare_setup", "8")
    assert "'mornng'" in fault.what
    assert other.problem.campaign.setup_names == ("",)
    assert rms(heldout(other.geometry)) == pytest.approx(before, rel=0.02)


def test_a_target_of_three_poses_or_of_known_place_stays():
    campaign = measured()
    points = campaign.points.copy()
    points[3:, 2] = np.nan
    some = replace(
        campaign, points=points, shots=np.where(np.isfinite(points).all(axis=2), campaign.shots, 0)
    )
    assert prepared.prepare(some).problem.seen[:, 2].sum() == 3
    points[1:, 2] = np.nan
    once = replace(some, points=points)
    assert len(prepared.prepare(once).problem.campaign.targets) == 2
    known = replace(once, targets=(*once.targets[:2], replace(once.targets[2], fixed=True)))
    assert len(prepared.prepare(known).problem.campaign.targets) == 3


def rms(residual):
    return float(np.sqrt(np.nanmean(np.sum(residual**2, axis=2))))


def nulled(points):
    points[7] = 0.0


def frozen(points):
    points[7] = points[6]


def gross(points):
    points[7] += [[0.0, 0.0, 0.2], [0.0, 0.0, 0.3], [0.0, 0.0, 0.2]]


def slight(points):
    points[7, 0] += [0.001, 0.0, 0.0]


@pytest.mark.parametrize("change", [nulled, frozen, gross, slight])
def test_a_wild_measurement_in_six_dimensions_is_one(change):
    """Its targets are computed from one pose: none of them is right where another is wrong."""
    exact = measured("ur5", poses=40, loads=(), sigma=0.0, state_sigma=False)
    points = exact.points + np.random.default_rng(3).normal(0, 3e-5, (40, 1, 3))
    change(points)
    ready = prepared.prepare(replace(with_points(exact, points), six_dof=True))
    assert [(fault.pose_id, fault.target) for fault in ready.faults] == [("8", None)]
    assert ready.problem.seen.all()
    assert "8" not in ready.problem.campaign.poses.ids


def test_part_of_the_data_may_have_no_pose_of_a_campaign():
    each = [replace(measured(poses=24, seed=seed), path=Path(f"{seed}.toml")) for seed in (1, 2)]
    both = prepared.prepare(each)
    part = both.some(np.flatnonzero(both.problem.campaign.poses.setup == 0))
    assert np.isfinite(part.geometry.state.t).all()
    assert part.geometry.chi2 < 1.5 * part.geometry.point_rows


def test_a_ball_in_a_socket_is_no_frozen_reading():
    """Its target has the same place in pose after pose, as it is held there; one that stays once is not."""
    campaign = measured("ur5", poses=40, loads=(), targets=1)
    stays = campaign.points.copy()
    stays[1:, 0] = np.repeat(stays[::10, 0], 10, axis=0)[1:]
    held_there = _frozen(problem_of(with_points(campaign, stays)))
    assert held_there.faults == ()
    once = campaign.points.copy()
    once[5] = once[4]
    assert [fault.pose_id for fault in _frozen(problem_of(with_points(campaign, once))).faults] == ["6"]


def test_of_several_campaigns_the_one_that_is_wrong_is_named(tmp_path):
    """A sign turned in the second: what the first would have to be to agree with it is not told."""
    paths = []
    for name, sign in (("sound", 1.0), ("turned", -1.0)):
        campaign = measured("ur5", poses=30, loads=(), seed=len(name))
        turned = campaign.poses.q * [1.0, 1.0, 1.0, sign, 1.0, 1.0]
        paths.append(write_campaign(tmp_path / name, campaign.with_poses(q=turned)))
    with pytest.raises(InputError, match="wrist_1_joint turns the other way") as caught:
        prepared.prepare([load_campaign(path) for path in paths])
    assert [fault.place for fault in caught.value.faults] == [f"{paths[1]}: poses"]


def test_campaigns_of_other_robots_are_refused_as_that_whatever_else_is_wrong():
    one, other = (measured(name, poses=30, loads=()) for name in ("ur5", "ur10"))
    turned = other.poses.q * [1.0, 1.0, 1.0, -1.0, 1.0, 1.0]
    other = replace(other, path=other.path.parent / "other" / other.path.name).with_poses(q=turned)
    with pytest.raises(InputError, match="robot 'ur10', but 'ur5'") as caught:
        prepared.prepare([one, other])
    assert "turns the other way" not in str(caught.value)


def test_a_campaign_of_one_pose_is_not_what_is_wrong_with_another(tmp_path):
    sound = measured("ur5", poses=30, loads=())
    turned = sound.with_poses(q=sound.poses.q * [1.0, 1.0, 1.0, -1.0, 1.0, 1.0])
    paths = [
        write_campaign(tmp_path / name, one)
        for name, one in (("turned", turned), ("single", sound.some(np.array([0]))))
    ]
    with pytest.raises(InputError, match="wrist_1_joint turns the other way") as caught:
        prepared.prepare([load_campaign(path) for path in paths])
    assert [fault.place for fault in caught.value.faults] == [f"{paths[0]}: poses"]
