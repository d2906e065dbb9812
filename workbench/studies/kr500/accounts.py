"""Accounts of the print: what the robot, its load and its solver may have been, through the paper's
whole protocol."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from workbench import Account, Array, InputError, Item, Prior

from . import laws, priors
from .printed import EQUATIONS, ERRORS, TABLE_1
from .summary import summary
from .tried import Tried, tried
from .worlds import Law, Values, both, world

ALLOWED = 0.1  # what an account idealises: of a ratio, in ln K, of a share
ITEMS = {
    "raw": ("Mean error by the load", "section 5.3"),
    "left": ("Left by constant stiffness", "section 5.3"),
    "gains": ("Left of that by 2, 16, 128 cells", "section 5.3"),
    "largest": ("Largest over mean error", "section 5.3"),
    "kinematics": ("Gain by calibration", "section 5.3"),
    "constant": ("K1 to K6", "equation (19)"),
    "step": ("Calibration moves K2 to K5", "equations (18) and (19)"),
    "halves": ("Halves apart: K2, K3, K5", "equations (20) and (21)"),
    "agree": ("The four K1 agree", "equations (18) to (21)"),
    "scatter": ("Scatter over 16 cells", "table 1"),
    "together": ("K2 with K3, K1 with K4", "table 1"),
    "ordered": ("Ordered in space", "table 1"),
    "signs": ("No negative K", "table 1"),
}
RATIOS = {"raw", "left", "gains", "largest", "kinematics", "constant", "agree", "scatter", "halves", "step"}
WEIGHED = ("raw", "left", "gains", "largest", "agree", "scatter")
"""Items of the odds, chosen before the print was held against a draw: how far the load bends, what each model
leaves, how uneven that is, whether K1 agrees, and how K scatters. The rest is in the tables alone."""
FINER = {"kinematics": 0.01, "gains": 0.03, "raw": 0.03, "left": 0.05, "largest": 0.05, "signs": 0.5}


def printed_summary() -> dict[str, Array]:
    K = {
        "theory": EQUATIONS["(18)"][None],
        "constant": EQUATIONS["(19)"][None],
        "2": np.array([EQUATIONS["(20)"], EQUATIONS["(21)"]]),
        "16": TABLE_1,
    }
    return summary(K, {key: (value[0], value[-1]) for key, value in ERRORS.items()})


def items() -> list[Item]:
    """All that accounts are judged by. Rounding of the print is far below what an account idealises."""
    print_ = printed_summary()
    return [
        Item(
            name,
            words,
            print_[name],
            FINER.get(name, ALLOWED) * (print_[name] if name in RATIOS else 1.0),
            place,
            name in RATIOS,
        )
        for name, (words, place) in ITEMS.items()
    ]


def predicted(
    law: Law, moment: bool, solver: str, values: Values, rng: np.random.Generator
) -> Mapping[str, Array]:
    """What the paper would have printed; NaN where the robot cannot reach the box."""
    try:
        w = world(values, rng)
    except InputError:
        return {key: np.nan * value for key, value in printed_summary().items()}
    return boiled(tried(w, both(w, law, moment), rng, solver))


def boiled(found: Tried) -> dict[str, Array]:
    return summary(found.K, {key: (e.mean(), e.max()) for key, e in found.errors.items()})


BASE, SOLVED = priors.CELL | priors.SPRINGS, priors.SOLVER
KINDS: Mapping[str, tuple[str, Mapping[str, Prior], Law, bool]] = {
    "plain": ("Constant stiffness, plain least squares", {}, laws.constant, True),
    "constant": ("Constant stiffness", SOLVED, laws.constant, True),
    "soft": ("Soft zone in joint 2 or 3", SOLVED | priors.SOFT, laws.soft_zone, True),
    "varying": ("Stiffness that varies (the authors’)", SOLVED | priors.VARYING, laws.varying, True),
    "structure": ("Bearings, foundation and tool tilt", SOLVED | priors.STRUCTURE, laws.structure, True),
    "bracket": ("The load shifts the SMR’s bracket", SOLVED | priors.BRACKET, laws.bracket, True),
    "force": ("The force is read wrong", SOLVED | priors.FORCE, laws.constant, True),
    "moment": ("Constant stiffness, moment left out", SOLVED, laws.constant, False),
    "moment_varying": ("Varying stiffness, moment left out", SOLVED | priors.VARYING, laws.varying, False),
    "moment_bracket": ("Bracket, and moment left out", SOLVED | priors.BRACKET, laws.bracket, False),
    "moment_force": ("Force read wrong, moment left out", SOLVED | priors.FORCE, laws.constant, False),
}
"""By name: words, free values, how the arm yields, whether the model knows where the load hangs."""


def accounts() -> list[Account]:
    return [
        Account(name, words, {**BASE, **own}, partial(predicted, law, moment, solver(name)))
        for name, (words, own, law, moment) in KINDS.items()
    ]


def solver(account: str) -> str:
    return "plain" if account == "plain" else "damped"
