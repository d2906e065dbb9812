"""Instrument frame and targets without a first guess, from the rigid arm: robust, from several starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames, frames
from ..robot.rotations import body_jacobian, from_vector, nearest_turn

STATED_TARGET = 0.02  # m, how far a stated target may be off before the fit resists: a reflector and its nest
UNKNOWN_TARGET = 1.0  # m, how far an unknown target may be from its frame
GOOD = 0.02  # of the spread of the points: with a smaller misfit no other start is tried
STILL = 1e-5  # m, rad: a step below which a registration, a place to start from, has arrived
ROUGHLY = 8  # iterations from each of many directions, of which the
PROMISING = 4  # best are followed to the end
LEAST_DAMPED, MOST_DAMPED = 1e-8, 1e4  # of the diagonal, what damps a step that would not mend
FAR = 50.0  # times the usual distance from the middle: farther points are not looked at


@dataclass(frozen=True)
class Sight:
    """What the instrument saw in some poses. N poses, T targets.

    R: (N, T, 3, 3), p: (N, T, 3) [m] frame behind which each target sits; points: (N, T, 3) [m] as
    measured, seen: (N, T) those that count.
    """

    R: Array
    p: Array
    points: Array
    seen: NDArray[np.bool_]

    @property
    def spread(self) -> float:
        """That of the frames' origins [m]."""
        return spread_of(self.p[self.seen]) if self.seen.any() else 0.0


@dataclass(frozen=True)
class Placed:
    """A set-up's frame R (3, 3), t (3,) [m] of the base in the instrument's, targets (T, 3) [m], the scale of
    the points; length: (N, T) [m] what is left of each point, NaN where not measured; middle: its median."""

    R: Array
    t: Array
    targets: Array
    scale: float
    length: Array
    middle: float


def register(problem: Problem) -> tuple[Array, Array, Array]:
    """R: (K, 3, 3), t: (K, 3) and targets: (K, T, 3) of each set-up, from the rigid nominal arm.

    Robust (a few wild points do no harm); where poses cannot tell frame from target, targets stay
    near their stated places.
    """
    setup, names = problem.campaign.poses.setup, problem.campaign.setup_names
    found = [place_stated(problem, setup == k) for k in range(len(names))]
    R, t, targets = (np.array([getattr(one, part) for one in found]) for part in ("R", "t", "targets"))
    fixed = np.array([target.fixed for target in problem.campaign.targets])
    return R, t, np.where(fixed[:, None], problem.stated_targets, targets)


def place_stated(problem: Problem, here: NDArray[np.bool_]) -> Placed:
    """The poses `here`, seen by one instrument, with the targets near where they are stated."""
    where = sight(problem.rigid, problem.campaign.points, problem.on, here)
    return place(where, problem.stated_targets, stated_within(problem))


def spread_of(points: Array) -> float:
    """[m] rms distance of (N, 3) points from their mean."""
    return float(np.sqrt(points.var(axis=0).sum()))


def stated_within(problem: Problem) -> Array:
    """(T,) [m] how far each target may be from where it is stated; a fixed one is held tight."""
    known = np.asarray(np.isfinite(problem.stated_targets).all(axis=1))
    prior = np.where(known, STATED_TARGET, UNKNOWN_TARGET)
    return np.where([target.fixed for target in problem.campaign.targets], 1e-6, prior)


def off_the_arm(arm: Arm, q: Array, points: Array) -> float:
    """Median distance [m] of points (N, 3) [m] of one target on the flange, its place unknown, from an arm at
    joints q (N, n) [rad, m]: roughly, and much where they do not belong together."""
    seen = sight(frames(arm, q), points[:, None], [arm.slots - 1], np.ones(len(q), dtype=bool))
    return place(seen, np.full((1, 3), np.nan), np.array([UNKNOWN_TARGET]), turns=False).middle


def sight(where: Frames, points: Array, on: Sequence[int], here: NDArray[np.bool_]) -> Sight:
    """The poses `here` of points (N, T, 3) on the frames `on`; points far from all are not looked at."""
    z = points[here]
    seen = np.asarray(np.isfinite(z).all(axis=2))
    p = np.stack([where.p[k][here] for k in on], axis=1)
    if seen.any():
        off = np.where(seen[..., None], z, 0.0) - np.median(z[seen], axis=0)
        distance = np.linalg.norm(np.clip(off, -1e100, 1e100), axis=2)
        usual = float(np.median(distance[seen])) + float(np.linalg.norm(p[seen].std(axis=0))) + 1e-3
        seen &= distance < FAR * usual
    return Sight(np.stack([where.R[k][here] for k in on], axis=1), p, z, seen)


def place(
    seen: Sight, stated: Array, prior: Array, *, turns: bool = True, scale: bool = False, rounds: int = 40
) -> Placed:
    """Best of several starts. stated: (T, 3) [m], NaN where unknown, and prior: (T,) [m] how far from there.

    turns: where no start is good, 24 directions more; scale: the size of the points is free as well;
    rounds: iterations.
    """
    known = np.asarray(np.isfinite(stated).all(axis=1))
    start = np.where(known[:, None], stated, 0.0)
    good = GOOD * (1e-3 + seen.spread)
    best = _refine(seen, start, prior, *_kabsch(seen, start), scale, rounds=rounds)
    if best.middle > good and start.any():
        other = _refine(seen, start, prior, *_kabsch(seen, 0.0 * start), scale, rounds=rounds)
        best = other if other.middle < best.middle else best
    if turns and best.middle > good:
        starts = [_turned_start(turn.as_matrix(), seen, start) for turn in Rotation.create_group("O")]
        rough = [_refine(seen, start, prior, *one, scale, rounds=ROUGHLY) for one in starts]
        for i in np.argsort([one.middle for one in rough])[:PROMISING]:
            other = _refine(seen, start, prior, *starts[int(i)], scale)
            best = other if other.middle < best.middle else best
    return best


def _kabsch(seen: Sight, targets: Array) -> tuple[Array, Array]:
    """Frame (3, 3), (3,) by Kabsch's rotation, repeated with less weight for what is far off."""
    points = seen.p + np.einsum("ntij,tj->nti", seen.R, targets)
    a, b = points[seen.seen], seen.points[seen.seen]
    if len(a) < 2:
        return np.eye(3), (b - a).mean(axis=0) if len(a) else np.zeros(3)
    ca, cb = np.median(a, axis=0), np.median(b, axis=0)
    weight = np.ones(len(a))
    R = np.eye(3)
    for _ in range(5):
        R = nearest_turn(a - ca, weight[:, None] * (b - cb))
        off = _norm(b - cb - (a - ca) @ R.T)
        weight = 1 / (off + _median(off) + 1e-9)
        weight /= weight.sum()
        ca, cb = weight @ a, weight @ b
    return R, cb - R @ ca


def _turned_start(turn: Array, seen: Sight, targets: Array) -> tuple[Array, Array]:
    points = seen.p + np.einsum("ntij,tj->nti", seen.R, targets)
    middle = np.median(seen.points[seen.seen], axis=0) if seen.seen.any() else np.zeros(3)
    return turn, middle - turn @ np.median(points.reshape(-1, 3), axis=0)


def _size(seen: Sight) -> float:
    """How much farther apart the points are than the frames."""
    measured, modelled = seen.points[seen.seen], seen.p[seen.seen]
    far = np.median(np.linalg.norm(measured - np.median(measured, axis=0), axis=1))
    size = far / (np.median(np.linalg.norm(modelled - np.median(modelled, axis=0), axis=1)) + 1e-9)
    return float(size) if np.isfinite(size) and size > 0 else 1.0


def _refine(
    seen: Sight, start: Array, prior: Array, R: Array, t: Array, free_scale: bool, rounds: int = 40
) -> Placed:
    """Gauss–Newton on frame, targets and scale with weights 1/misfit (robust), damped where a step would not
    mend: what poses do not determine (all on a line, a hand that never turns) goes nowhere."""
    of, pose = np.nonzero(seen.seen.T)
    ends = np.searchsorted(of, np.arange(len(start) + 1))  # of the points of each target
    axes, p, z = seen.R[pose, of], seen.p[pose, of], seen.points[pose, of]
    now = _Place(R, t, start.copy(), _size(seen) if free_scale else 1.0)
    hold = np.concatenate([np.full(6, 1e-9), np.repeat(prior, 3) ** -2.0, [0.0 if free_scale else 1e18]])
    J = np.zeros((len(z), 3, len(hold)))
    misfit, damping = np.inf, 0.0

    def cost(place: _Place, far: Array, scale: float) -> float:
        return float(far.sum() / scale + 0.5 * hold[6:-1] @ (place.targets - start).ravel() ** 2)

    points = now.points(axes, p, of)
    residual = z - points
    length = _norm(residual)
    for iteration in range(rounds):
        misfit, last = _median(length), misfit
        soft, scale = 1.5 * misfit + 1e-9, misfit + 1e-6
        far = np.hypot(length, soft)
        about = points - now.t
        J[..., :6], J[..., -1] = body_jacobian(about), about
        turned = now.size * now.R @ axes
        for i, (begin, end) in enumerate(pairwise(ends)):
            J[begin:end, :, 6 + 3 * i : 9 + 3 * i] = turned[begin:end]
        flat = J.reshape(-1, len(hold))
        pull = flat.T * np.repeat(1.0 / far / scale, 3)
        A, g = pull @ flat, pull @ residual.ravel()
        A.flat[:: len(hold) + 1] += hold
        g[6:-1] -= hold[6:-1] * (now.targets - start).ravel()
        least, step = cost(now, far, scale), np.zeros(len(g))
        while damping <= MOST_DAMPED:
            step = np.asarray(np.linalg.solve(A + np.diag(damping * np.diag(A)) if damping else A, g), float)
            then = now.moved(step)
            there = then.points(axes, p, of)
            off = z - there
            off_by = _norm(off)
            if cost(then, np.hypot(off_by, soft), scale) <= least:
                now, points, residual, length = then, there, off, off_by
                damping = 0.1 * damping if damping > LEAST_DAMPED else 0.0
                break
            if float(np.abs(step).max()) < STILL:
                break
            damping = max(LEAST_DAMPED, 100.0 * damping)
        arrived = damping > MOST_DAMPED or float(np.abs(step).max()) < STILL
        if arrived or (iteration > 15 and misfit > 0.999 * last):
            break
    every = np.asarray(np.isfinite(seen.points).all(axis=2))
    there = now.points(seen.R, seen.p, np.arange(len(start)))
    gap = np.clip(np.where(every[..., None], seen.points, np.nan) - there, -1e100, 1e100)
    return Placed(now.R, now.t, now.targets, now.size, np.linalg.norm(gap, axis=2), _median(length))


def _norm(vectors: Array) -> Array:
    """(M,) lengths of (M, 3)."""
    return np.asarray(np.sqrt(np.einsum("mi,mi->m", vectors, vectors)))


def _median(values: Array) -> float:
    """Of (M,) finite values, 0 of none (five times as fast as NumPy's)."""
    half = len(values) // 2
    if not len(values):
        return 0.0
    if len(values) % 2:
        return float(np.partition(values, half)[half])
    return float(0.5 * np.partition(values, (half - 1, half))[half - 1 : half + 1].sum())


@dataclass(frozen=True)
class _Place:
    """R: (3, 3), t: (3,) [m] the base in the instrument's frame; targets: (T, 3) [m]; size: of the points."""

    R: Array
    t: Array
    targets: Array
    size: float

    def points(self, axes: Array, p: Array, of: NDArray[np.int64]) -> Array:
        """(..., 3) [m] where the instrument would see the targets `of` (...) behind frames `axes`
        (..., 3, 3), p (..., 3) [m]."""
        local = p + (axes @ self.targets[of][..., None])[..., 0]
        return np.asarray(self.size * local @ self.R.T + self.t)

    def moved(self, step: Array) -> _Place:
        """After a step (7 + 3 T,): translation [m], rotation [rad], targets [m], logarithm of the size."""
        return _Place(
            from_vector(step[3:6]) @ self.R,
            self.t + step[:3],
            self.targets + step[6:-1].reshape(-1, 3),
            self.size * float(np.exp(np.clip(step[-1], -1.0, 1.0))),
        )
