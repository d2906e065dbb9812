"""A page with a Meshcat scene: the robot at one pose or in motion, the camera, a panel over it.

Drake's Meshcat draws the robot and writes the file; the panel is HTML with a script that goes into it.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..robot.description import Robot
from ..robot.drake_faults import quiet
from ..robot.kinematics import Array
from ..robot.rotations import turn_z_to
from .legible import legible
from .markup import render

DRAKES_HEAD = re.compile(r"<head>.*?</head>", re.DOTALL)
ON_THE_BASE = ("/robot", "/ghost", "/ghosts", "/obstacles", "/instrument", "/overlay")  # drawn in its frame
ASIDE = -60.0  # degrees from the arm's direction, from where a scene is seen
FILE_NAMES = re.compile(r"^// .* from .*\n", re.MULTILINE)  # Drake's remarks where it found a mesh


@contextmanager
def meshcat_alone() -> Iterator[Any]:
    """A Meshcat of its own, without a line on the console and without visitors from outside."""
    from pydrake.geometry import Meshcat, MeshcatParams

    with quiet():
        yield Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))


def draw_robot(meshcat: Any, robot: Robot, q: Array, prefix: str, time: Array | None = None) -> Array:
    """Publish the robot and its compensator at joints q (n,), or in motion through q (F, n) at times (F,)
    [s]; places of its links (L, 3) [m] in the (first) pose."""
    from ..robot.rigid_plant import link_poses

    poses = link_poses(robot, np.atleast_2d(q))
    draw_links(meshcat, robot, poses, prefix, time)
    return np.asarray(poses[0, :, :3, 3])


def draw_links(meshcat: Any, robot: Robot, poses: Array, prefix: str, time: Array | None = None) -> None:
    """Publish the robot with base and links at poses (F, L, 4, 4) in the world: the first alone, or in motion
    through all of them at times (F,) [s]. The compensator stays between its pivots."""
    from pydrake.geometry import MeshcatVisualizer, MeshcatVisualizerParams
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    from ..robot.picture import picture

    builder: Any = DiagramBuilder()
    plant, graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    shown = picture(robot, plant)
    params = MeshcatVisualizerParams(prefix=prefix, delete_on_initialization_event=False)
    drawn = MeshcatVisualizer.AddToBuilder(builder, graph, meshcat, params)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)

    def show(instant: float, there: Array) -> None:
        context.SetTime(instant)
        shown.put(own, there)
        diagram.ForcedPublish(context)

    if time is not None:
        drawn.StartRecording()
        for instant, there in zip(time, poses, strict=True):
            show(float(instant), there)
        drawn.StopRecording()
        drawn.PublishRecording()
    show(0.0, poses[0])


def upright(robot: Robot) -> Array:
    """(3, 3) axes of a view in the base's, the last one up: a robot that hangs is seen to hang."""
    weight = float(np.linalg.norm(robot.gravity))
    return turn_z_to(-np.array(robot.gravity) / weight) if weight > 0 else np.eye(3)


def camera(centre: list[float], extent: float, arm: Array, aside: float = ASIDE) -> tuple[Array, Array]:
    """Where the camera stands, and what it looks at (3,): the side of the arm (base to flange)."""
    azimuth = np.arctan2(arm[1], arm[0]) + np.radians(aside)
    ahead = np.array([1.22 * np.cos(azimuth), 1.22 * np.sin(azimuth), 0.43])
    left = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
    middle = np.array(centre) + 0.12 * extent * left  # room for the panel
    return middle + extent * ahead, middle


def look(
    meshcat: Any, view: Array, centre: list[float], extent: float, arm: Array, aside: float = ASIDE
) -> None:
    """All upright in a view (3, 3) on the axes of which `centre` and `arm` are; the camera in its place; a
    light ground; no axes."""
    from pydrake.math import RigidTransform, RotationMatrix

    meshcat.SetCamera(meshcat.PerspectiveCamera(fov=38, near=0.05, far=200))
    meshcat.SetCameraPose(*camera(centre, extent, arm, aside))
    for name in ON_THE_BASE:
        meshcat.SetTransform(name, RigidTransform(RotationMatrix(view.T)))
    for name in ("/Axes", "/Grid"):
        meshcat.SetProperty(name, "visible", False)
    meshcat.SetProperty("/Background", "top_color", [0.985, 0.988, 0.992])
    meshcat.SetProperty("/Background", "bottom_color", [0.86, 0.88, 0.905])


def with_panel(html: str, panel: str, data: dict[str, Any], title: str) -> str:
    """Meshcat's page with a head that keeps it off the network, and a panel of `templates/` over it."""
    html, found = DRAKES_HEAD.subn(lambda _: render("scene_head.html", title=title), html, count=1)
    body, end, rest = FILE_NAMES.sub("", html).rpartition("</body>")
    if not (found and end):
        raise RuntimeError("Drake's Meshcat page is not built as it was: no head, or no end of the body")
    return body + render(panel, data=legible(data)) + end + rest


def pack(values: Array) -> str:
    """(k, 3) as little-endian 32-bit numbers in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()


def round_factor(value: float) -> float:
    """To 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1, 2, 5) if step <= value / power * 1.001))
