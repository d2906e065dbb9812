"""KUKA KR 500: kinematics and stiffness of its own for every cell of the workspace (source 001).

The paper identifies constant parameters, then parameters per cell, and finds that small cells predict the
bend under 50 kg better: so "the joint stiffness varies indeed". Question: what do cells gain when stiffness
is constant, what do they gain when an effect of the load is missing, and can that effect be named?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.arm import Array
from workbench.campaign import Campaign, Target, write_campaign
from workbench.cells import (
    CellModel,
    Trade,
    cells,
    external,
    fit_cells,
    left_over,
    part,
    predicted,
    seated,
    trade,
    write_cells,
)
from workbench.compensate import compensate, nominal_joints, stated_conditions
from workbench.diagnose.run import Outcome, diagnose
from workbench.effects import catalogue
from workbench.effects.base import YieldEffect
from workbench.effects.joint_compliance import JointCompliance
from workbench.extended import loaded, write_model
from workbench.path_shapes import Run, line, tilted, work_frame
from workbench.paths import Path as Course
from workbench.poses import planned
from workbench.problem import problem
from workbench.programs.rotations import pose
from workbench.protocols.load_pairs import difference_rows
from workbench.records import record
from workbench.report.charts import OURS, PRINTED, Series, curves, rows
from workbench.report.drawing import MIDDLE, NOISE, Figure
from workbench.report.numbers import mm, p_value, percent, words
from workbench.report.story import tell
from workbench.report.study import Shown, Study, Table
from workbench.robot import Robot, load_robot
from workbench.simulate import Truth, random_geometry, simulate
from workbench.studies.kr500_figures import (
    allowed_table,
    beside_table,
    count_figure,
    left_table,
    scatter_table,
    stiffness_table,
)

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

PRINTED_ERROR = {  # mean, and largest where it is given [mm]
    "raw": (0.2567, 0.3244),
    "theory": (0.1104,),
    "constant": (0.1049, 0.1434),
    "2": (0.0989, 0.1434),
    "16": (0.0761, 0.1129),
    "128": (0.0581, 0.0981),
}

# not printed: where the box is, the tool, the noise, the instrument
BOX = np.array([[0.95, -0.6, 1.3], [1.55, 0.6, 1.9]])
SMR, MASS, TOOL = (0.08, 0.05, 0.25), (50.0, (0.06, 0.0, 0.2)), (10.0, (0.0, 0.0, 0.1))
SIGMA = 20e-6
SIDE = np.array([200.0, 200.0, -400.0])  # N: a load that K1 would feel
IN_BASE = np.eye(3)[None], np.zeros((1, 3))  # the paper measures in the base frame
TILTS = (-10.0, 0.0, 10.0)
HAND = pose(np.array([SMR]), np.eye(3)[None])[0]
SOFT, WIDTH = 4e-4, 200.0  # rad, N·m: what joint 2 yields beside its spring, and below which torque


def soft_zone(wrench: Array) -> Array:
    """(6,) motion of joint 2 beyond τ/K: a law that the catalogue does not have."""
    x = wrench[5] / WIDTH
    return np.array([0, 0, 0, 0, 0, SOFT * x / np.sqrt(1 + x**2)])


@dataclass(frozen=True)
class Case:
    """A true robot and its campaign: `data` at the corners and centres of all cells, `clean` the same without
    noise; seen, true: (128, 3) [m] what the load moves the verification points by, measured and as it is."""

    truth: Truth
    data: Campaign
    clean: Campaign
    seen: Array
    true: Array


def study(folder: Path, seed: int, quick: bool, progress: Callable[[str], None]) -> Study:
    """Two true robots, (a) of constant stiffness, (b) with a soft zone; the paper's protocol on both."""
    robot = load_robot("kr500")
    rng = np.random.default_rng([seed, 1])
    check = plan(robot, cells(BOX, CUTS["128"]).draw(rng), (0.0,))
    geometry = random_geometry(problem(check).arm, rng)
    n: dict[str, float] = {}
    case, models, trades = {}, {}, {}
    for name, yields in {"a": {}, "b": {2: soft_zone}}.items():
        progress(f"({name}) measuring the points of all cells, three rotations, with and without 50 kg")
        case[name] = measured(robot, Truth(geometry, yields=yields, sigma=SIGMA), check, seed)
        progress(f"({name}) fitting 1, 2, 16 and 128 cells")
        models[name] = fitted(case[name].data)
        found = {key: model.deflection(check)[128:] for key, model in models[name].items()}
        n |= errors(name, case[name], {"raw": np.zeros((128, 3)), **found})
        progress(f"({name}) asking how many cells the noise allows")
        trades[name] = how_many(case[name], found, check, 1 if quick else 4, seed)
    write_cells(folder / "cells", models["b"]["128"])

    progress("diagnosing the two cells' measurements")
    cuts = [("a", "2"), ("b", "2")] + ([] if quick else [("b", "constant"), ("b", "16")])
    told = {(name, cut): diagnose(at(case[name].data, cut), seed=seed) for name, cut in cuts}
    write_campaign(folder / "campaign", at(case["b"].data, "2"), comments=["simulated in Drake"])
    physical = extended(folder / "model.toml", told["b", "2"])
    n |= errors("b", case["b"], {"named": moved(predicted(replace(check, robot=physical)))})
    n |= {"named_records": len(told["b", "2"].problem.q), "remainder_p": told["b", "2"].diagnosis.remainder_p}
    n |= {
        "cells_over_named": n["b_128_true_mm"] / n["b_named_true_mm"],
        "a_cells_over_same": n["a_128_true_mm"] / n["a_same_true_mm"],
        "b_gain": 1 - n["b_128_mm"] / n["b_constant_mm"],
        **{f"{name}_allowed": one.best for name, one in trades.items()},
        "b_pays": trades["b"].pays,
        "b_pays_mm": trades["b"].pays * n["b_same_true_mm"],
        "b_kinematics_mm": abs(n["b_constant_mm"] - n["b_theory_mm"]),
        "floor_mm": float(1e3 * np.linalg.norm(case["b"].seen - case["b"].true, axis=1).mean()),
        "printed_k1_ratio": TABLE_1[:, 0].max() / TABLE_1[:, 0].min(),
    }

    progress("a side load, and commands for the verification points and a line")
    n |= {"records": len(case["b"].data.q), "few_records": len(at(case["b"].data, "constant").q)}
    n |= sideways(case["b"].truth, models["b"]["128"], physical, check)
    seen, bounds = identifiable(robot)
    driven, line_figure = commanded(robot, case["b"].truth, models["b"], physical, check)
    items: dict[str, Table | Figure] = {
        "equations": stiffness_table("Equations (18) to (21)", equations(models)),
        "table 1": beside_table("Table 1, 16 cells: printed · ours (a)", CUBICS, TABLE_1, models["a"]["16"]),
        "scatter": scatter_table(
            "How far the stiffnesses of 16 cells scatter",
            TABLE_1,
            {f"({name})": one["16"] for name, one in models.items()},
        ),
        "seen": seen,
        "errors": errors_figure(n),
        "count": count_figure(
            "count", "From the same measurements: noise grows with the cells", *trades.values()
        ),
        "allowed": allowed_table("How many cells noise allows", trades["b"], (1.0, 0.3, 0.1, 0.03, 0.0)),
        "torque": torque_figure(robot, models["b"]["128"]),
        "diagnosis": diagnosis_table(told),
        "candidates": candidates(robot, check),
        "line": line_figure,
    }
    stages = {"uncompensated": case["b"].true} | {
        said: case["b"].true - models["b"][key].deflection(check)[128:]
        for said, key in (("constant stiffness", "constant"), ("128 cells", "128"))
    }
    stages["soft zone named"] = case["b"].true - moved(predicted(replace(check, robot=physical)))
    shown = Shown(
        check.q[0], cells(BOX, CUTS["128"]).draw(np.random.default_rng([seed, 1])), stages, noise=SIGMA
    )
    files = {"Campaign": "campaign/campaign.toml", "Model": "model.toml", "Cells": "cells/cells.toml"}
    return tell(Path(__file__).with_suffix(".md"), robot, n | bounds | driven, items, shown, "errors", files)


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


def moved(points: Array) -> Array:
    """(C, 3) [m] loaded minus unloaded, of the points (2C, 1, 3) of a plan."""
    return np.asarray(points[len(points) // 2 :, 0] - points[: len(points) // 2, 0])


def quiet(truth: Truth) -> Truth:
    """The same robot without noise."""
    return replace(truth, sigma=0.0, repeatability=np.zeros(6))


def measured(robot: Robot, truth: Truth, check: Campaign, seed: int) -> Case:
    grid = plan(robot, cells(BOX, CUTS["128"]).samples)
    data = simulate(grid, truth, seed=seed, instrument=IN_BASE)
    clean = replace(data, points=simulate(grid, quiet(truth), instrument=IN_BASE).points)
    seen, true = (
        moved(simulate(check, t, seed=seed + 1, instrument=IN_BASE).points) for t in (truth, quiet(truth))
    )
    return Case(truth, data, clean, seen, true)


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


def errors(name: str, case: Case, found: Mapping[str, Array]) -> dict[str, float]:
    """Equation (22) at the verification points: what the load moves, less what a model says; seen, true."""
    out: dict[str, float] = {}
    for key, said in found.items():
        seen, true = (1e3 * np.linalg.norm(e - said, axis=1) for e in (case.seen, case.true))
        out |= {f"{name}_{key}_mm": seen.mean(), f"{name}_{key}_max_mm": seen.max()}
        out |= {f"{name}_{key}_true_mm": true.mean(), f"{name}_{key}_true_max_mm": true.max()}
    return out


def how_many(case: Case, found: Mapping[str, Array], check: Campaign, draws: int, seed: int) -> Trade:
    """What finer cells remove and what noise adds, when 1, 2, 16 and 128 cells use all measurements alike."""

    def said(data: Campaign, known: Mapping[str, Array]) -> list[Array]:
        fits = {key: fit_cells(data, BOX, CUTS[key], instrument=IN_BASE) for key in CUTS if key not in known}
        return [known[key] if key in known else fits[key].deflection(check)[128:] for key in CUTS]

    noisy = [said(case.data, {"constant": found["same"], "128": found["128"]})]
    for k in range(1, draws):
        noisy.append(said(simulate(case.data, case.truth, seed=seed + 10 * k, instrument=IN_BASE), {}))
    return trade([1, 2, 16, 128], case.true, said(case.clean, {}), noisy)


def extended(path: Path, found: Outcome) -> Robot:
    """The diagnosed robot, standing where the instrument is known to stand, written and read."""
    fit, job = found.fit, found.problem
    records = [record(e, v) for e, v in zip(fit.model.effects, fit.state.values, strict=True)]
    write_model(path, loaded(job.robot, job.campaign), seated(job.arm, fit.state), records)
    return load_robot(path)


def pushed(plan: Campaign) -> Campaign:
    """The plan with a force from the side at the SMR, as in machining, instead of the mass."""
    lever = problem(plan).rigid.R[-1] @ SMR
    wrench = np.hstack([np.tile(SIDE, (len(lever), 1)), np.cross(lever, SIDE)])
    return replace(plan, wrench=wrench * (plan.payload > 0)[:, None], payload=np.zeros_like(plan.payload))


def sideways(truth: Truth, one: CellModel, physical: Robot, check: Campaign) -> dict[str, float]:
    """The models under a force that K1 feels."""
    check = pushed(check)
    true = moved(simulate(check, quiet(truth), instrument=IN_BASE).points)
    said = {
        "raw": np.zeros_like(true),
        "128": one.deflection(check)[len(true) :],
        "named": moved(predicted(replace(check, robot=physical))),
    }
    by_k1 = 1e3 * SIDE[1] * BOX[:, 0].mean() ** 2 / TABLE_1[:, 0]  # what printed K1 make of it
    return {
        **{f"side_{key}_mm": float(1e3 * np.linalg.norm(true - e, axis=1).mean()) for key, e in said.items()},
        "side_printed_least_mm": by_k1.min(),
        "side_printed_most_mm": by_k1.max(),
    }


def commanded(
    robot: Robot, truth: Truth, models: Mapping[str, CellModel], physical: Robot, check: Campaign
) -> tuple[dict[str, float], Figure]:
    """The loop closed: commands corrected by each model, run by the loaded robot in Drake."""
    weight = external(check).wrench[-1]
    origin = work_frame(BOX[0] + [0.03, 0.05, 0.37], along=(0.54, 1.1, 0))
    drawn = line(1.22, Run(origin, speed=0.1, period=0.1, R_WT=origin[:3, :3].T @ tilted(0.0)))
    drawn = Course(drawn.time, nominal_joints(robot, drawn, HAND, start=check.q[0]))
    half = len(check.q) // 2
    out: dict[str, float] = {}
    for name, path in {
        "points": Course(clock(half), check.q[half:]),
        "line": drawn,
    }.items():
        cut = {key: models[key].compensate(path, weight) for key in ("constant", "128")}
        exact = compensate(physical, path, stated_conditions(physical, "mass"), tool=HAND)
        wanted = exact.X_desired[:, :3, 3]
        q = {"raw": exact.q_nominal, **{key: one.q for key, one in cut.items()}, "named": exact.q_command}
        error = {}
        for key, told in q.items():
            job = planned(robot, told, targets=check.targets, tool=TOOL, payloads={"mass": MASS},
                          payload=["mass"] * len(told))  # fmt: skip
            place = simulate(job, quiet(truth), instrument=IN_BASE).points[:, 0]
            error[key] = 1e3 * np.linalg.norm(place - wanted, axis=1)
            out |= {f"{name}_{key}_mm": error[key].mean(), f"{name}_{key}_max_mm": error[key].max()}
        jumps = cut["128"].jump_mm
    out |= {"jump_mm": jumps.max(), "walls": len(jumps)}
    series = {
        "constant stiffness": Series(error["constant"], colour=MIDDLE),
        "128 cells": Series(error["128"], colour=PRINTED),
        "soft zone named": Series(error["named"], colour=OURS),
    }
    title = "The corrected line under 50 kg: cells step at their walls, a physical model does not"
    way = 1e3 * np.linalg.norm(wanted - wanted[0], axis=1)
    figure = curves("line", title, way, series, "along the line, mm", "distance from the line, mm")
    return out, figure


def equations(models: Mapping[str, Mapping[str, CellModel]]) -> dict[str, Array | tuple[Array, Array]]:
    """Printed and ours: constant without and with calibrated kinematics, and the two cells."""
    ours = {"(18)": ("theory", 0), "(19)": ("constant", 0), "(20)": ("2", 0), "(21)": ("2", 1)}
    lines: dict[str, Array | tuple[Array, Array]] = {}
    for name, (key, cell) in ours.items():
        lines[f"{name} printed"] = EQUATIONS[name]
        for case, model in models.items():
            k, std = model[key].stiffness
            lines[f"{name} ours ({case})"] = k[cell], std[cell]
    return lines


def identifiable(robot: Robot) -> tuple[Table, dict[str, float]]:
    """Cramér–Rao bounds of the stiffnesses from the 27 poses of the whole box."""
    ours = plan(robot, cells(BOX, (1, 1, 1)).samples)
    axis = replace(
        ours, targets=(Target("SMR", (0, 0, 0.25), fixed=True),), load_com=np.array([[0, 0, 0], [0, 0, 0.2]])
    )
    bounds, singular = [], []
    for one in (axis, ours, pushed(ours)):
        _, s, V = np.linalg.svd(
            difference_rows(one).reshape(-1, 6) / (np.sqrt(2) * SIGMA), full_matrices=False
        )
        bounds.append(np.sqrt(((V.T / np.maximum(s, 1e-12)) ** 2).sum(axis=1)))
        singular.append(s)
    head = ("", "50 kg, tool on axis 6", "50 kg, our tool", "A force from the side")
    lines = [
        [f"K{j + 1}", *(percent(b[j], 0) if b[j] < 10 else "not seen" for b in bounds)] for j in range(6)
    ]
    number = {f"singular_{j + 1}": float(x) for j, x in enumerate(singular[1])}
    return Table("Least standard deviation of each stiffness from 27 poses", head, lines), number


def diagnosis_table(told: Mapping[tuple[str, str], Outcome]) -> Table:
    lines = []
    for (case, _), one in told.items():
        d = one.diagnosis
        found = [words(f.label) + ("" if f.status == "named" else " (not alone)") for f in d.causes]
        causes = ", ".join(label for label in found if not label.startswith("unknown")) or "none"
        lines.append(
            [f"({case})", str(d.n_poses), d.verdict.replace("_", " "), causes, p_value(d.remainder_p)]
        )
    head = ("Truth", "Records", "Verdict", "Causes found", "What is left")
    return Table("What a diagnosis says of the same measurements", head, lines, numbers=(1,))


def candidates(robot: Robot, check: Campaign) -> Table:
    """How large the causes that yield under load would have to be, to leave what the paper's fit leaves."""
    floor = 1e-3 * PRINTED_ERROR["128"][0]  # its noise at the most
    wanted = float(np.sqrt((1e-3 * PRINTED_ERROR["constant"][0]) ** 2 - floor**2))
    ours = plan(robot, cells(BOX, (1, 1, 1)).samples)
    kinds = [k for k in catalogue().values() if issubclass(k, YieldEffect) and k is not JointCompliance]
    sites = [site for kind in kinds for site in kind.sites(problem(ours))]
    title = f"What would leave {mm(1e3 * wanted)} mm beside constant stiffness"
    return left_table(title, left_over(ours, check, sites, wanted))


def errors_figure(n: Mapping[str, float]) -> Figure:
    names = {
        "raw": "no model",
        "theory": "constant, nominal kinematics",
        "constant": "constant",
        "2": "2 cells",
        "16": "16 cells",
        "128": "128 cells",
        "same": "constant, all points",
        "named": "soft zone named",
    }
    series = {"printed": Series([PRINTED_ERROR.get(key, (np.nan,))[0] for key in names], colour=PRINTED)}
    for case, colour in (("a", NOISE), ("b", OURS)):
        mean, true = ([n.get(f"{case}_{key}_{what}", np.nan) for key in names] for what in ("mm", "true_mm"))
        series[f"({case}), line: without noise"] = Series(mean, true, mean, colour)
    title = "Mean error at the 128 verification points"
    return rows("errors", title, list(names.values()), series, "mm")


def torque_figure(robot: Robot, model: CellModel) -> Figure:
    """Joint 2's compliance in 128 cells over the torque that the compensator leaves."""
    centres = plan(robot, model.cells.samples[-len(model.cells) :], (0.0,))
    torque = problem(centres).nominal_load.local[:, 2, 5].reshape(2, -1)
    order = np.argsort(torque.mean(axis=0))
    low, high = torque[:, order]
    soft = [np.array([soft_zone(np.array([0, 0, 0, 0, 0, t]))[5] for t in ts]) for ts in (low, high)]
    nominal = 1e6 / EQUATIONS["(19)"][1]
    series = {
        "128 cells": Series(1e6 / model.stiffness[0][order, 1], colour=PRINTED, style="o"),
        "truth: spring and soft zone": Series(
            nominal + 1e6 * (soft[1] - soft[0]) / (high - low), colour=OURS
        ),
        "equation (19)": Series(np.full(len(low), nominal), colour=MIDDLE, style="--"),
    }
    title = "“Stiffness that varies in space” is one curve over the torque of joint 2"
    return curves(
        "torque", title, (low + high) / 2, series, "net torque of joint 2, N·m", "compliance, 10⁻⁶ rad/(N·m)"
    )


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
