"""What a gravity compensator does to its joint, drawn: torque that is left, shift by a lost charge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arm import Array
from ..compensator.gas_spring import linkage
from ..poses import planned
from ..problem import Problem, problem
from ..protocols.load_pairs import Load
from ..report.charts import Series, curves
from ..report.drawing import MIDDLE, Figure
from ..robot import Robot


def compensated_joint(robot: Robot) -> int:
    """Number of the joint that the compensator acts on, from 0."""
    assert robot.compensator is not None
    return robot.joint_names.index(robot.compensator.joint)


def reach(job: Problem, joint: int) -> float:
    """From a joint to the flange in the first pose [m]."""
    return float(np.linalg.norm(job.rigid.p[-1][0] - job.rigid.origin[0, joint + 1]))


def torque_figure(robot: Robot, q: Array, load: Load, tool: Load) -> Figure:
    """Torque on the compensated joint over poses q: (N, n): of the weight alone, and of what is left."""
    joint = compensated_joint(robot)

    def torque(used: Robot, payload: str) -> Array:
        job = problem(planned(used, q, payloads={"load": load}, payload=[payload] * len(q), tool=tool))
        return job.nominal_load.local.reshape(len(q), -1)[:, job.arm.axial[joint]]

    series = {
        "with compensator": Series(1e-3 * torque(robot, "")),
        f"with compensator and {load[0]:.0f} kg": Series(1e-3 * torque(robot, "load")),
        "weight alone": Series(1e-3 * torque(replace(robot, compensator=None), ""), colour=MIDDLE),
    }
    title = f"What the compensator changes is the torque that joint {joint + 1}'s gear works at"
    x = f"joint {joint + 1}, °"
    return curves("torque", title, np.degrees(q[:, joint]), series, x, "torque, arm stretched, kN·m")


def bias_figure(robot: Robot, q: Array, shares: Sequence[float] = (-0.05, -0.1, -0.2)) -> Figure:
    """Shift of the flange over poses q: (N, n), arm stretched, where the charge is off by these shares."""
    job, joint = problem(planned(robot, q)), compensated_joint(robot)
    assert job.compensator is not None
    s, slope, _ = linkage(job.arm, job.compensator).stretch(q[:, joint])
    stiffness = robot.joints[joint].data.stiffness or np.inf
    shift = 1e3 * reach(job, joint) * job.compensator.force(s)[2] * slope / stiffness  # mm per unit of charge
    series = {f"{100 * share:.0f} %".replace("-", "−"): Series(-share * shift) for share in shares}
    title = "A lost charge moves the unloaded tool; loaded minus unloaded does not see it"
    x, y = f"joint {joint + 1}, °", f"shift of the flange towards +q{joint + 1}, mm"
    return curves("bias", title, np.degrees(q[:, joint]), series, x, y)
