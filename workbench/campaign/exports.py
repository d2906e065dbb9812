"""How programs of instruments export points: layouts by name, for `template` in `[points]`.

`group` and `point` of SpatialAnalyzer are taken as pose and target, since a group is usually measured per
pose; the other lists name one point per pose. Whatever differs is said beside the template, and counts.
"""

from __future__ import annotations

from typing import Any

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
