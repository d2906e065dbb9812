"""Puts a finished competition into findings: causes with rivals and parameters, and what has no name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import REFERENCE_TEMPERATURE, Problem
from ...effects import catalogue, separation_beside
from ...effects.base import UNKNOWN, Effect
from ...effects.place import Parameter
from ...files.version import version
from ...identification.fit import Fit, fit
from ...identification.heldout import heldout
from ...robot.kinematics import Array
from ..data_faults.rounded_joints import rounded_joints
from ..found import Detectable, Finding, GivenFact, NotTestable, Stage
from ..prepared import Prepared
from ..priors import PRIORS
from ..result import Diagnosis
from ..search.competition import SHOWS, Selection
from ..search.stages import geometry_alone, pose_errors, rms_mm, stages_of
from ..weighing.components import bare, with_companions
from ..weighing.remainder import Remainder, beyond_forms, remainder, repeatability_mm
from .ceiling import ceiling_mm
from .evidence import evidence
from .facts import facts, geometry, of_campaigns, unidentifiable
from .headline import Errors, headline, in_order, remarks, shows_in, steps, verdict_of, with_left
from .in_the_model import InModel, beside_the_model, has
from .nameless import UNSURE, nameless_of, scattering
from .on_test_campaign import test_figures
from .power import detectable, swallowed, visible_mm, wandering_mm
from .set_ups_apart import by_comparing, perhaps_changed
from .standing import standing, why_open
from .unseen import allowing_for_unseen

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
    problem, c = prepared.problem, prepared.problem.campaign
    alone = geometry_alone(prepared)
    stages = stages_of(prepared, alone, final, selection.groups, parts.seed)
    errors = _errors(parts, stages, stages[1 if alone is prepared.geometry else 2])
    left, beyond = _left(prepared, selection)
    rounded = rounded_joints(final, prepared.geometry, prepared.noise, beyond)
    repeats_to = None if rounded else repeatability_mm(final, beyond, prepared.covariance)
    named = _named(parts)
    # so much is no part of causes that are off their forms
    more = left if left.scatter and errors.much_left else beyond
    nameless = _nameless(parts, errors, more if repeats_to is None else None)
    verdict = verdict_of(named, nameless, errors)
    findings = _beside_what_is_found([*named, *nameless])
    faults = in_order(prepared.faults, c.poses.ids)
    moved, in_what = steps(faults), shows_in(prepared, left, errors.noise)
    untested = _swallowed(parts, named)
    line = headline(verdict, findings, errors, parts.given, repeats_to, in_what, bool(moved))
    return Diagnosis(
        robot=problem.robot.name,
        robot_title=problem.robot.title,
        campaign=c.title,
        n_poses=len(c.poses),
        n_points=int(problem.seen.sum()),
        noise=with_left(prepared.noise, left),
        stages=tuple(stages),
        verdict=verdict,
        headline=line + moved,
        causes=tuple(findings),
        ceiling_mm=errors.ceiling,
        remainder_chi2=left.chi2,
        remainder_dof=left.dof,
        remainder_p=left.p,
        not_testable=(*parts.not_testable, *untested),
        detectable=tuple(_that_would_show(parts, untested)),
        faults=faults + rounded,
        too_few=verdict == "nothing_missing" and errors.too_few,
        test=None if parts.test is None else test_figures(prepared.nominal, final, parts.test),
        given=parts.given,
        notes=(
            *_unweighed(problem),
            *_unwarmed(problem),
            *(fact.sentence for fact in parts.given if not fact.obeyed),
            *prepared.notes,
            *c.warnings,
            *remarks(prepared, left, beyond, bool(nameless), repeats_to),
            *_carried(selection),
            *(perhaps_changed(final) if nameless else []),
        ),
        geometry=geometry(final),
        unidentifiable=unidentifiable(final),
        facts=facts(problem, final),
        campaigns=of_campaigns(prepared, alone, final),
        errors=pose_errors(prepared, alone, final),
        version=version(),
        inputs=c.files,
    )


def _errors(parts: Parts, stages: Sequence[Stage], base: Stage) -> Errors:
    """What the verdict weighs."""
    final = parts.selection.fit
    return Errors(
        stages=stages,
        base=base,
        with_names=stages[stages.index(base) + len(parts.selection.groups)].heldout_rms_mm,
        ceiling=min(stages[-1].heldout_rms_mm, ceiling_mm(final, parts.candidates)),
        visible=visible_mm(final, parts.candidates),
        wandering=wandering_mm(final, parts.candidates),
        noise=1e3 * float(np.sqrt(3) * final.usual),
        lasting=0.0 if final.lasting is final else rms_mm(heldout(final.lasting, seed=parts.seed)),
    )


def _named(parts: Parts) -> list[Finding]:
    """The causes, by what they gain."""
    groups, final = parts.selection.groups, parts.selection.fit
    sure = _how_sure(parts) if groups else final.covariance
    return sorted((_finding(parts, *group, sure) for group in groups), key=lambda finding: -finding.gain_mm)


def _nameless(parts: Parts, errors: Errors, more: Remainder | None) -> list[Finding]:
    """What has no name. more: what is left for that, where it is not how the robot repeats."""
    best = errors.stages[-1].heldout_rms_mm
    found = nameless_of(parts.selection, errors.with_names - best)
    if not found and more is not None and more.scatter:
        stated = parts.prepared.noise.source == "stated"
        scatters = scattering(parts.selection, more, parts.prepared.covariance, best)
        if not stated or scatters.where.keys() or more.inflation > UNSURE:
            found = [scatters]
    return [_with_comparison(one, parts.prepared.problem) for one in found]


def _swallowed(parts: Parts, named: Sequence[Finding]) -> list[NotTestable]:
    """Causes that the geometry takes up, but for what is told of already."""
    told = {(f.cause, f.where.any_order) for f in named}
    told |= {(rival.cause, rival.where.any_order) for f in named for rival in f.rivals}
    return swallowed(parts.candidates, parts.prepared.geometry, parts.selection.fit, told)


def _that_would_show(parts: Parts, untested: Sequence[NotTestable]) -> list[Detectable]:
    """Sizes that would have shown, without those of what was not tested: what the fit came to may show a
    little of what geometry took up before."""
    out = {(item.cause, item.where.any_order) for item in untested}
    sizes = detectable(parts.candidates, parts.selection.fit, parts.prepared.noise_known)
    return [item for item in sizes if (item.cause, item.where.any_order) not in out]


def _unweighed(problem: Problem) -> list[str]:
    """A remark where the model has no masses: how an arm bends under its own weight looks like what its gears
    do."""
    if problem.arm.weighed or not problem.arm.gravity.any() or problem.arm.prismatic.all():
        return []
    return [
        f"The URDF of {problem.robot.name} has no masses: how the arm bends under its own weight is fitted "
        "without a name, and looks much like what gears do. State the masses before you believe the rest."
    ]


def _unwarmed(problem: Problem) -> list[str]:
    """A remark where some set-ups have temperatures and others have none."""
    c = problem.campaign
    if problem.warmth is None or c.poses.temperature is None:
        return []
    known = np.isfinite(c.poses.temperature)
    without = [name for i, name in enumerate(c.setup_names) if not known[c.poses.setup == i].any()]
    if not without:
        return []
    mean = REFERENCE_TEMPERATURE + problem.warmth[~known].mean()
    return [
        f"{', '.join(without)}: no temperature (temp_degC); taken to be as warm as the rest is in the mean, "
        f"{mean:.1f} °C. Links that grow then look like something else."
    ]


def _with_comparison(finding: Finding, problem: Problem) -> Finding:
    """What has no name in several campaigns, with the command that says whether these are of one robot."""
    advice = [finding.separate_by, by_comparing(problem)]
    return replace(finding, separate_by="; ".join(filter(None, advice)) or None)


def _carried(selection: Selection) -> list[str]:
    """Remarks on effects of known forms that the model has in it without their being named."""
    effects = [selection.fit.model.effects[i] for i in selection.nameless]
    known = [effect for effect in effects if effect.cause != UNKNOWN]
    held = dict.fromkeys(effect.label for effect in known if effect.is_held)
    labels = dict.fromkeys(effect.label for effect in known if not effect.is_held)
    said = []
    if labels:
        said.append(
            "The model carries what has no name by effects of known forms as well, which the data do not "
            f"settle (model.toml has their numbers, no finding does): {', '.join(labels)}."
        )
    if held:
        said.append(
            "An arm that yields where it was found to yields elsewhere too, by less than can be told apart: "
            f"{len(held)} other places are in the model, each held to the size of those that were found, and "
            "sizes and bounds allow for them."
        )
    return said


def _left(prepared: Prepared, selection: Selection) -> tuple[Remainder, Remainder]:
    """What the final fit leaves, and what of that real causes are not off their forms: by the noise that was
    there before any scatter was seen."""
    final, known = selection.fit, prepared.noise_known
    judged = fit(final.model, final.state, prepared.covariance, max_iterations=4, line=final.line)
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


def _how_sure(parts: Parts) -> Array:
    """(P, P) how far the final fit's numbers are off in the mean square, for all that may be there beside."""
    final = parts.selection.fit
    return allowing_for_unseen(final, _companions(parts.selection, final), parts.candidates)


def _finding(parts: Parts, effect: Effect, own: list[int], sure: Array) -> Finding:
    """One cause. own: numbers of its effects in the fit; sure: (P, P), see `_how_sure`."""
    final, selection = parts.selection.fit, parts.selection
    found = standing(selection, effect)
    rivals = found.rivals
    named = found.probability >= PRIORS.named and found.by_data >= PRIORS.by_data
    read = {(fact.cause, fact.where) for fact in parts.given if fact.given is not None}
    problem = final.model.problem
    advice = list(
        filter(None, (separation_beside(effect.key, (r.cause, r.where), read, problem) for r in rivals))
    )
    parameters, told = _describe(final, own, sure)
    mains = [i for i in own if final.model.effects[i].key == effect.key]
    strongest = mains[0] if effect.ordered else max(mains, key=final.wald)
    return Finding(
        cause=effect.cause,
        title=effect.heading,
        called=effect.called,
        where=effect.where,
        status="named" if named else "ambiguous",
        gain_mm=selection.gains_mm[effect.key],
        probability=found.probability,
        variant=_form(final, own, strongest),
        parameters=parameters,
        rivals=() if named else rivals,
        faint=() if named else found.faint,
        separate_by=None if named else "; ".join(dict.fromkeys(advice)) or ANYTHING,
        sentence=told.sentence if named else " ".join([told.sentence, *why_open(found)]),
        taken_back=told.taken_back,
        equation=effect.equation,
        evidence=evidence(final, final.model.effects[strongest], final.state.values[strongest]),
    )


def _form(final: Fit, own: Sequence[int], strongest: int) -> str:
    """The form of a finding that shows most; nothing where its cause and place say it."""
    effect = final.model.effects[strongest]
    if effect.where.order is not None:
        return ""
    places = catalogue()[effect.cause].places(final.model.problem)
    first = next((e for e in places if e.key == effect.key), effect)
    return "" if len(own) == 1 and effect.variant == first.variant else effect.variant


def _describe(final: Fit, own: Sequence[int], sure: Array) -> tuple[tuple[Parameter, ...], InModel]:
    """Parameters and sentence; further parts of one cause carry their order or form in the name. Of a gear's
    further lines a sentence says those that show. sure: (P, P) covariance of the fit's numbers."""
    parameters: list[Parameter] = []
    sentences: list[str] = []
    there = [(final.model.effects[i], final.effect_values(i)[0]) for i in own]
    given = final.model.given_values(final.state)
    there += [(item.effect, given[k, None]) for k, item in enumerate(final.model.given)]
    for n, i in enumerate(own):
        effect = final.model.effects[i].beside(there)
        values, part = final.state.values[i], final.columns.effect[i]
        if n == 0 or not effect.ordered or final.wald(i) > SHOWS:
            sentences.append(effect.sentence(values + has(final, final.model.effects[i])))
        for p in effect.report(values, sure[part, part]):
            clash = n > 0 and any(p.name == other.name for other in parameters)
            mark = f"order {effect.where.order:g}" if effect.where.order is not None else effect.variant
            parameters.append(replace(p, name=f"{p.name} ({mark})") if clash else p)
    told = said_together([s for s in sentences if s])
    return tuple(parameters), beside_the_model(final, [final.model.effects[i] for i in own], told)


def said_together(sentences: Sequence[str]) -> str:
    """Sentences one after the other; what the next ones say `by` how much of the same begins once.

    >>> said_together(["The gear errs by 9 µrad in 2 cycles.", "The gear errs by 4 µrad in 6 cycles."])
    'The gear errs by 9 µrad in 2 cycles; by 4 µrad in 6 cycles.'
    """
    told: list[str] = []
    for sentence in sentences:
        head, by, _ = sentence.partition(" by ")
        if by and told and told[-1].startswith(head + by):
            told[-1] = f"{told[-1].removesuffix('.')};{sentence.removeprefix(head)}"
        else:
            told.append(sentence)
    return " ".join(told)
