"""The loop closed: commands corrected by each model of the KR 500, run by the true robot under its load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...campaign import Campaign
from ...campaign.planned import planned
from ...correction import compensate, conditions_of
from ...correction.paths import Path
from ...identification.cells import CellModel
from ...identification.cells.two_steps import external
from ...report.charts import OURS, PRINTED, Series, curves
from ...report.drawing import MIDDLE, Figure
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.rotations import pose
from ...simulation.virtual_campaign import Truth
from .loads import exact

LABELS = {"constant": "constant stiffness", "128": "128 cells", "named": "soft zone named"}
COLOURS = {"constant": MIDDLE, "128": PRINTED, "named": OURS}


def commanded(
    paths: Mapping[str, Path],
    truth: Truth,
    models: Mapping[str, CellModel],
    physical: Robot,
    check: Campaign,
    payload: str,
) -> tuple[dict[str, float], Figure]:
    """Distances from each path by command, and their course along the last one, a line.

    models: of cells, by name; physical: the extended robot; check: a plan that states loads and target.
    """
    weight, conditions = external(check).wrench[-1], conditions_of(check, payload)
    hand = pose(np.array([check.targets[0].xyz]), np.eye(3)[None])[0]
    out: dict[str, float] = {}
    for name, path in paths.items():
        cut = {key: model.compensate(path, weight) for key, model in models.items()}
        whole = compensate(physical, path, conditions, tool=hand)
        wanted = whole.X_desired[:, :3, 3]
        q = {"raw": whole.q_nominal, **{key: one.q for key, one in cut.items()}, "named": whole.q_command}
        error = {}
        for key, told in q.items():
            place = exact(_carrying(check, payload, told), truth)[:, 0]
            error[key] = 1e3 * np.linalg.norm(place - wanted, axis=1)
            out |= {f"{name}_{key}_mm": error[key].mean(), f"{name}_{key}_max_mm": error[key].max()}
    jumps = cut["128"].jump_mm
    way = 1e3 * np.linalg.norm(wanted - wanted[0], axis=1)
    return {**out, "jump_mm": jumps.max(), "walls": len(jumps)}, _line_figure(way, error)


def _carrying(plan: Campaign, payload: str, q: Array) -> Campaign:
    """Poses q: (N, n) with a plan's tool and target, all of them with a payload of it."""
    i = plan.payload_names.index(payload)
    return planned(
        plan.robot,
        q,
        targets=plan.targets,
        tool=(plan.tool_mass, plan.tool_com.tolist()),
        payloads={payload: (float(plan.load_mass[i]), plan.load_com[i].tolist())},
        payload=[payload] * len(q),
    )


def _line_figure(way: Array, error: Mapping[str, Array]) -> Figure:
    series = {label: Series(error[key], colour=COLOURS[key]) for key, label in LABELS.items()}
    title = "The corrected line under 50 kg: cells step at their walls, a physical model does not"
    return curves("line", title, way, series, "along the line, mm", "distance from the line, mm")
