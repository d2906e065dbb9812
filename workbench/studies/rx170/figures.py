"""The RX170 study in figures, a table and numbers: stiffness, the swept joint and its gear, the spiral."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench import (
    Array,
    Figure,
    LocalStiffness,
    Separation,
    Table,
    by_joint,
    charts,
    numbers,
    sweep,
)

from .heights import height_figure
from .printed import SPEED, TABLE_1, TABLE_2
from .spiral import CORRECTIONS, FAST, SLOW, Spirals

DEGREE = np.rad2deg(1e3)  # 1/1000 deg per rad
CLOSE = np.deg2rad(10.0)  # rad of the sweep that are shown close
CORRECTED = ("none", "stiffness", "both")  # the paper's three commands


def stiffness_numbers(local: Sequence[LocalStiffness], share: Array) -> dict[str, float]:
    """Table I beside what was found, in 10⁶ N·m/rad; share: true over printed."""
    value, low, high, std, torque, turn = _columns(local)
    true = share * TABLE_1
    return {
        "local_half": 1.96 * float(std[1]),
        "inside": float(((low <= true) & (true <= high)).sum()),
        **by_joint("true", true / 1e6),
        **by_joint("k", value / 1e6),
        **by_joint("low", low / 1e6),
        **by_joint("high", high / 1e6),
        **by_joint("off", value / true - 1),
        **by_joint("std", std),
        **by_joint("half", 1.96 * std),
        **by_joint("torque", torque),
        **by_joint("turn", 1e3 * turn),
    }


def stiffness_figure(local: Sequence[LocalStiffness], share: Array) -> Figure:
    """Identified over printed stiffness."""
    value, low, high, *_ = (column / TABLE_1 for column in _columns(local))
    series = {
        "printed": charts.Series(np.ones(len(local)), colour=charts.PRINTED),
        "true, simulated": charts.Series(share, colour=charts.MODEL),
        "identified, 95 %": charts.Series(value, low, high, charts.OURS),
    }
    inside = int(((low <= share) & (share <= high)).sum())
    title = f"Each joint loaded by itself: {inside} of {len(local)} intervals hold the true stiffness"
    names = [found.joint.replace("_", " ") for found in local]
    return charts.rows("stiffness", title, names, series, "stiffness over Table I")


def _columns(local: Sequence[LocalStiffness]) -> Array:
    return np.array([(f.value, f.low, f.high, f.relative_std, f.torque, f.turn) for f in local]).T


def sweep_figures(found: Separation, joint: str) -> dict[str, Figure]:
    """`error`, `torque`, `gear`, `close` and `lines`, by name."""
    return _load_figures(found, f"{joint}, °") | _gear_figures(found, f"{joint}, °")


def _load_figures(found: Separation, angle: str) -> dict[str, Figure]:
    """The whole error with the load's part, and the torque that makes it."""
    error, yielded = DEGREE * found.error, DEGREE * found.yielded
    ends = [numbers.decimals(float(end), 0) for end in (found.torque.min(), found.torque.max())]
    errors = {
        "measured": charts.Series(error, colour=charts.MIDDLE, style="o"),
        "of it, yield under the residual torque": charts.Series(yielded, colour=charts.OURS),
    }
    torques = {
        "residual torque": charts.Series(found.torque, colour=charts.OURS),
        "with a spring 1 % stiffer": charts.Series(
            found.torque + found.spring, colour=charts.BEFORE, style="--"
        ),
    }
    title = (
        f"Of the position error {numbers.decimals(np.ptp(yielded), 0)}/1000° from end to end are the load's"
    )
    q, y = np.rad2deg(found.q), "position error, 1/1000°"
    return {
        "error": charts.curves("error", title, q, errors, angle, y),
        "torque": charts.curves(
            "torque",
            f"The spring leaves {' … '.join(ends)} N·m to the joint",
            q,
            torques,
            angle,
            "torque, N·m",
        ),
    }


def _gear_figures(found: Separation, angle: str) -> dict[str, Figure]:
    """The gear's part, over the whole sweep and close, and the scan for its lines."""
    q, y = np.rad2deg(found.q), "kinematic error, 1/1000°"
    gear, first, lines = (DEGREE * x for x in (found.gear, found.fundamental, found.lines_only))
    near = abs(found.q - found.q.mean()) < CLOSE / 2
    whole = {
        "kinematic error": charts.Series(gear, colour=charts.MIDDLE, style="o"),
        "fundamental": charts.Series(first, colour=charts.OURS),
    }
    close = {
        "kinematic error": charts.Series((gear - gear[near].mean())[near], colour=charts.MIDDLE, style="o"),
        "fundamental": charts.Series(first[near], colour=charts.BEFORE, style="--"),
        "all lines found": charts.Series(lines[near], colour=charts.OURS),
    }
    scanned = {
        "before": charts.Series(found.before, colour=charts.BEFORE),
        "with the lines in the model": charts.Series(found.after, colour=charts.OURS),
    }
    largest = numbers.decimals(float(np.abs(first).max()), 1)
    orders = ", ".join(numbers.decimals(line.order, 1) for line in found.lines)
    whole_rms = numbers.decimals(float(gear[near].std()), 1)
    left = numbers.decimals(float((gear - lines)[near].std()), 1)
    titles = {
        "gear": f"Without the load's part: a fundamental of {largest}/1000°",
        "close": f"The same over {np.rad2deg(CLOSE):.0f}°: the lines leave {left}/1000° RMS of {whole_rms}",
        "lines": f"The scan finds {orders} cycles per joint turn",
    }
    x, stands_out = "cycles per joint turn", "how far a line stands out, σ"
    return {
        "gear": charts.curves("gear", titles["gear"], q, whole, angle, y),
        "close": charts.curves("close", titles["close"], q[near], close, angle, y),
        "lines": charts.curves("lines", titles["lines"], found.orders, scanned, x, stands_out),
    }


def line_table(found: Separation, joint: str) -> Table:
    """The lines that were found, with the shaft that each belongs to."""
    turns, cycles = sweep.shaft(found.lines)
    return Table(
        f"Lines of {joint}, found without its ratio",
        (
            "Cycles per joint turn",
            "95 % interval",
            "Amplitude, 1/1000°",
            "95 %, ±",
            "Cycles per turn of the shaft",
        ),
        [
            [
                numbers.decimals(line.order, 2),
                f"{numbers.decimals(line.low, 2)} … {numbers.decimals(line.high, 2)}",
                numbers.decimals(DEGREE * line.amplitude, 2),
                numbers.decimals(1.96 * DEGREE * line.std, 2),
                str(whole) if whole else f"none: {numbers.significant(line.order / turns)}",
            ]
            for line, whole in zip(found.lines, cycles, strict=True)
        ],
        f"The shaft: half the largest line's order, {numbers.decimals(turns, 2)} turns per joint turn.",
    )


def sweep_numbers(found: Separation) -> dict[str, float]:
    """Orders, sizes in 1/1000°, torques in N·m, and stiffness from the sweep alone in 10⁶ N·m/rad."""
    first, smooth = found.lines[0], found.error - found.lines_only
    by_name = {
        "poses": len(found.q),
        "order": first.order,
        "order_low": first.low,
        "order_high": first.high,
        "order_half": (first.high - first.low) / 2,
        "width": 2 * np.pi / np.ptp(found.q),
        "shaft": sweep.shaft(found.lines)[0],
        "lines": len(found.lines),
        "amplitude": DEGREE * first.amplitude,
        "error_rms": DEGREE * found.error.std(),
        "lines_rms": DEGREE * found.lines_only.std(),
        "smooth_rms": DEGREE * np.sqrt(max(smooth.var() - found.noise**2, 0.0)),
        "noise_rms": DEGREE * found.noise,
        "yield_span": DEGREE * np.ptp(found.yielded),
        "largest": DEGREE * np.abs(found.lines_only).max(),
        "spring_change": np.ptp(found.spring),
        "spring_share": np.ptp(found.spring) / np.ptp(found.torque),
    }
    for key, alone in zip(("lines", "once", "smooth"), found.alone.values(), strict=True):
        by_name |= {
            f"alone_{key}": alone.stiffness / 1e6,
            f"alone_{key}_half": 1.96 * alone.relative_std,
            f"alone_{key}_chi2": alone.chi2,
        }
    return {key: float(value) for key, value in by_name.items()}


def along_figure(name: str, spirals: Spirals, by_name: Mapping[str, float]) -> Figure:
    """z along the spiral, the paper's Fig. 13; name: slow or fast."""
    speed, run = {"slow": (SLOW, spirals.slow), "fast": (FAST, spirals.fast)}[name]
    ra = ", ".join(numbers.mm(by_name[f"ra_{key}_{name}"]) for key in CORRECTED)
    error = {CORRECTIONS[key]: run.error[key] for key in CORRECTED}
    return height_figure(name, f"At {speed:g} m/s the mean of |z| is {ra} mm", run.time, error, spirals.zero)


def ra_rz_figure(by_name: Mapping[str, float]) -> Figure:
    """R_a and R_z beside the printed ones."""
    which = [(r, key) for key in CORRECTED for r in ("ra", "rz")]
    printed = np.array([TABLE_2["ra"], TABLE_2["rz"]]).T.ravel()
    slow, fast = ([by_name[f"{r}_{key}_{speed}"] for r, key in which] for speed in ("slow", "fast"))
    series = {
        "printed": charts.Series(printed, colour=charts.PRINTED),
        f"ours, {SPEED:g} m/s": charts.Series(slow, colour=charts.OURS),
        "ours, ten times as fast": charts.Series(fast, colour=charts.NOISE),
    }
    names = [f"R{r[1]}, {CORRECTIONS[key].lower()}" for r, key in which]
    ours, theirs = (f"{numbers.mm(ra[0])} and {numbers.mm(ra[4])} mm" for ra in (slow, printed))
    title = f"Ra without correction and with both: {ours}; printed: {theirs}"
    return charts.rows("heights", title, names, series, "mm", log=True)
