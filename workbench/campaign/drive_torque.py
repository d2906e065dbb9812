"""Torques of the drives as a second witness: they show loads that positions hide behind geometry.

What a drive exerts holds the load's torque, times a motor constant that is known to a few percent, plus
friction and an offset. So per joint an offset, a scale and the friction of its side of approach are taken
out, and what is left is compared: a compensator that has lost charge changes the torque, an eccentric gear
does not. Cables, the motor's cogging and a sensor's crosstalk go with the joint's angle: what is no larger
than the torques are accurate, and does, is no load. What the columns mean at all is asked in
`torque_columns`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array

if TYPE_CHECKING:
    from .problem import Problem

SHOWS = 0.5  # share of a joint's torque that the model must explain for the column to be believed
FEWEST = 10  # torques of a joint from which its noise is taken
ROUNDS = 2  # of a load's size and what it leaves
ACCURACY = 0.03  # of a joint's largest torque: motor currents, friction, and masses in the model
SMOOTH = 4  # functions of the joint's own angle that such an error may have, in half cycles over its range
WIDE = 1e3  # usual sizes of a load that nothing holds
TILT = 5e-3  # rad: how far the axis of a joint may lie from the model's
LEAST = 1e-6  # N·m, N: of a joint without any load


@dataclass(frozen=True, eq=False)
class Drive:
    """What a joint's drive makes of its own over the k poses where its torque was measured (`seen`). taken:
    (k, r) an orthonormal basis of offset, scale and friction; by_angle: (k, m) directions of smooth functions
    of the joint's own angle beside these; size: (m,) how large they may be, over the noise."""

    seen: NDArray[np.int64]
    taken: Array
    by_angle: Array
    size: Array

    def left_of(self, values: Array) -> Array:
        """(k, p) values of these poses without what is taken out, and of what goes with the angle as much as
        may be a load.

        Errors Z that go with the angle beside noise σ have the covariance σ² (I + Z Zᵀ) = σ² (I + U s² Uᵀ),
        whose inverse root is (I − U (1 − (1 + s²)^-½) Uᵀ) / σ.
        """
        part = values - self.taken @ (self.taken.T @ values)
        less = (1 - (1 + self.size**2) ** -0.5)[:, None]
        return np.asarray(part - self.by_angle @ (less * (self.by_angle.T @ part)))


def drives(problem: Problem) -> list[Drive]:
    """Of each joint; the scale is that of the nominal arm's torques. `Problem.own_of_drives` keeps them."""
    measured = problem.campaign.poses.torque
    assert measured is not None
    expected = problem.arm.own(problem.nominal_load.local)
    found = []
    for j in range(measured.shape[1]):
        seen = np.flatnonzero(np.isfinite(measured[:, j]))
        B = np.column_stack([own_of_drive(problem, j), expected[:, j]])[seen]
        B = B / np.maximum(np.linalg.norm(B, axis=0), 1e-12)
        left, size, _ = np.linalg.svd(B, full_matrices=False)
        Q = left[:, size > 1e-9]
        by_angle = _by_own_angle(problem.q[seen, j], measured[seen, j], expected[seen, j], Q)
        found.append(Drive(seen, Q, *by_angle))
    return found


def _by_own_angle(q: Array, torque: Array, expected: Array, Q: Array) -> tuple[Array, Array]:
    """(k, m) directions of smooth functions of a joint's angle q (k,) beside what is taken out, Q: (k, r);
    and (m,) how large they may be, over the noise. torque, expected: (k,) as measured, as by the model."""
    if len(q) <= Q.shape[1] + SMOOTH or np.ptp(q) == 0:
        return np.zeros((len(q), 0)), np.zeros(0)
    turn = np.pi * (q - q.min()) / np.ptp(q)
    Z = np.cos(turn[:, None] * np.arange(1, SMOOTH + 1)) * (2 / SMOOTH) ** 0.5
    U, size, _ = np.linalg.svd(Z - Q @ (Q.T @ Z), full_matrices=False)
    rest = torque - Q @ (Q.T @ torque)
    rest -= U @ (U.T @ rest)
    noise = float(np.sqrt(rest @ rest / (len(q) - Q.shape[1] - SMOOTH)))
    off = ACCURACY * float(np.abs(expected).max())
    return U, size * (off / noise if LEAST < noise < off else 1.0)


def project(problem: Problem, values: Array) -> Array:
    """(N, n, p) values without what each joint's drive may make of its own (`Drive`); zero where no torque
    was measured."""
    out = np.zeros_like(values)
    for j, drive in enumerate(problem.own_of_drives):
        out[drive.seen, j] = drive.left_of(values[drive.seen, j])
    return out


def own_of_drive(problem: Problem, j: int) -> Array:
    """(N, 1 or 3) what joint j's drive has without a load's help: an offset and, where the side of approach
    is known, friction: Coulomb's, and the share of the load that a gear adds to it."""
    side = problem.campaign.poses.side
    if side is None:
        return np.ones((len(problem.q), 1))
    signed = side[:, j].astype(float)
    load = np.abs(problem.arm.own(problem.nominal_load.local)[:, j])
    return np.column_stack([np.ones(len(signed)), signed, signed * load])


def axis_error(problem: Problem) -> Array:
    """(n,) [N·m, N] torque (RMS) that the stated loads make at each joint if its axis is off by `TILT`: no
    model of the torques is better, and at a vertical axis there is hardly any other."""
    slot, component = np.divmod(problem.arm.axial, 6)
    load = problem.nominal_load.local.reshape(len(problem.q), -1, 2, 3)
    own = load[:, slot, component // 3]
    return np.asarray(TILT * np.sqrt((own**2).sum(axis=2).mean(axis=0)) + LEAST)


def scatter(problem: Problem, moved: Array | None = None, largest: float = np.inf) -> Array:
    """(n,) [N·m, N] RMS of what the model leaves of each joint's torques, not less than `axis_error`;
    infinite where there are fewer than `FEWEST`.

    moved: (N, n, p) what a wrong load makes of the torques, as `project` leaves it, taken out as far as one
    size of it explains all joints, and not below the torques' `ACCURACY`; nothing of it where it would have
    to be larger than `largest`.
    """
    measured = problem.campaign.poses.torque
    assert measured is not None
    seen, least = np.isfinite(measured), axis_error(problem)
    known = np.nan_to_num(measured)
    left = project(problem, known[..., None])[..., 0]
    enough = seen.sum(axis=0) >= FEWEST
    free = np.maximum(seen.sum(axis=0) - [drive.taken.shape[1] for drive in problem.own_of_drives], 1)
    rms = np.maximum(np.sqrt((left**2).sum(axis=0) / free), least)
    least = np.maximum(least, np.minimum(rms, ACCURACY * np.abs(known).max(axis=0)))
    if moved is None:
        return np.where(enough, rms, np.inf)
    found, held = rms, np.eye(moved.shape[2]) / min(largest, WIDE)
    for _ in range(ROUNDS):
        columns = np.concatenate([(moved / found[:, None])[:, enough].reshape(-1, len(held)), held])
        wanted = np.concatenate([(left / found)[:, enough].ravel(), np.zeros(len(held))])
        size = np.linalg.lstsq(columns, wanted, rcond=None)[0]
        found = np.maximum(np.sqrt(((left - moved @ size) ** 2).sum(axis=0) / free), least)
    if np.abs(size).max(initial=0.0) <= largest:
        rms = found
    return np.where(enough, rms, np.inf)


def shown(rms: Array, total: Array) -> Array:
    """(n,) whether columns of that scatter are believed, of which the model leaves `rms` [N·m, N]."""
    return np.asarray(rms**2 < (1 - SHOWS) * total**2)
