"""The robot that is exported, as `verify` simulates it: the same plant from the same parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...robot.compensator import CompensatorLaw
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.yielding import Yielding
from ..closed_loop.drives import drives
from ..closed_loop.machine import Machine, machine
from ..closed_loop.mechanics import Give, Mechanics, springs_of
from .coil import nearest_coil
from .content import Content
from .tree import Tree, tree_of

GEAR = frozenset({"gear"})


@dataclass(frozen=True, eq=False)
class Simulated:
    """The plant that `verify` would simulate, and what of it no file states."""

    machine: Machine
    gives: tuple[Give, ...]
    assumed: tuple[str, ...]

    def tree(self, robot: Robot) -> Tree:
        """It, as file formats have it."""
        return tree_of(robot, self.machine.built, self.machine.drakes)


def simulated(content: Content, compensator: CompensatorLaw | None) -> Simulated:
    """The plant with what yields in proportion to its load, and with this compensator."""
    robot, arm = content.robot, content.arm
    axial, gives = springs_of(arm, Yielding(content.compliance), set())
    mass, moment = content.payload
    parts = Mechanics(
        robot=robot,
        arm=arm,
        gives=gives,
        axial=axial,
        placed=np.zeros((1, arm.slots, 6)),
        mass=mass,
        moment=moment,
        wrench=np.zeros((1, 6)),
        torque=np.zeros((1, arm.n)),
        compensator=compensator,
        gear=content.acting(GEAR),
        notes=(),
        stated=content.payload,
    )
    drive = drives(parts, _middle(content), robot.loop)
    return Simulated(machine(parts, drive), gives, drive.assumed)


def elastic_tree(content: Content) -> Tree:
    """For formats that know no gas: with the coil spring that comes nearest to the compensator."""
    return simulated(content, nearest_coil(content)).tree(content.robot)


def assumed(content: Content) -> list[str]:
    """What the elastic robot had to assume, a line each."""
    return [f"assumed: {line}" for line in simulated(content, None).assumed]


def _middle(content: Content) -> Array:
    """(n,) joints in the middle of their ranges, where inertias are taken that are not stated."""
    ends = np.clip(content.robot.limits, -np.pi, np.pi)
    return np.asarray(ends.mean(axis=1))
