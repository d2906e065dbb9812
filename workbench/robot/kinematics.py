"""The arm as arrays: kinematics of thousands of poses at a time, and the derivative of a point
with respect to every small motion of every frame.

X_AB is the pose of frame B in frame A, p_AoBo_A the way from A's origin to B's on the axes of A, as Drake
writes them. W is the world, which the robot's base is welded to. The arrays come from the Context of the
rigid twin (`rigid_plant.arrays`), once.

A *slot* is a place of the chain where something may move, from W to the flange:

    slot 0        the base            (foundation, drift)
    slot 1 .. n   the joints          (slot k sits between links k - 1 and k, its z along the axis)
    slot n + 1    the flange          (bending of the last link, tool)

Behind slot k comes frame L_k, of the link that it carries (L_0 base, L_n+1 flange, L_-1 the world):

    X_WL(k) = X_WL(k-1) · X_LS(k) · G(k) · T(k) · J(k)

    X_LS   nominal pose of the slot in the link before it
    G = Trans(tx, ty, tz) Rx Ry Rz        constant: what calibration corrects
    T = Trans(tx, ty, tz) Rx Ry Rz        per pose: transmission, load, temperature
    J = Rz(q), or Trans(0, 0, q) for a sliding joint (then T's tz comes after its rotations).

The six components of a motion are numbered tx ty tz rx ry rz (`TX` ... `RZ`); the axial one is rz (revolute)
or tz (prismatic). A column 6 · slot + component names one motion of the arm. L_k is the URDF's link frame,
turned so that z is the joint's axis (`Arm.R_link`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .rotations import body_jacobian, from_xyz, xyz_angles

Array = NDArray[np.float64]
TX, TY, TZ, RX, RY, RZ = range(6)


@dataclass(frozen=True)
class Arm:
    """Arrays of a serial arm with n joints and S = n + 2 slots.

    prismatic: (n,) bool. R: (S, 3, 3), p: (S, 3) [m] nominal pose X_LS of each slot in its parent link.
    geometry: (S, 6) [m, rad] corrections G; only the rows of joints are used.
    mass: (n + 1,) [kg] and moment: (n + 1, 3) [kg·m] = mass times centre of mass, of the base and
    the links, in their frames L; inertia: (n + 1, 3, 3) [kg·m²] about the frame's origin. R_link:
    (S, 3, 3) rotation of the URDF's link frame in L (identity for base and flange). gravity: (3,) [m/s²].
    compliance: (S, 6, 6) [rad/(N·m), m/N] yield of each slot under its own wrench.
    """

    names: tuple[str, ...]
    links: tuple[str, ...]
    prismatic: NDArray[np.bool_]
    R: Array
    p: Array
    geometry: Array
    mass: Array
    moment: Array
    inertia: Array
    R_link: Array
    gravity: Array
    compliance: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.names)

    @property
    def slots(self) -> int:
        return self.n + 2

    @property
    def slot_names(self) -> tuple[str, ...]:
        """(S,) "base", the joints' names, "flange"."""
        return ("base", *self.names, "flange")

    @property
    def axial(self) -> NDArray[np.int64]:
        """(n,) column 6 · slot + component of each joint's own motion."""
        return 6 * np.arange(1, self.n + 1) + np.where(self.prismatic, TZ, RZ)

    @property
    def weighed(self) -> bool:
        """Whether any moving link has a mass."""
        return bool(self.mass[1:].any())

    def own(self, slots: Array) -> Array:
        """(N, n) of motions or wrenches (N, S, 6) of all slots: what each joint has along its own axis."""
        return np.asarray(slots.reshape(len(slots), -1)[:, self.axial])

    @property
    def span(self) -> Array:
        """(S, 3) [m] from the parent link's frame to each slot, on the slot's axes (nominal)."""
        return np.einsum("sji,sj->si", self.R, self.p)

    def slot_of_joint(self, joint: str) -> int:
        """Slot at which a joint moves. Raises ValueError when there is none of that name."""
        return 1 + self.names.index(joint)

    def slot_of_link(self, link: str) -> int:
        """Slot behind which a link moves: 0 base, i link of joint i, n + 1 "flange"."""
        if link == "flange":
            return self.n + 1
        if link in ("base", self.links[0]):
            return 0
        return self.links.index(link)

    def with_geometry(self, geometry: Array) -> Arm:
        """The same arm with other corrections G: (S, 6)."""
        return replace(self, geometry=geometry)


def moved_base(arm: Arm, geometry: Array, R: Array, t: Array) -> Array:
    """Corrections (S, 6) of the arm with the corrections `geometry`, its base turned by R (3, 3) and then
    shifted by t (3,) [m]: the first joint's alone are others."""
    out = geometry.copy()
    placed = R @ (arm.p[1] + arm.R[1] @ geometry[1, :RX]) + t
    out[1, :RX] = arm.R[1].T @ (placed - arm.p[1])
    out[1, RX:] = xyz_angles((arm.R[1].T @ R @ arm.R[1] @ from_xyz(geometry[1:2, RX:])[0])[None])[0]
    return out


@dataclass(frozen=True)
class Frames:
    """Where everything is, in the world, for N poses.

    R, p: (S, N, 3, 3), (S, N, 3) [m] of X_WL (slot n + 1: the flange).
    axes: (N, S, 6, 3) unit axes of the motions T; origin: (N, S, 3) [m] where their rotations pivot.
    """

    arm: Arm
    R: Array
    p: Array
    axes: Array
    origin: Array

    @cached_property
    def geometry_axes(self) -> Array:
        """(N, S, 6, 3) unit axes of the corrections G."""
        axes = _corrected(self.arm)[2]
        out = np.empty((self.arm.slots, len(self.origin), 6, 3))
        out[0] = axes[0]
        for k in range(1, self.arm.slots):
            out[k] = (self.R[k - 1].reshape(-1, 3) @ axes[k].T).reshape(-1, 3, 6).transpose(0, 2, 1)
        return out.transpose(1, 0, 2, 3)

    @cached_property
    def geometry_origin(self) -> Array:
        """(N, S, 3) [m] where the corrections' rotations pivot."""
        p = _corrected(self.arm)[1]
        out = np.empty((self.arm.slots, len(self.origin), 3))
        out[0] = p[0]
        for k in range(1, self.arm.slots):
            out[k] = self.p[k - 1] + self.R[k - 1] @ p[k]
        return out.transpose(1, 0, 2)

    def points(self, targets: Array, on: Sequence[int]) -> Array:
        """Places of targets: (T, 3) in the frames behind slots `on` → (N, T, 3) [m]."""
        return np.stack([self.p[k] + self.R[k] @ targets[i] for i, k in enumerate(on)], axis=1)

    def turned(self, targets: Array, on: Sequence[int]) -> Array:
        """The targets' lever arms without the frame's origin: (N, T, 3) [m]."""
        return np.stack([self.R[k] @ targets[i] for i, k in enumerate(on)], axis=1)


def frames(arm: Arm, q: Array, motion: Array | None = None) -> Frames:
    """Frames for commanded joints q: (N, n) and slot motions: (N, S, 6) [m, rad] (None: zero)."""
    n_poses = len(q)
    G_R, G_p, _ = _corrected(arm)
    # slot by slot in memory: each step writes one block
    R_out = np.empty((arm.slots, n_poses, 3, 3))
    p_out = np.empty((arm.slots, n_poses, 3))
    axes = np.empty((arm.slots, n_poses, 6, 3))
    origin = np.empty((arm.slots, n_poses, 3))
    R = np.broadcast_to(np.eye(3), (n_poses, 3, 3))
    p = np.zeros((n_poses, 3))
    for k in range(arm.slots):
        flat = R.reshape(-1, 3)
        p = p + (flat @ G_p[k]).reshape(n_poses, 3)
        R = (flat @ G_R[k]).reshape(n_poses, 3, 3)
        moved = motion[:, k] if motion is not None else None
        joint = q[:, k - 1] if 1 <= k <= arm.n else None
        sliding = joint is not None and bool(arm.prismatic[k - 1])
        R, p = _step(R, p, moved, joint, sliding, axes[k], origin[k])
        R_out[k], p_out[k] = R, p
    return Frames(arm, R_out, p_out, axes.transpose(1, 0, 2, 3), origin.transpose(1, 0, 2))


def _step(
    R: Array, p: Array, moved: Array | None, joint: Array | None, sliding: bool, axes: Array, origin: Array
) -> tuple[Array, Array]:
    """One slot's motion and joint; fills `axes` (N, 6, 3) and `origin` (N, 3) in place."""
    axes[:, :3] = R.transpose(0, 2, 1)
    axes[:, RX] = R[:, :, 0]
    if moved is not None and moved[:, :3].any():
        slide = moved[:, :3].copy()
        if sliding:
            slide[:, 2] = 0.0
        p = p + np.einsum("nij,nj->ni", R, slide)
    if moved is not None and moved[:, RX].any():
        R = _turn(R, moved[:, RX], 1, 2)
    axes[:, RY] = R[:, :, 1]
    if moved is not None and moved[:, RY].any():
        R = _turn(R, moved[:, RY], 2, 0)
    axes[:, RZ] = R[:, :, 2]
    origin[:] = p
    angle = moved[:, RZ] if moved is not None else None
    if joint is not None and not sliding:
        angle = joint if angle is None else joint + angle
    if angle is not None:
        R = _turn(R, angle, 0, 1)
    if sliding and joint is not None:
        axes[:, TZ] = R[:, :, 2]
        way = joint if moved is None else joint + moved[:, TZ]
        p = p + R[:, :, 2] * way[:, None]
    return R, p


def _turn(R: Array, angle: Array, first: int, second: int) -> Array:
    """R times a rotation that takes column `first` towards column `second`."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    out = R.copy()
    out[:, :, first] = c * R[:, :, first] + s * R[:, :, second]
    out[:, :, second] = c * R[:, :, second] - s * R[:, :, first]
    return out


def _corrected(arm: Arm) -> tuple[Array, Array, Array]:
    """Slot poses with G, and the axes of G's six components in the parent link: (S, 6, 3)."""
    R = arm.R.copy()
    p = arm.p + np.einsum("sij,sj->si", arm.R, arm.geometry[:, :3])
    axes = np.empty((arm.slots, 6, 3))
    axes[:, :3] = arm.R.transpose(0, 2, 1)
    for component, (first, second, column) in {RX: (1, 2, 0), RY: (2, 0, 1), RZ: (0, 1, 2)}.items():
        axes[:, component] = R[:, :, column]
        R = _turn(R, arm.geometry[:, component], first, second)
    return R, p, axes


def point_jacobian(
    axes: Array, origin: Array, points: Array, on: Sequence[int], turn: Array | None = None
) -> Array:
    """Motion of points per unit of every slot motion.

    axes: (N, S, 6, 3), origin: (N, S, 3), points: (N, T, 3); `on` the slot behind which each
    target sits; turn: (N, 3, 3) into the frame in which the motion counts. Returns (N, T, 3, 6 S): a slot's
    motion is a twist, and moves a point by body_jacobian(point) @ twist; slots beyond the target do not.
    """
    n_poses, slots = axes.shape[:2]
    reach = body_jacobian(points)
    if turn is not None:
        reach = np.matmul(turn[:, None], reach)
    J = np.matmul(reach.reshape(n_poses, -1, 6), twists(axes, origin))
    out = np.asarray(J.reshape(n_poses, points.shape[1], 3, 6 * slots))
    for i, k in enumerate(on):
        out[:, i, :, 6 * (k + 1) :] = 0.0
    return out


def twists(axes: Array, origin: Array) -> Array:
    """(N, 6, 6 S) velocity of the base's origin and angular velocity per unit of every slot motion, for axes
    (N, S, 6, 3) and where their rotations pivot (N, S, 3)."""
    n_poses, slots = axes.shape[:2]
    out = np.zeros((n_poses, 6, slots, 6))
    out[:, :3, :, :3] = axes[:, :, :3].transpose(0, 3, 1, 2)
    about = axes[:, :, 3:].transpose(0, 3, 1, 2)
    out[:, 3:, :, 3:] = about
    x, y, z = origin[..., None].transpose(2, 0, 1, 3)
    out[:, 0, :, 3:] = y * about[:, 2] - z * about[:, 1]
    out[:, 1, :, 3:] = z * about[:, 0] - x * about[:, 2]
    out[:, 2, :, 3:] = x * about[:, 1] - y * about[:, 0]
    return out.reshape(n_poses, 6, 6 * slots)
