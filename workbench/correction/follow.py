"""Joints along a whole path: one start posture, its branch of elbow and wrist kept from pose to pose.

Knots on the path, close enough for one Newton run from any to the next, are solved first; joints between
are guessed by a smooth curve through them and solved all at once. An arm with more joints than the tool
needs moves each time by the least step, so that its redundancy stays where the start put it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Arm, Array, frames
from ..robot.rotations import angle_between
from .extended_arm import PART, parts
from .inverse import Tip, newton

SPACING = 0.1  # way between knots, in rad and lengths of the tip
STARTS = 128  # random postures that are tried for the first pose
BRANCHES = 16  # solutions of it that are followed
MENDED = 4  # of these that are looked at knot by knot
TRIES_IN_A_ROW = 3  # knots in a row that are tried in vain
RETRIES = 3  # rounds in which what was not reached is tried from its neighbours
JUMP = 0.15  # rad or lengths: joints that move by so much more than the way asks for change the branch
SAME = 1e-3

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Range:
    """Joint limits, lower and upper: (n,) [rad, m], infinite where there are none."""

    lower: Array
    upper: Array

    def margin(self, q: Array) -> Array:
        """Distance (...) to the nearest limit of any joint [rad, m], π at most; negative outside."""
        room = np.minimum(q - self.lower, self.upper - q)
        return np.minimum(room, np.pi).min(axis=-1)


def follow(
    arm: Arm, tip: Tip, X: Array, limits: Range, start: Array | None, seed: int
) -> tuple[Array, Bools]:
    """Joints (N, n) for the tool poses X: (N, 4, 4), and which poses were reached.

    start: (n,) joints near those of the first pose; None: the best of several postures.
    """
    way = path_way(tip, X)
    knots = knot_indices(way)
    first, postures = 0, np.zeros((0, arm.n))
    for first in [0, *range(1, len(knots), max(1, len(knots) // 8))]:
        postures = start_postures(arm, tip, X[knots[first]], limits, start, seed)
        if len(postures):
            break
    if not len(postures):
        return np.full((len(X), arm.n), np.nan), np.zeros(len(X), dtype=bool)
    q_knots, solved = _best_track(arm, tip, X[knots], first, postures, limits)
    return _fill(arm, tip, X, way, knots[solved], q_knots[solved])


def path_way(tip: Tip, X: Array) -> Array:
    """(N,) way of the tool from the first pose: turns [rad] and shifts in lengths of the tip, added up."""
    shift = np.linalg.norm(np.diff(X[:, :3, 3], axis=0), axis=1) / tip.length
    turn = angle_between(X[:-1, :3, :3], X[1:, :3, :3])
    return np.concatenate([[0.0], np.cumsum(shift + turn)])


def knot_indices(way: Array) -> NDArray[np.int64]:
    """Samples about `SPACING` apart, the first and the last among them."""
    step = np.floor(way / SPACING)
    inner = np.flatnonzero(np.diff(step) > 0) + 1
    return np.unique(np.concatenate([[0], inner, [len(way) - 1]]))


def start_postures(arm: Arm, tip: Tip, X: Array, limits: Range, start: Array | None, seed: int) -> Array:
    """(B, n) solutions of one pose (4, 4): from the given joints, or from many at random."""
    low = np.where(np.isfinite(limits.lower), limits.lower, np.where(arm.prismatic, -tip.length, -np.pi))
    high = np.where(np.isfinite(limits.upper), limits.upper, np.where(arm.prismatic, tip.length, np.pi))
    if start is None:
        rng = np.random.default_rng([seed, arm.n])
        guesses = rng.uniform(np.maximum(low, -np.pi), np.minimum(high, np.pi), (STARTS, arm.n))
    else:
        guesses = np.asarray(start, float)[None]
    target = np.broadcast_to(X, (len(guesses), 4, 4))
    q, solved = newton(arm, tip, target, guesses, rounds=40, refresh=1)
    q = q[solved]
    if start is not None or not len(q):
        return q
    off = np.linalg.norm(tip.error(frames(arm, q), target[: len(q)])[:, 3:], axis=1)
    q = q[off < off.min() + SAME]  # of 3 rows: a place is reached in other turns of the tool as well
    turns = np.where(arm.prismatic, 0.0, np.round((q - (low + high) / 2) / (2 * np.pi)))
    q = q - 2 * np.pi * turns
    q = q[np.argsort(-limits.margin(q), kind="stable")]
    kept: list[Array] = []
    for posture in q:
        if all(np.abs(posture - other).max() > SAME for other in kept):
            kept.append(posture)
        if len(kept) == BRANCHES:
            break
    return np.array(kept)


Track = tuple[Array, Bools]


def _best_track(arm: Arm, tip: Tip, X: Array, first: int, postures: Array, limits: Range) -> Track:
    """Joints (M, n) at all knots X, and which were solved, of the posture at knot `first` that serves best.

    From each posture, one Newton run to every knot; it stands where neighbours are smooth. The postures
    that come farthest so are mended knot by knot.
    """
    count, every = len(X), np.tile(X, (len(postures), 1, 1))
    q, solved = newton(arm, tip, every, np.repeat(postures, count, axis=0))
    smooth = np.zeros(len(q), dtype=bool)
    smooth[1:] = solved[1:] & solved[:-1] & one_branch(arm, tip, every[1:], q[:-1], q[1:])
    joins = smooth.reshape(-1, count)
    tracks = list(zip(q.reshape(-1, count, arm.n), solved.reshape(-1, count), strict=True))
    order = sorted(range(len(tracks)), key=lambda b: (-int(joins[b].sum()), _badness(tracks[b], limits)))
    mended = [_mended(arm, tip, X, first, *tracks[b], joins[b]) for b in order[:MENDED]]
    return min(mended, key=lambda track: _badness(track, limits))


def _mended(arm: Arm, tip: Tip, X: Array, first: int, q: Array, solved: Bools, smooth: Bools) -> Track:
    """The track with every knot on the branch of its neighbour towards `first`, or not solved.

    `smooth[k]`: knot k joins on to knot k - 1 as it is; others are solved once more from their neighbour,
    until some in a row are out of reach.
    """
    q, solved = q.copy(), solved.copy()
    for order in (range(first + 1, len(X)), range(first - 1, -1, -1)):
        last, touched, misses = first, False, 0
        for k in order:
            if abs(k - last) == 1 and not touched and smooth[max(k, last)]:
                last = k
                continue
            solved[k] = solved[k] and one_branch(arm, tip, X[[k]], q[[last]], q[[k]])[0]
            touched = not solved[k] and misses < TRIES_IN_A_ROW
            if touched:
                again, reached = newton(arm, tip, X[[k]], q[[last]], rounds=12)
                solved[k] = reached[0] and one_branch(arm, tip, X[[k]], q[[last]], again)[0]
                q[k] = again[0] if solved[k] else q[k]
            last, misses = (k, 0) if solved[k] else (last, misses + 1)
    return q, solved


def one_branch(arm: Arm, tip: Tip, X: Array, a: Array, b: Array) -> Bools:
    """(K,) whether postures a and b (K, n), b at the pose X, are one branch: the joints have moved by
    about what the tool's way asks for."""
    where = frames(arm, a)
    gain = tip.gain(arm, tip.jacobian(arm, where))
    way = np.einsum("kij,kj->ki", gain, tip.scaled(tip.error(where, X)))
    unit = np.where(arm.prismatic, tip.length, 1.0)
    off, far = np.abs((b - a - way) / unit).max(axis=1), np.abs(way / unit).max(axis=1)
    return np.asarray(off < JUMP + 0.5 * far)


def _badness(track: Track, limits: Range) -> tuple[int, int, float]:
    q, solved = track
    margin = limits.margin(q[solved])
    return int((~solved).sum()), int((margin < 0).sum()), -float(margin.min(initial=np.inf))


def _fill(
    arm: Arm, tip: Tip, X: Array, way: Array, knots: NDArray[np.int64], q_knots: Array
) -> tuple[Array, Bools]:
    """All samples, from knots that are solved."""
    from scipy.interpolate import CubicSpline  # slow to load, and what reads a program needs none

    q = np.empty((len(X), arm.n))
    solved = np.zeros(len(X), dtype=bool)
    fresh = np.concatenate([[True], np.diff(way[knots]) > 1e-9])
    curve = CubicSpline(way[knots][fresh], q_knots[fresh]) if fresh.sum() > 3 else None
    for part in parts(len(X)):
        inside = np.clip(way[part], way[knots[0]], way[knots[-1]])
        if curve is not None:
            guess = curve(inside)
        else:
            guess = np.stack([np.interp(inside, way[knots], q_knots[:, j]) for j in range(arm.n)], axis=1)
        q[part], solved[part] = newton(arm, tip, X[part], guess)
    return _retry(arm, tip, X, q, solved)


def _retry(arm: Arm, tip: Tip, X: Array, q: Array, solved: Bools) -> tuple[Array, Bools]:
    """Samples that were not reached, once more from the nearest that were."""
    for _ in range(RETRIES):
        lost, known = np.flatnonzero(~solved), np.flatnonzero(solved)
        if not len(lost) or not len(known):
            break
        right = np.clip(np.searchsorted(known, lost), 0, len(known) - 1)
        left = np.maximum(right - 1, 0)
        closer = np.abs(known[left] - lost) < np.abs(known[right] - lost)
        guess = q[np.where(closer, known[left], known[right])]
        before = len(lost)
        for start in range(0, len(lost), PART):
            some = lost[start : start + PART]
            q[some], solved[some] = newton(arm, tip, X[some], guess[start : start + PART])
        if int((~solved).sum()) == before:
            break
    return q, solved
