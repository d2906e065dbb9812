"""The chain of moving joints that a URDF has between its base and the flange."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ..files.faults import Fault, InputError, read_text
from ..files.toml import SHOWN


@dataclass(frozen=True)
class MovingJoint:
    """One moving joint of the chain and the link that it carries.

    `lower`, `upper` are the URDF's limits (rad or m, infinite where there are none), `velocity` likewise
    (rad/s or m/s).
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    link: str
    lower: float
    upper: float
    velocity: float


def read_chain(urdf: Path, flange: str) -> tuple[str, list[MovingJoint]]:
    """Base link and moving joints, base to flange. Raises `InputError` with every fault of the chain.

    Links behind a fixed joint belong to the link that they are welded to; the link named for a
    joint is its own child.
    """
    try:
        root = ET.fromstring(read_text(urdf))
    except ET.ParseError as error:
        raise InputError(Fault(str(urdf), f"is not XML: {error}")) from None
    parents = {}
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = (joint, parent.get("link", ""))
    if flange not in {link.get("name") for link in root.findall("link")}:
        raise InputError(Fault(str(urdf), f"has no link {flange!r}", "mend `flange` in the robot's TOML"))
    chain: list[MovingJoint] = []
    faults: list[Fault] = []
    link = flange
    while link in parents:
        joint, parent_link = parents.pop(link)
        kind = joint.get("type")
        if kind in ("revolute", "continuous", "prismatic"):
            chain.append(_moving_joint(urdf, joint, link, faults))
        elif kind != "fixed":
            faults.append(
                Fault(str(urdf), f"joint {joint.get('name')!r} is {kind!r}", "revolute, prismatic, fixed")
            )
        link = parent_link
    if not chain:
        faults.append(Fault(str(urdf), f"no moving joint between {link!r} and {flange!r}"))
    if faults:
        raise InputError(faults)
    return link, chain[::-1]


def _moving_joint(urdf: Path, joint: ET.Element, link: str, faults: list[Fault]) -> MovingJoint:
    """The joint; what is wrong with its limits is added to the faults."""
    limit, name, kind = joint.find("limit"), joint.get("name", ""), joint.get("type")
    limits = {} if limit is None else {key: limit.get(key, "0") for key in ("lower", "upper", "velocity")}
    numbers = {key: _number(text) for key, text in limits.items()}
    faults += [
        Fault(f"{urdf}: joint {name!r}", f"{key} is {limits[key][:SHOWN]!r}, not a number")
        for key, number in numbers.items()
        if math.isnan(number)
    ]
    endless = limit is None or kind == "continuous"
    return MovingJoint(
        name=name,
        kind="prismatic" if kind == "prismatic" else "revolute",
        link=link,
        lower=-math.inf if endless else numbers["lower"],
        upper=math.inf if endless else numbers["upper"],
        velocity=numbers.get("velocity") or math.inf,
    )


def _number(text: str) -> float:
    """The number that a text is, NaN where it is none."""
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        return math.nan
