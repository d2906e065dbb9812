"""Which measurement tells a soft gear of the KR 120 from a changed compensator?

Each machine is diagnosed from the paper's own records, read as absolute poses; from poses under three loads,
some of which reverse joint 2's torque; and from these with motor torque.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from workbench import (
    Campaign,
    Outcome,
    Problem,
    Rig,
    Robot,
    diagnose,
    load_pairs,
    planned,
    random_poses,
    write_campaign,
)

WAYS = ("the 31 pairs, read as absolute poses", "poses under three loads", "… with motor torque")


def three_loads(robot: Robot, rig: Rig, poses: int, seed: int) -> Campaign:
    """The plan: random poses with the tool alone, with half the load, with the load."""
    q = random_poses(robot, poses, np.random.default_rng([seed, 3]), floor=0.4, clear=0.6)
    mass, place = rig.load
    loads = {"half": (mass / 2, place), "full": rig.load}
    return planned(
        robot,
        np.tile(q, (3, 1)),
        targets=rig.targets,
        payloads=loads,
        payload=[name for name in ("", *loads) for _ in range(poses)],
        tool=rig.tool,
        title=f"{robot.title}, {poses} poses under three loads",
    )


def diagnosed(
    folder: Path, data: Mapping[str, Campaign], rich: Mapping[str, Campaign], seed: int
) -> dict[str, dict[str, Outcome]]:
    """Diagnoses by way and machine. data: its pairs; rich: its poses under three loads, kept in `folder`."""
    found: dict[str, dict[str, Outcome]] = {way: {} for way in WAYS}
    for name, full in rich.items():
        write_campaign(folder / name, full, comments=["simulated in Drake"])
        campaigns = load_pairs.as_one_setup(data[name]), full.with_poses(torque=None), full
        for way, campaign in zip(WAYS, campaigns, strict=True):
            found[way][name] = diagnose(campaign, seed=seed)
    return found


def reversing(problem: Problem) -> dict[str, float]:
    """In how many of the poses the loads reverse joint 2's torque."""
    bare, _, full = problem.nominal_load.local[:, 2, 5].reshape(3, -1)
    return {"rich_poses": float(len(bare)), "reversing": float((bare * full < 0).sum())}
