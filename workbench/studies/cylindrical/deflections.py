"""What forces do to the robot, for thousands of poses: Δt = J K⁻¹ Jᵀ w, linear in force and compliance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy.spatial import cKDTree

from workbench import Array, Target, load_pairs, load_robot, planned

from .printed import FORCE, TABLE_1

LENGTH = 0.5  # m, of link 2 in our model
STROKE = 0.5  # m, of joint 3 (Table 1)
GRAVITY = 9.80665
POOL = 4000
CIRCLE_RADIUS = 0.15  # m
HAND_TARGETS = [Target("E", (0.0, 0.0, 0.0), fixed=True)]


@dataclass(frozen=True, eq=False)
class Pool:
    """Random poses with their rows. reach, angle: (P,) [m, rad] of the tool; unit: (P, 3, 3, 3) [m/N] its
    motion per component of the force (last) and per joint's compliance over the true one (next to last)."""

    reach: Array
    angle: Array
    unit: Array

    def rows(self, which: Array, force: Array) -> Array:
        """(M, 3, 3) [m] of poses by number (M,) under forces (M, 3) or one (3,) [N]."""
        forces = np.broadcast_to(force, (len(which), 3))
        return np.asarray(np.einsum("pakf,pf->pak", self.unit[which], forces))

    def random(self, rng: np.random.Generator, count: int, length: float) -> Array:
        """(count,) poses within the strokes of a robot whose link 2 has this length [m]."""
        inside = np.flatnonzero((self.reach >= length) & (self.reach <= length + STROKE))
        return np.asarray(rng.choice(inside, count))

    def circle(self, centre: float) -> Array:
        """(24,) poses nearest to the circle about (centre, 0) [m]."""
        turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        x, y = centre + CIRCLE_RADIUS * np.cos(turn), CIRCLE_RADIUS * np.sin(turn)
        return self.nearest(np.hypot(x, y), np.arctan2(y, x))

    def nearest(self, reach: Array, angle: Array) -> Array:
        """(M,) poses nearest to places in the plane, reach and angle (M,) [m, rad]."""
        return np.asarray(self.places.query(_plane(reach, angle))[1])

    @cached_property
    def places(self) -> cKDTree:
        """Where the tool is, seen from above."""
        return cKDTree(_plane(self.reach, self.angle))

    def circle_error(self, centre: float, mass: float) -> float:
        """[m] mean over the circle under the load, with links of this mass [kg] that hang on joint 2."""
        pull = FORCE - np.array([0.0, 0.0, mass * GRAVITY])
        moved = self.rows(self.circle(centre), pull).sum(axis=2)
        return float(np.linalg.norm(moved, axis=1).mean())


def _plane(reach: Array, angle: Array) -> Array:
    return np.column_stack([reach * np.cos(angle), reach * np.sin(angle)])


@cache
def pool() -> Pool:
    """Poses of all reaches that are asked for; what a longer link 2 does, a longer stroke does as well."""
    rng = np.random.default_rng(0)
    q = rng.uniform([-np.pi, 0.0, -0.3], [np.pi, STROKE, 1.0], size=(POOL, 3))
    robot = load_robot("cylindrical")
    unit = []
    for force in np.eye(3):
        wrench = np.zeros((2 * POOL, 6))
        wrench[POOL:, :3] = force
        plan = planned(robot, np.tile(q, (2, 1)), targets=HAND_TARGETS, wrench=wrench)
        unit.append(load_pairs.difference_rows(plan))
    return Pool(LENGTH + q[:, 2], q[:, 0], np.stack(unit, axis=-1))


def least_squares(rows: Array, moved: Array, damping: float = 0.0, start: Array | None = None) -> Array:
    """(3,) stiffnesses from rows (M, 3, 3) and deflections (M, 3) [m] by eq. (9); with damping, one damped
    step from `start`, in the measure of the normal equations' own diagonal."""
    A = rows.reshape(-1, 3)
    normal, right = A.T @ A, A.T @ moved.ravel()
    k0 = np.zeros(3) if start is None else TABLE_1 / start
    held = damping * np.diag(np.diag(normal))
    return np.asarray(TABLE_1 / np.linalg.solve(normal + held, right + held @ k0))
