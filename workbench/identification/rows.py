"""A problem's rows at a state: whitened residuals, priors and Jacobian; and the state after a step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..campaign.problem import Problem
from ..effects.base import Effect
from ..robot.kinematics import Array
from ..robot.rotations import from_vectors
from .jacobian import Jacobian
from .model import Linearisation, Model, Prediction, State, move_frame
from .noise import Covariance, whitener
from .parameters import Columns, body_motion
from .patterns import Index, Pattern

Amounts = Mapping[int, tuple[Index, Array]]  # of a joint: numbers (p,), its motion by each (N, p)


def whitening(problem: Problem, line: Linearisation, noise: Covariance) -> Array:
    """(N, D, R) that whitens the residuals of points and drive torques."""
    turned = from_middle(problem, line.prediction.points) if problem.campaign.six_dof else None
    W = whitener(problem, noise, line.by_joint if noise.joint.any() else None, turned)
    if not problem.drives:
        return W
    n_poses, rows, columns_ = W.shape
    out = np.zeros((n_poses, rows + problem.drives, columns_ + problem.drives))
    out[:, :rows, :columns_] = W
    if noise.torque is not None and problem.campaign.poses.torque is not None:
        weight = np.isfinite(problem.campaign.poses.torque) / noise.torque * noise.weight[:, None]
        for j in range(problem.drives):
            out[:, rows + j, columns_ + j] = weight[:, j]
    return out


def from_middle(problem: Problem, points: Array) -> Array:
    """(N, T, 3) points from the middle of those of their pose that were seen."""
    seen = problem.seen[..., None]
    middle = np.where(seen, points, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    return np.asarray(points - middle[:, None])


@dataclass(frozen=True, eq=False)
class Place:
    """A model at a state. known: the derivatives there, where somebody has them already."""

    model: Model
    state: State
    prediction: Prediction
    known: Linearisation | None = None

    @classmethod
    def of(cls, model: Model, state: State, near: Linearisation | None = None) -> Place:
        """`near` as for `Model.loaded`."""
        return cls(model, state, model.loaded(state, near))

    @cached_property
    def line(self) -> Linearisation:
        """The derivatives: a step that is tried and not taken needs none."""
        return self.known or self.model.linearised(self.state, self.prediction)


@dataclass(frozen=True, eq=False)
class Equations:
    """What a step is solved from. residual: (N, T, 3) measured minus predicted, zero where not seen; r:
    (N, D) the same whitened; offset: (P,) how far each number is from its prior's mean, in its prior."""

    place: Place
    residual: Array
    r: Array
    offset: Array
    cost: float

    @property
    def line(self) -> Linearisation:
        """The derivatives."""
        return self.place.line

    @property
    def state(self) -> State:
        """Where they hold."""
        return self.place.state


def equations(place: Place, cols: Columns, W: Array) -> Equations:
    """The equations of a model at a state."""
    model, problem = place.model, place.model.problem
    residual = np.where(problem.seen[..., None], problem.campaign.points - place.prediction.points, 0.0)
    flat = residual.reshape(len(residual), -1)
    if problem.drives:
        flat = np.concatenate([flat, model.drive_residual(place.line, place.state)], axis=1)
    r = np.matmul(W, flat[..., None])[..., 0]
    offset = offset_of(model, cols, place.state)
    return Equations(place, residual, r, offset, float((r**2).sum() + (offset**2).sum()))


def fitted_numbers(cols: Columns, state: State) -> Array:
    """(P,) the fitted numbers of a state; NaN where a column is a motion: a frame's, a whole body's."""
    out = np.full(len(cols.names), np.nan)
    for k, i, part in cols.targets:
        if i is not None:
            out[part] = state.targets[k, i]
    out[cols.geometry_slice] = state.geometry.ravel()[cols.geometry]
    out[cols.given_slice] = state.given
    for part, values in zip(cols.effect, state.values, strict=True):
        out[part] = values
    return out


def offset_of(model: Model, cols: Columns, state: State) -> Array:
    """How far each number is from its prior's mean, in units of the prior."""
    problem = model.problem
    out = np.zeros(len(cols.names))
    for k, i, part in cols.targets:
        off = state.targets[k] - problem.stated_targets
        if i is not None:
            out[part] = np.nan_to_num(off[i])
        elif np.isfinite(off).all():
            out[part] = np.linalg.lstsq(body_motion(state.targets[k]), off.ravel(), rcond=None)[0]
    change = state.geometry - problem.arm.geometry
    out[cols.geometry_slice] = change.ravel()[cols.geometry]
    out[cols.given_slice] = state.given - [item.value for item in model.given]
    for part, values in zip(cols.effect, state.values, strict=True):
        out[part] = values
    return out / cols.prior


def amounts_of(model: Model, cols: Columns) -> Amounts:
    """Of each joint, what the effects that are errors of its angle without load do to it."""
    found = dict[int, list[tuple[Index, Array]]]()
    for effect, part in zip(model.effects, cols.effect, strict=True):
        own = effect.of_joint(model.problem)
        if own is not None:
            found.setdefault(own[0], []).append((np.arange(part.start, part.stop), own[1]))
    return {
        joint: (np.concatenate([at for at, _ in each]), np.concatenate([own for _, own in each], axis=1))
        for joint, each in found.items()
    }


def jacobian(
    model: Model,
    line: Linearisation,
    cols: Columns,
    state: State,
    W: Array | None,
    amounts: Amounts | None = None,
) -> Jacobian:
    """Jacobian (N, D, P), whitened by W (N, D, R); None: as it is (D = R). What effects do of the motions of
    slots they do of whitened ones as well: these are far fewer than the columns of all effects. amounts: as
    `amounts_of` has them, which no state changes, where somebody asks again and again."""
    amounts = amounts_of(model, cols) if amounts is None else amounts
    setup = model.problem.campaign.poses.setup
    n_poses, rows, _ = line.geometry.shape
    fixed = np.zeros((n_poses, rows, cols.geometry_slice.stop))
    for k in range(cols.setups):
        fixed[:, :, 6 * k : 6 * k + 6] = np.where((setup == k)[:, None, None], line.frame, 0.0)
    for k, i, part in cols.targets:
        here = (setup == k)[:, None, None]
        if i is not None:
            fixed[:, 3 * i : 3 * i + 3, part] = np.where(here, line.target[:, i], 0.0)
        else:
            body = body_motion(state.targets[k]).reshape(-1, 3, 6)
            count = 3 * line.target.shape[1]
            moved = (line.target @ body).reshape(n_poses, count, 6)
            fixed[:, :count, part] = np.where(here, moved, 0.0)
    fixed[:, :, cols.geometry_slice] = line.geometry[:, :, cols.geometry]
    first = cols.given_slice.start
    given = [
        (item.effect, state.given[i, None], slice(first + i, first + i + 1))
        for i, item in enumerate(model.given)
    ]
    effects = [*given, *zip(model.effects, state.values, cols.effect, strict=True)]
    of_joints = {number for own, _ in amounts.values() for number in own.tolist()}
    others = [item for item in effects if item[2].start not in of_joints]
    at = [np.arange(fixed.shape[2]), *(np.arange(part.start, part.stop) for *_, part in others)]
    slopes = line
    if W is not None and effects:
        slopes = replace(line, loaded=np.matmul(W, line.direct), torque=np.matmul(W, line.torque))
    J = np.empty((n_poses, rows if W is None else W.shape[1], sum(map(len, at))))
    stop = fixed.shape[2]
    J[:, :, :stop] = fixed if W is None else np.matmul(W, fixed)
    for (effect, values, _), own in zip(others, at[1:], strict=True):
        start, stop = stop, stop + len(own)
        if W is None or _by_slopes(effect, model.problem):
            J[:, :, start:stop] = effect.jacobian(model.problem, slopes, values)
        else:
            J[:, :, start:stop] = np.matmul(W, effect.jacobian(model.problem, line, values))
    motions = slopes.direct[:, :, model.problem.arm.axial]
    along = [Pattern(own, motions[:, :, j], j) for j, (_, own) in amounts.items()]
    return Jacobian([Pattern(J), *along], [np.concatenate(at), *(own for own, _ in amounts.values())])


def _by_slopes(effect: Effect, problem: Problem) -> bool:
    """Whether all that is seen of an effect is what slots and wrenches do: nothing that an instrument, or the
    torque of a drive, shows of itself."""
    return effect.acts != "instrument" and not (effect.acts == "load" and problem.drives)


def moved(problem: Problem, cols: Columns, state: State, centre: Array, step: Array) -> State:
    """The state after a step."""
    for k in range(cols.setups):
        state = move_frame(state, k, centre[k], step[6 * k : 6 * k + 6])
    targets = state.targets.copy()
    for k, i, part in cols.targets:
        if i is not None:
            targets[k, i] += step[part]
            continue
        centre = targets[k].mean(axis=0)
        turn = from_vectors(step[part][3:])
        targets[k] = (targets[k] - centre) @ turn.T + centre + step[part][:3]
    geometry = state.geometry.copy()
    geometry.reshape(-1)[cols.geometry] += step[cols.geometry_slice]
    values = tuple(v + step[part] for v, part in zip(state.values, cols.effect, strict=True))
    given = state.given + step[cols.given_slice]
    return replace(state, targets=targets, geometry=geometry, values=values, given=given)
