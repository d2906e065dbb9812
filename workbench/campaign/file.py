"""`campaign.toml`, and the columns that its two tables may have."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, FiniteFloat, ValidationError, model_validator

from ..files.faults import Fault, InputError
from ..files.section import Section
from ..files.tables import Column, ColumnPlace, Layout
from ..files.toml import read_toml, toml_key
from ..robot.description import Joint, Robot
from ..robot.schema import EXAMPLES, LoadData, toml_faults
from .cell import CellData, DrivingData, InstrumentData, ObstacleData
from .exports import EXPORTS, PROGRAM_EXPORTS
from .known import KnownData, Name

Vector3 = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class TableFile(Layout):
    """`[poses]` or `[points]`: a file and how it is laid out; template: as a program exports it."""

    file: Name
    """beside this file"""

    @model_validator(mode="before")
    @classmethod
    def _as_exported(cls, data: Any) -> Any:
        name = data.get("template") if isinstance(data, dict) else None
        known = {**EXPORTS, **PROGRAM_EXPORTS}.get(name) if isinstance(name, str) else None
        return {**known, **data} if known else data


Turns = Literal["quaternion", "xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "vector"]


class PointsFile(TableFile):
    """`[points]`; wide: targets side by side, the columns of x, y and z of each."""

    template: Literal[*EXPORTS] | None = None  # type: ignore[valid-type]
    """the layout of a program's export; what is said beside it counts"""
    wide: dict[Name, tuple[ColumnPlace, ColumnPlace, ColumnPlace]] = Field(default_factory=dict)
    """targets side by side: name → columns of x, y and z"""
    turned_mm: Annotated[FiniteFloat, Field(gt=0)] | None = None
    """6-D measurement: columns qw, qx, qy, qz, or rx, ry, rz, say how the target is turned; it is read as
    three points, NAME, NAME_x and NAME_y, the two so far along its axes: about as far as the targets are from
    the flange. Leave it out where single reflectors are in the table: all are read as points then"""
    turns: Turns | None = None
    """what rx, ry and rz are: angles about these axes, which stand still, in this order (about axes that turn
    with it: the letters backwards), or a rotation vector; left out: what turns as the flange does"""


class PosesFile(TableFile):
    """`[poses]`: joints counts the joint columns as the URDF does, or as the robot's controller does."""

    template: Literal[*PROGRAM_EXPORTS] | None = None  # type: ignore[valid-type]
    """the file is a robot program: the joint positions in it, a row each, column 1 their name (or number),
    the axes behind it in degrees, of URScript in radians; what is said beside it counts"""
    joints: Literal["urdf", "controller"] = "urdf"
    """how the joint columns count: as the URDF does, or as the robot's controller does, whose names of joints
    are known then, in the header and under `columns`"""


class TargetData(Section):
    """`[targets.T1]`."""

    xyz_mm: Vector3 | None = None
    """nominal place, re-fitted unless fixed (to some 5 mm where the hand hardly turns); absent = unknown"""
    on: Name = "flange"
    """flange, base, or a link's name"""
    fixed: bool = False
    """the place is calibrated: nothing fits it; three on the base say where that is, one on the flange beside
    the last axis how the flange stands about it"""
    opens: Vector3 | None = None
    """direction into which its reflector opens, in the frame of `on`; absent: a plan proposes one"""


class NoiseData(Section):
    """`[noise]`."""

    sigma_mm: Annotated[FiniteFloat, Field(ge=1e-5)] | None = None
    """of the instrument, one sigma per axis; absent = estimated from repeated poses; beside columns sx, sy,
    sz of the points it holds where these are empty or 0"""
    pose: bool = False
    """the targets of a pose are points of one 6-D measurement, wild as a whole or not at all"""


class CampaignFile(Section):
    """The whole of `campaign.toml`."""

    schema_: Literal[1] = Field(alias="schema")
    """the version of this format, 1"""
    title: str = ""
    """for pages"""
    robot: Name
    """a robot that comes along, or the path of a robot's TOML from this file"""
    poses: PosesFile
    """what the controller was told"""
    points: PointsFile
    """what the instrument saw, in its own frame"""
    targets: dict[Name, TargetData] = Field(default_factory=dict)
    """what it looked at, by name"""
    noise: NoiseData = NoiseData()
    """of the measurement"""
    known: KnownData = KnownData()
    """besides what was measured here"""
    tool: LoadData = LoadData(mass_kg=0.0)
    """always mounted"""
    payloads: dict[Name, LoadData] = Field(default_factory=dict)
    """loads by their names in the poses"""
    instrument: InstrumentData | None = None
    """where it stands, for plans"""
    obstacles: tuple[ObstacleData, ...] = ()
    """what the robot must not touch, and what it carries, for plans"""
    driving: DrivingData = DrivingData()
    """how planned poses are driven to"""

    @property
    def cell(self) -> CellData:
        """What a plan looks at."""
        return CellData(instrument=self.instrument, obstacles=self.obstacles, driving=self.driving)


def read_campaign_file(path: Path) -> CampaignFile:
    """Parse and check `campaign.toml`; `InputError` with all its faults."""
    content = read_toml(path)
    if "urdf" in content:
        what, mend = "is a robot, not a campaign", "name a campaign.toml, whose robot = may name this file"
        raise InputError(Fault(str(path), what, mend))
    try:
        file = CampaignFile.model_validate(content)
    except ValidationError as error:
        raise InputError(toml_faults(path, error, CampaignFile, _EXAMPLES)) from None
    faults = [
        Fault(f"{path}: targets.{toml_key(name)}.fixed", "a fixed target needs its place", "give xyz_mm")
        for name, target in file.targets.items()
        if target.fixed and target.xyz_mm is None
    ]
    faults += [
        Fault(f"{path}: targets.{toml_key(name)}.opens", "is no direction", "give a vector that is not zero")
        for name, target in file.targets.items()
        if target.opens is not None and not any(target.opens)
    ]
    if file.points.wide and file.points.turned_mm is not None:
        mend = "give the targets of a 6-D measurement a row each, or take it out"
        faults.append(Fault(f"{path}: points.turned_mm", "does not go with targets side by side", mend))
    if faults:
        raise InputError(faults)
    return file


_EXAMPLES = EXAMPLES | {
    "schema": "schema = 1",
    "robot": 'robot = "kr500", or the path of a robot TOML',
    "poses": '[poses] with file = "poses.csv"',
    "points": '[points] with file = "points.csv"',
    "file": 'file = "poses.csv", say',
}


UNSEEN = "leave x, y and z empty, or the line out, of a point that was not seen"
QUATERNION = ("qw", "qx", "qy", "qz")
ANGLES = ("rx", "ry", "rz")
TIME = Column("t", ("time",), blank=True, mend="write seconds from any beginning, or leave the cell empty")
WRENCH_COLUMNS = tuple(
    Column(f"{kind}{axis}", (dimension,), mend="write 0 where there is none")
    for kind, dimension in (("f", "force"), ("m", "torque"))
    for axis in "xyz"
)


def joint_column(
    name: str, joint: Joint, required: bool = False, blank: bool = False, mend: str = ""
) -> Column:
    """A column of a joint's positions."""
    slides = joint.kind == "prismatic"
    dimension, moves = ("length", "slides") if slides else ("angle", "turns")
    return Column(
        name,
        (dimension,),
        required=required,
        blank=blank,
        wild=required,
        subject=f"{joint.name} {moves}",
        mend=mend,
    )


def pose_columns(robot: Robot, joints: Sequence[Joint] = ()) -> list[Column]:
    """The columns of `poses.csv` for this robot; joints: in another order than the chain's."""
    columns = [
        Column("pose_id", text=True, mend="name every pose"),
        Column("payload", text=True, blank=True),
        Column("setup", text=True, blank=True),
        TIME,
        Column("temp", ("temperature",), blank=True),
        *WRENCH_COLUMNS,
    ]
    for index, joint in enumerate(joints or robot.joints, 1):
        position = joint_column(f"q{index}", joint, required=True, mend="a pose needs all its joints")
        pull = ("force",) if joint.kind == "prismatic" else ("torque",)
        columns += [
            position,
            joint_column(f"r{index}", joint, blank=True),
            Column(f"tau{index}", pull, blank=True, subject=position.subject),
            Column(f"dir{index}", mend="write -1, 0 or 1 (0: none or not known)"),
        ]
    return columns


def point_columns(file: CampaignFile, named: bool = False) -> list[Column]:
    """The columns of `points.csv`. With a single target, its column may be left out, and that of the pose
    where the points stand in the order of the poses (unless `named`)."""
    stated = file.noise.sigma_mm is not None
    sigma = "" if stated else "give it for every point, or state [noise] sigma_mm for the others"
    return [
        Column("pose_id", text=True, required=named, mend="every point belongs to a pose"),
        Column("target", text=True, required=len(file.targets) > 1, mend="name the target of every point"),
        *(Column(axis, ("length",), required=True, blank=True, wild=True, mend=UNSEEN) for axis in "xyz"),
        *(Column(f"s{axis}", ("length",), blank=stated, mend=sigma) for axis in "xyz"),
        *(Column(name, blank=True) for name in QUATERNION),
        *(Column(name, ("angle",), blank=True) for name in ANGLES),
        TIME,
    ]
