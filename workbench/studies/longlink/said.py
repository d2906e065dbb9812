"""What the page may say: its claims, each checked over the draws that it hangs on."""

from __future__ import annotations

from collections.abc import Mapping

from workbench import Claim, Draws, Judged, Stand, checked, redrawn

from .circular import HALF_ALPHA
from .printed import BEFORE
from .stories import OWN

ODDS = 100.0  # to the best account, beyond their errors, that exclude an account

ARMS = (
    Claim("circular", "of an arm that only sags, the fitted table makes four fifths or more of the error",
          lambda n: n["share_sag"] > 0.8),
    Claim("alpha_tells", "no sag makes half of the printed twist α₁",
          lambda n: max(abs(n["alpha_1_sag"]), abs(n["alpha_1_free"])) < HALF_ALPHA),
)  # fmt: skip
HIDDEN = (
    Claim(
        "two_finds",
        "25 points without and with a payload find a softer joint 6",
        lambda n: n["found_two"] == 1,
    ),
    Claim("one_misses", "25 unloaded points do not find it", lambda n: n["found_one"] == 0),
)
ODDS_SAY = (
    Claim(
        "several_left", "more than one account is not excluded by odds of 100 to 1", lambda n: n["left"] > 1
    ),
    Claim("odds_too", "odds of 100 to 1 exclude sag alone", lambda n: n["sag_left"] == 0),
)
"""Of the accounts' draws, drawn again out of themselves."""


def stands(numbers: Mapping[str, float], judged: Judged, arms: Draws, hidden: Draws) -> dict[str, Stand]:
    """All claims of the page."""
    found: dict[str, Stand] = {}
    for claims, draws in ((ARMS, arms), (HIDDEN, hidden)):
        found |= checked(claims, {**numbers, **draws.middle}, draws)
    found |= checked(ODDS_SAY, {**numbers, **_odds(judged)}, redrawn(judged, _odds))
    return found | checked(of_run(), numbers)


def _odds(judged: Judged) -> dict[str, float]:
    """Accounts that are left, and whether sag alone is one of them."""
    left = [name for name in OWN if not judged.excluded(name, ODDS)]
    return {"left": float(len(left)), "sag_left": float("sag" in left)}


def of_run() -> tuple[Claim, ...]:
    """Claims on the numbers of this run alone."""
    return (
        Claim("tables_near", "at ±90° the tables differ by the printed error, within two standard deviations",
              lambda n: abs(n["away_90"]) < 2),
        Claim("links_stiff", "links of the printed stiffness bend by less than a hundredth of the error",
              lambda n: n["bending_loaded_mm"] < 0.01 * BEFORE),
        Claim("once_enough", "(26) once leaves less than a tenth where the compliance is known",
              lambda n: n["known_once_mm"] < 0.1 * n["known_none_mm"]),
        Claim("driven_too", "driven in closed loop (26) leaves less than a tenth as well",
              lambda n: n["driven_once_mm"] < 0.1 * n["driven_none_mm"]),
        Claim("z_hints", "z is the largest in a stiff arm less often than in one that yields as well",
              lambda n: n["z_odds"] > 1),
        Claim("take_out", "deflection left in circle points shifts lengths by more than their interval",
              lambda n: n["bias_a_mm"] > n["half_a_mm"]),
        Claim("rigid_shown", "joints taken as rigid leave three times the noise on held-out poses",
              lambda n: n["rigid_heldout_mm"] > 3 * n["noise_mean_mm"]),
        Claim("names_unsure", "of the causes named with joints taken as rigid one is no joint or bearing",
              lambda n: n["rigid_right"] < n["rigid_causes"]),
        Claim("sag_in_zeros", "joints taken as rigid turn θ₂ and θ₃ downwards, as printed",
              lambda n: n["sag_2_deg"] > 0 and n["sag_3_deg"] > 0),
    )  # fmt: skip
