"""How the arm of each account yields: wrenches of all slots (N, S, 6) → motions (N, S, 6)."""

from __future__ import annotations

import numpy as np

from workbench import Array, Problem

from .printed import MASS
from .worlds import GRAVITY, Values

AXIAL, TILT = 5, slice(3, 5)  # components of a slot: about its joint's axis, across it


def constant(values: Values, problem: Problem, wrench: Array) -> Array:
    """Springs of the joints, the same in all poses."""
    out = np.zeros_like(wrench)
    for j in range(1, 7):
        out[:, j, AXIAL] = wrench[:, j, AXIAL] / values[f"k{j}"]
    return out


def soft_zone(values: Values, problem: Problem, wrench: Array) -> Array:
    """And in joint 2 or 3 a x/√(1 + x²), x = torque / width, beside the spring."""
    out, j = constant(values, problem, wrench), 2 if values["soft_joint"] < 0.5 else 3
    x = wrench[:, j, AXIAL] / values["soft_width"]
    out[:, j, AXIAL] += values["soft_size"] * x / np.sqrt(1 + x**2)
    return out


def varying(values: Values, problem: Problem, wrench: Array) -> Array:
    """Springs whose stiffness varies with the joint's own angle: what the authors say."""
    out = constant(values, problem, wrench)
    for j in range(1, 7):
        angle = values["turns"] * problem.q[:, j - 1] + values[f"phase{j}"]
        out[:, j, AXIAL] *= np.exp(-values[f"swing{j}"] * np.sin(angle))
    return out


def structure(values: Values, problem: Problem, wrench: Array) -> Array:
    """And foundation, bearings, force sensor and tool tilt."""
    out = constant(values, problem, wrench)
    for slots, tilt in {
        (0,): values["foundation"],
        (1, 2, 3): values["tilt"],
        (4, 5, 6): values["tilt_wrist"],
        (7,): values["hand"],
    }.items():
        for slot in slots:
            out[:, slot, TILT] += tilt * wrench[:, slot, TILT]
    return out


def bracket(values: Values, problem: Problem, wrench: Array) -> Array:
    """And the bracket of the SMR shifts in the flange's frame, as far as weight hangs on it."""
    out = constant(values, problem, wrench)
    shift = np.array([values[f"shift_{axis}"] for axis in "xyz"])
    weight = np.linalg.norm(wrench[:, -1, :3], axis=1)
    out[:, -1, :3] += weight[:, None] / (MASS * GRAVITY) * shift
    return out
