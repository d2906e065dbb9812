"""What a robot does by another course than any cause has: told as what it is like, by no wrong name."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from diagnosis_cases import found, measured, named

from workbench.campaign.problem import problem_of
from workbench.effects.base import UNKNOWN
from workbench.effects.unnamed.foot import Foot
from workbench.effects.unnamed.past import FORGETS, Past
from workbench.report.content import content
from workbench.robot.kinematics import RX, TZ

POSES = 90
TIME = 45.0 * np.arange(POSES)


def unknown_of(diagnosis):
    """What is told without a name, where nothing is named; the headline says what that is like."""
    (one,) = diagnosis.causes
    assert one.cause == UNKNOWN
    assert diagnosis.headline.startswith(f"Something is left that looks like {one.like}. ")
    return one.structure


@pytest.mark.parametrize("way", [pytest.param(0.3, marks=pytest.mark.slow), 2.0])
def test_a_base_that_tips_to_one_side_is_no_foundation(way):
    """It lifts a foot where it is pulled to that side by more than a tenth of the largest moment."""

    def motion(problem):
        x, y = problem.nominal_load.local[:, 0, RX : RX + 2].T
        about = np.cos(way) * x + np.sin(way) * y
        tilt = 1.2e-4 * np.maximum(about / np.abs(about).max() - 0.1, 0.0)
        return {RX: np.cos(way) * tilt, RX + 1: np.sin(way) * tilt, TZ: 0.25 * tilt}

    structure = unknown_of(found(measured("ur10", loads=(), poses=POSES, motion=motion)))
    assert structure.startswith("depends on overturning moment (the base tips about the axis at ")


def test_a_base_that_yields_alike_to_all_sides_is_a_foundation():
    diagnosis = found(measured("kr500", ("foundation:compliance=8e-9",), poses=POSES))
    assert named(diagnosis) == {("foundation", ""): "named"}


def test_a_foot_tips_about_its_own_axis_by_the_moment_about_it():
    problem = problem_of(measured("ur10", loads=(), poses=20))
    every = Foot.sites(problem)
    assert [one.variant for one in every] == [f"foot {angle:g}" for angle in np.arange(16) * 22.5]
    one = every[11]
    motion = one.motion(problem)
    assert np.sin(one.axis) * motion[RX] == pytest.approx(np.cos(one.axis) * motion[RX + 1])
    x, y = problem.nominal_load.local[:, 0, RX : RX + 2].T
    about = (np.cos(one.axis) * x + np.sin(one.axis) * y) / one.largest
    for column, lifts in enumerate((-0.3, 0.0, 0.3)):
        assert motion[RX][:, column] == pytest.approx(np.cos(one.axis) * np.maximum(about - lifts, 0.0))


def comes_back(time):
    """Warms up, and cools down again from the middle on."""
    share = time / time[-1]
    there = 1 - np.exp(-np.minimum(share, 0.5) / 0.15)
    return there * np.exp(-np.maximum(share - 0.5, 0.0) / 0.1)


@pytest.mark.parametrize(
    ("column", "says"),
    [(0, "base (or the instrument)"), pytest.param(-6, "tool", marks=pytest.mark.slow)],
)
def test_what_goes_there_and_back_in_time_drifts(column, says):
    gone = 1.5e-4 * comes_back(TIME)
    moved = measured(
        "ur10", loads=(), poses=POSES, time=TIME, motion=lambda p: {column % (6 * p.arm.slots): gone}
    )
    diagnosis = found(moved)
    assert named(diagnosis) == {("drift", ""): "named"}
    (drift,) = diagnosis.causes
    assert drift.sentence.startswith(f"The {says} moves in the course of the campaign")
    (size,) = drift.parameters
    assert size.value == pytest.approx(1.5e-4 * comes_back(TIME).std(), rel=0.3)


@pytest.mark.parametrize(("column", "kind"), [(0, "moved_instrument"), (-6, "changed_setup")])
@pytest.mark.parametrize(
    "time", [pytest.param(TIME, marks=pytest.mark.slow), None], ids=["timed", "in order"]
)
def test_what_moves_at_once_is_no_drift(column, kind, time):
    """By less than what stands out beside any smooth course."""
    gone = 7e-5 * (np.arange(POSES) >= 52)
    moved = measured(
        "ur10", loads=(), poses=POSES, time=time, motion=lambda p: {column % (6 * p.arm.slots): gone}
    )
    diagnosis = found(moved)
    assert [(fault.kind, fault.pose_id) for fault in diagnosis.faults] == [(kind, "53")]
    assert not diagnosis.causes


def test_what_moves_at_once_in_one_of_several_set_ups_is_told():
    """Another part of that set-up begins there; the other set-up stays as it is."""
    gone = 9e-5 * (np.arange(POSES) >= 66)
    moved = measured("ur10", loads=(), poses=POSES, time=TIME, motion=lambda p: {6 * p.arm.slots - 6: gone})
    stations = replace(moved.with_poses(setup=np.repeat([0, 1], [40, 50])), setup_names=("door", "window"))
    diagnosis = found(stations)
    assert [(fault.kind, fault.pose_id) for fault in diagnosis.faults] == [("changed_setup", "67")]
    assert not diagnosis.causes


@pytest.mark.parametrize(
    ("column", "says"),
    [pytest.param(0, "base (or an instrument)", marks=pytest.mark.slow), (-6, "tool")],
)
def test_what_warms_up_while_nobody_looks_at_the_clock_is_no_step(column, says):
    """Most of it is over after some poses of the first ones."""
    gone = 2.5e-4 * (1 - np.exp(-np.arange(POSES) / 6.0))
    moved = measured("ur10", loads=(), poses=POSES, motion=lambda p: {column % (6 * p.arm.slots): gone})
    diagnosis = found(moved)
    assert not {fault.kind for fault in diagnosis.faults} & {"moved_instrument", "changed_setup"}
    assert unknown_of(diagnosis).startswith("depends on the order of measurement")
    (unknown,) = diagnosis.causes
    assert unknown.like == f"a {says} that moves in the course of the campaign"
    assert unknown.separate_by == "record when each pose was measured (t_s)"


def test_a_zero_that_goes_there_and_back_is_of_its_joint():
    def joints(problem):
        return np.outer(2e-4 * comes_back(TIME), np.arange(6) == 2)

    structure = unknown_of(found(measured("ur10", loads=(), poses=POSES, time=TIME, joints=joints)))
    assert structure.startswith("depends on time (the zero of elbow_joint moves)")


def rubbed(q, width):
    """(N,) -1 to 1: how a joint that rubs is wound up after each of its moves, by hand."""
    state, out = 0.0, [0.0]
    for before, now in pairwise(q):
        side = np.sign(now - before)
        state = side + (state - side) * np.exp(-abs(now - before) / width)
        out.append(state)
    return np.array(out)


def test_a_joint_that_remembers_where_it_came_from_is_told():
    """Its sides of approach were not recorded; their order was."""

    def joints(problem):
        return np.outer(-8e-5 * rubbed(problem.q[:, 1], 0.35), np.arange(6) == 1)

    diagnosis = found(measured("ur10", loads=(), poses=POSES, joints=joints))
    assert unknown_of(diagnosis).startswith(
        "depends on where shoulder_lift_joint came from, in the order of measurement"
    )
    assert "wait longer" in content(diagnosis)["next"]


def test_the_past_of_a_joint_is_its_moves_in_the_order_of_time():
    campaign = measured("ur10", loads=(), poses=20)
    q = campaign.poses.q[:, 2]
    late = campaign.some(np.arange(20)[::-1]).with_poses(time=60.0 * np.arange(20)[::-1])
    for some, way in ((campaign, 1), (late, -1)):
        problem = problem_of(some)
        (one,) = (e for e in Past.sites(problem) if e.where.joint == "elbow_joint")
        joint, amount = one.of_joint(problem)
        assert joint == 2
        for column, width in enumerate(FORGETS):
            assert amount[::way, column] == pytest.approx(rubbed(q, width))
        assert amount[::way, -1] == pytest.approx(np.diff(q, prepend=q[0]) / np.pi)
