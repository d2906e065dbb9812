"""The whole loop on a simulated KR 500: measure, diagnose, extend the model.

Hidden in the robot: a harmonic-drive error in joint 4 (with a harmonic that the catalogue's form does
not have), a gas compensator that has lost a tenth of its charge, backlash in joint 5, and an ordinary
robot's errors of geometry. The campaign is what a laser tracker would see of Drake's loaded robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arm import Array
from ..campaign import Campaign, load_campaign, write_campaign
from ..diagnose.run import Outcome, diagnose
from ..poses import planned, random_poses
from ..problem import Problem, problem
from ..records import parse_effect
from ..report.outcome import write_outcome
from ..report.terminal import short_verdict
from ..robot import load_robot
from ..simulate import Truth, random_geometry, simulate

Progress = Callable[[str], None]

HIDDEN = (
    "gear_kinematic_error:joint=joint_4,order={order},amplitude=2.2e-4,phase=0.6",
    "gravity_compensator:variant=charge,relative=-0.10",
    "backlash:joint=joint_5,half_width=6e-5",
)


@dataclass(frozen=True)
class Summary:
    """What the demo printed."""

    outcome: Outcome
    folder: Path

    @property
    def text(self) -> str:
        return short_verdict(self.outcome.diagnosis, self.folder)

    def to_json(self) -> dict[str, Any]:
        return self.outcome.diagnosis.to_json()


def demo(folder: Path, seed: int, progress: Progress, quick: bool = False) -> Summary:
    """Runs the demo and writes everything under `folder`."""
    progress("measuring a KR 500 in Drake: two loads, three targets, 30 µm noise")
    campaign, _ = measured(seed, 60 if quick else 150)
    path = write_campaign(folder / "campaign", campaign, comments=["simulated in Drake"])
    outcome = diagnose(load_campaign(path), None, progress, seed)
    progress("writing the page, the report and the scene")
    write_outcome(outcome, folder)
    return Summary(outcome, folder)


def measured(seed: int, poses: int) -> tuple[Campaign, Truth]:
    """The demo's campaign and the truth behind it."""
    rng = np.random.default_rng([seed, 500])
    robot = load_robot("kr500")
    q = np.tile(random_poses(robot, poses, rng, share=0.8), (2, 1))
    plan = planned(
        robot,
        q,
        payloads={"heavy": (250.0, (0.0, 0.0, 0.15))},
        payload=[""] * poses + ["heavy"] * poses,
        tool=(60.0, (0.0, 0.0, 0.08)),
        direction=rng.choice([-1.0, 1.0], size=q.shape),
        title="KR 500, laser tracker, two loads",
    )
    job = problem(plan)
    order = 2 * (robot.joints[3].data.gear_ratio or 100.0)
    truth = Truth(
        geometry=random_geometry(job.arm, rng),
        effects=tuple(parse_effect(text.format(order=order), job) for text in HIDDEN),
        joints=lambda p: _second_harmonic(p, order),
        sigma=3e-5,
    )
    return simulate(plan, truth, seed=seed, torque_sigma=0.03), truth


def _second_harmonic(job: Problem, order: float) -> Array:
    """What real harmonic drives have besides: a fifth of the amplitude at twice the order, joint 4."""
    out = np.zeros_like(job.q)
    out[:, 3] = 4.4e-5 * np.sin(2 * order * job.q[:, 3] + 1.1)
    return out
