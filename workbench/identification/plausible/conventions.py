"""A controller that counts joints otherwise than the URDF: signs, quarter turns and a coupling at once.

From base to flange, joint after joint, the likeliest ways of counting are kept. What lies behind a joint is
not decided yet: its frame explains of the points what any linear map of its place and its axes does. That
leaves nothing but the motion of the joints behind it where all before it are right.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.description import Robot
from ...robot.kinematics import Arm, Array, frames
from .hypotheses import Hypothesis
from .misfit import Sample, misfit

ZEROS = (0, 90, -90, 180)  # degrees
KEPT = 120  # ways of counting: of the likely ones that one is right shows several joints later
TRIED = 24  # of these to the end
AXES_TOO = 18  # poses, from which on a frame's axes are looked at besides its place: 12 numbers for a column
WILD = 4.0  # times the usual distance from the middle: farther points are not looked at
ROUGHLY = 6  # iterations that show what is not worth
HOPEFUL = 2.0  # times the misfit that is enough


@dataclass(frozen=True)
class Counted:
    """The URDF's joints are change @ q + shift of the columns q. change: (n, n), shift: (n,) [deg]."""

    change: Array
    shift: NDArray[np.int64]

    @property
    def parts(self) -> int:
        """How many things are otherwise: signs, zeros and couplings."""
        signs = int(np.sum(np.diag(self.change) < 0))
        return signs + int(np.sum(self.shift != 0)) + self.couplings

    @property
    def couplings(self) -> int:
        return int(np.count_nonzero(self.change - np.diag(np.diag(self.change))))

    def joints(self, q: Array) -> Array:
        """(N, n) of the URDF, of columns q (N, n)."""
        return q @ self.change.T + np.radians(self.shift)

    def undo(self, data: Sample) -> Sample:
        return data.changed(q=self.joints(data.q))

    def with_joint(self, j: int, row: Array, zero: int) -> Counted:
        """With another row (n,) for joint j; the zero [deg] of the one before shows only now."""
        change, shift = self.change.copy(), self.shift.copy()
        change[j] = row
        shift[max(j - 1, 0)] = zero
        return Counted(change, shift)

    def with_zero(self, j: int, zero: int) -> Counted:
        shift = self.shift.copy()
        shift[j] = zero
        return Counted(self.change, shift)


def counted_otherwise(problem: Problem, data: Sample, enough: float) -> list[tuple[Hypothesis, float]]:
    """Ways of counting that leave no more than `enough`, and what they leave: at most one coupling."""
    for coupled in (False, True):
        fits = []
        for way in _likeliest(data, coupled):
            undone = way.undo(data)
            if misfit(undone, rounds=ROUGHLY).total > HOPEFUL * enough:
                continue
            if (left := misfit(undone).total) <= enough:
                fits.append((_told(way, problem.robot), left))
        if fits:
            return fits
    return []


def _likeliest(data: Sample, coupled: bool) -> Iterator[Counted]:
    """The likeliest ways of counting all joints, with every zero of the last one."""
    arm = data.arm
    setups, count = np.unique(data.setup, return_counts=True)
    rows = np.flatnonzero(data.setup == setups[np.argmax(count)])
    kept = [Counted(np.eye(arm.n), np.zeros(arm.n, dtype=np.int64))]
    for j in range(arm.n):
        # the zero of the first joint is the instrument's frame
        zeros = ZEROS if j > 1 and not arm.prismatic[j - 1] else (0,)
        more = [
            way.with_joint(j, row, zero)
            for way, zero, row in product(kept, zeros, _rows(arm, j, coupled))
            if way.couplings + np.count_nonzero(row) < 3
        ]
        left = np.concatenate(
            [_left(data, rows, more[k : k + KEPT], j + 2) for k in range(0, len(more), KEPT)]
        )
        parts = np.array([way.parts for way in more], dtype=np.float64)
        order = np.lexsort((parts, np.round(np.log(left + 1e-300), 4)))
        kept = [more[i] for i in order[:KEPT]]
    for way, zero in product(kept[:TRIED], ZEROS if not arm.prismatic[-1] else (0,)):
        yield way.with_zero(arm.n - 1, zero)


def _rows(arm: Arm, j: int, coupled: bool) -> list[Array]:
    """How joint j may be counted, its zero apart: (n,) each."""
    one = np.eye(arm.n)
    rows = [one[j], -one[j]]
    if coupled and not arm.prismatic[j]:
        beside = [i for i in (j - 1, j + 1) if 0 <= i < arm.n and not arm.prismatic[i]]
        rows += [own * one[j] + sign * one[i] for own in (1, -1) for i in beside for sign in (1, -1)]
    return rows


def _left(data: Sample, rows: NDArray[np.int64], ways: list[Counted], slot: int) -> Array:
    """(H,) [m²] what the best linear maps of the frame behind a slot leave of the points, for every way."""
    q = np.stack([way.joints(data.q[rows]) for way in ways])
    where = frames(data.arm, q.reshape(-1, data.arm.n))
    R, p = where.R[slot].reshape(*q.shape[:2], 3, 3), where.p[slot].reshape(*q.shape[:2], 3)
    axes_too = len(rows) >= AXES_TOO
    left = np.zeros(len(ways))
    for points, stated, on in zip(data.points[rows].swapaxes(0, 1), data.stated, data.on, strict=True):
        sound = _sound(points)
        own, place = R[:, sound], p[:, sound]
        if axes_too:
            told = np.concatenate([place, own.reshape(*own.shape[:2], 9)], axis=2)
        else:
            told = place + own @ np.nan_to_num(stated) * (slot == on)
        z = points[sound] - points[sound].mean(axis=0)
        Q = np.linalg.qr(told - told.mean(axis=1, keepdims=True))[0]
        left += np.sum(z**2) - np.sum((Q.swapaxes(1, 2) @ z) ** 2, axis=(1, 2))
    return np.maximum(left, 0.0)


def _sound(points: Array) -> NDArray[np.bool_]:
    """(N,) those points (N, 3) that were seen, and not far from all others."""
    seen = np.isfinite(points).all(axis=1)
    if not seen.any():
        return np.asarray(seen)
    off = np.linalg.norm(np.nan_to_num(points) - np.median(points[seen], axis=0), axis=1)
    return np.asarray(seen & (off <= WILD * np.median(off[seen])))


def _told(way: Counted, robot: Robot) -> Hypothesis:
    usual = np.eye(len(way.shift))
    other = [j for j, row in enumerate(way.change) if way.shift[j] or np.any(row != usual[j])]
    told = [f"{robot.joint_names[j]} is {_formula(way, j)}" for j in other]
    what = f"the columns count the joints otherwise than the robot's URDF: {', '.join(told)}"
    mend = "write that into the columns"
    if robot.convention is None or robot.convention.counts_as_the_urdf:
        stated = f"under [controller] of the robot's TOML {_controller(way, robot)}"
        mend = f'{mend}, or say joints = "controller" under [poses] and {stated}'
    return Hypothesis("poses", what, mend, way.undo, parts=way.parts)


def _formula(way: Counted, j: int) -> str:
    """The URDF's joint j of the columns, as people write it."""
    others = [i for i in np.flatnonzero(way.change[j]).tolist() if i != j]
    terms = [(float(way.change[j, i]), f"q{i + 1}") for i in [j, *others]]
    if way.shift[j]:
        terms.append((float(way.shift[j]), f"{abs(way.shift[j])}°"))
    terms.sort(key=lambda term: term[0] < 0)  # 90° - q2 rather than -q2 + 90°
    (first, name), *rest = terms
    return ("-" if first < 0 else "") + name + "".join(f" {'-' if f < 0 else '+'} {n}" for f, n in rest)


def _controller(way: Counted, robot: Robot) -> str:
    """The same as `[controller]` states it: shown = sign q + zero, and a coupling."""
    signs = np.diag(way.change).astype(int)
    names = robot.controller.names or tuple(f"J{j + 1}" for j in range(len(signs)))
    zeros = [0 - int(sign * shift) for sign, shift in zip(signs, way.shift, strict=True)]
    said = "" if robot.controller.names else f"names = {json.dumps(names)}, "
    said += f"signs = {signs.tolist()}, zeros = {zeros}"
    for j, i in ((int(j), int(i)) for j, i in np.argwhere(way.change - np.diag(signs))):
        factor = int(-signs[j] * way.change[j, i])
        said += f', couplings = [{{joint = "{names[j]}", on = "{names[i]}", factor = {factor}}}]'
    return said
