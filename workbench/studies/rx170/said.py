"""What the page says of Table II and of our closed loop, as conditions on its numbers."""

from __future__ import annotations

from scipy import stats

from workbench import Claim, Judged

RUNS_OUT = float(stats.chi2.isf(1e-3, 2))  # of a line more
OF_RUN = (
    Claim(
        "constant", "nine tenths of the first Ra are a constant height", lambda n: n["constant_share"] > 0.9
    ),
    Claim(
        "each_step",
        "in closed loop each correction lowers Ra and Rz, from where the others sag to",
        lambda n: (
            n["ra_none_slow"] > n["ra_stiffness_slow"] > n["ra_both_slow"]
            and n["rz_none_slow"] > n["rz_stiffness_slow"] > n["rz_both_slow"]
        ),
    ),
    Claim(
        "base_higher",
        "from the base Ra ends higher than from where the others sag to",
        lambda n: n["ra_base_both_slow"] > n["ra_both_slow"],
    ),
    Claim(
        "line_sharp",
        "the place of the strongest line is known ten times better than lines are apart",
        lambda n: n["order_half"] < 0.1 * n["width"],
    ),
    Claim(
        "takes_for_granted",
        "the interval from the sweep alone grows by half when the gear may run out, and fits better",
        lambda n: (
            n["alone_once_half"] > 1.5 * n["alone_lines_half"]
            and n["alone_lines_chi2"] - n["alone_once_chi2"] > RUNS_OUT
        ),
    ),
    Claim(
        "inertia",
        "ten times as fast a perfect model leaves more than the gear of joint 2 makes",
        lambda n: n["rz_perfect_fast"] > n["gear_joint_2_pv"],
    ),
    Claim(
        "servo_free",
        "at the slow speed all joints corrected leave less than joint 2 corrected, a perfect model less",
        lambda n: n["rz_both_slow"] > n["rz_all_slow"] > n["rz_perfect_slow"],
    ),
    Claim(
        "fast_left",
        "ten times as fast the corrections lower Rz, by less than at the slow speed",
        lambda n: 1 > n["rz_both_fast"] / n["rz_none_fast"] > n["rz_both_slow"] / n["rz_none_slow"],
    ),
)
"""Of the numbers of this run: they hold in it or not."""

OF_DRAWS = (Claim("deeper", "the corrections lower Ra more than Rz", lambda n: n["ra_gain"] < n["rz_gain"]),)
"""Of each draw of what is assumed."""

OF_ODDS = (
    Claim(
        "fixed",
        "z = 0 is neither each run's mean nor its best plane",
        lambda n: n["p_mean"] + n["p_level"] < 0.01,
    ),
    Claim(
        "open",
        "Table II does not tell a joint 2 that errs alone from other joints whose sag lies in the zero",
        lambda n: max(n["p_own"], n["p_sagging"]) < 0.95 * (n["p_own"] + n["p_sagging"]),
    ),
    Claim(
        "still",
        "counted from the base, the other joints would yield less than a quarter of our model's",
        lambda n: n["base_sag_high"] <= 0.25,
    ),
    Claim(
        "yielding",
        "counted from the base, the other joints may yield a quarter of our model's or more",
        lambda n: n["base_sag_high"] > 0.25,
    ),
)
"""Of the accounts' draws, drawn again out of themselves."""


def odds(judged: Judged) -> dict[str, float]:
    """What the claims of the odds ask for."""
    found = {f"p_{name}": p for name, p in judged.probabilities().items()}
    return found | {"base_sag_high": judged.needed("base", "sag")[2]}
