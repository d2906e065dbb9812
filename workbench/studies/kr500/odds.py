"""Accounts judged, as tables of this study: items in rows, for there are more of them than fit side by
side."""

from __future__ import annotations

import numpy as np

from workbench import Judged, Table, numbers

from .accounts import KINDS

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
        rows.append([words, *(_stands(judged, name, key) for name in names)])
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


def _stands(judged: Judged, account: str, item: str | None) -> str:
    found = judged.standing(account, item)
    if found.reproduced:
        return "yes"
    return f"{numbers.decimals(found.distance, 1)} σ" if np.isfinite(found.distance) else "too few draws"


def ranges_table(judged: Judged) -> Table:
    """What is not printed, and the range that it is drawn from."""
    every = {key: prior for account in judged.accounts for key, prior in account.priors.items()}
    rows = [[prior.words, prior.range, prior.why] for prior in every.values()]
    return Table(
        "What the paper does not give, and the range it is drawn from", ("", "Range", "Why"), rows, "", ()
    )
