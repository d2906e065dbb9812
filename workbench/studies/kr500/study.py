"""KUKA KR 500: kinematics and stiffness of its own for every cell of the workspace (source 001).

The paper identifies constant parameters, then parameters per cell, and finds that small cells predict the
bend under 50 kg better: so "the joint stiffness varies indeed". Question: what do cells gain when stiffness
is constant, what do they gain when an effect of the load is missing, and can that effect be named?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.campaign import Campaign, Target, write_campaign
from workbench.campaign.planned import planned
from workbench.campaign.problem import problem
from workbench.correction import nominal_joints
from workbench.correction.path_shapes import Run, line, tilted, work_frame
from workbench.correction.paths import Path as Course
from workbench.diagnosis.run import Outcome, diagnose
from workbench.identification.cells import CellModel, cells, fit_cells, write_cells
from workbench.identification.cells.two_steps import part
from workbench.report.story import Item, tell
from workbench.report.study import Shown, Study
from workbench.robot.description import Robot, load_robot
from workbench.robot.kinematics import Array
from workbench.robot.rotations import pose
from workbench.simulation.virtual_campaign import Truth, random_geometry
from workbench.studies.kr500 import figures as told
from workbench.studies.kr500.commands import commanded
from workbench.studies.kr500.count import allowed_table, count_figure, how_many
from workbench.studies.kr500.loads import IN_BASE, Case, errors, identifiable, measured, modelled, sideways
from workbench.studies.kr500.missing import candidates, diagnosis_table, extended

# printed: K1 ... K6 of equations (18)-(21) and of Table 1 [N·m/rad; the paper has N·mm/rad]
EQUATIONS = {
    "(18)": 1e6 * np.array([14.9, 6.03, 5.56, 0.370, 0.252, 0.453]),
    "(19)": 1e6 * np.array([15.6, 6.12, 5.83, 0.459, 0.219, 0.479]),
    "(20)": 1e6 * np.array([14.8, 5.58, 6.81, 0.368, 0.140, 0.206]),
    "(21)": 1e6 * np.array([14.9, 6.81, 4.81, 0.228, 0.399, 0.165]),
}
TABLE_1 = 1e6 * np.array([
    [10.6, 5.56, 6.40, 0.324, 0.131, 0.204], [6.85, 5.59, 6.29, 0.188, 0.0923, 0.126],
    [8.24, 5.88, 6.04, 0.168, 0.0730, 0.120], [10.1, 7.51, 4.29, 0.183, 0.288, 0.183],
    [1.82, 5.36, 6.80, 0.0627, 0.117, 0.0627], [2.05, 5.39, 8.57, 0.0576, 0.0728, 0.0576],
    [2.51, 5.48, 9.24, 0.0564, 0.0507, 0.0564], [2.64, 6.85, 4.88, 0.0520, 0.205, 0.0520],
    [69.5, 5.04, 6.36, 0.706, 0.142, 0.474], [8.29, 4.95, 6.13, 0.260, 0.0946, 0.180],
    [10.6, 5.42, 5.46, 0.234, 0.110, 0.207], [4.37, 7.32, 4.27, 0.117, 1.16, 0.113],
    [2.70, 4.50, 7.49, 0.122, 0.128, 0.0733], [2.83, 4.70, 8.53, 0.101, 0.0812, 0.0456],
    [2.64, 5.13, 7.38, 0.0762, 0.0811, 0.0360], [2.24, 6.72, 4.39, 0.0562, 0.230, 0.0249],
])  # fmt: skip
CUBICS = [f"{i // 4 + 1}.{i % 4 + 1}" for i in range(16)]
CUTS = {"constant": (1, 1, 1), "2": (1, 2, 1), "16": (2, 4, 2), "128": (4, 8, 4)}
USED = {"": "128", "named_": "2", "few_": "constant"}  # records behind the cells, the diagnosis, the least
PRINTED_ERROR = {  # mean, and largest where it is given [mm]
    "raw": (0.2567, 0.3244),
    "theory": (0.1104,),
    "constant": (0.1049, 0.1434),
    "2": (0.0989, 0.1434),
    "16": (0.0761, 0.1129),
    "128": (0.0581, 0.0981),
}

# not in the paper: the story says why
BOX = np.array([[0.95, -0.6, 1.3], [1.55, 0.6, 1.9]])
SMR, MASS, TOOL = (0.08, 0.05, 0.25), (50.0, (0.06, 0.0, 0.2)), (10.0, (0.0, 0.0, 0.1))
SIGMA = 20e-6
SIDE = np.array([200.0, 200.0, -400.0])  # N: a load that K1 would feel
TILTS = (-10.0, 0.0, 10.0)
HAND = pose(np.array([SMR]), np.eye(3)[None])[0]
SOFT, WIDTH = 4e-4, 200.0  # rad, N·m: what joint 2 yields beside its spring, and below which torque


def soft_zone(wrench: Array) -> Array:
    """(6,) motion of joint 2 beyond τ/K: a law that the catalogue does not have."""
    x = wrench[5] / WIDTH
    return np.array([0, 0, 0, 0, 0, SOFT * x / np.sqrt(1 + x**2)])


def study(folder: Path, seed: int, quick: bool, progress: Callable[[str], None]) -> Study:
    """Two true robots, (a) of constant stiffness, (b) with a soft zone; the paper's protocol on both."""
    robot = load_robot("kr500")
    rng = np.random.default_rng([seed, 1])
    fine = cells(BOX, CUTS["128"])
    points = fine.draw(rng)
    grid, check = plan(robot, fine.samples), plan(robot, points, (0.0,))
    geometry = random_geometry(problem(check).arm, rng)
    case, models, said = {}, {}, {}
    for name, yields in {"a": {}, "b": {2: soft_zone}}.items():
        progress(f"({name}) measuring the points of all cells, three rotations, with and without 50 kg")
        case[name] = measured(grid, check, Truth(geometry, yields=yields, sigma=SIGMA), seed)
        progress(f"({name}) fitting 1, 2, 16 and 128 cells")
        models[name] = fitted(case[name].data)
        said[name] = {key: model.deflection(check)[len(points) :] for key, model in models[name].items()}
    truth, b = case["b"].truth, models["b"]
    write_cells(folder / "cells", b["128"])

    progress("asking how many cells the noise allows")
    draws = 1 if quick else 4
    trades = {name: how_many(case[name], said[name], check, BOX, CUTS, draws, seed) for name in case}

    progress("diagnosing the two cells' measurements")
    write_campaign(folder / "campaign", at(case["b"].data, "2"), comments=["simulated in Drake"])
    outcomes = diagnosed(case, quick, seed)
    physical = extended(folder / "model.toml", outcomes["b", "2"])
    said["b"]["named"] = modelled(physical, check)

    progress("a side load, and commands for the verification points and a line")
    whole = plan(robot, cells(BOX, CUTS["constant"]).samples)
    seen, singular = identifiable(whole, SIDE, SIGMA)
    ways = {"points": Course(clock(len(points)), check.q[len(points) :]), "line": across(robot, check.q[0])}
    by_cells = {key: b[key] for key in ("constant", "128")}
    driven, line_figure = commanded(ways, truth, by_cells, physical, check, "mass")
    n = errors("a", case["a"], said["a"]) | errors("b", case["b"], said["b"]) | singular | driven
    n |= sideways(truth, b["128"], physical, check, SIDE, TABLE_1[:, 0], BOX[:, 0].mean())
    n |= told.compared(n, case["b"], trades, models, PRINTED_ERROR["constant"][0])
    n |= {f"{key}records": len(at(case["b"].data, cut).q) for key, cut in USED.items()}
    n["remainder_p"] = outcomes["b", "2"].diagnosis.remainder_p
    n["printed_k1_ratio"] = TABLE_1[:, 0].max() / TABLE_1[:, 0].min()
    items: dict[str, Item] = {
        "errors": told.errors_figure(PRINTED_ERROR, n),
        "equations": told.equations_table(EQUATIONS, models),
        "seen": seen,
        "table 1": told.cells_table(CUBICS, TABLE_1, models["a"]["16"]),
        "scatter": told.scatter_table(TABLE_1, models),
        "count": count_figure(trades["a"], trades["b"]),
        "allowed": allowed_table(trades["b"]),
        "torque": told.torque_figure(plan(robot, fine.centres, (0.0,)), b["128"], soft_zone),
        "diagnosis": diagnosis_table(outcomes),
        "candidates": candidates(whole, check, PRINTED_ERROR),
        "line": line_figure,
    }
    shown = Shown(check.q[0], points, left_by(case["b"].true, said["b"]), noise=SIGMA)
    files = {"Campaign": "campaign/campaign.toml", "Model": "model.toml", "Cells": "cells/cells.toml"}
    return tell(Path(__file__).with_name("story.md"), robot, n, items, shown, "errors", files)


def plan(robot: Robot, points: Array, tilts: Sequence[float] = TILTS) -> Campaign:
    """The tool straight down at each point (M, 3) and tilted about its y [deg]: all poses without load, then
    all of them with 50 kg."""
    R = np.array([tilted(tilt) for tilt in tilts] * len(points))
    path = Course(clock(len(R)), X=pose(np.repeat(points, len(tilts), axis=0), R))
    q = nominal_joints(robot, path, HAND, start=np.deg2rad([0, -90, 90, 0, 60, 0]))
    payload = [""] * len(q) + ["mass"] * len(q)
    target, title = Target("SMR", SMR, fixed=True), "KR 500, one SMR, with and without 50 kg"
    return planned(robot, np.tile(q, (2, 1)), targets=[target], tool=TOOL, payloads={"mass": MASS},
                   payload=payload, title=title)  # fmt: skip


def clock(count: int) -> Array:
    """(count,) [s] time enough from pose to pose."""
    return 10.0 * np.arange(count, dtype=np.float64)


def at(data: Campaign, cut: str) -> Campaign:
    """The poses at the corners and centres of these cells; finer cells have all of them."""
    every, some = (cells(BOX, CUTS[key]).samples for key in ("128", cut))
    here = (np.abs(every[:, None] - some).max(axis=2) < 1e-6).any(axis=1)
    return part(data, np.tile(np.repeat(here, len(TILTS)), 2))


def fitted(data: Campaign) -> dict[str, CellModel]:
    """The paper's models, and constant stiffness from the measurements of all 128 cells."""
    found = {key: fit_cells(at(data, key), BOX, cut, instrument=IN_BASE) for key, cut in CUTS.items()}
    theory = fit_cells(at(data, "constant"), BOX, (1, 1, 1), instrument=IN_BASE, kinematics=False)
    return {"theory": theory, **found, "same": fit_cells(data, BOX, (1, 1, 1), instrument=IN_BASE)}


def diagnosed(case: Mapping[str, Case], quick: bool, seed: int) -> dict[tuple[str, str], Outcome]:
    """By true robot and by the cells whose points are measured."""
    cuts = [("a", "2"), ("b", "2")] + ([] if quick else [("b", "constant"), ("b", "16")])
    return {(name, cut): diagnose(at(case[name].data, cut), seed=seed) for name, cut in cuts}


def across(robot: Robot, start: Array) -> Course:
    """A straight line through the box, the tool straight down; start: (n,) joints near its first pose."""
    frame = work_frame(BOX[0] + [0.03, 0.05, 0.37], along=(0.54, 1.1, 0))
    drawn = line(1.22, Run(frame, speed=0.1, period=0.1, R_WT=frame[:3, :3].T @ tilted(0.0)))
    return Course(drawn.time, nominal_joints(robot, drawn, HAND, start=start))


def left_by(true: Array, said: Mapping[str, Array]) -> dict[str, Array]:
    """(C, 3) [m] what the load moves the verification points by, and what each model leaves of it."""
    names = {"constant": "constant stiffness", "128": "128 cells", "named": "soft zone named"}
    return {"uncompensated": true} | {name: true - said[key] for key, name in names.items()}


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
