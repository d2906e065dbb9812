"""A swept joint in figures, a table and numbers: its error, the residual torque, the gear's lines."""

from __future__ import annotations

import numpy as np

from ..protocols.separation import Separation
from ..protocols.sweep import shaft
from ..report.charts import OURS, Series, curves
from ..report.drawing import BEFORE, MIDDLE, Figure
from ..report.numbers import decimals, significant
from ..report.study import Table

DEGREE = np.rad2deg(1e3)  # 1/1000 deg per rad
CLOSE = np.deg2rad(10.0)  # rad of the sweep that are shown close


def sweep_figures(found: Separation, joint: str) -> dict[str, Figure]:
    """`error`, `torque`, `gear`, `close` and `lines`, by name."""
    q, angle = np.rad2deg(found.q), f"{joint}, °"
    close = abs(found.q - found.q.mean()) < CLOSE / 2
    error, yielded, gear = (DEGREE * x for x in (found.error, found.yielded, found.gear))
    lines = DEGREE * found.lines_only
    ends = [decimals(float(end), 0) for end in (found.torque.min(), found.torque.max())]
    orders = ", ".join(decimals(line.order, 1) for line in found.lines)
    return {
        "error": curves(
            "error",
            f"Of the position error {decimals(np.ptp(yielded), 0)}/1000° from end to end are the load's",
            q,
            {
                "measured": Series(error, colour=MIDDLE, style="o"),
                "of it, yield under the residual torque": Series(yielded, colour=OURS),
            },
            angle,
            "measured minus commanded, 1/1000°",
        ),
        "torque": curves(
            "torque",
            f"The spring leaves {ends[0]} … {ends[1]} N·m to the joint",
            q,
            {
                "residual torque": Series(found.torque, colour=OURS),
                "with a spring 1 % stiffer": Series(found.torque + found.spring, colour=BEFORE, style="--"),
            },
            angle,
            "torque, N·m",
        ),
        "gear": curves(
            "gear",
            f"Without the load's part: a fundamental of {_largest(found)}/1000°",
            q,
            {
                "kinematic error": Series(gear, colour=MIDDLE, style="o"),
                "fundamental": Series(DEGREE * found.fundamental, colour=OURS),
            },
            angle,
            "kinematic error, 1/1000°",
        ),
        "close": curves(
            "close",
            f"The same over {decimals(float(np.rad2deg(CLOSE)), 0)}°: the lines follow what was measured",
            q[close],
            {
                "kinematic error": Series((gear - gear[close].mean())[close], colour=MIDDLE, style="o"),
                "fundamental": Series(DEGREE * found.fundamental[close], colour=BEFORE, style="--"),
                "all lines found": Series(lines[close], colour=OURS),
            },
            angle,
            "kinematic error, 1/1000°",
        ),
        "lines": curves(
            "lines",
            f"The scan finds {orders} cycles per joint turn",
            found.orders,
            {
                "before": Series(found.before, colour=BEFORE),
                "with the lines in the model": Series(found.after, colour=OURS),
            },
            "cycles per joint turn",
            "how far a line stands out, σ",
        ),
    }


def _largest(found: Separation) -> str:
    return decimals(DEGREE * float(np.abs(found.fundamental).max()), 1)


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
