"""What the page may say: its claims, each checked over the draws that it hangs on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Claim, Draws, Judged, Stand, checked, redrawn

from .patterns import RANGE_1, SEEN, large_ones

TENTH = 0.1
ODDS = 100.0  # against an account, beyond its error, that exclude it

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
ODDS_SAY = (
    Claim(
        "gas_out",
        "odds of 100 to 1 against a gas spring that the arm can hold",
        lambda n: n["gas_is_out"] == 1,
    ),
    Claim(
        "soft_not_best",
        "another account has higher odds than a soft gear, beyond their error",
        lambda n: n["soft_is_behind"] == 1,
    ),
    Claim(
        "several_left", "more than one account is not excluded by odds of 100 to 1", lambda n: n["left"] > 1
    ),
    Claim(
        "yardstick", "no named account excludes a scatter without a name", lambda n: n["nameless_out"] == 0
    ),
)
"""Of the accounts' draws, drawn again out of themselves."""


def stands(
    numbers: Mapping[str, float],
    judged: Judged,
    linkages: Draws,
    machines: Draws,
    soft: Draws,
    deciding: Draws,
) -> dict[str, Stand]:
    """All claims of the page."""
    fits = linkages.only(np.isfinite(linkages.numbers["fit_p"]))
    rising, falling = (soft.only(large_ones(soft, sign)) for sign in (1, -1))
    each = (
        (LINKAGES, linkages), (FITS, fits), (MACHINES, machines), (RISING, rising), (FALLING, falling),
        (DECIDING, deciding),
    )  # fmt: skip
    found: dict[str, Stand] = {}
    for claims, draws in each:
        found |= checked(claims, {**numbers, **draws.middle}, draws)
    return found | checked(ODDS_SAY, {**numbers, **_odds(judged)}, redrawn(judged, _odds))


def _odds(judged: Judged) -> dict[str, float]:
    """What the claims of the odds ask for: accounts that are left, and whether some are out."""
    names = [a.name for a in judged.accounts]
    named = [name for name in names if name != "nameless"]
    return {
        "left": float(sum(not judged.excluded(name, ODDS) for name in names)),
        "gas_is_out": float(judged.excluded("gas", ODDS)),
        "soft_is_behind": float(judged.excluded("soft", 1.0)),
        "nameless_out": float(any(judged.excluded("nameless", ODDS, by=name) for name in named)),
    }
