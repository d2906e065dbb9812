"""What stands open between a cause and its rivals, how far apart they are, and the fewest records that settle
it.

λ is that of `t_optimal`, for the size that the cause was found with; the rival is taken as large as imitates
it best in what was measured. Settled is λ ≥ `LEVELS.mostly`, from where a diagnosis names the cause mostly.

A rival may contain the cause, as a map of a joint contains the sine of its wheel: no pose tells the sine
from that. What refutes the map is that nothing else of it is seen: with S the information on its other
numbers in the size s that imitates the cause, twice the log Bayes factor against it is expected to be
Σ log(1 + s² S_k) − s² S_k/(1 + s² S_k) over the eigenvalues (Kass & Raftery 1995). Its λ is that of the
rest of it, in that size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...diagnosis.priors import PRIORS
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
INSIDE = 0.2  # share of λ that what contains a cause leaves of it, at most
IMITATES = 0.5  # share of λ that a rival leaves, at most, to be taken for the cause
ODDS = 2 * np.log(PRIORS.named / (1 - PRIORS.named))  # twice the log odds from which a cause is named,
SPARE = 2.0  # and by how much more they are asked for

Columns = NDArray[np.int64]


@dataclass(frozen=True)
class Tie:
    """An effect that was found, its size (p,) in usual ones, and the effects that rival it; odds: twice the
    log odds of the cause against each, where they are known."""

    effect: Effect
    size: Array
    rivals: tuple[Effect, ...]
    odds: tuple[float, ...] = ()

    def odds_of(self, rival: Effect) -> float:
        """Twice the log odds against a rival; nothing is known: even."""
        return self.odds[self.rivals.index(rival)] if self.odds else 0.0

    def pairs(self, space: DesignSpace) -> list[Pair]:
        """The cause beside each rival, and each rival beside the cause; not what another contains."""
        ways = [way for rival in self.rivals for way in ((self.effect, rival), (rival, self.effect))]
        return [way for way in ways if not contains(space, way[1], way[0])]


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
    chance = {(rival.cause, rival.where): rival.probability for rival in finding.rivals}
    odds = tuple(2 * float(np.log(finding.probability / chance[rival.key])) for rival in rivals)
    return replace(tie_between(effect, outcome.fit.state.values[strongest], rivals), odds=odds)


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
            of_rest = contains(space, rival, tie.effect)
            scale[j] = np.maximum(np.abs(imitation) * np.sqrt(len(j)), SMALLEST)
            scale[j] = _size_of(imitation) if of_rest else scale[j]
    return replace(space, rows=space.rows * scale, before=space.before * np.outer(scale, scale))


def contains(space: DesignSpace, whole: Effect, part: Effect) -> bool:
    """Whether one effect can be all that another is, in everything on offer, and more."""
    j, i = (space.columns(effect) - space.background for effect in (whole, part))
    if len(j) <= len(i):
        return False
    left = space.left(space.everything)
    beside = [unexplained(left, i, j, one, WIDE**-2) for one in np.eye(len(i))]
    return sum(beside) < INSIDE * float(np.trace(left[np.ix_(i, i)]))


def least(space: DesignSpace, data: Array, tie: Tie) -> float:
    """The smallest λ of the cause beside each of its rivals, and of each rival beside the cause, with the
    information data: (P, P)."""
    before, after = space.left(space.before), space.left(data)
    return min(_apart(space, before, after, tie, rival) for rival in tie.rivals)


def share_of(space: DesignSpace, data: Array, tie: Tie) -> float:
    """How much of the way to a settled tie the information data: (P, P) goes, beside the hardest rival; one
    and more: it is settled."""
    before, after = space.left(space.before), space.left(data)
    shares = []
    for rival in tie.rivals:
        if contains(space, rival, tie.effect):
            gain = _against(space, before, after, tie, rival) - _against(space, before, before, tie, rival)
            shares.append(gain / max(ODDS + SPARE - tie.odds_of(rival), SPARE))
        else:
            now = _apart(space, before, before, tie, rival)
            shares.append((_apart(space, before, after, tie, rival) - now) / (settled_at(now) - now))
    return min(shares)


def _apart(space: DesignSpace, before: Array, after: Array, tie: Tie, rival: Effect) -> float:
    """λ of the cause beside a rival and, where that imitates it, of the rival beside the cause, the smaller;
    of what contains the other its own alone."""
    i, j = (space.columns(effect) - space.background for effect in (tie.effect, rival))
    imitation = _imitation(before, i, j, tie.size)
    if contains(space, rival, tie.effect):
        return float(_size_of(imitation) ** 2 * np.trace(_rest(after, i, j)))
    own = unexplained(after, i, j, tie.size, WIDE**-2)
    alone = unexplained(before, i, j[:0], tie.size, 0.0)
    imitates = unexplained(before, i, j, tie.size, WIDE**-2) < IMITATES * alone
    if contains(space, tie.effect, rival) or not imitates:
        return own
    return min(own, unexplained(after, j, i, imitation, WIDE**-2))


def _against(space: DesignSpace, before: Array, after: Array, tie: Tie, rival: Effect) -> float:
    """Twice the log Bayes factor that is expected against a rival that contains the cause."""
    i, j = (space.columns(effect) - space.background for effect in (tie.effect, rival))
    size = _size_of(_imitation(before, i, j, tie.size))
    seen = size**2 * np.maximum(np.linalg.eigvalsh(_rest(after, i, j)), 0.0)
    return float(np.sum(np.log1p(seen) - seen / (1 + seen)))


def _size_of(imitation: Array) -> float:
    """Usual sizes of a function that has these numbers."""
    return max(float(np.sqrt(np.mean(imitation**2))), SMALLEST)


def _rest(left: Array, i: Columns, j: Columns) -> Array:
    """(q, q) information on columns j beside columns i."""
    cross = left[np.ix_(i, j)]
    return np.asarray(
        left[np.ix_(j, j)] - cross.T @ np.linalg.solve(left[np.ix_(i, i)] + WIDE**-2 * np.eye(len(i)), cross)
    )


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
    space: DesignSpace, ties: Sequence[Tie], search: Search, attempts: Attempts
) -> tuple[Records, float]:
    """The fewest records that settle all ties, and the share of the way that the hardest of them goes
    (`share_of`); below one: none settle them, and these were tried last."""
    pairs = list(dict.fromkeys(pair for tie in ties for pair in tie.pairs(space)))
    steering = as_found(space, ties)
    count, found, reached = attempts.first, None, 0.0
    for _ in range(attempts.times):
        chosen = t_optimal(steering, pairs, count, replace(search, starts=1))
        data = space.measured(chosen)
        share = min(share_of(space, data, tie) for tie in ties)
        if found is None or share >= 1 or reached < 1:
            found, reached = chosen, share
        most = min(attempts.most, len(space.rows))
        wanted = int(np.clip(np.ceil(attempts.margin * count / max(share, 1e-6)), attempts.fewest, most))
        if wanted == count or (reached >= 1 and wanted >= len(found)):
            break
        count = wanted
    assert found is not None
    return found, reached
