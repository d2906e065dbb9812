"""Accounts judged, as tables and figures: what each reproduces and misses, its odds, and what it needs."""

from __future__ import annotations

import math

from ..report import charts
from ..report.drawing import Figure
from ..report.numbers import MISSING, decimals, percent, probability
from ..report.study import Table
from .accounts import MISSED, Judged, Standing
from .evidence import LEAST, Evidence
from .priors import Prior


def account_items(judged: Judged) -> dict[str, Table | Figure]:
    """What a story shows of its accounts: `accounts`, `odds_table`, `odds`, and `needs`."""
    return {
        "accounts": accounts_table(judged),
        "odds_table": odds_table(judged),
        "odds": odds_figure(judged),
        "needs": needs_table(judged),
    }


def accounts_table(judged: Judged) -> Table:
    """Account × printed item."""
    names = [item.name for item in judged.items]
    head = ("Account", *(item.words for item in judged.items), "All together")
    rows = [
        [a.words, *(_stands(judged.standing(a.name, item)) for item in (*names, None))]
        for a in judged.accounts
    ]
    places = "; ".join(f"{item.words}: {item.place}" for item in judged.items)
    note = (
        f"In brackets: the share of the account's {_draws(judged)} draws that lie as far from their middle "
        f"as the print; at {percent(MISSED, 0)} or less it is missed, by so many of the draws' standard "
        "deviations. "
        f"Printed in: {places}."
    )
    return Table("What each account reproduces of what is printed, and what it misses", head, rows, note, ())


def odds_table(judged: Judged) -> Table:
    """Evidence and posterior odds under equal priors, and without each item."""
    shares = judged.probabilities()
    best = judged.evidence[judged.best].log10
    rows = [
        [
            a.words,
            str(len(a.priors)),
            _odds(judged.evidence[a.name], best),
            _share(shares[a.name]),
            *(_share(left_out[a.name]) for left_out in judged.without.values()),
        ]
        for a in judged.accounts
    ]
    head = ("Account", "Free values", "log₁₀ odds to the best", "Probability",
            *(f"… without {item.words}" for item in judged.items if item.name in judged.without))  # fmt: skip
    note = (
        "All accounts as probable before, and no other thought of. The likelihood of all printed numbers is "
        f"averaged over each account's free values: kernel density of {_draws(judged)} draws that were "
        "led towards the print in rounds (without an item: of those from the whole ranges). "
        "Far below the best they are orders of magnitude only. ±: one standard deviation of its Monte-Carlo "
        "error, or what a kernel half as wide changes."
    )
    return Table("Odds of the accounts, from all that is printed", head, rows, note)


def needs_table(judged: Judged) -> Table:
    """Each free value of an account's own: what was allowed, and what the print makes of it."""
    common = shared(judged)
    alike: dict[tuple[str, ...], list[str]] = {}
    for account in judged.accounts:
        for key, prior in account.priors.items():
            if key not in common:
                found = judged.needed(account.name, key)
                low, middle, high = map(prior.said, found)
                needed = f"{middle} ({low} … {high})" if all(map(math.isfinite, found)) else MISSING
                alike.setdefault((prior.words, prior.range, needed, prior.why), []).append(account.words)
    rows = [["; ".join(accounts), *said] for said, accounts in alike.items()]
    head = ("Account", "Free value", "Allowed", "Needed (5 … 95 %)", "Why this range")
    also = "; ".join(f"{prior.words}, {prior.range}" for prior in common.values())
    note = (
        "Needed: median of the draws, weighted by how near they come to the print, in the unit of what is "
        "allowed; –: none comes near."
    )
    return Table(
        "What each account was free to choose, and what it has to choose",
        head,
        rows,
        note + (f" Free in all accounts: {also}." if also else ""),
        (),
    )


def shared(judged: Judged) -> dict[str, Prior]:
    """Free values that all accounts have alike."""
    first, *others = judged.accounts
    return {k: p for k, p in first.priors.items() if all(a.priors.get(k) == p for a in others)}


def odds_figure(judged: Judged) -> Figure:
    """Log₁₀ odds of each account to the best, with two Monte-Carlo errors to either side."""
    best = judged.evidence[judged.best].log10
    logs = [max(e.log10 - best, -300.0) for e in judged.evidence.values()]
    errors = [min(e.error, 300.0) for e in judged.evidence.values()]
    series = {"odds": charts.Series(
        logs, [a - 2 * e for a, e in zip(logs, errors, strict=True)],
        [a + 2 * e for a, e in zip(logs, errors, strict=True)], charts.OURS,
    )}  # fmt: skip
    shares = judged.probabilities()
    first = max(shares, key=lambda key: shares[key])
    tied = [key for key in shares if key != first and not judged.excluded(key, 1.0)]
    near = [key for key in tied if judged.standing(key).reproduced]
    title = f"Of the accounts, “{_words(judged, first)}” has the highest odds"
    if near:
        title += f"; {len(near)} more that {'reproduces' if len(near) == 1 else 'reproduce'} the print "
        title += f"{'is' if len(near) == 1 else 'are'} within their error"
    elif not tied:
        title = f"Of the accounts, “{_words(judged, first)}” carries {probability(shares[first])}"
    names = [a.words for a in judged.accounts]
    return charts.rows(
        "odds", title, names, series, "log₁₀ of the odds to the best account, ± two standard deviations"
    )


def _draws(judged: Judged) -> str:
    return decimals(float(len(next(iter(judged.first.values())).shares)), 0)


def _words(judged: Judged, account: str) -> str:
    return next(a.words for a in judged.accounts if a.name == account)


def _stands(found: Standing) -> str:
    share = percent(found.share, 1 if 0 < found.share < 0.01 else 0)
    if found.reproduced:
        return f"reproduces ({share})"
    if not math.isfinite(found.distance):
        return f"fewer than {LEAST} draws print it"
    return f"misses by {decimals(found.distance, 1 if found.distance < 100 else 0)} σ ({share})"


def _odds(found: Evidence, best: float) -> str:
    if not math.isfinite(found.log10):
        return "−∞"
    places = 1 if found.error < 1 else 0 if found.error < 100 else -1
    odds, error = (decimals(round(x, places), places) for x in (found.log10 - best, found.error))
    return f"{odds} ± {error}"


def _share(value: float) -> str:
    return probability(value) if math.isfinite(value) else MISSING
