"""Puts a finished search into words and numbers: stages, findings, verdict, what could not be seen."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects.base import Effect
from ..effects.gear_kinematic_error import GearKinematicError
from ..effects.place import Parameter, Where
from ..identification.fit import Fit, refit
from ..identification.heldout import heldout
from ..robot.kinematics import Array
from .evidence import evidence, structure_evidence
from .facts import facts, geometry, unidentifiable
from .on_test_campaign import test_figures
from .power import detectable, swallowed
from .result import Diagnosis, FaultFound, Finding, Noise, NotTestable, PoseErrors, Stage, Verdict
from .search import Selection
from .verdict import (
    MOSTLY,
    OVERSHADOWED,
    PIECES,
    SURE,
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

    problem: Problem
    noise: Noise
    nominal: Fit
    geometry: Fit
    selection: Selection
    faults: tuple[FaultFound, ...]
    notes: tuple[str, ...]
    not_testable: tuple[NotTestable, ...]
    known: bool
    seed: int
    test: Campaign | None


Groups = list[tuple[Effect, list[int]]]


def assemble(parts: Parts) -> Diagnosis:
    """The Diagnosis."""
    final, selection, c = parts.selection.fit, parts.selection, parts.problem.campaign
    groups = _groups(selection)
    stages, heldouts = _stages(parts, groups)
    left = remainder(final, parts.known)
    share = explained_share(final, left)
    sure = _sure(parts, groups, left)
    mostly = bool(groups) and share >= MOSTLY and all(sure.values()) and parts.known
    findings = [_finding(parts, groups, g, stages, sure[g]) for g in range(len(groups))]
    notes = list(parts.notes) + list(c.warnings) + _remarks(parts, left, share, mostly)
    patched = patchwork(selection.effects)
    unknown = (left.structured and not mostly) or bool(patched)
    if unknown:
        findings.append(_unknown(parts, left, heldouts[-1], patched))
    verdict = _verdict(findings, unknown)
    test = test_figures(parts.nominal, final, parts.test) if parts.test is not None else None
    names = [joint.name for joint in parts.problem.robot.joints]
    return Diagnosis(
        robot=parts.problem.robot.name,
        robot_title=parts.problem.robot.title,
        campaign=c.title,
        n_poses=len(c.q),
        n_points=int(parts.problem.seen.sum()),
        noise=parts.noise,
        stages=tuple(stages),
        verdict=verdict,
        headline=_headline(verdict, findings, stages),
        causes=tuple(findings),
        remainder_chi2=left.chi2,
        remainder_dof=left.dof,
        remainder_p=left.p,
        not_testable=parts.not_testable + tuple(swallowed(selection, final, parts.problem)),
        detectable=tuple(detectable(selection, final, parts.known)),
        faults=parts.faults + _rounded(parts, left),
        test=test,
        notes=tuple(notes),
        geometry=geometry(final),
        unidentifiable=unidentifiable(final),
        facts=facts(parts.problem),
        errors=_errors(parts),
        joints=tuple(names),
        q=c.q,
        version=importlib.metadata.version("robot-workbench"),
        inputs=c.files,
    )


def _groups(selection: Selection) -> Groups:
    """Accepted effects of one cause and place together, strongest first (indices into the fit's effects)."""
    found: dict[tuple[str, Where], tuple[Effect, list[int]]] = {}
    for i, effect in enumerate(selection.effects):
        found.setdefault(effect.key, (effect, []))[1].append(i)
    return list(found.values())


def _stages(parts: Parts, groups: Groups) -> tuple[list[Stage], list[Array]]:
    """Nominal, geometry, then one stage per cause; and the held-out residuals of each."""
    final = parts.selection.fit
    fits = [("nominal", parts.nominal), ("geometry", parts.geometry)]
    members: list[int] = []
    name = "geometry"
    for i, (effect, own) in enumerate(groups):
        members += own
        name += f" + {effect.label}"
        last = i == len(groups) - 1
        fits.append((name, final if last else refit(final, [final.model.effects[m] for m in members])))
    stages, residuals = [], []
    for name, result in fits:
        out = heldout(result, seed=parts.seed)
        length = np.linalg.norm(out, axis=2)
        fitted = np.linalg.norm(result.residual, axis=2)
        mean, largest = float(np.nanmean(length)), float(np.nanmax(length))
        stages.append(
            Stage(
                name,
                0 if name == "nominal" else result.rank - parts.nominal.rank,
                1e3 * _rms(length),
                1e3 * mean,
                1e3 * largest,
                1e3 * _rms(fitted),
                _stage_note(parts, name, result),
            )
        )
        residuals.append(out)
    return stages, residuals


def _stage_note(parts: Parts, name: str, result: Fit) -> str:
    if name != "nominal" or result.rank >= len(result.columns.names):
        return ""
    return (
        "The poses cannot tell the instrument's frame from the targets: the targets stay near the "
        "stated places."
    )


def _rms(length: Array) -> float:
    return float(np.sqrt(np.nanmean(length**2)))


def _sure(parts: Parts, groups: Groups, left: Remainder) -> dict[int, bool]:
    """Which groups stay significant whatever else is going on."""
    selection = parts.selection
    final = selection.fit
    sure = {}
    patched = patchwork(selection.effects)
    for g, (effect, own) in enumerate(groups):
        out = any(stands_out(final, i) * selection.tries[i] < SURE for i in own)
        free = not left.structured or any(
            stands_alone(final, i, left, SURE / selection.tries[i]) for i in own
        )
        # beside something unknown that is far larger nothing is sure (where the noise is known, its size is)
        excess = left.chi2 - left.dof if left.structured and parts.known else 0.0
        free = free and sum(final.wald(i) for i in own) >= OVERSHADOWED * excess
        pieces = effect.cause in PIECES and effect.where.joint in patched
        sure[g] = out and free and not pieces
    return sure


def _finding(parts: Parts, groups: Groups, g: int, stages: list[Stage], sure: bool) -> Finding:
    effect, own = groups[g]
    final, selection = parts.selection.fit, parts.selection
    without = [e for i, e in enumerate(final.model.effects) if i not in own]
    worse = _rms(np.linalg.norm(heldout(refit(final, without), seed=parts.seed), axis=2)) * 1e3
    gain = worse - stages[-1].heldout_rms_mm
    pool = selection.pool
    chosen_keys = {e.key for e, _ in groups}
    rivals: dict[tuple[str, Where], None] = {}
    for i in own:
        for k in selection.rivals[i]:
            if pool.candidates[k].key not in chosen_keys:
                rivals.setdefault(pool.candidates[k].key, None)
    # a cause with several accepted parts has a rival only if that rival replaces the strongest part
    named = sure and not rivals
    separate = effect.separate
    advice = [separate[cause] for cause, _ in rivals if cause in separate]
    listed: list[tuple[str, Where]] = list(rivals)
    if not sure:
        listed.append(("unknown", Where()))
        advice.append("something else is left in the data: see the unknown structure")
    if not named and not advice:
        advice.append("more poses, spread over the whole range of the joints, and a second payload")
    parameters, sentence = _describe(final, groups[g])
    joint = effect.where.joint
    aliases = selection.aliases.get(joint or "", ())
    if isinstance(effect, GearKinematicError) and effect.searched and aliases:
        sentence += f" These poses fit other orders as well (e.g. {aliases[0]:g}): random poses would decide."
    strongest = min(own, key=lambda i: selection.p_values[i])
    return Finding(
        cause=effect.cause,
        title=effect.title,
        where=effect.where,
        status="named" if named else "ambiguous",
        gain_mm=gain,
        p_value=selection.p_values[strongest],
        parameters=parameters,
        rivals=tuple(listed),
        separate_by="; ".join(dict.fromkeys(advice)) if not named else None,
        sentence=sentence,
        equation=effect.equation,
        evidence=evidence(final, final.model.effects[strongest], final.state.values[strongest]),
    )


def _describe(final: Fit, group: tuple[Effect, list[int]]) -> tuple[tuple[Parameter, ...], str]:
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
    rms = 1e3 * _rms(np.linalg.norm(residual, axis=2))
    p = left.tests[0][1] if left.tests else left.p
    where = Where()
    if patched:
        where = Where(joint=sorted(patched)[0])
        structure = f"depends on {where.joint}: a smooth function of it that no single cause draws"
        sentence = f"What several causes draw together {structure}."
        p = min(parts.selection.p_values)
    else:
        if left.tests and left.tests[0][0].family.joint is not None:
            where = Where(joint=parts.problem.arm.names[left.tests[0][0].family.joint])
        structure = describe_structure(left, rms)
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


def _verdict(findings: Sequence[Finding], unknown: bool) -> Verdict:
    if unknown:
        return "unknown"
    if not findings:
        return "nothing_missing"
    return "named" if all(f.status == "named" for f in findings) else "ambiguous"


def _headline(verdict: Verdict, findings: Sequence[Finding], stages: Sequence[Stage]) -> str:
    """The verdict in one line; the numbers follow after the first full stop."""
    found = [f for f in findings if f.cause != "unknown"]
    named = [
        f"{f.cause.replace('_', ' ')} in {f.where}" if str(f.where) else f.cause.replace("_", " ")
        for f in found
    ]
    listed = ", ".join(named[:4]) + (f" and {len(named) - 4} more" if len(named) > 4 else "")
    gain = (
        f"Held-out error {stages[0].heldout_rms_mm:.3f} → {stages[-1].heldout_rms_mm:.3f} mm RMS, "
        f"{stages[1].heldout_rms_mm:.3f} mm with geometry alone."
    )
    if verdict == "nothing_missing":
        return f"Nothing is missing: geometry explains these data. {gain}"
    if verdict == "unknown":
        also = f" Found on the way: {listed}." if named else ""
        return f"Something is left that no known cause explains.{also} {gain}"
    if verdict == "ambiguous":
        return f"Found: {listed}; for some of it other explanations fit as well. {gain}"
    return f"Found: {listed}. {gain}"


def _remarks(parts: Parts, left: Remainder, share: float, mostly: bool) -> list[str]:
    notes = []
    if left.structured and mostly:
        notes.append(
            f"The causes found explain {share:.0%} of what geometry leaves; their form is not exact: a "
            "small remainder is still significant."
        )
    if parts.known and not left.structured and left.p < 1e-3:
        word = "larger" if left.inflation > 1 else "smaller"
        notes.append(
            f"The residual is {abs(left.inflation - 1):.0%} {word} than the noise says, without any "
            "structure: check the stated noise, or repeat ten poses five times."
        )
    if not parts.known:
        notes.append(parts.noise.sentence)
    return notes


def _rounded(parts: Parts, left: Remainder) -> tuple[FaultFound, ...]:
    """Joints that are multiples of a step which alone would make the scatter that is left.

    Commands are often round numbers and then exact; only unexplained scatter makes them suspect.
    """
    if not left.scatter:
        return ()
    problem = parts.problem
    axial = parts.selection.fit.line.direct[:, : 3 * problem.seen.shape[1], problem.arm.axial]
    lever = np.sqrt(np.mean(axial**2, axis=(0, 1)))
    excess = parts.noise.sigma_mm * 1e-3 * np.sqrt(max(left.inflation**2 - 1, 0.0))
    for step in (1.0, 0.5, 0.1, 0.05, 0.01):
        turns = np.degrees(problem.q) / step
        round_ = np.abs(turns - np.round(turns)).max(axis=0) < 1e-6
        made = float(
            np.sqrt(np.sum((lever * np.radians(step) / np.sqrt(12))[round_ & ~problem.arm.prismatic] ** 2))
        )
        if round_.all() and 0.4 * excess < made < 2.5 * excess:
            what = f"all joints are multiples of {step:g}°, which alone scatters {made * 1e3:.3f} mm per axis"
            return (
                FaultFound("rounded_joints", None, None, what, "kept: record the joints with more digits"),
            )
    return ()


def _errors(parts: Parts) -> PoseErrors:
    """Errors per point, turned into the base frame."""
    final, c = parts.selection.fit, parts.problem.campaign
    R = final.state.R[c.setup]
    base = np.einsum("nij,nti->ntj", R, c.points - final.state.t[c.setup][:, None])
    seen = parts.problem.seen
    n, t = np.nonzero(seen)

    def turned(result: Fit) -> Array:
        return np.einsum("nij,nti->ntj", result.state.R[c.setup], result.residual)[seen]

    return PoseErrors(
        base[seen],
        turned(parts.nominal),
        turned(parts.geometry),
        turned(final),
        n.astype(np.int64),
        t.astype(np.int64),
    )
