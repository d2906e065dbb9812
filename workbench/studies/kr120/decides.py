"""Which measurement tells a soft gear of the KR 120 from a changed compensator, and how often?

Each machine is diagnosed from pairs like the paper's, read as absolute poses, and from poses under three
loads with motor torque.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench import (
    Array,
    Campaign,
    Draws,
    Outcome,
    Prior,
    StudyRun,
    Table,
    Truth,
    catalogue,
    diagnose,
    draw_many,
    load_pairs,
    numbers,
    planned,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
)

from .assumed import ARCMIN
from .plans import CLEAR, FLOOR, JOINT, MARKER_PLACES, SIGMA, rig, robot
from .printed import LOAD
from .world import RZ, soft_zone

GAS = catalogue()["gravity_compensator"](variant="charge")
WAYS = {
    "pairs": "pairs, read as absolute poses",
    "torque": "poses under three loads, with motor torque",
}
MACHINES = {"gas": "as modelled", "soft": "soft gear", "leak": "lost charge"}
POSES = 16  # of each campaign; thrice under three loads
DRIVE_NOISE = 0.03  # share of a joint's largest torque
TOOL = 25.0  # kg
RIG = rig(TOOL, MARKER_PLACES[0][0], 200.0)
PRIORS = {
    "width": Prior("half width of the soft zone", 0.2, 1.0, "arcmin", why="data sheets allow 1 arcmin"),
    "torque": Prior(
        "torque at which it carries", 200, 2000, "N·m", True, "up to a sixth of the rated torque"
    ),
    "lost": Prior("lost share of the charge", 0.05, 0.25, why="a leak; 5 % is a cold morning"),
}


def truths(values: Mapping[str, float], seed: int) -> dict[str, Truth]:
    """As the paper models it; with a soft gear in joint 2, a form that the catalogue lacks; with a leak."""
    problem = problem_of(planned(robot(), np.zeros((1, 6))))
    usual = Truth(geometry=random_geometry(problem.arm, np.random.default_rng([seed, 1])), sigma=SIGMA)
    zone = soft_zone(values["width"] * ARCMIN, values["torque"])

    def turn(wrench: Array) -> Array:
        return np.asarray(np.eye(6)[RZ] * zone(wrench[RZ])[0])

    return {
        "gas": usual,
        "soft": replace(usual, yields={JOINT + 1: turn}),
        "leak": replace(usual, effects=((GAS, np.array([-values["lost"]])),)),
    }


def campaigns(way: str, seed: int) -> Campaign:
    """The plan of a way of measuring."""
    q = random_poses(robot(), POSES, np.random.default_rng([seed, 3]), floor=FLOOR, clear=CLEAR)
    mass, place = RIG.load
    loads = {"half": (mass / 2, place), "full": RIG.load}
    if way == "pairs":
        plan = load_pairs.pairs(robot(), q, RIG.load, np.zeros((POSES, 3)), RIG.targets, RIG.tool)
        return load_pairs.as_one_setup(plan)
    return planned(
        robot(),
        np.tile(q, (3, 1)),
        targets=RIG.targets,
        payloads=loads,
        payload=[name for name in ("", *loads) for _ in range(POSES)],
        tool=RIG.tool,
        title=f"{robot().title}, {POSES} poses under three loads",
    )


def one_of_each(values: Mapping[str, float], seed: int) -> dict[str, float]:
    """Every machine measured and diagnosed in every way: 1 where what is hidden, and nothing else, is
    said."""
    found: dict[str, float] = {}
    for way in WAYS:
        plan, right = campaigns(way, seed), 1.0
        for name, truth in truths(values, seed).items():
            noise = DRIVE_NOISE if way == "torque" else None
            said = diagnose(simulate(plan, truth, seed=seed, torque_sigma=noise), seed=seed % 1000)
            told, mistaken = judged(name, said)
            found |= {f"{name}_{way}": float(told), f"mistaken_{name}_{way}": float(mistaken)}
            right *= told
        found[f"apart_{way}"] = right
    bare, _, full = problem_of(campaigns("torque", seed)).nominal_load.local[:, JOINT + 1, RZ].reshape(3, -1)
    return found | {"reversing": float((bare * full < 0).mean())}


def judged(hidden: str, outcome: Outcome) -> tuple[bool, bool]:
    """Whether it is told: nothing in the machine as modelled; a fault of joint 2 and none of the compensator
    in the soft gear; the compensator, and nothing of joint 2, in the leak. Rivals count as said. And whether
    it is mistaken: the compensator is blamed for the soft gear, or joint 2's gear for the leak, without the
    true one beside."""
    said = named(outcome)
    gear, leak = any(joint == "joint_2" for _, joint in said), any(cause == GAS.cause for cause, _ in said)
    only_gear, only_leak = gear and not leak, leak and not gear
    return {
        "gas": (not said, bool(said)),
        "soft": (only_gear, only_leak),
        "leak": (only_leak, only_gear),
    }[hidden]


def named(outcome: Outcome) -> set[tuple[str, str | None]]:
    """Causes and their rivals, each with its joint."""
    causes = outcome.diagnosis.causes
    rivals = [rival for cause in causes for rival in cause.rivals]
    return {(c.cause, c.where.joint) for c in causes} | {(r.cause, r.where.joint) for r in rivals}


def deciding_draws(count: int, run: StudyRun) -> Draws:
    """`one_of_each` with so many seeds, soft gears and leaks."""
    return draw_many(one_of_each, PRIORS, count, run, "deciding")


def deciding_numbers(draws: Draws) -> dict[str, float]:
    """Shares of the draws in which each way tells each machine, and all three."""
    share = {
        f"told_{name}": float(column.mean()) for name, column in draws.numbers.items() if name != "reversing"
    }
    return share | {
        "deciding_draws": float(draws.count),
        "deciding_poses": float(POSES),
        "half_load": LOAD / 2,
        "reversing": float(draws.numbers["reversing"].mean()),
    }


def deciding_table(draws: Draws) -> Table:
    """Ways of measuring × machines."""
    n = deciding_numbers(draws)
    rows = [
        [
            words,
            *(numbers.percent(n[f"told_{name}_{way}"], 0) for name in MACHINES),
            *(numbers.percent(n[f"told_mistaken_{name}_{way}"], 0) for name in ("soft", "leak")),
            numbers.percent(n[f"told_apart_{way}"], 0),
        ]
        for way, words in WAYS.items()
    ]
    head = (
        "Measurement", *(f"{words}: right" for words in MACHINES.values()), "soft gear: gas blamed alone",
        "lost charge: joint 2 blamed alone", "all three right",
    )  # fmt: skip
    note = (
        f"Share of {draws.count} draws of seed, soft gear and leak, {POSES} poses each. Right: nothing in "
        "the machine as "
        "modelled; a fault of joint 2 and none of the compensator in the soft gear; the compensator and "
        "nothing of joint 2 "
        "in the leak; rivals count as said."
    )
    return Table("How often each measurement tells a soft gear from a changed compensator", head, rows, note)
