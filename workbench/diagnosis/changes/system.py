"""All occasions in one linear system: frames and targets of each, geometry and effects of all."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular, svd

from ...identification.rows import moved
from ...robot.kinematics import Array
from ...robot.ranges import beyond_range
from ..weighing.gram import OfRows
from ..weighing.reduced import Reduced, parts_of
from .candidates import Candidate, Shape, own_of
from .occasions import Occasion, numbers_of

PARTS = 10  # of an occasion, one after the other
FREE = 100.0  # times their priors: frames and targets of an occasion explain what they can, at no price

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class System:
    """R whitened rows of K occasions. J: (R, n) in prior sizes `prior` (n,): what each occasion has to
    itself (`local[k]`), then geometry and effects, which are common (`common`); e: (R,) the data, as far as
    the nominal robot does not explain them; own: (R,) occasion; pose: (R,) number among all poses; used:
    rows with data."""

    occasions: tuple[Occasion, ...]
    J: Array
    prior: Array
    local: tuple[slice, ...]
    common: slice
    e: Array
    own: NDArray[np.int64]
    pose: NDArray[np.int64]
    used: Mask

    @property
    def count(self) -> int:
        return len(self.occasions)

    @property
    def last(self) -> Array:
        """(K,) 1 at the last occasion, 0 at those before."""
        return (np.arange(self.count) == self.count - 1).astype(float)

    def frames(self, k: int) -> slice:
        """Columns of the instrument's place in an occasion's set-ups."""
        start = self.local[k].start
        return slice(start, start + 6 * self.occasions[k].fit.columns.setups)

    def lengths(self, k: int, rows: Array) -> Array:
        """[m] how far whitened rows of an occasion move each point that was seen there."""
        problem, whitener = self.occasions[k].problem, self.occasions[k].fit.whitener
        points = np.linalg.pinv(whitener) @ rows.reshape(len(whitener), -1, 1)
        moved = points[:, : 3 * problem.seen.shape[1], 0].reshape(*problem.seen.shape, 3)
        return np.asarray(np.linalg.norm(moved[problem.seen], axis=1))

    @property
    def misfit(self) -> bool:
        """Whether the noise does not explain what the model leaves of an occasion."""
        return any(one.misfit for one in self.occasions)

    @cached_property
    def within(self) -> list[list[Mask]]:
        """[k][i]: (N,) poses of occasion k that have every joint within what occasion i covered."""
        every = [one.problem.q for one in self.occasions]
        ranges = [(q.min(axis=0), q.max(axis=0)) for q in every]
        return [[np.all(~beyond_range(q, *other), axis=1) for other in ranges] for q in every]

    @property
    def mm(self) -> float:
        """RMS length [mm] of a motion of the points per root of its whitened sum of squares: by the mean
        variance of the points' noise."""
        variance = np.concatenate([one.fit.point_variance.ravel() for one in self.occasions])
        return 1e3 * float(np.sqrt(3 * np.mean(variance) / self.used.sum()))


def system_of(occasions: Sequence[Occasion]) -> System:
    """Each occasion linearised where its own fit is."""
    starts = [one.fit.columns.geometry_slice.start for one in occasions]
    ends = np.cumsum([0, *starts])
    common = occasions[0].fit.J.shape[2] - starts[0]
    J, e, used, priors = [], [], [], []
    pose = list[NDArray[np.int64]]()
    for k, one in enumerate(occasions):
        result, n = one.fit, starts[k]
        flat = result.J.reshape(-1, result.J.shape[2])
        rows = np.zeros((len(flat), ends[-1] + common))
        rows[:, ends[k] : ends[k + 1]], rows[:, ends[-1] :] = flat[:, :n], flat[:, n:]
        J.append(rows)
        e.append(result.r.ravel() + flat @ numbers_of(one))
        first = 0 if not pose else pose[-1][-1] + 1
        pose.append(first + np.repeat(np.arange(len(result.r)), result.r.shape[1]))
        used.append((np.abs(result.whitener).sum(axis=2) > 0).ravel())
        priors.append(FREE * result.columns.prior[:n])
    # a flange that fixed targets show at some occasions alone is held as far as these leave it
    widest = np.max([one.fit.columns.prior[n:] for one, n in zip(occasions, starts, strict=True)], axis=0)
    prior = np.concatenate([*priors, widest])
    return System(
        tuple(occasions),
        np.concatenate(J) * prior,
        prior,
        tuple(slice(int(a), int(b)) for a, b in itertools.pairwise(ends)),
        slice(int(ends[-1]), int(ends[-1]) + common),
        np.concatenate(e),
        own_of(occasions),
        np.concatenate(pose),
        np.concatenate(used),
    )


def reduced_of(
    system: System, candidates: Sequence[Candidate], noise_dof: float, rows: Mask | None = None
) -> Reduced:
    """The candidates in small matrices, what all occasions have anyway taken out. rows: only these count."""
    some = np.ones(len(system.e), bool) if rows is None else rows
    parts = parts_of([shape.width for shape in candidate.shapes] for candidate in candidates)
    shapes = [shape for candidate in candidates for shape in candidate.shapes]
    lengths, directions = svd(system.J[some].T, full_matrices=False)[1:]
    kept = (1.0 + lengths**2) ** -0.5  # of its length along the directions (n, R) of what is common

    def left_of(rows: Array) -> Array:
        """(g, R) of columns, one beside another."""
        return np.asarray(rows - (rows @ directions.T * (1.0 - kept)) @ directions)

    W = np.concatenate([left_of(shape.columns[some].T) for shape in shapes])
    e = left_of(system.e[some])
    dof = float(system.used[some].sum() - (1.0 - kept**2).sum())
    S = OfRows(W, [shape.width for shape in shapes])
    return Reduced(parts, S, W @ e, float(e @ e), dof, noise_dof)


@dataclass(frozen=True, eq=False)
class Solved:
    """All numbers at once. values: (n + g,) in prior sizes, background first; half: (n + g, n + g) with
    half halfᵀ their covariance; left: (R,) what is left, whitened; dof: its degrees of freedom; factor: on
    standard deviations, from what is left where that is more than the noise."""

    values: Array
    half: Array
    background: int
    left: Array
    dof: float

    @property
    def factor(self) -> float:
        return float(np.sqrt(max(1.0, float(self.left @ self.left) / self.dof)))

    def of(self, part: slice) -> tuple[Array, Array]:
        """Values and covariance of some of the columns behind the background, in their prior sizes."""
        at = slice(self.background + part.start, self.background + part.stop)
        half = self.factor * self.half[at]
        return self.values[at], half @ half.T


def solve(system: System, shapes: Sequence[Shape], scales: Sequence[float]) -> Solved:
    """The common numbers, and the shapes, each held as one that was found at its scale."""
    A, unit = _columns(system, shapes, scales)
    n = A.shape[1]
    values, inverse = _least_squares(A, system.e)
    left = system.e - A @ values
    dof = float(system.used.sum()) - (n - float((inverse**2).sum()))
    return Solved(
        values * unit,
        inverse * unit[:, None],
        system.J.shape[1],
        left,
        max(dof, 1.0),
    )


def moved_without_parts(
    system: System,
    shapes: Sequence[Shape],
    scales: Sequence[float],
    solved: Solved,
    parts: Sequence[NDArray[np.int64]],
) -> list[Array]:
    """(parts, n + g) of each division: by how much all numbers move, in prior sizes, when one part is left
    out, after the other. parts: (R,) each, the number of each row's part, -1 outside."""
    A, unit = _columns(system, shapes, scales)
    values = solved.values / unit
    out = []
    for part in parts:
        kept = [part != i for i in np.unique(part[part >= 0])]
        out.append(np.array([_least_squares(A[rows], system.e[rows])[0] - values for rows in kept]) * unit)
    return out


def parts_in_order(system: System) -> list[NDArray[np.int64]]:
    """Of each occasion: `PARTS`, one after the other in the order of measurement; or one for each pose."""
    out = []
    for here in (system.own == k for k in range(system.count)):
        poses = np.unique(system.pose[here])
        out.append(np.where(here, np.searchsorted(poses, system.pose) * PARTS // len(poses), -1))
    return out


def _least_squares(A: Array, e: Array) -> tuple[Array, Array]:
    """Values (n,) of numbers with standard normal priors by data e (R,) with columns A (R, n), and (n, n)
    half of their covariance. Without the normal equations: of columns that the data do not tell apart,
    squares lose what the priors say."""
    n = A.shape[1]
    stacked = np.column_stack([np.vstack([A, np.eye(n)]), np.concatenate([e, np.zeros(n)])])
    R = np.asarray(qr(stacked, mode="r", overwrite_a=True, check_finite=False)[0])
    inverse = np.asarray(solve_triangular(R[:n, :n], np.eye(n), check_finite=False))
    return inverse @ R[:n, n], inverse


def _columns(system: System, shapes: Sequence[Shape], scales: Sequence[float]) -> tuple[Array, Array]:
    """All columns (R, n + g), the shapes' as they are held, and how these are held (n + g,)."""
    held = [shape.held(scale) for shape, scale in zip(shapes, scales, strict=True)]
    C = [shape.columns * scale for shape, scale in zip(shapes, held, strict=True)]
    A = np.concatenate([system.J, *C], axis=1)
    return A, np.concatenate([np.ones(system.J.shape[1]), *held])


def relinearised(system: System, shapes: Sequence[Shape], solved: Solved) -> list[Occasion]:
    """The occasions at what was solved for, each with its own share of what changed."""
    background = solved.values[: solved.background] * system.prior
    out = []
    for k, one in enumerate(system.occasions):
        result, wanted = one.fit, background[system.common].copy()
        start, at = result.columns.geometry_slice.start, 0
        for shape in shapes:
            value = shape.levels(solved.of(slice(at, at + shape.width))[0])[k] * shape.sizes
            at += shape.width
            for column, moved_by in zip(shape.geometry, value, strict=False):
                wanted[np.flatnonzero(result.columns.geometry == column)] += moved_by
            first = 0
            for effect in shape.effects:
                p = len(effect.params)
                if effect in result.model.effects:
                    part = result.columns.effect[result.model.effects.index(effect)]
                    wanted[part.start - start : part.stop - start] += value[first : first + p]
                first += p
        step = np.concatenate([background[system.local[k]], wanted - numbers_of(one)[start:]])
        out.append(one.at(moved(one.problem, result.columns, result.state, result.line.centre, step)))
    return out
