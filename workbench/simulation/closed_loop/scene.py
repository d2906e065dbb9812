"""The scene: the simulated arm runs the path, its links where they were; tool paths as tubes, their errors
enlarged."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...report.meshcat_page import draw_links, look, meshcat_alone, pack, round_factor, upright, with_panel
from ...robot.kinematics import Array
from .pictures import COMMAND_COLOURS
from .verification import Verification, speed_text

FRAMES = 160
TUBE_POINTS = 1200  # at most
ERROR_SHOWN = 0.08  # of the path's size: how large the uncorrected error shows
PLAYED = 20.0  # s that the motion lasts on the screen, at most
SHORT_NAMES = {"uncorrected": "Uncorrected", "geometry": "Geometry only", "corrected": "Corrected"}
UNSEEN_AT_FIRST = ("geometry",)  # until they are asked for


def scene(found: Verification) -> str:
    """The scene at the slowest speed as one HTML text."""
    series = found.slow
    trial = series.trials["corrected"]
    frames = np.unique(
        np.searchsorted(series.time, np.linspace(0, series.time[-1], FRAMES)).clip(0, len(series.time) - 1)
    )
    pace = min(1.0, PLAYED / float(series.time[-1]))
    with meshcat_alone() as meshcat:
        poses = trial.links[frames]
        draw_links(meshcat, found.robot, poses, "/robot", pace * series.time[frames])
        view = upright(found.robot)
        links = poses[0, :, :3, 3] @ view
        data = _data(found, links, view)
        look(meshcat, view, data["centre"], 1.2 * data["extent"], links[-1] - links[0])
        html: str = meshcat.StaticHtml()
    return with_panel(html, "path_overlay.html", data, f"{found.robot.title}, {found.path.title}")


def _data(found: Verification, links: Array, view: Array) -> dict[str, Any]:
    """What the panel draws: the desired path and the errors of each command as packed numbers; and
    where to look, on the axes of the view (3, 3), as the links (L, 3) are."""
    series, p = found.slow, found.X[:, :3, 3]
    step = max(1, -(-len(p) // TUBE_POINTS))
    size = float(np.linalg.norm(np.ptp(p, axis=0))) or 0.1
    error = series.trials["uncorrected"].error
    large = max(float(np.quantile(np.linalg.norm(error, axis=1), 0.95)), 1e-9)
    seen = np.concatenate([p @ view, links])
    low, high = seen.min(axis=0), seen.max(axis=0)
    high[2] += 0.15 * float(np.linalg.norm(high - low))  # the elbow's shape stands above its axis
    return {
        "path": pack(p[::step]),
        "commands": [
            {
                "name": short,
                "shown": name not in UNSEEN_AT_FIRST,
                "colour": COMMAND_COLOURS[name],
                "errors": pack(series.trials[name].error[::step]),
                "rms_mm": series.trials[name].figures.rms_mm,
            }
            for name, short in SHORT_NAMES.items()
            if name in series.trials
        ],
        "factor": round_factor(ERROR_SHOWN * size / large),
        "speed": speed_text(series.speed),
        "size": size,
        "radius": max(0.0035 * size, 7e-4 * float(np.linalg.norm(high - low))),
        "extent": float(np.linalg.norm(high - low)),
        "centre": ((low + high) / 2).tolist(),
        "middle": (p.mean(axis=0) @ view).tolist(),
        "from": (links[-1] - links[0]).tolist(),
    }
