"""The machines as they are: as the paper models the robot, with a soft gear, with a leak.

What the paper does not give is assumed here; the story says why.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench import (
    Array,
    Robot,
    Truth,
    parse_effect,
    planned,
    problem_of,
    random_geometry,
)

from .compensator import GAS

SIGMA = 3e-5  # m, of a reading, per axis
GEAR, SOFT_ZONE, SOFT_TORQUE = 0.23e-6, float(np.radians(0.5 / 60)), 500.0  # rad/(N·m), rad, N·m
LEAK = 0.15  # of the charge
MACHINES = {"gas": "Gas spring alone", "soft": "Soft gear", "leak": f"Leak, {100 * LEAK:.0f} % of the charge"}


def machines(robot: Robot, seed: int) -> dict[str, Truth]:
    """As the paper models it; with a soft gear in joint 2; with a leak; and two without noise."""
    problem = problem_of(planned(robot, np.zeros((1, 6))))
    usual = Truth(geometry=random_geometry(problem.arm, np.random.default_rng([seed, 1])), sigma=SIGMA)

    def soft_zone(wrench: Array) -> Array:
        x = wrench[5] / SOFT_TORQUE
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, SOFT_ZONE * x / np.sqrt(1 + x**2)])

    nominal = 1 / (robot.joints[1].data.stiffness or np.inf)
    stiffer = parse_effect(f"joint_compliance:joint=joint_2,relative={GEAR / nominal - 1}", problem)
    soft = replace(usual, effects=(stiffer,), yields={2: soft_zone})
    less_charged = GAS, np.array([-1 / 6])
    return {
        "gas": usual,
        "soft": soft,
        "leak": replace(usual, effects=((GAS, np.array([-LEAK])),)),
        "exact": replace(usual, sigma=1e-9),
        "soft_less_charged": replace(soft, effects=(stiffer, less_charged), sigma=1e-9),
    }


def true_compliances(robot: Robot) -> Array:
    """(11,) as Table I lists them, of a gear that is the same at all angles."""
    k = np.array([1 / (joint.data.stiffness or np.inf) for joint in robot.joints])
    return np.array([k[0], *[k[1]] * 6, *k[2:]])
