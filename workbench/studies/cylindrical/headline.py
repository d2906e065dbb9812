"""What the page says, over draws of the poses and of what is not printed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import stats

from workbench import Array, Claim, Draws, Judged, StudyRun, by_joint, draw_many

from .accounts import ARM
from .deflections import GRAVITY, pool
from .printed import FORCE, POSES, SIGMA, TABLE_1, TABLE_2

OFF = TABLE_1 / TABLE_2 - 1  # of the printed compliances
CLEAR = float(stats.chi2.isf(1e-3, 3))

OF_DRAWS = (
    Claim(
        "far", "with the circle's load, the stated noise does not make Table 2", lambda n: n["chi2"] > CLEAR
    ),
    Claim(
        "millimetre",
        "the circle is half a millimetre to two off, with the links' weight and without",
        lambda n: 0.5 < n["circle_mm"] < 2.0 and 0.5 < n["bare_mm"] < 2.0,
    ),
    Claim("works", "Table 2 takes three quarters of the circle's error away", lambda n: n["left"] < 0.25),
)
"""Of each draw of poses, arm and circle."""

OF_RUN = (Claim("same", "without noise Table 1 comes back, to a hundredth", lambda n: n["without"] < 0.01),)
"""Of the numbers of this run: they hold in it or not."""

OF_ODDS = (
    Claim(
        "light",
        "the stated noise under a lighter load carries nine tenths of the odds",
        lambda n: n["p_light"] + n["p_random"] > 0.9,
    ),
    Claim(
        "hangs",
        "without the sentence on noise-free data a wrong lever and force are possible",
        lambda n: n["p_fault"] < 0.05 < n["p_fault_without_same"],
    ),
    Claim(
        "by_size",
        "without the size of the noise louder noise is possible",
        lambda n: n["p_louder"] < 0.05 < n["p_louder_without_noise"],
    ),
)
"""Of the accounts' draws, drawn again out of themselves."""


def odds(judged: Judged) -> dict[str, float]:
    """What the claims of the odds ask for."""
    found = {f"p_{name}": p for name, p in judged.probabilities().items()}
    for item, account in (("same", "fault"), ("noise", "louder")):
        found[f"p_{account}_without_{item}"] = judged.probabilities(item)[account]
    return found


def draws(run: StudyRun) -> Draws:
    """`chi2` of the printed errors under the circle's load, and what follows from it, by draw."""
    return draw_many(one, ARM, run.draws(400, 60), run)


def one(values: Mapping[str, float], seed: int) -> dict[str, float]:
    """One draw of poses, arm and circle."""
    arm, rng = pool(), np.random.default_rng(seed)
    A = arm.rows(arm.random(rng, POSES, values["length"]), FORCE).reshape(-1, 3)
    centre = values["centre"] * (values["length"] + 0.25)
    weight = np.array([0.0, 0.0, values["mass"] * GRAVITY])
    rows = arm.rows(arm.circle(centre), FORCE - weight)
    left = np.linalg.norm(rows @ (1 - TABLE_1 / TABLE_2), axis=1).mean()
    whole = np.linalg.norm(rows.sum(axis=2), axis=1).mean()
    return {
        **in_sigma(A),
        "circle_mm": 1e3 * arm.circle_error(centre, values["mass"]),
        "bare_mm": 1e3 * arm.circle_error(centre, 0.0),
        "left_mm": 1e3 * float(left),
        "left": float(left / whole),
    }


def in_sigma(A: Array) -> dict[str, float]:
    """What the stated noise makes of each compliance with rows A (M, 3), and how far off the print is."""
    bound = SIGMA * np.sqrt(np.diag(np.linalg.inv(A.T @ A)))
    chi2 = float(OFF @ A.T @ A @ OFF) / SIGMA**2
    return {
        **by_joint("bound", bound),
        "bound_least": float(bound.min()),
        "bound_most": float(bound.max()),
        **by_joint("printed", abs(OFF) / bound, "_sigma"),
        "chi2": chi2,
        "lighter": float(np.sqrt(chi2 / 3)),
    }
