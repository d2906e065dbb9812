"""The scene: robot, measured points and error arrows, before and after, in one HTML file.

The page itself is `meshcat_page`'s; `report/scene_overlay.html` goes into it and
draws points and arrows, so that their enlargement and the stage can be changed while looking.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .atomic import put
from .diagnosis import Diagnosis, PoseErrors
from .meshcat_page import draw_robot, look, meshcat_alone, pack, round_factor, with_panel
from .robot import Robot

Array = NDArray[np.float64]
MOST_POINTS = 6000
LONGEST = 0.13  # of the scene's size: the length of a large nominal error's arrow


def write_scene(
    diagnosis: Diagnosis,
    robot: Robot,
    path: Path,
    q: Array | None = None,
    ghost_q: Array | None = None,
    ghost_label: str = "the same pose under load, deflection enlarged",
) -> Path:
    """Write `scene.html`; its path. See `scene` for the arguments."""
    put(path, scene(diagnosis, robot, q, ghost_q, ghost_label).encode())
    return path


def scene(
    diagnosis: Diagnosis,
    robot: Robot,
    q: Array | None = None,
    ghost_q: Array | None = None,
    ghost_label: str = "the same pose under load, deflection enlarged",
) -> str:
    """The scene as one HTML text.

    q: (n,) joints of the solid robot, default a pose in the middle of the campaign. ghost_q: (n,)
    joints of a translucent second robot, for loaded against unloaded; `ghost_label` says what it is.
    """
    pose = _middle_pose(diagnosis, robot) if q is None else np.asarray(q, dtype=float)
    with meshcat_alone() as meshcat:
        reach = draw_robot(meshcat, robot, pose, "/robot")
        if ghost_q is not None:
            draw_robot(meshcat, robot, np.asarray(ghost_q, dtype=float), "/ghost")
        data = _data(diagnosis, reach, ghost_label if ghost_q is not None else "")
        look(meshcat, data["centre"], data["extent"], reach[-1] - reach[0])
        html: str = meshcat.StaticHtml()
    title = f"{diagnosis.robot_title}, {diagnosis.campaign}"
    return with_panel(html, "scene_overlay.html", data, title)


def _middle_pose(diagnosis: Diagnosis, robot: Robot) -> Array:
    """The measured pose nearest to the median of all; joints at zero when there is none."""
    if diagnosis.q is None or len(diagnosis.q) == 0:
        return np.zeros(len(robot.joints))
    spread = np.std(diagnosis.q, axis=0) + 1e-9
    distance = np.linalg.norm((diagnosis.q - np.median(diagnosis.q, axis=0)) / spread, axis=1)
    return np.asarray(diagnosis.q[int(np.argmin(distance))])


def _data(diagnosis: Diagnosis, links: Array, ghost: str) -> dict[str, Any]:
    """What the overlay draws: places and errors as packed numbers, stages, enlargement, colours."""
    errors = diagnosis.errors or _no_errors()
    step = max(1, -(-len(errors.points) // MOST_POINTS))
    stages = [("Nominal model", errors.error_nominal), ("Geometry calibrated", errors.error_geometry)]
    if len(diagnosis.stages) > 2:
        stages.append(("Causes in the model", errors.error_final))
    seen = np.concatenate([errors.points, links])
    low, high = seen.min(axis=0), seen.max(axis=0)
    extent = float(np.linalg.norm(high - low)) * (1.0 if len(errors.points) else 1.4) or 1.0
    sizes = np.linalg.norm(errors.error_nominal, axis=1)
    large = float(np.quantile(sizes, 0.98)) if len(sizes) else 1e-3
    return {
        "robot": diagnosis.robot_title,
        "points": pack(errors.points[::step]),
        "stages": [{"name": name, "errors": pack(e[::step])} for name, e in stages],
        "pose": errors.pose[::step].tolist(),
        "target": errors.target[::step].tolist(),
        "factor": round_factor(LONGEST * extent / max(large, 1e-9)),
        "noise_mm": diagnosis.noise.sigma_mm * float(np.sqrt(3)),
        "largest_mm": 1e3 * large,
        "extent": extent,
        "centre": ((low + high) / 2).tolist(),
        "ghost": ghost,
        "all": len(errors.points),
    }


def _no_errors() -> PoseErrors:
    none, number = np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    return PoseErrors(none, none, none, none, number, number)
