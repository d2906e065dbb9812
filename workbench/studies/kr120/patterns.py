"""What each kind of machine makes of joint 2's six compliances, and whether the pairs' own residual shows
it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy import stats

from workbench import Account, Array, Draws, Figure, Judged, StudyRun, Table, charts, draw_many, numbers

from .plans import compliances, plan, robot
from .printed import SIX, TABLE_1
from .stories import TELL, levelled
from .world import World, estimated

RANGE_1 = float(np.ptp(TABLE_1[SIX]) / TABLE_1[SIX].mean())  # of Table I's six
LARGE = 0.15  # range of the six over their mean above which a machine is one that may have made Table I
SEEN = 0.01  # p below which a residual is no noise


def machine_draws(accounts: Sequence[Account], count: int, run: StudyRun, name: str = "machines") -> Draws:
    """Each account once per draw: `range_`, `r_` (correlation of what it makes without noise with Table I's
    six, in the plan's order), `resid_` (p of the residual that six compliances leave, with the noise known),
    and `rising`: +1 where the plan's angles rise, −1 where they fall, 0 in any other order."""
    priors = {name: prior for account in accounts for name, prior in account.priors.items()}
    return draw_many(partial(one_machine, [a.name for a in accounts]), priors, count, run, name)


def one_machine(names: Sequence[str], values: Mapping[str, float], seed: int) -> dict[str, float]:
    """One draw of all accounts."""
    where = plan(int(values["plan"]))
    steps = np.sign(np.diff(where.angles))
    found = {"rising": float(steps[0]) if np.ptp(steps) == 0 else 0.0}
    for k, name in enumerate(names):
        world = levelled(TELL[name], values, where, seed + k)
        made = estimated(where, world, np.random.default_rng([seed, k]))
        clean = estimated(where, replace(world, sigma=0.0), np.random.default_rng(0)).k[SIX]
        six, noise = made.k[SIX], np.sqrt(2) * 1e-6 * values["noise"]
        found[f"range_{name}"] = float(np.ptp(six) / six.mean()) if six.mean() > 0 else np.inf
        found[f"r_{name}"] = float(np.corrcoef(six if name == "noise" else clean, TABLE_1[SIX])[0, 1])
        found[f"resid_{name}"] = float(stats.chi2.sf(made.dof * (made.residual / noise) ** 2, made.dof))
    return found


def pattern_numbers(draws: Draws, names: Sequence[str]) -> dict[str, float]:
    """For the story: how large the six differ, how they run, and how often the residual shows it."""
    found = {"machine_draws": float(draws.count), "range_printed": RANGE_1, "large": LARGE}
    for name in names:
        size, p = draws.numbers[f"range_{name}"], draws.numbers[f"resid_{name}"]
        low, middle, high = draws.range(f"range_{name}")
        found |= {f"range_{name}_p05": low, f"range_{name}_mid": middle, f"range_{name}_p95": high}
        large = size > LARGE
        found[f"reaches_{name}"] = float((size >= RANGE_1).mean())
        found[f"seen_{name}"] = float((p < SEEN).mean())
        found[f"seen_large_{name}"] = float((p[large] < SEEN).mean()) if large.any() else np.nan
        found[f"alike_{name}"] = float((draws.numbers[f"r_{name}"] > 0.8).mean())
    return found


def large_ones(soft: Draws, sign: int) -> Array:
    """(D,) which soft gears make the six differ much, on plans whose angles rise (+1) or fall (−1) as
    printed."""
    return np.asarray((soft.numbers["range_soft"] > LARGE) & (soft.numbers["rising"] == sign))


def soft_numbers(soft: Draws) -> dict[str, float]:
    """How the six of soft gears run, by the order of the angles."""
    found = {
        "soft_draws": float(soft.count),
        "soft_reaches": float((soft.numbers["range_soft"] >= RANGE_1).mean()),
    }
    for words, sign in (("rising", 1), ("falling", -1)):
        r = soft.numbers["r_soft"][large_ones(soft, sign)]
        found |= {
            f"soft_count_{words}": float(len(r)),
            f"soft_against_{words}": float((r < 0).mean()) if len(r) else np.nan,
        }
        found[f"soft_r_{words}"] = float(np.median(r)) if len(r) else np.nan
    return found


def pattern_table(draws: Draws, accounts: Sequence[Account]) -> Table:
    """What each account makes of the six, over the draws."""
    n = pattern_numbers(draws, [a.name for a in accounts])
    rows = []
    for a in accounts:
        k = a.name
        ends = f"{numbers.percent(n[f'range_{k}_p05'], 0)} … {numbers.percent(n[f'range_{k}_p95'], 0)}"
        shares = [n[f"{what}_{k}"] for what in ("reaches", "alike", "seen", "seen_large")]
        rows.append(
            [a.words, numbers.percent(n[f"range_{k}_mid"], 0), ends, *(numbers.percent(s, 0) for s in shares)]
        )
    head = (
        "Account", "Range of the six, median", "5 … 95 %", f"{numbers.percent(RANGE_1, 0)} or more",
        "Runs as Table I, r > 0.8", "Residual shows it",
        f"… where the six differ by {numbers.percent(LARGE, 0)}",
    )  # fmt: skip
    note = (
        f"{draws.count} machines of each account, with all free values drawn. Range: largest minus smallest "
        "over the mean. "
        f"Residual: what six compliances leave of the pairs has p < {SEEN}, with the noise of a reading "
        "known."
    )
    return Table(
        "What each account makes of joint 2's six compliances, and whether the pairs show it",
        head,
        rows,
        note,
    )


def pattern_figure(judged: Judged, names: Sequence[str]) -> Figure:
    """Table I's six over their mean, beside what accounts make: 5 to 95 % of their draws."""
    at = judged.columns("joint_2")
    printed = TABLE_1[SIX] / np.exp(np.log(TABLE_1[SIX]).mean())
    series = {"Table I": charts.Series(printed, colour=charts.PRINTED, style="o-")}
    words = {a.name: a.words for a in judged.accounts}
    for name, colour in zip(names, (charts.OURS, charts.MIDDLE, charts.NOISE), strict=False):
        made = judged.first[name].predicted[:, at]
        made = made[np.isfinite(made).all(axis=1)]
        over = np.exp(made - made.mean(axis=1, keepdims=True))
        low, middle, high = np.quantile(over, [0.05, 0.5, 0.95], axis=0)
        series[words[name]] = charts.Series(middle, low, high, colour, "-")
    title = "Table I's six compliances of joint 2, and what accounts make of them"
    x, y = "angle of joint 2, in the order of print", "compliance over the mean of the six"
    return charts.curves("pattern", title, np.arange(1, 7), series, x, y, height=3.4)


def blind_to_charge() -> float:
    """Largest relative change of joint 2's six compliances when a seventh of the charge is lost, without
    noise."""
    where, k = plan(0), compliances(robot())
    rng = np.random.default_rng(0)
    full, less = (estimated(where, World(k, charge=c, sigma=0.0), rng).k[SIX] for c in (1.0, 6 / 7))
    return float(np.abs(less / full - 1).max())
