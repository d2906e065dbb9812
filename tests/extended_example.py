"""Robots with known corrections and effects, as a diagnosis would hand them on, for tests of their users."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.effects.backlash import Backlash
from workbench.effects.base import Effect
from workbench.effects.bearing_tilt import BearingTilt
from workbench.effects.gear_eccentricity import GearEccentricity
from workbench.effects.gear_kinematic_error import GearKinematicError
from workbench.effects.gravity_compensator import GravityCompensator
from workbench.effects.hose_torque import HoseTorque
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.link_bending import LinkBending
from workbench.effects.lost_motion import LostMotion
from workbench.effects.payload import Payload
from workbench.effects.place import Where
from workbench.effects.records import record
from workbench.effects.thermal_growth import ThermalGrowth
from workbench.robot.description import Robot, load_robot
from workbench.robot.schema import GEOMETRY

Values = tuple[Effect, list[float]]


def extended(robot: Robot, effects: list[Values], seed: int = 5, size: float = 5e-4) -> Robot:
    """The robot with random corrections of `size` [m, rad] and these effects."""
    rng = np.random.default_rng(seed)
    geometry = {
        name: dict(zip(GEOMETRY, (size * rng.normal(size=6)).tolist(), strict=True))
        for name in robot.joint_names
    }
    records = tuple(record(effect, np.array(values)) for effect, values in effects)
    return replace(robot, geometry=geometry, effects=records)


def extended_kr500(ripple: float = 2e-4, order: float = 200.0) -> Robot:
    """A KR 500 with everything: stiffness, gears, play, soft zone, bearings, link, compensator, payload."""
    robot = load_robot("kr500")
    return extended(
        robot,
        [
            (JointCompliance(Where(joint="joint_3"), nominal=1 / 5.83e6), [0.4]),
            (GearKinematicError(Where(joint="joint_4", order=order)), [ripple, 0.3 * ripple]),
            (GearEccentricity(Where(joint="joint_1"), "1"), [8e-5, -3e-5]),
            (Backlash(Where(joint="joint_2")), [4e-5]),
            (Backlash(Where(joint="joint_5")), [8e-5]),
            (LostMotion(Where(joint="joint_2"), "soft 0.15", torque=1500.0), [6e-5]),
            (BearingTilt(Where(joint="joint_1")), [2e-8]),
            (LinkBending(Where(link="link_2")), [1.5e-8]),
            (GravityCompensator(variant="charge", kind="gas"), [-0.15]),
            (HoseTorque(Where(joint="joint_4")), [30.0]),
            (Payload(Where(payload="heavy"), "mass", mass=250.0, com=(0.15, 0.0, 0.05)), [9.0]),
            (ThermalGrowth(), [1.15e-5]),
        ],
    )
