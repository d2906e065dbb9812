"""An arm as its URDF and its TOML have it, and the rotations that it takes.

Own equations in NumPy, nothing of `workbench`. SI units and radians; in shapes n are joints. A link's vectors
stand in its own frame, which is its joint's after the joint has moved.
"""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation (3, 3) of a URDF's rpy: about fixed x, then y, then z."""
    cr, sr = np.cos(roll), np.sin(roll)
    cp, sp = np.cos(pitch), np.sin(pitch)
    cy, sy = np.cos(yaw), np.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation(vectors: Array) -> Array:
    """Rotations (..., 3, 3) of rotation vectors (..., 3), by Rodrigues' formula."""
    vectors = np.asarray(vectors, float)
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = np.zeros((*vectors.shape[:-1], 3, 3))
    cross[..., 0, 1] = -vectors[..., 2]
    cross[..., 0, 2] = vectors[..., 1]
    cross[..., 1, 2] = -vectors[..., 0]
    cross[..., 1, 0] = vectors[..., 2]
    cross[..., 2, 0] = -vectors[..., 1]
    cross[..., 2, 1] = vectors[..., 0]
    sine = np.sinc(angle / np.pi)
    cosine = 0.5 * np.sinc(angle / 2 / np.pi) ** 2
    return np.eye(3) + sine * cross + cosine * (cross @ cross)


def turned(rotations: Array, vectors: Array) -> Array:
    return np.einsum("...ij,...j->...i", rotations, vectors)


def dot(one: Array, other: Array) -> Array:
    return np.sum(one * other, -1)


@dataclass(frozen=True, eq=False)
class Arm:
    """What URDF and TOML say of a robot; NaN where they do not say a number.

    `lengths`: (n,) from joint to joint, the last to the flange; `reach`: their sum without the base, m.
    `stiffness`, `tilt_stiffness`: N·m/rad (sliding: N/m); `bending_stiffness`: E·I of a link, N·m².
    """

    path: Path
    names: list[str]
    links: list[str]
    turns: list[Array]
    offsets: list[Array]
    axes: list[Array]
    sliding: list[bool]
    lower: Array
    upper: Array
    mass: Array
    centre: Array
    flange_turn: Array
    flange_offset: Array
    stiffness: Array
    tilt_stiffness: Array
    bending_stiffness: Array
    repeatability: Array
    gear_ratio: Array
    compensator: dict[str, Any] | None
    gravity: Array
    lengths: Array
    reach: float

    @property
    def count(self) -> int:
        return len(self.names)

    @property
    def turning(self) -> list[int]:
        return [joint for joint in range(self.count) if not self.sliding[joint]]


def _numbers(words: str | None) -> Array:
    return np.array([float(word) for word in words.split()]) if words else np.zeros(3)


def _origin(element: ElementTree.Element) -> tuple[Array, Array]:
    """Offset, m, and rotation of an element's <origin>, which may be missing."""
    origin = element.find("origin")
    if origin is None:
        return np.zeros(3), roll_pitch_yaw(0.0, 0.0, 0.0)
    return _numbers(origin.get("xyz")), roll_pitch_yaw(*_numbers(origin.get("rpy")))


def _chain(root: ElementTree.Element, flange: str) -> list[ElementTree.Element]:
    """The joints from the base to the flange."""
    above = {joint.find("child").get("link"): joint for joint in root.iter("joint")}
    link, chain = flange, []
    while link in above:
        chain.append(above[link])
        link = above[link].find("parent").get("link")
    return chain[::-1]


def _inertials(root: ElementTree.Element) -> dict[str, tuple[float, Array]]:
    """Mass, kg, and centre, m, of each link that states them."""
    found = {}
    for link in root.iter("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            found[link.get("name")] = (float(inertial.find("mass").get("value")), _origin(inertial)[0])
    return found


def read_arm(path: Path) -> Arm:
    """The arm of a robot's TOML and of its URDF; what is fixed to a moving link is a part of it."""
    said = tomllib.loads(path.read_text(encoding="utf-8"))
    root = ElementTree.parse(path.parent / said["urdf"]).getroot()
    inertials = _inertials(root)
    names, links, turns, offsets, axes, sliding, lower, upper = [], [], [], [], [], [], [], []
    mass, centre = [], []
    turn, offset = np.eye(3), np.zeros(3)
    for joint in _chain(root, said["flange"]):
        shift, rotated = _origin(joint)
        offset = offset + turn @ shift
        turn = turn @ rotated
        link = joint.find("child").get("link")
        own_mass, own_centre = inertials.get(link, (0.0, np.zeros(3)))
        if joint.get("type") == "fixed":
            if own_mass and names:
                whole = mass[-1] + own_mass
                centre[-1] = (mass[-1] * centre[-1] + own_mass * (offset + turn @ own_centre)) / whole
                mass[-1] = whole
            continue
        axis = _numbers(joint.find("axis").get("xyz"))
        limit = joint.find("limit")
        limit = {} if limit is None else limit.attrib
        names.append(joint.get("name"))
        links.append(link)
        turns.append(turn)
        offsets.append(offset)
        axes.append(axis / np.linalg.norm(axis))
        sliding.append(joint.get("type") == "prismatic")
        lower.append(float(limit.get("lower", -np.pi)))
        upper.append(float(limit.get("upper", np.pi)))
        mass.append(own_mass)
        centre.append(own_centre)
        turn, offset = np.eye(3), np.zeros(3)
    joints = {joint["name"]: joint for joint in said.get("joints", [])}
    bending = {link["name"]: link["bending_stiffness"] for link in said.get("links", [])}

    def stated(key: str) -> Array:
        return np.array([joints.get(name, {}).get(key) or np.nan for name in names], float)

    lengths = [np.linalg.norm(part) for part in offsets[1:]]
    last = np.linalg.norm(offset)
    return Arm(
        path=path,
        names=names,
        links=links,
        turns=turns,
        offsets=offsets,
        axes=axes,
        sliding=sliding,
        lower=np.array(lower),
        upper=np.array(upper),
        mass=np.array(mass),
        centre=np.array(centre),
        flange_turn=turn,
        flange_offset=offset,
        stiffness=stated("stiffness"),
        tilt_stiffness=stated("tilt_stiffness"),
        bending_stiffness=np.array([bending.get(link, np.nan) for link in links]),
        repeatability=stated("repeatability"),
        gear_ratio=stated("gear_ratio"),
        compensator=said.get("compensator"),
        gravity=np.array(said.get("gravity", [0, 0, -9.80665])),
        lengths=np.array([*lengths, last]),
        reach=sum(lengths) + last,
    )
