"""Wrenches that are stated otherwise than they acted: the other way round, along other axes, in another unit,
at another point than the flange's origin. Seen in how the arm yields to them, whatever its joints' stiffness:
that is fitted to each, and only never less than none. The arm's weight is the ruler that tells a unit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from ...campaign.problem import Problem
from ...identification.fit import ROUGH, Fit, fit, start_state
from ...robot.kinematics import RX, Array
from ...robot.rotations import cross

AGAINST = 0.5  # of the squares at most is left where the arm yielded against its loads: it never does
ALONG = 0.25  # of the squares at most is left where they act along other axes, or elsewhere
SO_LARGE = 0.1  # of the squares at most is left where they are of another size
IDLE = 1e-6  # of the largest torque of a joint: what bears less tells nothing of its stiffness
ROUNDS = 8  # in which point and stiffness, of which the moments are the product, are found
FORCE, MOMENT = slice(0, RX), slice(RX, 6)
UNITS = {9.80665: "kilograms for newtons", 1e3: "kilonewtons for newtons", 4.4482: "pounds for newtons"}
AXES = "give what acts on the robot, along the axes of its base"


@dataclass(frozen=True)
class Mistake:
    """What the points say that the loads were, how to mend it, and the problem that says so. enough: of the
    squares at most is left without it."""

    what: str
    mend: str
    problem: Problem
    enough: float


def stated_otherwise(problem: Problem, instrument: Array) -> Iterator[Mistake]:
    """Along other axes, or the other way round. instrument: (K, 3, 3) the base's axes on the instrument's."""
    wrench, what = problem.campaign.poses.wrench, "fx ... mz: the arm yields as under wrenches"
    of_instrument = instrument.transpose(0, 2, 1)[problem.campaign.poses.setup]
    for turn, whose in ((problem.rigid.R[-1], "flange"), (of_instrument, "instrument")):
        there = np.concatenate([_turned(turn, wrench[:, part]) for part in (FORCE, MOMENT)], axis=1)
        for sign, opposite in ((1.0, ""), (-1.0, " the other way round")):
            said = f"{what} along the {whose}'s axes{opposite}"
            yield Mistake(said, AXES, under(problem, sign * there), ALONG)
    mend = "turn their signs: they are what acts on the robot, not what it does"
    yield Mistake(f"{what} the other way round", mend, under(problem, -wrench), AGAINST)


def of_another_size(problem: Problem) -> Iterator[tuple[str, Mistake]]:
    """In another unit, and which was mistaken for which."""
    wrench = problem.campaign.poses.wrench
    for size, unit in UNITS.items():
        for factor, mistaken in ((size, unit), (1 / size, " for ".join(reversed(unit.split(" for "))))):
            said = f"fx ... mz: the arm yields as under wrenches {factor:.3g} times as large"
            too = f"{size:.3g} times too {'large' if factor > 1 else 'small'}"
            mend = f"were {mistaken} written? If not, the links' masses are {too}"
            yield mistaken, Mistake(said, mend, under(problem, factor * wrench), SO_LARGE)
    if wrench[:, MOMENT].any():
        less = np.concatenate([wrench[:, FORCE], 1e-3 * wrench[:, MOMENT]], axis=1)
        said = "mx ... mz: the arm yields as under moments 0.001 times as large"
        mistaken = "newton millimetres for newton metres"
        yield mistaken, Mistake(said, f"were {mistaken} written?", under(problem, less), SO_LARGE)


@dataclass(frozen=True)
class Eased:
    """A fit of the geometry, not taken a step, beside joints that yield as the points want it."""

    at: Fit
    own: Array

    @classmethod
    def of(cls, first: Fit, problem: Problem) -> Eased:
        """Where `first` begins, under another problem's loads. Raises ArithmeticError where the arm finds no
        rest under them."""
        model = replace(first.model, problem=problem)
        at = fit(model, first.state, first.noise, tolerance=ROUGH, max_iterations=1)
        slot, component = np.divmod(problem.arm.axial, 6)
        return cls(at, problem.arm.compliance[slot, component, component])

    def left(self) -> tuple[float, Array]:
        """Squares that remain, and the joints' compliances (n,) by which they do."""
        A, b, squares = self._equations(self._yields())
        found = _at_least_none(A, b + A @ self.own)
        x = found - self.own
        return float(squares - 2 * b @ x + x @ A @ x), found

    def point(self, found: Array) -> tuple[Array, Array]:
        """(3,) [m] how much farther out on the flange's axes the forces act, and the compliances (n,) that
        go with it; found: those before."""
        wrench, turn = self.at.model.problem.campaign.poses.wrench, self.at.model.problem.rigid.R[-1]
        more = np.stack([cross(turn[:, :, k], wrench[:, FORCE]) for k in range(3)], axis=2)
        arm = self.at.model.problem.arm
        slot, component = np.divmod(arm.axial, 6)
        axes = self.at.model.problem.rigid.axes[:, slot, component] * ~np.asarray(arm.prismatic)[:, None]
        torque = np.einsum("nji,nik->njk", axes, more) * found[:, None]
        out = np.matmul(self.at.axial, torque)
        columns = np.concatenate([self._yields(), out, -out], axis=2)
        A, b, _ = self._equations(columns)
        own = np.concatenate([self.own, np.zeros(6)])
        both = _at_least_none(A, b + A @ own)
        n = len(self.own)
        return both[n : n + 3] - both[n + 3 :], both[:n]

    def _yields(self) -> Array:
        """(N, D, n) what each joint's yield to its torque moves, per unit of compliance; 0 without torque."""
        problem = self.at.model.problem
        torque = problem.nominal_torque
        most = np.abs(torque).max(axis=0)
        return np.asarray(self.at.axial * np.where(most > IDLE * most.max(), torque, 0.0)[:, None])

    def _equations(self, columns: Array) -> tuple[Array, Array, float]:
        """Normal equations of columns (N, D, k) beside all that the geometry takes, and the squares of the
        residual without."""
        whole = np.concatenate([columns, self.at.r[:, :, None]], axis=2).transpose(2, 0, 1)
        taken = self.at.beyond_background(whole).reshape(len(whole), -1)
        M = whole.reshape(len(whole), -1) @ taken.T
        return M[:-1, :-1], M[:-1, -1], float(M[-1, -1])


def begun(result: Fit) -> Fit:
    """The nominal robot with a fit's noise: what took in wrong loads is nothing to be linear about."""
    start = replace(start_state(result.model.problem), values=result.state.values)
    return fit(result.model, start, result.noise, tolerance=ROUGH, max_iterations=1)


def squares_left(first: Fit, problem: Problem) -> float:
    """What remains of the squares of a fit that has `begun` where the loads are those of another problem and
    the joints yield to them as they like."""
    try:
        left = Eased.of(first, problem).left()[0]
    except ArithmeticError:
        return np.inf
    return left if np.isfinite(left) else np.inf


def acting_elsewhere(first: Fit) -> Mistake | None:
    """The forces at the point of the flange's axes where the arm yields to them; None without one. first: a
    fit that has `begun`."""
    problem = first.model.problem
    wrench, turn = problem.campaign.poses.wrench, problem.rigid.R[-1]
    there, point = problem, np.zeros(3)
    try:
        found = Eased.of(first, problem).left()[1]
        for _ in range(ROUNDS):
            more, found = Eased.of(first, there).point(found)
            point = point + more
            lever = _turned(turn, np.tile(point, (len(turn), 1)))
            moment = wrench[:, MOMENT] + cross(lever, wrench[:, FORCE])
            there = under(problem, np.concatenate([wrench[:, FORCE], moment], axis=1))
    except ArithmeticError:
        return None
    place = " ".join(f"{1e3 * value + 0.0:.0f}" for value in point)
    what = f"fx ... mz: the arm yields as under forces at {place} mm in the flange's frame"
    how = "say with mx ... mz what the forces do about the flange's origin: lever × force, on the base's axes"
    return Mistake(what, how, there, ALONG)


def under(problem: Problem, wrench: Array) -> Problem:
    """The problem with other wrenches (N, 6)."""
    return replace(problem, campaign=problem.campaign.with_poses(wrench=wrench))


def _turned(turn: Array, vectors: Array) -> Array:
    return np.asarray((turn @ vectors[..., None])[..., 0])


def _at_least_none(A: Array, b: Array) -> Array:
    """The x ≥ 0 that minimises xᵀ A x − 2 bᵀ x, in units of its columns; 0 where there is none."""
    size = np.sqrt(np.maximum(np.diag(A), 0.0))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
    values, axes = np.linalg.eigh(A * np.outer(scale, scale))
    root = np.sqrt(np.maximum(values, 1e-12 * values.max(initial=0.0) + 1e-300))
    return np.asarray(scale * nnls((axes * root).T, (axes.T @ (scale * b)) / root)[0])
