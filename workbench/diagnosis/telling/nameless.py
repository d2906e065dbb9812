"""What has no name, as findings: functions that no cause explains, and scatter that nothing does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.problem import Problem
from ...effects.base import UNKNOWN, Effect, motion_said
from ...effects.place import NOWHERE, Where
from ...effects.unnamed import Unnamed
from ...identification.fit import Fit
from ...identification.noise import Covariance
from ...robot.kinematics import Array
from ..found import Finding, Rival
from ..noise.scatter import chi2_of_joints
from ..priors import PRIORS
from ..search.competition import Selection
from ..weighing.chosen import Shares
from ..weighing.components import Component
from ..weighing.remainder import Remainder
from .evidence import structure_evidence
from .headline import listed, words_of

ALSO_TOLD = 2  # parts without a name that are told beside the largest
MOST = 0.5  # of what is beyond the noise: a joint whose scatter makes more of it is where it sits
UNSURE = 1.2  # residual over a stated noise: up to it a scatter in no joint may be one stated too small


def nameless_of(selection: Selection, worth_mm: float) -> list[Finding]:
    """Functions without a name that the likeliest set has, largest first, as one. worth_mm: what all of them
    together bring on held-out poses."""
    found = []
    part = "set-up" if len(selection.fit.model.problem.campaign.setup_names) > 1 else "half of the poses"
    for member, share in zip(selection.members, selection.shares, strict=True):
        component = selection.components[member.component]
        if component.nameless and share[None] < PRIORS.absent:
            for function, worth in selection.each_of(member):
                assert isinstance(function, Unnamed)
                own = _unknown(selection.fit, function, share[member.component], worth)
                found.append(replace(own, rivals=_with_names(selection.components, share)))
    for member in selection.unrepeated:
        label = _in_words(selection.components[member.component])
        worth = selection.worth_mm(member)
        structure = f"looks like {label} in one {part} and not in another (it makes {worth:.3f} mm RMS)"
        found.append(_plain(structure, f"What is left {structure}.", NOWHERE, worth))
    for effect in {e.key: e for e in selection.fit.model.effects if e.key in selection.against}.values():
        why = "of a size that it has on no machine: something else does this"
        if effect.key in selection.beside.values():
            why = "by nothing but what real ones have beside that form: something else does this"
        elif effect.acts == "yielding":
            why = "with less than no compliance: something else gives way, or gravity is another than stated"
        structure = f"looks like {words_of(*effect.key)}, but {why}"
        worth = selection.gains_mm[effect.key]
        found.append(_plain(structure, f"What is left {structure}.", effect.where, worth))
    ordered = sorted(found, key=lambda finding: -finding.gain_mm)
    return [_as_one(ordered, max(worth_mm, 0.0))] if found else []


def _in_words(component: Component) -> str:
    """A component as people say it."""
    cause, where = component.key
    at = "" if where.order is None else f" at {where.order:.4g} cycles per turn"
    return component.label if component.nameless else words_of(cause, where) + at


def _with_names(components: Sequence[Component], share: Shares) -> tuple[Rival, ...]:
    """The causes that could be what has no name, likeliest first."""
    causes = [(p, components[k]) for k, p in share.items() if k is not None and not components[k].nameless]
    return tuple(
        Rival(*one.key, p, one.called)
        for p, one in sorted(causes, key=lambda cause: -cause[0])
        if p >= PRIORS.faintest_rival
    )


def _as_one(found: list[Finding], worth_mm: float) -> Finding:
    """What has no name is one finding: its largest part, the others told with it, and all causes that could
    be one of them."""
    first = found[0]
    likeliest: dict[tuple[str, Where], Rival] = {}
    for rival in sorted((r for one in found for r in one.rivals), key=lambda r: -r.probability):
        likeliest.setdefault((rival.cause, rival.where), rival)
    _, *others = dict.fromkeys(one.structure or "" for one in found)
    also = "; ".join(others[:ALSO_TOLD])
    structure = f"{first.structure} (besides: {also})" if also else first.structure
    sentence = f"What is left {structure}."
    rivals = tuple(likeliest.values())[:ALSO_TOLD]
    advice = "; ".join(dict.fromkeys(one.separate_by for one in found if one.separate_by)) or None
    return replace(
        first,
        gain_mm=worth_mm,
        structure=structure,
        sentence=sentence,
        rivals=rivals,
        separate_by=advice,
    )


def scattering(selection: Selection, left: Remainder, noise: Covariance, rms_mm: float) -> Finding:
    """The residual is larger than the noise, and nothing that competed says where it comes from: in a joint
    where its scatter makes most of what is beyond the noise."""
    problem = selection.fit.model.problem
    where, place = NOWHERE, ""
    scattered = chi2_of_joints(selection.fit, noise, selection.scatter)
    j = int(np.argmax(scattered))
    if scattered[j] > MOST * (left.chi2 - left.dof):
        where = Where(joint=problem.arm.names[j])
        size = motion_said(selection.scatter[j], bool(problem.arm.prismatic[j]))
        place = f", sits in {where.joint} ({size} from pose to pose)"
    elif any(selection.fit.noise.body):
        single = problem.campaign.six_dof or problem.seen.sum(axis=1).max() == 1
        place = ", as of a noise stated too small" if single else ", moves all targets of a pose together"
    unseen = [name for name, column in _columns(problem) if column is None]
    record = f", and record {listed(unseen)}" if unseen else ""
    structure = (
        f"the residual is {left.inflation:.2f} times the noise ({rms_mm:.4f} mm RMS){place}, and nothing "
        f"that was tried of {_tried(selection)} explains it: repeat some poses{record}"
    )
    worth = rms_mm * (1 - 1 / left.inflation)
    return _plain(structure, f"{structure[0].upper()}{structure[1:]}.", where, worth)


def _columns(problem: Problem) -> list[tuple[str, Array | None]]:
    """What may be recorded beside the joints."""
    side = problem.campaign.poses.side
    return [("approach", side), ("time", problem.time), ("temperature", problem.warmth)]


def _tried(selection: Selection) -> str:
    """What the components that competed are functions of, in words."""
    effects = [e for one in selection.components for form in one.forms for e in form.effects]
    uses = frozenset[str]().union(*(effect.uses for effect in effects))
    timed = selection.fit.model.problem.time is not None
    words = {
        "joints": "the joints",
        "load": "their loads",
        "side": "the side of approach",
        "time": "time" if timed else "the order of measurement",
        "temperature": "temperature",
    }
    return listed([word for use, word in words.items() if use in uses])


def _plain(structure: str, sentence: str, where: Where, worth_mm: float) -> Finding:
    return Finding(
        UNKNOWN, Unnamed.title, where, "ambiguous", worth_mm, 1.0, structure=structure, sentence=sentence
    )


def _unknown(final: Fit, function: Unnamed, probability: float, worth: float) -> Finding:
    value = dict[Effect, Array](zip(final.model.effects, final.state.values, strict=True)).get(function)
    structure = f"depends on {function.variable if value is None else function.found(value)}"
    return Finding(
        cause=UNKNOWN,
        title=Unnamed.title,
        where=function.where if function.where.other is None else NOWHERE,
        status="ambiguous",
        gain_mm=worth,
        probability=float(np.clip(probability, 0.0, 1.0)),
        separate_by=function.lacks or None,
        like=function.like,
        of_campaigns=function.dated,
        structure=structure,
        sentence=f"What is left {structure}.",
        evidence=structure_evidence(final, function),
    )
