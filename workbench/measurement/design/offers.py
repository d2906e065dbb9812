"""What may be measured next, and how many poses of it settle what stays open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from ...campaign import Campaign
from ...campaign.reflectors import with_reflectors
from ...effects import Key
from ...identification.fit import Fit
from ...robot.kinematics import Array
from .candidates import candidates, reach_of
from .causes import varied
from .discrimination_plan import MOST_MEASURED
from .fedorov import Search
from .prior_information import PriorInformation, Sensitivity, ValuedEffects
from .shown import with_shown
from .t_optimal import DesignSpace, design_space
from .ties import POWER, Attempts, Settling, Tie, fewest, least

POOL = 120  # candidate records
POSES = Attempts(first=24, fewest=24, most=60, times=2, margin=1.6)  # others may turn up as rivals
AMPLE = 5  # times as many poses of all kinds as anyone measures: none are so well chosen that they tell more
DRAWS = 3  # of random poses with torques
TORQUES = (18, 24, 30, 60)  # poses with them: offsets, scales, friction and noise come out of them too


@dataclass(frozen=True, eq=False)
class Offers:
    """What may be measured next. effects: at stake; measured: their sensitivity in the campaign; carried: the
    numbers of the fitted model's effects that have one; unsettled: those that stand in for what has no name,
    with numbers that the data do not settle: what a reading of them would have to be nobody knows."""

    prior: PriorInformation
    effects: ValuedEffects
    measured: Sensitivity | None
    carried: Mapping[Key, float] = field(default_factory=dict)
    unsettled: frozenset[Key] = frozenset()

    @cached_property
    def records(self) -> Campaign:
        """Records as `plan` offers them, but for whether the poses hang together: a plan's matter."""
        around = reach_of(self.prior, 0)
        factors = varied(effect for effect, _ in self.effects).possible(around.cell.driving)
        draw = partial(around.draw, linked=False)
        return candidates(self.prior, POOL, factors, np.random.default_rng(21), draw)

    @cached_property
    def space(self) -> DesignSpace:
        return design_space(self.prior.of_records(self.records, self.effects), self.measured)

    def with_reflectors(self, links: Sequence[str]) -> DesignSpace:
        """The records with a target more on each of these links."""
        records = with_reflectors(self.records, links)
        return design_space(
            self.prior.with_reflectors(links).of_records(records, self.effects), self.measured
        )

    @property
    def _torques_tell(self) -> bool:
        """Whether the drives' torques were not recorded, but a load is in it."""
        return not self.prior.problem.drives and any(effect.acts == "load" for effect, _ in self.effects)

    @cached_property
    def with_torques(self) -> DesignSpace | None:
        """The records with the drives' torques; None where these would tell nothing new."""
        if not self._torques_tell:
            return None
        prior = replace(self.prior, torques=True)
        return design_space(prior.of_records(self.records, self.effects), self.measured)

    @cached_property
    def torques(self) -> tuple[tuple[int, tuple[DesignSpace, ...]], ...]:
        """Some draws of so many random records with the drives' torques, few first: what is common to a
        joint's torques is taken out of those poses alone. None where these would tell nothing new."""
        if not self._torques_tell:
            return ()
        prior = replace(self.prior, torques=True)

        def space(count: int, draw: int) -> DesignSpace:
            chosen = np.sort(np.random.default_rng([23, draw]).permutation(POOL)[:count])
            return design_space(prior.of_records(self.records.some(chosen), self.effects), self.measured)

        return tuple((count, tuple(space(count, draw) for draw in range(DRAWS))) for count in TORQUES)


@dataclass(frozen=True, eq=False)
class Poses:
    """How many poses settle ties, with the margin; data: (P, P) information after them, None where these are
    more than `POSES.most`."""

    count: int
    space: DesignSpace
    data: Array | None

    def after(self, tie: Tie) -> float | None:
        """λ of a tie after them, where it is known."""
        return None if self.data is None else least(self.space, self.data, tie)

    def with_at_least(self, count: int) -> Poses:
        """The same, or so many."""
        return replace(self, count=max(self.count, count))


def roughly_settled(space: DesignSpace, tie: Tie, fit: Fit | None) -> Poses | None:
    """Poses on offer, as they come, that settle a tie: more than chosen ones, and found at once."""
    if not with_shown(space, tie, fit).rivals:
        return None
    needed = Settling(space, [tie]).needed(np.arange(len(space.rows)))
    if needed is None or POSES.margin * needed > MOST_MEASURED:
        return None
    return Poses(10 * int(np.ceil(max(POSES.fewest, POSES.margin * needed) / 10)), space, None)


def settled(space: DesignSpace, ties: Sequence[Tie], fit: Fit | None) -> Poses | None:
    """Poses that settle all ties; None where it takes more than anyone measures, or none shows a rival."""
    if not all(with_shown(space, tie, fit).rivals for tie in ties):
        return None
    settling = Settling(space, ties)
    if settling.power(space.measured(np.arange(POOL), AMPLE * MOST_MEASURED)) < POWER:
        return None  # however they are chosen
    chosen, _ = fewest(space, ties, Search(POOL, 1, 0), POSES)
    needed = settling.needed(chosen)
    if needed is None or POSES.margin * needed > MOST_MEASURED:
        return None
    count = max(POSES.fewest, int(np.ceil(POSES.margin * needed)))
    if count > POSES.most:
        return Poses(10 * int(np.ceil(count / 10)), space, None)
    return Poses(count, space, space.measured(chosen, count))
