"""The scene: robot, measured points and error arrows, before and after, in one HTML file.

Drake's Meshcat draws the robot and writes the file; `report/scene_overlay.html` goes into it and
draws points and arrows, so that their enlargement and the stage can be changed while looking.
"""

from __future__ import annotations

import base64
import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .atomic import put
from .diagnose.result import Diagnosis, PoseErrors
from .robot import Robot

Array = NDArray[np.float64]
OVERLAY = Path(__file__).with_name("report") / "scene_overlay.html"
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
    with _meshcat() as meshcat:
        reach = _draw_robot(meshcat, robot, pose, "/robot")
        if ghost_q is not None:
            _draw_robot(meshcat, robot, np.asarray(ghost_q, dtype=float), "/ghost")
        data = _data(diagnosis, reach, ghost_label if ghost_q is not None else "")
        _look(meshcat, data["centre"], data["extent"], reach[-1] - reach[0])
        html: str = meshcat.StaticHtml()
    overlay = OVERLAY.read_text(encoding="utf-8").replace("/*DATA*/", _script_json(data))
    title = f"<title>{_plain(diagnosis.robot_title)}, {_plain(diagnosis.campaign)}</title>"
    html = html.replace("<title>Drake MeshCat</title>", title)
    head, end, tail = html.rpartition("</body>")
    return head + overlay + end + tail


@contextmanager
def _meshcat() -> Iterator[Any]:
    """A Meshcat of its own, without a line on the console and without visitors from outside."""
    from pydrake.geometry import Meshcat, MeshcatParams

    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.WARNING)
    try:
        yield Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    finally:
        log.setLevel(level)


def _draw_robot(meshcat: Any, robot: Robot, q: Array, prefix: str) -> Array:
    """Publish the robot's visuals at joints q; places of its links (L, 3) [m]."""
    from pydrake.geometry import MeshcatVisualizer, MeshcatVisualizerParams
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder: Any = DiagramBuilder()
    plant, graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    Parser(plant).AddModels(robot.urdf)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(robot.base))
    plant.Finalize()
    params = MeshcatVisualizerParams(prefix=prefix, delete_on_initialization_event=False)
    MeshcatVisualizer.AddToBuilder(builder, graph, meshcat, params)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    positions = plant.GetPositions(own)
    for joint, value in zip(robot.joints, q, strict=True):
        positions[plant.GetJointByName(joint.name).position_start()] = value
    plant.SetPositions(own, positions)
    diagram.ForcedPublish(context)
    links = (robot.base, *robot.links)
    return np.array(
        [plant.EvalBodyPoseInWorld(own, plant.GetBodyByName(link)).translation() for link in links]
    )


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
        "points": _pack(errors.points[::step]),
        "stages": [{"name": name, "errors": _pack(e[::step])} for name, e in stages],
        "pose": errors.pose[::step].tolist(),
        "target": errors.target[::step].tolist(),
        "factor": _round(LONGEST * extent / max(large, 1e-9)),
        "noise_mm": diagnosis.noise.sigma_mm * float(np.sqrt(3)),
        "largest_mm": 1e3 * large,
        "extent": extent,
        "centre": ((low + high) / 2).tolist(),
        "ghost": ghost,
        "all": len(errors.points),
    }


def _look(meshcat: Any, centre: list[float], extent: float, arm: Array) -> None:
    """The camera, looking at the side of the arm (base to flange); a light ground; no axes."""
    azimuth = np.arctan2(arm[1], arm[0]) - np.radians(60)
    ahead = np.array([1.22 * np.cos(azimuth), 1.22 * np.sin(azimuth), 0.43])
    left = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
    middle = np.array(centre) + 0.12 * extent * left  # room for the panel
    meshcat.SetCamera(meshcat.PerspectiveCamera(fov=38, near=0.05, far=200))
    meshcat.SetCameraPose(middle + extent * ahead, middle)
    for name in ("/Axes", "/Grid"):
        meshcat.SetProperty(name, "visible", False)
    meshcat.SetProperty("/Background", "top_color", [0.985, 0.988, 0.992])
    meshcat.SetProperty("/Background", "bottom_color", [0.86, 0.88, 0.905])


def _no_errors() -> PoseErrors:
    none, number = np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    return PoseErrors(none, none, none, none, number, number)


def _pack(values: Array) -> str:
    """(k, 3) as little-endian 32-bit numbers in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()


def _round(value: float) -> float:
    """To 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1, 2, 5) if step <= value / power * 1.001))


def _script_json(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(data).replace("<", "\\u003c")


def _plain(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
