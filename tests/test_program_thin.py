"""Paths in the fewest lines and circles: within the tolerance, with their times and stops."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.correction.programs import Program, find_format
from workbench.correction.programs.arcs import circles
from workbench.correction.programs.base import legs_of
from workbench.correction.programs.thin import thinned
from workbench.robot import rotations

TOLERANCE = 1e-5


def at(p: np.ndarray, turn: np.ndarray | None = None) -> np.ndarray:
    turn = np.zeros_like(p) if turn is None else turn
    return rotations.pose(p, Rotation.from_rotvec(turn).as_matrix())


def circle(count: int = 766, radius: float = 0.003) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, count)
    return np.stack([1 + radius * np.cos(angle), radius * np.sin(angle), np.full(count, 0.5)], axis=1)


def from_legs(program: Program, points: np.ndarray) -> float:
    """Largest distance of points from the legs of a program, each sampled finely."""
    assert program.X is not None
    p, drawn = program.X[:, :3, 3], []
    for i in range(1, program.count):
        share = np.linspace(0, 1, 2001)[:, None]
        if program.circular[i]:
            assert program.via is not None
            centre, _, sweep, axis = circles(p[[i - 1]], program.via[[i], :3, 3], p[[i]])
            turn = Rotation.from_rotvec(share * sweep * axis[0]).as_matrix()
            drawn.append(centre + turn @ (p[i - 1] - centre[0]))
        else:
            drawn.append(p[i - 1] + share * (p[i] - p[i - 1]))
    line = np.concatenate(drawn)
    return max(float(np.linalg.norm(line - point, axis=1).min()) for point in points)


def test_a_circle_is_two_blocks_and_not_765() -> None:
    p = circle()
    program = Program("CIRCLE", at(p), time=np.linspace(0, 10, len(p)))
    few = thinned(program, TOLERANCE)
    assert few.count == 3
    assert few.circular.tolist() == [False, True, True]
    assert from_legs(few, p[::20]) < TOLERANCE
    assert few.time is not None
    assert few.time[-1] == 10
    for name, word in (
        ("krl", "CIRC "),
        ("rapid", "MoveC "),
        ("ls", "C P["),
        ("urscript", "movec("),
        ("val3", "movec("),
    ):
        text = "\n".join(find_format(name).write(few).values())
        assert text.count(word) == 2, name
        back = find_format(name).read(find_format(name).write(few))
        assert from_legs(back, p[::20]) < TOLERANCE + 2e-6
        assert back.time is not None
        assert back.time[-1] == pytest.approx(10, rel=1e-3)


def test_lines_alone_where_a_format_has_no_circles() -> None:
    p = circle()
    few = thinned(Program("CIRCLE", at(p), time=np.linspace(0, 10, len(p))), TOLERANCE, round_legs=False)
    assert few.via is None
    assert 20 < few.count < 60
    assert from_legs(few, p[::20]) < TOLERANCE


def test_a_corner_a_stop_and_a_change_of_speed_stay() -> None:
    p = np.zeros((401, 3))
    p[:, 0] = np.minimum(np.arange(401), 200) * 1e-3
    p[:, 1] = np.maximum(np.arange(401) - 200, 0) * 1e-3
    pace = np.where(np.arange(400) < 100, 0.01, 0.02)
    dwell = np.where(np.arange(401) == 300, 0.5, 0.0)
    time = np.concatenate([[0.0], np.cumsum(pace)]) + np.where(np.arange(401) > 300, 0.5, 0.0)
    few = thinned(Program("CORNER", at(p), time=time, dwell=dwell), TOLERANCE)
    assert few.X is not None
    assert few.time is not None
    np.testing.assert_allclose(
        few.X[:, :2, 3], [[0, 0], [0.1, 0], [0.2, 0], [0.2, 0.1], [0.2, 0.2]], atol=1e-12
    )
    np.testing.assert_allclose(few.time, [0, 1, 3, 5, 7.5])
    assert few.dwell.tolist() == [0, 0, 0, 0.5, 0]
    legs = legs_of(few)
    # a square corner is cut by no more than the tolerance, the change of speed on the line as `blend` says
    assert legs.blend[1] == pytest.approx(1e-3)
    assert legs.blend[2] == pytest.approx(2 * TOLERANCE / np.sin(np.pi / 4))
    assert legs.blend[3] == 0


def test_a_turn_that_does_not_keep_step_breaks_the_line() -> None:
    s = np.linspace(0, 1, 201)
    p = np.stack([0.2 * s, 0 * s, 0 * s], axis=1)
    even = np.stack([0 * s, 0 * s, s], axis=1)
    assert thinned(Program("EVEN", at(p, even), time=s), TOLERANCE).count == 2
    bent = thinned(Program("BENT", at(p, even**2), time=s), TOLERANCE)
    assert bent.count > 10
    assert bent.X is not None
    for i in range(200):
        k = np.searchsorted(bent.X[:, 0, 3], p[i, 0], side="right") - 1
        part = (p[i, 0] - bent.X[k, 0, 3]) / (bent.X[k + 1, 0, 3] - bent.X[k, 0, 3])
        angles = Rotation.from_matrix(bent.X[[k, k + 1], :3, :3]).as_rotvec()[:, 2]
        assert abs(angles[0] + part * (angles[1] - angles[0]) - s[i] ** 2) * 0.1 <= TOLERANCE + 1e-12


def test_no_tolerance_keeps_every_point() -> None:
    p = circle(50)
    program = Program("ALL", at(p), time=np.linspace(0, 1, 50))
    assert thinned(program, 0.0) is program


@pytest.mark.parametrize("spacing", [0.2, 0.005, 0.001])
def test_corners_stay_corners(spacing: float) -> None:
    """Over any three points there is a circle: of a square's corners, or of a corner and its neighbours,
    of which one is far away."""
    corners = 0.2 * np.array([[0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2], [0, 0, 2]])
    share = np.arange(round(0.2 / spacing)) * spacing / 0.2
    p = np.concatenate([*(a + share[:, None] * (b - a) for a, b in pairwise(corners)), corners[-1:]])
    p = np.delete(p, np.arange(len(share) + 1, len(share) + len(share) // 4), axis=0)
    few = thinned(Program("SQUARE", at(p), time=0.01 * np.arange(len(p))), TOLERANCE)
    assert not few.circular.any()
    assert from_legs(few, corners) < 1e-9


def test_a_polygon_is_no_circle_but_what_is_sampled_closely_is() -> None:
    for count, round_ in ((13, False), (49, True)):
        p = circle(count)
        few = thinned(Program("RING", at(p), time=np.linspace(0, 10, count)), TOLERANCE)
        assert few.circular.any() == round_


def arc(radius: float, sweep: float, count: int = 201) -> np.ndarray:
    angle = np.linspace(0, np.radians(sweep), count)
    return np.stack([1 + radius * np.cos(angle), radius * np.sin(angle), np.full(count, 0.5)], axis=1)


@pytest.mark.parametrize(
    ("p", "lines", "rounds"),
    [
        (arc(4.0, 0.3), True, 0),  # m and degrees: a straight leg as corrected, 0.014 mm off its chord
        (arc(0.02, 11.0), True, 0),
        (arc(0.02, 14.0), False, 1),
        (arc(1.2e-4, 180.0), True, 0),
        (arc(4e-4, 180.0), False, 1),
    ],
)
def test_no_circle_that_a_controller_refuses(p: np.ndarray, lines: bool, rounds: int) -> None:
    """RAPID wants its three points 0.1 mm apart, and 1° between via and end as seen from the start."""
    few = thinned(Program("ARC", at(p), time=np.linspace(0, 10, len(p))), TOLERANCE)
    assert few.circular.sum() == rounds
    assert (few.count - 1 > few.circular.sum()) == lines
    assert from_legs(few, p[::5]) < 1.05 * TOLERANCE
    for i in np.flatnonzero(few.circular):
        assert few.X is not None
        assert few.via is not None
        a, b = (X[:3, 3] - few.X[i - 1, :3, 3] for X in (few.via[i], few.X[i]))
        assert min(np.linalg.norm(way) for way in (a, b, b - a)) > 1e-4
        assert np.degrees(np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))) > 1


def test_fanuc_stops_at_sharp_corners_and_runs_through_flat_ones() -> None:
    """CNT cuts a corner as the speed has it, which no tolerance bounds."""
    p = 0.1 * np.array([[0, 0, 5], [1, 0.02, 5], [2, 0, 5], [2, 1, 5], [2, 2, 5]])
    program = Program("CORNERS", at(p), time=np.arange(5.0), tolerance=TOLERANCE)
    moves = [line for line in find_format("ls").write(program)["CORNERS.ls"].splitlines() if "P[" in line]
    ends = [
        line.split()[-2] if line.split()[-1] == ";" else line.split()[-1] for line in moves if ":L" in line
    ]
    assert ends == ["CNT100", "FINE", "CNT100", "FINE"]
    assert any("stops (FINE)" in said for said in find_format("ls").warnings(program))
