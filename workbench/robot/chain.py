"""The chain of moving joints that a URDF has between its base and the flange."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..files.faults import Fault, InputError
from .kinematics import Array
from .rotations import from_zyx
from .urdf import LOOSE, MOVING, WORLD, Urdf, Vector3, limit, origin_of, vector

ROUNDING = 1e-6  # rad or m
LIMITS = ("lower", "upper", "velocity", "effort")


@dataclass(frozen=True)
class MovingJoint:
    """One moving joint of the chain and the link that it carries.

    `lower`, `upper` are the URDF's limits (rad or m, infinite where there are none), `velocity` and `effort`
    likewise (rad/s or m/s, N·m or N).
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    link: str
    lower: float
    upper: float
    velocity: float
    effort: float

    def beyond(self, q: Array) -> NDArray[np.bool_]:
        """Which of its positions [rad, m] lie beyond its limits, by more than rounding."""
        return np.asarray((q < self.lower - ROUNDING) | (q > self.upper + ROUNDING))


@dataclass(frozen=True)
class Chain:
    """Base, moving joints from there to the flange, and which way is down: (3,) on the base's axes."""

    base: str
    joints: tuple[MovingJoint, ...]
    down: Vector3


def read_chain(urdf: Urdf, flange: str, base: str | None = None) -> Chain:
    """Base and moving joints, base to flange. Raises `InputError` with every fault of the chain.

    base: None for the root, or what stands on it where the root is called `world` or carries the robot
    loosely (a floating base). Links behind a fixed joint belong to the link that they are welded to; the
    link named for a joint is its own child.
    """
    for key, link in (("flange", flange), ("base", base)):
        if link is not None and link not in urdf.links:
            mend = f"mend --{key}, or `{key}` in the robot's TOML; it has: {', '.join(urdf.links)}"
            raise InputError(Fault(str(urdf.path), f"has no link {link!r}", mend))
    way = list(urdf.above(flange))
    if base is not None and base not in way:
        what = f"link {base!r} does not carry {flange!r}"
        raise InputError(Fault(str(urdf.path), what, f"`base` may be one of {', '.join(way[1:])}"))
    base = base or _natural_base(urdf, way)
    chain: list[MovingJoint] = []
    faults: list[Fault] = []
    for link in way[: way.index(base)]:
        joint = urdf.joints[link]
        place, kind = f"{urdf.path}: joint {joint.get('name')!r}", urdf.kind(link)
        if (mimic := joint.find("mimic")) is not None and kind in MOVING:
            what = f"follows {mimic.get('joint')!r} (mimic, times {mimic.get('multiplier', '1')})"
            faults.append(Fault(place, what, _OWN))
        elif kind in MOVING:
            chain.append(_moving_joint(joint, link, place, faults))
        elif kind != "fixed":
            faults.append(Fault(place, f"is {kind!r}", "revolute, continuous, prismatic or fixed"))
    if not chain and not faults:
        what = f"no moving joint between {base!r} and {flange!r}"
        faults.append(Fault(str(urdf.path), what, "mend `base` or `flange`"))
    if faults:
        raise InputError(faults)
    return Chain(base, tuple(chain[::-1]), _down(urdf, base))


_OWN = (
    'between base and flange every joint has to be its own: write type="fixed" where it stood still, or take '
    "<mimic> out and give it a column in the poses (`plan` and `compensate` then move it by itself, and what "
    "is soft before it is loaded otherwise than through rods); of a telescope, write one joint that moves as "
    "far as all its stages together, the others fixed"
)


def _natural_base(urdf: Urdf, way: list[str]) -> str:
    """The root of the links on the way; below what is loose; and what stands on a root called world."""
    loose = [link for link in way if link in urdf.joints and urdf.kind(link) in LOOSE]
    base = loose[0] if loose else way[-1]
    if base == WORLD and len(way) > 1 and urdf.kind(way[-2]) == "fixed":
        return way[-2]
    return base


def _down(urdf: Urdf, base: str) -> Vector3:
    """The root's −z on the axes of a base that is mounted on it, moving joints between at zero."""
    down = np.array([0.0, 0.0, -1.0])
    for link in [*urdf.above(base)][-2::-1]:
        place = f"{urdf.path}: joint {urdf.joints[link].get('name')!r}"
        rpy = np.array(origin_of(urdf.joints[link], place)[1])
        down = from_zyx(rpy[None, ::-1])[0].T @ down
    x, y, z = (round(float(v), 12) + 0.0 for v in down)
    return x, y, z


def _moving_joint(joint: ET.Element, link: str, place: str, faults: list[Fault]) -> MovingJoint:
    """Limits that leave no way (the URDF's default 0 .. 0) are none."""
    said = joint.find("limit")
    lower, upper, velocity, effort = (limit(said, key, place) for key in LIMITS)
    if lower > upper:
        faults.append(Fault(place, f"its limits are {lower:g} .. {upper:g}", "the lower one comes first"))
    for key, value in (("velocity", velocity), ("effort", effort)):
        if value < 0:
            faults.append(Fault(place, f"its limit of {key} is {value:g}", "above zero, or leave it out"))
    if not any(vector(joint.find("axis"), "xyz", place, (1.0, 0.0, 0.0))):
        faults.append(Fault(place, "its axis is 0 0 0", "say which way it is"))
    bounds = lower < upper and joint.get("type") != "continuous"
    return MovingJoint(
        name=joint.get("name", ""),
        kind="prismatic" if joint.get("type") == "prismatic" else "revolute",
        link=link,
        lower=lower if bounds else -math.inf,
        upper=upper if bounds else math.inf,
        velocity=velocity or math.inf,
        effort=effort or math.inf,
    )
