"""What SDF cannot say, and the drives, as one system."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import LeafSystem

from .cylinder import add_pull, between, gas_force, pulled
from .gears import Curve, Erring, add_forces, add_up

ROUNDS = 8  # from a joint back to its drive: each leaves a gear's slope of what is left
BANDWIDTH = 2 * np.pi * 5.0  # rad/s of the drives' position loops, critically damped


class Effects(LeafSystem):
    """Drives that hold the weight, errors of the gears with their reaction, gas compensator, hoses.

    Behind the gear of a joint that yields is a spring, and the plant's joint is the drive. A rigid joint has
    its gear's error in it: the drive is where `drives` says.
    """

    def __init__(self, plant: MultibodyPlant, effects: Any) -> None:
        super().__init__()
        self.set_name("effects")
        self.plant, self.scratch, self.forces = plant, plant.CreateDefaultContext(), MultibodyForces(plant)
        names = [str(name) for name in effects["joints"]]
        self.n, self.size = len(names), plant.num_velocities()
        self.motors = np.array([plant.GetJointByName(name).position_start() for name in names])
        self.springs = [self._place(f"{name}_spring") for name in names]
        self.gears, self.hoses = (_curves(effects, kind) for kind in ("gear/", "torque/"))
        self.rigid = [gear for gear in self.gears if self.springs[gear.joint] < 0]
        sprung = sorted({gear.joint for gear in self.gears} - {gear.joint for gear in self.rigid})
        self.erring = [self._erring(j, effects) for j in sprung]
        self.gas: Any = tuple(effects["gas"].tolist()) if "gas" in effects.files else None
        if self.gas is not None:
            self.bodies = [plant.GetBodyByName(str(name)) for name in effects["gas_bodies"]]
            self.pivots = effects["gas_pivots"]
        self.flange = plant.GetFrameByName(str(effects["flange"]))
        self.inertia = np.diag(plant.CalcMassMatrix(self.scratch))[self.motors]
        self._state = self.DeclareVectorInputPort("plant_state", plant.num_multibody_states())
        self._desired = self.DeclareVectorInputPort("desired_state", 2 * self.n)
        self.DeclareVectorOutputPort("force", self.size, self._force)
        self.DeclareVectorOutputPort("state", 2 * self.n, self._measured)
        pose: Any = Value[RigidTransform]
        forces: Any = Value[list[ExternallyAppliedSpatialForce]]
        tool: Any = self._tool_pose
        gas: Any = self._body_force
        self.DeclareAbstractOutputPort("tool_pose", pose, tool)
        self.DeclareAbstractOutputPort("body_force", forces, gas)

    def joints(self, q: Any, v: Any) -> Any:
        """(2, n) positions and velocities of the plant's joints, of drives at q (n,) that move at v (n,)."""
        at, rate = list(q), list(v)
        for gear, slope in zip(self.rigid, add_up(self.rigid, q, at), strict=True):
            rate[gear.joint] += slope * v[gear.by]
        return np.array([at, rate])

    def drives(self, q: Any, v: Any) -> Any:
        """(2, n) the other way: of the drives, for the plant's joints at q (n,) that move at v (n,)."""
        there = np.array([q, v])
        found = there
        for _ in range(ROUNDS if self.rigid else 0):
            found = found + there - self.joints(*found)
        return found

    def balance(self, positions: Any) -> Any:
        """(V,) all generalised forces at rest: weight, springs, effects; without the drives."""
        plant, scratch, forces = self.plant, self.scratch, self.forces
        plant.SetPositions(scratch, positions)
        plant.CalcForceElementsContribution(scratch, forces)
        if self.gas is not None:
            add_pull(scratch, forces, self.bodies, *self._gas())
        return plant.CalcGeneralizedForces(scratch, forces) + self._effects([*positions, *self.size * [0.0]])

    def _place(self, joint: str) -> int:
        return self.plant.GetJointByName(joint).position_start() if self.plant.HasJointNamed(joint) else -1

    def _erring(self, j: int, effects: Any) -> Erring:
        pairs = [(i, int(self.motors[gear.by])) for i, gear in enumerate(self.gears) if gear.joint == j]
        stiffness, damping = float(effects["stiffness"][j]), float(effects["damping"][j])
        return Erring(j, self.springs[j], stiffness, damping, tuple(pairs))

    def _effects(self, x: list[float]) -> Any:
        """(V,) generalised forces of gears and hoses at states x [2 V]."""
        force, motors = np.zeros(self.size), self.motors.tolist()
        q, _ = self.drives([x[at] for at in motors], self.n * [0.0]).tolist()
        errors, torques = self.n * [0.0], self.n * [0.0]
        slopes = add_up(self.gears, q, errors)
        add_forces(self.erring, x, errors, slopes, force)
        add_up(self.hoses, q, torques)
        for at in (motors, self.springs):
            for place, torque in zip(at, torques, strict=True):
                if place >= 0:
                    force[place] += torque
        return force

    def _gas(self) -> tuple[Any, Any, Any, float]:
        """Poses of the two bodies and pivots where the scratch Context stands, the way between, the pull."""
        area, charge, preload, *column = self.gas
        poses = [body.EvalPoseInWorld(self.scratch) for body in self.bodies]
        way = between(poses, self.pivots)
        gas, _, air = gas_force(float(np.linalg.norm(way)), area, *column)
        return poses, self.pivots, way, charge * gas + air + preload

    def _force(self, context: Any, output: Any) -> None:
        x: Any = self._state.Eval(context)
        desired: Any = self._desired.Eval(context)
        q, v = x[: self.size][self.motors], x[self.size :][self.motors]
        hold = -self.balance(x[: self.size])[self.motors]
        place, rate = self.joints(desired[: self.n], desired[self.n :])
        wanted = BANDWIDTH**2 * (place - q) + 2 * BANDWIDTH * (rate - v)
        force = self._effects(x.tolist())
        force[self.motors] += hold + self.inertia * wanted
        output.SetFromVector(force)

    def _body_force(self, context: Any, output: Any) -> None:
        x: Any = self._state.Eval(context)
        self.plant.SetPositions(self.scratch, x[: self.size])
        gas = self.gas is not None
        output.set_value(pulled([body.index() for body in self.bodies], *self._gas()[1:]) if gas else [])

    def _measured(self, context: Any, output: Any) -> None:
        x: Any = self._state.Eval(context)
        drives = self.drives(x[: self.size][self.motors], x[self.size :][self.motors])
        output.SetFromVector(drives.ravel())

    def _tool_pose(self, context: Any, output: Any) -> None:
        x: Any = self._state.Eval(context)
        self.plant.SetPositions(self.scratch, x[: self.size])
        output.set_value(self.flange.CalcPoseInWorld(self.scratch))


def _curves(effects: Any, kind: str) -> list[Curve]:
    """The curves of a kind, with the joints that their names say."""
    found = []
    for key in effects.files:
        if key.startswith(kind):
            _, joint, by, _ = key.split("/")
            found.append(Curve(int(joint), int(by), effects[key]))
    return found
