"""Plans such as the paper's: 31 configurations at six angles of joint 2, before and after loading.

Where the angles lie, how many configurations each has, what hangs on the flange and which of them are pulled
from the side is not printed. A plan of the study's pool draws it all from its number, and then chooses its
configurations by the paper's criterion (18).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from workbench import (
    Array,
    Problem,
    Rig,
    Robot,
    Target,
    exchange,
    gas_spring,
    load_pairs,
    load_robot,
    planned,
    problem_of,
    random_poses,
)

from .printed import CONFIGURATIONS, LOAD, MARKERS_APART, MARKERS_BEFORE

JOINT = 1  # joint 2, from 0
ANGLES, LEAST, MOST = 6, 3, 7  # section IV: configurations at each of the angles
POOL, QUICK_POOL = 12, 3  # plans
CANDIDATES = 60  # configurations at each angle to choose from
ACROSS, BEFORE = MARKERS_APART / 2, MARKERS_BEFORE
MARKER_PLACES = (ACROSS, 0.0, BEFORE), (-ACROSS, 0.0, BEFORE), (0.0, ACROSS, BEFORE)  # m, on the flange
TARGETS = tuple(Target(f"M{i}", place, fixed=True) for i, place in enumerate(MARKER_PLACES, start=1))
LIMITS = {"joint_1": 0.7, "joint_4": np.pi, "joint_5": 1.9, "joint_6": np.pi}
FLOOR, CLEAR = 0.25, 0.45  # m: lowest point, and distance from the first axis
TEST_POSE, TEST_FORCE = np.radians([0, -60, 90, 0, 60, 0]), np.array([300.0, 100.0, -500.0])
SIGMA = 3e-5  # m, of a reading, per axis: where one value is needed


@dataclass(frozen=True, eq=False)
class PairPlan:
    """angles: (6,) [rad] in the order of print; group: (C,) which of them; problem: its 2C poses, C before
    and C after loading; rows: (C, 9, 11) motion of the markers by the load per unit of each compliance of
    Table I."""

    angles: Array
    group: NDArray[np.int64]
    problem: Problem
    rows: Array

    @property
    def count(self) -> int:
        return len(self.group)


@cache
def robot() -> Robot:
    """The KR 120."""
    return load_robot("kr120")


def rig(tool: float, hook: float, side: float) -> Rig:
    """Markers, load and tool [kg], the hook's place across the flange [m], the pull from the side [N]."""
    place = (hook, 0.0, BEFORE)
    return Rig(TARGETS, (LOAD, place), np.array([0.0, side, 0.0]), (tool, place), SIGMA, LIMITS)


@cache
def plan(number: int) -> PairPlan:
    """A plan of the pool. number: from 0."""
    rng = np.random.default_rng([number, 120])
    low, high = np.radians([rng.uniform(-145, -110), rng.uniform(-40, 15)])
    angles = np.linspace(low, high, ANGLES) + rng.uniform(-1, 1, ANGLES) * np.radians(5.0)
    order = rng.integers(3)  # of print: rising, falling, any
    angles = angles[::-1] if order == 1 else rng.permutation(angles) if order == 2 else angles
    counts = drawn_counts(rng)
    hook, side = 0.02 * 23.0 ** rng.random(), 5.0 * 80.0 ** rng.random()
    used = rig(rng.uniform(10.0, 40.0), hook, side)
    A0 = used.moved(robot(), TEST_POSE, TEST_FORCE)
    aside = 1 + int(rng.integers(2))  # configurations of each angle that are pulled from the side
    upright = round(
        30.0 ** rng.random()
    )  # of so many times the candidates, those whose tool points down most
    q = np.concatenate([candidates(used.held(robot(), "joint_2", a), upright, rng) for a in angles])
    shape = ANGLES, CANDIDATES, 3 * len(TARGETS), len(robot().joints)
    down, pulled = (used.rows(robot(), q, pull).reshape(shape) for pull in (np.zeros(3), used.sideways))
    chosen, pulls = [], []
    for g, count in enumerate(counts):
        sides = np.argsort(-(pulled[g, :, :, 0] ** 2).sum(axis=1))[:aside]
        prior = np.einsum("cri,crj->ij", pulled[g, sides], pulled[g, sides])
        best, _ = exchange(down[g], A0, count - aside, prior=prior, starts=1, seed=number)
        chosen += [*q[g * CANDIDATES + best], *q[g * CANDIDATES + sides]]
        pulls += [np.zeros(3)] * (count - aside) + [used.sideways] * aside
    group = np.repeat(np.arange(ANGLES, dtype=np.int64), counts)
    campaign = load_pairs.pairs(robot(), np.array(chosen), used.load, np.array(pulls), TARGETS, used.tool)
    rows = load_pairs.difference_rows(campaign) / compliances(robot())
    return PairPlan(angles, group, problem_of(campaign), eleven(rows, group))


def candidates(used: Robot, times: int, rng: np.random.Generator) -> Array:
    """(CANDIDATES, 6) [rad] of `times` as many random poses those whose tool points down most."""
    q = random_poses(used, times * CANDIDATES, rng, floor=FLOOR, clear=CLEAR)
    axis = problem_of(planned(used, q)).rigid.R[-1][:, 2, 2]  # z of the flange along z of the base
    return q[np.argsort(axis)[:CANDIDATES]]


def spring(problem: Problem) -> tuple[gas_spring.Linkage, gas_spring.CompensatorLaw]:
    """The robot's compensator: where it acts, and how strongly."""
    law = problem.compensator
    assert law is not None
    return gas_spring.linkage(problem.arm, law), law


def compliances(used: Robot) -> Array:
    """(6,) [rad/(N·m)] of its joints."""
    return np.array([1 / (joint.data.stiffness or np.inf) for joint in used.joints])


def drawn_counts(rng: np.random.Generator) -> NDArray[np.int64]:
    """(6,) configurations at each angle: from three to seven, 31 in all."""
    counts = np.full(ANGLES, LEAST, dtype=np.int64)
    while counts.sum() < CONFIGURATIONS:
        counts[rng.choice(np.flatnonzero(counts < MOST))] += 1
    return counts


def eleven(rows: Array, group: NDArray[np.int64]) -> Array:
    """(C, R, 11) rows by the compliances of Table I, from (C, R, 6) by those of the joints."""
    k2 = rows[:, :, JOINT, None] * (group[:, None, None] == np.arange(ANGLES))
    return np.concatenate([rows[:, :, :1], k2, rows[:, :, 2:]], axis=2)
