"""KUKA KR 500: kinematics and stiffness of its own for every cell of the workspace.

“Variable Parameters Stiffness Identification and Modeling for Positional Compensation of Industrial Robots”
identifies constant parameters, then parameters per cell, and finds that small cells predict the bend under
50 kg better: so "the joint stiffness varies indeed". Question: what do cells gain when stiffness is constant,
what do they gain when an effect of the load is missing, and can that effect be named?
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Figure,
    Shown,
    Study,
    StudyRun,
    Table,
    Truth,
    as_package,
    cells,
    load_robot,
    problem_of,
    random_geometry,
    run_study,
    tell,
    write_campaign,
    write_cells,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from . import figures
from .commands import commanded, paths
from .count import allowed_table, count_figure, how_many
from .loads import errors, identifiable, measured, modelled, sideways
from .missing import candidates, diagnosed, diagnosis_table, extended
from .printed import CUTS, NUMBERS
from .protocol import BOX, at, fitted, plan

# not in the paper: the story says why
SIGMA = 20e-6  # m
SIDE = np.array([200.0, 200.0, -400.0])  # N: a load that K1 would feel
SOFT_YIELD, WIDTH = 4e-4, 200.0  # rad, N·m: what joint 2 yields beside its spring, and below which torque
USED = {"": "128", "named_": "2", "few_": "constant"}  # records behind the cells, the diagnosis, the least


def soft_zone(wrench: Array) -> Array:
    """(6,) motion of joint 2 beyond τ/K: a law that the catalogue does not have."""
    x = wrench[5] / WIDTH
    return np.array([0, 0, 0, 0, 0, SOFT_YIELD * x / np.sqrt(1 + x**2)])


def study(run: StudyRun) -> Study:
    """Two true robots, (a) of constant stiffness, (b) with a soft zone; the paper's protocol on both."""
    folder, seed, quick, progress = run.folder, run.seed, run.quick, run.say
    robot = load_robot("kr500")
    rng = np.random.default_rng([seed, 1])
    fine = cells(BOX, CUTS["128"])
    points = fine.draw(rng)
    grid, check = plan(robot, fine.samples), plan(robot, points, (0.0,))
    geometry = random_geometry(problem_of(check).arm, rng)
    case, models, predicted = {}, {}, {}
    for name, yields in {"a": {}, "b": {2: soft_zone}}.items():
        progress(f"({name}) measuring the points of all cells, three rotations, with and without 50 kg")
        case[name] = measured(grid, check, Truth(geometry, yields=yields, sigma=SIGMA), seed)
        progress(f"({name}) fitting 1, 2, 16 and 128 cells")
        models[name] = fitted(case[name].data)
        predicted[name] = {key: m.deflection(check)[len(points) :] for key, m in models[name].items()}
    write_cells(folder / "cells", models["b"]["128"])

    progress("asking how many cells the noise allows")
    draws = 1 if quick else 4
    trades = {name: how_many(case[name], predicted[name], check, draws, seed) for name in case}

    progress("diagnosing the two cells' measurements")
    write_campaign(folder / "campaign", at(case["b"].data, "2"), comments=["simulated in Drake"])
    outcomes = diagnosed(case, quick, seed)
    physical = extended(folder / "model.toml", outcomes["b", "2"])
    predicted["b"]["named"] = modelled(physical, check)

    progress("a side load, and commands for the verification points and a line")
    whole = plan(robot, cells(BOX, CUTS["constant"]).samples)
    seen, singular = identifiable(whole, SIDE, SIGMA)
    driven, line = commanded(paths(robot, check), case["b"].truth, models["b"], physical, check, "mass")

    n = (
        NUMBERS
        | errors("a", case["a"], predicted["a"])
        | errors("b", case["b"], predicted["b"])
        | singular
        | driven
    )
    n |= sideways(case["b"].truth, models["b"]["128"], physical, check, SIDE)
    n |= figures.compared(n, case["b"], trades, models)
    n |= {f"{key}records": len(at(case["b"].data, cut).poses.q) for key, cut in USED.items()}
    n["remainder_p"] = outcomes["b", "2"].diagnosis.remainder_p
    items: dict[str, Table | Figure] = {
        "errors": figures.errors_figure(n),
        "equations": figures.equations_table(models),
        "seen": seen,
        "table 1": figures.cells_table(models["a"]["16"]),
        "scatter": figures.scatter_table(models),
        "count": count_figure(trades["a"], trades["b"]),
        "allowed": allowed_table(trades["b"]),
        "torque": figures.torque_figure(plan(robot, fine.centres, (0.0,)), models["b"]["128"], soft_zone),
        "diagnosis": diagnosis_table(outcomes),
        "candidates": candidates(whole, check),
        "line": line,
    }
    shown = Shown(check.poses.q[0], points, left_by(case["b"].true, predicted["b"]), noise=SIGMA)
    files = {"Campaign": "campaign/campaign.toml", "Model": "model.toml", "Cells": "cells/cells.toml"}
    return tell(Path(__file__).with_name("story.md"), robot, n, items, shown, "errors", files)


def left_by(true: Array, predicted: Mapping[str, Array]) -> dict[str, Array]:
    """(C, 3) [m] what the load moves the verification points by, and what each model leaves of it."""
    names = {"constant": "constant stiffness", "128": "128 cells", "named": "soft zone named"}
    return {"uncompensated": true} | {name: true - predicted[key] for key, name in names.items()}


if __name__ == "__main__":
    run_study(study)
