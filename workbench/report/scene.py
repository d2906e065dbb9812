"""The scene: robot, measured points and error arrows, before and after, in one HTML file.

The page itself is `meshcat_page`'s; `templates/scene_overlay.html` goes into it and
draws points and arrows, so that their enlargement and the stage can be changed while looking.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..diagnosis.found import PoseErrors
from ..diagnosis.result import Diagnosis
from ..robot.description import Robot
from ..robot.kinematics import Array
from .meshcat_page import draw_robot, look, meshcat_alone, pack, round_factor, upright, with_panel

SCENE_POINTS = 6000  # at most
WHOLE = 1.4  # of what the links' frames span: room for a whole arm in the view
ABOVE = 0.25  # of their height: what an arm has above them
ARROW_LENGTH = 0.13  # of the scene's size: the length of a large nominal error's arrow


@dataclass(frozen=True)
class Shown:
    """What a scene shows. q: (n,) joints of the robot; points: (M, 3) [m] in the base frame; stages: name →
    errors (M, 3) [m] at the points, the worst first; pose, target: (M,) the number of each point's pose and
    target; noise: σ per axis [m], 0 where there is none; ghost_q: (n,) joints of a translucent second
    robot, for loaded against unloaded; `ghost_label` says what it is. suspicious: (M,) points to be red;
    which: a sentence on which errors these are. Without points the robot is all there is."""

    q: Array
    points: Array
    stages: Mapping[str, Array]
    pose: NDArray[np.int64] | None = None
    target: NDArray[np.int64] | None = None
    noise: float = 0.0
    ghost_q: Array | None = None
    ghost_label: str = ""
    suspicious: NDArray[np.bool_] | None = None
    which: str = ""


def scene(
    diagnosis: Diagnosis,
    robot: Robot,
    q: Array,
    ghost_q: Array | None = None,
    ghost_label: str = "",
) -> str:
    """The scene of a diagnosis as one HTML text, with the robot and its ghost at joints (n,); see `Shown`."""
    shown = replace(shown_of(diagnosis, q), ghost_q=ghost_q, ghost_label=ghost_label)
    return scene_of(robot, shown, f"{diagnosis.robot_title}, {diagnosis.campaign}")


def shown_of(diagnosis: Diagnosis, q: Array) -> Shown:
    """A diagnosis' points with their errors by stage, the robot at joints q: (n,)."""
    errors = diagnosis.errors or _no_errors()
    stages = {
        diagnosis.start.capitalize(): errors.error_nominal,
        "Geometry calibrated": errors.error_geometry,
    }
    if len(diagnosis.stages) > 2:
        stages["Causes in the model"] = errors.error_final
    noise, which = 1e-3 * diagnosis.noise.alone_mm, "Errors of the fitted poses."
    return Shown(q, errors.points, stages, errors.pose, errors.target, noise, which=which)


def scene_of(robot: Robot, shown: Shown, title: str) -> str:
    """Robot, points and errors as one HTML text."""
    with meshcat_alone() as meshcat:
        reach = draw_robot(meshcat, robot, np.asarray(shown.q, dtype=float), "/robot")
        if shown.ghost_q is not None:
            draw_robot(meshcat, robot, np.asarray(shown.ghost_q, dtype=float), "/ghost")
        view = upright(robot)
        data = _data(shown, reach @ view, view)
        look(meshcat, view, data["centre"], data["extent"], (reach[-1] - reach[0]) @ view)
        html: str = meshcat.StaticHtml()
    return with_panel(html, "scene_overlay.html", data, title)


def _data(shown: Shown, links: Array, view: Array) -> dict[str, Any]:
    """What the overlay draws: places and errors as packed numbers, stages, enlargement, colours; and
    where to look, on the axes of the view (3, 3), as the links (L, 3) are."""
    points = shown.points
    step = max(1, -(-len(points) // SCENE_POINTS))
    pose = np.arange(len(points)) if shown.pose is None else shown.pose
    target = np.zeros(len(points), dtype=np.int64) if shown.target is None else shown.target
    tall = float(np.ptp(links[:, 2]))
    above = links + np.array([0.0, 0.0, ABOVE * tall])
    seen = np.concatenate([points @ view, links, above])
    low, high = seen.min(axis=0), seen.max(axis=0)
    extent = float(np.linalg.norm(high - low)) * (1.0 if len(points) else WHOLE) or 1.0
    extent = max(extent, WHOLE * (1 + ABOVE) * tall)  # the arm is whole where points are in a corner
    sizes = np.linalg.norm(next(iter(shown.stages.values())), axis=1)
    large = float(np.quantile(sizes, 0.98)) if len(sizes) else 1e-3
    return {
        "points": pack(points[::step]),
        "stages": [{"name": name, "errors": pack(e[::step])} for name, e in shown.stages.items()],
        "pose": pose[::step].tolist(),
        "target": target[::step].tolist(),
        "factor": round_factor(ARROW_LENGTH * extent / max(large, 1e-9)),
        "noise_mm": 1e3 * (float(np.sqrt(3)) * shown.noise or large / 100),
        "largest_mm": 1e3 * large,
        "extent": extent,
        "centre": ((low + high) / 2).tolist(),
        "suspicious": [] if shown.suspicious is None else shown.suspicious[::step].tolist(),
        "which": shown.which if len(points) else "",
        "ghost": shown.ghost_label if shown.ghost_q is not None else "",
    }


def _no_errors() -> PoseErrors:
    none, number = np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    return PoseErrors(none, none, none, none, number, number)
