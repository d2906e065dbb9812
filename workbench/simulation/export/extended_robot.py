"""The extended robot for Drake: `AddExtendedRobot(builder)`. It needs pydrake and NumPy alone.

Beside this file stand the robot as SDF (springs, rotors, coil compensator), `package.xml`, the model
directives, and `effects.npz` with what SDF cannot say: gas compensator, gears' errors, hoses' torques.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.trajectories import PiecewisePolynomial

BANDWIDTH = 2 * np.pi * 5.0  # rad/s of the drives' position loops, critically damped
ATMOSPHERE = 101325.0  # Pa


HERE = Path(__file__).resolve().parent


def AddExtendedRobot(builder: DiagramBuilder, folder: Path = HERE) -> Diagram:
    """Adds the robot, its drives and its effects as one diagram, and returns it.

    Input `desired_state` (2n,): positions, then velocities [rad, m] of the n joints. Outputs `state` (2n,)
    of the drives, `tool_pose` of the flange, and `query_object` for a visualizer. `Settle` brings it to rest.
    """
    inner = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(inner, 0.0)
    effects = np.load(folder / "effects.npz")
    name = str(effects["name"])
    parser = Parser(plant)
    parser.package_map().Add(name, folder)
    parser.AddModels(folder / f"{name}.dmd.yaml")
    plant.mutable_gravity_field().set_gravity_vector(effects["gravity"])
    plant.Finalize()
    plant.set_name("plant")
    drives = inner.AddSystem(Effects(plant, effects))
    inner.Connect(plant.get_state_output_port(), drives.GetInputPort("plant_state"))
    inner.Connect(drives.GetOutputPort("force"), plant.get_applied_generalized_force_input_port())
    inner.ExportInput(drives.GetInputPort("desired_state"), "desired_state")
    for port in ("state", "tool_pose"):
        inner.ExportOutput(drives.GetOutputPort(port), port)
    inner.ExportOutput(scene.get_query_output_port(), "query_object")
    robot = inner.Build()
    robot.set_name(name)
    builder.AddSystem(robot)
    return robot


def Settle(robot: Diagram, context: Context, q: Any) -> None:
    """Puts the robot to rest at joints q (n,) under its loads. context: of the whole diagram."""
    plant: Any = robot.GetSubsystemByName("plant")
    effects: Any = robot.GetSubsystemByName("effects")
    own = plant.GetMyMutableContextFromRoot(context)
    positions = np.zeros(plant.num_positions())
    positions[effects.motors] = q
    free = np.setdiff1d(np.arange(plant.num_positions()), effects.motors)
    for _ in range(20):
        plant.SetPositions(own, positions)
        left = effects.balance(positions)[free]
        slope = np.empty((len(free), len(free)))
        for i, at in enumerate(free):
            there = positions.copy()
            there[at] += 1e-6
            slope[:, i] = (effects.balance(there)[free] - left) / 1e-6
        step = np.linalg.solve(slope, left) if len(free) else left
        positions[free] -= step
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    plant.SetPositions(own, positions)
    plant.SetVelocities(own, np.zeros(plant.num_velocities()))


class Effects(LeafSystem):
    """Drives that hold the weight, errors of the gears with their reaction, gas compensator, hoses."""

    def __init__(self, plant: MultibodyPlant, effects: Any) -> None:
        super().__init__()
        self.set_name("effects")
        self.plant, self.scratch, self.forces = plant, plant.CreateDefaultContext(), MultibodyForces(plant)
        names = [str(name) for name in effects["joints"]]
        self.n = len(names)
        self.motors = np.array([plant.GetJointByName(name).position_start() for name in names])
        self.springs = np.array([self._place(f"{name}_spring") for name in names])
        self.stiffness, self.damping = effects["stiffness"], effects["damping"]
        self.gears = [_Curve(effects, key) for key in effects.files if key.startswith("gear/")]
        self.hoses = [_Curve(effects, key) for key in effects.files if key.startswith("torque/")]
        self.gas: Any = effects["gas"] if "gas" in effects.files else None
        if self.gas is not None:
            self.bodies = [plant.GetBodyByName(str(name)) for name in effects["gas_bodies"]]
            self.pivots = effects["gas_pivots"]
        self.flange = plant.GetFrameByName(str(effects["flange"]))
        M = plant.CalcMassMatrix(self.scratch)
        self.inertia = np.diag(M)[self.motors]
        self._state = self.DeclareVectorInputPort("plant_state", plant.num_multibody_states())
        self._desired = self.DeclareVectorInputPort("desired_state", 2 * self.n)
        self.DeclareVectorOutputPort("force", plant.num_velocities(), self._force)
        self.DeclareVectorOutputPort("state", 2 * self.n, self._measured)
        pose: Any = Value[RigidTransform]
        tool: Any = self._tool_pose
        self.DeclareAbstractOutputPort("tool_pose", pose, tool)

    def balance(self, positions: Any) -> Any:
        """(V,) all generalised forces at rest: weight, springs, effects; without the drives."""
        self.plant.SetPositions(self.scratch, positions)
        self.plant.CalcForceElementsContribution(self.scratch, self.forces)
        return self.plant.CalcGeneralizedForces(self.scratch, self.forces) + self._effects(positions)

    def _place(self, joint: str) -> int:
        return self.plant.GetJointByName(joint).position_start() if self.plant.HasJointNamed(joint) else -1

    def _effects(self, positions: Any, velocities: Any = None) -> Any:
        """(V,) generalised forces of gears, hoses and gas; the scratch Context stands at the positions."""
        force = np.zeros(len(positions))
        velocities = np.zeros(len(positions)) if velocities is None else velocities
        q, v = positions[self.motors], velocities[self.motors]
        error, rate = np.zeros(self.n), np.zeros(self.n)
        for gear in self.gears:
            error[gear.joint] += gear.value(q)
            rate[gear.joint] += gear.slope(q) * v[gear.other]
        for j in np.flatnonzero(error).tolist():
            force[self.springs[j]] += self.stiffness[j] * error[j] + self.damping[j] * rate[j]
        for gear in self.gears:  # the motor feels what turns the gear's error
            j = gear.joint
            at = self.springs[j]
            pull = self.stiffness[j] * (positions[at] - error[j])
            pull += self.damping[j] * (velocities[at] - rate[j])
            force[self.motors[gear.other]] += gear.slope(q) * pull
        for hose in self.hoses:
            torque = hose.value(q)
            force[self.motors[hose.joint]] += torque
            if self.springs[hose.joint] >= 0:
                force[self.springs[hose.joint]] += torque
        return force if self.gas is None else force + self._gas_force()

    def _gas_force(self) -> Any:
        area, charge, preload, precharge, length, reference, exponent = self.gas
        world = self.plant.world_frame()
        X = [body.EvalPoseInWorld(self.scratch) for body in self.bodies]
        ends = [pose @ pivot for pose, pivot in zip(X, self.pivots, strict=True)]
        way = ends[1] - ends[0]
        s = float(np.linalg.norm(way))
        pressure = charge * precharge * (length / (length - (s - reference))) ** exponent
        pull = (area * (pressure - ATMOSPHERE) + preload) / s * way
        self.forces.SetZero()
        for body, pose, pivot, sign in zip(self.bodies, X, self.pivots, (1.0, -1.0), strict=True):
            pair = SpatialForce(tau=np.zeros(3), f=sign * pull)  # type: ignore[arg-type]
            body.AddInForce(self.scratch, pose.rotation() @ pivot, pair, world, self.forces)
        return self.plant.CalcGeneralizedForces(self.scratch, self.forces)

    def _force(self, context: Context, output: Any) -> None:
        x: Any = self._state.Eval(context)
        desired: Any = self._desired.Eval(context)
        half = len(x) // 2
        hold = -self.balance(x[:half])[self.motors]
        q, v = x[:half][self.motors], x[half:][self.motors]
        wanted = BANDWIDTH**2 * (desired[: self.n] - q) + 2 * BANDWIDTH * (desired[self.n :] - v)
        force = self._effects(x[:half], x[half:])
        force[self.motors] += hold + self.inertia * wanted
        output.SetFromVector(force)

    def _measured(self, context: Context, output: Any) -> None:
        x: Any = self._state.Eval(context)
        half = len(x) // 2
        output.SetFromVector(np.concatenate([x[:half][self.motors], x[half:][self.motors]]))

    def _tool_pose(self, context: Context, output: Any) -> None:
        x: Any = self._state.Eval(context)
        self.plant.SetPositions(self.scratch, x[: len(x) // 2])
        output.set_value(self.flange.CalcPoseInWorld(self.scratch))


class _Curve:
    """Something at joint `joint` as a function of joint `other`, from samples."""

    def __init__(self, effects: Any, key: str) -> None:
        _, joint, other, _ = key.split("/")
        self.joint, self.other = int(joint), int(other)
        samples = effects[key]
        self._curve = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(samples[0], samples[1:])
        self._slope = self._curve.derivative()

    def value(self, q: Any) -> float:
        return float(self._curve.value(q[self.other])[0, 0])

    def slope(self, q: Any) -> float:
        return float(self._slope.value(q[self.other])[0, 0])
