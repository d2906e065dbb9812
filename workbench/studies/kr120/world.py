"""Machines that may have made Table I, and what the paper's estimate makes of their pairs.

The loaded equilibrium is the workbench's batch one, which a test holds against Drake's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from workbench import Array, Yielding, bending_compliance, equilibrium

from .plans import ANGLES, JOINT, PairPlan, compliances, robot

RX, RY, RZ = 3, 4, 5  # of a slot's six components
Law = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class World:
    """What a machine is like. C configurations, T markers, all as the paper believes where nothing is said.

    k: (6,) [rad/(N·m)]; law: of joint 2's torque [N·m] → turn [rad] and slope, beside k. group_k2: (6,) its
    compliance by angle in place of k. charge: of the gas. friction: (6,) [N·m] of the gears, at rest on
    `side` (C, 6) within ±1 of it. bearing: (3,) [rad/(N·m)] tilt of joints 1 to 3; foundation: the same of
    the floor; bending: 1/EI of links 2 and 3 [1/(N·m²)]. hook (3,) [m], weight (share): where and how much
    the load is beyond what is told. markers: (3, 3) [m] errors of their places; turn: (3,) [rad] of the
    instrument's frame. drift: (6, 3) [m] between before and after, by angle.
    """

    k: Array
    law: Law | None = None
    group_k2: Array | None = None
    charge: float = 1.0
    friction: Array = field(default_factory=lambda: np.zeros(6))
    side: Array | float = 0.0
    bearing: Array = field(default_factory=lambda: np.zeros(3))
    foundation: float = 0.0
    bending: Array = field(default_factory=lambda: np.zeros(2))
    hook: Array = field(default_factory=lambda: np.zeros(3))
    weight: float = 0.0
    markers: Array = field(default_factory=lambda: np.zeros((3, 3)))
    turn: Array = field(default_factory=lambda: np.zeros(3))
    drift: Array = field(default_factory=lambda: np.zeros((ANGLES, 3)))
    sigma: float = 3e-5


@dataclass(frozen=True, eq=False)
class Estimate:
    """k: (11,) as Table I lists them; cofactor: (11,) standard deviations per unit of a difference's noise;
    residual: root mean square of what is left [m], with `dof`."""

    k: Array
    cofactor: Array
    residual: float
    dof: int


def moved(plan: PairPlan, world: World) -> Array:
    """(C, T, 3) [m] loaded minus unloaded, without noise, in the base frame."""
    problem, count = plan.problem, plan.count
    arm, loads = problem.arm, problem.loads
    after = np.arange(2 * count) >= count
    hanging = after & (problem.campaign.poses.payload > 0)
    mass, place = problem.campaign.load_mass[-1], problem.campaign.load_com[-1]
    law = loads.compensator
    assert law is not None
    moment = loads.moment + np.outer(hanging, mass * (world.weight * place + (1 + world.weight) * world.hook))
    wrench = loads.wrench.copy()
    lever = problem.rigid.R[-1] @ world.hook
    wrench[:, 3:] += np.cross(lever, wrench[:, :3])
    loads = replace(
        loads,
        mass=loads.mass + mass * world.weight * hanging,
        moment=moment,
        wrench=wrench * (1 + world.weight),
        compensator=replace(law, charge=world.charge),
    )
    yielding = _yielding(plan, world)
    direct = np.zeros((2 * count, arm.slots, 6))
    direct.reshape(2 * count, -1)[count:, arm.axial] = _stuck(plan, world)
    _, where, _ = equilibrium(arm, problem.q, direct, loads, yielding.motion)
    points = where.points(problem.stated_targets + world.markers, problem.on)
    return np.asarray(points[count:] - points[:count])


def _stuck(plan: PairPlan, world: World) -> Array:
    """(C, 6) [rad] by which friction holds the gears back after loading: a play operator of width
    `friction`."""
    count, problem = plan.count, plan.problem
    local = problem.nominal_torque
    change = local[count:] - local[:count]
    before = world.side * world.friction
    return np.asarray((np.clip(before - change, -world.friction, world.friction) - before) * world.k)


def _yielding(plan: PairPlan, world: World) -> Yielding:
    arm = plan.problem.arm
    linear = np.zeros((arm.slots, 6, 6))
    for joint, k in enumerate(world.k):
        linear[joint + 1, RZ, RZ] = k
    for component in (RX, RY):
        linear[0, component, component] = world.foundation
        for joint, c in enumerate(world.bearing):
            linear[joint + 1, component, component] += c
    for link, compliance in zip((2, 3), world.bending, strict=True):
        linear[link + 1] += compliance * bending_compliance(arm.span[link + 1])
    bent: list[tuple[int, tuple[int, ...], Law]] = []
    slot = JOINT + 1
    if world.group_k2 is not None:
        linear[slot, RZ, RZ] = 0.0
        each = np.tile(world.group_k2[plan.group], 2)
        bent.append((slot, (RZ,), lambda wrench: _axial(each * wrench[:, RZ], each)))
    if world.law is not None:
        form = world.law
        bent.append((slot, (RZ,), lambda wrench: _axial(*form(wrench[:, RZ]))))
    return Yielding(linear, tuple(bent))


def _axial(turn: Array, slope: Array) -> tuple[Array, Array]:
    motion, by_wrench = np.zeros((len(turn), 6)), np.zeros((len(turn), 6, 6))
    motion[:, RZ], by_wrench[:, RZ, RZ] = turn, slope
    return motion, by_wrench


def soft_zone(width: float, torque: float) -> Law:
    """Law of a gear that turns by ± width [rad] before it carries, at about `torque` [N·m]."""

    def law(load: Array) -> tuple[Array, Array]:
        x = load / torque
        return width * x / np.sqrt(1 + x**2), width / torque / (1 + x**2) ** 1.5

    return law


def estimated(plan: PairPlan, world: World, rng: np.random.Generator) -> Estimate:
    """Eqs. (8)–(11) on the pairs as measured: k = (Σ BᵀB)⁻¹ Σ Bᵀ Δp."""
    made = moved(plan, world) + world.drift[plan.group][:, None]
    made = made + np.cross(world.turn, made) + np.sqrt(2) * world.sigma * rng.normal(size=made.shape)
    return estimate(plan, made)


def estimate(plan: PairPlan, made: Array) -> Estimate:
    """Of differences (C, T, 3) [m]."""
    rows, y = plan.rows.reshape(-1, plan.rows.shape[2]), made.reshape(-1)
    scale = np.concatenate([compliances(robot())[[0] + [JOINT] * ANGLES], compliances(robot())[2:]])
    inverse = np.linalg.inv((rows * scale).T @ (rows * scale))
    k = inverse @ (rows * scale).T @ y
    left = y - rows @ (scale * k)
    dof = len(y) - len(k)
    return Estimate(scale * k, scale * np.sqrt(np.diag(inverse)), float(np.sqrt(left @ left / dof)), dof)
