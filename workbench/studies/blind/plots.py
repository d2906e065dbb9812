"""The study's figures, as SVG for the page and as PNG beside it."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import Any

import numpy as np
from scipy.stats import norm

from ...report import reliability
from ...report.drawing import AFTER, BEFORE, INK, MIDDLE, MUTED, NOISE, Figure, drawing, plain_log
from ...report.numbers import words
from ..case_study import Record
from . import tally
from .tally import Rate, by_strength, confusion, offsets

Files = dict[str, bytes]


def figures_of(cases: Sequence[Record], rates: Sequence[Rate]) -> tuple[list[Figure], Files]:
    """All figures that the cases allow, and the files `<name>.svg` and `<name>.png`."""
    made, files = [], Files()
    for draw in (_rates, _reliability, _confusion, _strength, _intervals, _errors):
        figure = draw(cases, rates, files)
        if figure is not None:
            files[f"{figure.name}.svg"] = figure.svg.encode()
            made.append(figure)
    return made, files


def _png(axes: Any, files: Files, name: str) -> None:
    picture = BytesIO()
    axes.figure.savefig(picture, format="png", dpi=150, facecolor="white")
    files[f"{name}.png"] = picture.getvalue()


def _rates(cases: Sequence[Record], rates: Sequence[Rate], files: Files) -> Figure | None:
    shown = [r for r in rates if r.total]
    if not shown:
        return None
    with drawing("rates", 0.7 + 0.3 * len(shown)) as (axes, svg):
        for row, r in enumerate(shown):
            colour = {True: NOISE, False: BEFORE, None: MIDDLE}[r.reached]
            axes.plot([100 * r.low, 100 * r.high], [row, row], color=colour, lw=5, alpha=0.35)
            axes.plot([100 * r.share], [row], "o", color=colour, ms=6)
            for aim in (r.at_least, r.at_most):
                if aim is not None:
                    axes.plot([100 * aim] * 2, [row - 0.35, row + 0.35], color=INK, lw=1.2)
        axes.set(
            yticks=range(len(shown)), ylim=(len(shown) - 0.4, -0.6), xlim=(-1, 101), xlabel="% of the cases"
        )
        axes.set_yticklabels([f"{r.name} ({r.total})" for r in shown], color=INK)
        axes.grid(axis="y", visible=False)
        _png(axes, files, "rates")
    reached = sum(r.reached is True for r in shown)
    aimed = sum(r.reached is not None for r in shown)
    return Figure(
        "rates", f"{reached} of {aimed} aims are reached", "Rates with 95 % intervals and aims", svg[0]
    )


def _reliability(cases: Sequence[Record], rates: Sequence[Rate], files: Files) -> Figure | None:
    return reliability.reliability(tally.reliability(cases), len(cases))


def _confusion(cases: Sequence[Record], rates: Sequence[Rate], files: Files) -> Figure | None:
    rows, columns, counts = confusion(cases)
    if not rows:
        return None
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    with drawing("confusion", 1.9 + 0.24 * len(rows)) as (axes, svg):
        for (i, j), count in np.ndenumerate(counts):
            if count:
                right = rows[i] == columns[j] or (rows[i].startswith("clean") and columns[j] == "nothing")
                colour = AFTER if right else BEFORE
                axes.fill_between([j - 0.5, j + 0.5], i - 0.5, i + 0.5, color=colour, lw=0,
                                  alpha=0.15 + 0.6 * float(share[i, j]))  # fmt: skip
                axes.text(j, i, str(count), ha="center", va="center", color=INK, fontsize=7.5)
        axes.set(yticks=range(len(rows)), xticks=range(len(columns)), xlim=(-0.5, len(columns) - 0.5),
                 ylim=(len(rows) - 0.5, -0.5), xlabel="reported first", ylabel="hidden")  # fmt: skip
        axes.set_yticklabels([_words(r) for r in rows], color=INK)
        axes.set_xticklabels([_words(c) for c in columns], rotation=55, ha="right", rotation_mode="anchor")
        _png(axes, files, "confusion")
    hits = sum(int(counts[i, columns.index(r)]) for i, r in enumerate(rows) if r in columns)
    hits += sum(int(counts[i, -1]) for i, r in enumerate(rows) if r.startswith("clean"))
    title = f"{hits} of {int(counts.sum())} cases are reported as what they are"
    return Figure("confusion", title, "Confusion matrix: hidden cause against the one reported first", svg[0])


def _words(name: str) -> str:
    return words(name).replace("-", ", ")


def _strength(cases: Sequence[Record], rates: Sequence[Rate], files: Files) -> Figure | None:
    rows = by_strength(cases)
    if len(rows) < 2:
        return None
    lines = {"detected": MUTED, "reported": AFTER, "first": INK, "named": NOISE, "wrong": BEFORE}
    said = {
        "detected": "something found", "reported": "truth reported", "first": "first name right",
        "named": "named, rightly", "wrong": "a wrong cause named",
    }  # fmt: skip
    with drawing("strength", 3.0) as (axes, svg):
        x = [row["middle"] for row in rows]
        for name, colour in lines.items():
            axes.plot(
                x, [100 * row[name] for row in rows], "o-", color=colour, ms=4, lw=1.6, label=said[name]
            )
        best = [100 * row["at_best"] for row in rows]
        axes.plot(x, best, "--", color=MUTED, lw=1.2, label="reported, were its shape known")
        axes.set(
            xscale="log", xlabel="non-centrality λ of what is hidden", ylabel="% of the cases", ylim=(-2, 102)
        )
        plain_log(axes.xaxis)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        _png(axes, files, "strength")
    last = rows[-1]
    title = f"From λ = {last['from']:g} the first name is right in {100 * last['first']:.0f} % of the cases"
    return Figure("strength", title, "Shares detected, reported, and named against λ", svg[0])


def _intervals(cases: Sequence[Record], rates: Sequence[Rate], files: Files) -> Figure | None:
    z = np.array([item["z"] for item in offsets(cases, "z")])
    if len(z) < 10:
        return None
    edges = np.linspace(-5, 5, 41)
    with drawing("intervals", 2.4) as (axes, svg):
        axes.stairs(
            np.histogram(np.clip(z, -5, 5), edges, density=True)[0], edges, fill=True, color=AFTER, alpha=0.4
        )
        x = np.linspace(-5, 5, 201)
        axes.plot(x, norm.pdf(x), color=NOISE, lw=1.6)
        axes.set(xlabel="found minus true, in standard deviations", ylabel="density")
        _png(axes, files, "intervals")
    inside = 100 * float(np.mean(np.abs(z) < 1.96))
    title = f"{inside:.0f} % of the 95 % intervals hold the true value"
    return Figure("intervals", title, "Errors of the main parameters over their standard deviations", svg[0])


def _errors(cases: Sequence[Record], rates: Sequence[Rate], files: Files) -> Figure | None:
    bounded = [c for c in cases if c["bound_mm"]]
    if len(bounded) < 10:
        return None
    with drawing("errors", 2.4) as (axes, svg):
        for name, colour, label in (
            ("error_mm", AFTER, "as diagnosed"), ("right_error_mm", MIDDLE, "with the right causes"),
        ):  # fmt: skip
            ratio = np.sort([float(c[name]) / float(c["bound_mm"]) for c in bounded])
            axes.plot(
                ratio, 100 * np.arange(1, len(ratio) + 1) / len(ratio), color=colour, lw=1.8, label=label
            )
        axes.axvline(1.2, color=INK, lw=1)
        axes.set(
            xscale="log", xlabel="held-out error over the Cramér–Rao bound", ylabel="% of the cases below"
        )
        plain_log(axes.xaxis)
        axes.legend(loc="lower right")
        _png(axes, files, "errors")
    middle = float(np.median([float(c["error_mm"]) / float(c["bound_mm"]) for c in bounded]))
    title = f"At other poses the model errs by {middle:.2f} times the bound in the median case"
    return Figure("errors", title, "Distribution of held-out error over the bound", svg[0])
