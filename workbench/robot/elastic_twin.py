"""The elastic twin at work: its Context, Drake's generalised forces there, and where they vanish."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces, RevoluteSpring
from pydrake.systems.framework import Context, Diagram

from .compensator import CompensatorLaw
from .equilibrium import NoRest
from .extended_robot.cylinder import add_applied
from .force_systems import Cylinder, SlotSprings
from .kinematics import Arm, Array
from .loads import Loads
from .plant_diagram import applied_wrench
from .plant_parts import link_inertia, point_inertia, slot_pose
from .plants import ArmPlant
from .schema import GEOMETRY
from .yielding import Yielding


@dataclass(frozen=True, eq=False)
class ElasticTwin:
    """A robot in Drake with everything that yields; `elastic_plant.elastic_twin` builds it.

    root: Context of the whole `diagram`. joints: (slot, component) → the joint that moves there; motors:
    names of the motor joints, base to flange. springs: Drake's, where the Context has their stiffness; laws,
    cylinder: the systems at the plant's ports. All joints have one degree of freedom.
    """

    arm: Arm
    built: ArmPlant
    diagram: Diagram
    root: Context
    joints: dict[tuple[int, int], str]
    motors: tuple[str, ...]
    yielding: Yielding
    springs: dict[tuple[int, int], RevoluteSpring]
    laws: SlotSprings | None
    compensator: CompensatorLaw | None
    cylinder: Cylinder | None

    @property
    def plant(self) -> MultibodyPlant:
        return self.built.plant

    @cached_property
    def context(self) -> Context:
        """The plant's own part of the Context."""
        return self.plant.GetMyMutableContextFromRoot(self.root)

    @cached_property
    def columns(self) -> NDArray[np.int64]:
        """Columns 6 · slot + component that have a joint."""
        return np.array([6 * slot + component for slot, component in self.joints])

    def set_geometry(self, geometry: Array) -> None:
        """Writes the corrections G of joints and flange: (S, 6) into the Context."""
        for slot in range(1, self.arm.slots):
            X = slot_pose(self.arm, slot, geometry[slot])
            self.built.corrected[slot].SetPoseInParentFrame(self.context, X)

    def set_masses(self, arm: Arm) -> None:
        """Writes the masses and centres of mass of base and links into the Context."""
        for slot in range(arm.n + 1):
            inertia = link_inertia(arm, slot)
            self.built.bodies[slot].SetSpatialInertiaInBodyFrame(self.context, inertia)

    def set_payload(self, mass: float, moment: Array) -> None:
        """Mass [kg] and mass times centre of mass (3,) [kg·m] of tool and payload, flange frame."""
        self.built.bodies[-1].SetSpatialInertiaInBodyFrame(self.context, point_inertia(mass, moment))

    def set_loads(self, loads: Loads) -> None:
        """Payload, wrench, joint torques and the compensator's charge of one pose (N = 1). Raises ValueError
        for another coil or another gas than the twin was built with."""
        self.set_payload(float(loads.mass[0]), loads.moment[0])
        force = np.zeros(self.plant.num_velocities())
        for at in (self._motors_at, self._axial_at):
            force[at] += loads.torque[0]
        self.diagram.GetInputPort("joint_force").FixValue(self.root, force)
        wrench = applied_wrench(self.built.bodies[-1], loads.wrench[0])
        self.diagram.GetInputPort("wrench").FixValue(self.root, [wrench])
        if (law := loads.compensator) is not None and self.cylinder is not None:
            if law.data != self.cylinder.law.data:
                raise ValueError("the elastic twin was built with another gas")
            charge = float(np.mean(law.charge))
            self.cylinder.set_charge(
                self.cylinder.GetMyMutableContextFromRoot(self.root), charge, law.preload
            )
        elif law is not None and (self.compensator is None or self.compensator.coil != law.coil):
            raise ValueError("the elastic twin was built with another compensator")

    def equilibrium(self, q: Array, direct: Array, loads: Loads) -> Array:
        """Where Drake's generalised forces vanish in one pose: slot motions (S, 6). The plant stays in it.

        q: (n,) commanded; direct: (S, 6) motions without load, at which the springs are slack; `loads` of
        one pose (N = 1). Each round the wrench of the springs takes up what Drake's forces leave, and the
        batch law says where that moves the slots. Raises NoRest where the arm finds no rest.
        """
        self._refuse_without_joint(direct)
        self.set_loads(loads)
        self._set_rest(direct)
        shape = (1, self.arm.slots, 6)
        wrench, motion, last = np.zeros(shape), direct.copy(), np.inf
        yields, at = self._yields, self._yields_at
        for _ in range(60):
            self._near(wrench[0])
            self.set_motion(q, motion, direct)
            wrench.reshape(-1)[yields] += self.forces()[at]
            new = direct + self.yielding.motion(wrench)[0]
            step = float(np.abs(new - motion).max())
            motion = new
            if step < 1e-14 or (step < 1e-10 and step > 0.5 * last):  # as still as rounding allows
                self._near(wrench[0])
                self.set_motion(q, motion, direct)
                return motion
            last = step
        raise NoRest

    def forces(self) -> Array:
        """(V,) Drake's generalised forces at the present place: weight, force elements, all at the ports."""
        plant, context = self.plant, self.context
        sum_ = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, sum_)
        add_applied(plant, context, sum_, plant.get_applied_spatial_force_input_port().Eval(context))
        at_port: Any = plant.get_applied_generalized_force_input_port().Eval(context)
        return np.asarray(plant.CalcGeneralizedForces(context, sum_) + at_port)

    def drive_torque(self) -> Array:
        """(n,) torques [N·m, N] with which the drives hold the present pose."""
        return -self.forces()[self._motors_at]

    def set_motion(self, q: Array, motion: Array, direct: Array) -> None:
        """Commanded joints (n,) and slot motions (S, 6). Of a joint's own motion the part that load does not
        make (`direct`, (S, 6)) sits in its motor, the rest in its spring."""
        self._refuse_without_joint(motion)
        gear = direct.reshape(-1)[self.arm.axial]
        positions: Any = np.empty(self.plant.num_positions())
        positions[self._motors_at] = q + gear
        positions[self._joints_at] = motion.reshape(-1)[self.columns]
        positions[self._axial_at] -= gear
        self.plant.SetPositions(self.context, positions)

    def points(self, targets: Array, on: Sequence[int]) -> Array:
        """Places of targets (T, 3) behind slots `on` at the present pose: (T, 3) [m]."""
        plant, context, world = self.plant, self.context, self.plant.world_frame()
        frames = [self.built.slots[k] for k in on]
        return np.array(
            [
                plant.CalcPointsPositions(context, frame, target, world)[:, 0]
                for frame, target in zip(frames, targets, strict=True)
            ]
        )

    def _set_rest(self, direct: Array) -> None:
        """Writes into the Context where the springs are slack."""
        positions = np.zeros(self.plant.num_positions())
        positions[self._joints_at] = direct.reshape(-1)[self.columns]
        positions[self._axial_at] = 0.0
        for spring in self.springs.values():
            spring.SetNominalAngle(self.context, positions[spring.joint().position_start()])
        if self.laws is not None:
            self.laws.set_rest(self.laws.GetMyMutableContextFromRoot(self.root), positions)

    def _near(self, wrench: Array) -> None:
        """Tells the springs' laws near which wrenches (S, 6) theirs are."""
        for spring in () if self.laws is None else self.laws.springs:
            spring.near = wrench[spring.slot, spring.components]

    @cached_property
    def _joints_at(self) -> NDArray[np.int64]:
        """Place of the joints at `columns` in positions and velocities."""
        return self._at(tuple(self.joints.values()))

    @cached_property
    def _motors_at(self) -> NDArray[np.int64]:
        return self._at(self.motors)

    @cached_property
    def _axial_at(self) -> NDArray[np.int64]:
        """Place of each joint's own spring joint."""
        return self._at(tuple(self.joints[divmod(int(column), 6)] for column in self.arm.axial))

    @cached_property
    def _yields(self) -> NDArray[np.int64]:
        """Columns that give way."""
        return np.flatnonzero(self.yielding.columns)

    @cached_property
    def _yields_at(self) -> NDArray[np.int64]:
        """Their place in positions and velocities."""
        return self._at(tuple(self.joints[divmod(int(column), 6)] for column in self._yields))

    def _at(self, joints: tuple[str, ...]) -> NDArray[np.int64]:
        places = [self.plant.GetJointByName(name).position_start() for name in joints]
        return np.array(places, dtype=np.int64)

    def _refuse_without_joint(self, motion: Array) -> None:
        rest = motion.reshape(-1).copy()
        rest[self.columns] = 0.0
        if rest.any():
            slot, component = divmod(int(np.flatnonzero(rest)[0]), 6)
            raise ValueError(f"the elastic twin was built without {GEOMETRY[component]} at slot {slot}")
