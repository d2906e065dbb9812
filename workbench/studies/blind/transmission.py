"""Hidden causes between command and joint. Their forms are near the catalogue's, never the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...effects.backlash import Backlash
from ...effects.gear_eccentricity import GearEccentricity
from ...effects.gear_kinematic_error import GearKinematicError
from ...effects.gear_ratio import GearRatio
from ...effects.guideway import Guideway
from ...effects.joint_map import JointMap
from ...effects.readback_joints import ReadbackJoints
from ...effects.wrist_coupling import WristCoupling
from ...robot.kinematics import Array
from ...simulation.virtual_campaign import Truth
from .hidden import Hidden, axial_torque, joint_error, largest_torque

Shape = Callable[[Array], Array]
SECTIONS = 4  # of a guide


def gear_ratio(problem: Problem, effect: GearRatio, rng: np.random.Generator) -> Hidden:
    """ε q, with a tenth of it bent: the pitch of the teeth is not quite even."""
    j, unit = problem.joint(effect.where.joint), _sign(rng) * 5e-5
    far, bend = float(np.abs(problem.q[:, j]).max()), rng.uniform(-0.12, 0.12)

    def error(problem: Problem) -> Array:
        q = problem.q[:, j]
        return unit * q * (1 + bend * (2 * (q / far) ** 2 - 1))

    return Hidden("gear_ratio", effect, np.array([unit]), joint_error(j, error), 20.0)


def gear_eccentricity(problem: Problem, effect: GearEccentricity, rng: np.random.Generator) -> Hidden:
    """One or two cycles per turn, with a small third harmonic."""
    j, k = problem.joint(effect.where.joint), effect.cycles
    phase, third, other = rng.uniform(-np.pi, np.pi), rng.uniform(0.05, 0.12), rng.uniform(-np.pi, np.pi)

    def error(problem: Problem) -> Array:
        q = problem.q[:, j]
        return 1e-4 * (np.sin(k * q + phase) + third * np.sin(3 * k * q + other))

    unit = 1e-4 * np.array([np.cos(phase), np.sin(phase)])
    return Hidden("gear_eccentricity", effect, unit, joint_error(j, error), 10.0)


def gear_kinematic_error(problem: Problem, effect: GearKinematicError, rng: np.random.Generator) -> Hidden:
    """A gear line with a harmonic of 15–25 % at twice its order; one in three of no known order."""
    j = problem.joint(effect.where.joint)
    if rng.random() < 1 / 3:
        effect = replace(effect, where=replace(effect.where, order=float(rng.uniform(12, 330))), variant="")
    order = effect.cycles
    double = replace(effect, where=replace(effect.where, order=2 * order), variant="")
    phase, share, other = rng.uniform(-np.pi, np.pi), rng.uniform(0.15, 0.25), rng.uniform(-np.pi, np.pi)

    def error(problem: Problem) -> Array:
        q = problem.q[:, j]
        return 3e-5 * (np.sin(order * q + phase) + share * np.sin(2 * order * q + other))

    unit = 3e-5 * np.array([np.cos(phase), np.sin(phase)])
    return Hidden("gear_kinematic_error", effect, unit, joint_error(j, error), 20.0, more=(double,))


def wrist_coupling(problem: Problem, effect: WristCoupling, rng: np.random.Generator) -> Hidden:
    """c q of the other joint, with a ripple: the coupled gears run out a little."""
    j, other, unit = problem.joint(effect.where.joint), problem.joint(effect.where.other), _sign(rng) * 1e-4
    ripple, phase = rng.uniform(0.05, 0.15), rng.uniform(-np.pi, np.pi)

    def error(problem: Problem) -> Array:
        q = problem.q[:, other]
        return unit * (q + ripple * np.sin(2 * q + phase))

    return Hidden("wrist_coupling", effect, np.array([unit]), joint_error(j, error), 20.0)


def backlash(problem: Problem, effect: Backlash, rng: np.random.Generator) -> Hidden:
    """Against the last motion, 15 % more or less of it as the joint's torque goes."""
    j, share = problem.joint(effect.where.joint), rng.uniform(-0.2, 0.2)
    most = largest_torque(problem, j)

    def error(problem: Problem) -> Array:
        direction = problem.campaign.poses.side
        if direction is None:
            return np.zeros(len(problem.q))
        return -3e-5 * direction[:, j] * (1 + share * axial_torque(problem)[:, j] / most)

    return Hidden("backlash", effect, np.array([3e-5]), joint_error(j, error), 20.0)


def readback_joints(problem: Problem, effect: ReadbackJoints, rng: np.random.Generator) -> Hidden:
    """The servo stops off the command and the encoders see it; each joint's a little wrongly."""
    weight = rng.uniform(0.9, 1.1, problem.arm.n)
    seed = int(rng.integers(1_000_000))

    def plan(campaign: Campaign, size: float) -> Campaign:
        off = 2e-5 * np.random.default_rng([seed, len(campaign.poses.q)]).normal(size=campaign.poses.q.shape)
        return campaign.with_poses(readback=campaign.poses.q + size * off)

    def form(size: float) -> Truth:
        def error(problem: Problem) -> Array:
            return np.asarray(weight * (np.asarray(problem.campaign.poses.readback) - problem.q))

        return Truth(joints=error)

    return Hidden("readback_joints", effect, np.ones(1), form, 50.0, plan=plan, fixed=True)


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def joint_map(problem: Problem, effect: JointMap | Guideway, rng: np.random.Generator) -> Hidden:
    """A saw with slow teeth, nearly three cycles a turn, or a bump where a tooth is damaged; or a guide."""
    if effect.of_joint(problem) is None:
        return _guide(problem, effect, rng)
    j = problem.joint(effect.where.joint)
    shapes = (_saw(rng), _uneven(rng), _bump(problem.q[:, j], rng))
    shape = shapes[int(rng.integers(len(shapes)))]
    near = effect.motion(problem)[int(problem.arm.axial[j])]
    unit = np.asarray(np.linalg.lstsq(near, 1e-4 * shape(problem.q[:, j]), rcond=1e-6)[0], dtype=np.float64)
    return Hidden("joint_map", effect, unit, joint_error(j, lambda p: 1e-4 * shape(p.q[:, j])), 30.0)


def _guide(problem: Problem, effect: JointMap | Guideway, rng: np.random.Generator) -> Hidden:
    """Straight sections of a guide that meet at an angle, each as long as it happens to be."""
    j, near = problem.joint(effect.where.joint), effect.motion(problem)
    low, high = problem.q[:, j].min(), problem.q[:, j].max()
    joints = np.array([low, *np.sort(rng.uniform(low, high, SECTIONS - 1)), high])
    off = 1e-4 * rng.normal(size=(6, len(joints)))

    def motion(about: Problem) -> dict[int, Array]:
        return {c: np.interp(about.q[:, j], joints, way) for c, way in zip(near, off, strict=True)}

    true = np.concatenate(list(motion(problem).values()))
    unit = np.linalg.lstsq(np.concatenate(list(near.values())), true, rcond=1e-6)[0]

    def form(size: float) -> Truth:
        return Truth(motion=lambda about: {k: size * v for k, v in motion(about).items()})

    return Hidden("joint_map", effect, np.asarray(unit), form, 30.0)


def _saw(rng: np.random.Generator) -> Shape:
    cycles, phase = rng.uniform(1.3, 1.7), rng.uniform()
    return lambda q: (q * cycles / (2 * np.pi) + phase) % 1.0 - 0.5


def _uneven(rng: np.random.Generator) -> Shape:
    cycles, phase = rng.uniform(2.45, 2.75), rng.uniform(-np.pi, np.pi)
    return lambda q: np.sin(cycles * q + phase)


def _bump(q: Array, rng: np.random.Generator) -> Shape:
    at, width = float(np.quantile(q, rng.uniform(0.3, 0.7))), 0.12 * float(np.ptp(q))
    return lambda q: np.exp(-0.5 * ((q - at) / width) ** 2)
