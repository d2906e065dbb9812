"""The next records for accuracy: least mean squared error of what the calibrated model predicts.

Parameters are frames, targets, geometry, the joints' compliances and the effects that the robot's own TOML
states; held by the priors of a fit and by what was measured already. The plan is I-optimal: what counts is
the mean over typical poses, with every stated load, of the squared 3-D error of the targets (Klimchik et al.
2017, eqs. (17), (18)), frame and targets fitted there: that of the model itself, as `diagnose --test` judges
it in a new set-up.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...campaign import Campaign
from ...effects.joint_compliance import JointCompliance
from ...robot.kinematics import Array
from ..driving.ways import Ways
from .accuracy_plan import MOST_TRIED, AccuracyPlan
from .budget import Question, in_time
from .candidates import DRAWS, Factors, candidates, random_rows, take
from .fedorov import Records, Search, criterion, exchange, information
from .prior_information import PriorInformation, Sensitivity, ValuedEffects, prior_precision

TYPICAL = 300  # poses whose mean squared error counts


@dataclass(frozen=True, eq=False)
class AccuracySpace(Question):
    """Candidate records and what is asked, on common parameters. rows: (C, D, P) of the candidates; A0: (D0,
    P) rows [mm] whose mean squared error counts; held: (P, P) prior and measured information."""

    prior: PriorInformation
    effects: ValuedEffects
    names: tuple[str, ...]
    offered: Campaign
    rows: Array
    A0: Array
    held: Array
    measured: bool
    search: Search

    def looking_at(self, names: Collection[str]) -> AccuracySpace:
        offered = self.offered.looking_at(names)
        return replace(
            self, offered=offered, rows=self.prior.of_records(offered, self.effects).on(self.names)
        )

    def chosen(self, among: Records, count: int) -> Records:
        """The records (count,) after which the error is least."""
        found, _ = exchange(
            self.rows[among], self.A0, count, prior=self.held, starts=1, seed=self.search.seed
        )
        return among[found]

    def error(self, records: Campaign) -> float:
        """Expected error [mm] after these records."""
        return criterion(self.prior.of_records(records, self.effects).on(self.names), self.A0, self.held)

    def worth(self, records: Campaign) -> float:
        """1/e² [1/mm²], less what was there before."""
        return self.error(records) ** -2 - (self.now or np.inf) ** -2

    @cached_property
    def now(self) -> float | None:
        """Expected error [mm] from what was measured; None: nothing was."""
        return criterion(self.rows[:0], self.A0, self.held) if self.measured else None


def accuracy_space(prior: PriorInformation, search: Search) -> AccuracySpace:
    """Candidates for accuracy. Raises InputError where there are none."""
    rng = np.random.default_rng([search.seed, 21])
    offered = candidates(prior, search.pool, Factors().possible(search.driving), rng, search.draw)
    effects = _effects(prior)
    new, before = prior.of_records(offered, effects), prior.of_campaign(effects)
    typical = candidates(prior, TYPICAL, Factors(), rng)
    error = 1e3 * prior.of_predictions(typical, effects) / np.sqrt(len(typical.poses.q))  # mm
    names = tuple(dict.fromkeys([*(before.names if before else ()), *new.names]))
    # the same A0ᵀ A0 in few rows
    A0 = Sensitivity(new.names, np.asarray(np.linalg.qr(error, mode="r"))[None]).on(names)[0]
    held = np.diag(prior_precision(names))
    if before is not None:
        held += information(before.on(names))
    return AccuracySpace(prior, effects, names, offered, new.on(names), A0, held, before is not None, search)


def plan_accuracy(prior: PriorInformation, count: int, search: Search) -> AccuracyPlan:
    """`count` records out of the candidates. Raises InputError where that cannot be."""
    space = accuracy_space(prior, search)
    rows = space.rows
    chosen, _ = exchange(rows, space.A0, count, prior=space.held, starts=search.starts, seed=search.seed)
    return _plan(space, take(space.offered, chosen))


def plan_accuracy_in_time(
    prior: PriorInformation, seconds: float, search: Search, ways: Ways, dwell: float
) -> AccuracyPlan:
    """The records that bring most in a time. Raises InputError where that cannot be."""
    space = accuracy_space(prior, search)
    best, alone = in_time(space, ways, dwell, seconds)
    made = _plan(space, best.drive.plan)
    return replace(made, over_poses=best.rate / alone.rate, stops=best.stops)


def _plan(space: AccuracySpace, records: Campaign) -> AccuracyPlan:
    chance, count = _Chance(space.rows, space.A0, space.held, space.search.seed), len(records.poses)
    error = space.error(records)
    return AccuracyPlan(
        records,
        space.prior.noise,
        now_mm=space.now,
        random_mm=chance.median(count),
        plan_mm=error,
        same=chance.records_for(error, count),
        random=take(space.offered, random_rows(len(space.rows), count, space.search.seed)),
    )


def _effects(prior: PriorInformation) -> ValuedEffects:
    """The effects whose parameters are open: those of the robot's TOML, and every joint's compliance."""
    stated = {effect.key for effect, _ in prior.acting}
    every = [effect for effect in JointCompliance.each(prior.problem) if effect.key not in stated]
    return (*prior.acting, *((effect, np.zeros(1)) for effect in every))


@dataclass(frozen=True)
class _Chance:
    """What random records reach. rows: (C, D, P) of the candidates, which stand for all poses; A0: (D0, P);
    held: (P, P) prior information."""

    rows: Array
    A0: Array
    held: Array
    seed: int

    def median(self, count: int) -> float:
        """Median criterion of `count` random records, drawn with repeats."""
        values = []
        for draw in range(DRAWS):
            chosen = np.random.default_rng([self.seed, 22, draw]).integers(len(self.rows), size=count)
            values.append(criterion(self.rows[chosen], self.A0, self.held))
        return float(np.median(values))

    def records_for(self, wanted: float, count: int) -> int | None:
        """Fewest records with a median of `wanted`; None where that takes more than `MOST_TRIED` times
        `count`."""
        low, high = 1, count
        while self.median(high) > wanted:
            if high >= MOST_TRIED * count:
                return None
            low, high = high, 2 * high
        while high - low > max(1, low // 50):
            middle = (low + high) // 2
            low, high = (middle, high) if self.median(middle) > wanted else (low, middle)
        return high
