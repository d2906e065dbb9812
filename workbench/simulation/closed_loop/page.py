"""`verify.html`: the proof on one page, in the look of the report."""

from __future__ import annotations

from importlib.metadata import version

from ...report.markup import render
from ...report.numbers import mm
from ...report.study import Table, Tile
from .pictures import pictures, speed_text
from .verification import COMMAND_NAMES, Series, Verification


def page(found: Verification) -> str:
    """The whole page as text."""
    *along, heights, spectrum = pictures(found)
    return render(
        "closed_loop.html",
        robot=found.robot.title,
        path=found.path.title,
        headline=headline(found),
        lead=_lead(found),
        tiles=[_tile(series) for series in found.series],
        along=[(drawn, _numbers(series)) for drawn, series in zip(along, found.series, strict=True)],
        heights=heights,
        roughness=_roughness(found),
        repeats=_repeats(found),
        spectrum=spectrum,
        left=_left(found),
        facts=_facts(found),
        notes=found.notes,
        version=version("robot-workbench"),
    )


def headline(found: Verification) -> str:
    """What came out, in one sentence."""
    trials = found.slow.trials
    before, after = trials["uncorrected"].figures.rms_mm, trials["corrected"].figures.rms_mm
    if after < before:
        ratio = before / after
        return f"The corrected path is {ratio:.{0 if ratio >= 10 else 1}f} times as accurate"
    return "The correction does not make this path better"


def _lead(found: Verification) -> list[str]:
    said = [
        "The true robot ran the path in closed loop: controller, drives, gears, springs and loads in one "
        f"dynamic model, {len(found.path)} samples. Commands were corrected by what the model knows."
    ]
    ratio = found.slow.ratio_to_perfect
    if ratio is not None:
        perfect = mm(found.slow.trials["perfect"].figures.rms_mm)
        said.append(
            f"A model without any error would reach {perfect} mm; this one comes to {ratio:.2f} times that."
        )
    return said


def _tile(series: Series) -> Tile:
    before, after = (series.trials[name].figures for name in ("uncorrected", "corrected"))
    return Tile(
        f"RMS error at {speed_text(series.speed)}",
        mm(before.rms_mm),
        mm(after.rms_mm),
        "mm",
        f"largest {mm(before.max_mm)} → {mm(after.max_mm)} mm",
    )


def _numbers(series: Series) -> Table:
    rows = []
    for name, trial in series.trials.items():
        f = trial.figures
        values = (f.mean_mm, f.rms_mm, f.p95_mm, f.max_mm, f.across_max_mm)
        rows.append([COMMAND_NAMES[name], *(mm(value) for value in values)])
    return Table(
        f"At {speed_text(series.speed)}, {series.time[-1]:.3g} s. Distance of the tool from where it should "
        "be at that instant; across: from the path, whenever it passes.",
        ("Command", "Mean, mm", "RMS, mm", "95 %, mm", "Largest, mm", "Largest across, mm"),
        rows,
    )


def _roughness(found: Verification) -> Table:
    n = ", ".join(f"{x:.2f}" for x in found.normal + 0.0)
    return Table(
        f"Error along the normal ({n}) of the path's plane: R_a its mean size, R_z highest peak minus "
        "deepest valley.",
        ("Speed", "Command", "R_a, mm", "R_z, mm"),
        [
            [speed_text(series.speed), COMMAND_NAMES[name], mm(trial.figures.ra_mm), mm(trial.figures.rz_mm)]
            for series in found.series
            for name, trial in series.trials.items()
        ],
        numbers=(2, 3),
    )


def _repeats(found: Verification) -> Table:
    return Table(
        "ISO 9283 path accuracy AT (largest distance of the runs' mean from the path) and repeatability RT "
        "(largest mean plus three standard deviations about that mean).",
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
        "The highest lines in the corrected path's error.",
        ("Speed", "Frequency, Hz", "Amplitude, µm", "Runs with the gear of"),
        [
            [
                speed_text(series.speed),
                f"{line.frequency_hz:.3g}",
                f"{1e3 * line.amplitude_mm:.2g}",
                line.cause or "none known",
            ]
            for series in found.series
            for line in series.trials["corrected"].lines
        ],
        numbers=(1, 2),
    )


def _facts(found: Verification) -> list[tuple[str, str]]:
    servo = 1e6 * abs(found.slow.trials["corrected"].motor).max()
    return [
        ("Half the step moves the tool by", f"{found.step_change_um:.2g} µm at most"),
        ("The model itself expects, at rest", f"{mm(found.expected_mm)} mm RMS"),
        ("Integration", "third-order Runge–Kutta, fixed step of 1 ms, continuous plant"),
        ("Servo error, largest", f"{servo:.3g} µrad (or µm)"),
    ]
