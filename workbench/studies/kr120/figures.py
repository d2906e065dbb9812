"""The KR 120 study's figures, Table I beside ours, and its numbers by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench import (
    Array,
    Figure,
    FittedSpring,
    GroupPlan,
    Problem,
    Robot,
    charts,
    gas_spring,
    load_pairs,
    planned,
    problem_of,
)

from .plans import spring
from .printed import ATMOSPHERE, HALF_1, SIX, TABLE_1

LOST = (-0.05, -0.1, -0.2)  # of the charge


def plan_numbers(plan: GroupPlan) -> dict[str, float]:
    """The optimum beside plans drawn at random."""
    middle = float(np.median(plan.random))
    return {
        "rho0_mm": 1e3 * plan.rho0,
        "rho0_median_mm": 1e3 * middle,
        "rho0_best_mm": 1e3 * float(plan.random.min()),
        "hanging_tells_k1": float(np.isfinite(plan.hanging)),
        "rho0_force_mm": 1e3 * plan.any_force,
        "fewer": (middle / plan.rho0) ** 2,
        "pulled": float(plan.campaign.poses.wrench.any(axis=1).sum()),
    }


def plan_figure(plan: GroupPlan) -> Figure:
    marks = {
        "optimum": 1e3 * plan.rho0,
        f"best of {len(plan.random)} random": 1e3 * float(plan.random.min()),
        "median": 1e3 * float(np.median(plan.random)),
    }
    title = f"The optimum plan against {len(plan.random)} random plans of the same size"
    label = "expected error at the test pose ρ0, mm"
    return charts.histogram("plans", title, 1e3 * plan.random, label, marks)


def spring_numbers(springs: Mapping[str, FittedSpring]) -> dict[str, float]:
    """Fitted gas springs, each with its gear."""
    by_name: dict[str, float] = {}
    for name, fitted in springs.items():
        by_name |= _strength(name, fitted.force, fitted.torque, fitted.stiffness)
        by_name |= {f"{name}_chi2": fitted.chi2, f"{name}_p": fitted.p_value}
        by_name |= {f"{name}_s0_m": fitted.s0, f"{name}_sV_m": fitted.sV}
    return by_name


def own_spring_numbers(problem: Problem, angles: Array) -> dict[str, float]:
    """What the robot's own gas spring does at these angles: force, torque, stiffness, and shift of the
    stretched arm."""
    joint = compensated_joint(problem.robot)
    triangle, law = spring(problem)
    gear = problem.robot.joints[joint].data.stiffness or np.inf
    torque, added = gas_spring.bias(triangle, law, angles), gas_spring.added_stiffness(triangle, law, angles)
    assert law.data.precharge
    assert law.data.gas_length
    assert law.data.reference is not None
    sV = law.data.precharge * law.data.gas_length / ATMOSPHERE
    return {
        "own_s0_m": law.data.reference + law.data.gas_length - sV,
        "own_sV_m": sV,
        "a_mm": 1e3 * triangle.a,
        "L_mm": 1e3 * triangle.L,
        "alpha_deg": float(np.degrees(triangle.alpha)),
        **_strength("own", law.force(triangle.stretch(angles)[0])[0], torque, gear),
        "added_least_kNm": 1e-3 * float(added.min()),
        "added_most_kNm": 1e-3 * float(added.max()),
        "added_share": float(added.max()) / gear,
        "bias_shift_mm": 1e3 * float(np.abs(torque).max()) / gear * reach(problem, joint),
    }


def _strength(name: str, force: Array, torque: Array, gear: float) -> dict[str, float]:
    return {
        f"{name}_least_MN": 1e-6 * float(force.min()),
        f"{name}_most_MN": 1e-6 * float(force.max()),
        f"{name}_torque_kNm": 1e-3 * float(np.abs(torque).max()),
        f"{name}_gear_MNm": 1e-6 * gear,
    }


def stiffness_figure(problem: Problem, angles: Array, needed: FittedSpring) -> Figure:
    """Joint 2's stiffness at the angles: Table I, the robot's gas spring, the one that Table I would need."""
    k, half = TABLE_1[SIX], HALF_1[SIX]
    added = gas_spring.added_stiffness(*spring(problem), angles)
    alone, needs = 1 / k.mean() + added, 1 / needed.compliance
    series = {
        "gas spring alone": charts.Series(1e-6 * alone, colour=charts.MIDDLE),
        "nearest gas spring of any strength, eq. (12)": charts.Series(
            1e-6 * needs, colour=charts.NOISE, style="--"
        ),
        "Table I": charts.Series(1e-6 / k, 1e-6 / (k + half), 1e-6 / (k - half), charts.PRINTED, "o"),
    }
    title = "Joint 2's stiffness: with the robot's gas spring, with the one nearest to Table I, as printed"
    x, y = "joint 2, ° (angles and order assumed)", "stiffness, MN·m/rad"
    return charts.curves("stiffness", title, np.degrees(angles), series, x, y, height=3.4)


def compensated_joint(robot: Robot) -> int:
    """Number of the joint that the compensator acts on, from 0."""
    assert robot.compensator is not None
    return robot.joint_names.index(robot.compensator.joint)


def reach(problem: Problem, joint: int) -> float:
    """From a joint to the flange in the first pose [m]."""
    return float(np.linalg.norm(problem.rigid.p[-1][0] - problem.rigid.origin[0, joint + 1]))


def stretched(angles: Array) -> Array:
    """(91, 6) poses with the arm stretched, joint 2 from the first of these angles to the last."""
    q = np.zeros((91, 6))
    q[:, 1] = np.linspace(angles[0], angles[-1], len(q))
    return q


def torque_figure(robot: Robot, q: Array, load: load_pairs.Load, tool: load_pairs.Load) -> Figure:
    """Torque on the compensated joint over poses q: (N, n): of the weight alone, and of what is left."""
    joint, bare = compensated_joint(robot), replace(robot, compensator=None)

    def torque(used: Robot, payload: str) -> Array:
        problem = problem_of(planned(used, q, payloads={"load": load}, payload=[payload] * len(q), tool=tool))
        return problem.nominal_load.local.reshape(len(q), -1)[:, problem.arm.axial[joint]]

    series = {
        "with compensator": charts.Series(1e-3 * torque(robot, "")),
        f"with compensator and {load[0]:.0f} kg": charts.Series(1e-3 * torque(robot, "load")),
        "weight alone": charts.Series(1e-3 * torque(bare, ""), colour=charts.MIDDLE),
    }
    title = f"The torque that joint {joint + 1}'s gear works at, with the compensator and without"
    x = f"joint {joint + 1}, °"
    return charts.curves("torque", title, np.degrees(q[:, joint]), series, x, "torque, arm stretched, kN·m")


def bias_figure(robot: Robot, q: Array) -> Figure:
    """Shift of the flange over poses q: (N, n), arm stretched, where some of the charge is lost."""
    problem, joint = problem_of(planned(robot, q)), compensated_joint(robot)
    triangle, law = spring(problem)
    s, slope, _ = triangle.stretch(q[:, joint])
    stiffness = robot.joints[joint].data.stiffness or np.inf
    force = law.force(s)[2]  # per unit of charge
    shift = 1e3 * reach(problem, joint) * force * slope / stiffness  # mm
    series = {f"{100 * share:.0f} %".replace("-", "−"): charts.Series(-share * shift) for share in LOST}
    title = "How far a lost charge moves the unloaded tool"
    x, y = f"joint {joint + 1}, °", "shift of the flange, mm"
    return charts.curves("bias", title, np.degrees(q[:, joint]), series, x, y)
