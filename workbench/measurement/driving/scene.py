"""The scene of a plan: the robot drives it, some of its poses stand as ghosts, rays go from the
instrument."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...report.meshcat_page import ASIDE, camera, draw_robot, look, meshcat_alone, pack, upright, with_panel
from ...robot.hulls import STANDING
from ...robot.kinematics import Array, frames
from .block import Drive
from .reach import Reach
from .sight import hides

GHOSTS = 7
NEARER, MARGIN = 1.05, 0.1  # of the scene's size: how far away the camera is, and what is left above
STOP, WAY = 0.5, 0.7  # s on the screen: of a standstill, and of the way to it
SIDES = (ASIDE, 60.0, -30.0, 30.0, -100.0, 100.0, -140.0, 140.0)  # degrees, the first best
OBSTACLE = (0.55, 0.45, 0.35, 0.8)


def scene(drive: Drive, reach: Reach) -> str:
    """The scene as one HTML text."""
    from pydrake.geometry import Box, Convex, Rgba
    from pydrake.math import RigidTransform

    robot, q = reach.robot, drive.records.poses.q
    known = np.flatnonzero(np.isfinite(reach.places).all(axis=1))
    points = frames(reach.arm, q).points(reach.places[known], [reach.on[t] for t in known])
    joints, time = _motion(drive)
    with meshcat_alone() as meshcat:
        links = draw_robot(meshcat, robot, joints, "/robot", time)
        for k in _spread(q, GHOSTS):
            draw_robot(meshcat, robot, q[k], f"/ghosts/{k}")
        for number, hull in enumerate(reach.hulls):
            if hull.slot == STANDING:
                shape = Convex(hull.vertices.T.copy(), hull.name)
                meshcat.SetObject(f"/obstacles/{number}", shape, Rgba(*OBSTACLE))
        view = upright(robot)
        data = _data(drive, reach, points, links, view)
        if data["eye"]:
            size = 0.02 * data["extent"]
            meshcat.SetObject("/instrument/box", Box(size, size, 2 * size), Rgba(0.1, 0.1, 0.12, 1))
            meshcat.SetTransform("/instrument/box", RigidTransform(np.array(data["eye"])))
        aside = _unhidden(reach, view, data["centre"], NEARER * data["extent"], links, points.reshape(-1, 3))
        arm = (links[-1] - links[0]) @ view
        look(meshcat, view, data["centre"], NEARER * data["extent"], arm, aside)
        html: str = meshcat.StaticHtml()
    return with_panel(html, "plan_overlay.html", data, f"{robot.title}: planned poses")


def _unhidden(
    reach: Reach, view: Array, centre: list[float], extent: float, links: Array, points: Array
) -> float:
    """From which side [degrees beside the arm] the robot and its targets are seen best past what stands
    around."""
    standing = [hull for hull in reach.hulls if hull.slot == STANDING]
    seen, arm = np.concatenate([links, points]), (links[-1] - links[0]) @ view

    def hidden(aside: float) -> int:
        eye = np.broadcast_to(view @ camera(centre, extent, arm, aside)[0], seen.shape)
        return int(np.any([hides(hull, eye, seen, carries=True) for hull in standing], axis=0).sum())

    return min(SIDES, key=hidden) if standing else ASIDE


def _motion(drive: Drive) -> tuple[Array, Array]:
    """Joints (F, n) and times on the screen (F,) through all that is driven."""
    joints, time, now = [drive.records.poses.q[0]], [0.0], 0.0
    for way, q in zip(drive.via[1:], drive.records.poses.q[1:], strict=True):
        for stop in (*way, q):
            now += STOP
            joints.append(joints[-1])
            time.append(now)
            now += WAY
            joints.append(stop)
            time.append(now)
    return np.array(joints), np.array(time)


def _spread(q: Array, count: int) -> NDArray[np.int64]:
    """Poses that are far from each other: the first, then always the farthest from those chosen."""
    size = np.ptp(q, axis=0) + 1e-9
    chosen = [0]
    for _ in range(min(count, len(q)) - 1):
        far = np.min([np.linalg.norm((q - q[k]) / size, axis=1) for k in chosen], axis=0)
        chosen.append(int(np.argmax(far)))
    return np.unique(chosen)


def _data(drive: Drive, reach: Reach, points: Array, links: Array, view: Array) -> dict[str, Any]:
    eye = None if reach.sight is None else reach.sight.eye
    standing = [hull.vertices for hull in reach.hulls if hull.slot == STANDING]
    seen = np.concatenate([points.reshape(-1, 3), links, *([] if eye is None else [eye[None]]), *standing])
    seen = seen @ view
    low, high = seen.min(axis=0), seen.max(axis=0)
    high[2] += MARGIN * float(np.linalg.norm(high - low))
    return {
        "points": pack(points.reshape(-1, 3)),
        "targets": points.shape[1],
        "ids": list(drive.records.poses.ids),
        "check": drive.check.tolist(),
        "eye": [] if eye is None else eye.tolist(),
        "obstacles": bool(standing),
        "extent": float(np.linalg.norm(high - low)),
        "centre": ((low + high) / 2).tolist(),
        "said": f"{len(drive.check)} standstills in about {drive.total_s / 60:.0f} min.",
    }
