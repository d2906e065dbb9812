"""The verdict on a terminal: read in ten seconds."""

from __future__ import annotations

from pathlib import Path

from ..diagnosis.result import NAMELESS, Diagnosis
from ..effects.base import UNKNOWN
from .content import decision, place, to_decide


def short_verdict(diagnosis: Diagnosis, folder: Path | None) -> str:
    """A few lines: verdict, causes with gain, faults, and where the report lies (`folder`, if written)."""
    lines = [
        f"{diagnosis.robot_title}: {diagnosis.n_poses} poses, {diagnosis.n_points} points, "
        f"noise {diagnosis.noise.sigma_mm:.4f} mm per axis ({diagnosis.noise.source})",
        "",
        diagnosis.headline,
        "",
        f"  held-out error, mm RMS   {'   '.join(_steps(diagnosis))}",
    ]
    if diagnosis.test:
        t = diagnosis.test
        lines.append(
            f"  test campaign, mm mean   before {t.before_mean_mm:.4f}   after {t.after_mean_mm:.4f}"
            f"   (max {t.after_max_mm:.4f})"
        )
    for finding in diagnosis.causes:
        sentence = finding.sentence or finding.structure or ""
        where = place(finding.where)
        name = f"{finding.cause} ({where})" if where and finding.cause != UNKNOWN else finding.cause
        lines += ["", f"  {finding.status.upper():<10}{name}   gain {finding.gain_mm * 1e3:.1f} µm"]
        lines += [f"            {sentence}"] if sentence else []
        if finding.rivals:
            said = [(rival.cause, place(rival.where)) for rival in finding.rivals]
            rivals = ", ".join(f"{cause} ({at})" if at else cause for cause, at in said)
            word = "may be" if finding.cause == UNKNOWN else "fits as well"
            lines.append(f"            {word}: {rivals}")
        if finding.separate_by:
            lines.append(f"            to decide: {finding.separate_by}")
        for one in to_decide(finding):
            lines.append(f"            - {decision(one)}")
            lines += [f"              {one.command}"] if one.command else []
    lines += [f"  {fact.sentence}" for fact in diagnosis.given]
    for fault in diagnosis.faults[:10]:
        lines.append(f"  data fault: {fault.kind} at pose {fault.pose_id}: {fault.what} ({fault.done})")
    if len(diagnosis.faults) > 10:
        lines.append(f"  ... and {len(diagnosis.faults) - 10} more data faults")
    causes = sorted({item.cause for item in diagnosis.not_testable if not item.where.keys()})
    if causes:
        lines += ["", f"  not testable with these data: {', '.join(causes)}"]
    if folder is not None:
        lines += [
            "",
            f"  page: {folder}/index.html   report: {folder}/report.pdf   model: {folder}/model.toml",
        ]
    return "\n".join(lines)


def _steps(diagnosis: Diagnosis) -> list[str]:
    """Nominal, geometry, what was given, the causes and what has no name, as far as there is any."""
    nominal, geometry, *more = diagnosis.stages
    steps = [("nominal", nominal), ("geometry", geometry)]
    if (given := diagnosis.with_given) is not None:
        steps.append(("and what was given", given))
        more.remove(given)
    with_names = [stage for stage in more if not stage.name.endswith(NAMELESS)]
    steps += [("with causes", stage) for stage in with_names[-1:]]
    steps += [(f"with {NAMELESS}", stage) for stage in more if stage not in with_names]
    return [f"{name} {stage.heldout_rms_mm:.4f}" for name, stage in steps]
