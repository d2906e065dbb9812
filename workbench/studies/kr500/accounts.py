"""Accounts of the print: what the robot, its load and its solver may have been, through the paper's whole protocol."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from workbench import Array, InputError

from ..accounts import Account, Item
from . import laws, priors, springs
from .printed import CUTS, EQUATIONS, ERRORS, TABLE_1
from .summary import summary
from .worlds import Law, Poses, Values, World, posed, world

PLACES = {
    "raw": ("Mean error by the load", 0.00005, "section 5.3"),
    "left": ("What constant stiffness leaves of it", 0.0004, "section 5.3"),
    "gains": ("What 2, 16 and 128 cells leave of that", 0.0007, "section 5.3"),
    "largest": ("Largest errors over the means", 0.001, "section 5.3"),
    "kinematics": ("Nominal over calibrated kinematics", 0.001, "section 5.3"),
    "constant": ("K1 to K6 of all", 0.005, "equation (19)"),
    "step": ("What calibration changes of K2 to K5", 0.003, "equations (18) and (19)"),
    "halves": ("How the two halves differ, K2, K3, K5", 0.003, "equations (20) and (21)"),
    "agree": ("Four K1 agree", 0.002, "equations (18) to (21)"),
    "scatter": ("Scatter of K over 16 cells", 0.003, "table 1"),
    "together": ("K2 against K3, K1 with K4", 0.005, "table 1"),
    "ordered": ("K ordered in space", 0.005, "table 1"),
    "signs": ("No negative K", 0.5, "table 1"),
    "equal": ("K4 = K6 in five cells", 0.5, "table 1"),
}
RATIOS = {"raw", "left", "gains", "kinematics", "constant", "agree", "scatter", "largest"}
RELATIVE = {"constant", "agree", "scatter"}  # rounding is a share of the number


def printed_summary() -> dict[str, Array]:
    K = {
        "theory": EQUATIONS["(18)"][None],
        "constant": EQUATIONS["(19)"][None],
        "2": np.array([EQUATIONS["(20)"], EQUATIONS["(21)"]]),
        "16": TABLE_1,
    }
    return summary(K, {key: (value[0], value[-1]) for key, value in ERRORS.items()})


def items() -> list[Item]:
    """All that accounts are judged by; the uncertainty is that of rounding."""
    out = []
    for name, value in printed_summary().items():
        words, sd, place = PLACES[name]
        sd = sd * np.abs(value) if name in RELATIVE else sd
        out.append(Item(name, words, value, sd, place, name in RATIOS))
    return out


def experiment(
    values: Values, rng: np.random.Generator, law: Law, moment: bool, solver: str
) -> tuple[dict[str, Array], dict[str, Array]]:
    """The paper's protocol in one world: K (C, n) [N·m/rad] and errors (M,) [mm] at the verification points, of
    each model. Raises `InputError` where the robot cannot reach the box."""
    w = world(values, rng)
    grid, check = (posed(w, problem, law, moment) for problem in (w.grid, w.check))
    return identified_and_verified(w, grid, check, rng, solver)


def identified_and_verified(
    w: World, grid: Poses, check: Poses, rng: np.random.Generator, solver: str
) -> tuple[dict[str, Array], dict[str, Array]]:
    values, solve = w.values, {"plain": springs.plain, "damped": springs.damped}[solver]
    read = grid.read(values, rng)
    first = springs.normal(grid.columns(values, False, rng), read)
    again = grid.read(values, rng) if values["again"] > 0.5 else read
    then = springs.normal(grid.columns(values, True, rng), again)
    smr = w.check.stated_targets[0]
    half = len(w.check.q) // 2
    points = w.check.rigid.points(smr[None], [7])[:half, 0]
    found = {}
    for key in ("theory", *CUTS):
        cut = w.cuts["constant" if key == "theory" else key]
        used = springs.summed(first if key == "theory" else then, springs.poses_of(cut, w.cuts["128"]))
        found[key] = solve(used, values)
    errors = {"raw": norm(check.read(values, rng))}
    for key, c in found.items():
        cut = w.cuts["constant" if key == "theory" else key]
        here = springs.of_points(points, w.box, cut, c)
        told = (check.columns(values, key != "theory", rng) @ here[:, :, None])[:, :, 0]
        errors[key] = norm(check.read(values, rng) - told)
    return {key: 1 / c for key, c in found.items()}, errors


def norm(vectors: Array) -> Array:
    """(M,) [mm] equation (22)."""
    return np.asarray(1e3 * np.linalg.norm(vectors, axis=1))


def predicted(
    law: Law, moment: bool, solver: str, values: Values, rng: np.random.Generator
) -> Mapping[str, Array]:
    """What the paper would have printed."""
    try:
        K, errors = experiment(values, rng, law, moment, solver)
    except InputError:
        return {key: np.nan * value for key, value in printed_summary().items()}
    return summary(K, {key: (e.mean(), e.max()) for key, e in errors.items()})


BASE = priors.CELL | priors.SPRINGS
SOLVED = priors.SOLVER
VARIED, BUILT = SOLVED | priors.VARYING, SOLVED | priors.STRUCTURE
KINDS = {
    "plain": ("Constant stiffness, plain least squares", {}, laws.constant, True, "plain"),
    "constant": ("Constant stiffness", SOLVED, laws.constant, True, "damped"),
    "soft": ("A soft zone in joint 2 or 3", SOLVED | priors.SOFT, laws.soft_zone, True, "damped"),
    "varying": ("Stiffness that varies (the authors’)", VARIED, laws.varying, True, "damped"),
    "structure": ("Bearings, foundation and tool tilt", BUILT, laws.structure, True, "damped"),
    "bracket": ("The load shifts the SMR's bracket", SOLVED | priors.BRACKET, laws.bracket, True, "damped"),
    "force": ("The force is read wrong", SOLVED | priors.FORCE, laws.constant, True, "damped"),
    "moment": ("The load's moment is left out", SOLVED, laws.constant, False, "damped"),
    "both": ("Moment left out and stiffness that varies", VARIED, laws.varying, False, "damped"),
}


def accounts() -> list[Account]:
    return [
        Account(name, words, BASE | own, partial(predicted, law, moment, solver))
        for name, (words, own, law, moment, solver) in KINDS.items()
    ]
