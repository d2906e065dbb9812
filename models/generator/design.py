"""What is known of a robot: the data that one robot file states, before any file is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .kinematics import Array, Chain, Table, pose, rotation_x, rotation_y, rotation_z

Vector = Sequence[float]


@dataclass(frozen=True)
class Mass:
    """Mass [kg], centre of mass [mm] and inertia about it [kg·m²], in the frame that `Masses` names.

    `inertia` is a full tensor, or the sides (mm) of the cuboid that stands for the link.
    """

    mass: float
    com: Vector
    inertia: Sequence[Sequence[float]] | None = None
    box: Vector | None = None

    def tensor(self) -> Array:
        """(3, 3) about the centre of mass, in the frame of `com`."""
        if self.inertia is not None:
            return np.array(self.inertia, dtype=float)
        if self.box is None:
            raise ValueError("a mass needs an inertia or a box")
        x, y, z = (np.array(self.box) / 1000) ** 2
        return self.mass / 12 * np.diag([y + z, x + z, x + y])


@dataclass(frozen=True)
class Masses:
    """Masses of links 1..n in frames 1..n of `table` at joint angles `at` (deg, the URDF's joints).

    Without a table they are stated at q = 0 in the base frame, or, where `start` is given, in that of an
    arm that stands upright: turned as the link frames are, its z axis `start` mm along the base's.
    """

    links: Sequence[Mass]
    table: Table | None = None
    at: Vector | None = None
    start: float | None = None


@dataclass(frozen=True)
class Limits:
    """Limits of one joint: degrees and degrees/s (revolute) or mm and mm/s; N·m or N."""

    lower: float
    upper: float
    velocity: float
    effort: float


# Assumed of every robot: a position cycle of 4 ms, a drive cycle of 0.5 ms and as much delay.
LOOP = {
    "position_period": 0.004,
    "drive_period": 0.0005,
    "delay": 0.0005,
    "velocity_filter": 0.00025,
    "encoder_steps": 1048576.0,
    "position_hz": 5.0,
    "coulomb": 0.01,
    "stiction": 1.2,
    "load_side": 0.1,
}


@dataclass(frozen=True)
class Design:
    """One robot. `loop`: what its controller does otherwise than `LOOP`. `mount` is roll, pitch, yaw
    [deg] of all link frames in the base frame at q = 0. `pose_repeatability`: the maker's figure (RP), mm."""

    name: str
    title: str
    chain: Chain
    limits: Sequence[Limits]
    masses: Masses
    source: Mapping[str, str]
    look: Callable[[Design], Mapping[str, Any]]
    base_mass: Mass
    joints: Sequence[str] = ()
    mount: Vector = (0.0, 0.0, 0.0)
    joint_data: Mapping[str, Vector] = field(default_factory=dict)
    pose_repeatability: float | None = None
    compensator: Mapping[str, Any] | None = None
    loop: Mapping[str, float] = field(default_factory=dict)
    bending_stiffness: Mapping[str, float] = field(default_factory=dict)
    controller: Mapping[str, Any] | None = None

    @property
    def joint_names(self) -> list[str]:
        return list(self.joints) or [f"joint_{i + 1}" for i in range(len(self.chain.axes))]

    @property
    def rotation(self) -> Array:
        """(3, 3) of all link frames in the base frame at q = 0."""
        roll, pitch, yaw = self.mount
        return rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll)

    def link_frames(self) -> list[Array]:
        """Poses X_BL (4, 4) of link frames 1..n at q = 0: on the joint axes, all turned alike."""
        return [pose(self.rotation, 1000 * axis.point) for axis in self.chain.axes]
