"""Whether a robot's drives bear its own weight, as its URDF has both."""

from __future__ import annotations

import numpy as np

from ..robot.description import Robot
from .planned import joint_ranges, planned
from .problem import problem_of

POSES = 300


def too_weak(robot: Robot) -> list[str]:
    """A line for each joint whose drive does not bear what the arm weighs in some of its range: placeholders
    for efforts, as many public descriptions have them."""
    lower, upper = joint_ranges(robot)
    q = np.random.default_rng(0).uniform(lower, upper, (POSES, len(lower)))
    problem = problem_of(planned(robot, q))
    most = np.abs(problem.nominal_torque).max(axis=0)
    return [
        f"{robot.urdf}: {joint.name} holds up to {torque:.3g} {unit} of the arm's own weight, but its drive "
        f"bears {joint.effort:.3g} {unit} (effort): `verify` refuses that; state what it bears (0: unknown)"
        for joint, torque in zip(robot.joints, most, strict=True)
        for unit in ("N" if joint.kind == "prismatic" else "N·m",)
        if torque > joint.effort
    ]
