"""How a robot's controller names and counts its joints, and where its world and flange stand: `[controller]`.

The URDF counts joint i as q_i; the controller shows, in its own order,

    shown_k = sign_k q_j(k) + zero_k + Σ factor (sign_l q_j(l) + zero_l)

the last term for mechanically coupled axes (J3 shown against the horizontal: J3 on J2, factor −1). As
arrays shown = A q + zero, with one matrix A for the arm. Cartesian targets are the controller's own too:
poses
of its flange (and the tool on it) in its world, which need not be the URDF's base (FANUC and Stäubli: at the
height of joint 2; UR: half a turn about z from the base of many URDFs).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat

from ..files.faults import Fault
from ..files.section import Section
from .kinematics import Array
from .loop import Loop
from .rotations import from_zyx, pose

SI = {"deg": np.pi / 180, "rad": 1.0, "mm": 1e-3, "m": 1.0}
ANGLES = ("deg", "rad")

Name = Annotated[str, Field(min_length=1)]
Triple = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class FrameData(Section):
    """A frame: its origin, and its turn R = Rz(a) Ry(b) Rx(c)."""

    xyz_mm: Triple = (0.0, 0.0, 0.0)
    """its origin"""
    abc_deg: Triple = (0.0, 0.0, 0.0)
    """a, b, c of its turn"""

    def pose(self) -> Array:
        """(4, 4) [m]."""
        return pose(1e-3 * np.array(self.xyz_mm), from_zyx(np.radians([self.abc_deg]))[0])


class CouplingData(Section):
    """The controller's joint `joint` also counts the joint `on`, times `factor`."""

    joint: Name
    """joint of the controller"""
    on: Name
    """the joint that it counts as well"""
    factor: FiniteFloat
    """times this"""


class Controller(Section):
    """`[controller]`: lists over the controller's joints, in the controller's order."""

    make: str = ""
    """maker of the controller; a program in another maker's format is told"""
    names: tuple[Name, ...] = ()
    """the controller's name of every joint; without them nothing is stated"""
    joints: tuple[Name, ...] = ()
    """the URDF's joint behind each; absent: the chain's own order"""
    signs: tuple[Literal[-1, 1], ...] = ()
    """-1 where it counts the other way"""
    zeros: tuple[FiniteFloat, ...] = ()
    """what it shows where the URDF's joint is at 0"""
    units: tuple[Literal["deg", "rad", "mm", "m"], ...] = ()
    """of the zeros, and of columns by the controller's names"""
    couplings: tuple[CouplingData, ...] = ()
    """joints that count others as well"""
    external: tuple[Name, ...] = ()
    """those of the names that are external axes (rails)"""
    world: FrameData = FrameData()
    """the controller's world in the URDF's base"""
    flange: FrameData = FrameData()
    """its flange in the URDF's flange"""
    loop: Loop = Loop()
    """how it samples, what its drives bear, how they rub"""

    def faults(self, place: str, joints: Sequence[str], sliding: Sequence[bool]) -> list[Fault]:
        """What does not fit the chain of those URDF joints, of which `sliding` say where one slides."""
        n = len(joints)
        found = [
            Fault(f"{place}.{key}", f"has {len(values)} entries for {n} joints", "give one for each")
            for key in ("names", "joints", "signs", "zeros", "units")
            if (values := getattr(self, key)) and len(values) != n
        ]
        if not self.names and self != Controller(loop=self.loop):
            found.append(Fault(f"{place}.names", "is missing", "give the controller's name of every joint"))
        if self.joints and sorted(self.joints) != sorted(joints) and not found:
            found.append(Fault(f"{place}.joints", "are not the URDF's", f"has: {list(joints)}"))
        if len(set(self.names)) < len(self.names):
            found.append(Fault(f"{place}.names", "has a name twice"))
        told = [(f"{place}.external", name) for name in self.external]
        told += [(f"{place}.couplings", name) for pair in self.couplings for name in (pair.joint, pair.on)]
        found += [
            Fault(key, f"no joint {name!r}", f"has: {list(self.names)}")
            for key, name in told
            if name not in self.names
        ]
        found += [
            Fault(f"{place}.couplings", f"{pair.joint} counts itself")
            for pair in self.couplings
            if pair.joint == pair.on
        ]
        if not found and self.units:
            slides = dict(zip(joints, sliding, strict=True))
            found += [
                Fault(f"{place}.units", f"{unit} does not fit {joint}")
                for joint, unit in zip(self.joints or joints, self.units, strict=True)
                if slides[joint] == (unit in ANGLES)
            ]
        return found


@dataclass(frozen=True, eq=False)
class Convention:
    """A controller's way of counting n joints: shown = A q + zero, SI, in its own order.

    names: its joints; order: the URDF's joint behind each; A: (n, n); zero: (n,) [rad or m]; units: of each,
    as it shows them; sliding: (n,) which slide; external: (n,) which are external axes. world: (4, 4) its
    world in the URDF's base; flange: (4, 4) its flange in the URDF's.
    """

    names: tuple[str, ...]
    order: tuple[int, ...]
    A: Array
    zero: Array
    units: tuple[str, ...]
    sliding: tuple[bool, ...]
    external: tuple[bool, ...]
    world: Array
    flange: Array

    @property
    def counts_as_the_urdf(self) -> bool:
        """Whether it shows the URDF's joints as they are."""
        return np.array_equal(self.A, np.eye(len(self.names))) and not self.zero.any()

    def shown(self, q: Array) -> Array:
        """(N, n) what the controller shows of the URDF's joints (N, n); SI both."""
        return np.asarray(q @ self.A.T + self.zero)

    def joints(self, shown: Array) -> Array:
        """(N, n) the URDF's joints of what the controller shows (N, n); SI both."""
        return np.asarray(np.linalg.solve(self.A, (shown - self.zero).T).T)

    def sides(self, shown: Array) -> Array:
        """(N, n) signs of the URDF's joint motions of the controller's (−1, 0, 1); 0 where coupled axes
        moved against each other, so that nobody knows."""
        parts = np.linalg.inv(self.A)[None] * shown[:, None, :]
        up, down = (parts > 0).any(axis=2), (parts < 0).any(axis=2)
        return np.asarray(up.astype(float) - down)

    def to_world(self, X: Array) -> Array:
        """(..., 4, 4) poses in the controller's world, of poses in the URDF's base."""
        return np.asarray(np.linalg.inv(self.world) @ X)

    def from_world(self, X: Array) -> Array:
        """(..., 4, 4) poses in the URDF's base, of poses in the controller's world."""
        return np.asarray(self.world @ X)

    def to_flange(self, X: Array) -> Array:
        """(4, 4) a tool on the controller's flange, of a tool on the URDF's."""
        return np.asarray(np.linalg.inv(self.flange) @ X)

    def from_flange(self, X: Array) -> Array:
        """(4, 4) a tool on the URDF's flange, of a tool on the controller's."""
        return np.asarray(self.flange @ X)


def convention_of(data: Controller, joints: Sequence[str], sliding: Sequence[bool]) -> Convention:
    """The convention that checked `data` state for a chain of those URDF joints."""
    n, slides = len(joints), np.array(sliding, dtype=bool)
    order = [list(joints).index(name) for name in data.joints or joints]
    units = data.units or tuple("mm" if slides[j] else "deg" for j in order)
    own = np.zeros((n, n))
    own[np.arange(n), order] = data.signs or 1.0
    zero = np.array(data.zeros or [0.0] * n) * [SI[unit] for unit in units]
    mixed = np.eye(n)
    for pair in data.couplings:
        mixed[data.names.index(pair.joint), data.names.index(pair.on)] += pair.factor
    return Convention(
        names=data.names,
        order=tuple(order),
        A=mixed @ own,
        zero=mixed @ zero,
        units=units,
        sliding=tuple(bool(slides[j]) for j in order),
        external=tuple(name in data.external for name in data.names),
        world=data.world.pose(),
        flange=data.flange.pose(),
    )
