"""The cases counted: rates with their aims, by strength, by cause, and what was taken for what."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import stats

from ..case_study import Record

STRENGTHS = (20.0, 40.0, 80.0, 200.0, 600.0, np.inf)  # edges of the classes of λ
STATED = (0.0, 0.2, 0.5, 0.8, 0.95, 0.99, 1.0)  # edges of the classes of stated probabilities
Test = Callable[[Record], bool]


@dataclass(frozen=True)
class Rate:
    """A share of cases with its 95 % interval (Wilson), and the aim: at least (or at most) so much."""

    name: str
    hits: int
    total: int
    low: float
    high: float
    at_least: float | None = None
    at_most: float | None = None

    @property
    def share(self) -> float:
        return self.hits / self.total if self.total else float("nan")

    @property
    def reached(self) -> bool | None:
        if not self.total or (self.at_least is None and self.at_most is None):
            return None
        above = self.at_least is None or self.share >= self.at_least
        return above and (self.at_most is None or self.share <= self.at_most)

    @property
    def text(self) -> str:
        if not self.total:
            return f"{self.name:<52} no case"
        aim = [f"≥ {100 * self.at_least:g}"] if self.at_least is not None else []
        aim += [f"≤ {100 * self.at_most:g}"] if self.at_most is not None else []
        mark = {True: "reached", False: "MISSED", None: ""}[self.reached]
        span = f"({100 * self.low:.0f}–{100 * self.high:.0f})"
        said = f"{100 * self.share:5.1f} %  {self.hits}/{self.total} {span}"
        return f"{self.name:<52} {said:<26} {', '.join(aim):<12} {mark}".rstrip()

    def to_json(self) -> dict[str, Any]:
        return {**asdict(self), "share": self.share if self.total else None, "reached": self.reached}


def rate(
    name: str,
    cases: Sequence[Record],
    test: Test,
    at_least: float | None = None,
    at_most: float | None = None,
) -> Rate:
    """Share of the cases that pass the test."""
    hits, total = sum(bool(test(case)) for case in cases), len(cases)
    low, high = (0.0, 1.0) if not total else stats.binomtest(hits, total).proportion_ci(method="wilson")
    return Rate(name, hits, total, float(low), float(high), at_least, at_most)


def kind(case: Record) -> str:
    """single, pair, unknown, clean-stated or clean-repeats."""
    what = str(case["key"]).partition("/")[0]
    if what == "pair" or what.startswith("clean"):
        return what
    return "unknown" if what.startswith("unknown") else "single"


def strength(case: Record) -> float:
    """λ of what is hidden; of two, the weaker."""
    return min((float(truth["strength"]) for truth in case["truths"]), default=0.0)


def aims(cases: Sequence[Record]) -> list[Rate]:
    """The rates that the study is for."""
    of = {name: [c for c in cases if kind(c) == name] for name in KINDS}
    single, pairs, unknown = of["single"], of["pair"], of["unknown"]
    strong = [c for c in single if strength(c) >= STRONG]
    strongest = [c for c in single if strength(c) >= 200]
    z, form = offsets(cases, "z"), offsets(cases, "z_form")
    return [
        rate("λ ≥ 40: truth among the reported causes", strong, _is("reported"), at_least=0.97),
        rate("λ ≥ 40: first name right", strong, _is("first_right"), at_least=0.92),
        rate("λ ≥ 200: first name right", strongest, _is("first_right"), at_least=0.98),
        rate("  the same, where no other cause is within λ 10", _apart(strongest), _is("first_right")),
        rate("one cause: a wrong one named", single, _is("wrong_name"), at_most=0.01),
        rate("one cause: a wrong one named first", single, _is("first_wrong_name")),
        rate("outside the catalogue: said to be unknown", unknown, _is("unknown"), at_least=0.95),
        rate("outside the catalogue: a cause named", unknown, _is("wrong_name"), at_most=0.02),
        rate("clean, σ stated: false alarm", of["clean-stated"], _is("false_alarm"), at_most=0.015),
        rate("clean, σ from repeats: false alarm", of["clean-repeats"], _is("false_alarm"), at_most=0.015),
        rate("two causes: both found", pairs, _is("reported"), at_least=0.92),
        rate("two causes: both found and nothing else", pairs, _both_only, at_least=0.85),
        rate("two causes: both first names right, nothing else", pairs, _both_first),
        rate("a data fault seen where there is none", cases, lambda c: bool(c["faults"])),
        rate("95 % intervals: cover what is hidden, in its form", z, _inside, at_least=0.93, at_most=0.97),
        rate("95 % intervals: cover what is hidden", form, _inside),
        rate("held-out error ≤ 1.2 × bound", _bounded(cases), _near_bound),
    ]


STRONG = 40.0  # λ
KINDS = ("single", "pair", "unknown", "clean-stated", "clean-repeats")


def _is(name: str) -> Test:
    return lambda case: bool(case[name])


def _apart(cases: Sequence[Record]) -> list[Record]:
    """Cases in which every other cause leaves more of the truth than its own cause does, by λ 10."""
    return [c for c in cases if min(item["left"] for item in c["nearest"]) > c["form_left"] + 10]


def _both_only(case: Record) -> bool:
    return bool(case["reported"] and case["nothing_else"])


def _both_first(case: Record) -> bool:
    return bool(case["reported"] and case["only_right"])


def _inside(case: Record) -> bool:
    return abs(float(case["z"])) < 1.96


def offsets(cases: Sequence[Record], name: str) -> list[Record]:
    """One record per interval: how many standard deviations it is off."""
    return [
        {"key": c["key"], "label": label, "z": z}
        for c in cases
        for label, z in c[name].items()
        if np.isfinite(z)
    ]


def _bounded(cases: Sequence[Record]) -> list[Record]:
    return [case for case in cases if case["bound_mm"]]


def _near_bound(case: Record) -> bool:
    return float(case["error_mm"]) <= 1.2 * float(case["bound_mm"])


def figures(cases: Sequence[Record]) -> dict[str, float | None]:
    """Held-out error over the bound, rms over the cases: as diagnosed, and with the right causes; share of
    strong single causes whose first name its own probability says to be right; seconds."""
    bounded = _bounded(cases)
    strong = [c for c in cases if kind(c) == "single" and strength(c) >= STRONG]
    first = [max((float(p) for p, _ in case["stated"]), default=0.0) for case in strong]
    seconds = [float(c["seconds"]) for c in cases]

    def ratio(name: str) -> float | None:
        squares = [(float(c[name]) / float(c["bound_mm"])) ** 2 for c in bounded]
        return float(np.sqrt(np.median(squares))) if squares else None

    return {
        "error_over_bound": ratio("error_mm"),
        "error_over_bound_right_cause": ratio("right_error_mm"),
        "first_by_its_probability": float(np.mean(first)) if first else None,
        "seconds_median": float(np.median(seconds)) if seconds else None,
        "seconds_max": max(seconds, default=None),
    }


def by_strength(cases: Sequence[Record]) -> list[dict[str, Any]]:
    """Single causes in classes of λ: shares detected, reported, first, named rightly and wrongly, and what
    one who knows the shapes would report."""
    rows = []
    single = [c for c in cases if kind(c) == "single"]
    for low, high in pairwise(STRENGTHS):
        here = [c for c in single if low <= strength(c) < high or (low == STRENGTHS[0] and strength(c) < low)]
        if not here:
            continue
        rows.append(
            {
                "from": low,
                "to": high if np.isfinite(high) else None,
                "cases": len(here),
                "middle": float(np.exp(np.mean([np.log(strength(c)) for c in here]))),
                "detected": _share(here, lambda c: c["verdict"] != "nothing_missing"),
                "reported": _share(here, _is("reported")),
                "first": _share(here, _is("first_right")),
                "named": _share(here, lambda c: c["verdict"] == "named" and c["first_right"]),
                "wrong": _share(here, _is("wrong_name")),
                "at_best": float(np.mean([case["at_best"] for case in here])),
            }
        )
    return rows


def _share(cases: Sequence[Record], test: Test) -> float:
    return sum(bool(test(case)) for case in cases) / len(cases)


def by_cause(cases: Sequence[Record]) -> list[dict[str, Any]]:
    """Single causes and kinds of unknown, one row each."""
    groups: dict[str, list[Record]] = {}
    for case in cases:
        groups.setdefault(str(case["key"]).partition("/")[0], []).append(case)
    return [
        {
            "what": what,
            "cases": len(group),
            "first_right": sum(bool(c["first_right"]) for c in group),
            "reported": sum(bool(c["reported"]) for c in group),
            "unknown": sum(bool(c["unknown"]) for c in group),
            "wrong_name": sum(bool(c["wrong_name"]) for c in group),
            "nothing_missing": sum(c["verdict"] == "nothing_missing" for c in group),
        }
        for what, group in groups.items()
    ]


def confusion(cases: Sequence[Record]) -> tuple[list[str], list[str], Any]:
    """Rows: what was hidden; columns: what was reported first (twins count as the truth); counts."""
    rows, columns, pairs = list[str](), list[str](), list[tuple[str, str]]()
    for case in cases:
        what = str(case["key"]).partition("/")[0]
        if kind(case) == "pair":
            continue
        hidden = what if kind(case) == "single" else kind(case)
        first = hidden if case["first_right"] else str(case["first"])
        if kind(case) == "unknown" and case["verdict"] == "unknown":
            first = "unknown"
        pairs.append((hidden, first))
        rows += [hidden] if hidden not in rows else []
    rows = sorted(rows, key=lambda r: (r in KINDS, r))
    order = [r for r in rows if r not in KINDS]
    columns = order + sorted({first for _, first in pairs} - set(order) - {"unknown", "nothing"})
    columns += ["unknown", "nothing"]
    counts = np.zeros((len(rows), len(columns)), dtype=int)
    for hidden, first in pairs:
        counts[rows.index(hidden), columns.index(first)] += 1
    return rows, columns, counts


def missed(case: Record) -> bool:
    """Whether something about the case is not as it should be."""
    if case["faults"] or case["wrong_name"] or case["false_alarm"]:
        return True
    if kind(case) == "unknown":
        return not case["unknown"]
    if kind(case) == "pair":
        return not _both_only(case)
    return kind(case) == "single" and not (case["first_right"] and case["reported"])


def reliability(cases: Sequence[Record]) -> list[Record]:
    """Classes of the probabilities that were stated of causes and rivals: how many, their mean, and the share
    that was true, with its 95 % interval (Wilson)."""
    every = np.array([pair for case in cases for pair in case["stated"]], dtype=float).reshape(-1, 2)
    out = []
    for low, high in pairwise(STATED):
        here = every[(every[:, 0] > low) & (every[:, 0] <= high)]
        if len(here):
            right = stats.binomtest(int(here[:, 1].sum()), len(here))
            low_true, high_true = right.proportion_ci(method="wilson")
            out.append(
                {
                    "from": low,
                    "to": high,
                    "statements": len(here),
                    "stated": float(here[:, 0].mean()),
                    "true": float(right.statistic),
                    "low": float(low_true),
                    "high": float(high_true),
                }
            )
    return out
