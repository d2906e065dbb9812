"""`residuals.csv`: what every measured point is off, before and after, for other programs to draw."""

from __future__ import annotations

import numpy as np

from ..diagnosis.found import PoseErrors
from ..diagnosis.result import Diagnosis
from ..files.tables import table_text

HEAD = (
    "pose_id", "target", "x_mm", "y_mm", "z_mm", "dx_mm", "dy_mm", "dz_mm", "nominal_mm", "geometry_mm",
    "error_mm",
)  # fmt: skip


def residuals(diagnosis: Diagnosis) -> dict[str, bytes]:
    """The table, by its name; nothing where the errors are not known. A row per point of the fitted poses:
    where it was measured, measured minus the model with everything in it (both in the base frame), and the
    length of the error with the nominal robot, with geometry alone, and with everything."""
    errors = diagnosis.errors
    if errors is None:
        return {}
    lengths = [
        np.linalg.norm(one, axis=1)[:, None]
        for one in (errors.error_nominal, errors.error_geometry, errors.error_final)
    ]
    numbers = 1e3 * np.hstack([errors.points, errors.error_final, *lengths])
    rows = [[*called(errors, k), *(f"{value:.4f}" for value in row)] for k, row in enumerate(numbers)]
    return {"residuals.csv": table_text(HEAD, rows).encode()}


def called(errors: PoseErrors, point: int) -> tuple[str, str]:
    """The pose and the target of a point, by name, or by number where there are no names."""
    pose, target = int(errors.pose[point]), int(errors.target[point])
    return (
        errors.pose_ids[pose] if errors.pose_ids else str(pose + 1),
        errors.target_names[target] if errors.target_names else str(target + 1),
    )
