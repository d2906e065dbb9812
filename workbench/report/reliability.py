"""How often what is stated with a probability is true, by the blind study and an outside simulator."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

from .drawing import AFTER, INK, MIDDLE, NOISE, Figure, drawing
from .numbers import percent

NEAR = 5.0  # %: of classes nearer to each other than that the second has its count under its bar
COUNTED = Path(__file__).with_name("reliability.json")  # `benchmarks/blind.py` writes it
OUTSIDE = Path(__file__).with_name("outside.json")  # `benchmarks/outside` writes it


def published() -> Figure | None:
    """The figure of the release's own blind study and of the outside simulator; None where it has none."""
    if not COUNTED.is_file():
        return None
    said = json.loads(COUNTED.read_text(encoding="utf-8"))
    judged = json.loads(OUTSIDE.read_text(encoding="utf-8")) if OUTSIDE.is_file() else {}
    return reliability(said["reliability"], said["cases"], judged)


def reliability(
    classes: Sequence[Mapping[str, Any]], cases: int, judged: Mapping[str, Any] | None = None
) -> Figure | None:
    """classes: of stated probabilities, as `studies.blind.tally.reliability` counts them in so many cases.
    judged: `cases` and `probability` of the outside simulator, as its `score.py` counts them."""
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
        ours = "our own simulator, with 95 % interval and number of statements"
        axes.plot([], [], "o", color=MIDDLE, ms=6, label=ours)
        if judged:
            _beside(axes, judged["probability"])
        axes.set(xlabel="stated, %", ylabel="true, %", xlim=(-3, 103), ylim=(-3, 112))
        axes.set_yticks(range(0, 101, 20))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=1)
    most = classes[-1]
    other = ""
    if judged and judged["probability"][-1]["n"]:
        last_of = judged["probability"][-1]
        share = percent(last_of["true"] / last_of["n"], 0)
        least = percent(last_of["stated"][0], 0)
        other = f"; of {least} or more {share} in {judged['cases']} of an outside one"
    return Figure(
        "reliability",
        f"Of what is stated with {percent(most['from'], 0)} or more, {percent(most['true'], 0)} was true "
        f"({cases} campaigns of our own simulator, with forms near the catalogue's{other})",
        "Stated probabilities of causes and rivals against the share that was true, with 95 % intervals and "
        "numbers of statements",
        svg[0],
    )


def _beside(axes: Any, classes: Sequence[Mapping[str, Any]]) -> None:
    """The outside simulator's classes: what is a part of the fault, or beside it, counts as not true."""
    for row in (row for row in classes if row["n"]):
        ends = binomtest(row["true"], row["n"]).proportion_ci(method="wilson")
        x = 100 * row["mean"]
        axes.plot([x, x], [100 * ends.low, 100 * ends.high], color=AFTER, lw=1.2)
        axes.plot([x], [100 * row["true"] / row["n"]], "s", color=AFTER, mfc="none", ms=6)
    axes.plot([], [], "s", color=AFTER, mfc="none", ms=6, label="an outside simulator, with 95 % interval")
