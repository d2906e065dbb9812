"""A step in time: the instrument was moved, or the tool was mounted anew, in the middle of a campaign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign.in_motion import in_motion
from ...campaign.problem import Problem
from ...campaign.stepped import split_campaign
from ...effects import catalogue
from ...effects.base import Effect, short
from ...effects.coming_to_rest import SHARES, SOONEST, share_gone
from ...effects.recorded import DataFault
from ...effects.unnamed import unnamed
from ...effects.unnamed.at_once import AtOnce
from ...identification.fit import Fit, refit
from ...identification.registration import (
    GOOD,
    UNKNOWN_TARGET,
    Placed,
    place,
    place_stated,
    sight,
    stated_within,
)
from ...robot.kinematics import Array
from ...robot.rotations import body_jacobian
from ..found import FaultFound
from ..weighing.places_of_steps import CLEARLY, Taken, by_chance, gains_of, half_of, places, prefix
from ..weighing.screen import SURVIVES, effective_dof, quadratic, reduce_columns
from .rounded_joints import shared_rounding
from .sag import sag

LEAST_POSES = 20  # of a set-up in which a step is sought
LEAST_BEFORE = 8  # poses before and after a jump
JUMP = 0.1  # of the spread of the points, from which a step counts as a jump
MOST = 0.5  # of what is beyond the noise, which a step explains
SURE = 3.0  # standard deviations of its size, from which a step's size is determined
AS_WELL = 2.0  # times what is left of its own fit: one fit for all poses explains a part as well
WAVES = 3  # cosines in the order of measurement: what a drift may look like
LOOKED_AT, KEPT = 10, 1 / 3  # poses that are off most, and of what a step takes off χ² without one of them
MANY = 10.0  # times its usual size, up to which what is smooth may stand in for a step


@dataclass(frozen=True)
class Step:
    """A step in time: kind of data fault, first pose after it, size [m] that the points move by, rms; what
    it takes off χ², where it was sought by that."""

    kind: DataFault
    first: int
    size: float
    statistic: float = 0.0

    def fault(self, problem: Problem) -> FaultFound:
        """The step as a data fault of the pose that it comes before."""
        moved = {"moved_instrument": "the instrument's frame", "changed_setup": "the tool with its targets"}
        what = f"{moved[self.kind]} steps by {short(1e3 * self.size)} mm (at the targets) before this pose"
        name = problem.campaign.poses.ids[self.first]
        return FaultFound(self.kind, name, None, what, "frame and targets fitted anew from here on")


def step_in_time(result: Fit) -> Step | None:
    """A moved instrument, or a tool that was mounted anew, in any set-up of one campaign; None when nothing
    steps.

    Every place in the measured order is tried; a step must stand out of a smooth drift clearly. Of rows that
    were measured in motion neighbours have much of their noise in common, and its wander looks like steps.
    """
    c = result.model.problem.campaign
    if c.beside or in_motion(c.poses.q, c.poses.time):  # each of several was asked alone
        return None
    found = [_step_of(result, own) for own in c.poses.by_setup if len(own) >= LEAST_POSES]
    return max((one for one in found if one), key=lambda one: one.statistic, default=None)


def _only(columns: Array, own: NDArray[np.int64]) -> Array:
    """Columns (N, ...) in the poses `own`, 0 in others."""
    out = np.zeros_like(columns)
    out[own] = columns[own]
    return out


def _step_of(result: Fit, own: NDArray[np.int64]) -> Step | None:
    """The clearest step among the poses `own` of a set-up; None where none is, or all creeps to rest."""
    motions = {kind: _only(columns, own) for kind, columns in _motions(result).items()}
    found = [_step(result, kind, columns, own) for kind, columns in motions.items()]
    step = max((one for one in found if one), key=lambda one: one.statistic, default=None)
    if step is None or step.statistic < max(_creeping(result, columns, own) for columns in motions.values()):
        return None
    return step


def by_no_chance(result: Fit, step: Step, others: Sequence[Step]) -> bool:
    """Whether a step, beside others and a fit without any, takes clearly more off χ² than one does where the
    order of measurement is drawn at random: what a model lacks looks like steps too."""
    taken, problem = Taken.by(result), result.model.problem
    motions = {kind: np.matmul(result.whitener, columns) for kind, columns in _motions(result).items()}
    for other in others:
        there = problem.campaign.poses.in_setup_of(other.first)
        taken = taken.and_of(_only(motions[other.kind], there[there >= other.first]))
    own = problem.campaign.poses.in_setup_of(step.first)
    base = _only(motions[step.kind], own)
    first = int(np.searchsorted(own, step.first))
    gain = gains_of(*prefix(taken, base, own))[first]
    if gain <= CLEARLY * by_chance(result, base, own, places(problem.positions[own]), taken):
        return False
    return not _of_one_pose(taken, base, own, first, gain)


def _of_one_pose(taken: Taken, base: Array, own: NDArray[np.int64], first: int, gain: float) -> bool:
    """Whether a step of the poses `own` before the one at `first`, which takes so much off χ², is that of a
    single wild pose on its shorter side: one that stands for itself leaves little of it."""
    some = own[:first] if first <= len(own) - first else own[first:]
    for pose in some[np.argsort(-(taken.r[some] ** 2).sum(axis=1))][:LOOKED_AT]:
        beside = taken.and_of(_only(base, np.array([pose])))
        if gains_of(*prefix(beside, base, own))[first] < KEPT * gain:
            return True
    return False


def _motions(result: Fit) -> dict[DataFault, Array]:
    """(N, R, 6) what moves in each kind of step."""
    return {"moved_instrument": result.line.frame, "changed_setup": result.line.direct[:, :, -6:]}


def jump(problem: Problem) -> Step | None:
    """A step in a set-up that is too large for a fit of all its poses together, None where there is none.

    From one pose on, all are grossly off where the first ones put the arm, and agree among themselves.
    """
    c = problem.campaign
    for own in [] if c.beside else c.poses.by_setup:
        step = _jump(replace(problem, campaign=c.some(own)))
        if step is not None:
            return replace(step, first=int(own[step.first]))
    return None


def _jump(problem: Problem) -> Step | None:
    """The same of one set-up."""
    c, n_poses = problem.campaign, len(problem.q)
    if n_poses < 4 * LEAST_BEFORE:
        return None
    order = np.arange(n_poses)
    first = place_stated(problem, order < max(LEAST_BEFORE, n_poses // 4))
    spread = float(np.linalg.norm(problem.rigid.p[-1].std(axis=0)))
    if first.middle > GOOD * spread:
        return None
    base = problem.rigid.points(first.targets, problem.on) @ first.R.T + first.t
    off = np.where(problem.seen, np.linalg.norm(c.points - base, axis=2), np.nan)
    seen = problem.seen.any(axis=1)
    far = np.zeros(n_poses, dtype=bool)
    far[seen] = np.nanmedian(off[seen], axis=1) > JUMP * spread
    right = np.concatenate([[0], np.cumsum(~far)]) + far.sum() - np.concatenate([[0], np.cumsum(far)])
    k = int(np.argmax(right))
    if not LEAST_BEFORE <= k <= n_poses - LEAST_BEFORE or far[:k].mean() > 0.1 or far[k:].mean() < 0.9:
        return None
    after = place_stated(problem, order >= k)
    if after.middle > GOOD * spread or _one_fits(problem, first, after, k):
        return None
    size = float(np.sqrt(np.nanmean(off[k:] ** 2)))
    if size < SURE * _prediction(problem, first, order < k, order >= k):
        return None
    held = np.full(len(first.targets), 1e-6)
    seen_after = sight(problem.rigid, c.points, problem.on, order >= k)
    same_tool = place(seen_after, first.targets, held, turns=False)
    kind: DataFault = "moved_instrument" if same_tool.middle < AS_WELL * after.middle else "changed_setup"
    return Step(kind, k, size, np.inf)


def _one_fits(problem: Problem, first: Placed, after: Placed, k: int) -> bool:
    """Whether one frame and one set of targets for all poses fit both parts about as well as their own do."""
    every = place_stated(problem, np.ones(len(problem.q), dtype=bool))
    parts = ((every.length[:k], first.middle), (every.length[k:], after.middle))
    return all(float(np.nanmedian(length)) < AS_WELL * own for length, own in parts)


def _prediction(problem: Problem, first: Placed, here: NDArray[np.bool_], there: NDArray[np.bool_]) -> float:
    """Standard deviation, rms [m], of the points `there` as a registration of the poses `here` predicts them.

    What is off a rigid robot is alike in neighbouring poses: more of them do not make it better known.
    """
    rigid, seen = problem.rigid, problem.seen
    points = rigid.points(first.targets, problem.on) @ first.R.T
    axes = np.stack([first.R @ rigid.R[slot] for slot in problem.on], axis=1)
    J = _frame_and_targets(points, axes)
    known, new = (J[seen & some[:, None]].reshape(-1, J.shape[-1]) for some in (here, there))
    prior = np.concatenate([np.full(6, UNKNOWN_TARGET), np.repeat(stated_within(problem), 3)])
    sigma = first.middle + 1e-9
    A = known.T @ known / (sigma**2 * here.sum()) + np.diag(prior**-2.0)
    return float(np.sqrt(np.sum(new.T * np.linalg.solve(A, new.T)) / (len(new) / 3)))


def _step(result: Fit, kind: DataFault, columns: Array, own: NDArray[np.int64]) -> Step | None:
    """The best step of the motions columns: (N, R, 6) of the points of the poses `own`; None when none is
    clear."""
    base, taken = np.matmul(result.whitener, columns), Taken.by(result)
    before = prefix(taken, base, own)
    possible = places(result.model.problem.positions[own])
    if not possible:
        return None
    gains = gains_of(*before)[possible]
    gain, first = float(gains.max()), possible[int(gains.argmax())]
    scatter = _scatter(result, gain)
    step, along = _only(base, own[:first]), np.zeros(len(base))
    along[own] = np.linspace(0, np.pi, len(own))
    drift = [base * np.cos(k * along)[:, None, None] for k in range(1, WAVES + 1)]
    if gain < 60 * scatter or _beside(result, step, drift) < 40 * scatter:
        return None
    if _beside_joints(result, step) < 60 * scatter:
        return None
    alike = scatter > 1.0 or shared_rounding(result)  # in a run the errors of rounding are
    if alike and gain < CLEARLY * by_chance(result, base, own, possible, taken):
        return None
    if _of_one_pose(taken, base, own, first, gain):
        return None
    size, std = _size(result, columns, own, *(of[first] for of in before))
    return Step(kind, int(own[first]), size, gain) if size > SURE * std * np.sqrt(scatter) else None


def _size(
    result: Fit, columns: Array, own: NDArray[np.int64], S: Array, u: Array, length: Array
) -> tuple[float, float]:
    """How far the points of the poses `own` move by a step, rms [m], and the standard deviation of that. What
    the background swallows of the step moves nothing."""
    seen, half = result.model.problem.seen[own], half_of(S, length)
    at_points = np.matmul(columns[own, : 3 * seen.shape[1]], half).reshape(*seen.shape, 3, -1)[seen]
    moved = at_points @ (half.T @ u)
    rms, std = (float(np.sqrt((by**2).sum() / len(moved))) for by in (moved, at_points))
    return rms, std


def moved_by(result: Fit, step: AtOnce) -> float:
    """How far the points of the poses after it move by a step, beside all that a fit has, rms [m]."""
    if step not in result.model.effects:  # what brings nothing on poses held out is no part of it any more
        result = refit(result, [*result.model.effects, step])
    model, seen = result.model, result.model.problem.seen
    values = result.state.values[model.effects.index(step)]
    moved = model.effect_jacobian(result.line, step, values)[:, : 3 * seen.shape[1]] @ values
    moved = moved.reshape(*seen.shape, 3)[seen & (step.after(model.problem) > 0)]
    return float(np.sqrt((moved**2).sum() / len(moved)))


def _scatter(result: Fit, gain: float) -> float:
    """χ² per degree of freedom that a step must stand out of, at least 1: what it leaves, where it takes most
    of what is beyond the noise; else all, as an unknown effect is no step. What a model lacks is the same in
    repeats of a joint position: as many of them are one look at it."""
    dof, position = effective_dof(result), result.model.problem.positions
    count = np.bincount(position)
    sums = np.zeros((len(count), result.point_residual.shape[1]))
    np.add.at(sums, position, result.point_residual)
    shared = float((sums**2 / count[:, None]).sum())
    looks = result.point_rows * len(count) / len(position) - (result.point_rows - dof)
    return max(_left_by(gain, result.chi2, dof), _left_by(gain, shared, max(looks, 1.0)))


def _left_by(gain: float, chi2: float, dof: float) -> float:
    every, left = chi2 / dof, (chi2 - gain) / dof
    return max(1.0, left if left - 1.0 < (1.0 - MOST) * (every - 1.0) else every)


def _beside_joints(result: Fit, step: Array) -> float:
    """Statistic of a step when smooth functions of joints, stiffness, payload, warmth and sag are taken out
    first; where these are as many as the data, each up to many times its usual size.

    Poses measured joint by joint, load by load, or while the arm warms up, would else let their errors look
    like a step.
    """
    problem = result.model.problem
    every = [*_of_one_joint(problem), *_of_load(problem), *_of_time(problem)]
    smooth = [result.whitened(e) * [p.typical for p in e.params] for e in every]
    return _beside(result, step, [*smooth, sag(result)], held=MANY * problem.coarse)


def _beside(result: Fit, step: Array, smooth: Sequence[Array], held: float = np.inf) -> float:
    """Statistic of a step (N, D, 6) when other columns are taken out first; where these are as many as the
    data each up to about `held` times, and none where they may be without end."""
    n = sum(columns.shape[2] for columns in smooth)
    room = 0.6 * result.point_rows - result.J.shape[2]
    if room < (n if held == np.inf else 0):
        return 0.0
    S, u, own = reduce_columns(result, np.concatenate([*smooth, step], axis=2))
    if n > room:
        S[np.arange(n), np.arange(n)] += held**-2.0
    length = np.sqrt(np.maximum(own, 1e-12 * own.max()))  # what moves nothing stays nothing
    S, u = S / np.outer(length, length), u / length
    size, axes = np.linalg.eigh(S[:n, :n])
    half = axes[:, size > SURVIVES] / np.sqrt(size[size > SURVIVES])  # what the background swallows is noise
    across = half.T @ S[:n, n:]
    left, rest = S[n:, n:] - across.T @ across, u[n:] - across.T @ (half.T @ u[:n])
    return quadratic(left, rest, np.ones(step.shape[2]))[0]


def _of_one_joint(problem: Problem) -> list[Effect]:
    """Smooth functions of single joints, of each cause the first form; and functions without a name."""
    kinds = [kind for kind in catalogue().values() if kind.smooth and kind.needs(problem) is None]
    smooth = {e.key: e for kind in kinds for e in reversed(kind.sites(problem))}
    return [*smooth.values(), *(e for e in unnamed(problem) if e.variant in ("tilt", "torque", "side"))]


def _of_load(problem: Problem) -> list[Effect]:
    """What a change of load does: payloads, and joints that yield to them."""
    loads = problem.campaign.payload_names
    every = [e for kind in catalogue().values() if kind.needs(problem) is None for e in kind.sites(problem)]
    return [e for e in every if e.where.payload in loads or (e.always and e.axial)]


def _of_time(problem: Problem) -> list[Effect]:
    """How an arm, or what it stands on, moves smoothly as it warms up: by a law, which no step is part of."""
    kinds = [kind for kind in catalogue().values() if kind.acts == "geometry" and kind.needs(problem) is None]
    every = [e for kind in kinds for e in kind.sites(problem)]
    return [e for e in every if e.lasting and e.uses & {"time", "temperature"}]


def _creeping(result: Fit, columns: Array, own: NDArray[np.int64]) -> float:
    """The most that motions columns: (N, R, 6) of the poses `own` take off χ² where they creep to rest in
    the order of measurement: what is fast at first looks like an early step."""
    base, order, gains = np.matmul(result.whitener, columns), np.zeros(len(columns)), []
    order[own] = np.arange(len(own), dtype=float)
    for share in (SOONEST, *SHARES):
        S, u, length = reduce_columns(result, base * share_gone(order, share * len(own))[:, None, None])
        gains.append(quadratic(S, u, length)[0])
    return max(gains)


def split_setup(problem: Problem, first: int) -> Problem:
    """The problem with the poses from `first` on, of its set-up, in one of their own."""
    c = problem.campaign
    return replace(problem, campaign=split_campaign(c, first, int(c.poses.setup[first])))


def _frame_and_targets(about: Array, axes: Array) -> Array:
    """(N, T, 3, 6 + 3 T) how points move by a translation [m] and a turn [rad] of the frame, and by the
    targets' places [m]. about: (N, T, 3) [m] the points, about the frame's origin; axes: (N, T, 3, 3) of the
    targets' places."""
    J = np.zeros((*about.shape, 6 + 3 * about.shape[1]))
    J[..., :6] = body_jacobian(about)
    for i in range(about.shape[1]):
        J[:, i, :, 6 + 3 * i : 9 + 3 * i] = axes[:, i]
    return J
