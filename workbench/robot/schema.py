"""The tables that a robot's TOML may have: keys, units, bounds, and the faults of a file that breaks them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from ..files.faults import Fault, InputError, read_text
from ..files.measure import AboveZero
from ..files.section import Section
from ..files.table_columns import suggest
from ..files.toml import read_toml
from ..files.toml_place import keys_at, line_of, places
from .convention import Controller
from .loop import Loop
from .uncertainty import Uncertainty

FILE_NAME = re.compile(r"\w[\w.+-]*")
GEOMETRY = ("tx", "ty", "tz", "rx", "ry", "rz")
FLANGE = "flange"  # what `[geometry]` calls its frame
EXAMPLES = {
    "name": 'name = "my_robot", say',
    "urdf": 'urdf = "my_robot.urdf", say: the file beside this one',
    "flange": 'flange = "tool0", say: a link of the URDF',
    "mass_kg": "mass_kg = 60.0, say",
}
"""What a missing key looks like."""
SAID = {"extra_forbidden": "unknown key", "missing": "is missing"}  # a fault's type → our words
STANDARD_GRAVITY = 9.80665  # m/s²

SLOWEST, FASTEST = 1e-3, 1e6  # motor turns per joint turn, or rad per m

Vector3 = tuple[float, float, float]


def _gear(ratio: float) -> float:
    if not SLOWEST <= abs(ratio) <= FASTEST:
        raise ValueError(f"no gear has such a ratio: {SLOWEST:g} to {FASTEST:g}, either sign")
    return ratio


GearRatio = Annotated[float, AfterValidator(_gear)]


def _of_files(name: str) -> str:
    if not FILE_NAME.fullmatch(name):
        raise ValueError(
            "is no name of a file: letters, digits and _ . + -, the first a letter, a digit or _"
        )
    return name


FileName = Annotated[str, AfterValidator(_of_files)]


class _Table(Section):
    model_config = ConfigDict(allow_inf_nan=False)


class JointData(_Table):
    """What the TOML says of one joint. SI units; None = not known."""

    name: str
    """of the moving joint in the URDF"""
    stiffness: AboveZero | None = None
    """axial, N·m/rad (N/m of a sliding joint); absent = rigid"""
    gear_ratio: GearRatio | None = None
    """motor turns per joint turn; absent = unknown"""
    rotor_inertia: float = Field(default=0.0, ge=0)
    """kg·m², on the motor's side"""
    damping: float = Field(default=0.0, ge=0)
    """N·m·s/rad across the elastic joint"""
    tilt_stiffness: AboveZero | None = None
    """N·m/rad of the bearing, about the two axes across the joint"""
    repeatability: float | None = Field(default=None, ge=0)
    """rad or m, one sigma"""


class Compensator(_Table):
    """A gravity compensator: a gas cylinder or a spring that pulls two pivots together.

    gas:    F = A (p (l / (l − (s − reference)))^n − 101325 Pa), s the distance of the pivots
    spring: F = rate (s − free_length)
    """

    kind: Literal["gas", "spring"]
    """gas: a cylinder; spring: a spring; both pull their pivots together"""
    joint: str
    """the joint that it relieves"""
    body: str
    """link that carries the fixed pivot"""
    arm: str
    """link that carries the moving pivot"""
    body_pivot: Vector3
    """m, in that link's frame of the URDF"""
    arm_pivot: Vector3
    """m, in that link's frame of the URDF"""
    piston_area: AboveZero | None = None
    """m² (gas)"""
    precharge: AboveZero | None = None
    """Pa absolute, at `reference` (gas)"""
    gas_length: AboveZero | None = None
    """m, volume by area at `reference` (gas)"""
    reference: AboveZero | None = None
    """m, distance of the pivots at which precharge and length hold (gas)"""
    exponent: float = Field(1.0, ge=1.0, le=1.4)
    """1 isothermal to 1.4 adiabatic (gas)"""
    rate: AboveZero | None = None
    """N/m (spring)"""
    free_length: float | None = None
    """m (spring)"""

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
    """of the link in the URDF"""
    bending_stiffness: AboveZero | None = None
    """EI, N·m²"""


class LoadData(_Table):
    """`[tool]` or `[payloads.heavy]`: mass and centre of mass in the flange frame."""

    mass_kg: Annotated[FiniteFloat, Field(ge=0)]
    """kg"""
    com_mm: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)
    """centre of mass in the flange's frame, mm"""


def stated_load(load: LoadData | None) -> tuple[float, tuple[float, float, float]]:
    """Mass [kg] and centre of mass [m, flange frame]; nothing for None."""
    if load is None:
        return 0.0, (0.0, 0.0, 0.0)
    x, y, z = load.com_mm
    return load.mass_kg, (1e-3 * x, 1e-3 * y, 1e-3 * z)


class EffectRecord(_Table):
    """One effect of an extended model: its cause, where it sits, its parameters by name."""

    cause: str
    """as `workbench causes` lists it"""
    joint: str | None = None
    """where it sits"""
    other: str | None = None
    """the joint that it moves with"""
    link: str | None = None
    """where it sits"""
    payload: str | None = None
    """which load"""
    order: float | None = None
    """cycles per joint turn; of a sliding joint 2π over its period in m"""
    variant: str = ""
    """of the cause, where it has some"""
    values: dict[str, float] = Field(default_factory=dict)
    """parameters by name, SI units"""


class RobotFile(_Table):
    """A robot's TOML, or a model.toml: that one has `[geometry]` and `[[effects]]` as well."""

    schema_: Literal[1] = Field(alias="schema")
    """the version of this format, 1"""
    name: FileName
    """short, without blanks"""
    title: str = ""
    """for pages"""
    urdf: str
    """the nominal rigid robot, beside this file"""
    flange: str
    """link that carries tool and targets"""
    base: str | None = None
    """link where the arm begins; absent: the URDF's root, or what stands on its `world`"""
    gravity: Vector3 | None = None
    """m/s² on the base's axes; absent: straight down in the URDF"""
    pose_repeatability_mm: AboveZero | None = None
    """ISO 9283 RP [mm] as the maker's data sheet states it, of the tool; absent = not known"""
    joints: tuple[JointData, ...] = ()
    """what is known of the moving joints; those not named are rigid"""
    compensator: Compensator | None = None
    """the gravity compensator, if there is one"""
    links: tuple[LinkData, ...] = ()
    """links that bend"""
    controller: Controller = Controller()
    """how the robot's controller counts joints and names frames"""
    source: dict[str, Any] = Field(default_factory=dict)
    """where each number comes from"""
    tool: LoadData | None = None
    """in a model.toml: what the campaign behind it carried"""
    payloads: dict[str, LoadData] = Field(default_factory=dict)
    """in a model.toml: the campaign's loads by name"""
    mounted: str = ""
    """in a model.toml of campaigns with other tools: the payload that is the tool of the last; poses that do
    not say what the arm carries have it"""
    geometry: dict[str, dict[str, float]] = Field(default_factory=dict)
    """in a model.toml: corrections by joint, Trans(tx, ty, tz) Rx Ry Rz [m, rad] before its motion, on the
    joint's axes in the URDF, which the smallest rotation turns so that z is the axis of motion; and of the
    `flange`, where fixed targets on it showed how it stands"""
    effects: tuple[EffectRecord, ...] = ()
    """in a model.toml: what was found"""
    prediction: Uncertainty | None = None
    """in a model.toml: how sure it is of the tool's place"""


class _LoopFile(_Table):
    """A TOML that holds a controller's loop and nothing else."""

    controller: Controller


def parse_loop(path: Path) -> Loop:
    """The `[controller.loop]` of a TOML file of its own. Raises `InputError` with its faults."""
    try:
        return _LoopFile.model_validate(read_toml(path)).controller.loop
    except ValidationError as error:
        raise InputError(toml_faults(path, error, _LoopFile)) from None


def parse_robot(path: Path) -> RobotFile:
    """The TOML's tables. Raises `InputError` with every fault of the file by itself."""
    try:
        return RobotFile.model_validate(read_toml(path))
    except ValidationError as error:
        raise InputError(toml_faults(path, error, RobotFile)) from None


def toml_faults(
    path: Path, error: ValidationError, model: type[BaseModel], examples: Mapping[str, str] = EXAMPLES
) -> list[Fault]:
    """The faults that pydantic found in a TOML file of the model, each with its line, key and value.

    examples: key → what a missing one looks like.
    """
    lines = places(read_text(path) if path.is_file() else "")
    faults = []
    for item in error.errors():
        *table, name = item["loc"] or ("file",)
        key, value = ".".join(str(part) for part in (*table, name)), item.get("input")
        plain = isinstance(value, str | int | float | bool) and item["type"] != "wrong_kind"
        what = item["msg"].removeprefix("Value error, ") + (f" (is {value!r})" if plain else "")
        what = SAID.get(item["type"], what)
        mend = "the first line is schema = 1" if key == "schema" else ""
        if item["type"] == "extra_forbidden":
            known = keys_at(model, tuple(table))
            mend = suggest(str(name), known) or f"known here: {', '.join(known)}"
        elif item["type"] == "missing":
            mend = examples.get(str(name), mend)
        line = line_of(item["loc"], lines)
        faults.append(Fault(f"{path} line {line}: {key}" if line else f"{path}: {key}", what, mend))
    return faults


def unknown_names(path: Path, file: RobotFile, joints: list[str], links: set[str]) -> list[Fault]:
    """What the TOML says of joints and links that the URDF's chain does not have, and what is missing."""
    faults = [
        Fault(f"{path}: links.{link.name}", "no such link in the URDF's chain", f"has: {sorted(links)}")
        for link in file.links
        if link.name not in links
    ]
    for kind, names in (
        ("joints", [one.name for one in file.joints]),
        ("links", [one.name for one in file.links]),
    ):
        faults += [
            Fault(f"{path}: {kind}.{name}", f"is there {names.count(name)} times", "keep one table")
            for name in dict.fromkeys(names) if names.count(name) > 1
        ]  # fmt: skip
    if file.mounted and file.mounted not in file.payloads:
        known = f"has: {[*file.payloads]}"
        faults.append(Fault(f"{path}: mounted", f"no payload {file.mounted!r}", known))
    for name, values in file.geometry.items():
        if name not in (*joints, FLANGE):
            faults.append(Fault(f"{path}: geometry.{name}", "no such joint", f"has: {joints}, {FLANGE}"))
        faults += [
            Fault(f"{path}: geometry.{name}.{key}", "unknown key", f"one of {GEOMETRY}")
            for key in values
            if key not in GEOMETRY
        ]
    if (compensator := file.compensator) is not None:
        place = f"{path}: compensator"
        faults += [Fault(f"{place}.{name}", f"missing, a {compensator.kind} compensator needs it")
                   for name in compensator.missing()]  # fmt: skip
        if compensator.body == compensator.arm:
            faults.append(Fault(f"{place}.arm", "its pivots are on one link", "body and arm are two links"))
        if compensator.joint not in joints:
            faults.append(Fault(f"{place}.joint", f"no joint {compensator.joint!r}", f"has: {joints}"))
        faults += [
            Fault(f"{place}.{key}", f"no link {link!r}", f"has: {sorted(links)}")
            for key, link in (("body", compensator.body), ("arm", compensator.arm))
            if link not in links
        ]
    return faults
