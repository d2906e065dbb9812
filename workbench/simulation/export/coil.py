"""The coil spring that comes nearest to a compensator, for formats that know no gas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...robot.compensator import CompensatorLaw
from ...robot.kinematics import frames
from ...robot.schema import Compensator
from .content import Content

SHORTEST = 1e-3  # m: a spring's free length has to be positive


def nearest_coil(content: Content) -> CompensatorLaw | None:
    """Least squares in force over the pivots' travel within the joint's limits; a coil spring is itself."""
    law = content.compensator
    if law is None:
        return None
    if law.coil is not None:
        rate, free = law.coil
    else:
        arm, joint = content.arm, content.robot.joint(law.data.joint)
        q = np.zeros((200, arm.n))
        q[:, arm.names.index(joint.name)] = np.linspace(
            max(joint.lower, -np.pi), min(joint.upper, np.pi), 200
        )
        s = law.ends(frames(arm, q))[2]
        force = law.force(s)[0]
        rate, offset = np.polyfit(s, force, 1)
        free = -offset / rate if rate > 0 else 0.0
        if free < SHORTEST:
            free = SHORTEST
            rate = float((force @ (s - free)) / ((s - free) @ (s - free)))
    data = Compensator(
        kind="spring", joint=law.data.joint, body=law.data.body, arm=law.data.arm,
        body_pivot=law.data.body_pivot, arm_pivot=law.data.arm_pivot,
        rate=float(rate), free_length=float(free), exponent=1.0,
    )  # fmt: skip
    return replace(law, data=data, charge=1.0, preload=0.0)
