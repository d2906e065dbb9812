"""What the page says, as conditions on its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench import Claim, Draws, Judged

from .accounts import KINDS
from .gains import ROBOTS
from .named import known, share
from .printed import ERRORS, GAIN

VARYING = [name for name in KINDS if name.endswith("varying")]
CONSTANT = [name for name in KINDS if name not in VARYING]
NO_GAIN = ("plain", "constant", "soft", "structure", "force")
RATIO = ERRORS["theory"][0] / ERRORS["constant"][0]


def told(judged: Judged, draws: Draws, curve: Mapping[str, Draws]) -> dict[str, float]:
    """Numbers that the story and its claims ask for beside those of the accounts and the draws."""
    every = [judged.probabilities(), *(judged.probabilities(item.name) for item in judged.items)]
    authors = [sum(p[name] for name in VARYING) for p in every]
    right = {
        a.name: sum(judged.standing(a.name, i.name).reproduced for i in judged.items) for a in judged.accounts
    }
    log10 = {name: one.log10 for name, one in judged.evidence.items()}
    varies, constant = (max(some, key=lambda name: log10[name]) for some in (VARYING, CONSTANT))
    return {
        "items": float(len(judged.items)),
        "right_varying": float(max(right[name] for name in VARYING)),
        "right_constant": float(max(right[name] for name in CONSTANT)),
        "odds_constant": log10[constant] - log10[varies],
        "odds_error": max(judged.evidence[name].error for name in (constant, varies)),
        "p_authors": authors[0],
        "p_authors_least": min(authors),
        "p_authors_most": max(authors),
        "behind_plain_models": log10[varies] - max(log10[name] for name in NO_GAIN),
        "gains_reproduced": float(sum(judged.standing(name, "gains").reproduced for name in NO_GAIN)),
        "largest_constant": _largest(judged),
        "account_draws": float(len(judged.predicted["varying"])),
        "account_reached": float(np.isfinite(judged.predicted["varying"]).all(axis=1).mean()),
        **_calibration(judged),
        **{f"share_worse_{name}": float((draws.numbers[f"worse_{name}"] > 1).mean()) for name in ROBOTS},
        **{f"share_gain_{name}": float((draws.numbers[f"gain_{name}"] > GAIN).mean()) for name in ROBOTS},
        **{key: draws.range(key)[1] for key in draws.numbers},
        "share_twice": _share_twice(draws),
        "most_equal": max(float(draws.numbers[f"equal_{name}"].max()) for name in ROBOTS),
        **_named(curve),
    }


def _largest(judged: Judged) -> float:
    """Median of the largest error over the mean of constant stiffness, in the account of the same."""
    at = judged.columns("largest").start + 1
    return float(np.exp(np.nanmedian(judged.predicted["constant"][:, at])))


def _calibration(judged: Judged) -> dict[str, float]:
    """Shares of all accounts' draws in which calibrating gains what it does in print, by whether the
    measurements were the same or made anew."""
    at = judged.columns("kinematics").start
    gained: dict[bool, list[float]] = {True: [], False: []}
    for name, rows in judged.predicted.items():
        good = np.isfinite(rows).all(axis=1)
        for anew in gained:
            some = rows[good & ((judged.values[name]["again"] > 0.5) == anew), at]
            gained[anew] += (some >= np.log(RATIO)).tolist()
    return {"share_step_same": float(np.mean(gained[False])), "share_step_anew": float(np.mean(gained[True]))}


def _share_twice(draws: Draws) -> float:
    """Of all robots' draws: the largest errors of 1 and of 2 cells print alike."""
    digit = 0.5e-4 / ERRORS["constant"][1]
    return float(np.mean([draws.numbers[f"twice_{name}"] < digit for name in ROBOTS]))


def _named(curve: Mapping[str, Draws]) -> dict[str, float]:
    """Shares of the robots whose soft zone was named, by records; by how often its torque was small."""
    out = {f"named_{cut}": share(known(one, "named")) for cut, one in curve.items()}
    reverses = np.concatenate([known(one, "reverses") for one in curve.values()])
    found = np.concatenate([known(one, "found") for one in curve.values()])
    few = reverses < 0.05
    return out | {
        "named_rarely": share(found[few]),
        "share_rarely": share(few.astype(float)),
    }


CLAIMS: Sequence[Claim] = (
    Claim("not_shown", "constant stiffness does as well, to one item and to 100 : 1 or the error of the odds",
          lambda n: n["right_constant"] >= n["right_varying"] - 1
          and n["odds_constant"] > -max(2.0, n["odds_error"])),
    Claim("no_gain", "load known: constant stiffness, soft zone, bearings, misread force miss the gains",
          lambda n: n["gains_reproduced"] == 0),
    Claim("cells_add_noise", "constant stiffness, known load: 128 cells predict worse than one set",
          lambda n: n["worse_constant"] > 1),
    Claim("constant_gains_little", "constant stiffness, known load: cells gain less than is printed",
          lambda n: n["gain_constant"] < GAIN),
    Claim("soft_gains_little", "a soft zone: cells gain less than is printed",
          lambda n: n["gain_soft"] < GAIN),
    Claim("structure_gains_little", "bearings and tool tilt: cells gain less than is printed",
          lambda n: n["gain_structure"] < GAIN),
    Claim("step_by_chance", "what calibration gains comes about by chance in one draw of twenty",
          lambda n: max(n["share_step_same"], n["share_step_anew"]) > 0.05),
    Claim("equal_unexplained", "no robot prints K4 = K6 in as many cells",
          lambda n: n["most_equal"] < n["printed_equal"]),
)  # fmt: skip
