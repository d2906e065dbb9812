"""Figures of a verification: error along the path, R_a and R_z, spectrum of what is left."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from ...report.drawing import AFTER, BEFORE, MIDDLE, MUTED, NOISE, Figure, drawing, plain_log
from ...report.numbers import mm, mm_change, significant
from ...robot.kinematics import Array
from .measures import spectrum
from .repeatability import Repeatability
from .verification import COMMAND_NAMES, Series, Sweep, Verification, speed_text, sweep_said

LED, LAGGED = "#7a4fa3", "#2f7f86"
COMMAND_COLOURS = {
    "uncorrected": BEFORE,
    "geometry": MIDDLE,
    "corrected": AFTER,
    "elastic": LED,
    "loop": LAGGED,
    "perfect": NOISE,
}
PATH_POINTS = 1000  # of a curve, at most
LEAST_SHOWN = 1e-4  # mm, of a logarithmic axis


def pictures(found: Verification) -> list[Figure]:
    """All figures, in the page's order."""
    return [
        *(_along(series, number, found.repeatability) for number, series in enumerate(found.series)),
        _heights(found),
        _spectra(found.series[-1]),
    ]


def _along(series: Series, number: int, repeatability: Repeatability) -> Figure:
    """Error of each command over time, logarithmic."""
    before, after = (series.trials[name].figures for name in ("uncorrected", "corrected"))
    with drawing(f"along{number}", 3.0) as (axes, svg):
        for name, trial in series.trials.items():
            size = np.maximum(1e3 * np.linalg.norm(trial.error, axis=1), LEAST_SHOWN)
            t, size = _thinned(series.time, size)
            style = "--" if name == "perfect" else "-"
            axes.plot(t, size, style, color=COMMAND_COLOURS[name], lw=1.4, label=COMMAND_NAMES[name])
        axes.set_yscale("log")
        plain_log(axes.yaxis)
        axes.set(xlabel="time along the path, s", ylabel="3-D error of the tool, mm")
        shown = _beside(axes, repeatability)
        low = min(*shown, *(trial.figures.mean_mm for trial in series.trials.values()))
        axes.set_ylim(bottom=max(LEAST_SHOWN, 0.2 * low))
        axes.set_xlim(0, series.time[-1])
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return Figure(
        f"along{number}",
        f"At {speed_text(series.speed)} the RMS error {mm_change(before.rms_mm, after.rms_mm)}, "
        f"the largest {mm_change(before.max_mm, after.max_mm)}{_led(series)}",
        f"Error of the tool along the path at {speed_text(series.speed)}, for each command",
        svg[0],
    )


def _led(series: Series) -> str:
    """What drives that lead leave, where that shows."""
    reached, best = (mm(series.trials[name].figures.rms_mm) for name in ("corrected", series.best))
    if best == reached:
        return ""
    what = "elastic feed-forward" if series.best == "elastic" else "predicted servo lag"
    return f"; with {what} {best} mm RMS are left"


def _heights(found: Verification) -> Figure:
    """R_a and R_z per command at the slowest speed, as Olabi et al. (2012) tabulate them."""
    trials = found.slow.trials
    names = [name for name in COMMAND_NAMES if name in trials]
    with drawing("heights", 0.9 + 0.34 * len(names)) as (axes, svg):
        for row, name in enumerate(names):
            f = trials[name].figures
            axes.plot([f.ra_mm, f.rz_mm], [row, row], color=COMMAND_COLOURS[name], lw=2, alpha=0.45)
            axes.plot(f.ra_mm, row, "o", color=COMMAND_COLOURS[name], ms=7)
            axes.plot(f.rz_mm, row, "|", color=COMMAND_COLOURS[name], ms=10, mew=2)
            said = f"{mm(f.ra_mm)}  /  {mm(f.rz_mm)}"
            place = {"va": "center", "fontweight": "bold", "color": COMMAND_COLOURS[name]}
            axes.annotate(said, (1.0, row), (6, 0), ("axes fraction", "data"), "offset points", **place)
        axes.set(yticks=range(len(names)), ylim=(len(names) - 0.5, -0.6), xscale="log")
        axes.set_yticklabels([COMMAND_NAMES[name] for name in names])
        axes.grid(axis="y", visible=False)
        plain_log(axes.xaxis)
        axes.set_xlabel("error normal to the path's plane, mm: Ra (dot), Rz (bar)")
    first, last = (trials[name].figures for name in ("uncorrected", "corrected"))
    return Figure(
        "heights",
        f"Ra {mm_change(first.ra_mm, last.ra_mm)}, Rz {mm_change(first.rz_mm, last.rz_mm)}",
        "Ra and Rz of each command at the slowest speed",
        svg[0],
    )


def _spectra(series: Series) -> Figure:
    """Spectrum of the error across the path, before and after."""
    with drawing("spectrum", 2.5) as (axes, svg):
        top = 0.0
        for name in ("uncorrected", "corrected"):
            f, amplitude = spectrum(series.time, series.trials[name].across)
            used = (f > 0) & (f < max(100.0, 1.5 * f[1]))  # its lowest line at least, however short the path
            axes.plot(
                *_thinned(f[used], np.maximum(1e3 * amplitude[used], 1e-3)),
                color=COMMAND_COLOURS[name],
                lw=1.2,
                label=COMMAND_NAMES[name],
            )
            top = max(top, float(amplitude[used].max()))
        axes.set(xscale="log", yscale="log", xlabel="frequency, Hz", ylabel="error across the path, µm")
        axes.set_ylim(max(1e-2, top), 2e3 * top)
        for axis in (axes.xaxis, axes.yaxis):
            plain_log(axis)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    lines = series.trials["corrected"].lines
    said = "nothing stands out of what is left"
    if lines:
        named = f", {lines[0].cause}" if lines[0].cause else ""
        said = (
            f"the highest peak left is {significant(1e3 * lines[0].amplitude_mm, 2)} µm at "
            f"{significant(lines[0].frequency_hz, 2)} Hz"
        )
        said += named
    return Figure(
        "spectrum",
        f"At {speed_text(series.speed)} {said}",
        "Spectrum of the error across the path, before and after",
        svg[0],
    )


def sweep_picture(sweep: Sweep, repeatability: Repeatability) -> Figure:
    """RMS error by tool speed of each command, and of a rigid arm under the same controller."""
    lines = (
        ("uncorrected", "Uncorrected", BEFORE, "o-"),
        ("corrected", "Static correction", AFTER, "o-"),
        ("elastic", "… and elastic feed-forward", LED, "o-"),
        ("rigid", "An arm that does not yield", NOISE, "o--"),
    )
    with drawing("sweep", 3.2) as (axes, svg):
        for name, label, colour, style in lines:
            axes.plot(sweep.speeds, sweep.rms_mm[name], style, color=colour, lw=1.6, ms=4, label=label)
        _beside(axes, repeatability)
        axes.set(xscale="log", yscale="log", xlabel="speed of the tool, m/s", ylabel="RMS error, mm")
        for axis in (axes.xaxis, axes.yaxis):
            plain_log(axis)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    said = sweep_said(sweep)
    return Figure("sweep", said[0].upper() + said[1:], "RMS error of the tool by its speed", svg[0])


def _beside(axes: Any, repeatability: Repeatability) -> list[float]:
    """Lines at the repeatability of data sheet and joints, named in the legend; their heights [mm]."""
    lines = (
        ("Repeatability by data sheet", repeatability.data_sheet_mm, "--"),
        ("Repeatability of the joints", repeatability.joints_mm, ":"),
    )
    heights = []
    for label, height, style in lines:
        if height is not None:
            axes.axhline(height, color=MUTED, lw=1.2, ls=style, label=label)
            heights.append(height)
    return heights


def _thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """At most `PATH_POINTS` points of a curve, the largest of each stretch."""
    if len(x) <= PATH_POINTS:
        return x, y
    edges = np.linspace(0, len(x), PATH_POINTS + 1).astype(int)
    at = [a + int(np.argmax(y[a:b])) for a, b in pairwise(edges)]
    return x[at], y[at]
