"""What pulls at the robot's bodies: the compensator's gas, the process force.

In a Diagram they act at Drake's ports (`plant_diagram`). Here they are computed by the same functions without
the way through the ports, on which every body's pose would go to Python and back.
"""

from __future__ import annotations

import math

import numpy as np
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import Context

from ...robot.extended_robot.cylinder import add_applied, add_pull, between
from ...robot.force_systems import Cylinder
from ...robot.kinematics import Array
from ...robot.loop import Loop
from ...robot.plant_diagram import applied_wrench
from .machine import Machine


class BodyForces:
    """The forces on bodies of a machine, as generalised forces (V,).

    context: of its plant. wrench: (K, 6) of the process, a row per step; charge: (K,) of the compensator;
    None where there is none. A coil spring is no force on bodies: the plant itself has it.
    """

    def __init__(
        self, machine: Machine, context: Context, loop: Loop, wrench: Array | None, charge: Array | None
    ) -> None:
        self.machine, self.plant, self.context = machine, machine.plant, context
        self.wrench, self.charge = wrench, charge
        self.forces = MultibodyForces(self.plant)
        self.gas = None if machine.cylinder is None else _Gas(machine.cylinder, machine, loop)

    @property
    def active(self) -> bool:
        """Whether there are any."""
        return self.wrench is not None or self.gas is not None

    def at(self, k: int, since: float | None) -> Array:
        """(V,) at the plant's present place, in step k; since: [s] after the call before, None: at rest."""
        self.forces.SetZero()
        if self.wrench is not None:
            pushed = [applied_wrench(self.machine.built.bodies[-1], self.wrench[k])]
            add_applied(self.plant, self.context, self.forces, pushed)
        if self.gas is not None:
            charge = None if self.charge is None else float(self.charge[k])
            self.gas.add(self.context, charge, since, self.forces)
        return np.asarray(self.plant.CalcGeneralizedForces(self.context, self.forces))


class _Gas:
    """The cylinder's pull, and the heat of its gas: a fast stroke heats it, and the heat leaves."""

    def __init__(self, cylinder: Cylinder, machine: Machine, loop: Loop) -> None:
        law = self.law = cylinder.law
        self.charge, self.pivots, self.loop = float(np.mean(law.charge)), cylinder.pivots, loop
        self.bodies = [machine.built.bodies[slot] for slot in (law.body, law.arm)]
        self.faster = max(loop.gas_exponent - law.data.exponent, 0.0) if law.data.kind == "gas" else 0.0
        self.heat, self.length = 0.0, 0.0

    def add(
        self, context: Context, charge: float | None, since: float | None, forces: MultibodyForces
    ) -> None:
        """Adds its forces at the present place; charge None: the law's own."""
        poses = [body.EvalPoseInWorld(context) for body in self.bodies]
        way = between(poses, self.pivots)
        s = math.sqrt(way @ way)
        charge = self.charge if charge is None else charge
        warmed = self._warmed(s, since) if self.faster else 0.0
        pull = self.law.pull(s, charge * (1 + warmed), self.law.preload)
        add_pull(context, forces, self.bodies, poses, self.pivots, way, pull)

    def _warmed(self, s: float, since: float | None) -> float:
        """Relative surplus of the gas's temperature, at pivots s [m] apart."""
        data = self.law.data
        assert data.gas_length is not None
        assert data.reference is not None
        length = data.gas_length - (s - data.reference)
        if since is not None:
            stroke = (length - self.length) / length
            self.heat -= self.faster * (1 + self.heat) * stroke + since / self.loop.gas_time * self.heat
        self.length = length
        return self.heat
