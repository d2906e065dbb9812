"""The verdict on a terminal: read in ten seconds."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ..diagnosis.found import NAMELESS, FaultFound, Finding
from ..diagnosis.result import Diagnosis
from ..effects.base import UNKNOWN
from .content import next_step, place, place_of, status
from .dataset import SOURCES
from .deciding import LONG, decision, to_decide
from .numbers import bound, mm

FAULTS = 10  # lines of faults; the rest is counted
POSES = 12  # by their ids in a line
INDENT = " " * 14  # of what is said below a cause


def fault_lines(faults: Sequence[FaultFound], word: str) -> list[str]:
    """A line for what is said of several poses alike, or of none of their targets, and for each other pose
    with all its targets; beyond some, how many more."""
    said = Counter((fault.kind, fault.what) for fault in faults)
    together: dict[tuple[str | None, ...], list[FaultFound]] = {}
    for fault in faults:
        alike = said[fault.kind, fault.what] > 1 or fault.pose_id is None or fault.target is None
        key = (fault.what,) if alike else (None, fault.pose_id)
        together.setdefault((fault.kind, fault.done, *key), []).append(fault)
    lines = [f"{word}: {_fault_line(group)}" for group in together.values()]
    more = len(lines) - FAULTS
    return lines if more <= 1 else [*lines[:FAULTS], f"... and {more} more lines like these"]


def _fault_line(group: list[FaultFound]) -> str:
    """What is wrong with the points of one pose, or with several poses alike."""
    first = group[0]
    names = list(dict.fromkeys(fault.target for fault in group if fault.target))
    poses = list(dict.fromkeys(fault.pose_id for fault in group if fault.pose_id is not None))
    where = f" at pose{'s' * (len(poses) > 1)} {_some(poses)}" if poses else ""
    where += f", {', '.join(names)}" if names else ""
    more = f" ({first.target})" if len({fault.what for fault in group}) > 1 else ""
    return f"{first.kind}{where}: {first.what}{more} ({first.done})"


def _some(poses: list[str]) -> str:
    return ", ".join(poses) if len(poses) <= POSES else f"{', '.join(poses[: POSES - 1])} … {poses[-1]}"


def short_verdict(diagnosis: Diagnosis, folder: Path | None) -> str:
    """A few lines: verdict, causes with gain, faults, and where the report lies (`folder`, if written)."""
    noise = diagnosis.noise
    shared = f", and {mm(noise.repeatability_mm)} mm of a pose" if noise.repeatability_mm else ""
    lines = [
        f"{diagnosis.robot_title}: {diagnosis.n_poses} poses, {diagnosis.n_points} points, "
        f"noise {mm(noise.sigma_mm)} mm per axis{shared} ({SOURCES[noise.source]})",
        *_far_too_much(diagnosis),
        *[f"model: {said}" for key, said in diagnosis.facts.items() if key == "Model"],
        "",
        diagnosis.headline,
        "",
        f"  held-out error, mm RMS   {'   '.join(_steps(diagnosis))}",
    ]
    if diagnosis.bounds_mm:
        near, far = map(bound, diagnosis.bounds_mm)
        lines.append(f"  corrected, 95 %, mm      where measured {near}   all over the joints' range {far}")
    if diagnosis.test:
        t = diagnosis.test
        lines.append(
            f"  test campaign, mm mean   before {mm(t.before_mean_mm)}   after {mm(t.after_mean_mm)}"
            f"   (max {mm(t.after_max_mm)})"
        )
        lines += [f"    {note}" for note in t.notes]
        lines += [f"    {line}" for line in fault_lines(t.faults, "data fault of the test")]
    lines += _each_campaign(diagnosis)
    for finding in diagnosis.causes:
        sentence = finding.sentence or finding.structure or ""
        where = place_of(finding)
        name = f"{finding.cause} ({where})" if where else finding.cause
        name = "structure" if finding.cause == UNKNOWN else name
        gain = f"   gain {finding.gain_mm * 1e3:.1f} µm" if finding.gain_mm > 0 else ""
        lines += ["", f"  {status(finding).upper():<11} {name}{gain}"]
        lines += [f"{INDENT}{sentence}"] if sentence else []
        if known := [rival for rival in finding.rivals if rival.cause != UNKNOWN]:  # its sentence says others
            said = [(rival.cause, place(rival.where)) for rival in known]
            rivals = ", ".join(f"{cause} ({at})" if at else cause for cause, at in said)
            word = "may be" if finding.cause == UNKNOWN else "fits as well"
            lines.append(f"{INDENT}{word}: {rivals}")
        if finding.separate_by or finding.decide:
            lines.append(f"{INDENT}to decide: {finding.separate_by or ''}".rstrip())
        lines += _ways(finding, diagnosis, folder)
    lines += [f"  {fact.sentence}" for fact in diagnosis.given]
    lines += [f"  {line}" for line in fault_lines(diagnosis.faults, "data fault")]
    causes = sorted({item.cause for item in diagnosis.not_testable if not item.where.keys()})
    if causes:
        lines += ["", f"  not testable with these data: {', '.join(causes)}"]
    if folder is not None:
        step, command = next_step(diagnosis)
        command = command.replace("model.toml", shlex.quote(f"{folder}/model.toml"))
        lines += [
            *(["", f"  next: {step} {command}"] if command else []),
            "",
            f"  page: {folder}/index.html   report: {folder}/report.pdf   model: {folder}/model.toml",
        ]
    return "\n".join(lines)


def _ways(finding: Finding, diagnosis: Diagnosis, folder: Path | None) -> list[str]:
    """What would decide, with the first command; where the others are."""
    lines, others = [], 0
    for one in to_decide(finding):
        lines.append(f"{INDENT}- {decision(one)}")
        if one.command and (one is finding.ready or folder is None):
            lines.append(f"{INDENT}  {_by_result(one.command, diagnosis, folder)}")
        else:
            others += bool(one.command)
    if others:
        more = "the command of the other" if others == 1 else f"the commands of {others} others"
        lines.append(f"{INDENT}  ({more}: on the page, and in {folder}/result.json)")
    return lines


def _by_result(command: str, diagnosis: Diagnosis, folder: Path | None) -> str:
    """A command; one that says many numbers takes them from the result instead, and all that is open."""
    parts = shlex.split(command)
    if len(command) <= LONG or folder is None or "--tell" not in parts:
        return command
    parts[parts.index("--tell") + 1] = f"{folder}/result.json"
    if sum(one.status == "ambiguous" and one.cause != UNKNOWN for one in diagnosis.causes) > 1:
        at = parts.index("--poses")
        del parts[at : at + 2]
    return shlex.join(parts)


def _far_too_much(diagnosis: Diagnosis) -> list[str]:
    """That far more noise was stated than there is."""
    noise = diagnosis.noise
    if noise.left_mm is None:
        return []
    return [
        f"  the fit leaves {mm(noise.left_mm)} mm per axis, far less than that noise: is it in mm? Nothing "
        "smaller is looked for. State",
        "  the instrument's own noise, or take it out of the campaign",
    ]


def _each_campaign(diagnosis: Diagnosis) -> list[str]:
    """A line for each of several campaigns."""
    wide = max((len(one.label) for one in diagnosis.campaigns), default=0)
    return [
        f"  {one.label:<{wide}}  {one.n_poses} poses   noise {mm(one.noise_mm)}   fitted, mm RMS "
        f"{diagnosis.start.removesuffix(' model')} {mm(one.nominal_mm)}   geometry {mm(one.geometry_mm)}   "
        f"in the end {mm(one.after_mm)}{'   the model is of this one' * one.of_model}"
        for one in diagnosis.campaigns
    ]


def _steps(diagnosis: Diagnosis) -> list[str]:
    """Nominal, geometry, what was given, the causes and what has no name, as far as there is any."""
    nominal, geometry, *more = diagnosis.stages
    steps = [(diagnosis.start.removesuffix(" model"), nominal), ("geometry", geometry)]
    if (given := diagnosis.with_given) is not None:
        steps.append(("and what was given", given))
        more.remove(given)
    with_names = [stage for stage in more if not stage.name.endswith(NAMELESS)]
    steps += [("with causes", stage) for stage in with_names[-1:]]
    steps += [(f"with {NAMELESS}", stage) for stage in more if stage not in with_names]
    return [f"{name} {mm(stage.heldout_rms_mm)}" for name, stage in steps]
