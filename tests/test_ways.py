"""What the closed loop runs between the rows of a path, and where it judges it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from workbench import Path, load_robot, verify
from workbench.correction.trajectory import nominal_joints
from workbench.robot.kinematics import frames
from workbench.robot.rigid_plant import arrays
from workbench.robot.rotations import angle_between, pose, rotation_about
from workbench.simulation.closed_loop.motion import motion
from workbench.simulation.closed_loop.ways import CLOSE, way_of

CENTRE = np.array([1.6, 0.2, 1.1])
ROBOT = load_robot("kr500")
DOWN = rotation_about("y", np.array([np.pi]))[0] @ rotation_about("z", np.array([0.4]))[0]


def path_over(p, speed=0.1):
    """A path of tool poses over places (N, 3), all with one orientation."""
    time = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]) / speed
    return Path(time, X=pose(p, np.tile(DOWN, (len(p), 1, 1))))


def square(each):
    """A square of 100 mm with `each` rows a side."""
    corners = CENTRE + 0.05 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
    share = np.linspace(0, 1, each, endpoint=False)[:, None]
    sides = [a + share * (b - a) for a, b in pairwise(corners)]
    return path_over(np.concatenate([*sides, corners[-1:]]))


def circle(count):
    angle = np.linspace(0, 2 * np.pi, count)
    return path_over(CENTRE + 0.05 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1))


def over(path):
    return way_of(ROBOT, path, path.X, nominal_joints(ROBOT, path), None)


def flange(q):
    return frames(arrays(ROBOT), q).p[-1]


@pytest.mark.parametrize("each", [1, 2, 7, 100])
def test_a_square_stays_one_however_many_rows_it_has(each):
    path = square(each)
    way = over(path)
    p = way.X[:, :3, 3] - CENTRE
    assert np.abs(np.abs(p[:, :2]).max(axis=1) - 0.05).max() < 1e-12
    if each == 1:
        assert np.linalg.norm(np.diff(p, axis=0), axis=1).max() <= CLOSE + 1e-12
    assert np.abs(p[way.corners, :2]) == pytest.approx(0.05)
    assert len(way.corners) == 3
    command = way.command(nominal_joints(ROBOT, path))
    assert np.linalg.norm(flange(command) - way.X[:, :3, 3], axis=1).max() < 1e-9
    moved = motion(way.along(path).time, command, corners=way.corners)
    off = np.abs(np.abs(flange(moved.q) - CENTRE)[:, :2].max(axis=1) - 0.05)
    assert off.max() < 1e-3  # the filter's rounding of a corner
    assert np.median(off) < 1e-6


def test_waves_shorter_than_the_rows_are_apart_are_seen_between_them():
    """Rows are where a gear is corrected: judged there alone it would err nowhere."""
    path = path_over(CENTRE + np.linspace([-0.05, 0, 0], [0.05, 0, 0], 5))
    q = nominal_joints(ROBOT, path)
    assert len(over(path).leg) == 5
    way = way_of(ROBOT, path, path.X, q, None, [(1, 200.0)])
    cycles = 200 * np.abs(np.diff(way.command(q)[:, 1])) / (2 * np.pi)
    assert cycles.max() <= 1.01 / 8
    assert len(way_of(ROBOT, path, path.X, q, None, [(1, 1.0)]).leg) == 5


def test_rows_on_a_circle_are_no_polygon():
    """Straight from row to row it would be 0.07 mm inside."""
    path = circle(61)
    way = over(path)
    assert not len(way.corners)
    moved = motion(way.along(path).time, way.command(nominal_joints(ROBOT, path)), corners=way.corners)
    radius = np.linalg.norm((flange(moved.q) - CENTRE)[:, :2], axis=1)
    assert radius == pytest.approx(0.05, abs=3e-5)


@pytest.mark.parametrize("turns_off", [False, True])
@pytest.mark.parametrize("rows", [2, 3])
def test_where_two_rows_are_one_place_the_tool_stands(turns_off, rows):
    """A curve through them went on by 18 mm in two seconds, and came back."""
    way = 0.01 * np.arange(11.0)[:, None]
    first = CENTRE + way * [1.0, 0, 0]
    then = first[-1] + way[1:] * ([0, 1.0, 0] if turns_off else [1.0, 0, 0])
    p = np.concatenate([first, np.repeat(first[-1:], rows - 1, axis=0), then])
    path = path_over(p)
    still = np.arange(len(p)) > 10
    rest = np.clip(np.arange(len(p)) - 10, 0, rows - 1) * 2.0 / (rows - 1)
    path = replace(path, time=path.time + np.where(still, rest, 0.0))
    way = over(path)
    moved = motion(way.along(path).time, way.command(nominal_joints(ROBOT, path)), corners=way.corners)
    gone = flange(moved.q)
    assert np.linalg.norm(np.diff(gone, axis=0), axis=1).sum() == pytest.approx(0.2, abs=1e-3)
    stands = np.linalg.norm(gone - first[-1], axis=1) < 1e-6
    assert moved.period * stands.sum() == pytest.approx(2.0, abs=0.06)  # less what the filter rounds
    time = way.along(path).time
    here = np.linalg.norm(way.X[:, :3, 3] - first[-1], axis=1) < 1e-9
    assert np.diff(time[here]).max() < 0.011  # so that what dies out there counts for as long as it has


def test_where_the_tool_turns_on_the_spot_it_stays_there():
    way = 0.01 * np.arange(11.0)[:, None] * [1.0, 0, 0]
    p = CENTRE + np.concatenate([way, np.repeat(way[-1:], 5, axis=0), way[-1] + way[1:]])
    angle = np.interp(np.arange(len(p)), [10, 15], [0.0, 0.2])
    X = pose(p, DOWN @ rotation_about("z", angle))
    path = Path(0.1 * np.arange(len(p)), X=X)
    way = over(path)
    moved = motion(way.along(path).time, way.command(nominal_joints(ROBOT, path)), corners=way.corners)
    assert np.linalg.norm(np.diff(flange(moved.q), axis=0), axis=1).sum() == pytest.approx(0.2, abs=1e-3)


def test_close_rows_of_a_smooth_path_are_its_samples():
    path = circle(400)
    way = over(path)
    assert len(way.leg) == 400
    assert way.along(path) is path
    q = nominal_joints(ROBOT, path)
    assert way.command(q) is q


def test_between_rows_a_command_is_as_far_off_as_at_them():
    path = square(1)
    q = nominal_joints(ROBOT, path) + 1e-4
    way = over(path)
    off = flange(way.command(q)) - way.X[:, :3, 3]
    here = flange(q) - path.X[:, :3, 3]
    expected = (1 - way.share)[:, None] * here[way.leg] + way.share[:, None] * here[way.leg + 1]
    assert np.abs(off - expected).max() < 1e-9
    assert np.linalg.norm(here, axis=1).min() > 1e-5


def test_loads_and_time_go_evenly_from_row_to_row():
    path = replace(square(1), wrench=np.arange(30.0).reshape(5, 6), temperature=np.arange(5.0))
    way = over(path)
    along = way.along(path)
    at = way.leg + way.share
    assert along.temperature == pytest.approx(at)
    assert along.wrench[:, 2] == pytest.approx(6 * at + 2)
    assert along.time == pytest.approx(np.interp(at, np.arange(5), path.time))


def test_where_no_straight_line_is_the_joints_run_evenly_and_it_is_told():
    """From one side of the robot to the other: the straight line goes through its column."""
    q = np.radians([[0, -60, 100, 0, 50, 0], [180, -60, 100, 0, 50, 0]])
    path = Path(np.array([0.0, 8.0]), q=q)
    arm = arrays(ROBOT)
    where = frames(arm, q)
    way = way_of(ROBOT, path, pose(where.p[-1], where.R[-1]), q, None)
    assert way.uneven == (0,)
    command = way.command(q)
    assert command[:, 0] == pytest.approx(np.pi * way.share)
    assert command[:, 1:] == pytest.approx(np.tile(q[0, 1:], (len(command), 1)))


def test_what_verify_says_of_a_square_does_not_hang_on_its_rows():
    """The largest error is just behind a corner, where the sparse path has no row."""
    few, many = (
        verify(square(each), ROBOT, ROBOT, speeds=None, repeats=0).slow.trials["corrected"].figures
        for each in (1, 60)
    )
    assert few.max_mm == pytest.approx(many.max_mm, rel=0.05)
    assert few.rms_mm == pytest.approx(many.rms_mm, rel=0.05)
    assert few.max_mm > 0.5


def test_the_turn_runs_with_the_way():
    path = square(1)
    turned = path.X.copy()
    turned[1:, :3, :3] = turned[1:, :3, :3] @ rotation_about("x", np.array([0.2]))
    way = over(replace(path, X=turned))
    first = way.leg == 0
    turn = angle_between(turned[0, :3, :3][None], way.X[first, :3, :3])
    assert turn == pytest.approx(0.2 * way.share[first], abs=1e-9)
