"""What would decide between a cause and its rivals: how many poses, or which reading how exactly.

λ is that of `t_optimal`, for the size that the cause was found with; the rival is taken as large as imitates
it best in what was measured. Settled is λ ≥ `LEVELS.mostly`, from where a diagnosis names the cause mostly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from shlex import quote

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...diagnosis.result import Decision, Finding
from ...diagnosis.run import Outcome
from ...effects import catalogue, separation
from ...effects.base import UNKNOWN, Effect
from ...effects.records import effect_text
from ...robot.kinematics import Array
from ..driving.reach import reach
from .candidates import candidates
from .causes import varied
from .discrimination import LEVELS
from .fedorov import Records, Search, information
from .prior_information import WIDE, PriorInformation, Sensitivity, ValuedEffects, from_prepared
from .t_optimal import DesignSpace, Pair, design_space, t_optimal

MOST = 3  # ambiguous findings that are worked out, the strongest
POOL = 120  # candidate records
FIRST, FEWEST, LARGEST = 24, 6, 60  # poses of a follow-up: tried first, fewest, most
CLOSER, MARGIN = 4, 1.1  # how often the number is mended, and by how much more than is thought to do it
SMALLEST = 0.1  # usual sizes, of a rival that hardly imitates
DRAWS = 3  # of random poses with torques
FEWEST_TORQUES = 12  # poses from which a joint's offset, scale and friction are taken out of its torques
TORQUE_TERMS = 3  # a joint's offset, scale and friction
READINGS = np.geomspace(1.0, 1e-3, 60)  # spread of a reading, in usual sizes of the cause

Columns = NDArray[np.int64]
Torques = Callable[[Records], DesignSpace]  # of some of the candidate records


@dataclass(frozen=True)
class Tie:
    """An effect that was found, its size (p,) in usual ones, and the effects that rival it."""

    effect: Effect
    size: Array
    rivals: tuple[Effect, ...]


def what_decides(outcome: Outcome) -> Outcome:
    """The outcome, its strongest ambiguous findings with what would decide: commands with expected λ."""
    told = [(f, tie) for f in outcome.diagnosis.causes if (tie := tie_of(outcome, f)) is not None][:MOST]
    ties = [tie for _, tie in told]
    if not ties:
        return outcome
    prior = from_prepared(outcome.prepared)
    valued = _valued(ties)
    offered = _offered(prior, [effect for effect, _ in valued])
    measured = prior.of_campaign(valued)
    space = design_space(prior.of_records(offered, valued), measured)
    with_torque = _with_torque(prior, offered, valued, measured)
    found = {id(f): _decisions(prior.problem, tie, space, with_torque) for f, tie in told}
    causes = tuple(replace(f, decide=found.get(id(f), ())) for f in outcome.diagnosis.causes)
    return replace(outcome, diagnosis=replace(outcome.diagnosis, causes=causes))


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
    typical = np.array([p.typical for p in effect.params])
    return Tie(effect, outcome.fit.state.values[strongest] / typical, rivals)


def _offered(prior: PriorInformation, effects: Sequence[Effect]) -> Campaign:
    """Records that can be driven, as `plan` offers them."""
    around = reach(
        prior.problem, prior.places, prior.problem.campaign.cell, np.random.default_rng([0, 24]), prior.shown
    )
    pull = around.cell.driving.pull_N or 0.0
    factors = replace(varied(effects), pull=pull)
    return candidates(prior, POOL, factors, np.random.default_rng(21), around.draw)


def _with_torque(
    prior: PriorInformation, offered: Campaign, effects: ValuedEffects, measured: Sensitivity | None
) -> Torques | None:
    """The same records with the drives' torques; None where these were recorded, or no load is in it."""
    loads = any(effect.acts == "load" for effect, _ in effects)
    if not loads or prior.problem.drives:
        return None
    recorded = offered.with_poses(torque=np.zeros_like(offered.poses.q))

    def space(chosen: Records) -> DesignSpace:
        return design_space(prior.of_records(recorded.some(chosen), effects), measured)

    return space


def _decisions(
    problem: Problem, tie: Tie, space: DesignSpace, with_torque: Torques | None
) -> tuple[Decision, ...]:
    """Poses; the torques beside them where poses alone are too many; readings; else what the causes say."""
    path = quote(str(problem.campaign.path))
    now = least(space, space.before, tie)
    tell = ",".join([_found(tie), *dict.fromkeys(_text(rival) for rival in tie.rivals)])
    found = []
    poses = _settled(space, tie, now)
    if poses is not None:
        count, after = poses
        words = f"{count} more poses, chosen for it"
        command = f"workbench plan {path} --tell {quote(tell)} --poses {count} --out follow-up"
        found.append(Decision("poses", words, command, count, now, after))
    if with_torque is not None and (torque := _settled_by_torque(with_torque, tie, now)) is not None:
        count, after = torque
        if poses is None or count < poses[0]:
            words = f"the torques of the drives (columns tau1 ...) at {count} more poses"
            command = f"workbench plan {path} --poses {count} --out follow-up"
            found.append(Decision("drive_torque", words, command, count, now, after))
    found += _readings(problem, tie, space, now)
    if poses is None:
        said = (separation(tie.effect.cause, rival.cause) for rival in tie.rivals)
        words_of = dict.fromkeys(filter(None, said))
        found += [Decision("other", words, None, None, now, None) for words in words_of]
    return tuple(found)


def told_apart(outcome: Outcome, tie: Tie, before: Outcome) -> float:
    """λ of a tie in all that an outcome was made of; before: the outcome that left it."""
    valued = _valued((tie,))
    both, first = (from_prepared(one.prepared).of_campaign(valued) for one in (outcome, before))
    assert both is not None
    space = design_space(both, first)
    return least(space, information(space.rows), tie)


def _valued(ties: Sequence[Tie]) -> ValuedEffects:
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
    return _left(after, i, j, tie.size, WIDE**-2), _left(after, j, i, imitation, WIDE**-2)


def _imitation(left: Array, i: Columns, j: Columns, size: Array) -> Array:
    """The size of columns j that imitates columns i best."""
    S = left[np.ix_(j, j)] + WIDE**-2 * np.eye(len(j))
    return np.asarray(np.linalg.solve(S, left[np.ix_(j, i)] @ size), dtype=np.float64)


def _left(left: Array, i: Columns, j: Columns, size: Array, held: float) -> float:
    """λ of columns i in a size beside columns j."""
    cross = left[np.ix_(j, i)]
    S = left[np.ix_(j, j)] + held * np.eye(len(j))
    unexplained = left[np.ix_(i, i)] - cross.T @ np.linalg.solve(S, cross)
    return max(float(size @ unexplained @ size), 0.0)


def settled_at(now: float) -> float:
    """λ that settles it: more than there is where a rival holds out against it."""
    return max(LEVELS.mostly, now + LEVELS.least)


def pairs_of(tie: Tie) -> list[Pair]:
    return [way for rival in tie.rivals for way in ((tie.effect, rival), (rival, tie.effect))]


def _settled(space: DesignSpace, tie: Tie, now: float) -> tuple[int, float] | None:
    """Poses that settle it, and λ after them; None where it takes more than `LARGEST`."""
    count, found, steering = FIRST, None, as_found(space, (tie,))
    for _ in range(CLOSER):
        chosen = t_optimal(steering, pairs_of(tie), count, Search(POOL, 1, 0))
        after = least(space, space.measured(chosen), tie)
        share = (after - now) / (settled_at(now) - now)
        if share >= 1:
            found = (count, after)
        wanted = int(np.clip(np.ceil(MARGIN * count / max(share, 1e-6)), FEWEST, LARGEST))
        if wanted == count or (found is not None and wanted >= found[0]):
            break
        count = wanted
    return found


def _settled_by_torque(torques: Torques, tie: Tie, now: float) -> tuple[int, float] | None:
    """Random poses with drive torques that settle it, and λ after them, the least of some draws; what is
    common to a joint's torques is taken out of those poses alone. The noise of the torques is what the stated
    robot leaves of them, the cause itself in it: n poses tell no more than a λ of n − 3."""
    for count in (FEWEST_TORQUES, FIRST, LARGEST):
        reached = []
        for draw in range(DRAWS):
            order = np.random.default_rng([23, draw]).permutation(POOL)
            space = torques(np.sort(order[:count]))
            gain = least(space, space.before + information(space.rows), tie) - now
            reached.append(now + gain / (1 + gain / (count - TORQUE_TERMS)))
        if min(reached) >= settled_at(now):
            return count, min(reached)
    return None


def _readings(problem: Problem, tie: Tie, space: DesignSpace, now: float) -> list[Decision]:
    """Quantities of the cause or its rivals that another instrument reads, and how exactly it has to."""
    found: dict[str, Decision] = {}
    for effect in (tie.effect, *tie.rivals):
        spread, after = _spread(tie, effect, space, now)
        for name, unit in effect.wholes.items():
            slope = _slope(problem, effect, name)
            if not spread or not slope or len(effect.params) != 1:
                continue
            std = float(f"{spread * effect.params[0].typical / slope:.1g}")
            where = f" of {effect.where}" if str(effect.where) else ""
            words = f"read {name}{where} to ± {std:g} {unit}".removesuffix(" 1")
            fact = f"{_text(effect)}{',' if ':' in _text(effect) else ':'}{name}=VALUE,std={std:g}"
            command = f'workbench diagnose {problem.campaign.path} --known "{fact}"'
            found.setdefault(f"{effect.label}", Decision("reading", words, command, None, now, after))
    return list(found.values())


def _spread(tie: Tie, effect: Effect, space: DesignSpace, now: float) -> tuple[float, float]:
    """The largest spread of a reading, in usual sizes, that settles all rivals, and λ then; 0: none does.

    A reading of the cause holds its own size against none; one of the only rival takes it out of the way.
    """
    if effect is tie.effect:
        return float(np.linalg.norm(tie.size) / np.sqrt(settled_at(now) - now)), settled_at(now)
    if {rival.key for rival in tie.rivals} == {effect.key}:
        i, j = (space.columns(e) - space.background for e in (tie.effect, effect))
        left = space.left(space.before)
        for spread in READINGS:
            after = _left(left, i, j, tie.size, spread**-2)
            if after >= settled_at(now):
                return float(spread), after
    return 0.0, 0.0


def _slope(problem: Problem, effect: Effect, name: str) -> float:
    """Change of the parameter per unit of a quantity that is read whole, about the model's value."""
    at = 1.0
    for _ in range(50):  # the whole at which the parameter is zero: they are monotonic, found by secants
        here, beside = (effect.of_whole(problem, name, v, 0.0) for v in (at, at * (1 + 1e-6)))
        if here is None or beside is None:
            return 0.0
        slope = (beside - here) / (1e-6 * at)
        if abs(here) < 1e-9 * effect.params[0].typical:
            break
        at = at - here / slope if at - here / slope > 0 else 2 * at
    return abs(slope)


def _found(tie: Tie) -> str:
    """The cause with the size that was found, as `--tell` and `--effect` take it."""
    values = tie.size * np.array([p.typical for p in tie.effect.params])
    return effect_text(tie.effect, np.array([float(f"{value:.3g}") for value in values]))


def _text(effect: Effect) -> str:
    """The cause with its place, as `--tell` takes it."""
    where = ",".join(f"{key}={value}" for key, value in effect.where.keys().items())
    return f"{effect.cause}:{where}" if where else effect.cause
