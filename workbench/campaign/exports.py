"""How others write points and poses: layouts by name, for `template` in `[points]` and in `[poses]`.

`group` and `point` of SpatialAnalyzer are taken as pose and target, since a group is usually measured per
pose; the other lists name one point per pose. Whatever differs is said beside the template, and counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .program_joints import ARM, PROGRAMS

_GROUPS = {
    "header": False,
    "comment": "//",
    "columns": {"pose_id": 2, "target": 3, "x_mm": 4, "y_mm": 5, "z_mm": 6},
}
_NAMED = {"header": False, "columns": {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}}

EXPORTS: dict[str, dict[str, Any]] = {
    "spatial-analyzer": {**_GROUPS, "separator": " "},  # collection group point x y z
    "spatial-analyzer-csv": {**_GROUPS, "separator": ","},
    "leica": {**_NAMED, "separator": ","},  # name, x, y, z
    "polyworks": {**_NAMED, "separator": " ", "comment": "#"},  # name x y z
}

_RADIANS = ("urscript",)  # of programs; the others state degrees


def program_columns(name: str, sliding: Sequence[bool]) -> dict[str, str | int]:
    """The columns of what `program_joints` makes of a program; sliding: of each joint, whether it does."""
    turning = "rad" if name in _RADIANS else "deg"
    units = ["mm" if slides else turning for slides in sliding]
    return {"pose_id": 1, **{f"q{i}_{unit}": i + 1 for i, unit in enumerate(units, 1)}}


PROGRAM_EXPORTS: dict[str, dict[str, Any]] = {
    name: {"header": False, "separator": ",", "columns": program_columns(name, [False] * ARM)}
    for name in PROGRAMS
}
