"""The loop closed: commands corrected by each model of the KR 500, run by the true robot under its load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import (
    Array,
    Campaign,
    CellModel,
    Figure,
    Path,
    Robot,
    Truth,
    charts,
    compensate,
    conditions_of,
    nominal_joints,
    path_shapes,
    planned,
    two_steps,
)

from .loads import exact
from .protocol import BOX, HAND, clock

LABELS = {"constant": "constant stiffness", "128": "128 cells", "named": "soft zone named"}
LINE_COLOURS = {"constant": charts.MIDDLE, "128": charts.PRINTED, "named": charts.OURS}


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
    weight, conditions = two_steps.external(check).poses.wrench[-1], conditions_of(check, payload)
    out: dict[str, float] = {}
    for name, path in paths.items():
        cut = {key: models[key].compensate(path, weight) for key in ("constant", "128")}
        whole = compensate(physical, path, conditions, tool=HAND)
        wanted = whole.X_desired[:, :3, 3]
        q = {"raw": whole.q_nominal, **{key: one.q for key, one in cut.items()}, "named": whole.q_command}
        error = {}
        for key, joints in q.items():
            place = exact(_carrying(check, payload, joints), truth)[:, 0]
            error[key] = 1e3 * np.linalg.norm(place - wanted, axis=1)
            out |= {f"{name}_{key}_mm": error[key].mean(), f"{name}_{key}_max_mm": error[key].max()}
    jumps = cut["128"].jump_mm
    way = 1e3 * np.linalg.norm(wanted - wanted[0], axis=1)
    return {**out, "jump_mm": jumps.max(), "walls": len(jumps)}, _line_figure(way, error)


def paths(robot: Robot, check: Campaign) -> dict[str, Path]:
    """The verification points, and a line across the box."""
    count = len(check.poses.q) // 2
    return {"points": Path(clock(count), check.poses.q[count:]), "line": across(robot, check.poses.q[0])}


def across(robot: Robot, start: Array) -> Path:
    """A straight line through the box, the tool straight down; start: (n,) joints near its first pose."""
    frame = path_shapes.work_frame(BOX[0] + [0.03, 0.05, 0.37], along=(0.54, 1.1, 0))
    run = path_shapes.Run(frame, speed=0.1, period=0.1, R_WT=frame[:3, :3].T @ path_shapes.tilted(0.0))
    drawn = path_shapes.line(1.22, run)
    return Path(drawn.time, nominal_joints(robot, drawn, HAND, start=start))


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
    series = {label: charts.Series(error[key], colour=LINE_COLOURS[key]) for key, label in LABELS.items()}
    title = "The corrected line under 50 kg: cells step at their walls, a physical model does not"
    return charts.curves("line", title, way, series, "along the line, mm", "distance from the line, mm")
