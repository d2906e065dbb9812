"""How the robot is measured: each joint loaded by itself, and joints swept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench import (
    Array,
    Campaign,
    Effect,
    LocalStiffness,
    Problem,
    Robot,
    Target,
    Truth,
    axis_by_axis,
    catalogue,
    load_pairs,
    simulate,
    sweep,
)

from .printed import SWEPT

# not in the paper, from here on: noise per reading of tracker [m] and level [rad]
TRACKER, LEVEL = 3e-5, 5e-6

# How each joint is loaded: pose [deg], N and N·m at the flange per N of load, largest load [N], links with
# tracker targets (none: levels). Each force runs through the axes that shall not feel it, if it can.
LOCAL = {
    "joint_1": ((0, 0, 90, 0, 0, 0), (0, 1, 0, 0, 0, 0), 500.0, ("base", "link_1")),
    "joint_2": ((0, 0, 90, 0, 0, 0), (-1, 0, 0, 0, 0, 0), 800.0, ("link_1", "link_2")),
    "joint_3": ((0, 0, 90, 0, 0, 0), (0, 0, -1, 0, 0, 0), 500.0, ()),
    "joint_4": ((0, 0, 90, 0, 90, 0), (0, 0, -1, -0.5, 0, 0), 500.0, ()),
    "joint_5": ((0, 0, 90, 0, 0, 0), (0, 0, -1, 0, 0.5, 0), 300.0, ()),
    "joint_6": ((0, 0, 90, 0, 0, 0), (0, 0, -1, -0.2, 0, 0), 50.0, ()),
}
TARGET_PLACES = {  # m, of tracker targets on the links
    "base": ((0.3, 0.2, 0.1), (-0.3, 0.1, 0.3), (0.1, -0.3, 0.3)),
    "link_1": ((0.3, -0.2, 0.1), (-0.3, 0.15, 0.1), (0.0, -0.35, 0.2)),
    "link_2": ((0.1, -0.2, 0.8), (-0.1, -0.2, 0.6), (0.0, -0.3, 0.9)),
}
# Of the global method: N at a place on the flange [m], and the tracker's targets there
GLOBAL_FORCE, GLOBAL_LEVER = 500.0, (0.1, 0.1, 0.1)
FLANGE_PLACES = ((0.15, 0.0, 0.05), (-0.1, 0.12, 0.05), (-0.1, -0.12, 0.15))
# Which joint is swept between which angles, the others where [deg], a target on its link [m]. The paper
# sweeps joint 2; the two others that lift the tool are swept for the row that corrects everything.
SWEEPS = {
    "joint_2": (SWEPT, (0, 0, 90, 0, 0, 0), Target("elbow", (0.0, -0.25, 0.95), "link_2")),
    "joint_3": ((50, 150), (0, 0, 0, 0, 0, 0), Target("wrist", (0.0, -0.15, 0.8), "link_3")),
    "joint_5": ((-50, 50), (0, 0, 90, 0, 0, 0), Target("bar", (0.0, 0.0, 0.5), "link_5")),
}

COUNTED = 101  # poses of a sweep or path that are looked at for collisions


def stiffness(robot: Robot, truth: Robot, joint: str, rounds: int, seed: int) -> LocalStiffness:
    """One joint's stiffness: the load goes up in ten steps and down again, `rounds` times."""
    degrees, wrench, largest, links = LOCAL[joint]
    q, steps, level = np.deg2rad(degrees), largest * np.linspace(0, 1, 11), not links
    points = [Target(f"{on}_{i}", xyz, on) for on in links for i, xyz in enumerate(TARGET_PLACES[on])]
    targets = axis_by_axis.levels(robot, q, joint) if level else points
    plan = axis_by_axis.local_plan(truth, q, wrench, np.tile([*steps, *steps[::-1]], rounds), targets)
    seen = simulate(
        plan,
        Truth(sigma=LEVEL * axis_by_axis.POINTER if level else TRACKER, repeatability=np.zeros(6)),
        seed=10 * seed + robot.joint_names.index(joint),
        instrument=(np.eye(3)[None], np.zeros((1, 3))) if level else None,
    )
    return axis_by_axis.identify(replace(seen, robot=robot), joint, levelled=level)


def scattered(rng: np.random.Generator, count: int) -> Array:
    """(count, 6) [rad] poses of the global method."""
    return np.deg2rad(
        rng.uniform([-90, -50, 40, -180, -90, -180], [90, 50, 130, 180, 90, 180], size=(count, 6))
    )


def stood_in(seed: int, spiral: Array) -> dict[str, Array]:
    """What poses are for → their joints (N, 6) [rad]. spiral: (M, 6) [rad] along it."""
    swept = {}
    for joint, (ends, q, _) in SWEEPS.items():
        every = np.tile(np.deg2rad(q), (COUNTED, 1))
        every[:, int(joint[-1]) - 1] = np.deg2rad(np.linspace(*ends, COUNTED))
        swept[f"sweep of {joint.replace('_', ' ')}, evenly"] = every
    return {
        "joints loaded one by one": np.deg2rad([pose for pose, *_ in LOCAL.values()]),
        "all joints at once": scattered(np.random.default_rng([seed, 1]), COUNTED),
        **swept,
        "spiral, evenly": spiral[:: max(1, len(spiral) // COUNTED)],
    }


def all_at_once(robot: Robot, truth: Robot, count: int, seed: int) -> tuple[Array, Array]:
    """The paper's global method, eq. (1): forces from all sides at the flange, its motion under the tracker.
    All six stiffnesses [N·m/rad] and their relative standard deviations, each (6,)."""
    rng = np.random.default_rng([seed, 1])
    q = scattered(rng, count)
    pull = rng.normal(size=(count, 3))
    pull *= GLOBAL_FORCE / np.linalg.norm(pull, axis=1)[:, None]
    targets = [Target(f"F{i}", xyz) for i, xyz in enumerate(FLANGE_PLACES)]
    plan = load_pairs.pairs(truth, q, (0.0, GLOBAL_LEVER), pull, targets, (0.0, (0.0, 0.0, 0.0)))
    seen = load_pairs.measure_pairs(plan, Truth(sigma=TRACKER), seed, (np.eye(3), np.zeros(3)))

    def joints(problem: Problem) -> list[Effect]:
        return [e for e in catalogue()["joint_compliance"].sites(problem) if e.where.joint]

    k, std = load_pairs.compliances(load_pairs.fit_pairs(replace(seen, robot=robot), joints, TRACKER))
    return 1 / k, std / k


def measured(truth: Robot, believed: Robot, joint: str, count: int, seed: int) -> Campaign:
    """A joint swept on the true robot; the campaign names the robot that is believed in."""
    ends, q, target = SWEEPS[joint]
    low, high = np.deg2rad(ends)
    plan = sweep.sweep(truth, joint, np.deg2rad(q), (float(low), float(high)), count, target)
    return replace(simulate(plan, Truth(sigma=TRACKER), seed=seed), robot=believed)
