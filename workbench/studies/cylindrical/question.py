"""What would make the printed errors: how much noise, or which fault."""

from __future__ import annotations

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from workbench import Array, Campaign, Truth, by_joint, load_pairs, simulate

from .printed import POSES, SIGMA, TABLE_1, TABLE_2

IN_BASE = np.eye(3)[None], np.zeros((1, 3))  # an instrument that stands in the robot's base


def expected(plan: Campaign) -> Array:
    """(3 · POSES, 3) [m] eq. (7): deflections per relative compliance, as the program expects them."""
    return load_pairs.difference_rows(plan).reshape(-1, 3)


def noise_needed(plan: Campaign, seed: int, draws: int) -> dict[str, float]:
    """What the stated noise makes of each compliance, and the noise that the printed errors would need."""
    A = expected(plan)
    bound = SIGMA * np.sqrt(np.diag(np.linalg.inv(A.T @ A)))
    off = TABLE_1 / TABLE_2 - 1  # of the printed compliances
    chi2 = float(off @ A.T @ A @ off) / SIGMA**2
    needed = SIGMA * float(np.sqrt(chi2 / 3))
    noise = np.random.default_rng([seed, 1]).normal(scale=needed, size=(len(A), draws))
    spread = np.std(1 / (1 + np.linalg.lstsq(A, noise)[0]), axis=1)
    return {
        **by_joint("printed", abs(off) / bound, "_sigma"),
        **by_joint("bound", bound),
        **by_joint("spread", spread),
        "printed_off_in_sigma": float((abs(off) / bound).max()),
        "printed_chi2": chi2,
        "printed_p": float(stats.chi2.sf(chi2, 3)),
        "noise_needed_mm": 1e3 * needed,
        "noise_over_stated": needed / SIGMA,
    }


def explained(name: str, plan: Campaign, which: tuple[bool, bool]) -> dict[str, float]:
    """The fault that comes nearest to the printed errors, its errors, and what its fit leaves.

    Link 2 is longer, the force smaller, than the program has them, by what `which` leaves free.
    """
    A, free = expected(plan), np.flatnonzero(which)

    def made(size: Array) -> tuple[Array, float]:
        length, force = np.bincount(free, size, minlength=2)
        geometry = np.zeros((5, 6))
        geometry[3, 2] = length  # joint 3 slides along its z
        load = plan.with_poses(wrench=(1 - force) * plan.poses.wrench)
        p = simulate(load, Truth(geometry=geometry), instrument=IN_BASE).points[:, 0]
        moved = (p[POSES:] - p[:POSES]).ravel()
        k = np.linalg.lstsq(A, moved)[0]  # eq. (9)
        return 1 / k - 1, float(np.sqrt(np.mean((moved - A @ k) ** 2)))

    def missed(size: Array) -> Array:
        return made(size)[0] - (TABLE_2 / TABLE_1 - 1)

    best = least_squares(missed, np.full(len(free), 0.01)).x
    length, force = np.bincount(free, best, minlength=2)
    errors, residual = made(best)
    return {
        **by_joint(name, errors, "_off"),
        f"{name}_length_mm": 1e3 * length,
        f"{name}_force": force,
        f"{name}_residual_mm": 1e3 * float(np.hypot(residual, SIGMA)),
        f"{name}_residual_p": float(stats.chi2.sf(len(A) * (1 + (residual / SIGMA) ** 2), len(A) - 3)),
    }
