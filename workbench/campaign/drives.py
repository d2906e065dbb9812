"""What the drives make of their own of the torques that they record: offsets, scales, friction, and what goes
with the angle of a joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .poses import Array, Poses

ACCURACY = 0.03  # of a joint's largest torque: motor currents, friction, and masses in the model
SMOOTH = 4  # functions of the joint's own angle that such an error may have, in half cycles over its range
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


def drives_of(poses: Poses, expected: Array) -> list[Drive]:
    """Of each joint. expected: (N, n) torques of the nominal arm [N·m, N], whose scale is taken out."""
    measured = poses.torque
    assert measured is not None
    found = []
    for j in range(measured.shape[1]):
        seen = np.flatnonzero(np.isfinite(measured[:, j]))
        B = np.column_stack([own_of_drive(poses, expected, j), expected[:, j]])[seen]
        B = B / np.maximum(np.linalg.norm(B, axis=0), 1e-12)
        left, size, _ = np.linalg.svd(B, full_matrices=False)
        Q = left[:, size > 1e-9]
        by_angle = _by_own_angle(poses.q[seen, j], measured[seen, j], expected[seen, j], Q)
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


def own_of_drive(poses: Poses, expected: Array, j: int) -> Array:
    """(N, 1 or 3) what joint j's drive has without a load's help: an offset and, where the side of approach
    is known, friction: Coulomb's, and the share of the load that a gear adds to it."""
    side = poses.side
    if side is None:
        return np.ones((len(poses), 1))
    signed = side[:, j].astype(float)
    return np.column_stack([np.ones(len(signed)), signed, signed * np.abs(expected[:, j])])
