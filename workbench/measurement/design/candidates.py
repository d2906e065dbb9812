"""Records that could be measured, and the order in which to measure those that are chosen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.cell import CellData, DrivingData
from ...campaign.planned import random_poses
from ...campaign.problem import REFERENCE_TEMPERATURE
from ..driving.reach import Draw, Reach, reach
from .prior_information import PriorInformation

DRAWS = 25  # random plans behind a median
FEWEST = 40  # joint positions, however many loads and states they are offered in
WARM = REFERENCE_TEMPERATURE + 10.0  # °C, of an arm that has worked for an hour or two


@dataclass(frozen=True)
class Factors:
    """Factors of a plan besides pose and payload: the side of approach, cold or warm, early or late; pull:
    [N] of a horizontal pull at the flange, along the base's y, that can be rigged (0: none); apart: [s] from
    one session to the next."""

    approach: bool = False
    warm: bool = False
    late: bool = False
    pull: float = 0.0
    apart: float = 60 * DrivingData().warm_up_min

    def possible(self, driving: DrivingData) -> Factors:
        """With the pull that can be rigged, and the time that it takes to work the arm warm."""
        return replace(self, pull=driving.pull_N or 0.0, apart=60 * driving.warm_up_min)

    @property
    def sessions(self) -> list[tuple[float, float]]:
        """Start [s] and temperature [°C] of each session: cold, warm and cold again; or first and last."""
        cold = REFERENCE_TEMPERATURE
        if self.warm:
            return [(0.0, cold), (self.apart, WARM), (2 * self.apart, cold)]
        return [(0.0, cold), (2 * self.apart, cold)] if self.late else [(0.0, cold)]


def reach_of(prior: PriorInformation, seed: int, cell: CellData | None = None) -> Reach:
    """The robot in its cell (default: that of the campaign). Raises InputError."""
    problem, rng = prior.problem, np.random.default_rng([seed, 24])
    return reach(problem, prior.known_places, cell or problem.campaign.cell, rng, prior.shown)


def candidates(
    prior: PriorInformation,
    count: int,
    factors: Factors,
    rng: np.random.Generator,
    draw: Draw | None = None,
) -> Campaign:
    """About `count` possible records: random poses with every load and in every session. draw: of poses that
    can be measured; None: any. Raises InputError where hardly any pose is possible."""
    payloads = prior.mountable
    sessions = factors.sessions
    pulls = 2 if factors.pull else 1
    several = len(payloads) * len(sessions) * pulls
    positions = max(FEWEST, count // several)
    q = random_poses(prior.robot, positions, rng) if draw is None else draw(positions, rng)
    grids = np.meshgrid(payloads, range(len(sessions)), range(pulls))
    payload, session, pulled = (grid.ravel() for grid in grids)
    records = prior.records(np.tile(q, (several, 1)), np.repeat(payload, len(q)))
    start, temperature = (
        np.repeat(np.array(column)[session], len(q)) for column in zip(*sessions, strict=True)
    )
    wrench = np.zeros((len(records.poses), 6))
    wrench[:, 1] = factors.pull * np.repeat(pulled, len(q))
    side = rng.choice([-1.0, 1.0], size=records.poses.q.shape)
    return records.with_poses(
        wrench=wrench,
        side=side if factors.approach else None,
        time=start if factors.warm or factors.late else None,
        temperature=temperature if factors.warm else None,
    )


def random_rows(offered: int, count: int, seed: int, draw: int = 0) -> NDArray[np.int64]:
    """As many random ones of the records on offer, beside which a plan is held; draw: which of some."""
    return np.random.default_rng([seed, 23, draw]).permutation(offered)[:count]


def random_draws(offered: int, count: int, seed: int) -> list[NDArray[np.int64]]:
    """`DRAWS` times as many random ones, each sorted."""
    return [np.sort(random_rows(offered, count, seed, draw)) for draw in range(DRAWS)]


def take(records: Campaign, chosen: NDArray[np.int64]) -> Campaign:
    """Some of the records, named in the order of the plan."""
    title = f"{records.robot.title}, {len(chosen)} planned poses"
    return replace(
        records.some(chosen).with_poses(ids=tuple(str(i + 1) for i in range(len(chosen)))), title=title
    )


def payload_counts(records: Campaign) -> dict[str, int]:
    """How many records carry which payload ("": none)."""
    return {name: int((records.poses.payload == i).sum()) for i, name in enumerate(records.payload_names)}
