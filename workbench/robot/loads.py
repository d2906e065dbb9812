"""What pulls on the arm, and the wrenches that it makes at every slot.

The wrench at slot k is what the part beyond the slot receives from gravity, payload, external wrench and
compensator, as generalised forces of the slot's six motions (N and N·m).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .compensator import CompensatorLaw
from .kinematics import Arm, Array, Frames
from .rotations import cross


@dataclass(frozen=True)
class Loads:
    """What pulls on the arm in N poses.

    mass: (N,) [kg], moment: (N, 3) [kg·m, flange frame] of tool and payload together; wrench:
    (N, 6) [N, N·m] on the robot at the flange origin, base frame; torque: (N, n) [N·m or N] extra
    axial torque on each joint (hose).
    """

    mass: Array
    moment: Array
    wrench: Array
    torque: Array
    compensator: CompensatorLaw | None = None


@dataclass(frozen=True)
class Wrenches:
    """Wrenches at all slots: local (N, S, 6), and the sums that their derivative needs.

    force, moment: (N, S, 3) in the base frame, the moment about the slot's origin. mass: (N, S),
    first: (N, S, 3) mass and first moment of mass about the slot's origin, of all beyond it.
    """

    local: Array
    force: Array
    moment: Array
    mass: Array
    first: Array


def wrenches(arm: Arm, where: Frames, loads: Loads) -> Wrenches:
    """Wrenches at all slots."""
    n_poses, slots = where.origin.shape[:2]
    # slot by slot in memory, as the frames are
    axes, origin = where.axes.transpose(1, 0, 2, 3), where.origin.transpose(1, 0, 2)
    mass, first = np.empty((slots, n_poses)), np.empty((slots, n_poses, 3))
    mass[-1] = loads.mass
    first[-1] = loads.mass[:, None] * where.p[-1] + (where.R[-1] @ loads.moment[..., None])[..., 0]
    for k in range(slots - 2, -1, -1):
        mass[k] = mass[k + 1] + arm.mass[k]
        turned = (where.R[k].reshape(-1, 3) @ arm.moment[k]).reshape(n_poses, 3)
        first[k] = first[k + 1] + arm.mass[k] * where.p[k] + turned
    first -= mass[..., None] * origin
    external = loads.wrench[:, :3]
    force = mass[..., None] * arm.gravity + external
    moment = cross(first, arm.gravity)
    if loads.wrench.any():
        moment += cross(where.p[-1] - origin, external) + loads.wrench[:, 3:]
    if (c := loads.compensator) is not None:
        a, u, s = c.ends(where)
        pull = c.force(s)[0][:, None] * u
        for k in range(c.body + 1, c.arm + 1):
            force[k] += pull
            moment[k] += cross(a - origin[k], pull)
    local = np.empty((slots, n_poses, 6))
    np.einsum("snci,sni->snc", axes[..., :3, :], force, out=local[..., :3])
    np.einsum("snci,sni->snc", axes[..., 3:, :], moment, out=local[..., 3:])
    slot, component = np.divmod(arm.axial, 6)
    local[slot, :, component] += loads.torque.T
    return Wrenches(*(x.swapaxes(0, 1) for x in (local, force, moment, mass, first)))
