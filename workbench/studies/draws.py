"""A study's headline over many draws of seeds and of the values that had to be assumed."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.stats import qmc, rankdata, spearmanr

from ..report import charts
from ..report.drawing import Figure
from ..report.numbers import join, percent, significant
from ..robot.kinematics import Array
from .priors import Prior
from .study_run import StudyRun
from .tasks import run_tasks

CHANCE = 0.05  # that an assumption is said to carry a number which it does not
Draw = Callable[[Mapping[str, float], int], Mapping[str, float]]


@dataclass(frozen=True)
class Draws:
    """values: assumption → (D,); numbers: name → (D,), what was found with them and a seed of its own."""

    priors: Mapping[str, Prior]
    values: Mapping[str, Array]
    numbers: Mapping[str, Array]

    @property
    def count(self) -> int:
        return len(next(iter(self.numbers.values())))

    def each(self) -> list[dict[str, float]]:
        """The numbers and assumptions of each draw."""
        both = {**self.values, **self.numbers}
        return [{name: float(column[d]) for name, column in both.items()} for d in range(self.count)]

    def range(self, name: str) -> tuple[float, float, float]:
        """5, 50 and 95 % of a number."""
        low, middle, high = np.quantile(self.numbers[name], [0.05, 0.5, 0.95])
        return float(low), float(middle), float(high)

    @property
    def middle(self) -> dict[str, float]:
        """The median of each number, where there are draws."""
        return {name: self.range(name)[1] for name in self.numbers} if self.count else {}

    def only(self, at: Array) -> Draws:
        """Some of the draws; at: (D,) bool."""
        return replace(
            self,
            values={name: column[at] for name, column in self.values.items()},
            numbers={name: column[at] for name, column in self.numbers.items()},
        )

    def by_name(self) -> dict[str, float]:
        """For a story: NAME_mid (the median), NAME_p05 and NAME_p95 of each number, and `draws`."""
        found = {"draws": float(self.count)}
        for name in self.numbers:
            low, middle, high = self.range(name)
            found |= {f"{name}_p05": low, f"{name}_mid": middle, f"{name}_p95": high}
        return found

    def carries(self, name: str) -> dict[str, float]:
        """Share of a number's variance, in ranks, that goes with each assumption alone."""
        ranks = rankdata(self.numbers[name])
        if np.ptp(ranks) == 0:
            return dict.fromkeys(self.priors, 0.0)
        return {key: float(np.corrcoef(rankdata(v), ranks)[0, 1] ** 2) for key, v in self.values.items()}

    def carrier(self, name: str) -> str | None:
        """The assumption that carries most of a number; None where chance would make some assumption carry as
        much of so few draws."""
        shares = self.carries(name)
        first = max(shares, key=lambda key: shares[key])
        if not shares[first]:
            return None
        chance = float(spearmanr(self.values[first], self.numbers[name]).pvalue)
        at_least = 2 / math.factorial(self.count)  # any order of so few draws
        return first if max(chance, at_least) < CHANCE / len(self.values) else None

    def ends(self, name: str, assumption: str) -> tuple[float, float]:
        """Median of a number over the draws in the lowest, and the highest, third of an assumption."""
        order = np.argsort(self.values[assumption])
        third = max(1, len(order) // 3)
        column = self.numbers[name]
        return float(np.median(column[order[:third]])), float(np.median(column[order[-third:]]))


def draw_many(
    work: Draw, priors: Mapping[str, Prior], draws: int, run: StudyRun, name: str = "draws"
) -> Draws:
    """`work(values, seed)` → numbers, for many draws of the assumed values and as many seeds.

    The values fill their ranges evenly (Latin hypercube). work runs in other processes: a function of a
    module, or a `partial` of one. name: of the file that keeps the draws. Raises RuntimeError where a draw
    fails, with the end of its traceback.
    """
    seed = [run.seed, zlib.crc32(name.encode())]
    # without assumptions the seeds alone are drawn
    shares = qmc.LatinHypercube(max(len(priors), 1), rng=np.random.default_rng(seed)).random(draws)
    values = [
        {key: prior.at(float(u)) for (key, prior), u in zip(priors.items(), row, strict=False)}
        for row in shares
    ]
    facts = {"seed": run.seed, "draws": draws, "priors": {k: repr(p) for k, p in priors.items()}}
    done = run_tasks(
        partial(_one, work, values, run.seed),
        [str(d) for d in range(draws)],
        run.store(name),
        study=facts,
        workers=run.workers,
        resume=run.resume,
        label=name,
    )
    results: list[Mapping[str, float]] = []
    for key, item in done.items():
        if item.error:
            raise RuntimeError(f"{name}, draw {key}: {item.error}")
        results.append(item.result)
    return Draws(
        priors,
        {key: np.array([v[key] for v in values]) for key in priors},
        {key: np.array([r[key] for r in results], dtype=float) for key in results[0]},
    )


def _one(work: Draw, values: Sequence[Mapping[str, float]], seed: int, key: str) -> dict[str, Any]:
    found = work(values[int(key)], int(np.random.SeedSequence([seed, int(key)]).generate_state(1)[0]))
    return {name: float(value) for name, value in found.items()}


def tornado(draws: Draws, number: str, name: str, label: str, factor: float = 1.0, title: str = "") -> Figure:
    """Which assumption carries a number: its median in the lowest and the highest third of each assumption.

    name: of the figure; label: of the axis, with the unit; factor: from the number to the axis. The title
    says the median, 5 to 95 %, and what carries most where the draws tell, unless it is given.
    """
    low, middle, high = (factor * end for end in draws.range(number))
    shares = draws.carries(number)
    rows = sorted(draws.priors, key=lambda key: -abs(float(np.subtract(*draws.ends(number, key)))))
    first = draws.carrier(number)
    most = "so few do not tell which assumption carries it"
    if first is not None:
        most = f"most goes with: {draws.priors[first].words} ({percent(shares[first], 0)} of the variance)"
    what, _, unit = label.partition(", ")
    size = join(f"{significant(middle, 2)} ({significant(low, 2)} … {significant(high, 2)})", unit)
    said = title or f"{what[:1].upper()}{what[1:]}: {size} in {draws.count} draws; {most}"
    bars = []
    for key in rows:
        at_low, at_high = (factor * end for end in draws.ends(number, key))
        words = f"{draws.priors[key].words}, {draws.priors[key].range}"
        bars.append(charts.Bar(words, at_low, at_high, percent(shares[key], 0)))
    return charts.tornado(name, said, bars, (low, middle, high), label)
