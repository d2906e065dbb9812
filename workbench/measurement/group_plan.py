"""Configurations for a joint's compliance at several angles of it, chosen for a test pose.

At each angle a few configurations under a hanging load, and one pulled from the side: gravity makes no torque
about an upright first axis, so a plan without it leaves that joint's compliance unknown and the criterion,
eq. (18) of Klimchik et al. (2017), infinite.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..campaign import Campaign, Target
from ..campaign.planned import random_poses
from ..robot.description import Robot
from ..robot.kinematics import Array
from .design import criterion, exchange
from .load_pairs import Load, difference_rows, pairs

GRAVITY = 9.80665  # m/s²
FEW = 100  # configurations at each angle to choose from where the forces are chosen as well
RANDOMS = 300  # plans drawn at random, to compare with


@dataclass(frozen=True)
class Rig:
    """What is measured and how: markers, hanging load, its sideways pull (3,) [N], tool; sigma of a reading
    [m]; limits: joint → largest angle [rad] either way, where the instrument still sees the tool."""

    targets: Sequence[Target]
    load: Load
    sideways: Array
    tool: Load
    sigma: float
    limits: Mapping[str, float]

    def rows(self, robot: Robot, q: Array, pull: Array) -> Array:
        """(C, 3T, n) whitened rows of loaded minus unloaded, for configurations q: (C, n), pull: (3,) [N]."""
        plan = pairs(robot, q, self.load, np.tile(pull, (len(q), 1)), self.targets, self.tool)
        return difference_rows(plan) / (np.sqrt(2) * self.sigma)

    def moved(self, robot: Robot, q: Array, force: Array) -> Array:
        """(3, n) [m] how the first target moves in a pose q (n,) under a force (3,) [N] at the load's place,
        per unit of each joint's compliance over the model's."""
        plan = pairs(robot, q[None], self.load, force[None], self.targets, self.tool)
        return difference_rows(plan)[0, :3]

    def held(self, robot: Robot, name: str, angle: float) -> Robot:
        """The robot with one joint held at an angle [rad] and the others within the limits."""
        joints = []
        for joint in robot.joints:
            most = self.limits.get(joint.name, np.inf)
            lower, upper = max(joint.lower, -most), min(joint.upper, most)
            if joint.name == name:
                lower, upper = angle - 1e-9, angle + 1e-9
            joints.append(replace(joint, lower=lower, upper=upper))
        return replace(robot, joints=tuple(joints))


@dataclass(frozen=True)
class GroupPlan:
    """The pairs of all groups. rho0 [m]: eq. (18), summed over the groups; random: (R,) [m] the same of plans
    drawn at random from the same candidates; hanging: rho0 without any pull from the side; any_force: rho0
    where the force of each configuration is chosen as well."""

    campaign: Campaign
    rho0: float
    random: Array
    hanging: float
    any_force: float


def group_plan(
    robot: Robot,
    joint: str,
    angles: Array,
    counts: Sequence[int],
    rig: Rig,
    A0: Array,
    candidates: int,
    seed: int,
) -> GroupPlan:
    """The plan for `counts` configurations at `angles` (M,) of a joint. A0: (3, n) motion of the tool at the
    test pose under its force, per unit of each compliance [m]."""
    rng = np.random.default_rng([seed, 0])
    chosen: list[Array] = []
    pulls: list[Array] = []
    squares, random, hanging, free = 0.0, np.zeros(RANDOMS), 0.0, 0.0
    forces = rig.load[0] * GRAVITY * np.vstack([np.eye(3), -np.eye(3)])
    for angle, count in zip(angles, counts, strict=True):
        q = random_poses(rig.held(robot, joint, angle), candidates, rng, floor=0.4, clear=0.6)
        down, aside = rig.rows(robot, q, np.zeros(3)), rig.rows(robot, q, rig.sideways)
        side = int(np.argmax((aside[:, :, 0] ** 2).sum(axis=1)))
        best, rho = exchange(down, A0, count - 1, prior=aside[side].T @ aside[side], starts=3, seed=seed)
        chosen += [*q[best], q[side]]
        pulls += [np.zeros(3)] * (count - 1) + [rig.sideways]
        squares += rho**2
        hanging += criterion(down, A0) ** 2
        pulled = np.concatenate([rig.rows(robot, q[:FEW], force) for force in forces])
        free += exchange(pulled, A0, count, starts=1, seed=seed)[1] ** 2
        for i in range(RANDOMS):
            some, one = rng.choice(candidates, count - 1, replace=False), rng.integers(candidates)
            random[i] += criterion(down[some], A0, aside[one].T @ aside[one]) ** 2
    title = f"{robot.title}, {len(chosen)} configurations before and after loading"
    plan = pairs(robot, np.array(chosen), rig.load, np.array(pulls), rig.targets, rig.tool, title)
    roots = (float(np.sqrt(total)) for total in (squares, hanging, free))
    rho0, without, any_force = roots
    return GroupPlan(plan, rho0, np.sqrt(random), without, any_force)
