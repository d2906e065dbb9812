"""What a report says, in words and ready numbers: the page and the PDF both set this text.

Everything here is a string, a list or a dict, so that the PDF can take it as JSON, and nobody
downstream formats a number again.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from scipy.stats import maxwell

from ..diagnosis.found import NAMELESS, FaultFound, Finding, GivenFact
from ..diagnosis.result import Diagnosis
from ..diagnosis.telling.headline import STEPS, listed, words_of
from ..effects.base import UNKNOWN
from ..effects.place import Parameter
from . import figures
from .dataset import SUPPORT, facts
from .deciding import to_decide, ways
from .drawing import Figure
from .equation import typeset
from .legible import legible
from .limits import detectable, not_testable, place, place_of, unidentifiable
from .numbers import (
    MISSING,
    NOT_KNOWN,
    bound,
    decimals,
    mm,
    mm_change,
    p_value,
    probability,
    quantity,
    words,
)
from .reliability import published
from .worst import worst_head, worst_poses, worst_said

Content = dict[str, Any]


@dataclass(frozen=True)
class Material:
    """What page and PDF are set from: text with ready numbers, figures by name, equations as SVG."""

    said: Content
    figures: Mapping[str, Figure]
    equations: Mapping[str, str]


VERDICTS = {
    "nothing_missing": "Nothing is missing",
    "named": "Cause found",
    "ambiguous": "Rivals remain",
    "unknown": "Unexplained structure",
}
COUNT = ("no", "the", "the two", "the three", "the four", "the five", "the six", "the seven", "the eight")
LAMBDA = (
    "λ is how far apart two explanations are in the data: the squared distance between what they predict, in "
    "standard deviations of the noise, with the rival as large as imitates best. It takes both as exactly of "
    "their form, which no real machine is, and one may be likelier than the other before the data. So a "
    "cause may be open at a large λ: it is settled where λ outweighs both."
)
DETECTABLE = (
    "Smaller effects than these would have stayed unseen (80 % power). Of a mass, a length is how far its "
    "centre would have to be off."
)
UNIDENTIFIABLE = (
    "These corrections of the joints' frames (tx, ty, tz: shifts; rx, ry, rz: turns; z is the axis of "
    "motion) stay as the model has them: in these poses they move no point, or as others do."
)
GEOMETRY = (
    "Corrections of the joints' frames to the model: tx, ty, tz shifts, rx, ry, rz turns; z is the axis of "
    "motion. The {rows} rows are {parameters} independent parameters. Intervals: {support}. "
    "Where one is wide, other rows move the points alike: what they make together is known, each by itself "
    "is not."
)
IN_TILES = re.compile(r"Held-out error [^()]*?\.(?=\s|$)")  # of the headline: tiles and stages say it
OUTSIDE = "something that no cause of the catalogue explains"


def content(diagnosis: Diagnosis) -> Content:
    """All text and numbers of the report, in its order."""
    step, command = next_step(diagnosis)
    return {
        "robot": diagnosis.robot_title or diagnosis.robot,
        "campaign": diagnosis.campaign,
        "origin": " · ".join(dict.fromkeys((diagnosis.robot_title or diagnosis.robot, diagnosis.campaign))),
        "verdict": _verdict(diagnosis),
        "summary": _summary(diagnosis),
        "next": step,
        "next_command": command,
        "proof": list(diagnosis.proof) if diagnosis.proof else None,
        "revealed": asdict(diagnosis.revealed) if diagnosis.revealed else None,
        "tiles": _tiles(diagnosis),
        "start": diagnosis.start,
        "bounds": _bounds(diagnosis),
        "test": _test(diagnosis),
        "stages": _stages(diagnosis),
        "remainder": _remainder(diagnosis),
        "causes": [_cause(finding, number) for number, finding in enumerate(diagnosis.causes)],
        "no_cause": _no_cause(diagnosis),
        "of_lambda": LAMBDA if any(finding.decide for finding in diagnosis.causes) else "",
        "not_testable": not_testable(diagnosis),
        "detectable": detectable(diagnosis),
        "detectable_said": DETECTABLE,
        "faults": [_fault(fault) for fault in diagnosis.faults],
        "unidentifiable": unidentifiable(diagnosis),
        "unidentifiable_said": UNIDENTIFIABLE,
        "geometry": [_geometry(parameter) for parameter in diagnosis.geometry],
        "residuals": {"residuals.csv": "Residuals"} if diagnosis.errors is not None else {},
        "worst": worst_poses(diagnosis),
        "worst_head": worst_head(diagnosis),
        "worst_said": worst_said(diagnosis),
        "geometry_said": GEOMETRY.format(
            rows=len(diagnosis.geometry), parameters=_independent(diagnosis), support=SUPPORT
        ),
        "facts": [[name, value] for name, value in facts(diagnosis)],
        "notes": list(diagnosis.notes),
        "given": [_given(fact) for fact in diagnosis.given],
        "support": SUPPORT,
        "version": diagnosis.version,
        "inputs": [[name, digest] for name, digest in diagnosis.inputs.items()],
    }


def gather(diagnosis: Diagnosis) -> Material:
    """Everything that the report shows, drawn once."""
    diagnosis = legible(diagnosis)
    drawn = [figures.stages(diagnosis), figures.histogram(diagnosis), figures.campaign(diagnosis)]
    drawn += [published()] if any(cause.cause != UNKNOWN for cause in diagnosis.causes) else []
    drawn += [figures.evidence(finding, number) for number, finding in enumerate(diagnosis.causes)]
    return Material(
        content(diagnosis),
        {figure.name: figure for figure in drawn if figure is not None},
        typeset([finding.equation for finding in diagnosis.causes]),
    )


def _verdict(diagnosis: Diagnosis) -> dict[str, str]:
    """The headline is the first sentence; what more there is comes below it."""
    headline, _, more = diagnosis.headline.partition(". ")
    more = IN_TILES.sub("", more).strip()
    return {
        "kind": "ambiguous" if diagnosis.too_few else diagnosis.verdict,
        "label": _label(diagnosis),
        "headline": headline.removesuffix("."),
        "more": more,
    }


def _label(diagnosis: Diagnosis) -> str:
    if diagnosis.too_few:
        return "Too few poses"
    if diagnosis.verdict == "named" and len(diagnosis.causes) > 1:
        return "Causes found"
    if diagnosis.verdict == "nothing_missing" and any(fact.differs for fact in diagnosis.given):
        return "Given and confirmed"
    if diagnosis.verdict == "nothing_missing" and any(fault.kind in STEPS for fault in diagnosis.faults):
        return "Nothing else is missing"
    return VERDICTS[diagnosis.verdict]


def _no_cause(diagnosis: Diagnosis) -> str:
    """What stands in place of causes where there are none."""
    if diagnosis.too_few:
        return "None can be told by so few poses."
    confirmed = [fact.differs for fact in diagnosis.given if fact.differs]
    if not confirmed:
        return "None is needed."
    return f"None is needed beyond what was given and what the data confirm: {'; '.join(confirmed)}."


def _summary(diagnosis: Diagnosis) -> str:
    """The verdict's paragraph: what the model misses, what each step brings, what is left."""
    first, last = diagnosis.stages[0], diagnosis.stages[-1]
    known = [finding for finding in diagnosis.causes if finding.cause != "unknown"]
    said = [f"As it is, the model misses the measured points by {mm(first.heldout_mean_mm)} mm on average."]
    if len(diagnosis.stages) > 1:
        said.append(f"Calibrating its geometry brings that to {mm(diagnosis.stages[1].heldout_mean_mm)} mm.")
    if (given := diagnosis.with_given) is not None:
        said.append(f"With what was given in it as well, {mm(given.heldout_mean_mm)} mm are left.")
    if known and len(diagnosis.stages) > 2:
        which = "cause" if len(known) == 1 else "causes"
        number = COUNT[len(known)] if len(known) < len(COUNT) else f"the {len(known)}"
        besides = " and what has no name" if last.name.endswith(NAMELESS) else ""
        said.append(f"With {number} {which} below{besides} in it, {mm(last.heldout_mean_mm)} mm are left.")
    if diagnosis.noise.source != "residual":
        alone = mm(maxwell.mean(scale=diagnosis.noise.alone_mm))
        said.append(f"Noise alone would make {alone} mm.")
    return " ".join(said)


def next_step(diagnosis: Diagnosis) -> tuple[str, str]:
    """What to do next, in a sentence, and the command for it where there is one: what the model lacks, what
    would decide the largest open cause, or what to record."""
    for finding in diagnosis.causes:
        if finding.cause == UNKNOWN and finding.separate_by:
            return f"What has no name may get one: {finding.separate_by}.", ""
    for finding in sorted(diagnosis.causes, key=lambda finding: -finding.gain_mm):
        offered = [one.words for one in to_decide(finding)][:1] or [finding.separate_by or ""]
        if offered[0]:
            what = words_of(finding.cause, finding.where, finding.called)
            return f"To decide {what}: {offered[0]} (under Causes).", ""
    if any(finding.cause == UNKNOWN for finding in diagnosis.causes):
        whys = [item.why for item in diagnosis.not_testable if item.why.startswith("no column")]
        steps = ["repeat ten poses five times", *dict.fromkeys(why.partition(": ")[2] for why in whys)]
        return f"What has no name may get one in a campaign with more in it: {listed(steps)}.", ""
    if diagnosis.too_few:
        return "Measure more poses:", "workbench plan CAMPAIGN.toml"
    if diagnosis.verdict in ("named", "nothing_missing") and not diagnosis.proof:
        return "Correct programs with this model:", "workbench compensate PATH.csv --model model.toml"
    return "", ""


def _remainder(diagnosis: Diagnosis) -> str:
    """What all smooth terms together could still gain, and whether what is left looks like noise."""
    last, best = diagnosis.stages[-1].heldout_rms_mm, diagnosis.ceiling_mm
    return (
        f"All smooth terms tried (of joints, loads, time, place) reach {mm(best)} mm RMS on held-out poses, "
        f"this model {mm(last)} mm. {_left(diagnosis)}"
    )


def _left(diagnosis: Diagnosis) -> str:
    chi2, dof, p = diagnosis.remainder_chi2, diagnosis.remainder_dof, diagnosis.remainder_p
    if diagnosis.noise.source == "residual":
        return (
            "The noise was taken from the residual itself, so whether something is left in it "
            "cannot be judged; state the instrument's noise or repeat some poses."
        )
    if not (math.isfinite(chi2) and math.isfinite(dof) and dof > 0):
        return "What is left was not tested."
    figure = f"χ² = {decimals(chi2, 0)} at {decimals(dof, 0)} degrees of freedom, {p_value(p)}"
    if p < 0.001:
        return f"More is left than the noise explains ({figure})."
    return f"What is left cannot be told from noise ({figure})."


def _tiles(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """The big figures: nominal model, calibrated geometry, all causes; held-out."""
    first, last = diagnosis.stages[0], diagnosis.stages[-1]
    middle = diagnosis.stages[1] if len(diagnosis.stages) > 2 else None
    tiles = []
    for label, key in (("Mean error", "mean"), ("RMS error", "rms"), ("Largest error", "max")):
        values = [getattr(stage, f"heldout_{key}_mm") for stage in (first, last)]
        between = f"{mm(getattr(middle, f'heldout_{key}_mm'))} mm with geometry alone" if middle else ""
        before, after = map(mm, values)
        tiles.append({"label": label, "before": before, "after": after, "unit": "mm", "note": between})
    return tiles


def _test(diagnosis: Diagnosis) -> str:
    test = diagnosis.test
    if test is None:
        return ""
    return (
        f"On the test campaign “{test.campaign}” ({test.n_points} points, nothing fitted on it) the mean "
        f"error {mm_change(test.before_mean_mm, test.after_mean_mm)}, the largest "
        f"{mm_change(test.before_max_mm, test.after_max_mm)}; RMS {mm(test.after_rms_mm)} mm."
        + "".join(f" {note}" for note in test.notes)
    )


def _stages(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    names = figures.stage_names(diagnosis)
    return [
        {
            "name": name,
            "full": stage.name,
            "parameters": str(stage.parameters),
            "numbers": [mm(stage.heldout_mean_mm), mm(stage.heldout_rms_mm), mm(stage.heldout_max_mm),
                        mm(stage.fit_rms_mm)],
            "note": stage.note,
        }
        for name, stage in zip(names, diagnosis.stages, strict=True)
    ]  # fmt: skip


def _bounds(diagnosis: Diagnosis) -> str:
    """What correction leaves, in words; nothing where that is not known."""
    if diagnosis.bounds_mm is None:
        return ""
    near, far = map(bound, diagnosis.bounds_mm)
    left = f"What correction leaves, 95 %: {near} mm at half of the measured poses"
    if far == NOT_KNOWN:
        return f"{left}. Of most of the joints' range these poses say nothing."
    return f"{left}, {far} mm at half of those all over the joints' range."


def _cause(finding: Finding, number: int) -> Content:
    unknown = finding.cause == UNKNOWN
    return {
        "title": finding.title or words(finding.cause),
        "id": finding.cause,
        "where": place_of(finding),
        "status": status(finding),
        "status_label": status(finding).capitalize(),
        "sentence": finding.sentence,
        "structure": "" if (finding.structure or "") in finding.sentence else _sentence(finding.structure),
        "equation": finding.equation,
        "gain": "" if unknown and finding.gain_mm <= 0 else f"{mm(finding.gain_mm)} mm",
        "p": f"probability {probability(finding.probability)}",
        "parameters": [_parameter(parameter) for parameter in finding.parameters],
        "rivals": _rivals(finding),
        "rivals_said": "May be" if unknown else "Fits as well",
        "separate_by": finding.separate_by or "",
        "decide": ways(finding),
        "figure": f"evidence{number}" if finding.evidence is not None and len(finding.evidence.x) else "",
    }


def status(finding: Finding) -> str:
    """How a finding stands, in a word."""
    return "unexplained" if finding.cause == UNKNOWN else finding.status


def _rivals(finding: Finding) -> list[str]:
    """One entry per cause, with its places: `lost motion (joint_1, joint_2)`."""
    places: dict[str, list[str]] = {}
    for rival in finding.rivals:
        said = OUTSIDE if rival.cause == "unknown" else rival.called or words(rival.cause)
        places.setdefault(said, []).append(place(rival.where))
    found = {cause: ", ".join(dict.fromkeys(filter(None, where))) for cause, where in places.items()}
    return [f"{cause} ({where})" if where else cause for cause, where in found.items()]


def _sentence(text: str | None) -> str:
    """With a capital and a full stop."""
    return "" if not text else text[:1].upper() + text[1:] + ("" if text[-1] in ".!?" else ".")


def _parameter(parameter: Parameter) -> dict[str, str]:
    shown = quantity(parameter)
    return {
        "name": words(parameter.name),
        "value": f"{shown} ({shown.also})" if shown.also else str(shown),
        "interval": shown.interval or MISSING,
        "meaning": parameter.meaning,
    }


def _independent(diagnosis: Diagnosis) -> int:
    """How many numbers the stage of geometry has beside frame and targets."""
    return diagnosis.stages[1].parameters if len(diagnosis.stages) > 1 else len(diagnosis.geometry)


def _geometry(parameter: Parameter) -> list[str]:
    shown = quantity(parameter)
    *joint, name = parameter.name.removeprefix("geometry/").split("/")
    return [" ".join(joint), name, str(shown), shown.interval or MISSING]


def _fault(fault: FaultFound) -> list[str]:
    pose = "" if fault.pose_id is None else f"pose {fault.pose_id}"
    where = ", ".join(part for part in (pose, fault.target) if part)
    return [words(fault.kind), where, fault.what, fault.done]


def _given(fact: GivenFact) -> list[str]:
    """As it was said, as the data alone have it, as both have it, and whether it was kept to."""
    where = place(fact.where)
    seen, fitted = (
        quantity(p).interval or str(quantity(p)) if p else MISSING for p in (fact.seen, fact.fitted)
    )
    if fact.exact and fact.fitted is not None:
        fitted = "as given"
    cause = f"{words(fact.cause)} ({where})" if where else words(fact.cause)
    note = f" ({fact.note})" if fact.note else ""
    return [
        cause,
        f"{fact.said}{note}",
        seen,
        fitted,
        "confirmed by the data"
        if fact.differs
        else "kept to"
        if fact.obeyed
        else "contradicted, not kept to",
    ]
