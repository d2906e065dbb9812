"""What the page may say: its claims, each checked over the draws that it hangs on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array, Claim, Draws, Judged, checked
from workbench.report.study import Stand

from .patterns import RANGE_1, SEEN, large_ones

TENTH = 0.1
ODDS = 100.0  # against an account, beyond its error, that exclude it
FEWEST = 5  # draws
LEFT = 0.05  # probability of an account that is still to be reckoned with

LINKAGES = (
    Claim(
        "spring_small",
        "a gas spring that the arm can hold changes joint 2's stiffness by less than a tenth of Table I",
        lambda n: n["share_of_table"] < TENTH,
    ),
)
FITS = (
    Claim(
        "no_spring_fits", "no gas spring of any strength fits Table I, p < 1 %", lambda n: n["fit_p"] < SEEN
    ),
)
MACHINES = (
    Claim("soft_short", "a soft gear makes less than Table I's range", lambda n: n["range_soft"] < RANGE_1),
    Claim("soft_seen", "the pairs' own residual shows a soft gear", lambda n: n["resid_soft"] < SEEN),
)
RISING = (
    Claim(
        "soft_against", "a soft gear runs against Table I where its angles rise", lambda n: n["r_soft"] < 0
    ),
)
FALLING = (
    Claim("soft_with", "a soft gear runs with Table I where its angles fall", lambda n: n["r_soft"] > 0),
)
DECIDING = (
    Claim("pairs_decide", "pairs read as absolute poses tell all machines", lambda n: n["apart_pairs"] == 1),
    Claim(
        "torque_decides", "three loads with motor torque tell all machines", lambda n: n["apart_torque"] == 1
    ),
)


def stands(
    numbers: Mapping[str, float],
    judged: Judged,
    linkages: Draws,
    machines: Draws,
    soft: Draws,
    deciding: Draws,
) -> dict[str, Stand]:
    """All claims of the page."""
    fits = only(linkages, np.isfinite(linkages.numbers["fit_p"]))
    rising, falling = (only(soft, large_ones(soft, sign)) for sign in (1, -1))
    each = (
        (LINKAGES, linkages), (FITS, fits), (MACHINES, machines), (RISING, rising), (FALLING, falling),
        (DECIDING, deciding),
    )  # fmt: skip
    found: dict[str, Stand] = {}
    for claims, draws in each:
        if draws.count < FEWEST:  # too few of these to say anything
            found |= {claim.name: Stand(claim.words, 0.0, 0, False) for claim in claims}
            continue
        middle = {name: float(np.median(column)) for name, column in draws.numbers.items()}
        found |= checked(claims, {**numbers, **middle}, draws)
    return found | checked(of_odds(judged), numbers)


def of_odds(judged: Judged) -> tuple[Claim, ...]:
    """Claims that hang on the odds of this run."""
    best = max(e.log10 for e in judged.evidence.values())

    def out(name: str) -> bool:
        found = judged.evidence[name]
        return bool(best - found.log10 > np.log10(ODDS) + found.error)

    left = [a.name for a in judged.accounts if judged.probabilities()[a.name] > LEFT]
    named = max(p for name, p in judged.probabilities().items() if name != "nameless")
    return (
        Claim("gas_out", "odds of 100 to 1 against a gas spring that the arm can hold", lambda _: out("gas")),
        Claim("several_left", "more than one account is left", lambda _: len(left) > 1),
        Claim("yardstick", "no named account beats a scatter without a name tenfold",
              lambda _: named < 10 * judged.probabilities()["nameless"]),
    )  # fmt: skip


def only(draws: Draws, at: Array) -> Draws:
    """Some of the draws; at: (D,) bool."""
    return Draws(
        draws.priors,
        {name: column[at] for name, column in draws.values.items()},
        {name: column[at] for name, column in draws.numbers.items()},
    )
