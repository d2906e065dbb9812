"""What gives way under load: compliances of the slots, and laws that are not linear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .kinematics import Arm, Array

Law = Callable[[Array], tuple[Array, Array]]  # wrench (N, 6) → motion (N, 6), its derivative (N, 6, 6)


@dataclass(frozen=True, eq=False)
class Yielding:
    """What yields: linear (S, 6, 6) compliances, and laws of slots that are not linear, each with the
    components that take part."""

    linear: Array
    bent: tuple[tuple[int, tuple[int, ...], Law], ...] = ()

    def motion(self, wrench: Array) -> Array:
        """Motions (N, S, 6) [m, rad] under local wrenches (N, S, 6) [N, N·m]."""
        out = np.matmul(wrench.swapaxes(0, 1), self.linear.swapaxes(1, 2)).swapaxes(0, 1)
        for slot, _, law in self.bent:
            out[:, slot] += law(wrench[:, slot])[0]
        return out

    @property
    def columns(self) -> NDArray[np.bool_]:
        """(6 S,) which components of motion yield at all."""
        some: NDArray[np.bool_] = np.asarray(self.linear.any(axis=1) | self.linear.any(axis=2))
        for slot, components, _ in self.bent:
            some[slot, list(components)] = True
        return some.ravel()

    def slope(self, wrench: Array) -> tuple[NDArray[np.int64], Array]:
        """The components that yield (E), and their derivative by these wrenches (N, E, E)."""
        rows = np.flatnonzero(self.columns)
        slot, component = np.divmod(rows, 6)
        slope = np.broadcast_to(self.linear, (len(wrench), *self.linear.shape))
        if self.bent:
            slope = slope.copy()
        for k, _, law in self.bent:
            slope[:, k] += law(wrench[:, k])[1]
        Phi = slope[:, slot[:, None], component[:, None], component]
        return rows, np.where(slot[:, None] == slot, Phi, 0.0)


def own_compliance(C: Array, k: int) -> float:
    """What of a slot's compliance C (6, 6) is component k's alone: without what the others carry along."""
    others = [c for c in range(6) if c != k]
    coupled = C[k, others] @ np.linalg.pinv(C[np.ix_(others, others)], rcond=1e-9) @ C[others, k]
    return float(C[k, k] - coupled)


def own_yielding(arm: Arm) -> Yielding:
    """The arm's own compliance alone."""
    return Yielding(arm.compliance)
