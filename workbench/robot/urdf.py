"""The chain of moving joints that a URDF has between its base and the flange."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ..files.faults import Fault, InputError, read_text


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
    for joint in root.iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = (joint, parent.get("link", ""))
    if flange not in {link.get("name") for link in root.iter("link")}:
        raise InputError(Fault(str(urdf), f"has no link {flange!r}", "mend `flange` in the robot's TOML"))
    chain: list[MovingJoint] = []
    link, faults = flange, []
    while link in parents:
        joint, parent_link = parents[link]
        kind = joint.get("type")
        if kind in ("revolute", "continuous", "prismatic"):
            chain.append(_moving_joint(joint, link))
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


def _moving_joint(joint: ET.Element, link: str) -> MovingJoint:
    limit = joint.find("limit")
    revolute = joint.get("type") != "prismatic"
    bounds = limit is not None and joint.get("type") != "continuous"
    inf = float("inf")
    return MovingJoint(
        name=joint.get("name", ""),
        kind="revolute" if revolute else "prismatic",
        link=link,
        lower=float(limit.get("lower", 0.0)) if bounds and limit is not None else -inf,
        upper=float(limit.get("upper", 0.0)) if bounds and limit is not None else inf,
        velocity=(float(limit.get("velocity", 0.0)) or inf) if limit is not None else inf,
        effort=(float(limit.get("effort", 0.0)) or inf) if limit is not None else inf,
    )
