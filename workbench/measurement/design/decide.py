"""What would decide between a cause and its rivals: how many poses, or which reading how exactly.

λ and what settles it are those of `ties`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from shlex import quote

import numpy as np

from ...campaign.problem import Problem
from ...diagnosis.found import Decision, Finding
from ...diagnosis.run import Outcome
from ...diagnosis.telling.headline import listed, words_of
from ...effects import separation_beside, without_reflectors
from ...effects.base import Effect
from ...effects.given import given_facts
from ...effects.place import ALL
from ...effects.records import effect_text
from ...files.faults import InputError
from ...identification.fit import Fit
from ..driving.block import torque_columns
from .causes import CHANCE
from .discrimination_plan import MOST_MEASURED
from .offers import POSES, Offers, Poses, roughly_settled, settled
from .prior_information import from_prepared
from .reflectors import settled_by_reflectors
from .shown import with_hope
from .t_optimal import DesignSpace
from .ties import (
    POWER,
    SAID,
    Settling,
    Tie,
    at_zero,
    contains,
    imitation,
    least,
    settled_at,
    tie_of,
    unexplained,
)

MOST = 3  # ambiguous findings that are worked out, the strongest, and readings of each
SETTLE = ("poses", "drive_torque")  # kinds that settle a tie as a whole
VISIT = 100  # poses that a visit has, at most
OTHERWISE = "another kind of measurement"
READINGS = np.geomspace(1.0, 1e-3, 60)  # spread of a reading, in usual sizes of the cause


def what_decides(outcome: Outcome) -> Outcome:
    """The outcome, its strongest ambiguous findings with what would decide: commands with expected λ. Where
    the robot can hardly be measured further (its cell, a model too soft elsewhere), a note says so."""
    told = [(f, tie) for f in outcome.diagnosis.causes if (tie := tie_of(outcome, f)) is not None][:MOST]
    if not told:
        return outcome
    try:
        return _decided(outcome, told)
    except InputError as error:
        said = "; ".join(f"{fault.place}: {fault.what}" for fault in error.faults)
        note = f"What would decide could not be worked out: {said}."
        prepared, diagnosis = outcome.prepared, outcome.diagnosis
        return replace(
            outcome,
            prepared=replace(prepared, notes=(*prepared.notes, note)),
            diagnosis=replace(diagnosis, notes=(*diagnosis.notes, note)),
        )


def _decided(outcome: Outcome, told: Sequence[tuple[Finding, Tie]]) -> Outcome:
    """The outcome, these ambiguous findings with what would decide. Raises InputError."""
    prior = from_prepared(outcome.prepared)
    valued = at_zero([tie for _, tie in told])
    model, values = outcome.fit.model, outcome.fit.state.values
    carried = {e.key: float(v[0]) for e, v in zip(model.effects, values, strict=True) if len(v) == 1}
    unsettled = frozenset(carried) - {(f.cause, f.where) for f in outcome.diagnosis.causes}
    offers = Offers(prior, valued, prior.of_campaign(valued), carried, unsettled)
    alone = [_decisions(tie, _heard(tie, f), offers) for f, tie in told]
    at_once = _at_once([tie for _, tie in told], alone, offers)
    found = {id(f): (*more, *own) for (f, _), more, own in zip(told, at_once, alone, strict=True)}
    causes = tuple(_worked_out(f, found[id(f)]) if id(f) in found else f for f in outcome.diagnosis.causes)
    return replace(outcome, diagnosis=replace(outcome.diagnosis, causes=causes))


def _worked_out(finding: Finding, decide: tuple[Decision, ...]) -> Finding:
    """A finding with what would decide; of general advice what was worked out goes."""
    advice = without_reflectors(finding.separate_by or "")
    return replace(finding, decide=decide, separate_by=advice or (None if decide else OTHERWISE))


def _heard(tie: Tie, finding: Finding) -> Tie:
    """The tie without the rivals that are not worth a word."""
    said = {(rival.cause, rival.where) for rival in finding.rivals}
    return replace(tie, rivals=tuple(rival for rival in tie.rivals if rival.key in said))


def _decisions(tie: Tie, heard: Tie, offers: Offers) -> tuple[Decision, ...]:
    """Poses; the torques beside them where poses alone are too many; readings; else what the causes say.
    heard: the tie as far as it is worth a word."""
    problem, space = offers.prior.problem, offers.space
    tell = quote(command_text(tie))
    now = least(space, space.before, tie)
    found: list[Decision] = []
    poses = settled(space, [tie], offers.prior.fit)
    if poses is not None:
        about = "about " if poses.data is None else ""
        words = f"{about}{poses.count} more poses, chosen for it"
        command = _plan_command(problem, tell, poses.count)
        found.append(Decision("poses", words, command, poses.count, now, poses.after(tie)))
    torque = _settled_by_torque(offers, tie)
    columns = torque_columns(problem.robot)
    if torque is not None and (poses is None or torque[0] < poses.count):
        count, after = torque
        words = f"record the torques of the drives (columns {columns}) at {count} more poses"
        command = _plan_command(problem, tell, count, " --torque")
        found.append(Decision("drive_torque", words, command, count, now, after))
    if poses is None and torque is None:
        found += _told_by_poses(offers, tie, heard, tell)
    if poses is None or poses.data is None:
        found += _by_reflectors(offers, tie, heard, tell, poses)
    found += _readings(problem, heard, offers, now)
    others: list[str] = []
    if poses is None and torque is None:
        others += _told_by_torque(offers, heard, columns)
    if poses is None:
        others += [_whole(heard, rival) for rival in _wholes(space, heard)]
    if poses is None or poses.data is None:
        read = {item.effect.key for item in given_facts(problem)}
        said = (separation_beside(tie.effect.key, rival.key, read, problem) for rival in heard.rivals)
        others += filter(None, (without_reflectors(words) for words in said if words))
    found += [Decision("other", words, None, None, now, None) for words in dict.fromkeys(others)]
    return tuple(found)


def _plan_command(problem: Problem, tell: str, count: int, options: str = "") -> str:
    """The plan of so many poses for a tie, as a command. tell: it, as `--tell` takes it, quoted."""
    asked = f"--tell {tell} --poses {count}{options}"
    return f"workbench plan {problem.campaign.arguments} {asked} --out follow-up"


def _at_once(
    ties: Sequence[Tie], alone: Sequence[Sequence[Decision]], offers: Offers
) -> list[tuple[Decision, ...]]:
    """For each tie the poses that settle it in one visit with all others that take no more than one. alone:
    what decides each."""
    ways = [[way for way in own if way.kind in SETTLE and (way.poses or 0) <= VISIT] for own in alone]
    together = [tie for tie, own in zip(ties, ways, strict=True) if own]
    asked = [own for own in ways if own]
    if len(together) < 2:
        return [()] * len(ties)
    found: list[Poses] = []
    if all(any(way.kind == "poses" for way in own) for own in asked):
        found += _visit(offers.space, together, offers.prior.fit, POSES.fewest)
    with_torques = [way.poses or 0 for own in asked for way in own if way.kind == "drive_torque"]
    if with_torques and offers.with_torques is not None:
        some = _visit(offers.with_torques, together, offers.prior.fit, max(with_torques))
        found += [one for one in some if not found or one.count < found[0].count]
    said = [_said_at_once(one, together, offers) for one in found]
    return [tuple(one[tie] for one in said) if tie in together else () for tie in ties]


def _visit(space: DesignSpace, ties: Sequence[Tie], fit: Fit | None, at_least: int) -> list[Poses]:
    """Poses that settle all ties in one visit, or none."""
    found = settled(space, ties, fit)
    return [] if found is None or found.count > VISIT else [found.with_at_least(at_least)]


def _said_at_once(poses: Poses, ties: Sequence[Tie], offers: Offers) -> dict[Tie, Decision]:
    """What poses that settle ties at once are to each of them."""
    problem, torque = offers.prior.problem, poses.space is not offers.space
    tell = quote(";".join(map(command_text, ties)))
    command = _plan_command(problem, tell, poses.count, " --torque" * torque)
    words = f"{poses.count} more poses"
    if torque:
        columns = torque_columns(problem.robot)
        words = f"record the torques of the drives (columns {columns}) at {words}"
    out = {}
    for tie in ties:
        others = " and ".join(dict.fromkeys(_said(one.effect) for one in ties if one is not tie))
        now, said = least(offers.space, offers.space.before, tie), f"{words}, chosen for it and for {others}"
        out[tie] = Decision(
            "drive_torque" if torque else "poses", said, command, poses.count, now, poses.after(tie)
        )
    return out


def _settled_by_torque(offers: Offers, tie: Tie) -> tuple[int, float] | None:
    """Random poses with drive torques that settle it, and λ after them, the least of some draws."""
    for count, spaces in offers.torques:
        if all(Settling(space, [tie]).power(space.everything) >= POWER for space in spaces):
            return count, min(least(space, space.everything, tie) for space in spaces)
    return None


def _told_by_poses(offers: Offers, tie: Tie, heard: Tie, tell: str) -> list[Decision]:
    """Poses that tell the cause from some of its rivals, where none tell it from all. tell: the tie as
    `--tell` takes it; `plan` leaves out what no poses tell, as here."""
    space = offers.space
    most = space.measured(np.arange(len(space.rows)), MOST_MEASURED)
    rest, gone = with_hope(space, most, tie)
    worth = {rival.key for rival in heard.rivals}
    told, untold = (
        list(dict.fromkeys(_said(one) for one in some if one.key in worth)) for some in (rest.rivals, gone)
    )
    poses = roughly_settled(space, rest, offers.prior.fit) if told else None
    if poses is None:
        return []
    words = f"about {poses.count} more poses, chosen for it: they tell {_said(tie.effect)} from "
    words += listed(told) + (f", but not from {listed(untold)}" if untold else "")
    command = _plan_command(offers.prior.problem, tell, poses.count)
    now = least(space, space.before, rest)
    return [Decision("some_rivals", words, command, poses.count, now, None)]


def _by_reflectors(offers: Offers, tie: Tie, heard: Tie, tell: str, without: Poses | None) -> list[Decision]:
    """Poses with reflectors on the arm or its base that settle it, as `settled_by_reflectors`."""
    found = settled_by_reflectors(offers, tie, heard, without)
    if found is None:
        return []
    links, poses = found
    on = listed(["the base" if link == "base" else f"{link} near its joint" for link in links])
    words = f"a reflector on {on}" if len(links) == 1 else f"reflectors on {on}"
    words += f", measured beside the others at about {poses.count} more poses, chosen for it"
    options = "".join(f" --reflector {quote(link)}" for link in links)
    command = _plan_command(offers.prior.problem, tell, poses.count, options)
    now = least(poses.space, poses.space.before, tie)
    return [Decision("reflectors", words, command, poses.count, now, None)]


def _told_by_torque(offers: Offers, tie: Tie, columns: str) -> list[str]:
    """What drive torques tell of a tie that they do not settle: the cause from some of its rivals."""
    told = {}
    keys = dict.fromkeys(rival.key for rival in tie.rivals)
    for beside in map(tie.beside, keys):
        if (found := _settled_by_torque(offers, beside)) is not None:
            told[_said(beside.rivals[0])] = found[0]
    if not told:
        return []
    words = f"record the torques of the drives (columns {columns}) at {max(told.values())} more poses"
    rest = "" if len(told) == len(keys) else ", but not from the other rivals"
    return [f"{words}: they tell {_said(tie.effect)} from {', '.join(told)}{rest}"]


def _wholes(space: DesignSpace, tie: Tie) -> list[Effect]:
    """The rivals that contain the cause, one for each place."""
    found = [rival for rival in tie.rivals if contains(space, rival, tie.effect)]
    return list({rival.key: rival for rival in found}.values())


def _whole(tie: Tie, rival: Effect) -> str:
    """Why no few poses settle a cause beside a rival that contains it."""
    if rival.free:
        return (
            f"{_said(tie.effect)} is a case of {_said(rival)}: no pose tells them apart, only that nothing "
            f"else shows at many more angles of {rival.where}; {MOST_MEASURED} poses are too few"
        )
    return (
        f"{_said(rival)} can do to the tool all that {_said(tie.effect)} does, with other numbers: "
        f"{MOST_MEASURED} poses are too few"
    )


def _readings(problem: Problem, tie: Tie, offers: Offers, now: float) -> list[Decision]:
    """Quantities of the cause or its likeliest rivals that another instrument reads, and how exactly."""
    found: dict[str, Decision] = {}
    space, carried = offers.space, offers.carried
    likeliest = sorted(tie.rivals, key=lambda rival: -tie.chance(rival.key))
    only = len({rival.key for rival in tie.rivals}) == 1
    for effect in (tie.effect, *(rival for rival in likeliest if rival.key not in offers.unsettled)):
        apart = {one.where for one in (tie.effect, *tie.rivals) if one.cause == effect.cause}
        if effect.variant == ALL and len(apart) > 1:
            continue  # a whole that is off may be one part alone
        spread, after = _spread(tie, effect, space, now)
        for name, unit in effect.wholes.items():
            abouts = _abouts(tie, effect, space, carried.get(effect.key, 0.0))
            slope = max(_slope(problem, effect, name, about) for about in abouts)
            if not spread or not slope or len(effect.params) != 1:
                continue
            std = float(f"{spread * effect.params[0].typical / slope:.1g}")
            where = (
                f" of {effect.where}" if str(effect.where) else " of all that moves" * (effect.variant == ALL)
            )
            exactly = f"{std:,.10g}".replace(",", "\N{NO-BREAK SPACE}")
            words = f"read {name}{where} to ± {exactly} {unit}".removesuffix(" 1")
            words += "" if only or effect is tie.effect else f": whether it is {_said(effect)}"
            place = _text(effect, _form_said(effect, problem))
            fact = f"{place}{',' if ':' in place else ':'}{name}=VALUE,std={std:.10g}"
            command = f"workbench diagnose {problem.campaign.arguments} --known {quote(fact)}"
            found.setdefault(effect.label, Decision("reading", words, command, None, now, after))
    return list(found.values())[:MOST]


def _said(effect: Effect) -> str:
    """A cause and where it sits, as people say them."""
    return words_of(effect.cause, effect.where, effect.called)


def _form_said(effect: Effect, problem: Problem) -> dict[str, str]:
    """The form of an effect, where a fact of its cause and place alone would be of another."""
    first = next(one for one in type(effect).places(problem) if one.key == effect.key)
    return {} if first.variant == effect.variant else {"variant": effect.variant}


def _spread(tie: Tie, effect: Effect, space: DesignSpace, now: float) -> tuple[float, float | None]:
    """The largest spread of a reading, in usual sizes, that decides, and λ then; 0: none does.

    A reading of the cause holds its own size against none; one of the only rival takes it out of the way; one
    of a rival among several says whether it is as large as it would have to be.
    """
    needed = float(np.sqrt(settled_at(now) - now))
    if effect is tie.effect:
        return float(np.linalg.norm(tie.size)) / needed, settled_at(now)
    i, j = (space.columns(e) - space.background for e in (tie.effect, effect))
    left = space.left(space.before)
    if any(rival != effect for rival in tie.rivals):
        return float(np.linalg.norm(imitation(left, i, j, tie.size))) / needed, None
    for spread in READINGS:
        after = unexplained(left, i, j, tie.size, spread**-2)
        if after >= settled_at(now):
            return float(spread), after
    return 0.0, 0.0


def _abouts(tie: Tie, effect: Effect, space: DesignSpace, carried: float) -> list[float]:
    """Parameters near which a reading may turn out: as found; of a rival as the fitted model carries it (in
    its usual size where that has no number, a joint that is rigid), and as large as it has to be to be what
    was found: a stiffness is to be read as exactly as the softer of both asks."""
    typical = effect.params[0].typical
    if effect is tie.effect:
        return [float(tie.size[0]) * typical]
    i, j = (space.columns(e) - space.background for e in (tie.effect, effect))
    imitated = float(imitation(space.left(space.before), i, j, tie.size)[0])
    return [carried or (0.0 if effect.stated else typical), carried + imitated * typical]


def _slope(problem: Problem, effect: Effect, name: str, about: float) -> float:
    """Change of the parameter per unit of a quantity that is read whole, where the parameter is `about`."""
    at = 1.0
    for _ in range(50):  # the whole at which the parameter is that: they are monotonic, found by secants
        here, beside = (effect.of_whole(problem, name, v, 0.0) for v in (at, at * (1 + 1e-6)))
        if here is None or beside is None:
            return 0.0
        slope, here = (beside - here) / (1e-6 * at), here - about
        if slope == 0.0:  # no whole, however large, has the parameter there
            return 0.0
        if abs(here) < 1e-9 * effect.params[0].typical:
            break
        at = at - here / slope if at - here / slope > 0 else 2 * at
    return abs(slope)


def command_text(tie: Tie) -> str:
    """The tie as `--tell` takes it: the cause with the size that was found, its rivals, and how likely the
    diagnosis has each, those without a name among them."""
    values = tie.size * np.array([p.typical for p in tie.effect.params])
    found = effect_text(tie.effect, np.array([float(f"{value:.{SAID}g}") for value in values]))
    rivals = {form.first.key: form.first for form in tie.forms if form.first.key != tie.effect.key}
    told = [(found, tie.effect.key), *((_text(effect), key) for key, effect in rivals.items())]
    return ",".join(_with(text, tie.chances.get(key)) for text, key in told)


def _with(text: str, chance: float | None) -> str:
    """A cause as `--tell` takes it, with its probability where that is known."""
    if chance is None:
        return text
    return f"{text}{',' if ':' in text else ':'}{CHANCE}={chance:.2g}"


def _text(effect: Effect, more: Mapping[str, str] | None = None) -> str:
    """The cause with its place, as `--tell` takes it, and more of it. One that is alike in the whole arm has
    that said: else all places would be asked for."""
    whole = {"variant": ALL} if effect.variant == ALL else {}
    said = {**effect.where.keys(), **whole, **(more or {})}
    where = ",".join(f"{key}={value}" for key, value in said.items())
    return f"{effect.cause}:{where}" if where else effect.cause
