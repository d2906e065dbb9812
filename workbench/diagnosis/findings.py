"""Puts a finished search into findings: causes with their rivals and parameters, and what is left unknown."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .. import __version__
from ..campaign import Campaign
from ..effects import separation
from ..effects.place import Parameter, Where
from ..identification.fit import Fit
from ..robot.kinematics import Array
from .evidence import evidence, structure_evidence
from .facts import facts, geometry, unidentifiable
from .headline import headline, remarks, verdict_of
from .on_test_campaign import test_figures
from .power import detectable, swallowed
from .prepared import Prepared
from .result import Diagnosis, Finding, NotTestable
from .rounded_joints import rounded_joints
from .search import Selection
from .stages import Group, pose_errors, rms_mm, stages_of, without
from .verdict import (
    EXPLAINS_MOST,
    OVERSHADOWED,
    STANDS_OUT,
    Remainder,
    describe_structure,
    explained_share,
    patchwork,
    remainder,
    stands_alone,
    stands_out,
)


@dataclass(frozen=True)
class Parts:
    """What the run has gathered."""

    prepared: Prepared
    selection: Selection
    not_testable: tuple[NotTestable, ...]
    seed: int
    test: Campaign | None


def assemble(parts: Parts) -> Diagnosis:
    """The Diagnosis."""
    prepared, selection, final = parts.prepared, parts.selection, parts.selection.fit
    problem, known, c = prepared.problem, prepared.noise_known, prepared.problem.campaign
    groups = _groups(selection)
    stages, unseen = stages_of(prepared, final, groups, parts.seed)
    left = remainder(final, known)
    share = explained_share(final, left)
    sure = [_sure(parts, group, left) for group in groups]
    mostly = bool(groups) and share >= EXPLAINS_MOST and all(sure) and known
    best = stages[-1].heldout_rms_mm
    findings = [_finding(parts, groups, g, best, sure[g]) for g in range(len(groups))]
    patched = patchwork(selection.effects)
    unknown = (left.structured and not mostly) or bool(patched)
    if unknown:
        findings.append(_unknown(parts, left, unseen, patched))
    verdict = verdict_of(findings, unknown)
    return Diagnosis(
        robot=problem.robot.name,
        robot_title=problem.robot.title,
        campaign=c.title,
        n_poses=len(c.poses.q),
        n_points=int(problem.seen.sum()),
        noise=prepared.noise,
        stages=tuple(stages),
        verdict=verdict,
        headline=headline(verdict, findings, stages),
        causes=tuple(findings),
        remainder_chi2=left.chi2,
        remainder_dof=left.dof,
        remainder_p=left.p,
        not_testable=(*parts.not_testable, *swallowed(selection, final, problem)),
        detectable=tuple(detectable(selection, final, known)),
        faults=prepared.faults + rounded_joints(final, prepared.noise, left),
        test=None if parts.test is None else test_figures(prepared.nominal, final, parts.test),
        notes=(*prepared.notes, *c.warnings, *remarks(prepared, left, share, mostly)),
        geometry=geometry(final),
        unidentifiable=unidentifiable(final),
        facts=facts(problem),
        errors=pose_errors(prepared, final),
        joints=tuple(joint.name for joint in problem.robot.joints),
        q=c.poses.q,
        version=__version__,
        inputs=c.files,
    )


def _groups(selection: Selection) -> list[Group]:
    """Accepted effects of one cause and place together, strongest first (indices into the fit's effects)."""
    found: dict[tuple[str, Where], Group] = {}
    for i, effect in enumerate(selection.effects):
        found.setdefault(effect.key, (effect, []))[1].append(i)
    return list(found.values())


def _sure(parts: Parts, group: Group, left: Remainder) -> bool:
    """Whether a cause stays significant whatever else is going on."""
    selection, final = parts.selection, parts.selection.fit
    effect, own = group
    out = any(stands_out(final, i) * selection.tries[i] < STANDS_OUT for i in own)
    free = not left.structured or any(
        stands_alone(final, i, left, STANDS_OUT / selection.tries[i]) for i in own
    )
    # beside something unknown that is far larger nothing is sure (where the noise is known, its size is)
    judged = left.structured and parts.prepared.noise_known
    excess = left.chi2 - left.dof if judged else 0.0
    free = free and sum(final.wald(i) for i in own) >= OVERSHADOWED * excess
    piece = effect.smooth or effect.ordered
    return out and free and not (piece and effect.where.joint in patchwork(selection.effects))


def _finding(parts: Parts, groups: list[Group], g: int, best_mm: float, sure: bool) -> Finding:
    """One cause; best_mm: held-out RMS with all of them."""
    effect, own = groups[g]
    final, selection = parts.selection.fit, parts.selection
    rivals = _rivals(selection, groups, own)
    named = sure and not rivals
    advice = list(filter(None, (separation(effect.cause, cause) for cause, _ in rivals)))
    if not sure:
        rivals.append(("unknown", Where()))
        advice.append("something else is left in the data: see the unknown structure")
    if not named and not advice:
        advice.append("more poses, spread over the whole range of the joints, and a second payload")
    parameters, sentence = _describe(final, groups[g])
    aliases = selection.aliases.get(effect.where.joint or "", ())
    if effect.searched and aliases:
        sentence += f" These poses fit other orders as well (e.g. {aliases[0]:g}): random poses would decide."
    strongest = min(own, key=lambda i: selection.p_values[i])
    return Finding(
        cause=effect.cause,
        title=effect.title,
        where=effect.where,
        status="named" if named else "ambiguous",
        gain_mm=without(final, own, parts.seed) - best_mm,
        p_value=selection.p_values[strongest],
        parameters=parameters,
        rivals=tuple(rivals),
        separate_by="; ".join(dict.fromkeys(advice)) if not named else None,
        sentence=sentence,
        equation=effect.equation,
        evidence=evidence(final, final.model.effects[strongest], final.state.values[strongest]),
    )


def _rivals(selection: Selection, groups: list[Group], own: list[int]) -> list[tuple[str, Where]]:
    """Causes that could stand in for a cause with the parts `own`, none of them accepted beside it."""
    accepted = {effect.key for effect, _ in groups}
    keys = [selection.pool.candidates[k].key for i in own for k in selection.rivals[i]]
    return list(dict.fromkeys(key for key in keys if key not in accepted))


def _describe(final: Fit, group: Group) -> tuple[tuple[Parameter, ...], str]:
    """Parameters and sentence; further parts of one cause carry their order or form in the name."""
    parameters: list[Parameter] = []
    sentences: list[str] = []
    for n, i in enumerate(group[1]):
        effect = final.model.effects[i]
        values, covariance = final.effect_values(i)
        sentences.append(effect.sentence(values))
        for p in effect.report(values, covariance):
            clash = n > 0 and any(p.name == other.name for other in parameters)
            mark = f"order {effect.where.order:g}" if effect.where.order is not None else effect.variant
            parameters.append(replace(p, name=f"{p.name} ({mark})") if clash else p)
    return tuple(parameters), " ".join(s for s in sentences if s)


def _unknown(parts: Parts, left: Remainder, residual: Array, patched: set[str]) -> Finding:
    p = left.tests[0][1] if left.tests else left.p
    where = Where()
    if patched:
        where = Where(joint=sorted(patched)[0])
        structure = f"depends on {where.joint}: a smooth function of it that no single cause draws"
        sentence = f"What several causes draw together {structure}."
        p = min(parts.selection.p_values)
    else:
        if left.tests and left.tests[0][0].family.joint is not None:
            where = Where(joint=parts.prepared.problem.arm.names[left.tests[0][0].family.joint])
        structure = describe_structure(left, rms_mm(residual))
        sentence = f"What is left {structure}." if left.tests else f"{structure[0].upper()}{structure[1:]}."
    return Finding(
        cause="unknown",
        title="Something that no cause of the catalogue explains",
        where=where,
        status="ambiguous",
        gain_mm=0.0,
        p_value=float(p),
        structure=structure,
        sentence=sentence,
        evidence=structure_evidence(parts.selection.fit, left.tests[0][0]) if left.tests else None,
    )
