"""The scene of `workbench predict`: the tool's places coloured by the error to be expected, and where was
measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..identification.prediction import ToolErrors
from ..robot.description import Robot
from ..robot.kinematics import Array
from .meshcat_page import draw_robot, look, meshcat_alone, pack, upright, with_panel
from .workspace_map import class_edges, class_labels, opaque_colours

MOST_PLACES = 6000


def expected_scene(
    robot: Robot, errors: ToolErrors, values: Mapping[str, Array], measured: Array, title: str
) -> str:
    """The scene as one HTML text. values: by their names, (N,) [m] of each pose; measured: (M, 3) [m]
    places of the tool in the campaign."""
    places = errors.places.mean(axis=1)
    middle = int(np.argmin(np.linalg.norm(places - np.median(places, axis=0), axis=1)))
    with meshcat_alone() as meshcat:
        links = draw_robot(meshcat, robot, errors.campaign.poses.q[middle], "/robot")
        view = upright(robot)
        seen = np.concatenate([places, measured, links]) @ view
        low, high = seen.min(axis=0), seen.max(axis=0)
        extent = float(np.linalg.norm(high - low))
        centre = ((low + high) / 2).tolist()
        look(meshcat, view, centre, extent, (links[-1] - links[0]) @ view)
        html: str = meshcat.StaticHtml()
    step = max(1, -(-len(places) // MOST_PLACES))
    data = {
        "places": pack(places[::step]),
        "ids": list(errors.campaign.poses.ids[::step]),
        "outside": list(errors.outside[::step]),
        "measured": pack(measured),
        "colours": opaque_colours(),
        "stages": [_stage(name, value, errors.measured, step) for name, value in values.items()],
        "extent": extent,
        "factor": 1.0,
    }
    return with_panel(html, "predict_overlay.html", data, title)


def _stage(name: str, value: Array, inside: NDArray[np.bool_], step: int) -> dict[str, Any]:
    """One quantity: class of colour and millimetres of each place that is drawn, and what the classes are, by
    the values inside (N,) of what was measured; where none are, there are no classes to tell."""
    told = value[inside]
    edges = class_edges(told) if len(told) else np.full(4, np.inf)
    return {
        "name": name,
        "mean_mm": 1e3 * float(told.mean()) if len(told) else None,
        "largest_mm": 1e3 * float(told.max()) if len(told) else None,
        "labels": class_labels(edges) if len(told) else [],
        "level": np.searchsorted(edges, value[::step]).tolist(),
        "mm": [round(1e3 * float(one), 4) for one in value[::step]],
    }
