"""How often what is stated with a probability is true, as the blind study counted it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .drawing import INK, MIDDLE, NOISE, Figure, drawing
from .numbers import percent

NEAR = 5.0  # %: of classes nearer to each other than that the second has its count under its bar
COUNTED = Path(__file__).with_name("reliability.json")  # `benchmarks/blind.py` writes it


def published() -> Figure | None:
    """The figure of the release's own blind study; None where it has none."""
    if not COUNTED.is_file():
        return None
    said = json.loads(COUNTED.read_text(encoding="utf-8"))
    return reliability(said["reliability"], said["cases"])


def reliability(classes: Sequence[Mapping[str, Any]], cases: int) -> Figure | None:
    """classes: of stated probabilities, as `studies.blind.tally.reliability` counts them in so many cases."""
    if not classes:
        return None
    with drawing("reliability", 2.5) as (axes, svg):
        axes.plot([0, 100], [0, 100], "--", color=NOISE, lw=1.4, label="stated as it is")
        last, under = -NEAR, False
        for row in classes:
            x, low, true, high = (100 * row[key] for key in ("stated", "low", "true", "high"))
            axes.plot([x, x], [low, high], color=MIDDLE, lw=4, alpha=0.35)
            axes.plot([x], [true], "o", color=MIDDLE, ms=6)
            under = x - last < NEAR and not under
            at, lift, side = (low, -5, "top") if under else (high, 5, "bottom")
            words = {"ha": "center", "va": side, "color": INK, "fontsize": 8}
            axes.annotate(row["statements"], (x, at), (0, lift), textcoords="offset points", **words)
            last = x
        axes.plot([], [], "o", color=MIDDLE, ms=6, label="true, with 95 % interval and number of statements")
        axes.set(xlabel="stated, %", ylabel="true, %", xlim=(-3, 103), ylim=(-3, 112))
        axes.set_yticks(range(0, 101, 20))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    most = classes[-1]
    return Figure(
        "reliability",
        f"Of what is stated with {percent(most['from'], 0)} or more, {percent(most['true'], 0)} was true "
        f"({cases} simulated campaigns, faults in other forms than ours)",
        "Stated probabilities of causes and rivals against the share that was true, with 95 % intervals and "
        "numbers of statements",
        svg[0],
    )
