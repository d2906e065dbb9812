"""What bends: links of the printed stiffness, joints and bearings as assumed."""

from __future__ import annotations

import numpy as np

from workbench import Array, Robot, by_joint, deflection_budget, planned

from .arm import ARM
from .figures import Chapter, budget_figure
from .printed import TABLE_1, TABLE_2


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
    }
    return Chapter(numbers, {"budget": budget_figure(size_loaded, float(mean_mm(loaded.whole)))})


def mean_mm(moved: Array) -> Array:
    """Mean length [mm] of motions (N, ..., 3) [m] over the poses."""
    return np.asarray(1e3 * np.linalg.norm(moved, axis=-1).mean(axis=0))
