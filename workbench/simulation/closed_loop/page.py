"""`verify.html`: what was found, on one page, in the look of the report."""

from __future__ import annotations

from importlib.metadata import version

from ...report.markup import render
from ...report.numbers import mm, significant
from ...report.study import Table, Tile
from .pictures import pictures, sweep_picture
from .repeatability import Repeatability
from .verification import (
    COMMAND_NAMES,
    Series,
    Verification,
    anew_said,
    perfect_said,
    speed_text,
    step_said,
    sweep_said,
)


def page(found: Verification) -> str:
    """The whole page as text."""
    *along, heights, spectrum = pictures(found)
    return render(
        "closed_loop.html",
        robot=found.robot.title,
        path=found.path.title,
        headline=headline(found),
        lead=_lead(found),
        tiles=[_tile(series, found.repeatability) for series in found.series],
        along=[
            (drawn, _numbers(series, found.repeatability))
            for drawn, series in zip(along, found.series, strict=True)
        ],
        heights=heights,
        roughness=_roughness(found),
        repeats=_repeats(found),
        spectrum=spectrum,
        sweep=None if found.sweep is None else sweep_picture(found.sweep, found.repeatability),
        left=_left(found),
        facts=_facts(found),
        notes=found.notes,
        inputs=found.inputs.items(),
        version=version("robot-workbench"),
    )


def headline(found: Verification) -> str:
    """What came out, in one sentence; first of all what it stands for, where the truth is the model."""
    if found.same:
        return found.caveat
    trials = found.slow.trials
    before, after = trials["uncorrected"].figures.rms_mm, trials["corrected"].figures.rms_mm
    if mm(before) == mm(after):
        return f"The correction changes nothing here: the error stays at {mm(after)} mm RMS"
    if after < before:
        return f"The correction takes the error from {mm(before)} to {mm(after)} mm RMS"
    return f"The correction makes this path worse: from {mm(before)} to {mm(after)} mm RMS"


def _lead(found: Verification) -> list[str]:
    said = [
        "The simulated robot ran the path in closed loop: sampled controller, drives, gears, springs, "
        f"friction and loads, {found.judged}. Commands were corrected by what the model knows.",
        f"Beside every residual stands the {found.repeatability.said}.",
    ]
    return [*said, *(f"{more}." for more in (anew_said(found), perfect_said(found.slow)) if more)]


def _tile(series: Series, repeatability: Repeatability) -> Tile:
    before, after = (series.trials[name].figures for name in ("uncorrected", "corrected"))
    label, was, now = f"RMS error at {speed_text(series.speed)}", mm(before.rms_mm), mm(after.rms_mm)
    if was == now:
        label, was = f"{label}, before and after", ""
    first, last = mm(before.max_mm), mm(after.max_mm)
    largest = f"{last} mm, before and after" if first == last else f"{first} → {last} mm"
    return Tile(label, was, now, "mm", f"largest {largest}; {repeatability.short}")


def _numbers(series: Series, repeatability: Repeatability) -> Table:
    rows = []
    for name, trial in series.trials.items():
        f = trial.figures
        values = (f.mean_mm, f.rms_mm, f.p95_mm, f.max_mm, f.across_max_mm)
        rows.append([COMMAND_NAMES[name], *(mm(value) for value in values)])
    return Table(
        f"At {speed_text(series.speed)}, {series.time[-1]:.3g} s. Distance of the tool from where it should "
        f"be at that instant; across: from the path, whenever it passes; {repeatability.short}.",
        ("Command", "Mean, mm", "RMS, mm", "95 %, mm", "Largest, mm", "Largest across, mm"),
        rows,
    )


def _roughness(found: Verification) -> Table:
    n = ", ".join(f"{x:.2f}" for x in found.normal + 0.0)
    return Table(
        f"Error along the normal ({n}) of the path's plane, unfiltered, along the whole path (Pa and Pz of "
        "ISO 4287): Ra the mean size about its mean line, Rz highest peak minus deepest valley. A constant "
        "height is no roughness: it stands by itself.",
        ("Speed", "Command", "Ra, mm", "Rz, mm", "Height, mm"),
        [
            [
                speed_text(series.speed),
                COMMAND_NAMES[name],
                mm(trial.figures.ra_mm),
                mm(trial.figures.rz_mm),
                mm(trial.figures.offset_mm),
            ]
            for series in found.series
            for name, trial in series.trials.items()
        ],
        numbers=(2, 3, 4),
    )


def _repeats(found: Verification) -> Table:
    return Table(
        "ISO 9283 path accuracy AT (largest distance of the runs' mean from the path) and repeatability RT "
        "(largest mean plus three standard deviations about that mean); beside them, "
        f"{found.repeatability.said}.",
        ("Command", "Runs", "Speed", "AT, mm", "RT, mm"),
        [
            [
                COMMAND_NAMES[r.name],
                str(r.count),
                speed_text(r.speed),
                mm(r.at_mm),
                "not known" if r.rt_mm is None else mm(r.rt_mm),
            ]
            for r in found.repeats
        ],
    )


def _left(found: Verification) -> Table:
    return Table(
        "The highest peaks in the spectrum of the corrected path's error, above 3.5 cycles along it.",
        ("Speed", "Frequency, Hz", "Amplitude, µm", "Runs with the gear of"),
        [
            [
                speed_text(series.speed),
                significant(line.frequency_hz, 3),
                significant(1e3 * line.amplitude_mm, 2),
                line.cause or "none known",
            ]
            for series in found.series
            for line in series.trials["corrected"].lines
        ],
        numbers=(1, 2),
    )


def _facts(found: Verification) -> list[tuple[str, str]]:
    servo = 1e6 * abs(found.slow.trials["corrected"].motor).max()
    facts = [(f"At {speed_text(series.speed)}", step_said(series)) for series in found.series]
    facts += [
        ("The model itself expects, at rest", f"{mm(found.expected_mm)} mm RMS"),
        (
            "Integration",
            "implicit midpoint on Drake's mass matrix and forces; no inertia is added to any spring",
        ),
        ("Servo error, largest", f"{significant(servo, 3)} µrad (or µm)"),
    ]
    facts[len(found.series) : len(found.series)] = found.modes.facts()
    if found.sweep is not None:
        facts.append(("By speed", sweep_said(found.sweep)))
    return facts
