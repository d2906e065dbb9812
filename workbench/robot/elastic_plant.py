"""The elastic twin: the robot in Drake with everything that yields, and with what pulls on it.

At every slot it has a frame for the geometric correction and small joints for what moves there; at every
joint also a motor joint with the rotor's inertia, and a spring joint. What yields is a spring that acts:

    a component by itself              RevoluteSpring, PrismaticSpring
    coupled ones, and laws not linear  `SlotSprings` at the plant's port
    a compensator's coil               LinearSpringDamper between its pivots
    a compensator's gas                `Cylinder` at the plant's port

What calibration and causes change (frame poses, masses, stiffness, rest angles, charge) lives in the Context.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, RevoluteSpring

from .compensator import CompensatorLaw
from .description import Robot
from .elastic_twin import ElasticTwin
from .force_systems import SlotSpring, SlotSprings
from .kinematics import RX, Arm
from .plant_diagram import cylinder_of, plant_diagram
from .plant_parts import add_rotor, add_spring, axial_joint, component_joint
from .plants import ArmPlant, arm_plant
from .schema import GEOMETRY
from .yielding import Yielding, own_yielding

Place = tuple[int, int]


def elastic_twin(
    arm: Arm,
    robot: Robot,
    yielding: Yielding | None = None,
    moved: Sequence[Place] = (),
    compensator: CompensatorLaw | None = None,
) -> ElasticTwin:
    """Builds the elastic twin of an arm.

    yielding: what gives way; default: the arm's own compliance. moved: the (slot, component) pairs that
    move without load; the axial joints are always there. compensator: what pulls beside the weight.
    """
    yielding = own_yielding(arm) if yielding is None else yielding
    moving = _Moving(arm, robot, yielding, set(moved))
    built = arm_plant(arm, moving.at_slot, compensator=compensator)
    laws, cylinder = moving.laws(built), cylinder_of(built, arm, compensator)
    diagram = plant_diagram(built.plant, laws, cylinder)
    return ElasticTwin(
        arm=arm,
        built=built,
        diagram=diagram,
        root=diagram.CreateDefaultContext(),
        joints=moving.joints,
        motors=tuple(moving.motors),
        yielding=yielding,
        springs=moving.springs,
        laws=laws,
        compensator=compensator,
        cylinder=cylinder,
    )


class _Moving:
    """What moves at the slots: small joints, then motor and spring; and which joint is which."""

    def __init__(self, arm: Arm, robot: Robot, yielding: Yielding, moved: set[Place]) -> None:
        self.arm, self.robot, self.yielding = arm, robot, yielding
        self.wanted = moved | {divmod(int(column), 6) for column in np.flatnonzero(yielding.columns)}
        self.joints: dict[Place, str] = {}
        self.motors: list[str] = []
        self.springs: dict[Place, RevoluteSpring] = {}
        self.coupled = [slot for slot in range(arm.slots) if self._needs_law(slot)]

    def at_slot(self, plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        arm, name = self.arm, self.arm.slot_names[slot]
        axial = int(arm.axial[slot - 1]) % 6 if 1 <= slot <= arm.n else None
        for component, key in enumerate(GEOMETRY):
            if component != axial and (slot, component) in self.wanted:
                free = component_joint(plant, f"{name}_{key}", frame, component)
                self._sprung(plant, (slot, component), free)
                frame = free.child_body().body_frame()
        if axial is None:
            return frame
        data = self.robot.joint(name).data
        motor = axial_joint(plant, arm, slot, f"{name}_motor", frame)
        add_rotor(plant, motor, data.rotor_inertia, data.gear_ratio or 1.0)
        self.motors.append(motor.name())
        spring = axial_joint(
            plant, arm, slot, f"{name}_spring", motor.child_body().body_frame(), data.damping
        )
        self._sprung(plant, (slot, axial), spring)
        return spring.child_body().body_frame()

    def laws(self, built: ArmPlant) -> SlotSprings | None:
        """The springs of the slots whose law is no element of Drake's."""
        springs = []
        for slot in self.coupled:
            mine = np.flatnonzero(self.yielding.columns.reshape(-1, 6)[slot])
            at = [built.plant.GetJointByName(self.joints[slot, int(c)]).position_start() for c in mine]
            springs.append(SlotSpring(self.yielding, slot, mine, np.array(at)))
        plant = built.plant
        return SlotSprings(springs, plant.num_multibody_states(), plant.num_velocities()) if springs else None

    def _needs_law(self, slot: int) -> bool:
        C = self.yielding.linear[slot]
        shifts = [c for c in range(RX) if C[c, c] and not self._axial(slot, c)]  # their rest is no parameter
        bent = any(where == slot for where, _, _ in self.yielding.bent)
        return bool(bent or shifts or (C - np.diag(np.diag(C))).any() or (np.diag(C) < 0).any())

    def _axial(self, slot: int, component: int) -> bool:
        return 1 <= slot <= self.arm.n and int(self.arm.axial[slot - 1]) % 6 == component

    def _sprung(self, plant: MultibodyPlant, place: Place, joint: Joint) -> None:
        """Notes the joint of a place; gives it its spring where Drake has one."""
        self.joints[place] = joint.name()
        slot, component = place
        compliance = self.yielding.linear[slot, component, component]
        if slot not in self.coupled and compliance > 0:
            spring = add_spring(plant, joint, 1 / compliance)
            if isinstance(spring, RevoluteSpring):
                self.springs[place] = spring
