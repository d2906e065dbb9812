"""Figures of a diagnosis as SVG text, the same bytes for the same diagnosis.

Each figure carries the sentence that it shows; page and PDF print it above the picture, where it
wraps.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import maxwell

from ..diagnosis.found import Evidence, Finding, PoseErrors
from ..diagnosis.result import Diagnosis
from .drawing import (
    AFTER,
    BEFORE,
    INK,
    MIDDLE,
    MODEL,
    MUTED,
    NOISE,
    Array,
    Figure,
    cloud,
    dots,
    drawing,
    plain_log,
    ticks,
)
from .numbers import Scale, axis_scale, change, mm, mm_change, significant, words

SELDOM = 3.4  # σ per axis: the 3-D length that noise alone exceeds in a point of a hundred
ZERO_SHOWN = 1e-5  # mm: what a logarithmic axis shows for zero


def stages(diagnosis: Diagnosis) -> Figure:
    """Held-out error per stage: mean to maximum as a line, RMS as a dot, the noise as a band."""
    shown = diagnosis.stages
    names = stage_names(diagnosis)
    first, last = shown[0], shown[-1]
    floor = float(np.sqrt(3)) * diagnosis.noise.alone_mm
    alone = "" if diagnosis.noise.source == "residual" else f"; the noise alone makes {mm(floor)} mm"
    with drawing("stages", 0.75 + 0.36 * len(shown)) as (axes, svg):
        for row, stage in enumerate(shown):
            colour = BEFORE if row == 0 else AFTER if row == len(shown) - 1 else MIDDLE
            rms = max(stage.heldout_rms_mm, ZERO_SHOWN)
            ends = [max(stage.heldout_mean_mm, ZERO_SHOWN), max(stage.heldout_max_mm, ZERO_SHOWN)]
            axes.plot(ends, [row, row], color=colour, lw=2, alpha=0.45, solid_capstyle="round")
            axes.plot(ends[1:], [row], "|", color=colour, ms=9, mew=2)
            axes.plot([rms], [row], "o", color=colour, ms=7)
            number = {"va": "center", "fontweight": "bold", "color": colour}
            beside = ("axes fraction", "data")
            axes.annotate(mm(stage.heldout_rms_mm), (1.0, row), (6, 0), beside, "offset points", **number)
        axes.set(xscale="log", yticks=range(len(shown)), ylim=(len(shown) - 0.4, -0.6))
        axes.set_yticklabels(names, color=INK)
        axes.grid(axis="y", visible=False)
        _noise_floor(axes, floor, "noise alone" if alone else "noise, from the residual")
        plain_log(axes.xaxis)
        axes.annotate("RMS, mm", (1.0, 1.0), (6, 3), "axes fraction", "offset points", color=MUTED)
        axes.set_xlabel("3-D error on held-out poses, mm: mean, RMS (dot), largest (bar)")
    return Figure(
        "stages",
        "On poses that were not fitted, the RMS error "
        f"{mm_change(first.heldout_rms_mm, last.heldout_rms_mm)}{alone}",
        "Held-out RMS error per stage: "
        + "; ".join(f"{n} {mm(s.heldout_rms_mm)} mm" for n, s in zip(names, shown, strict=True)),
        svg[0],
    )


def stage_names(diagnosis: Diagnosis) -> list[str]:
    """Each stage by what it adds to the one before: `+ gear kinematic error (joint_4)`."""
    names, before = [], ""
    for stage in diagnosis.stages:
        added = stage.name.removeprefix(f"{before} + ") if before else stage.name
        if added == stage.name:
            names.append(stage.name if before else diagnosis.start.removesuffix(" model"))
        else:
            cause, bracket, where = added.partition("(")
            names.append(f"+ {words(cause)}" + (f" ({where}" if bracket else ""))
        before = stage.name
    return names


def histogram(diagnosis: Diagnosis) -> Figure | None:
    """How the 3-D errors are spread before and after, against what the noise alone would do."""
    if diagnosis.errors is None:
        return None
    before, label = before_of(diagnosis, diagnosis.errors)
    after = norm_mm(diagnosis.errors.error_final)
    sigma = diagnosis.noise.alone_mm
    top = max(float(np.quantile(before, 0.995)), 5 * sigma)
    wide = top > 15 * np.median(after)
    low = max(min(float(np.quantile(after, 0.005)), 0.4 * sigma), 1e-6)
    edges = np.geomspace(low, top, 45) if wide else np.linspace(0, top, 45)
    with drawing("histogram", 2.5) as (axes, svg):
        for errors, colour, name in ((before, BEFORE, label), (after, AFTER, "after")):
            share = 100 * np.histogram(errors, edges)[0] / max(len(errors), 1)
            axes.stairs(share, edges, fill=True, alpha=0.35, color=colour)
            axes.stairs(share, edges, color=colour, lw=1.4, label=name)
        middle = (edges[1:] + edges[:-1]) / 2
        axes.plot(middle, 100 * maxwell.pdf(middle, scale=sigma) * np.diff(edges), "--", color=NOISE, lw=1.6,
                  label=f"noise alone, σ = {mm(sigma)} mm per axis")  # fmt: skip
        if wide:
            axes.set_xscale("log")
            plain_log(axes.xaxis)
        else:
            axes.set_xlim(0, top)
        axes.set(xlabel="3-D error, mm", ylabel="% of points", ylim=(0, None))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return Figure(
        "histogram",
        f"Median error {mm(float(np.median(after)))} mm, {mm(float(np.median(before)))} mm {label}; "
        f"noise of this size alone would give {mm(maxwell.median(scale=sigma))} mm",
        "Histogram of the 3-D errors before and after, with the curve of the noise alone",
        svg[0],
    )


def campaign(diagnosis: Diagnosis) -> Figure | None:
    """Error of every pose in the order of the campaign: drifts, steps and outliers show here."""
    if diagnosis.errors is None:
        return None
    errors = diagnosis.errors
    before, label = before_of(diagnosis, errors)
    after = norm_mm(errors.error_final)
    poses, at = np.unique(errors.pose, return_inverse=True)
    worst_before, worst_after = (np.full(len(poses), ZERO_SHOWN) for _ in range(2))
    np.maximum.at(worst_before, at, before)
    np.maximum.at(worst_after, at, after)
    odd = _odd(diagnosis, worst_after)
    with drawing("campaign", 2.6) as (axes, svg):
        ticks(axes, poses + 1.0, worst_before, BEFORE, label)
        dots(axes, poses + 1.0, worst_after, AFTER, "after")
        axes.set_yscale("log")
        plain_log(axes.yaxis)
        axes.axhline(
            SELDOM * diagnosis.noise.alone_mm, color=NOISE, ls="--", lw=1.2, label="noise alone: seldom more"
        )
        if len(odd):
            ring = {"ms": 10, "mfc": "none", "mec": INK, "mew": 1.2}
            axes.plot(poses[odd] + 1, worst_after[odd], "o", **ring, label="data fault")
        axes.set(xlabel="pose, in the order of the campaign", ylabel="worst point of the pose, mm")
        axes.set_xlim(0, poses.max() + 2)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    share = np.mean(worst_after < worst_before)
    said = mm_change(float(np.median(worst_before)), float(np.median(worst_after)))
    return Figure(
        "campaign",
        f"{100 * share:.0f} % of the poses come out better; the median pose's worst point {said}",
        "Worst error of every pose in the order of the campaign, before and after; dashed: the largest "
        "that noise alone would give in most poses",
        svg[0],
    )


def evidence(finding: Finding, number: int) -> Figure | None:
    """The residual against the variable that shows the cause: before with the curve, and after."""
    seen = finding.evidence
    if seen is None or len(seen.x) == 0:
        return None
    name = f"evidence{number}"
    x_scale = axis_scale(np.concatenate([seen.x, seen.curve_x]).tolist(), seen.x_unit)
    y_scale = axis_scale(np.concatenate([seen.before, seen.curve_y]).tolist(), seen.y_unit)
    panels = [(seen.before, BEFORE, "without this cause in the model"), (seen.after, AFTER, "with it")]
    if finding.cause == "unknown":
        panels = [(seen.before, BEFORE, "what is left")]
    with drawing(name, 2.55, len(panels), sharex=True, sharey=True, squeeze=False) as (grid, svg):
        axes = grid[0]
        for panel, (y, colour, title) in zip(axes, panels, strict=True):
            cloud(panel, seen.x * x_scale.factor, y * y_scale.factor, colour)
            panel.set_title(title, loc="left", fontsize=8.5, color=colour, fontweight="bold")
            panel.set_xlabel(_axis_label(seen.x_name, x_scale))
        axes[0].plot(seen.curve_x * x_scale.factor, seen.curve_y * y_scale.factor, color=MODEL, lw=1.8)
        axes[-1].axhline(0, color=MODEL, lw=1)
        axes[0].set_ylabel(_axis_label(seen.y_name, y_scale))
        axes[0].set_ylim(*(y_scale.factor * _range(seen)))
    alt = f"{seen.y_name} against {seen.x_name}: " + ", ".join(title for *_, title in panels)
    return Figure(name, _evidence_title(finding.cause, seen, y_scale), alt, svg[0])


def _range(seen: Evidence) -> Array:
    """Lowest and highest value to show: nearly all points, the whole curve, and zero."""
    low, high = np.nanquantile(np.concatenate([seen.before, seen.after]), (0.002, 0.998))
    low, high = min(low, np.min(seen.curve_y, initial=0.0)), max(high, np.max(seen.curve_y, initial=0.0))
    room = 0.08 * (high - low) or 1e-9
    return np.array([low - room, high + room])


def _evidence_title(cause: str, seen: Evidence, scale: Scale) -> str:
    """In the unit of the axis below it."""
    before, after = (float(np.sqrt(np.nanmean(y**2))) for y in (seen.before, seen.after))
    first = significant(before * scale.factor)
    if cause == "unknown":
        return f"What is left has an RMS of {first} {scale.unit} and goes with {seen.x_name}"
    said = change(first, significant(after * scale.factor), scale.unit, falls=after < before)
    return f"With this cause in the model, the RMS of {seen.y_name} {said}"


def _noise_floor(axes: Any, floor: float, label: str) -> None:
    if not floor > 0:
        return
    axes.axvline(floor, color=NOISE, ls="--", lw=1.3)
    axes.annotate(label, (floor, 1), (0, 3), xycoords=("data", "axes fraction"), color=NOISE,
                  textcoords="offset points", ha="center")  # fmt: skip


def before_of(diagnosis: Diagnosis, errors: PoseErrors) -> tuple[Array, str]:
    """What "before" means: the calibrated geometry when causes were found, else what it began with."""
    if len(diagnosis.stages) > 2:
        return norm_mm(errors.error_geometry), "with geometry alone"
    return norm_mm(errors.error_nominal), f"with the {diagnosis.start}"


def _odd(diagnosis: Diagnosis, worst: Array) -> NDArray[np.int64]:
    """Poses to mark: as many as have outliers among the faults, where noise cannot explain them."""
    poses = {fault.pose_id for fault in diagnosis.faults if fault.pose_id is not None}
    largest = np.argsort(-worst, kind="stable")[: len(poses)]
    return np.asarray(largest[worst[largest] > 6 * diagnosis.noise.alone_mm], dtype=np.int64)


def norm_mm(errors: Array) -> Array:
    return np.asarray(1e3 * np.linalg.norm(errors, axis=1))


def _axis_label(name: str, scale: Scale) -> str:
    return f"{name}, {scale.unit}" if scale.unit else name
