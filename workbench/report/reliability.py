"""How often what is stated with a probability is true, as the blind study counted it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .drawing import INK, MIDDLE, NOISE, Figure, drawing
from .numbers import percent

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
    with drawing("reliability", 2.9) as (axes, svg):
        axes.plot([0, 100], [0, 100], "--", color=NOISE, lw=1.4, label="stated as it is")
        for row in classes:
            x = 100 * row["stated"]
            axes.plot([x, x], [100 * row["low"], 100 * row["high"]], color=MIDDLE, lw=4, alpha=0.35)
            axes.plot([x], [100 * row["true"]], "o", color=MIDDLE, ms=6)
            left = x > 90
            at, count = (x, 100 * row["true"]), str(row["statements"])
            side = {"xytext": (-7 if left else 7, -4), "ha": "right" if left else "left"}
            axes.annotate(count, at, fontsize=8, color=INK, textcoords="offset points", **side)
        axes.set(xlabel="stated, %", ylabel="true, %", xlim=(-3, 103), ylim=(-3, 103))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0))
    most = classes[-1]
    return Figure(
        "reliability",
        f"Of what is stated with {percent(most['from'], 0)} or more, {percent(most['true'], 0)} was true "
        f"({cases} simulated campaigns with foreign forms)",
        "Stated probabilities of causes and rivals against the share that was true, with 95 % intervals and "
        "numbers of statements",
        svg[0],
    )
