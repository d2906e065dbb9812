"""The tables that a robot's TOML may have: keys, units, bounds, and the faults of a file that breaks them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from ..files.faults import Fault, InputError
from ..files.toml import read_toml

GEOMETRY = ("tx", "ty", "tz", "rx", "ry", "rz")
STANDARD_GRAVITY = 9.80665  # m/s²

Vector3 = tuple[float, float, float]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class JointData(_Table):
    """What the TOML says of one joint. SI units; None = not known."""

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


class RobotFile(_Table):
    """A robot's TOML, or a model.toml: that one has `[geometry]` and `[[effects]]` as well."""

    schema_: Literal[1] = Field(alias="schema")
    name: str
    title: str = ""
    urdf: str
    flange: str
    gravity: Vector3 = (0.0, 0.0, -STANDARD_GRAVITY)
    joints: tuple[JointData, ...] = ()
    compensator: Compensator | None = None
    links: tuple[LinkData, ...] = ()
    source: dict[str, Any] = {}
    tool: LoadData | None = None
    payloads: dict[str, LoadData] = {}
    geometry: dict[str, dict[str, float]] = {}
    effects: tuple[EffectRecord, ...] = ()


def parse_robot(path: Path) -> RobotFile:
    """The TOML's tables. Raises `InputError` with every fault of the file by itself."""
    try:
        return RobotFile.model_validate(read_toml(path))
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


def unknown_names(path: Path, file: RobotFile, joints: list[str], links: set[str]) -> list[Fault]:
    """What the TOML says of joints and links that the URDF's chain does not have, and what is missing."""
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
