"""What would leave the printed error after calibration: one fault at a time, at the size that does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import brentq

from workbench import Array, Robot, deflection, planned, with_compliance, zeros_and_offsets
from workbench import denavit_hartenberg as dh

from .arm import ARM
from .figures import Chapter, left_figure
from .printed import AFTER, FITTED, JUDGED, TABLE_2, TABLE_3
from .tables import z_largest

FAULTS = {"compliance": (0.01, 1.0), "ratio": (1e-4, 1e-2), "twist": (1e-5, 1e-2), "noise": (1e-4, 5e-3)}


def what_leaves(assumed: Robot, seed: int, draws: int) -> Chapter:
    """The size of each fault that leaves the printed mean when d and θ alone are fitted.

    assumed: the robot with the compliance of its TOML.
    """

    def tried(fault: str, size: float) -> Array:
        """(draws, 2) [mm] before and after."""
        return np.array([one_fault(assumed, {fault: size}, [seed, k]) for k in range(draws)])

    def beyond(size: float, fault: str) -> float:
        return float(tried(fault, size)[:, 1].mean() - AFTER)

    numbers = {"draws_12": float(draws)}
    for fault, (low, high) in FAULTS.items():
        left = brentq(beyond, low, high, args=(fault,), rtol=0.01, xtol=low / 10)
        means = tried(fault, left)
        numbers |= {f"{fault}_leaves": left, f"{fault}_before_mm": means[:, 0].mean()}
        numbers |= {f"{fault}_scatter_mm": means[:, 1].std()}
    share = numbers["compliance_leaves"]
    full = tried("compliance", 1.0).mean(axis=0)
    yielding = tip_error(with_compliance(assumed, share), ARM.poses(1200, [seed, 4]))
    steps = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    left_by_step = [tried("compliance", step)[:, 1].mean() for step in steps]
    numbers |= {
        "share": share,
        "stiffer": 1 / share,
        "stiffness_2_kNm": 1e-3 * (assumed.joints[1].data.stiffness or np.inf) / share,
        "full_before_mm": full[0],
        "full_after_mm": full[1],
        "z_largest_yielding": z_largest(yielding),
        "twist_leaves_deg": float(np.degrees(numbers["twist_leaves"])),
        "noise_leaves_mm": 1e3 * numbers["noise_leaves"],
        "right_leaves_mm": float(left_by_step[0]),
    }
    return Chapter(numbers, {"left": left_figure(steps, left_by_step, share, AFTER)})


def tip_error(robot: Robot, q: Array) -> Array:
    """(N, 3) [m] Table III with its deflection minus Table II without, at the tip."""
    built = dh.with_rows(robot, TABLE_2, TABLE_3)
    sag = deflection(planned(built, q, targets=ARM.targets[:1]))[:, 0]
    return np.asarray(dh.chain(TABLE_3, q)[:, -1, :3, 3] - dh.chain(TABLE_2, q)[:, -1, :3, 3] + sag)


def one_fault(assumed: Robot, fault: Mapping[str, float], seed: Sequence[int]) -> tuple[float, float]:
    """Mean error [mm] on points that judge, before and after d and θ are fitted to others, with a fault."""
    rng, n = np.random.default_rng([*seed, 1]), len(TABLE_2)
    q = ARM.poses(FITTED + JUDGED, seed)
    true, rigid = with_compliance(assumed, fault.get("compliance", 0.0)), with_compliance(assumed, 0.0)
    ratio, sigma = fault.get("ratio", 0.0) * rng.normal(size=n), fault.get("noise", ARM.sigma)
    made = ARM.measured(true, q[:FITTED], [*seed, 2], ratio=ratio, sigma=sigma)
    judged = ARM.measured(true, q[FITTED:], [*seed, 3], ratio=ratio, sigma=sigma)
    known = np.column_stack([TABLE_2[:, 0], TABLE_3[:, 1:3], TABLE_2[:, 3]])
    known[:, 1] += fault.get("twist", 0.0) * rng.normal(size=n)
    before = zeros_and_offsets.identified(made, rigid, [])
    seen = zeros_and_offsets.with_ball(made, TABLE_3[-1, 2])
    after = zeros_and_offsets.identified(seen, dh.with_rows(rigid, TABLE_2, known))
    means = [float(zeros_and_offsets.error_lengths(fit, judged).mean()) for fit in (before, after)]
    return means[0], means[1]
