"""Designs that hold something: a tool that never turns, joints that stand still; and rows in motion."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from workbench import (
    Target,
    Truth,
    diagnose,
    load_robot,
    parse_effect,
    planned,
    predict,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
    write_fit,
)
from workbench.campaign.in_motion import in_motion
from workbench.diagnosis.all_over import with_bounds
from workbench.diagnosis.data_faults.moved_setup import step_in_time
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.telling.on_test_campaign import test_figures as figures_on
from workbench.diagnosis.telling.remarks_on_test import worse
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.noise import required_noise
from workbench.identification.registration import STATED_TARGET
from workbench.identification.set_up import fit_set_up
from workbench.report.terminal import short_verdict

SIGMA = 2e-5
STATED = ((0.15, 0.0, 0.06), (-0.1, 0.12, 0.08), (-0.08, -0.13, 0.05))


def grid():
    """(64, 6) joints of a KR 500 whose tool looks down with one heading, however the place."""
    turn, lean, bend = (one.ravel() for one in np.meshgrid(*[np.linspace(-1.0, 1.0, 4)] * 3))
    q2, q3 = -1.6 + 0.25 * lean, 1.7 + 0.25 * bend
    return np.column_stack([0.4 * turn, q2, q3, 0 * q2, np.pi / 2 - q2 - q3, 0.4 * turn])


@cache
def one_orientation():
    """Measured so: geometry is off by tenths of a millimetre, targets by a millimetre."""
    robot = load_robot("kr500")
    targets = [Target(f"T{k}", place) for k, place in enumerate(STATED)]
    plan = planned(robot, grid(), targets=targets, tool=(250.0, (0.1, 0.0, 0.3)))
    geometry = random_geometry(problem_of(plan).arm, np.random.default_rng(1))
    seen = simulate(plan, Truth(geometry=geometry, sigma=SIGMA), seed=1)
    rng = np.random.default_rng(2)
    stated = [replace(one, xyz=tuple(one.xyz + rng.normal(size=3) * 1e-3)) for one in seen.targets]
    return problem_of(replace(seen, targets=tuple(stated), noise_sigma=SIGMA))


def test_the_grid_never_turns_its_tool():
    R = one_orientation().rigid.R[-1]
    assert np.abs(R - R[0]).max() < 1e-9


def test_what_the_nominal_robot_errs_by_does_not_carry_its_targets_away():
    problem = one_orientation()
    start, noise = start_state(problem), required_noise(problem)
    off = [
        np.linalg.norm(found.state.targets[0] - problem.stated_targets, axis=1).max()
        for found in (
            fit(Model(problem), start, noise, geometry=False),
            fit_set_up(Model(problem), start, noise),
        )
    ]
    assert off[0] > 0.05  # by the instrument's noise alone
    assert off[1] < STATED_TARGET


@pytest.mark.parametrize("count", [1, 3])
def test_an_arm_that_sags_does_not_carry_its_targets_away(count):
    """It turns the tool a little, alike from pose to pose as what a nominal robot errs by."""
    targets = [Target(f"T{k}", place) for k, place in enumerate(STATED[:count])]
    plan = planned(load_robot("kr500"), grid(), targets=targets, tool=(250.0, (0.1, 0.0, 0.3)))
    job = problem_of(plan)
    soft = parse_effect("joint_compliance:joint=joint_2,relative=0.3", job)
    geometry = random_geometry(job.arm, np.random.default_rng(1))
    seen = simulate(plan, Truth(geometry=geometry, effects=(soft,), sigma=SIGMA), seed=1)
    prepared = prepare(replace(seen, noise_sigma=SIGMA))
    for found, most in ((prepared.nominal, 1e-3), (prepared.geometry, 5e-3)):  # it was 14 mm and 37 mm
        off = np.linalg.norm(found.state.targets[0] - prepared.problem.stated_targets, axis=1)
        assert off.max() < most


@pytest.mark.parametrize("held", [np.pi / 2, 0.123456789])
def test_a_joint_that_was_held_still_is_inside_where_it_was_held(held, tmp_path):
    robot = load_robot("cylindrical")
    rng = np.random.default_rng(3)
    q = np.column_stack([np.full(40, held), rng.uniform(0.05, 0.5, (40, 2))])
    seen = simulate(planned(robot, q), Truth(sigma=SIGMA), seed=1)
    problem = problem_of(replace(seen, noise_sigma=SIGMA))
    write_fit(tmp_path / "model.toml", fit(Model(problem), noise=required_noise(problem)))
    errors = predict(
        load_robot(tmp_path / "model.toml"), np.array([[held, 0.3, 0.3], [held + 0.01, 0.3, 0.3]])
    )
    assert errors.outside == ("", "joint_1")


def swept(lower, upper, seed):
    """Diagnosed and measured alike: a UR5 whose joint 1 turns too far by a curve, from `lower` to `upper`."""
    robot, rng = load_robot("ur5"), np.random.default_rng(seed)
    q = random_poses(robot, 40, rng)
    q[:, 0] = rng.uniform(lower, upper, len(q))
    plan = planned(robot, q)
    bell = parse_effect(
        "gear_eccentricity:joint=shoulder_pan_joint,variant=1,amplitude=2e-3", problem_of(plan)
    )
    where = np.eye(3)[None], np.zeros((1, 3))
    seen = simulate(plan, Truth(effects=(bell,), sigma=SIGMA), seed=seed, instrument=where)
    return replace(seen, noise_sigma=SIGMA)


@cache
def narrow():
    """Measured where joint 1 is about where the curve is flat, without a cause in the model."""
    return prepare([swept(1.3, 1.7, 1)])


def figures(test):
    return figures_on(narrow().nominal, narrow().geometry, test)


def test_what_errs_beyond_what_was_measured_is_no_data_fault():
    few = swept(1.3, 1.7, 2)
    q, points = few.poses.q.copy(), few.points.copy()
    far = swept(-1.7, -1.3, 3)
    q[:4], points[:4] = far.poses.q[:4], far.points[:4]
    found = figures(replace(few.with_poses(q=q), points=points))
    assert found.faults == ()
    assert found.after_max_mm > 1.0
    points[0, 0] += 0.003  # one target of such a pose, and one pose within
    points[9] += 0.003
    found = figures(replace(few.with_poses(q=q), points=points))
    assert [(one.kind, one.pose_id) for one in found.faults] == [("outlier", "10")] * points.shape[1]


def test_what_errs_like_a_moved_base_beyond_what_was_measured_may_be_the_model():
    assert figures(swept(1.3, 1.7, 2)).notes == ()
    (said,) = figures(swept(-1.7, -1.3, 3)).notes
    assert "stands" in said
    assert said.endswith("beyond what was measured: it may be the model that errs there.")


def test_a_model_that_is_farther_off_than_the_robot_was_is_told():
    rng, beyond = np.random.default_rng(4), np.arange(40) >= 20
    was = 1e-3 * rng.uniform(0.5, 1.5, (40, 3))
    was[3, 1] = np.nan
    assert worse(was, was, beyond) == []
    assert worse(was, was + 2e-5 * rng.normal(size=was.shape), beyond) == []
    (every,) = worse(was, 1.5 * was, beyond)
    assert "poses, of which 20 lie beyond the joints' measured ranges, the model is farther off" in every
    (some,) = worse(was, np.where(beyond[:, None], 1.5, 0.1) * was, beyond)
    assert some.startswith("At 20 of the test campaign's 40 poses, which lie beyond")


def test_bounds_where_it_was_measured_and_all_over():
    found = with_bounds(diagnose(one_orientation().campaign)).diagnosis
    near, far = found.bounds_mm
    assert near < 0.1
    assert far > 1.0
    assert found.to_json()["bounds_mm"] == {"measured": near, "all_over": far}
    assert f"where measured {near:.3f}" in short_verdict(found, None)
    lost = short_verdict(replace(found, bounds_mm=(near, 1419.2)), None)
    assert f"where measured {near:.3f}   all over the joints' range not known\n" in lost
    assert "joints' range not known" not in short_verdict(found, None)


def to_and_fro(apart):
    """A UR5's joints go to and fro, seen every `apart` s by an instrument that is 0.1 mm elsewhere from row
    200 on."""
    robot, phase = load_robot("ur5"), np.linspace(0, 6 * np.pi, 400)
    q = np.array([0.3, -1.2, 1.4, 0.2, 0.9, 0.1]) + 0.6 * np.sin(
        np.outer(phase, [1, 0.7, 0.9, 1.1, 0.8, 1.3])
    )
    seen = simulate(planned(robot, q), Truth(sigma=SIGMA), seed=5).with_poses(time=apart * np.arange(400.0))
    seen.points[200:] += 1e-4
    problem = problem_of(replace(seen, noise_sigma=SIGMA))
    return fit(Model(problem), noise=required_noise(problem))


def test_rows_in_motion_are_told_from_standstills():
    q = np.cumsum(np.full((9, 6), 0.01), axis=0)
    assert in_motion(q, 0.02 * np.arange(9)) == pytest.approx(0.02)
    assert in_motion(q, 20.0 * np.arange(9)) == 0.0
    assert in_motion(q, None) == 0.0
    assert in_motion(np.repeat(q[:2], 9, axis=0), np.r_[0.02 * np.arange(9), 30 + 0.02 * np.arange(9)]) == 0.0
    assert in_motion(q, np.full(9, np.nan)) == 0.0


def test_a_step_among_rows_in_motion_may_be_noise_that_is_alike_in_neighbours():
    found = step_in_time(to_and_fro(20.0))
    assert found is not None
    assert (found.kind, found.first) == ("moved_instrument", 200)
    assert step_in_time(to_and_fro(0.02)) is None
