"""What data would show flexibility: four plans, a joint 6 that is softer than modelled, and a rigid model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Campaign,
    Diagnosis,
    Draws,
    Prior,
    Robot,
    StudyRun,
    Table,
    Target,
    Where,
    diagnose,
    draw_many,
    load_robot,
    numbers,
    with_compliance,
    write_campaign,
)

from .arm import ARM
from .figures import Chapter, plans_figure

ON_LINKS = (Target("on link 2", (1.0, 0.0, 0.1), "link_2"), Target("on link 4", (0.9, 0.0, 0.1), "link_4"))
SOFT_JOINT = 5  # joint 6, from 0
AT = 100.0  # N·m at which it has hardened by `hardens`, a form the catalogue does not have
PRIORS = {
    "softer": Prior("compliance of joint 6 over the model's", 1.5, 3, why="what is to be found"),
    "hardens": Prior("less compliance at 100 N·m", 0, 0.3, why="a form the catalogue does not have"),
}
SAID = ("named", "among", "wrong", "nothing")


@dataclass(frozen=True)
class Plan:
    """So many poses, once with each of the loads; on: targets besides the arm's own."""

    name: str
    count: int
    loads: tuple[str, ...] = ("",)
    on: tuple[Target, ...] = ()


PLANS = {
    "one": Plan("25 unloaded", 25),
    "more": Plan("50 unloaded", 50),
    "two": Plan("25 without and with 10 kg", 25, ("", "gun")),
    "links": Plan("25 twice, targets on links 2, 4", 25, ("", "gun"), ON_LINKS),
}


def hidden_draws(share: float, count: int, run: StudyRun) -> Draws:
    """Joint 6 softer than modelled, in so many draws, each measured by every plan and diagnosed. share: of
    the assumed compliance that the arm has."""
    return draw_many(partial(one_of_each, share), PRIORS, count, run, "hidden")


def one_of_each(share: float, values: Mapping[str, float], seed: int) -> dict[str, float]:
    """By plan: 1 for how its diagnosis speaks of joint 6."""
    robot = with_compliance(load_robot("longlink"), share)
    found: dict[str, float] = {}
    for key, plan in PLANS.items():
        said = verdict_of(diagnose(measured(robot, plan, [seed], values)).diagnosis)
        found |= {f"{kind}_{key}": float(kind == said) for kind in SAID}
        found[f"found_{key}"] = float(said in ("named", "among"))
    return found


def what_shows(folder: Path, robot: Robot, draws: Draws, run: StudyRun) -> Chapter:
    """What each plan could detect, and how often it finds a softer joint 6."""
    joints = robot.joint_names[1:6]
    found = {name: float(column.mean()) for name, column in draws.numbers.items()}
    smallest = {}
    for key, plan in PLANS.items():
        clean = diagnose(measured(robot, plan, [run.seed, 0])).diagnosis
        size = {x.where.joint: x.size for x in clean.detectable if x.cause == "joint_compliance"}
        smallest[key] = np.array([size.get(joint, np.nan) for joint in joints])
        found[f"detectable_{key}"] = smallest[key][-1]
    middle = {name: prior.middle for name, prior in PRIORS.items()}
    shown = measured(robot, PLANS["two"], [run.seed, 1], middle)
    write_campaign(folder / "campaign", shown, comments=["simulated in Drake"])
    gain = float(np.mean(smallest["more"][-2:] / smallest["two"][-2:]))
    found |= {"gain_two": gain, "hidden_draws": float(draws.count)} | taken_as_rigid(robot, run.seed)
    drawn = plans_figure({PLANS[p].name: x for p, x in smallest.items()}, joints, gain)
    return Chapter(found, {"plans": drawn, "hidden": hidden_table(found)})


def hidden_table(found: Mapping[str, float]) -> Table:
    """How often each plan finds the softer joint 6."""
    rows = [
        [plan.name, str(plan.count * len(plan.loads)), numbers.percent(found[f"detectable_{key}"], 0),
         *(numbers.percent(found[f"{kind}_{key}"], 0) for kind in SAID)]
        for key, plan in PLANS.items()
    ]  # fmt: skip
    head = ("Plan", "Points", "Detectable", "Named", "Among rivals", "Other", "Nothing")
    note = (
        f"Shares of {found['hidden_draws']:.0f} draws of seed, size and hardening. Detectable: smallest "
        "excess compliance of joint 6 "
        "that is found with 80 % power, all geometry free. Named: the stiffness of joint 6, or how it "
        "depends on torque, and "
        "nothing else; among rivals: with others; other: something else."
    )
    return Table("A joint 6 of 1.5 to 3 times the compliance", head, rows, note)


def taken_as_rigid(robot: Robot, seed: int) -> dict[str, float]:
    """The whole robot on the paper's kind of data, diagnosed with all its joints taken as rigid."""
    rigid = with_compliance(robot, 0.0)
    data, judged = (replace(measured(robot, PLANS["one"], [seed, k]), robot=rigid) for k in (0, 99))
    found = diagnose(data, judged).diagnosis
    return {
        "rigid_heldout_mm": found.stages[1].heldout_rms_mm,
        "rigid_diagnosed_mm": found.stages[-1].heldout_rms_mm,
        "rigid_causes": float(len(found.causes)),
        "rigid_right": float(sum(c.cause in ("joint_compliance", "bearing_tilt") for c in found.causes)),
    }


def measured(
    robot: Robot, plan: Plan, seed: Sequence[int], soft: Mapping[str, float] | None = None
) -> Campaign:
    """The plan's campaign, the ball's place unknown; soft: by how much joint 6 is softer, and hardens."""
    q = np.tile(ARM.poses(plan.count, [*seed, 7]), (len(plan.loads), 1))
    payload = [load for load in plan.loads for _ in range(plan.count)]
    compliance = 1 / (robot.joints[SOFT_JOINT].data.stiffness or np.inf)

    def law(wrench: Array) -> Array:
        assert soft is not None
        torque = wrench[5]  # about the joint's axis, z
        more = (soft["softer"] - 1) * compliance
        return np.asarray(np.eye(6)[5] * more * torque * (1 - soft["hardens"] * (torque / AT) ** 2))

    ball, *ring = ARM.targets
    targets = [replace(ball, fixed=False), *ring, *plan.on]
    further = {SOFT_JOINT + 1: law} if soft is not None else {}
    return ARM.measured(robot, q, [*seed, 8], targets, payload=payload, yields=further)


def verdict_of(diagnosis: Diagnosis) -> str:
    """How a diagnosis speaks of joint 6's stiffness: named, among (rivals), wrong, nothing."""

    def right(cause: str, where: Where) -> bool:
        return cause in ("joint_compliance", "lost_motion") and where.joint == "joint_6"

    causes = diagnosis.causes
    if not causes:
        return "nothing"
    if all(right(c.cause, c.where) and c.status == "named" for c in causes):
        return "named"
    said = [(c.cause, c.where) for c in causes]
    said += [(rival.cause, rival.where) for c in causes for rival in c.rivals]
    return "among" if any(right(*place) for place in said) else "wrong"
