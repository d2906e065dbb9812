"""A path with the fewest straight and circular legs that stay within a tolerance of its points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...robot import rotations
from ...robot.kinematics import Array
from .arcs import circles, swept
from .base import STANDSTILL, Program, legs_of

LEVER = 0.1  # m: a turn of the tool counts at this distance from its point
PACE = 0.1  # legs whose speeds differ by more than this share of their mean stay apart
LEAST_ON_A_CIRCLE = 5  # points, below which a circle says nothing: over any three there is one
COARSEST = np.radians(15)  # between neighbours on a circle: wider apart they are corners
WIDEST = np.radians(190)  # of one circular leg, so that a circle is two of them; RAPID ends at 240°
FLATTEST = np.radians(3)  # from via to end, seen from the start: RAPID wants 1°, a UR was seen to refuse 2.9°
SHORTEST = 2e-4  # m between start, via and end: RAPID wants 0.1 mm


def thinned(program: Program, tolerance: float, round_legs: bool = True) -> Program:
    """The path of a program of poses in as few legs as a forward search finds.

    tolerance [m]: how far a point that is left out may lie from the leg that replaces it, and how far its
    turn (times `LEVER`) may be from the leg's, which runs evenly from end to end. Points with a pause, turns
    on the spot and changes of speed by more than `PACE` stay. round_legs: the controller has circular moves;
    a circle takes the place of points no farther apart than `COARSEST`: of a square's corners none. What is
    nearly straight is lines, as controllers refuse such circles. The legs keep their durations, so each runs
    at the mean speed of what it replaces.
    """
    if program.kind != "poses" or program.count < 3 or tolerance <= 0 or program.via is not None:
        return program
    assert program.X is not None
    path = _Path(program, tolerance)
    kept, via = [0], [np.full((4, 4), np.nan)]
    while kept[-1] < program.count - 1:
        start = kept[-1]
        straight = path.farthest(start, path.is_straight)
        round_ = path.farthest(start, path.is_circular) if round_legs else start
        over, end = np.full((4, 4), np.nan), max(straight, start + 1)
        if round_ > end and path.is_curved(start, round_):
            over, end = program.X[path.middle(start, round_)], round_
        kept.append(end)
        via.append(over)
    bent = np.array(via)
    some = np.array(kept)
    return replace(
        program,
        X=program.X[some],
        q=None if program.q is None else program.q[some],
        time=None if program.time is None else program.time[some],
        dwell=program.dwell[some],
        posture=None if program.posture is None else program.posture[some],
        via=bent if np.isfinite(bent).any() else None,
        tolerance=max(tolerance, program.tolerance),
    )


class _Path:
    """Points p (N, 3) and turns R (N, 3, 3) with what their legs allow."""

    def __init__(self, program: Program, tolerance: float) -> None:
        assert program.X is not None
        self.p, self.R, self.tolerance = program.X[:, :3, 3], program.X[:, :3, :3], tolerance
        legs = legs_of(program)
        self.way = np.concatenate([[0.0], np.cumsum(legs.distance[1:])])
        self.speed = legs.speed
        held = (legs.pause > 0) | (legs.distance < STANDSTILL)
        held[:-1] |= held[1:] & (legs.distance[1:] < STANDSTILL)
        held[[0, -1]] = True
        stops = np.flatnonzero(held)
        self.stop = stops[
            np.minimum(np.searchsorted(stops, np.arange(program.count), side="right"), len(stops) - 1)
        ]

    def farthest(self, start: int, fits: Callable[[int, int], bool]) -> int:
        """The last point that one leg from `start` reaches: doubling steps, then halving."""
        last, good, step = int(self.stop[start]), start, 1
        while good < last:
            trial = min(start + step, last)
            if not fits(start, trial):
                bad = trial
                while bad - good > 1:
                    middle = (good + bad) // 2
                    good, bad = (middle, bad) if fits(start, middle) else (good, middle)
                return good
            good, step = trial, 2 * step
        return good

    def middle(self, start: int, end: int) -> int:
        """The point between that is nearest to half the way."""
        half = 0.5 * (self.way[start] + self.way[end])
        inner = np.arange(start + 1, end)
        return int(inner[np.argmin(np.abs(self.way[inner] - half))])

    def is_straight(self, start: int, end: int) -> bool:
        if end == start + 1:
            return True
        points, line = self.p[start : end + 1] - self.p[start], self.p[end] - self.p[start]
        length = float(np.linalg.norm(line))
        if length < STANDSTILL:
            return False
        along = points @ line / length
        beside = np.linalg.norm(points - np.outer(along, line / length), axis=1)
        return bool(beside.max() <= self.tolerance) and self._runs_on(start, end, along / length)

    def is_circular(self, start: int, end: int) -> bool:
        """Within the tolerance; how flat counts in the end (`is_curved`), as every arc begins flat."""
        if end - start + 1 < LEAST_ON_A_CIRCLE:  # so that a longer one is tried
            return True
        via = self.middle(start, end)
        a, b, c = (self.p[[i]] for i in (start, via, end))
        centre, radius, sweep, axis = circles(a, b, c)
        if not np.isfinite(radius[0]) or sweep[0] > WIDEST:
            return False
        points = self.p[start : end + 1] - centre
        height = points @ axis[0]
        off = np.hypot(np.linalg.norm(points - np.outer(height, axis[0]), axis=1) - radius, height)
        if off.max() > self.tolerance:
            return False
        share = swept(centre, axis, a, self.p[start : end + 1]) / sweep[0]
        share[0], share[-1] = 0.0, 1.0
        close = float(np.diff(share).max() * sweep[0]) <= COARSEST
        return close and self._runs_on(start, end, share)

    def is_curved(self, start: int, end: int) -> bool:
        """Whether controllers take the circle: enough points, far enough apart, not nearly on a line."""
        if end - start + 1 < LEAST_ON_A_CIRCLE:
            return False
        via = self.middle(start, end)
        a, b = self.p[via] - self.p[start], self.p[end] - self.p[start]
        if min(np.linalg.norm(way) for way in (a, b, b - a)) < SHORTEST:
            return False
        return bool(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b) >= FLATTEST)

    def _runs_on(self, start: int, end: int, share: Array) -> bool:
        """Never back, at an even pace, the turn in step. share: (m,) of the way at each point."""
        if (np.diff(share) < 0).any():
            return False
        speed = self.speed[start + 1 : end + 1]
        if np.ptp(speed) > PACE * speed.mean():
            return False
        whole = rotations.vectors(self.R[[start]].transpose(0, 2, 1) @ self.R[[end]])
        even = self.R[start] @ rotations.from_vectors(share[:, None] * whole)
        return bool(rotations.angle_between(even, self.R[start : end + 1]).max() * LEVER <= self.tolerance)
