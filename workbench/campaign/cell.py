"""What stands around the robot, and what measuring there takes: the instrument, obstacles, minutes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, ValidationError, model_validator

from ..files.faults import Fault, InputError
from ..files.section import Section
from ..files.toml import read_toml
from ..robot.schema import toml_faults

MOST = 1e6  # mm: what is said to be farther is a slip; of times likewise
Vector3 = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Millimetres = Annotated[FiniteFloat, Field(ge=-MOST, le=MOST)]
Place = tuple[Millimetres, Millimetres, Millimetres]
Positive = Annotated[FiniteFloat, Field(gt=0, le=MOST)]
NotNegative = Annotated[FiniteFloat, Field(ge=0, le=MOST)]


class InstrumentData(Section):
    """`[instrument]`: where it stands while it measures. Planned poses are those that it sees."""

    xyz_mm: Place
    """its measuring head, in the robot's base frame"""
    acceptance_deg: Annotated[FiniteFloat, Field(gt=0, le=180)] = 30.0
    """half the cone into which a reflector opens (of a 1.5 inch one about 30, of a probe as its maker
    says)"""


class ObstacleData(Section):
    """`[[obstacles]]`: a box or the convex hull of a mesh that the robot must not touch, or that it
    carries."""

    name: Annotated[str, Field(min_length=1)]
    """for messages"""
    box_mm: tuple[Positive, Positive, Positive] | None = None
    """edges of a box about its middle"""
    mesh: str | None = None
    """file in metres beside this one: .obj, .gltf, .stl"""
    xyz_mm: Place = (0.0, 0.0, 0.0)
    """where it is: the box's middle, the mesh's origin"""
    abc_deg: Vector3 = (0.0, 0.0, 0.0)
    """how it is turned: Rz(a) Ry(b) Rx(c)"""
    on: str = "base"
    """base: it stands in the robot's base frame; flange or a link's name: it is mounted there, as a tool
    is"""

    @model_validator(mode="after")
    def _one_shape(self) -> ObstacleData:
        if (self.box_mm is None) == (self.mesh is None):
            raise ValueError("an obstacle has box_mm or mesh")
        return self


class DrivingData(Section):
    """`[driving]`: how the poses are driven to, and what things cost."""

    speed_share: Annotated[FiniteFloat, Field(gt=0, le=1)] = 0.1
    """of the joints' full speed"""
    floor_mm: Millimetres | None = 0.0
    """height of the floor in the base frame"""
    clearance_mm: NotNegative = 20.0
    """that all bodies keep from each other"""
    check_every: Annotated[int, Field(ge=0)] = 15
    """poses between two returns to the check pose; 0: no check pose"""
    reflector_s: NotNegative = 3.0
    """for each reflector after the first at a standstill: about 3 where the tracker turns to them by itself,
    20 and more where one is moved by hand, 0 where all are seen at once"""
    load_change_min: NotNegative = 10.0
    """to mount another load"""
    pull_min: NotNegative = 5.0
    """to rig a horizontal pull, and to take it away"""
    warm_up_min: NotNegative = 120.0
    """to work the arm warm, or to let it cool: from one session of a plan to the next"""
    pull_N: Positive | None = None
    """of a horizontal pull at the flange that can be rigged; absent: none can"""


class CellData(Section):
    """The sections that a plan looks at, in `campaign.toml` or in a file of their own (`--cell`)."""

    instrument: InstrumentData | None = None
    """where it stands; absent: what it sees is not checked"""
    obstacles: tuple[ObstacleData, ...] = ()
    """what the robot must not touch, and what it carries"""
    driving: DrivingData = DrivingData()
    """how the poses are driven to"""


class _CellFile(CellData):
    schema_: Literal[1] = Field(alias="schema")
    """the version of this format, 1"""


def read_cell(path: Path) -> CellData:
    """The sections of a file of their own; meshes as its folder has them. Raises `InputError`."""
    try:
        file = _CellFile.model_validate(read_toml(path))
    except ValidationError as error:
        raise InputError(toml_faults(path, error, _CellFile)) from None
    return beside(CellData(instrument=file.instrument, obstacles=file.obstacles, driving=file.driving), path)


def beside(cell: CellData, path: Path) -> CellData:
    """The cell of the file `path`, with its meshes' files in full. Raises `InputError` where one is not
    there."""
    placed = tuple(
        one.model_copy(update={"mesh": str((path.parent / one.mesh).resolve())}) if one.mesh else one
        for one in cell.obstacles
    )
    faults = [
        Fault(f"{path}: obstacles {one.name!r}", f"no file {one.mesh}", "mend mesh, or give box_mm")
        for one in placed
        if one.mesh and not Path(one.mesh).is_file()
    ]
    if faults:
        raise InputError(faults)
    return cell.model_copy(update={"obstacles": placed})
