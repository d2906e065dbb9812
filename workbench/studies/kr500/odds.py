"""Accounts judged, as tables of this study: items in rows, for there are more of them than fit side by
side."""

from __future__ import annotations

import numpy as np

from workbench import Array, Judged, Table, numbers

from .accounts import KINDS

SHAKEN = 4000

SHORT = {
    "plain": "Constant, plain",
    "constant": "Constant",
    "soft": "Soft zone",
    "varying": "Varies (authors)",
    "structure": "Bearings, tool",
    "bracket": "Bracket",
    "force": "Force misread",
    "moment": "No moment",
    "moment_varying": "No moment, varies",
    "moment_bracket": "No moment, bracket",
    "moment_force": "No moment, misread",
}


def standings_table(judged: Judged, moment: bool) -> Table:
    """Printed item × account, of those whose model knows where the load hangs or of the others."""
    names = [name for name, (_, _, _, knows) in KINDS.items() if knows is moment]
    rows = []
    for key, words in [*((item.name, item.words) for item in judged.items), (None, "All together")]:
        stands = [judged.standing(name, key) for name in names]
        rows.append(
            [words, *("yes" if s.reproduced else f"{numbers.decimals(s.distance, 1)} σ" for s in stands)]
        )
    right = [sum(judged.standing(name, item.name).reproduced for item in judged.items) for name in names]
    rows.append([f"Reproduced, of {len(judged.items)}", *map(str, right)])
    places = "; ".join(f"{item.words}: {item.place}" for item in judged.items)
    note = (
        "yes: more than one draw in twenty lies as far from the draws’ middle as the print; else by how many "
        "of their standard deviations the account misses it." + (f" Printed in: {places}." if moment else "")
    )
    title = "it is known where the load hangs" if moment else "the load’s moment is left out"
    return Table(
        f"What accounts reproduce: {title}", ("Printed", *(SHORT[name] for name in names)), rows, note
    )


def odds_table(judged: Judged) -> Table:
    """Evidence and probability of each account, and how far its Monte-Carlo error moves it."""
    whole, shaken = judged.probabilities(), shaken_probabilities(judged)
    best = max(one.log10 for one in judged.evidence.values())
    rows = []
    for account in judged.accounts:
        name, one = account.name, judged.evidence[account.name]
        low, high = np.quantile(shaken[name], [0.05, 0.95])
        odds = f"{numbers.decimals(one.log10 - best, 1)} ± {numbers.decimals(one.error, 1)}"
        rows.append(
            [
                account.words,
                str(len(account.priors)),
                odds if np.isfinite(one.log10) else "too few draws reach",
                numbers.probability(whole[name]),
                f"{numbers.probability(low)} … {numbers.probability(high)}",
            ]
        )
    head = (
        "Account",
        "Free values",
        "log₁₀ odds to the best",
        "Probability",
        "… within the errors, 5 to 95 %",
    )
    note = (
        "All accounts as probable before, and no other thought of. The likelihood of all printed numbers is "
        f"averaged over each account’s free values, from {len(judged.last['plain'].shares)} draws in the "
        "last of three rounds that are led towards the print. ±: one standard deviation of its Monte-Carlo "
        "error, or what a kernel half as wide changes: of accounts far behind it says only that they are "
        "far. Within the errors: all log₁₀ odds shaken by their ± at once."
    )
    return Table("Odds of the accounts, from all that is printed", head, rows, note)


def shaken_probabilities(judged: Judged) -> dict[str, Array]:
    """(SHAKEN,) probabilities of each account, with the logarithm of every evidence moved by its error,
    normally."""
    found = judged.evidence.values()
    rng = np.random.default_rng([judged.seed, 9])
    moved = np.array([one.log10 + one.error * rng.normal(size=SHAKEN) for one in found])
    shares = 10 ** (moved - moved.max(axis=0))
    return dict(zip(judged.evidence, shares / shares.sum(axis=0), strict=True))


def ranges_table(judged: Judged) -> Table:
    """What is not printed, and the range that it is drawn from."""
    every = {key: prior for account in judged.accounts for key, prior in account.priors.items()}
    rows = [[prior.words, prior.range, prior.why] for prior in every.values()]
    return Table(
        "What the paper does not give, and the range it is drawn from", ("", "Range", "Why"), rows, "", ()
    )
