"""What runs between the rows of a path: straight lines, and circles where rows lie on one.

A path's rows may be far apart, and a smooth curve through the joints of the corners of a square is no square.
So a leg that such a curve leaves has samples of its own, and at corners and stops the curve ends: the command
turns or stands there at once, and its filter rounds that off (`motion`). The legs at a corner are sampled
finely: there the error is largest; and those on which a gear errs in waves shorter than the rows are apart:
rows alone would not see these. What is corrected are the rows: between them the command is as far from
the wanted pose as they are, in proportion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...correction.command import COARSE
from ...correction.file import TOLERANCE_MM
from ...correction.inverse import Tip, newton
from ...correction.paths import Path
from ...correction.programs.arcs import circles, swept
from ...correction.programs.base import Program
from ...correction.programs.thin import COARSEST, thinned
from ...correction.trajectory import rigid
from ...correction.trouble import ranges_of
from ...robot.description import Robot
from ...robot.kinematics import Arm, Array, frames
from ...robot.rigid_plant import arrays
from ...robot.rotations import angle_between, from_vectors, pose, straight, tool_pose, vectors
from .motion import curve

CLOSE, TURNED = 5e-3, np.radians(1)  # m, rad: samples of a leg are no farther apart
CORNER = 1e-3  # m: nor those of a leg that begins or ends at a corner
SAME = 1e-8  # m, rad: rows that are no farther apart are one place, or one posture
STOP = 400  # samples of a path that stood all the time: what has died out counts for as long as it has
OFF = 1e-4  # m: a leg on which the curve through the rows stays so near needs no samples of its own
MOST = 20_000  # samples
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Way:
    """N rows with what is between them, for the nominal arm and its tip: M samples, each with its leg (M,),
    the row before, and its share of that leg. X: (M, 4, 4) wanted tool poses; corners: (C,) samples in which
    the tool turns off at once; uneven: rows (K,) behind which the arm cannot run as the tool should, its
    joints run evenly there."""

    arm: Arm
    tip: Tip
    rows: Array
    leg: Index
    share: Array
    X: Array
    corners: Index
    uneven: tuple[int, ...] = ()

    def along(self, path: Path) -> Path:
        """The path with a row for each sample. Its joints and poses are not in it."""
        if len(self.leg) == len(path):
            return path

        def at(values: Array | None) -> Array | None:
            if values is None:
                return None
            share = self.share.reshape(-1, *[1] * (values.ndim - 1))
            return np.asarray((1 - share) * values[self.leg] + share * values[self.leg + 1])

        time = at(path.time)
        assert time is not None
        lines = tuple(path.lines[i] for i in self.leg) if path.lines else ()
        return replace(
            path, time=time, q=None, X=self.X, wrench=at(path.wrench), temperature=at(path.temperature),
            lines=lines, dwell=None,
        )  # fmt: skip

    def command(self, q: Array) -> Array:
        """Joints (M, n) of a command that has joints q (N, n) in the rows."""
        if len(self.leg) == len(q):
            return q
        return self._between(q)[0]

    def _between(self, q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """The same, and which samples (M,) the arm reaches as the tool should."""
        told = self.tip.pose(frames(self.arm, q))
        off = told[:, :3, 3] - self.rows[:, :3, 3]
        turn = vectors(told[:, :3, :3] @ self.rows[:, :3, :3].transpose(0, 2, 1))
        leg, share = self.leg, self.share[:, None]

        def at(values: Array) -> Array:
            return np.asarray((1 - share) * values[leg] + share * values[leg + 1])

        even = at(q)
        X = pose(self.X[:, :3, 3] + at(off), from_vectors(at(turn)) @ self.X[:, :3, :3])
        joints, there = newton(self.arm, self.tip, X, even)
        legs = np.isin(leg, leg[~there])
        on_row = (self.share == 0) | (self.share == 1)
        return np.where((legs | on_row)[:, None], even, joints), ~legs


def way_of(
    robot: Robot, path: Path, X: Array, q: Array, tool: Array | None, waves: Sequence[tuple[int, float]] = ()
) -> Way:
    """The way over rows with the wanted tool poses X (N, 4, 4), which the nominal arm reaches with joints q
    (N, n). waves: joints, from 0, and how often in a turn (in 2π m) each errs."""
    stands = np.linalg.norm(np.diff(X[:, :3, 3], axis=0), axis=1) < SAME
    bends = np.union1d(_corners(X[:, :3, 3]), _stops(stands, X, q))
    round_ = _on_circles(path, X)
    middle = _at(X, np.arange(len(X) - 1), np.full(len(X) - 1, 0.5), round_)
    arm, tip = rigid(arrays(robot), tool_pose(tool), ranges_of(robot))
    half = 0.5 * (path.time[:-1] + path.time[1:])
    smooth = tip.pose(frames(arm, curve(path.time, q, bends)(half)))
    far = np.linalg.norm(smooth[:, :3, 3] - middle[:, :3, 3], axis=1) > OFF
    at_corner = np.isin(np.arange(len(far)), np.concatenate([bends - 1, bends]))
    size = np.maximum(
        np.linalg.norm(np.diff(X[:, :3, 3], axis=0), axis=1) / np.where(at_corner, CORNER, CLOSE),
        angle_between(X[:-1, :3, :3], X[1:, :3, :3]) / TURNED,
    )
    size = np.where(far | at_corner, size, 1.0)
    for joint, order in waves:
        size = np.maximum(size, COARSE * order / (2 * np.pi) * np.abs(np.diff(q[:, joint])))
    size = np.where(stands, np.maximum(size, STOP * np.diff(path.time) / np.ptp(path.time)), size)
    size *= min(1.0, MOST / size.sum())
    count = np.maximum(np.ceil(size), 1).astype(np.int64)
    leg = np.append(np.repeat(np.arange(len(count)), count), len(count) - 1)
    first = np.concatenate([[0], np.cumsum(count)])
    share = np.append((np.arange(first[-1]) - first[leg[:-1]]) / count[leg[:-1]], 1.0)
    found = Way(arm, tip, X, leg, share, _at(X, leg, share, round_), first[bends])
    there = found._between(q)[1]
    return replace(found, uneven=tuple(np.unique(leg[~there]).tolist()))


def _corners(p: Array) -> Index:
    """Rows in which a path p (N, 3) turns off by more than rows on a circle do."""
    way = np.diff(p, axis=0)
    length = np.linalg.norm(way, axis=1)
    ahead = way / np.maximum(length, 1e-12)[:, None]
    turn = np.arccos(np.clip((ahead[:-1] * ahead[1:]).sum(axis=1), -1, 1))
    moves = np.minimum(length[:-1], length[1:]) > 1e-6
    return 1 + np.flatnonzero(moves & (turn > COARSEST))


def _stops(stands: NDArray[np.bool_], X: Array, q: Array) -> Index:
    """Rows in which the tool X (N, 4, 4) comes to stand, or leaves from where it stood (N − 1 legs), still or
    turning, and the arm with joints (N, n) likewise. A curve through rows in one place would leave it in
    between."""
    turn = np.maximum(angle_between(X[:-1, :3, :3], X[1:, :3, :3]), np.abs(np.diff(q, axis=0)).max(axis=1))
    how = np.where(stands, 1 + (turn < SAME), 0)
    return 1 + np.flatnonzero(how[:-1] != how[1:])


def _on_circles(path: Path, X: Array) -> Array:
    """(N − 1, 6) centre and axis of the circle on which a leg runs, as a program would have it; NaN where it
    is straight."""
    out = np.full((len(X) - 1, 6), np.nan)
    program = thinned(Program("", X, time=path.time), 1e-3 * TOLERANCE_MM)
    if program.via is None or program.time is None:
        return out
    kept = np.searchsorted(path.time, program.time)
    for k in np.flatnonzero(np.isfinite(program.via[:, 0, 3])):
        a, b = kept[k - 1], kept[k]
        centre, _, _, axis = circles(X[[a], :3, 3], program.via[[k], :3, 3], X[[b], :3, 3])
        out[a:b] = np.concatenate([centre[0], axis[0]])
    return out


def _at(X: Array, leg: Index, share: Array, round_: Array) -> Array:
    """(M, 4, 4) poses at shares (M,) of legs (M,) between rows X (N, 4, 4)."""
    out = straight(X[leg], X[leg + 1], share)
    bent = np.flatnonzero(np.isfinite(round_[leg, 0]))
    if len(bent):
        here, s = leg[bent], share[bent, None]
        centre, axis = round_[here, :3], round_[here, 3:]
        start, end = (X[rows, :3, 3] for rows in (here, here + 1))
        angle = swept(centre, axis, start, end)[:, None]

        def turned(by: Array) -> Array:
            return np.asarray((from_vectors(by * axis) @ (start - centre)[..., None])[..., 0])

        # rows lie on the circle within the tolerance: what they are off goes in evenly
        out[bent, :3, 3] = centre + turned(s * angle) + s * (end - centre - turned(angle))
    return out
