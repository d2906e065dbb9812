"""The bending of a link, as a compliance at its end."""

from __future__ import annotations

import numpy as np

from .kinematics import Array
from .rotations import skew


def bending_compliance(length: Array, section: Array | None = None) -> Array:
    """Compliance (6, 6) for EI = 1 N·m² of a cantilever that ends at a slot.

    `length`: (3,) [m] from the link's root to its end, on the slot's axes (`Arm.span`). section: (3, 3) from
    moment to curvature, across the link; None: alike in all directions. Bernoulli: the end moves by
    F l³/3EI + M l²/2EI and turns by F l²/2EI + M l/EI, across the link only.
    """
    reach = float(np.linalg.norm(length))
    out = np.zeros((6, 6))
    if reach < 1e-6:
        return out
    u = length / reach
    across = np.eye(3) - np.outer(u, u) if section is None else section
    by_force = across @ skew(u)  # the moment of a force: u × F per length
    out[:3, :3] = skew(u).T @ by_force * reach**3 / 3
    out[3:, 3:] = across * reach
    out[3:, :3] = by_force * reach**2 / 2
    out[:3, 3:] = out[3:, :3].T
    return out
