"""What bends: links of the printed stiffness, joints and bearings as assumed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array, Robot, by_joint, deflection_budget, planned, problem_of

from .arm import ARM
from .figures import Chapter, budget_figure
from .printed import TABLE_1, TABLE_2

BEARING_SHARES = (0.25, 0.5, 0.75, 1.0)  # d₁/(d₁ + d₂)


def what_bends(robot: Robot, seed: int, count: int) -> Chapter:
    """Motion of the tip by joint, bearing and link, in so many random poses."""
    plan = planned(robot, ARM.poses(count, seed), targets=ARM.targets[:1], payloads=ARM.payloads)
    own, loaded = (
        deflection_budget(plan.with_poses(payload=np.full_like(plan.poses.payload, k))) for k in (0, 1)
    )
    size, size_loaded = ({kind: mean_mm(part) for kind, part in b.parts.items()} for b in (own, loaded))
    length = TABLE_2[:, 2:].max(axis=1)
    printed = 1e3 * own.moment.max(axis=0) * length**2 / 3 / TABLE_1  # eq. (21)
    numbers = {
        **by_joint("eq21_um", 1e3 * printed),
        **by_joint("link_own_um", 1e3 * size["link"]),
        **by_joint("link_loaded_um", 1e3 * size_loaded["link"]),
        **by_joint("torsion_mm", size["torsion"]),
        **by_joint("overturning_mm", size["overturning"]),
        "bending_own_mm": float(mean_mm(own.parts["link"].sum(axis=1))),
        "bending_loaded_mm": float(mean_mm(loaded.parts["link"].sum(axis=1))),
        "bending_eq21_mm": float(printed.max()),
        "sag_mm": float(mean_mm(own.whole)),
        "link_7_um": 1e6 * last_link(robot),
        **{f"sag_share_{int(100 * share)}_mm": shared(own.parts, share) for share in BEARING_SHARES},
    }
    return Chapter(numbers, {"budget": budget_figure(size_loaded, float(mean_mm(loaded.whole)))})


def last_link(robot: Robot) -> float:
    """Deflection [m] of link 7's end by its own weight, held level: a cantilever with an even load, w = m g
    l³/8EI."""
    arm = problem_of(planned(robot, np.zeros((1, 7)))).arm
    length, stiffness = float(TABLE_2[6, 3]), TABLE_1[6]
    return float(arm.mass[7] * np.linalg.norm(arm.gravity) * length**3 / (8 * stiffness))


def shared(parts: Mapping[str, Array], share: float) -> float:
    """Mean motion [mm] of the tip where the reducer takes this share d₁/(d₁ + d₂) of the overturning, eqs.
    (14), (15)."""
    moved = parts["torsion"] + share * parts["overturning"] + parts["link"]
    return float(mean_mm(moved.sum(axis=1)))


def mean_mm(moved: Array) -> Array:
    """Mean length [mm] of motions (N, ..., 3) [m] over the poses."""
    return np.asarray(1e3 * np.linalg.norm(moved, axis=-1).mean(axis=0))
