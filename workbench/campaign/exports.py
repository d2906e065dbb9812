"""How others write points and poses: layouts by name, for `template` in `[points]` and in `[poses]`.

`group` and `point` of SpatialAnalyzer are taken as pose and target, since a group is usually measured per
pose; the other lists name one point per pose. Whatever differs is said beside the template, and counts.
"""

from __future__ import annotations

from typing import Any

from .program_joints import PROGRAMS

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


def _program(name: str) -> dict[str, Any]:
    """The layout of what `program_joints` makes of a program."""
    unit = "rad" if name in _RADIANS else "deg"
    axes = {f"q{i}_{unit}": i + 1 for i in range(1, 7)}
    return {"header": False, "separator": ",", "columns": {"pose_id": 1, **axes}}


PROGRAM_EXPORTS = {name: _program(name) for name in PROGRAMS}
