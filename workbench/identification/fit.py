"""Identification: Gauss–Newton on analytic Jacobians, whitened by the noise, held by wide priors.

Geometry corrections carry a prior of a few mm and mrad, which is far wider than what data decide and
keeps what they cannot decide at its nominal value: no columns are chosen by hand, nothing runs off. What
no point shows, whatever the pose, is held to 0.5 mm and 0.5 mrad: it changes levers of loads alone.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from ..campaign.problem import Problem
from ..effects.base import Effect
from ..robot.equilibrium import NoRest
from ..robot.kinematics import Array
from .gauss_newton import Normal
from .jacobian import Jacobian
from .model import Linearisation, Model, State
from .noise import Covariance, body_motion, required_noise
from .parameters import Columns, columns
from .patterns import Pattern
from .registration import register
from .rows import Amounts, Equations, Place, amounts_of, equations, fitted_numbers, jacobian, moved, whitening

CORRECTIONS = 4  # of a step, until it follows the valley it goes along
TOLERANCE = 1e-2  # standard deviations, all numbers together
AS_TOLD = 0.5  # of what a step should gain, from which it may be less damped
ROUGH = 0.3  # of a fit that is a place to start from, and to be linear about
ROUGHLY, QUITE, LATELY = 1.0, 0.01, 3  # χ² that so many steps have gained together: a fit is there, or creeps


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model.

    line: derivatives at the solution; whitener: (N, D, R) with R = 3T, or 3T + n where drive torques were
    recorded; r: (N, D) whitened residual (measured minus predicted); residual: (N, T, 3) [m], NaN where not
    seen; normal: the equations at the solution; rough: a place to start from. cost: whitened squares of the
    residual and of what the priors hold.
    """

    model: Model
    state: State
    columns: Columns
    noise: Covariance
    line: Linearisation
    whitener: Array
    normal: Normal
    r: Array
    residual: Array
    rough: bool
    iterations: int
    converged: bool
    cost: float

    def __repr__(self) -> str:
        names = ", ".join(effect.cause for effect in self.model.effects) or "geometry alone"
        return f"Fit with {names}: {len(self.columns.names)} numbers, {self.iterations} iterations"

    @property
    def J(self) -> Array:
        """(N, D, P) whitened Jacobian."""
        return self.normal.J.columns

    @cached_property
    def upper(self) -> Array:
        """(P, P) with JᵀJ + prior = upperᵀ upper, in units of the priors."""
        return self.normal.factor(self.rough)

    @cached_property
    def own_axes(self) -> Array:
        """(N, D, P) whitened Jacobian along axes on which its numbers, the priors counted in, are known to 1:
        what it takes of whitened columns are their products with these."""
        J = self.normal.J.rows * self.columns.prior
        taken = solve_triangular(self.upper, J.T, trans="T", check_finite=False)
        return np.ascontiguousarray(taken.T).reshape(self.J.shape)

    @cached_property
    def motions(self) -> Jacobian:
        """Jacobian (N, R, P) before whitening."""
        return jacobian(self.model, self.line, self.columns, self.state, None)

    @cached_property
    def lasting(self) -> Fit:
        """Without functions that do not stay with the robot (of bearing, order, time), the rest fitted again:
        part of what they took may be the robot's, and a model predicts without them. What earlier campaigns
        alone have stays: the rest is the robot of the last."""
        kept = [e for e in self.model.effects if e.lasting or e.dated]
        return self if len(kept) == len(self.model.effects) else refit(self, kept)

    @cached_property
    def covariance(self) -> Array:
        """(P, P) covariance of the fitted numbers."""
        half = solve_triangular(self.upper, np.eye(len(self.upper))).T * self.columns.prior
        return np.asarray(half.T @ half)

    def value(self, name: str) -> float:
        """A fitted number by its name in `columns.names`; `joint_compliance/joint_2` where that is the start
        of one name only. Raises KeyError; a frame has no numbers of its own: see `state`."""
        value = float(fitted_numbers(self.columns, self.state)[self.columns.index(name)])
        if np.isnan(value):
            raise KeyError(f"{name} is a motion: the state has what it led to")
        return value

    def std(self, name: str) -> float:
        """Standard deviation of a fitted number by its name, as `value`."""
        i = self.columns.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    @cached_property
    def axial(self) -> Array:
        """(N, D, n) whitened motions of the points by each joint's own motion."""
        return np.matmul(self.whitener, self.line.direct[:, :, self.model.problem.arm.axial])

    def pattern(self, effect: Effect) -> Pattern:
        """The whitened columns of an effect at zero, in the model or not."""
        own = effect.of_joint(self.model.problem)
        if own is None:
            return Pattern(self.whitened(effect))
        joint, amount = own
        return Pattern(amount, self.axial[:, :, joint], joint)

    def whitened(self, effect: Effect) -> Array:
        """(N, D, p) whitened columns of an effect at zero, in the model or not."""
        G = self.model.effect_jacobian(self.line, effect, np.zeros(len(effect.params)))
        return np.asarray(np.matmul(self.whitener, G))

    @property
    def point_variance(self) -> Array:
        """(N, T) [m²] per axis of the points' noise: the instrument's, the joints' and the body's."""
        problem, noise = self.model.problem, self.noise
        axial = self.line.by_joint * noise.joint
        moved = np.concatenate([axial, body_motion(problem) * np.repeat(noise.body, 3)], axis=2)
        return np.asarray(noise.sigma**2 + (moved**2).reshape(*noise.sigma.shape, -1).sum(axis=2) / 3)

    @property
    def usual(self) -> float:
        """[m] the points' noise per axis, root mean square."""
        return float(np.sqrt(np.mean(self.point_variance)))

    @property
    def rank(self) -> int:
        """Number of combinations that the data decide better than their prior does."""
        return int((np.linalg.svd(self.upper, compute_uv=False) > np.sqrt(2)).sum())

    @property
    def chi2(self) -> float:
        """Whitened residual sum of squares of the points."""
        return float((self.point_residual**2).sum())

    @property
    def point_residual(self) -> Array:
        """(N, D') whitened residual of the points alone, without the drive torques."""
        return self.r[:, : self.r.shape[1] - self.model.problem.drives]

    @property
    def point_rows(self) -> int:
        """Number of whitened rows that carry data of points."""
        used = np.abs(self.whitener[:, : self.point_residual.shape[1]]).sum(axis=2) > 0
        return int(used.sum())

    def at(self, problem: Problem) -> Array:
        """(N, T, 3) [m] the points of a problem that differs in what its poses carry, as fitted."""
        return replace(self.model, problem=problem).predict(self.state)

    def effect_values(self, i: int) -> tuple[Array, Array]:
        """Values (p,) and covariance (p, p) of the model's i-th effect."""
        part = self.columns.effect[i]
        return self.state.values[i], self.covariance[part, part]

    def given_estimate(self, i: int) -> tuple[float, float]:
        """Value and standard deviation of the model's i-th given number, what was given counted in."""
        at = self.columns.given_slice.start + i
        return float(self.state.given[i]), float(np.sqrt(self.covariance[at, at]))

    def beyond_background(self, moved: Array) -> Array:
        """What is seen of whitened motions (..., N, D): of each without what frames, targets and geometry
        take of it within their priors."""
        n = self.columns.background
        J = (self.J[:, :, :n] * self.columns.prior[:n]).reshape(-1, n)
        flat = moved.reshape(-1, len(J)).T
        taken = J @ np.linalg.solve(J.T @ J + np.eye(n), J.T @ flat)
        return np.asarray(moved - taken.T.reshape(moved.shape))

    def wald(self, i: int) -> float:
        """Squared size of the model's i-th effect in standard deviations."""
        values, covariance = self.effect_values(i)
        return float(values @ np.linalg.solve(covariance, values))


def start_state(problem: Problem) -> State:
    """State after registration, robot as it is."""
    R, t, targets = register(problem)
    return State(problem.arm.geometry, R, t, targets)


def fit(
    model: Model,
    start: State | None = None,
    noise: Covariance | None = None,
    geometry: bool | Sequence[int] = True,
    tolerance: float = TOLERANCE,
    max_iterations: int = 30,
    line: Linearisation | None = None,
) -> Fit:
    """Fits frames, targets, geometry, the model's effects and its given numbers to the campaign.

    geometry: all of it, none of it, or only the columns 6 · slot + component (tx ty tz rx ry rz) named.
    start: default the registered nominal robot; it may lack the effects' values (zeros then). noise: default
    as the campaign states it. Stops when a step changes no fitted number by more than `tolerance` of its
    standard deviation, when it creeps, or at the start with `max_iterations` 1. line: the
    derivatives at the start, where a fit that ended there has them. Raises ArithmeticError when it does not
    converge, `InputError` without any noise.
    """
    problem = model.problem
    start, noise = start or start_state(problem), noise or required_noise(problem)
    if len(start.values) != len(model.effects):
        start = replace(start, values=tuple(np.zeros(len(e.params)) for e in model.effects))
    start = replace(start, given=model.given_values(start))
    cols = columns(problem, model.effects, geometry, model.given)
    place = Place.of(model, start) if line is None else Place(model, start, line.prediction, line)
    W = whitening(problem, place.line, noise)
    at = equations(place, cols, W)
    amounts = amounts_of(model, cols)
    normal, damping, converged = _normal(model, cols, at, W, amounts), 0.0, False
    gains, little = list[float](), ROUGHLY if tolerance >= ROUGH else QUITE
    for iteration in range(max_iterations):
        step = normal.step(damping)
        creeps = len(gains) > LATELY and sum(gains[-LATELY:]) < little
        converged = (step.length < tolerance and damping == 0.0) or creeps
        if converged or iteration == max_iterations - 1:
            break
        new = _along(model, cols, at, W, normal, step.change, damping)
        if new is None:
            damping = max(10 * damping, 1.0)
            if damping > 1e15:
                raise ArithmeticError("the fit does not converge")
            continue
        gains.append(at.cost - new.cost)
        if step.length < tolerance or gains[-1] > AS_TOLD * normal.gain(step.change):
            damping = damping / 10 if damping > 0.1 else 0.0
        at = new
        if iteration < 2:  # the points' motion by the joints, in the noise, hardly changes any more
            W = whitening(problem, at.line, noise)
            at = equations(at.place, cols, W)
        normal = _normal(model, cols, at, W, amounts)
    residual = np.where(problem.seen[..., None], at.residual, np.nan)
    end = tolerance > TOLERANCE, iteration + 1, converged, at.cost
    return Fit(model, at.state, cols, noise, at.line, W, normal, at.r, residual, *end)


def _normal(model: Model, cols: Columns, at: Equations, W: Array, amounts: Amounts) -> Normal:
    return Normal.of(jacobian(model, at.line, cols, at.state, W, amounts), at.r, at.offset, cols.prior)


def _stepped(model: Model, cols: Columns, at: Equations, W: Array, step: Array) -> Equations | None:
    """The equations after a step; None where it goes to an arm too soft to stand."""
    state = moved(model.problem, cols, at.state, at.line.centre, step)
    try:
        return equations(Place.of(model, state, at.line), cols, W)
    except ArithmeticError:
        return None


def _worse(new: Equations | None, at: Equations) -> bool:
    return new is None or not new.cost <= at.cost * (1 + 1e-6) + 1e-3  # no number is worse


def _along(
    model: Model, cols: Columns, at: Equations, W: Array, normal: Normal, step: Array, damping: float
) -> Equations | None:
    """The equations after a step (P,); None where it leads to nothing better.

    Numbers that can stand in for each other lie in valleys that bend: a long step leaves them. So what the
    step makes of the residual beyond what the derivatives said is taken back, by the same derivatives (a
    second-order correction: Nocedal, Wright, Numerical Optimization, 2006, 18.3), as long as that helps.
    """
    aim, change, before = at.r - normal.J.times(step), step, np.inf
    for _ in range(1 + CORRECTIONS):
        new = _stepped(model, cols, at, W, change)
        if new is None or new.cost > before:
            return None
        if not _worse(new, at):
            return new
        before = new.cost
        change = change + normal.towards(new.r - aim).step(damping).change
    return None


def refit(result: Fit, effects: Sequence[Effect], tolerance: float = TOLERANCE) -> Fit:
    """The same data with other effects, started from the numbers that a fit has already; from the robot as it
    is where an arm of these numbers does not stand, what held it up being gone."""

    def place(effect: Effect) -> Hashable:
        return effect.cause, effect.where, effect.variant, len(effect.params)

    had = dict(zip(map(place, result.model.effects), result.state.values, strict=True))
    values = tuple(had.get(place(effect), np.zeros(len(effect.params))) for effect in effects)
    model = replace(result.model, effects=tuple(effects))
    start = replace(result.state, values=values)
    line = result.line if _as_before(result, model, start) else None
    found = list[Fit]()
    with suppress(NoRest):
        found.append(fit(model, start, result.noise, tolerance=tolerance, line=line))
        if found[0].converged:
            return found[0]
    # what was not in the model has bent the geometry far along what hardly shows: from the robot as it is
    again = replace(start_state(model.problem), values=tuple(0.0 * v for v in values))
    found.append(fit(model, again, result.noise, tolerance=tolerance))
    return min(found, key=lambda one: one.cost)


def _as_before(result: Fit, model: Model, start: State) -> bool:
    """Whether a model at a state is what a fit ended at: all its effects in its numbers, others at zero."""
    before = dict(zip(result.model.effects, result.state.values, strict=True))
    return before.keys() <= set(model.effects) and all(
        np.array_equal(values, before.get(effect, np.zeros_like(values)))
        for effect, values in zip(model.effects, start.values, strict=True)
    )
