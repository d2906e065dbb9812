"""Inverse kinematics of the nominal rigid arm, many poses at a time: Newton with analytic Jacobians."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Arm, Array, Frames, frames
from ..robot.rotations import cross, pose, vectors

DAMPING = 1e-4  # of a joint motion, relative to the arm's length: only felt at a singularity
TURN_DAMPING = 0.02  # likewise, of turns that come second to the place: they are not had at any cost
STEP = 0.3  # rad, or of the arm's length: the longest step of any joint
REACHED_WITHIN = 1e-11  # m
JACOBIAN_ROUNDS = 5  # rounds that one Jacobian serves
PLACE_ROUNDS = 10  # the last ones, in which an arm of 3 rows that does not rest turns the tool no more


@dataclass(frozen=True, eq=False)
class Tip:
    """The tool on the flange, and how much of its pose the arm can serve.

    R: (3, 3), p: (3,) [m] tool in the flange frame. rows: 6, or 3 where an arm cannot turn it every way: it
    follows the place, and with the freedom that is left the orientation as near as it can (a SCARA's turn
    about the vertical, say). length: [m] that a rad counts, about a third of the arm's reach.
    """

    R: Array
    p: Array
    rows: int
    length: float

    def place(self, where: Frames) -> tuple[Array, Array]:
        """Tool rotations (K, 3, 3) and positions (K, 3) [m]."""
        R = where.R[-1]
        return R @ self.R, where.p[-1] + R @ self.p

    def pose(self, where: Frames) -> Array:
        """(K, 4, 4)."""
        R, p = self.place(where)
        return pose(p, R)

    def error(self, where: Frames, X: Array) -> Array:
        """(K, 6) from the tool to the wanted pose X: way [m] and turn [rad], base frame."""
        R, p = self.place(where)
        out = np.empty((len(p), 6))
        out[:, :3] = X[:, :3, 3] - p
        out[:, 3:] = vectors(X[:, :3, :3] @ R.transpose(0, 2, 1))
        return out

    def scaled(self, error: Array) -> Array:
        """(K, 6) [m]: turns count with `length`."""
        return np.concatenate([error[:, :3], self.length * error[:, 3:]], axis=1)

    def left(self, arm: Arm, scaled: Array, step: Array) -> Array:
        """(K,) [m] that the arm can still take off the scaled error (K, 6); step: (K, n) [rad, m] that its
        joints would go for it."""
        off = np.abs(scaled[:, : self.rows]).max(axis=1)
        if self.rows == 6:
            return np.asarray(off)
        return np.maximum(off, np.abs(np.where(arm.prismatic, 1.0, self.length) * step).max(axis=1))

    def jacobian(self, arm: Arm, where: Frames) -> Array:
        """(K, 6, n) [m]: of the scaled error, per rad or, of a sliding joint, per `length`."""
        slots = np.arange(1, arm.n + 1)
        axis = where.axes[:, slots, arm.axial % 6]
        p = self.place(where)[1]
        J = np.empty((len(p), arm.n, 6))
        J[..., :3] = cross(axis, p[:, None] - where.origin[:, slots])
        J[..., 3:] = self.length * axis
        J[:, arm.prismatic, :3] = self.length * axis[:, arm.prismatic]
        J[:, arm.prismatic, 3:] = 0.0
        return J.transpose(0, 2, 1)

    def gain(self, arm: Arm, J: Array, turn: bool = True) -> Array:
        """(K, n, 6) joint motion [rad, m] per scaled error [m]: the damped inverse, of least norm; of 3
        rows that of the place, and, with what moves no place, of the `turn`."""
        inverse = damped_inverse(J[:, : self.rows], DAMPING * self.length)
        if self.rows < 6:
            free = np.eye(arm.n) - inverse @ J[:, :3]
            turned = turn * free @ damped_inverse(J[:, 3:] @ free, TURN_DAMPING * self.length)
            inverse = np.concatenate([inverse - turned @ J[:, 3:] @ inverse, turned], axis=2)
        inverse[:, arm.prismatic] *= self.length
        return inverse


def damped_inverse(J: Array, damping: float) -> Array:
    """(K, n, m): Jᵀ (J Jᵀ + λ²)⁻¹ of (K, m, n); of fewer joints than rows (Jᵀ J + λ²)⁻¹ Jᵀ."""
    m, n = J.shape[1:]
    JT = J.transpose(0, 2, 1)
    square = J @ JT if m <= n else JT @ J
    np.einsum("kii->ki", square)[...] += damping**2
    inverse = np.linalg.inv(square)
    return np.asarray(JT @ inverse if m <= n else inverse @ JT)


def limited(arm: Arm, tip: Tip, step: Array) -> Array:
    """Steps (K, n), shortened where a joint would go too far at once."""
    size = np.abs(step) / np.where(arm.prismatic, tip.length, 1.0)
    return np.asarray(step / np.maximum(size.max(axis=1) / STEP, 1.0)[:, None])


def newton(
    arm: Arm, tip: Tip, X: Array, q: Array, rounds: int = 30, refresh: int = JACOBIAN_ROUNDS
) -> tuple[Array, NDArray[np.bool_]]:
    """Joints (K, n) that put the tool on X: (K, 4, 4), from the guess q, and which of them do."""
    q = q.copy()
    active = np.arange(len(q))
    gain = np.zeros((len(q), arm.n, 6))
    there = np.zeros(len(q), dtype=bool)
    for count in range(rounds):
        where = frames(arm, q[active])
        error = tip.scaled(tip.error(where, X[active]))
        if count % refresh == 0:
            gain = tip.gain(arm, tip.jacobian(arm, where), count < rounds - PLACE_ROUNDS)
        there[active] = np.abs(error[:, : tip.rows]).max(axis=1) <= REACHED_WITHIN
        step = np.einsum("kij,kj->ki", gain, error)
        far = tip.left(arm, error, step) > REACHED_WITHIN
        active, gain, step = active[far], gain[far], step[far]
        if not len(active):
            break
        q[active] += limited(arm, tip, step)
    return q, there
