"""What is not well along a path, by sample and reason: out of reach or range, too fast, near-singular."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..files.faults import Fault
from ..robot.description import Robot
from ..robot.kinematics import Arm, Array
from .check import sample_faults
from .follow import Range
from .inverse import DAMPING, Tip
from .paths import Path

SINGULAR = 0.02  # smallest singular value of the Jacobian, turns in rad and shifts in lengths of the tip


@dataclass(frozen=True)
class Trouble:
    """One thing that is not well at one sample.

    kind: "reach", "rest", "range", "velocity" or "singular"; the first three make the path impossible.
    """

    index: int
    kind: str
    what: str


def ranges_of(robot: Robot) -> Range:
    """The joints' limits."""
    return Range(*robot.limits.T)


def unreached(reached: NDArray[np.bool_], what: str, kind: str = "reach") -> list[Trouble]:
    """Samples that no joints were found for, or no rest of the loaded arm."""
    return [Trouble(int(i), kind, what) for i in np.flatnonzero(~reached)]


def out_of_range(robot: Robot, q: Array, what: str) -> list[Trouble]:
    """Samples at which a joint (N, n) would leave its range."""
    found = []
    limits = ranges_of(robot)
    for i, j in np.argwhere((q < limits.lower - 1e-9) | (q > limits.upper + 1e-9)):
        low = q[i, j] < limits.lower[j]
        limit = limits.lower[j] if low else limits.upper[j]
        scale, unit = (1e3, "mm") if robot.joints[j].kind == "prismatic" else (180 / np.pi, "deg")
        said = f"{what}: {robot.joints[j].name} at {q[i, j] * scale:.3f} {unit}"
        found.append(
            Trouble(int(i), "range", f"{said}, {'lower' if low else 'upper'} limit {limit * scale:.3f}")
        )
    return found


def too_fast(robot: Robot, q: Array, time: Array) -> list[Trouble]:
    """Samples that a joint reaches faster than its URDF allows."""
    speed = np.abs(np.diff(q, axis=0)) / np.diff(time)[:, None]
    found = []
    for i, j in np.argwhere(speed > np.array([joint.velocity for joint in robot.joints])):
        joint = robot.joints[j]
        scale, unit = (1e3, "mm/s") if joint.kind == "prismatic" else (180 / np.pi, "deg/s")
        said = f"{joint.name} at {speed[i, j] * scale:.3f} {unit}, limit {joint.velocity * scale:.3f}"
        found.append(Trouble(int(i) + 1, "velocity", said))
    return found


def near_singular(arm: Arm, tip: Tip, J: Array, first: int = 0) -> list[Trouble]:
    """Samples where some tool motion takes far more joint motion than elsewhere. J: (N, 6, n); first: the
    number of the first sample."""
    J = J[:, : tip.rows] / tip.length
    # the sum of 1/σ² over the singular values: only where it is large is the smallest one computed
    weak = np.einsum("kii->k", np.linalg.inv(J @ J.transpose(0, 2, 1) + DAMPING**2 * np.eye(tip.rows)))
    found = []
    for i in np.flatnonzero(weak > 1 / (SINGULAR**2 + DAMPING**2)):
        smallest, joints = _weakest(J[i])
        if smallest < SINGULAR:
            names = " and ".join(arm.names[j] for j in joints)
            found.append(
                Trouble(
                    first + int(i), "singular", f"near-singular ({smallest:.4f}): {names} move for little"
                )
            )
    return found


def _weakest(J: Array) -> tuple[float, Sequence[int]]:
    """Smallest singular value and the two joints that move most in its direction."""
    _, s, V = np.linalg.svd(J)
    k = min(J.shape) - 1
    return float(s[k]), sorted(np.argsort(-np.abs(V[k]))[:2].tolist())


def impossible(path: Path, troubles: Sequence[Trouble]) -> list[Fault]:
    """The faults of a path that cannot be run: per kind and joint, one per line, long runs counted."""
    faults: list[Fault] = []
    mends = {
        "reach": "move the path, or start in another posture (--start)",
        "rest": "check stiffness, masses, wrenches and effects of the model",
        "range": "move the path, or start in another posture (--start)",
    }
    for kind, mend in mends.items():
        here = [trouble for trouble in troubles if trouble.kind == kind]
        faults += sample_faults(path, [t.index for t in here], [t.what for t in here], mend)
    return faults
