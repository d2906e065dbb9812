"""Force laws that Drake has no element for, as systems at a plant's ports.

`SlotSprings` are springs whose coordinates are coupled (a link's bending), or whose law is not linear (a soft
gear); `Cylinder` is a compensator of any law. Both act wherever the plant is evaluated or simulated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from .compensator import CompensatorLaw
from .extended_robot.cylinder import between, pulled
from .kinematics import Array
from .yielding import Yielding

ROUNDING = 1e-18  # rad, m: no position tells less apart
RIGID = 1e-16  # rad/(N·m), m/N: what a direction yields in which the slot's own law does not


@dataclass(eq=False)
class SlotSpring:
    """The spring of a slot: its wrench for a motion of m components, by the inverse of what yields there.

    at: (m,) places in positions and velocities. near: a wrench (m,) from which the search begins; it does
    not change what is found.
    """

    yielding: Yielding
    slot: int
    components: NDArray[np.int64]
    at: NDArray[np.int64]
    near: Array = field(init=False)

    def __post_init__(self) -> None:
        self.near = np.zeros(len(self.components))
        C = self.yielding.linear[self.slot][np.ix_(self.components, self.components)]
        size, self._way = np.linalg.eigh(C)
        none = np.abs(size) <= 1e-12 * np.abs(size).max(initial=0.0)
        self._size = np.where(none, RIGID, size)
        self._C = (self._way * self._size) @ self._way.T
        self._laws = [law for slot, _, law in self.yielding.bent if slot == self.slot]

    def wrench(self, motion: Array) -> Array:
        """(m,) [N, N·m] that moves the slot by `motion` (m,). Raises ArithmeticError if none does."""
        if not self._laws:
            return np.asarray(self._way @ ((self._way.T @ motion) / self._size))
        w = self.near
        left, slope = self._left(motion, w)
        if np.abs(left).max() <= ROUNDING:
            return w
        for _ in range(60):
            step = np.linalg.solve(slope, left)
            share = 1.0
            while share > 1e-6:
                there, slope_there = self._left(motion, w + share * step)
                if np.abs(there).max() <= np.abs(left).max():
                    break
                share /= 2
            still = np.abs(there).max() >= 0.5 * np.abs(left).max()
            w, left, slope = w + share * step, there, slope_there
            if still and np.abs(left).max() < 1e-12:
                return w
        raise ArithmeticError("no wrench makes this motion: a yield falls as its load rises")

    def _left(self, motion: Array, w: Array) -> tuple[Array, Array]:
        """What is left of the motion (m,) under a wrench (m,), and the law's slope (m, m)."""
        whole = np.zeros((1, 6))
        whole[0, self.components] = w
        moved, slope = self._C @ w, self._C.copy()
        for law in self._laws:
            more, by_wrench = law(whole)
            moved += more[0, self.components]
            slope += by_wrench[0][np.ix_(self.components, self.components)]
        return motion - moved, slope


class SlotSprings(LeafSystem):
    """Springs at slots. Input `state` of the plant; output `force`, its generalised forces (V,).

    The motions at which they are slack are a parameter of the Context, in the springs' order.
    """

    def __init__(self, springs: Sequence[SlotSpring], n_states: int, n_velocities: int) -> None:
        super().__init__()
        self.springs = tuple(springs)
        self._at = np.concatenate([spring.at for spring in springs])
        self._ends = np.cumsum([len(spring.at) for spring in springs])[:-1]
        self._state = self.DeclareVectorInputPort("state", n_states)
        slack: Any = np.zeros(len(self._at))
        self.DeclareNumericParameter(BasicVector(slack))
        self.DeclareVectorOutputPort("force", n_velocities, self._calc)

    def set_rest(self, context: Context, positions: Array) -> None:
        """Positions of the plant in which the springs are slack."""
        context.get_mutable_numeric_parameter(0).SetFromVector(positions[self._at])

    def _calc(self, context: Context, output: BasicVector) -> None:
        x: Array = self._state.Eval(context)  # type: ignore[assignment]
        motion = x[self._at] - context.get_numeric_parameter(0).get_value()
        force: Any = np.zeros(output.size())
        for spring, part in zip(self.springs, np.split(motion, self._ends), strict=True):
            force[spring.at] -= spring.wrench(part)
        output.SetFromVector(force)


class Cylinder(LeafSystem):
    """A compensator as a pair of forces on the two bodies that carry its pivots.

    Input `body_poses` of the plant; output `force`, a list of two `ExternallyAppliedSpatialForce`.
    Parameters in the Context: charge [1] and preload [N].
    """

    def __init__(self, law: CompensatorLaw, bodies: tuple[RigidBody, RigidBody], pivots: tuple[Array, Array]):
        super().__init__()
        self.law, self.pivots = law, pivots
        self._bodies = tuple(body.index() for body in bodies)
        self._poses = self.DeclareAbstractInputPort("body_poses", Value[list[RigidTransform]]())
        start: Any = [float(np.mean(law.charge)), law.preload]
        self.DeclareNumericParameter(BasicVector(start))
        made: Any = Value[list[ExternallyAppliedSpatialForce]]
        calc: Any = self._calc
        self.DeclareAbstractOutputPort("force", made, calc)

    def set_charge(self, context: Context, charge: float, preload: float) -> None:
        """Charge of the gas (or rate of the spring) over its nominal one, and preload [N]."""
        both: Any = [charge, preload]
        context.get_mutable_numeric_parameter(0).SetFromVector(both)

    def _calc(self, context: Context, output: Any) -> None:
        poses: Any = self._poses.Eval(context)
        charge, preload = context.get_numeric_parameter(0).get_value()
        way = between([poses[int(body)] for body in self._bodies], self.pivots)
        pull = self.law.pull(math.sqrt(way @ way), charge, preload)
        output.set_value(pulled(self._bodies, self.pivots, way, pull))
