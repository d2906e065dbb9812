"""The next records for accuracy: least mean squared error of what the calibrated model predicts.

Parameters are frames, targets, geometry, the joints' compliances and the effects that the robot's own TOML
states; held by the priors of a fit and by what was measured already. What counts is the mean over typical
poses, with every stated load, of the squared 3-D error of the targets (source 002, eqs. (17), (18)), frame
and targets fitted there: that of the model itself, as `diagnose --test` judges it in a new set-up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...diagnosis.result import FaultFound
from ...effects.joint_compliance import JointCompliance
from ...robot.kinematics import Array
from .candidates import Factors, candidates, ordered, payload_counts, take
from .fedorov import criterion, exchange, information
from .knowledge import Acting, Knowledge, Rows, information_before

TYPICAL = 300  # poses whose mean squared error counts
DRAWS = 25  # random plans behind a median
MOST = 100  # times the plan's number of random poses that are tried


@dataclass(frozen=True)
class AccuracyPlan:
    """Records for accuracy, in the order to measure them, and the expected errors [mm]: one sigma, 3-D, of
    the model's prediction from noise alone. now_mm: from the campaign (None: there is none); random_mm: the
    median after as many random records; same: random records for the error of this plan (None: more than
    `MOST` times as many); faults: of the campaign's data."""

    records: Campaign
    noise: str
    now_mm: float | None
    random_mm: float
    plan_mm: float
    same: int | None
    faults: tuple[FaultFound, ...] = ()

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": "accuracy",
            "n_poses": len(self.records.q),
            "payloads": payload_counts(self.records),
            "noise": self.noise,
            "faults": [fault.to_json() for fault in self.faults],
            "now_mm": self.now_mm,
            "random_mm": self.random_mm,
            "plan_mm": self.plan_mm,
            "random_poses_for_the_same": self.same,
        }

    @property
    def text(self) -> str:
        n = len(self.records.q)
        same = f"about {self.same}" if self.same else f"more than {MOST * n}"
        lines = [
            "Expected error of the calibrated model, 3-D, one sigma, from noise alone",
            f"({self.noise}):",
            *([] if self.now_mm is None else [f"  now                    {self.now_mm:8.4f} mm"]),
            f"  after {n:4d} random poses {self.random_mm:8.4f} mm",
            f"  after this plan        {self.plan_mm:8.4f} mm; it takes {same} random poses for the same",
        ]
        return "\n".join(lines)


def plan_accuracy(known: Knowledge, count: int, pool: int, starts: int, seed: int) -> AccuracyPlan:
    """`count` records out of about `pool` candidates. Raises InputError where that cannot be."""
    rng = np.random.default_rng([seed, 21])
    offered = candidates(known, pool, Factors(), rng)
    effects = _effects(known)
    new, before = known.new(offered, effects), known.measured(effects)
    typical = candidates(known, TYPICAL, Factors(), rng)
    error = 1e3 * known.typical(typical, effects) / np.sqrt(len(typical.q))  # mm
    names = list(dict.fromkeys([*(before.names if before else ()), *new.names]))
    rows = new.on(names)
    # the same A0ᵀ A0 in few rows
    A0 = Rows(new.names, np.asarray(np.linalg.qr(error, mode="r"))[None]).on(names)[0]
    prior = np.diag(information_before(names))
    if before is not None:
        prior += information(before.on(names))
    chosen, plan_mm = exchange(rows, A0, count, prior=prior, starts=starts, seed=seed)
    nothing = rows[:0]
    return AccuracyPlan(
        ordered(take(offered, chosen)),
        known.noise,
        None if before is None else criterion(nothing, A0, prior),
        _random(rows, A0, prior, count, seed),
        plan_mm,
        _as_good(rows, A0, prior, count, plan_mm, seed),
    )


def _effects(known: Knowledge) -> Acting:
    """The effects whose parameters are open: those of the robot's TOML, and every joint's compliance."""
    stated = {effect.key for effect, _ in known.acting}
    every = [effect for effect in JointCompliance.sites(known.problem) if effect.key not in stated]
    return (*known.acting, *((effect, np.zeros(1)) for effect in every))


def _random(rows: Array, A0: Array, prior: Array, count: int, seed: int) -> float:
    """Median criterion of `count` random records, drawn with repeats: the candidates stand for all poses."""
    values = []
    for draw in range(DRAWS):
        chosen = np.random.default_rng([seed, 22, draw]).integers(len(rows), size=count)
        values.append(criterion(rows[chosen], A0, prior))
    return float(np.median(values))


def _as_good(rows: Array, A0: Array, prior: Array, count: int, wanted: float, seed: int) -> int | None:
    """Fewest random records with a median criterion of `wanted`; None where that takes too many."""
    low, high = count, count
    while _random(rows, A0, prior, high, seed) > wanted:
        if high >= MOST * count:
            return None
        low, high = high, 2 * high
    while high - low > max(1, low // 50):
        middle = (low + high) // 2
        low, high = (middle, high) if _random(rows, A0, prior, middle, seed) > wanted else (low, middle)
    return high
