"""Prediction of a campaign and its analytic Jacobian, all effects included.

One chain rule for everything. Let d be the motions that do not depend on load, y the motions of the
slots that yield, Q the wrenches: y = φ(Q(d + y)). Then with H = ∂Q/∂motion and Φ = ∂φ/∂Q,

    dy = (I − Φ H_yy)⁻¹ (Φ (H_yd dd + H_yg dg + dQ) + dφ)

which is the exact compliance derivative (K − ∂τ/∂θ)⁻¹ for axial springs, and every effect is a dd
(transmission, temperature, drift), a dφ (stiffness, bending, tilt) or a dQ (payload, compensator).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..campaign import drive_torque
from ..campaign.problem import Problem
from ..effects.acting import Acting
from ..effects.base import Effect
from ..effects.given import Given
from ..robot.equilibrium import equilibrium
from ..robot.kinematics import Arm, Array, Frames, frames, point_jacobian
from ..robot.loads import Loads, Wrenches, wrenches
from ..robot.rotations import body_jacobian, from_vectors
from ..robot.wrench_jacobian import wrench_jacobian


@dataclass(frozen=True)
class State:
    """Everything that a fit changes. K set-ups, T targets, S slots.

    geometry: (S, 6) corrections [m, rad]; R: (K, 3, 3), t: (K, 3) [m] base frame in the instrument's;
    targets: (K, T, 3) [m] in the frames behind their slots; values: one (p,) per effect of the model;
    given: (g,) the model's given numbers, empty where they are as they were said.
    """

    geometry: Array
    R: Array
    t: Array
    targets: Array
    values: tuple[Array, ...] = ()
    given: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Prediction:
    """A campaign as a state predicts it.

    base: (N, T, 3) points in the robot's base frame, true: (N, T, 3) in the instrument's, points: (N, T, 3)
    as the instrument shows them [m]; motion: (N, S, 6) all slot motions. arm, loads, where: what they were
    computed from; bears: the wrenches, None where nothing yields.
    """

    arm: Arm
    loads: Loads
    motion: Array
    where: Frames
    bears: Wrenches | None
    base: Array
    true: Array
    points: Array

    @cached_property
    def load(self) -> Wrenches:
        """The wrenches at the slots."""
        return wrenches(self.arm, self.where, self.loads) if self.bears is None else self.bears


@dataclass(frozen=True)
class View:
    """How points that move are seen: on the slots `on`, turned (N, 3, 3) into the instrument's frame, shown
    by it as `shows` (N, T, 3, 3) says (None: as they are); drives: rows of torques behind the points'."""

    on: tuple[int, ...]
    turn: Array
    shows: Array | None
    drives: int

    def true(self, prediction: Prediction, axes: Array, origin: Array) -> Array:
        """(N, 3T, 6S) motions of the true points by motions along axes (N, S, 6, 3) about (N, S, 3)."""
        motions = point_jacobian(axes, origin, prediction.base, self.on, self.turn)
        return motions.reshape(len(motions), -1, motions.shape[3])

    def shown(self, motions: Array) -> Array:
        """(N, R, ·) what the instrument and the drives show of motions (N, 3T, ·) of the true points: of the
        drives nothing."""
        if self.shows is not None:
            each = self.shows @ motions.reshape(*self.shows.shape[:2], 3, -1)
            motions = np.asarray(each).reshape(motions.shape)
        if not self.drives:
            return motions
        return np.concatenate([motions, np.zeros((len(motions), self.drives, motions.shape[2]))], axis=1)


@dataclass(frozen=True)
class Linearisation:
    """Derivatives of the points (N, T, 3) in the instrument's frame at a state.

    Where drive torques were recorded, n rows for them follow the 3T rows of the points: R = 3T + n; only
    loads move them. geometry: (N, R, 6S) by corrections G; torque: (N, R, E) by the local wrenches `rows`;
    answer: (N, E, E) motion of these rows at rest by the change that their wrenches ask for first; frame:
    (N, R, 6) by shift and turn of the instrument frame about `centre`; target: (N, T, 3, 3) by the targets'
    places; loaded: what `direct` is where anything yields.
    """

    prediction: Prediction
    view: View
    loaded: Array | None
    geometry: Array
    torque: Array
    rows: NDArray[np.int64]
    answer: Array
    frame: Array
    target: Array
    centre: Array

    @cached_property
    def direct(self) -> Array:
        """(N, R, 6S) by slot motions, load's answer included."""
        if self.loaded is not None:
            return self.loaded
        where = self.prediction.where
        return self.view.shown(self.view.true(self.prediction, where.axes, where.origin))

    @property
    def by_joint(self) -> Array:
        """(N, 3T, n) motion of the points by each joint's own motion."""
        return self.direct[:, : 3 * self.target.shape[1], self.prediction.arm.axial]

    def precondition(self, change: Array) -> Array:
        """(N, S, 6) Newton step to where the arm rests, of the change that its wrenches ask for now."""
        out = change.reshape(len(change), -1).copy()
        out[:, self.rows] = np.matmul(self.answer, out[:, self.rows, None])[..., 0]
        return out.reshape(change.shape)


@dataclass(frozen=True)
class Model:
    """A problem with the effects that act in it: `effects` with the state's values, and `known` ones
    with values of their own, which no fit changes (those of a model.toml); `given`: numbers known by other
    means, which a fit changes within their spread."""

    problem: Problem
    effects: tuple[Effect, ...] = ()
    known: tuple[tuple[Effect, Array], ...] = ()
    given: tuple[Given, ...] = ()

    def given_values(self, state: State) -> Array:
        """(g,) the given numbers at a state."""
        return state.given if len(state.given) else np.array([item.value for item in self.given])

    def acting(self, state: State) -> Acting:
        """All effects with their values at a state."""
        given = [(item.effect, v[None]) for item, v in zip(self.given, self.given_values(state), strict=True)]
        return Acting((*self.known, *given, *zip(self.effects, state.values, strict=True)))

    def start(self, R: Array, t: Array, targets: Array) -> State:
        """State with the robot's own geometry and all effects at zero."""
        values = tuple(np.zeros(len(effect.params)) for effect in self.effects)
        return State(self.problem.arm.geometry, R, t, targets, values)

    def in_base(self) -> State:
        """The same seen by instruments that stand in the base frame, targets where they are stated."""
        stated, setups = self.problem.stated_targets, len(self.problem.campaign.setup_names)
        R, t = np.tile(np.eye(3), (setups, 1, 1)), np.zeros((setups, 3))
        return self.start(R, t, np.tile(stated, (setups, 1, 1)))

    def loaded(self, state: State, near: Linearisation | None = None) -> Prediction:
        """Loaded poses and points; `near`, at a state that is almost the same, saves time."""
        problem, acting = self.problem, self.acting(state)
        direct = acting.direct(problem)
        arm, loads = acting.loads(problem, problem.arm.with_geometry(state.geometry))
        yielding, load = acting.yielding(arm), None
        if not yielding.columns.any():
            motion, where = direct, frames(arm, problem.q, direct)
        elif near is None:
            motion, where, load = equilibrium(arm, problem.q, direct, loads, yielding.motion)
        else:
            start, precondition = near.prediction.motion, near.precondition
            motion, where, load = equilibrium(
                arm, problem.q, direct, loads, yielding.motion, near=start, preconditioner=precondition
            )
        base = self._place(where, state)
        true = self._see(base, state)
        return Prediction(arm, loads, motion, where, load, base, true, acting.seen(problem, true))

    def predict(self, state: State) -> Array:
        """Points (N, T, 3) [m] as the instrument would see them."""
        return self.loaded(state).points

    def _place(self, where: Frames, state: State) -> Array:
        on, setup = self.problem.on, self.problem.campaign.poses.setup
        if len(state.targets) == 1:
            return where.points(state.targets[0], on)
        every = np.stack([where.points(targets, on) for targets in state.targets])
        return np.asarray(every[setup, np.arange(len(setup))])

    def _see(self, base: Array, state: State) -> Array:
        setup = self.problem.campaign.poses.setup
        return np.einsum("nij,ntj->nti", state.R[setup], base) + state.t[setup][:, None]

    def linearise(self, state: State, near: Linearisation | None = None) -> Linearisation:
        """Derivatives at a state; `near` as for `loaded`: saves time, changes nothing."""
        return self.linearised(state, self.loaded(state, near))

    def linearised(self, state: State, prediction: Prediction) -> Linearisation:
        """Derivatives at a state of which the prediction is known."""
        acting = self.acting(state)
        arm, where = prediction.arm, prediction.where
        turn = state.R[self.problem.campaign.poses.setup]
        view = View(tuple(self.problem.on), turn, acting.sight(self.problem), self.problem.drives)
        G = view.true(prediction, where.geometry_axes, where.geometry_origin)
        yielding = acting.yielding(arm)
        rows, J = np.flatnonzero(yielding.columns), None
        torque: Array = np.zeros((*G.shape[:2], len(rows)))
        answer: Array = np.zeros((len(G), len(rows), len(rows)))
        if len(rows):
            load, J = prediction.load, view.true(prediction, where.axes, where.origin)
            Phi = yielding.slope(load.local)[1]
            args = (arm, where, prediction.loads, load, rows)
            H = wrench_jacobian(*args, where.axes, where.origin, before_joint=False)
            H_g = wrench_jacobian(*args, where.geometry_axes, where.geometry_origin, before_joint=True)
            answer = np.asarray(np.linalg.inv(np.eye(len(rows)) - Phi @ H[:, :, rows]))
            torque = J[:, :, rows] @ (answer @ Phi)
            J += torque @ H
            G += torque @ H_g
        frame, target, centre = self._frame_and_target(state, prediction, turn)
        if view.shows is not None:
            target = view.shows @ target
        if J is not None:
            J = view.shown(J)
        G, torque, frame = (view.shown(X) for X in (G, torque, frame))
        return Linearisation(prediction, view, J, G, torque, rows, answer, frame, target, centre)

    def _frame_and_target(
        self, state: State, prediction: Prediction, turn: Array
    ) -> tuple[Array, Array, Array]:
        setup = self.problem.campaign.poses.setup
        n_poses, n_targets = prediction.points.shape[:2]
        centre = np.zeros((len(state.R), 3))  # anywhere, of a set-up without poses: part of the data
        for k in np.unique(setup).tolist():
            centre[k] = prediction.true[setup == k].mean(axis=(0, 1))
        frame = body_jacobian(prediction.true - centre[setup][:, None])
        target = np.empty((n_poses, n_targets, 3, 3))
        for i, k in enumerate(self.problem.on):
            target[:, i] = turn @ prediction.where.R[k]
        return frame.reshape(n_poses, 3 * n_targets, 6), target, centre

    def drive_residual(self, line: Linearisation, state: State) -> Array:
        """(N, n) measured torques of the drives that the loads do not explain [N·m, N]."""
        measured = self.problem.campaign.poses.torque
        assert measured is not None
        left = drive_torque.project(self.problem, np.nan_to_num(measured)[..., None])[..., 0]
        for effect, values in self.acting(state).those(lambda effect: effect.acts == "load"):
            left = left - self.effect_jacobian(line, effect, values)[:, -self.problem.drives :] @ values
        return left

    def effect_jacobian(self, line: Linearisation, effect: Effect, values: Array) -> Array:
        """(N, R, p) motion of the points (and drive torques) per unit of each parameter of an effect.

        The effect need not be in the model: then this is what adding it would do.
        """
        return effect.jacobian(self.problem, line, values)


def move_frame(state: State, setup: int, centre: Array, change: Array) -> State:
    """The state with one set-up's frame shifted and turned about `centre` by change (6,)."""
    turn = from_vectors(change[3:])
    R, t = state.R.copy(), state.t.copy()
    R[setup] = turn @ R[setup]
    t[setup] = turn @ (t[setup] - centre) + centre + change[:3]
    return replace(state, R=R, t=t)
