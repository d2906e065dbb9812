"""The RX170's spiral, drawn in closed loop: R_a and R_z of every command, and what the printed ones hold.

Where z = 0 is, the paper does not say. Here it is where the tool would run on average if joint 2 had no
error: then the corrections of joint 2 alone can bring R_a down as far as the printed ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import stats

from workbench import Array, Path, Robot, Shown, planned, problem_of

from .causes import one_cause_each, standing_error
from .draw import Drawn, draw_corrected
from .heights import heights, least_mean
from .printed import SPEED, TABLE_1, TABLE_2
from .superposed import ELBOW_UP, spiral_at

Numbers = dict[str, float]
CORRECTIONS = {
    "none": "Without correction",
    "stiffness": "Stiffness correction",
    "both": "Stiffness and kinematic correction",
    "all": "All joints corrected",
    "perfect": "A perfect model",
}
SLOW, FAST = SPEED, 0.3  # m/s; at the printed acceleration, and at ten times that
# not in the paper
AWAY, SPACING = 1.0, 3e-4  # m, of the spiral from axis 1, and between samples
ALONG = 1e-5  # m, noise of the tracker per reading along the path


@dataclass(frozen=True, eq=False)
class Spirals:
    """The slow path, its run and the fast one; causes: cause → (N,) [m] height that it alone makes of the
    slow path, standing."""

    path: Path
    slow: Drawn
    fast: Drawn
    causes: Mapping[str, Array]

    @property
    def zero(self) -> float:
        """Height from which R_a counts [m]."""
        return float(self.causes["others"].mean())

    @property
    def shown(self) -> Shown:
        """The slow run in space."""
        error = {CORRECTIONS[key]: e for key, e in self.slow.error.items()}
        return Shown(self.slow.q[len(self.slow.q) // 2], self.slow.wanted, error, noise=ALONG)


def draw_spirals(
    truth: Robot,
    robot: Robot,
    beliefs: Mapping[str, Robot],
    turns: int,
    workers: int,
    progress: Callable[[str], None],
) -> Spirals:
    """The spiral at both speeds, uncorrected and corrected by each belief; what each cause makes of it."""
    slow, fast = (spiral_at(AWAY, speed, turns, SPACING) for speed in (SLOW, FAST))
    drawn = draw_corrected(truth, robot, [slow, fast], beliefs, ELBOW_UP, workers, progress)
    single = one_cause_each(truth, "joint_2")
    causes = {key: standing_error(one, slow, ELBOW_UP)[:, 2] for key, one in single.items()}
    return Spirals(
        slow, drawn[0], drawn[1], {**causes, "others": causes["yield_others"] + causes["gear_others"]}
    )


def spiral_numbers(spirals: Spirals, seed: int) -> Numbers:
    """R_a and R_z of every command at both speeds [mm]; mean and span of what each cause does to z [mm]."""
    rng = np.random.default_rng([seed, 13])
    numbers: Numbers = {}
    for speed, run in {"slow": spirals.slow, "fast": spirals.fast}.items():
        for name, error in run.error.items():
            found = heights(run.wanted, error, spirals.zero, ALONG * rng.normal(size=len(error)))
            numbers |= {f"{key}_{name}_{speed}": value for key, value in found.items()}
    for key, z in spirals.causes.items():
        numbers |= {f"{key}_mean": float(1e3 * z.mean()), f"{key}_pv": float(1e3 * np.ptp(z))}
    gains = {f"{r}_gain": numbers[f"{r}_both_slow"] / numbers[f"{r}_none_slow"] for r in ("ra", "rz")}
    return numbers | gains | {"lowered": -numbers["yield_others_mean"]}


def printed_numbers(robot: Robot, spirals: Spirals) -> Numbers:
    """What the printed R_a and R_z say by themselves."""
    run = spirals.slow
    problem = problem_of(planned(robot, run.q[len(run.q) // 2][None], targets=()))
    where = problem.rigid
    lever = float(np.linalg.norm((where.p[-1, 0] - where.origin[0, 3])[:2]))  # joint 3 to tool
    span = 2 * float(stats.norm.isf(0.56 / len(run.q)))  # in σ, of as many readings as samples (Blom)
    (ra, *_, ra_both), (rz, *_, rz_both) = TABLE_2["ra"], TABLE_2["rz"]
    constant = least_mean(ra, rz)
    return {
        "constant": constant,
        "constant_share": constant / ra,
        "torque_3_printed": 1e-3 * ra_both / lever * TABLE_1[2],
        "torque_3_ours": float(abs(problem.nominal_load.local.ravel()[problem.arm.axial[2]])),
        "noise_most": 1e3 * rz_both / span,
        "noise_ours": 1e6 * ALONG,
        "samples": float(len(run.q)),
    }
