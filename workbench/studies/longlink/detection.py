"""What data would show flexibility: four plans, a joint 6 that is softer than modelled, and a rigid model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Campaign,
    Diagnosis,
    Robot,
    Target,
    Where,
    diagnose,
    with_compliance,
    write_campaign,
)

from .arm import ARM
from .figures import Chapter, plans_figure

ON_LINKS = (Target("on link 2", (1.0, 0.0, 0.1), "link_2"), Target("on link 4", (0.9, 0.0, 0.1), "link_4"))
SOFT_JOINT = 5  # joint 6, from 0
HARDENS, AT = 0.2, 100.0  # assumed: so much less compliant at so many N·m, a form the catalogue does not have


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


def what_shows(folder: Path, robot: Robot, seed: int, draws: int) -> Chapter:
    """What each plan could detect, and how often it finds a joint 6 of twice the compliance."""
    joints = robot.joint_names[1:6]
    numbers, smallest = {"hidden_draws": float(draws)}, {}
    for key, plan in PLANS.items():
        clean = diagnose(measured(robot, plan, [seed, 0])).diagnosis
        size = {x.where.joint: x.size for x in clean.detectable if x.cause == "joint_compliance"}
        smallest[key] = np.array([size.get(joint, np.nan) for joint in joints])
        hidden = [measured(robot, plan, [seed, k], soft=True) for k in range(draws)]
        said = [verdict_of(diagnose(campaign).diagnosis) for campaign in hidden]
        share = {kind: said.count(kind) / draws for kind in ("named", "among", "wrong", "nothing")}
        numbers |= {f"{kind}_{key}": value for kind, value in share.items()}
        numbers[f"found_{key}"] = share["named"] + share["among"]
        numbers[f"detectable_{key}"] = smallest[key][-1]
        if key == "two":
            write_campaign(folder / "campaign", hidden[0], comments=["simulated in Drake"])
    gain = float(np.mean(smallest["more"][-2:] / smallest["two"][-2:]))
    numbers |= {"gain_two": gain} | taken_as_rigid(robot, seed)
    drawn = plans_figure({PLANS[p].name: x for p, x in smallest.items()}, joints, gain)
    return Chapter(numbers, {"plans": drawn})


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


def measured(robot: Robot, plan: Plan, seed: Sequence[int], soft: bool = False) -> Campaign:
    """The plan's campaign, the ball's place unknown; soft: joint 6 yields twice as much, hardening."""
    q = np.tile(ARM.poses(plan.count, [*seed, 7]), (len(plan.loads), 1))
    payload = [load for load in plan.loads for _ in range(plan.count)]
    compliance = 1 / (robot.joints[SOFT_JOINT].data.stiffness or np.inf)

    def law(wrench: Array) -> Array:
        torque = wrench[5]  # about the joint's axis, z
        return np.asarray(np.eye(6)[5] * compliance * torque * (1 - HARDENS * (torque / AT) ** 2))

    ball, *ring = ARM.targets
    targets = [replace(ball, fixed=False), *ring, *plan.on]
    further = {SOFT_JOINT + 1: law} if soft else {}
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
