"""What the page says, as conditions on its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench import Array, Calibrated, Claim, Draws, Judged, calibrated

from .accounts import KINDS, WEIGHED
from .gains import ROBOTS
from .named import known
from .printed import ERRORS, GAIN

VARYING = [name for name in KINDS if name.endswith("varying")]
CONSTANT = [name for name in KINDS if name not in VARYING]
NO_GAIN = ("plain", "constant", "soft", "structure", "force")
SMOOTH = [name for name in CONSTANT if name not in NO_GAIN]  # springs constant, something smooth beside them
STANDINGS = (
    *(("varying", "largest"), ("plain", "agree"), ("constant", "agree")),
    *(("plain", "signs"), ("moment", "gains")),
)  # account and item that a claim asks for
RATIO = ERRORS["theory"][0] / ERRORS["constant"][0]
MISSED = 0.05  # of the draws as far out as the print, or fewer


def told(judged: Judged, weighed: Calibrated, draws: Draws, curve: Mapping[str, Draws]) -> dict[str, float]:
    """Numbers that the story and its claims ask for beside those of the accounts and the draws."""
    right = _right(judged)
    first = judged.first["varying"]
    return {
        "right_varying": float(max(right[name] for name in VARYING)),
        "right_bracket": float(right["bracket"]),
        "right_constant": float(max(right[name] for name in CONSTANT)),
        **_judged(judged, weighed),
        "largest_constant": _largest(judged),
        "account_reached": float(np.isfinite(first.predicted).all(axis=1).mean()),
        **_calibration(judged),
        **{f"share_worse_{name}": float((draws.numbers[f"worse_{name}"] > 1).mean()) for name in ROBOTS},
        **{f"share_gain_{name}": float((draws.numbers[f"gain_{name}"] > GAIN).mean()) for name in ROBOTS},
        **draws.middle,
        "share_twice": _share_twice(draws),
        "most_equal": max(float(draws.numbers[f"equal_{name}"].max()) for name in ROBOTS),
        **_named(curve),
    }


def again(judged: Judged) -> dict[str, float]:
    """What the claims of the accounts ask for."""
    return _judged(judged, calibrated(judged, WEIGHED)) | _calibration(judged)


def _judged(judged: Judged, weighed: Calibrated) -> dict[str, float]:
    """How many items accounts reproduce, how some stand at one, and the odds."""
    return {
        **{f"share_{name}_{item}": judged.standing(name, item).share for name, item in STANDINGS},
        "items": float(len(judged.items)),
        "right_most": float(max(_right(judged).values())),
        "gains_reproduced": float(sum(judged.standing(name, "gains").reproduced for name in NO_GAIN)),
        **_odds(weighed),
    }


def _right(judged: Judged) -> dict[str, int]:
    """How many items each account reproduces."""
    names = [item.name for item in judged.items]
    return {a.name: sum(judged.standing(a.name, n).reproduced for n in names) for a in judged.accounts}


def _odds(weighed: Calibrated) -> dict[str, float]:
    """Calibrated probabilities of one group of accounts against another, how often worlds of the two are
    told, and what was stated and what was right."""
    *_, before = weighed.stated(1.0)
    return {
        "p_varies": weighed.against(VARYING, CONSTANT),
        "told_varies": weighed.told(VARYING, CONSTANT),
        "p_smooth": weighed.against([*SMOOTH, *VARYING], NO_GAIN),
        "told_smooth": weighed.told([*SMOOTH, *VARYING], NO_GAIN),
        "temper": weighed.temper,
        "worlds": float(len(weighed.made)),
        "right_worlds": weighed.right,
        "sure_before": float(before[2]),
        "sure_right": before[3],
        "weighed": float(len(WEIGHED)),
    }


def _largest(judged: Judged) -> float:
    """Median of the largest error over the mean of constant stiffness, in the account of the same."""
    at = judged.columns("largest").start + 1
    return float(np.exp(np.nanmedian(judged.first["constant"].predicted[:, at])))


def _calibration(judged: Judged) -> dict[str, float]:
    """Shares of all accounts' draws in which calibrating lowers the error, and moves K2 to K5, as it does in
    print, by whether the measurements were the same or made anew."""
    print_, _ = judged.target
    by = {"step": np.log(RATIO), "moves": print_[judged.columns("step")][0]}
    columns = {"step": judged.columns("kinematics").start, "moves": judged.columns("step").start}
    made: dict[bool, list[Array]] = {True: [], False: []}
    for account in judged.accounts:
        one = judged.first[account.name]
        anew = one.shares[:, list(account.priors).index("again")] > 0.5
        good = np.isfinite(one.predicted).all(axis=1)
        for new in made:
            made[new].append(one.predicted[good & (anew == new)])
    return {
        f"share_{key}_{words}": float((np.vstack(made[new])[:, columns[key]] >= least).mean())
        for key, least in by.items()
        for new, words in ((False, "same"), (True, "anew"))
    }


def _share_twice(draws: Draws) -> float:
    """Of all robots' draws: the largest errors of 1 and of 2 cells print alike."""
    digit = 0.5e-4 / ERRORS["constant"][1]
    return float(np.mean([draws.numbers[f"twice_{name}"] < digit for name in ROBOTS]))


def _named(curve: Mapping[str, Draws]) -> dict[str, float]:
    """Robots by records and those whose soft zone was named; of all, how often its torque was small."""
    out = {f"named_{cut}": float(known(one, "named").sum()) for cut, one in curve.items()}
    out |= {f"robots_{cut}": float(known(one, "named").size) for cut, one in curve.items()}
    few = np.concatenate([known(one, "reverses") for one in curve.values()]) < 0.05
    found = np.concatenate([known(one, "found") for one in curve.values()])
    return out | {
        "robots": float(few.size),
        "rarely": float(few.sum()),
        "named_rarely": float(found[few].sum()),
    }


OF_ACCOUNTS: Sequence[Claim] = (
    Claim("undecided", "neither varying nor constant stiffness has 95 % against the other",
          lambda n: max(n["p_varies"], 1 - n["p_varies"]) < 0.95),
    Claim("smooth_decides", "accounts with a smooth error have 95 % against the others",
          lambda n: n["p_smooth"] > 0.95),
    Claim("too_sure", "uncalibrated odds of nine tenths are right in less than nine tenths",
          lambda n: n["sure_before"] > 0 and n["sure_right"] < 0.9),
    Claim("none_all", "no account reproduces all", lambda n: n["right_most"] < n["items"]),
    Claim("largest_missed", "the authors' account misses the largest error",
          lambda n: n["share_varying_largest"] <= MISSED),
    Claim("start_agrees", "the four K1 agree more often by a solver that keeps to its start",
          lambda n: n["share_plain_agree"] <= MISSED and n["share_constant_agree"] > n["share_plain_agree"]),
    Claim("plain_negative", "plain least squares print negative stiffnesses",
          lambda n: n["share_plain_signs"] <= MISSED),
    Claim("no_gain", "load known: constant stiffness, soft zone, bearings, misread force miss the gains",
          lambda n: n["gains_reproduced"] == 0),
    Claim("moment_enough", "constant stiffness with the moment left out reproduces the gains",
          lambda n: n["share_moment_gains"] > MISSED),
    Claim("step_by_chance", "what calibration gains comes about by chance in one draw of twenty",
          lambda n: max(n["share_step_same"], n["share_step_anew"]) > MISSED),
)  # fmt: skip
"""Of the accounts' draws, drawn again out of themselves."""

OF_RUN: Sequence[Claim] = (
    Claim(
        "equal_unexplained", "no robot prints K4 = K6 in as many cells",
        lambda n: n["most_equal"] < n["printed_equal"],
    ),
)  # fmt: skip
"""Of all draws of what cells gain together."""

OF_DRAWS: Sequence[Claim] = (
    Claim("cells_add_noise", "constant stiffness, known load: 128 cells predict worse than one set",
          lambda n: n["worse_constant"] > 1),
    Claim("constant_gains_little", "constant stiffness, known load: cells gain less than is printed",
          lambda n: n["gain_constant"] < GAIN),
    Claim("soft_gains_little", "a soft zone: cells gain less than is printed",
          lambda n: n["gain_soft"] < GAIN),
    Claim("structure_gains_little", "bearings and tool tilt: cells gain less than is printed",
          lambda n: n["gain_structure"] < GAIN),
)  # fmt: skip
"""Of each draw of what cells gain."""
