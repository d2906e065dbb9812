"""Small campaigns measured in Drake with something hidden in the robot, for tests of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np

from workbench.campaign import Campaign
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import Problem, problem_of
from workbench.diagnosis.result import Diagnosis
from workbench.diagnosis.run import diagnose
from workbench.effects.base import Effect
from workbench.effects.records import parse_effect
from workbench.identification.fit import Fit
from workbench.robot.description import Robot, load_robot
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate

SIGMA = 3e-5  # m


@cache
def robot(name: str) -> Robot:
    """A robot of the workbench, or a random one like "6R"."""
    if name not in ("6R", "7R"):
        return load_robot(name)
    return load_robot(write_random_robot(Path(mkdtemp()), 3, name))


def measured(
    name: str = "kr500",
    effects: tuple[str, ...] = (),
    *,
    poses: int = 60,
    seed: int = 1,
    loads: tuple[float, ...] = (250.0,),
    repeats: int = 1,
    targets: int = 3,
    joints: Callable[[Problem], np.ndarray] | None = None,
    motion: Callable[[Problem], dict[int, np.ndarray]] | None = None,
    q: np.ndarray | None = None,
    sigma: float = SIGMA,
    state_sigma: bool = True,
    torque_sigma: float | None = None,
    **columns: Any,
) -> Campaign:
    """`poses` random poses, without payload and with each of `loads` [kg], all `repeats` times.

    effects: as on the command line; joints, motion: further errors of the joints, of
    the frames, in any form.
    """
    arm = robot(name)
    rng = np.random.default_rng([seed, 77])
    q = random_poses(arm, poses, rng) if q is None else q
    names = ["", *(f"load_{i + 1}" for i in range(len(loads)))]
    whole = np.tile(q, (len(names) * repeats, 1))
    side = rng.choice([-1.0, 1.0], size=(len(names) * len(q), q.shape[1]))
    plan = planned(
        arm,
        whole,
        targets=TARGETS[:targets],
        payloads={key: (mass, (0.05, 0.0, 0.15)) for key, mass in zip(names[1:], loads, strict=True)},
        payload=[key for key in names for _ in range(len(q))] * repeats,
        direction=np.tile(side, (repeats, 1)),
        **columns,
    )
    job = problem_of(plan)
    truth = Truth(
        geometry=random_geometry(job.arm, rng),
        effects=tuple(parse_effect(text, job) for text in effects),
        joints=joints,
        motion=motion,
        sigma=sigma,
    )
    return simulate(plan, truth, seed=seed, state_sigma=state_sigma, torque_sigma=torque_sigma)


def found(campaign: Campaign) -> Diagnosis:
    """The diagnosis."""
    return diagnose(campaign).diagnosis


def named(diagnosis: Diagnosis) -> dict[tuple[str, str], str]:
    """(cause, place) → status."""
    return {(finding.cause, str(finding.where)): finding.status for finding in diagnosis.causes}


def with_points(campaign: Campaign, points: np.ndarray) -> Campaign:
    """The campaign with other points."""
    return replace(campaign, points=points)


def assert_slopes(result: Fit, effect: Effect, values: np.ndarray) -> None:
    """The effect's Jacobian is the derivative of what the whole model predicts."""
    model = replace(result.model, effects=(effect,))
    step = 0.1 * values
    states = [replace(result.state, values=(values + sign * step,)) for sign in (1, -1)]
    up, down = (model.predict(state) for state in states)
    line = model.linearise(replace(result.state, values=(values,)))
    slope = model.effect_jacobian(line, effect, values) @ (2 * step)
    moved = np.abs(up - down).max()
    assert np.abs(slope.reshape(up.shape) - (up - down)).max() < max(1e-3 * moved, 1e-12)
