"""The RX170 study in figures, a table and numbers: stiffness, the swept joint and its gear, the spiral."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...measurement.axis_by_axis import LocalStiffness
from ...measurement.separation import Separation
from ...measurement.sweep import shaft
from ...report.charts import OURS, PRINTED, Series, curves, rows
from ...report.drawing import BEFORE, MIDDLE, MODEL, NOISE, Figure
from ...report.numbers import decimals, mm, significant
from ...report.study import Table
from ...robot.kinematics import Array
from ..telling import each
from .heights import height_figure
from .spiral import COMMANDS, FAST, SLOW, Spirals

DEGREE = np.rad2deg(1e3)  # 1/1000 deg per rad
CLOSE = np.deg2rad(10.0)  # rad of the sweep that are shown close
CORRECTED = ("none", "stiffness", "both")  # the paper's three commands


def stiffness_numbers(local: Sequence[LocalStiffness], printed: Array, share: Array) -> dict[str, float]:
    """Table I beside what was found, in 10⁶ N·m/rad; share: true over printed."""
    value, low, high, std, torque, turn = _columns(local)
    true = share * printed
    return {
        "local_half": 1.96 * float(std[1]),
        "inside": float(((low <= true) & (true <= high)).sum()),
        **each("printed", printed / 1e6),
        **each("true", true / 1e6),
        **each("k", value / 1e6),
        **each("low", low / 1e6),
        **each("high", high / 1e6),
        **each("off", value / true - 1),
        **each("std", std),
        **each("torque", torque),
        **each("turn", 1e3 * turn),
    }


def stiffness_figure(local: Sequence[LocalStiffness], printed: Array, share: Array) -> Figure:
    """Identified over printed stiffness."""
    value, low, high, *_ = (column / printed for column in _columns(local))
    series = {
        "printed": Series(np.ones(len(local)), colour=PRINTED),
        "true, simulated": Series(share, colour=MODEL),
        "identified, 95 %": Series(value, low, high, OURS),
    }
    title = "Loaded by itself, each joint shows its own stiffness"
    names = [found.joint.replace("_", " ") for found in local]
    return rows("stiffness", title, names, series, "stiffness over Table I")


def _columns(local: Sequence[LocalStiffness]) -> Array:
    return np.array([(f.value, f.low, f.high, f.relative_std, f.torque, f.turn) for f in local]).T


def sweep_figures(found: Separation, joint: str) -> dict[str, Figure]:
    """`error`, `torque`, `gear`, `close` and `lines`, by name."""
    return _load_figures(found, f"{joint}, °") | _gear_figures(found, f"{joint}, °")


def _load_figures(found: Separation, angle: str) -> dict[str, Figure]:
    """The whole error with the load's part, and the torque that makes it."""
    error, yielded = DEGREE * found.error, DEGREE * found.yielded
    ends = [decimals(float(end), 0) for end in (found.torque.min(), found.torque.max())]
    errors = {
        "measured": Series(error, colour=MIDDLE, style="o"),
        "of it, yield under the residual torque": Series(yielded, colour=OURS),
    }
    torques = {
        "residual torque": Series(found.torque, colour=OURS),
        "with a spring 1 % stiffer": Series(found.torque + found.spring, colour=BEFORE, style="--"),
    }
    title = f"Of the position error {decimals(np.ptp(yielded), 0)}/1000° from end to end are the load's"
    q, y = np.rad2deg(found.q), "position error, 1/1000°"
    return {
        "error": curves("error", title, q, errors, angle, y),
        "torque": curves(
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
        "kinematic error": Series(gear, colour=MIDDLE, style="o"),
        "fundamental": Series(first, colour=OURS),
    }
    close = {
        "kinematic error": Series((gear - gear[near].mean())[near], colour=MIDDLE, style="o"),
        "fundamental": Series(first[near], colour=BEFORE, style="--"),
        "all lines found": Series(lines[near], colour=OURS),
    }
    scanned = {
        "before": Series(found.before, colour=BEFORE),
        "with the lines in the model": Series(found.after, colour=OURS),
    }
    largest = decimals(float(np.abs(first).max()), 1)
    orders = ", ".join(decimals(line.order, 1) for line in found.lines)
    titles = {
        "gear": f"Without the load's part: a fundamental of {largest}/1000°",
        "close": f"The same over {np.rad2deg(CLOSE):.0f}°: the lines follow what was measured",
        "lines": f"The scan finds {orders} cycles per joint turn",
    }
    x, stands_out = "cycles per joint turn", "how far a line stands out, σ"
    return {
        "gear": curves("gear", titles["gear"], q, whole, angle, y),
        "close": curves("close", titles["close"], q[near], close, angle, y),
        "lines": curves("lines", titles["lines"], found.orders, scanned, x, stands_out),
    }


def line_table(found: Separation, joint: str) -> Table:
    """The lines that were found, with the shaft that each belongs to."""
    turns, cycles = shaft(found.lines)
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
                decimals(line.order, 2),
                f"{decimals(line.low, 2)} … {decimals(line.high, 2)}",
                decimals(DEGREE * line.amplitude, 2),
                decimals(1.96 * DEGREE * line.std, 2),
                str(whole) if whole else f"none: {significant(line.order / turns)}",
            ]
            for line, whole in zip(found.lines, cycles, strict=True)
        ],
        f"The shaft: half the largest line's order, {decimals(turns, 2)} turns per joint turn.",
    )


def sweep_numbers(found: Separation) -> dict[str, float]:
    """Orders, sizes in 1/1000°, torques in N·m, and stiffness from the sweep alone in 10⁶ N·m/rad."""
    first, smooth = found.lines[0], found.error - found.lines_only
    numbers = {
        "poses": len(found.q),
        "order": first.order,
        "order_low": first.low,
        "order_high": first.high,
        "order_half": (first.high - first.low) / 2,
        "width": 2 * np.pi / np.ptp(found.q),
        "shaft": shaft(found.lines)[0],
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
        numbers |= {
            f"alone_{key}": alone.stiffness / 1e6,
            f"alone_{key}_half": 1.96 * alone.relative_std,
            f"alone_{key}_chi2": alone.chi2,
        }
    return {key: float(value) for key, value in numbers.items()}


def along_figure(name: str, spirals: Spirals, numbers: Mapping[str, float]) -> Figure:
    """z along the spiral, the paper's Fig. 13; name: slow or fast."""
    speed, run = {"slow": (SLOW, spirals.slow), "fast": (FAST, spirals.fast)}[name]
    ra = ", ".join(mm(numbers[f"ra_{key}_{name}"]) for key in CORRECTED)
    error = {COMMANDS[key]: run.error[key] for key in CORRECTED}
    return height_figure(name, f"At {speed:g} m/s the mean of |z| is {ra} mm", run.time, error, spirals.zero)


def ra_rz_figure(numbers: Mapping[str, float], table_2: Mapping[str, Sequence[float]]) -> Figure:
    """R_a and R_z beside the printed ones."""
    which = [(r, key) for key in CORRECTED for r in ("ra", "rz")]
    printed = np.array([table_2["ra"], table_2["rz"]]).T.ravel()
    slow, fast = ([numbers[f"{r}_{key}_{speed}"] for r, key in which] for speed in ("slow", "fast"))
    series = {
        "printed": Series(printed, colour=PRINTED),
        "ours, 0.03 m/s": Series(slow, colour=OURS),
        "ours, ten times as fast": Series(fast, colour=NOISE),
    }
    names = [f"R{r[1]}, {COMMANDS[key].lower()}" for r, key in which]
    title = (
        f"Ra falls from {mm(slow[0])} to {mm(slow[4])} mm; printed: {mm(printed[0])} to {mm(printed[4])} mm"
    )
    return rows("heights", title, names, series, "mm", log=True)
