"""Puts a finished competition into findings: causes with rivals and parameters, and what has no name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import __version__
from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects import separation_beside
from ..effects.base import UNKNOWN, Effect
from ..effects.place import NOWHERE, Parameter, Where
from ..effects.unnamed import Unnamed
from ..identification.fit import Fit, fit
from ..robot.kinematics import Array
from .ceiling import ceiling_mm
from .chosen import Shares
from .competition import Selection
from .components import Component, bare, with_companions
from .evidence import evidence, structure_evidence
from .facts import facts, geometry, unidentifiable
from .headline import headline, remarks, verdict_of
from .on_test_campaign import test_figures
from .power import detectable, swallowed, visible_mm
from .prepared import Prepared
from .priors import PRIORS
from .remainder import Remainder, beyond_forms, remainder, repeatability_mm
from .result import Diagnosis, Finding, GivenFact, NotTestable, Rival
from .rounded_joints import rounded_joints
from .stages import geometry_alone, pose_errors, stages_of

ALSO_TOLD = 2  # parts without a name that are told beside the largest
ANYTHING = "more poses, spread over the whole range of the joints, and a second payload"


@dataclass(frozen=True)
class Parts:
    """What the run has gathered."""

    prepared: Prepared
    selection: Selection
    candidates: Sequence[Effect]
    not_testable: tuple[NotTestable, ...]
    seed: int
    test: Campaign | None
    given: tuple[GivenFact, ...] = ()


def assemble(parts: Parts) -> Diagnosis:
    """The Diagnosis."""
    prepared, selection, final = parts.prepared, parts.selection, parts.selection.fit
    problem, known, c = prepared.problem, prepared.noise_known, prepared.problem.campaign
    groups = selection.groups
    alone = geometry_alone(prepared)
    stages = stages_of(prepared, alone, final, groups, parts.seed)
    base = stages[1 if alone is prepared.geometry else 2]
    left, beyond = _left(prepared, selection)
    best = stages[-1].heldout_rms_mm
    with_names = stages[stages.index(base) + len(groups)].heldout_rms_mm
    findings = [_finding(parts, *group) for group in groups]
    ceiling = min(best, ceiling_mm(final, parts.candidates))
    brought = base.heldout_rms_mm - with_names
    rounded = rounded_joints(final, prepared.noise, beyond)
    repeats_to = None if rounded else repeatability_mm(final, beyond, prepared.covariance)
    nameless = _nameless(selection, with_names - best)
    if not nameless and beyond.scatter and repeats_to is None:
        nameless = [_scatter(selection, beyond, best)]
    verdict = verdict_of(findings, nameless, brought, with_names - ceiling)
    findings = _beside_what_is_found(sorted(findings, key=lambda finding: -finding.gain_mm) + nameless)
    return Diagnosis(
        robot=problem.robot.name,
        robot_title=problem.robot.title,
        campaign=c.title,
        n_poses=len(c.poses),
        n_points=int(problem.seen.sum()),
        noise=prepared.noise,
        stages=tuple(stages),
        verdict=verdict,
        headline=headline(
            verdict,
            findings,
            stages,
            brought,
            ceiling,
            visible_mm(final, parts.candidates),
            1e3 * np.sqrt(3) * final.usual,
            base,
            parts.given,
            repeats_to,
            left.inflation if left.overstated else None,
        ),
        causes=tuple(findings),
        ceiling_mm=ceiling,
        remainder_chi2=left.chi2,
        remainder_dof=left.dof,
        remainder_p=left.p,
        not_testable=(*parts.not_testable, *swallowed(parts.candidates, prepared.geometry)),
        detectable=tuple(detectable(parts.candidates, final, known)),
        faults=prepared.faults + rounded,
        test=None if parts.test is None else test_figures(prepared.nominal, final, parts.test),
        given=parts.given,
        notes=(
            *_unweighed(problem),
            *(fact.sentence for fact in parts.given if not fact.obeyed),
            *prepared.notes,
            *c.warnings,
            *remarks(prepared, left, beyond, bool(nameless), repeats_to),
            *_carried(selection),
        ),
        geometry=geometry(final),
        unidentifiable=unidentifiable(final),
        facts=facts(problem),
        errors=pose_errors(prepared, alone, final),
        joints=problem.robot.joint_names,
        q=c.poses.q,
        version=__version__,
        inputs=c.files,
    )


def _unweighed(problem: Problem) -> list[str]:
    """A remark where the model has no masses: how an arm bends under its own weight looks like what its gears
    do."""
    if problem.arm.weighed or not problem.arm.gravity.any() or problem.arm.prismatic.all():
        return []
    return [
        f"The URDF of {problem.robot.name} has no masses: how the arm bends under its own weight is fitted "
        "without a name, and looks much like what gears do. State the masses before you believe the rest."
    ]


def _carried(selection: Selection) -> list[str]:
    """A remark on effects of known forms that the model has in it without their being named."""
    effects = [selection.fit.model.effects[i] for i in selection.nameless]
    labels = dict.fromkeys(effect.label for effect in effects if effect.cause != UNKNOWN)
    if not labels:
        return []
    return [
        "The model carries what has no name by effects of known forms as well, which the data do not settle "
        f"(model.toml has their numbers, no finding does): {', '.join(labels)}."
    ]


def _left(prepared: Prepared, selection: Selection) -> tuple[Remainder, Remainder]:
    """What the final fit leaves, and what of that real causes are not off their forms: by the noise that was
    there before any scatter was seen."""
    final, known = selection.fit, prepared.noise_known
    judged = fit(final.model, final.state, prepared.covariance, max_iterations=4)
    left = remainder(judged, known)
    companions = _companions(selection, judged) if left.scatter else []
    return left, beyond_forms(judged, known, companions) if companions else left


def _companions(selection: Selection, near: Fit) -> list[tuple[Effect, Array]]:
    """What real causes have beside the forms that they are fitted in, as large as these are likeliest."""
    scale = {bare(selection.components[m.component].key): m.scale for m in selection.members}
    problem = near.model.problem
    return [
        (companion, scale[effect.key] * sizes)
        for effect in near.model.effects
        if selection.named(effect)
        for companion, sizes in with_companions(near, (effect,), problem)[1:]
    ]


def _beside_what_is_found(findings: list[Finding]) -> list[Finding]:
    """Without rivals that are found themselves: these are there whatever it is."""
    there = {(f.cause, f.where) for f in findings if f.status == "named"}
    return [
        replace(f, rivals=tuple(r for r in f.rivals if (r.cause, r.where) not in there)) for f in findings
    ]


def _finding(parts: Parts, effect: Effect, own: list[int]) -> Finding:
    """One cause. own: numbers of its effects in the fit."""
    final, selection = parts.selection.fit, parts.selection
    found = standing(selection, effect)
    rivals = found.rivals
    named = found.probability >= PRIORS.named and found.by_data >= PRIORS.by_data
    read = {(fact.cause, fact.where) for fact in parts.given if fact.given is not None}
    problem = final.model.problem
    advice = list(
        filter(None, (separation_beside(effect.key, (r.cause, r.where), read, problem) for r in rivals))
    )
    if any(rival.cause == UNKNOWN for rival in rivals):
        advice.append("something without a name fits as well: see the unknown structure")
    parameters, sentence = _describe(final, own)
    strongest = max((i for i in own if final.model.effects[i].key == effect.key), key=final.wald)
    return Finding(
        cause=effect.cause,
        title=effect.title,
        where=effect.where,
        status="named" if named else "ambiguous",
        gain_mm=selection.gains_mm[effect.key],
        probability=found.probability,
        variant=_form(final, own, strongest),
        parameters=parameters,
        rivals=() if named else rivals,
        faint=() if named else found.faint,
        separate_by=None if named else "; ".join(dict.fromkeys(advice)) or ANYTHING,
        sentence=sentence,
        equation=effect.equation,
        evidence=evidence(final, final.model.effects[strongest], final.state.values[strongest]),
    )


def _form(final: Fit, own: Sequence[int], strongest: int) -> str:
    """The form of a finding that shows most; nothing where its cause and place say it."""
    effect = final.model.effects[strongest]
    if effect.where.order is not None:
        return ""
    first = next((e for e in effect.places(final.model.problem) if e.key == effect.key), effect)
    return "" if len(own) == 1 and effect.variant == first.variant else effect.variant


@dataclass(frozen=True)
class Standing:
    """A cause at its place among all that compete. rivals: those that cover the rest, likeliest first, and
    those that only their prior odds keep from it; faint: the likeliest of the others, without which it would
    be named were there no rivals; by_data: its probability where no other cause is less likely before the
    data than it: what the data alone say."""

    probability: float
    rivals: tuple[Rival, ...]
    faint: tuple[Rival, ...]
    by_data: float


def standing(selection: Selection, effect: Effect) -> Standing:
    """How a cause stands at its place, where it is likeliest."""
    best: tuple[float, Shares, int] | None = None
    for member, share in zip(selection.members, selection.shares, strict=True):
        component = selection.components[member.component]
        same = bare(component.key) == effect.key
        if same and (best is None or share[member.component] > best[0]):
            best = share[member.component], share, member.component
    assert best is not None
    probability, share, index = best
    raised = {k: p * _handicap(selection.components, index, k) for k, p in share.items()}
    total = sum(raised.values())
    covered, rivals, faint = probability, list[Rival](), list[Rival]()
    others = sorted(((p, k) for k, p in share.items() if k is not None and k != index), reverse=True)
    for p, k in others:
        rival = Rival(*selection.components[k].key, p)
        close = raised[k] >= (1 - PRIORS.by_data) * total
        worth_a_word = close or (covered < PRIORS.listed and p >= PRIORS.faintest_rival)
        if (rival.cause, rival.where) != effect.key:
            (rivals if worth_a_word else faint).append(rival)
        covered += p if worth_a_word else 0.0
    return Standing(probability, tuple(rivals), _not_yet_named(probability, faint), raised[index] / total)


def _not_yet_named(probability: float, faint: Sequence[Rival]) -> tuple[Rival, ...]:
    """The first of these rivals, likeliest first, until the others leave half of what a name leaves."""
    left = sum(rival.probability for rival in faint)
    kept = list[Rival]()
    for rival in faint:
        if left <= (1 - PRIORS.named) / 2 * probability:
            break
        kept.append(rival)
        left -= rival.probability
    return tuple(kept)


def _handicap(components: Sequence[Component], own: int, other: int | None) -> float:
    """By how much a cause was less likely than another before the data. A line's odds are also those of its
    order, and functions without a name stand for what nobody knows: these stay as they are."""
    if other is None or components[other].nameless or components[other].key[1].order is not None:
        return 1.0
    return float(np.exp(max(components[own].log_odds - components[other].log_odds, 0.0)))


def _describe(final: Fit, own: Sequence[int]) -> tuple[tuple[Parameter, ...], str]:
    """Parameters and sentence; further parts of one cause carry their order or form in the name."""
    parameters: list[Parameter] = []
    sentences: list[str] = []
    there = [(final.model.effects[i], final.effect_values(i)[0]) for i in own]
    given = final.model.given_values(final.state)
    there += [(item.effect, given[k, None]) for k, item in enumerate(final.model.given)]
    for n, i in enumerate(own):
        effect = final.model.effects[i].beside(there)
        values, covariance = final.effect_values(i)
        sentences.append(effect.sentence(values))
        for p in effect.report(values, covariance):
            clash = n > 0 and any(p.name == other.name for other in parameters)
            mark = f"order {effect.where.order:g}" if effect.where.order is not None else effect.variant
            parameters.append(replace(p, name=f"{p.name} ({mark})") if clash else p)
    return tuple(parameters), " ".join(s for s in sentences if s)


def _nameless(selection: Selection, worth_mm: float) -> list[Finding]:
    """Functions without a name that the likeliest set has, largest first, as one. worth_mm: what all of them
    together bring on held-out poses."""
    found = []
    part = "set-up" if len(selection.fit.model.problem.campaign.setup_names) > 1 else "half of the poses"
    for member, share in zip(selection.members, selection.shares, strict=True):
        component = selection.components[member.component]
        if component.nameless and share[None] < PRIORS.absent:
            (function,) = component.forms[0].effects
            assert isinstance(function, Unnamed)
            worth = selection.worth_mm(member)
            own = _unknown(selection.fit, function, share[member.component], worth)
            found.append(replace(own, rivals=_with_names(selection.components, share)))
    for member in selection.unrepeated:
        label = selection.components[member.component].label
        worth = selection.worth_mm(member)
        structure = f"looks like {label} in one {part} and not in another (it makes {worth:.3f} mm RMS)"
        found.append(_plain(structure, f"What is left {structure}.", NOWHERE, worth))
    for effect in {e.key: e for e in selection.fit.model.effects if e.key in selection.against}.values():
        structure = f"looks like {effect.label}, but with less than no compliance: something else gives way"
        worth = selection.gains_mm[effect.key]
        found.append(_plain(structure, f"What is left {structure}.", effect.where, worth))
    ordered = sorted(found, key=lambda finding: -finding.gain_mm)
    return [_as_one(ordered, max(worth_mm, 0.0))] if found else []


def _with_names(components: Sequence[Component], share: Shares) -> tuple[Rival, ...]:
    """The causes that could be what has no name, likeliest first."""
    causes = [
        (p, components[k].key) for k, p in share.items() if k is not None and not components[k].nameless
    ]
    return tuple(
        Rival(*key, p) for p, key in sorted(causes, key=lambda one: -one[0]) if p >= PRIORS.faintest_rival
    )


def _as_one(found: list[Finding], worth_mm: float) -> Finding:
    """What has no name is one finding: its largest part, the others told with it, and all causes that could
    be one of them."""
    first, *others = found
    likeliest: dict[tuple[str, Where], Rival] = {}
    for rival in sorted((r for one in found for r in one.rivals), key=lambda r: -r.probability):
        likeliest.setdefault((rival.cause, rival.where), rival)
    also = "; ".join(finding.structure or "" for finding in others[:ALSO_TOLD])
    structure = f"{first.structure} (besides: {also})" if also else first.structure
    sentence = f"What is left {structure}."
    rivals = tuple(likeliest.values())[:ALSO_TOLD]
    return replace(first, gain_mm=worth_mm, structure=structure, sentence=sentence, rivals=rivals)


def _scatter(selection: Selection, left: Remainder, rms_mm: float) -> Finding:
    """The residual is larger than the noise, and nothing that competed says where it comes from."""
    problem = selection.fit.model.problem
    where, place = NOWHERE, ""
    if selection.scatter.any():
        j = int(np.argmax(np.where(problem.arm.prismatic, 0.0, selection.scatter)))
        where = Where(joint=problem.arm.names[j])
        place = f", sits in {where.joint} ({selection.scatter[j] * 1e6:.0f} µrad from pose to pose)"
    elif any(selection.fit.noise.body):
        single = problem.seen.sum(axis=1).max() == 1
        place = ", as of a noise stated too small" if single else ", moves all targets of a pose together"
    unseen = [name for name, column in _columns(problem) if column is None]
    record = f", and record {_listed(unseen)}" if unseen else ""
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
    return _listed([word for use, word in words.items() if use in uses])


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def _plain(structure: str, sentence: str, where: Where, worth_mm: float) -> Finding:
    return Finding(
        UNKNOWN, Unnamed.title, where, "ambiguous", worth_mm, 1.0, structure=structure, sentence=sentence
    )


def _unknown(final: Fit, function: Unnamed, probability: float, worth: float) -> Finding:
    structure = f"depends on {function.variable}"
    return Finding(
        cause=UNKNOWN,
        title=Unnamed.title,
        where=function.where if function.where.other is None else NOWHERE,
        status="ambiguous",
        gain_mm=worth,
        probability=float(np.clip(probability, 0.0, 1.0)),
        structure=structure,
        sentence=f"What is left {structure}.",
        evidence=structure_evidence(final, function),
    )
