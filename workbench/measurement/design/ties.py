"""What stands open between a cause and its rivals, how far apart they are, and the fewest records that settle
it.

λ is that of `t_optimal`, for the size that the cause was found with; the rival is taken as large as imitates
it best in what was measured. Settled is λ ≥ `LEVELS.mostly`, from where a diagnosis names the cause mostly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...diagnosis.result import Finding
from ...diagnosis.run import Outcome
from ...effects import catalogue
from ...effects.base import UNKNOWN, Effect
from ...robot.kinematics import Array
from .discrimination_plan import LEVELS
from .fedorov import Records, Search, information
from .prior_information import WIDE, ValuedEffects, from_prepared
from .t_optimal import DesignSpace, Pair, design_space, t_optimal

SMALLEST = 0.1  # usual sizes, of a rival that hardly imitates

Columns = NDArray[np.int64]


@dataclass(frozen=True)
class Tie:
    """An effect that was found, its size (p,) in usual ones, and the effects that rival it."""

    effect: Effect
    size: Array
    rivals: tuple[Effect, ...]

    @property
    def pairs(self) -> list[Pair]:
        """The cause beside each rival, and each rival beside the cause."""
        return [way for rival in self.rivals for way in ((self.effect, rival), (rival, self.effect))]


@dataclass(frozen=True)
class Attempts:
    """How the fewest records are looked for. first, fewest, most: records that are tried; times: how often at
    most; margin: by how much more than is thought to do it."""

    first: int
    fewest: int
    most: int
    times: int
    margin: float


def tie_of(outcome: Outcome, finding: Finding) -> Tie | None:
    """The finding as effects; None where it is named, or no rival has a name."""
    if finding.status == "named" or finding.cause == UNKNOWN:
        return None
    own = [i for i, e in enumerate(outcome.fit.model.effects) if e.key == (finding.cause, finding.where)]
    keys = dict.fromkeys((rival.cause, rival.where) for rival in finding.rivals if rival.cause != UNKNOWN)
    kinds = [catalogue()[cause] for cause in dict.fromkeys(cause for cause, _ in keys)]
    rivals = tuple(e for kind in kinds for e in kind.sites(outcome.problem) if e.key in keys)
    if not own or not rivals:
        return None
    strongest = max(own, key=outcome.fit.wald)
    effect = outcome.fit.model.effects[strongest]
    return tie_between(effect, outcome.fit.state.values[strongest], rivals)


def tie_between(effect: Effect, values: Array, rivals: tuple[Effect, ...]) -> Tie:
    """The tie of an effect that was found with these values (p,)."""
    return Tie(effect, values / np.array([p.typical for p in effect.params]), rivals)


def told_apart(outcome: Outcome, tie: Tie, before: Outcome) -> float:
    """λ of a tie in all that an outcome was made of; before: the outcome that left it."""
    valued = at_zero((tie,))
    both, first = (from_prepared(one.prepared).of_campaign(valued) for one in (outcome, before))
    assert both is not None
    space = design_space(both, first)
    return least(space, information(space.rows), tie)


def at_zero(ties: Sequence[Tie]) -> ValuedEffects:
    """The effects of ties, at zero."""
    effects = dict.fromkeys(e for tie in ties for e in (tie.effect, *tie.rivals))
    return tuple((effect, np.zeros(len(effect.params))) for effect in effects)


def as_found(space: DesignSpace, ties: Sequence[Tie]) -> DesignSpace:
    """The space with each cause in the size that was found, and each rival as large as imitates it best, in
    place of their usual sizes: what is hardest in it is what is hardest to settle."""
    scale, before = np.ones(len(space.names)), space.left(space.before)
    for tie in ties:
        for rival in tie.rivals:
            i, j = (space.columns(effect) for effect in (tie.effect, rival))
            imitation = _imitation(before, i - space.background, j - space.background, tie.size)
            scale[i] = np.maximum(np.abs(tie.size) * np.sqrt(len(i)), SMALLEST)
            scale[j] = np.maximum(np.abs(imitation) * np.sqrt(len(j)), SMALLEST)
    return replace(space, rows=space.rows * scale, before=space.before * np.outer(scale, scale))


def least(space: DesignSpace, data: Array, tie: Tie) -> float:
    """The smallest λ of the cause beside each of its rivals, and of each rival beside the cause, with the
    information data: (P, P)."""
    before, after = space.left(space.before), space.left(data)
    return min(min(_both(space, before, after, tie, rival)) for rival in tie.rivals)


def _both(space: DesignSpace, before: Array, after: Array, tie: Tie, rival: Effect) -> tuple[float, float]:
    i, j = (space.columns(effect) - space.background for effect in (tie.effect, rival))
    imitation = _imitation(before, i, j, tie.size)
    return unexplained(after, i, j, tie.size, WIDE**-2), unexplained(after, j, i, imitation, WIDE**-2)


def _imitation(left: Array, i: Columns, j: Columns, size: Array) -> Array:
    """The size of columns j that imitates columns i best."""
    S = left[np.ix_(j, j)] + WIDE**-2 * np.eye(len(j))
    return np.asarray(np.linalg.solve(S, left[np.ix_(j, i)] @ size), dtype=np.float64)


def unexplained(left: Array, i: Columns, j: Columns, size: Array, held: float) -> float:
    """λ of columns i in a size beside columns j, which are held to zero with this information."""
    cross = left[np.ix_(j, i)]
    S = left[np.ix_(j, j)] + held * np.eye(len(j))
    alone = left[np.ix_(i, i)] - cross.T @ np.linalg.solve(S, cross)
    return max(float(size @ alone @ size), 0.0)


def settled_at(now: float) -> float:
    """λ that settles it: more than there is where a rival holds out against it."""
    return max(LEVELS.mostly, now + LEVELS.least)


def fewest(
    space: DesignSpace, ties: Sequence[tuple[Tie, float]], search: Search, attempts: Attempts
) -> tuple[Records, float]:
    """The fewest records that settle all ties (each with its λ now), and the share of the way from that to
    `settled_at` that the hardest of them goes; below one: none settle them, and these were tried last."""
    pairs = list(dict.fromkeys(pair for tie, _ in ties for pair in tie.pairs))
    steering = as_found(space, [tie for tie, _ in ties])
    count, found, reached = attempts.first, None, 0.0
    for _ in range(attempts.times):
        chosen = t_optimal(steering, pairs, count, replace(search, starts=1))
        data = space.measured(chosen)
        share = min((least(space, data, tie) - now) / (settled_at(now) - now) for tie, now in ties)
        if found is None or share >= 1 or reached < 1:
            found, reached = chosen, share
        most = min(attempts.most, len(space.rows))
        wanted = int(np.clip(np.ceil(attempts.margin * count / max(share, 1e-6)), attempts.fewest, most))
        if wanted == count or (reached >= 1 and wanted >= len(found)):
            break
        count = wanted
    assert found is not None
    return found, reached
