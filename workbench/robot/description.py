"""A robot: its URDF (the nominal rigid arm) and its TOML (what URDF cannot say).

The same loader reads the models that come with the workbench, a user's own robot by path, and
the `model.toml` that a diagnosis writes: that is a robot TOML with `[geometry]` and `[[effects]]`.
"""

from __future__ import annotations

import tomllib
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from ..files.faults import Fault, InputError, read_text

GEOMETRY = ("tx", "ty", "tz", "rx", "ry", "rz")
STANDARD_GRAVITY = (0.0, 0.0, -9.80665)


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


Vector3 = tuple[float, float, float]


class JointData(_Table):
    """What the TOML says of one joint (contract, section 1). SI units; None = not known."""

    name: str
    stiffness: float | None = Field(default=None, gt=0)
    gear_ratio: float | None = None
    rotor_inertia: float = Field(default=0.0, ge=0)
    damping: float = Field(default=0.0, ge=0)
    tilt_stiffness: float | None = Field(default=None, gt=0)
    repeatability: float | None = Field(default=None, ge=0)


class Compensator(_Table):
    """A gravity compensator: a gas cylinder or a spring that pulls two pivots together.

    gas:    F = A (p (l / (l − (s − reference)))^n − 101325 Pa), s the distance of the pivots
    spring: F = rate (s − free_length)
    """

    kind: Literal["gas", "spring"]
    joint: str
    body: str
    arm: str
    body_pivot: Vector3
    arm_pivot: Vector3
    piston_area: float | None = Field(default=None, gt=0)
    precharge: float | None = Field(default=None, gt=0)
    gas_length: float | None = Field(default=None, gt=0)
    reference: float | None = Field(default=None, gt=0)
    exponent: float = Field(1.0, ge=1.0, le=1.4)
    rate: float | None = Field(default=None, gt=0)
    free_length: float | None = None

    def missing(self) -> list[str]:
        """Names of the numbers that this kind needs and that are not given."""
        needed = {
            "gas": ("piston_area", "precharge", "gas_length", "reference"),
            "spring": ("rate", "free_length"),
        }[self.kind]
        return [name for name in needed if getattr(self, name) is None]


class LinkData(_Table):
    """A flexible link: bending stiffness EI in N·m²."""

    name: str
    bending_stiffness: float | None = Field(default=None, gt=0)


class LoadData(_Table):
    """`[tool]` or `[payloads.heavy]`: mass and centre of mass in the flange frame."""

    mass_kg: Annotated[FiniteFloat, Field(ge=0)]
    com_mm: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)


def stated_load(load: LoadData | None) -> tuple[float, tuple[float, float, float]]:
    """Mass [kg] and centre of mass [m, flange frame]; nothing for None."""
    if load is None:
        return 0.0, (0.0, 0.0, 0.0)
    x, y, z = load.com_mm
    return load.mass_kg, (1e-3 * x, 1e-3 * y, 1e-3 * z)


class EffectRecord(_Table):
    """One effect of an extended model: its cause, where it sits, its parameters by name."""

    cause: str
    joint: str | None = None
    other: str | None = None
    link: str | None = None
    payload: str | None = None
    order: float | None = None
    variant: str = ""
    values: dict[str, float] = {}


class _RobotFile(_Table):
    schema_: Literal[1] = Field(alias="schema")
    name: str
    title: str = ""
    urdf: str
    flange: str
    gravity: Vector3 = STANDARD_GRAVITY
    joints: tuple[JointData, ...] = ()
    compensator: Compensator | None = None
    links: tuple[LinkData, ...] = ()
    source: dict[str, Any] = {}
    tool: LoadData | None = None
    payloads: dict[str, LoadData] = {}
    geometry: dict[str, dict[str, float]] = {}
    effects: tuple[EffectRecord, ...] = ()


@dataclass(frozen=True)
class Joint:
    """One moving joint of the chain from base to flange.

    `kind` is "revolute" or "prismatic"; `lower`, `upper` are the URDF's limits (rad or m,
    infinite where there are none), `velocity` likewise (rad/s or m/s).
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    link: str
    lower: float
    upper: float
    velocity: float
    data: JointData


@dataclass(frozen=True)
class Robot:
    """A robot as loaded and checked. `joints` run from the base to the flange.

    tool, payloads: what the campaign behind a model.toml carried; they count only where nobody states
    other loads (a campaign always does).
    """

    name: str
    title: str
    urdf: Path
    flange: str
    gravity: Vector3
    base: str
    joints: tuple[Joint, ...]
    compensator: Compensator | None = None
    bending_stiffness: dict[str, float] = field(default_factory=dict)
    source: dict[str, Any] = field(default_factory=dict)
    tool: LoadData | None = None
    payloads: dict[str, LoadData] = field(default_factory=dict)
    geometry: dict[str, dict[str, float]] = field(default_factory=dict)
    effects: tuple[EffectRecord, ...] = ()
    path: Path | None = None

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    @property
    def links(self) -> tuple[str, ...]:
        """The moving links, base to flange: `links[i]` is carried by `joints[i]`."""
        return tuple(joint.link for joint in self.joints)


def model_folders() -> list[Path]:
    """Where robots that come with the workbench are looked for."""
    package = Path(__file__).resolve().parents[1]
    return [folder for folder in (package.parent / "models", package / "models") if folder.is_dir()]


def list_robots() -> list[Path]:
    """The TOML of every robot that comes with the workbench, sorted by name."""
    found = {path.stem: path for folder in model_folders() for path in folder.glob("*/*.toml")}
    return [found[name] for name in sorted(found)]


def find_robot(robot: str | Path, beside: Path | None = None) -> Path:
    """Path of a robot's TOML from a name under `models/` or a path (relative to `beside`).

    Raises `InputError` when there is none.
    """
    text = str(robot)
    if not text.endswith(".toml"):
        for path in list_robots():
            if path.stem == text:
                return path
        known = ", ".join(path.stem for path in list_robots())
        raise InputError(Fault(text, "no such robot", f"known: {known}; or give the path of a robot TOML"))
    path = Path(text)
    if not path.is_absolute() and beside is not None:
        path = beside / path
    if not path.is_file():
        raise InputError(Fault(str(path), "no such robot file", "check `robot = ...`"))
    return path


def load_robot(robot: str | Path, beside: Path | None = None) -> Robot:
    """Load a robot by name or by path and check it.

    Raises `InputError` with every fault of the TOML and the URDF.
    """
    path = find_robot(robot, beside)
    file = _parse(path)
    urdf = path.parent / file.urdf
    base, chain = _chain(urdf, file.flange)
    data = {joint.name: joint for joint in file.joints}
    names = [name for name, *_ in chain]
    faults = [
        Fault(
            f"{path}: joints.{name}", "no moving joint of the URDF between base and flange", f"has: {names}"
        )
        for name in data
        if name not in names
    ]
    links = {base, *(child for _, _, child, *_ in chain)}
    faults += _check_references(path, file, names, links)
    if faults:
        raise InputError(faults)
    joints = tuple(
        Joint(name, kind, child, lower, upper, velocity, data.get(name, JointData(name=name)))
        for name, kind, child, lower, upper, velocity in chain
    )
    return Robot(
        name=file.name,
        title=file.title or file.name,
        urdf=urdf,
        flange=file.flange,
        gravity=file.gravity,
        base=base,
        joints=joints,
        compensator=file.compensator,
        bending_stiffness={
            link.name: link.bending_stiffness for link in file.links if link.bending_stiffness is not None
        },
        source=file.source,
        tool=file.tool,
        payloads=file.payloads,
        geometry=file.geometry,
        effects=file.effects,
        path=path,
    )


def _parse(path: Path) -> _RobotFile:
    try:
        return _RobotFile.model_validate(tomllib.loads(read_text(path)))
    except tomllib.TOMLDecodeError as error:
        raise InputError(Fault(str(path), f"is not TOML: {error}")) from None
    except ValidationError as error:
        raise InputError(toml_faults(path, error)) from None


def toml_faults(path: Path, error: ValidationError) -> list[Fault]:
    """The faults that pydantic found in a TOML file, each with its key and value."""
    faults = []
    for item in error.errors():
        key = ".".join(str(part) for part in item["loc"]) or "file"
        value = item.get("input")
        said = f" (is {value!r})" if isinstance(value, str | int | float | bool) else ""
        what = "unknown key" if item["type"] == "extra_forbidden" else item["msg"] + said
        faults.append(Fault(f"{path}: {key}", what))
    return faults


def _check_references(path: Path, file: _RobotFile, joints: list[str], links: set[str]) -> list[Fault]:
    faults = [
        Fault(f"{path}: links.{link.name}", "no such link in the URDF's chain", f"has: {sorted(links)}")
        for link in file.links
        if link.name not in links
    ]
    for name, values in file.geometry.items():
        if name not in joints:
            faults.append(Fault(f"{path}: geometry.{name}", "no such joint", f"has: {joints}"))
        faults += [
            Fault(f"{path}: geometry.{name}.{key}", "unknown key", f"one of {GEOMETRY}")
            for key in values
            if key not in GEOMETRY
        ]
    if (compensator := file.compensator) is not None:
        place = f"{path}: compensator"
        faults += [Fault(f"{place}.{name}", f"missing, a {compensator.kind} compensator needs it")
                   for name in compensator.missing()]  # fmt: skip
        if compensator.joint not in joints:
            faults.append(Fault(f"{place}.joint", f"no joint {compensator.joint!r}", f"has: {joints}"))
        faults += [
            Fault(f"{place}.{key}", f"no link {link!r}", f"has: {sorted(links)}")
            for key, link in (("body", compensator.body), ("arm", compensator.arm))
            if link not in links
        ]
    return faults


_Segment = tuple[str, Literal["revolute", "prismatic"], str, float, float, float]


def _chain(urdf: Path, flange: str) -> tuple[str, list[_Segment]]:
    """Base link and moving joints (name, kind, carried link, limits, velocity), base to flange.

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
    chain: list[_Segment] = []
    link, faults = flange, []
    while link in parents:
        joint, parent_link = parents[link]
        kind = joint.get("type")
        if kind in ("revolute", "continuous", "prismatic"):
            chain.append(_segment(joint, link))
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


def _segment(joint: ET.Element, link: str) -> _Segment:
    limit = joint.find("limit")
    revolute = joint.get("type") != "prismatic"
    bounds = limit is not None and joint.get("type") != "continuous"
    inf = float("inf")
    return (
        joint.get("name", ""),
        "revolute" if revolute else "prismatic",
        link,
        float(limit.get("lower", 0.0)) if bounds and limit is not None else -inf,
        float(limit.get("upper", 0.0)) if bounds and limit is not None else inf,
        (float(limit.get("velocity", 0.0)) or inf) if limit is not None else inf,
    )
