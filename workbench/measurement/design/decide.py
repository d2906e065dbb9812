"""What would decide between a cause and its rivals: how many poses, or which reading how exactly.

λ is that of `t_optimal`, for the size that the cause was found with; the rival is taken as large as imitates
it best in what was measured. Settled is λ ≥ `LEVELS.mostly`, from where a diagnosis names the cause mostly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...diagnosis.result import Decision, Finding
from ...diagnosis.run import Outcome
from ...effects import catalogue, separation
from ...effects.base import UNKNOWN, Effect
from ...robot.kinematics import Array
from .candidates import candidates
from .causes import varied
from .discrimination import LEVELS
from .fedorov import Records, Search, information
from .prior_information import WIDE, PriorInformation, Sensitivity, ValuedEffects, from_prepared
from .t_optimal import DesignSpace, Pair, design_space, t_optimal

MOST = 3  # ambiguous findings that are worked out, the strongest
POOL = 120  # candidate records
FIRST, FEWEST, LARGEST = 24, 6, 60  # poses of a follow-up: tried first, fewest, most
DRAWS = 3  # of random poses with torques
FEWEST_TORQUES = 12  # poses from which a joint's offset, scale and friction are taken out of its torques
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
    told = [(f, tie) for f in outcome.diagnosis.causes if (tie := _tie(outcome, f)) is not None][:MOST]
    ties = [tie for _, tie in told]
    if not ties:
        return outcome
    prior = from_prepared(outcome.prepared)
    effects = list(dict.fromkeys(e for tie in ties for e in (tie.effect, *tie.rivals)))
    valued = tuple((effect, np.zeros(len(effect.params))) for effect in effects)
    offered = _offered(prior, effects)
    measured = prior.of_campaign(valued)
    space = design_space(prior.of_records(offered, valued), measured)
    with_torque = _with_torque(prior, offered, valued, measured)
    found = {id(f): _decisions(prior.problem, tie, space, with_torque) for f, tie in told}
    causes = tuple(replace(f, decide=found.get(id(f), ())) for f in outcome.diagnosis.causes)
    return replace(outcome, diagnosis=replace(outcome.diagnosis, causes=causes))


def _tie(outcome: Outcome, finding: Finding) -> Tie | None:
    """The finding as effects; None where it is named, or no rival has a name."""
    if finding.status == "named" or finding.cause == UNKNOWN:
        return None
    own = [i for i, e in enumerate(outcome.fit.model.effects) if e.key == (finding.cause, finding.where)]
    keys = {(rival.cause, rival.where) for rival in finding.rivals if rival.cause != UNKNOWN}
    kinds = [catalogue()[cause] for cause in dict.fromkeys(cause for cause, _ in keys)]
    rivals = tuple(e for kind in kinds for e in kind.sites(outcome.problem) if e.key in keys)
    if not own or not rivals:
        return None
    strongest = max(own, key=outcome.fit.wald)
    effect = outcome.fit.model.effects[strongest]
    typical = np.array([p.typical for p in effect.params])
    return Tie(effect, outcome.fit.state.values[strongest] / typical, rivals)


def _offered(prior: PriorInformation, effects: Sequence[Effect]) -> Campaign:
    return candidates(prior, POOL, varied(effects), np.random.default_rng(21))


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
    path = problem.campaign.path
    now = least(space, space.before, tie)
    tell = ",".join([_text(tie.effect), *dict.fromkeys(_text(rival) for rival in tie.rivals)])
    found = []
    poses = _settled(space, tie, now)
    if poses is not None:
        count, after = poses
        words = f"{count} more poses, chosen for it"
        command = f"workbench plan {path} --tell {tell} --poses {count} --out follow-up"
        found.append(Decision("poses", words, command, count, now, after))
    if with_torque is not None and (torque := _settled_by_torque(with_torque, tie, now)) is not None:
        count, after = torque
        if poses is None or count < poses[0]:
            words = f"the torques of the drives (columns tau1 ...) at {count} more poses"
            found.append(Decision("drive_torque", words, None, count, now, after))
    found += _readings(problem, tie, space, now)
    if poses is None:
        said = (separation(tie.effect.cause, rival.cause) for rival in tie.rivals)
        words_of = dict.fromkeys(filter(None, said))
        found += [Decision("other", words, None, None, now, None) for words in words_of]
    return tuple(found)


def least(space: DesignSpace, data: Array, tie: Tie) -> float:
    """The smallest λ of the cause beside each of its rivals, and of each rival beside the cause, with the
    information data: (P, P)."""
    before, after = space.left(space.before), space.left(data)
    return min(min(_both(space, before, after, tie, rival)) for rival in tie.rivals)


def _both(space: DesignSpace, before: Array, after: Array, tie: Tie, rival: Effect) -> tuple[float, float]:
    i, j = (space.columns(effect) - space.background for effect in (tie.effect, rival))
    S = before[np.ix_(j, j)] + WIDE**-2 * np.eye(len(j))
    imitation = np.asarray(np.linalg.solve(S, before[np.ix_(j, i)] @ tie.size), dtype=np.float64)
    return _left(after, i, j, tie.size, WIDE**-2), _left(after, j, i, imitation, WIDE**-2)


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
    count = FIRST
    for _ in range(2):
        chosen = t_optimal(space, pairs_of(tie), count, Search(POOL, 1, 0))
        after = least(space, space.measured(chosen), tie)
        gain = (after - now) / count
        if gain <= 0:
            return None
        count = max(FEWEST, int(np.ceil((settled_at(now) - now) / gain)))
        if count > LARGEST:
            return None
    return count, now + gain * count


def _settled_by_torque(torques: Torques, tie: Tie, now: float) -> tuple[int, float] | None:
    """Random poses with drive torques that settle it, and λ after them, the least of some draws; what is
    common to a joint's torques is taken out of those poses alone."""
    for count in (FEWEST_TORQUES, FIRST, LARGEST):
        reached = []
        for draw in range(DRAWS):
            order = np.random.default_rng([23, draw]).permutation(POOL)
            space = torques(np.sort(order[:count]))
            reached.append(least(space, space.before + information(space.rows), tie))
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


def _text(effect: Effect) -> str:
    """The cause with its place, as `--tell` takes it."""
    where = ",".join(f"{key}={value}" for key, value in effect.where.keys().items())
    return f"{effect.cause}:{where}" if where else effect.cause
