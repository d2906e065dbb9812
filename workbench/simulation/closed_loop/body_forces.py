"""What pulls at the robot's bodies through Drake's ports: the compensator, the process force."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import Context

from ...robot.extended_robot.cylinder import add_applied
from ...robot.force_systems import Cylinder
from ...robot.kinematics import Array
from ...robot.loop import Loop
from ...robot.plant_diagram import applied_wrench
from .machine import Machine


class BodyForces:
    """The forces on bodies of a machine's diagram, as generalised forces (V,).

    root: Context of the diagram. wrench: (K, 6) of the process, a row per step; charge: (K,) of the
    compensator; None where there is none. A coil spring is no force on bodies: the plant itself has it.
    """

    def __init__(
        self, machine: Machine, root: Context, loop: Loop, wrench: Array | None, charge: Array | None
    ) -> None:
        self.machine, self.plant, self.root = machine, machine.plant, root
        self.context = self.plant.GetMyContextFromRoot(root)
        self.wrench, self.charge = wrench, charge
        self.pushed: Array | None = None
        none: Any = np.zeros(self.plant.num_velocities())
        machine.diagram.GetInputPort("joint_force").FixValue(root, none)
        self.port = machine.diagram.GetInputPort("wrench")
        self.port.FixValue(root, [])
        self.forces = MultibodyForces(self.plant)
        self.gas = None if machine.cylinder is None else _Gas(machine.cylinder, machine, root, loop)

    @property
    def active(self) -> bool:
        """Whether there are any."""
        return self.wrench is not None or self.gas is not None

    def at(self, k: int, since: float | None) -> Array:
        """(V,) at the plant's present place, in step k; since: [s] after the call before, None: at rest."""
        if self.wrench is not None:
            self._push(self.wrench[k])
        if self.gas is not None:
            self.gas.charge(None if self.charge is None else float(self.charge[k]), since)
        self.forces.SetZero()
        applied = self.plant.get_applied_spatial_force_input_port().Eval(self.context)
        add_applied(self.plant, self.context, self.forces, applied)
        return np.asarray(self.plant.CalcGeneralizedForces(self.context, self.forces))

    def _push(self, wrench: Array) -> None:
        """Puts the process force (6,) on the port, where it is another than before."""
        if self.pushed is None or (wrench != self.pushed).any():
            self.port.FixValue(self.root, [applied_wrench(self.machine.built.bodies[-1], wrench)])
            self.pushed = wrench


class _Gas:
    """The cylinder's charge, and the heat of its gas: a fast stroke heats it, and the heat leaves."""

    def __init__(self, cylinder: Cylinder, machine: Machine, root: Context, loop: Loop) -> None:
        self.cylinder, self.machine, self.loop = cylinder, machine, loop
        self.own = cylinder.GetMyMutableContextFromRoot(root)
        self.context = machine.plant.GetMyContextFromRoot(root)
        data = cylinder.law.data
        self.faster = max(loop.gas_exponent - data.exponent, 0.0) if data.kind == "gas" else 0.0
        self.heat, self.length = 0.0, 0.0

    def charge(self, charge: float | None, since: float | None) -> None:
        """Sets it for the present place; None: the law's own."""
        charge = float(np.mean(self.cylinder.law.charge)) if charge is None else charge
        warmed = self._warmed(since) if self.faster else 0.0
        self.cylinder.set_charge(self.own, charge * (1 + warmed), self.cylinder.law.preload)

    def _warmed(self, since: float | None) -> float:
        """Relative surplus of the gas's temperature."""
        data = self.cylinder.law.data
        assert data.gas_length is not None
        assert data.reference is not None
        length = data.gas_length - (self.cylinder.distance(self.machine.plant, self.context) - data.reference)
        if since is not None:
            self.heat -= (
                self.faster * (length - self.length) / length + since / self.loop.gas_time * self.heat
            )
        self.length = length
        return self.heat
