"""Records that could be measured, and the order in which to measure those that are chosen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.planned import random_poses
from ...campaign.problem import REFERENCE_TEMPERATURE
from ...robot.description import Robot
from ...robot.kinematics import Array
from .prior_information import PriorInformation

FEWEST = 40  # joint positions, however many loads and states they are offered in
WARM = REFERENCE_TEMPERATURE + 10.0  # °C, of an arm that has worked for an hour or two
SESSION = 7200.0  # s between the sessions of a plan
PACE = 60.0  # s for a record


@dataclass(frozen=True)
class Factors:
    """Factors of a plan besides pose and payload: the side of approach, cold or warm, early or late."""

    approach: bool = False
    warm: bool = False
    late: bool = False

    @property
    def sessions(self) -> list[tuple[float, float]]:
        """Start [s] and temperature [°C] of each session: cold, warm and cold again; or first and last."""
        cold = REFERENCE_TEMPERATURE
        if self.warm:
            return [(0.0, cold), (SESSION, WARM), (2 * SESSION, cold)]
        return [(0.0, cold), (2 * SESSION, cold)] if self.late else [(0.0, cold)]


def candidates(prior: PriorInformation, count: int, factors: Factors, rng: np.random.Generator) -> Campaign:
    """About `count` possible records: random poses with every load and in every session. Raises InputError
    where hardly any pose is possible."""
    payloads = len(prior.problem.campaign.payload_names)
    sessions = factors.sessions
    several = payloads * len(sessions)
    q = random_poses(prior.robot, max(FEWEST, count // several), rng)
    payload, session = (grid.ravel() for grid in np.meshgrid(range(payloads), range(len(sessions))))
    records = prior.records(np.tile(q, (several, 1)), np.repeat(payload, len(q)))
    start, temperature = (
        np.repeat(np.array(column)[session], len(q)) for column in zip(*sessions, strict=True)
    )
    side = rng.choice([-1.0, 1.0], size=records.poses.q.shape)
    return records.with_poses(
        side=side if factors.approach else None,
        time=start if factors.warm or factors.late else None,
        temperature=temperature if factors.warm else None,
    )


def take(records: Campaign, chosen: NDArray[np.int64]) -> Campaign:
    """Some of the records, named in the order of the plan."""
    title = f"{records.robot.title}, {len(chosen)} planned poses"
    return replace(
        records.some(chosen).with_poses(ids=tuple(str(i + 1) for i in range(len(chosen)))), title=title
    )


def ordered(plan: Campaign) -> Campaign:
    """The plan session by session, load by load, and from each pose to the nearest one that is left: the
    nearest by the joint that travels the largest share of its range. Times go on from record to record."""
    span = _spans(plan.robot)
    session = np.zeros(len(plan.poses.q)) if plan.poses.time is None else plan.poses.time
    order: list[int] = []
    here = np.zeros(len(span))
    for group in np.unique(np.column_stack([session, plan.poses.payload]), axis=0):
        left = list(np.flatnonzero((session == group[0]) & (plan.poses.payload == group[1])))
        while left:
            travel = (np.abs(plan.poses.q[left] - here) / span).max(axis=1)
            order.append(int(left.pop(int(np.argmin(travel)))))
            here = plan.poses.q[order[-1]]
    plan = take(plan, np.array(order, dtype=np.int64))
    if plan.poses.time is None:
        return plan
    run = np.arange(len(plan.poses.q)) - np.searchsorted(plan.poses.time, plan.poses.time)
    return plan.with_poses(time=plan.poses.time + PACE * run)


def payload_counts(records: Campaign) -> dict[str, int]:
    """How many records carry which payload ("": none)."""
    return {name: int((records.poses.payload == i).sum()) for i, name in enumerate(records.payload_names)}


def travel(plan: Campaign) -> float:
    """Mean share of its range that the joint which travels farthest moves from record to record."""
    steps = np.abs(np.diff(plan.poses.q, axis=0)) / _spans(plan.robot)
    return float(steps.max(axis=1).mean()) if len(steps) else 0.0


def _spans(robot: Robot) -> Array:
    span = np.array([joint.upper - joint.lower for joint in robot.joints])
    return np.where(np.isfinite(span), span, 2 * np.pi)
