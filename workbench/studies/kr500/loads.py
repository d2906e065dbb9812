"""The KR 500 study's measurements: poses without load and then with it, and which stiffness a load shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench import (
    Array,
    Campaign,
    CellModel,
    Robot,
    Table,
    Target,
    Truth,
    by_joint,
    load_pairs,
    numbers,
    places,
    problem_of,
    simulate,
)

from .printed import TABLE_1
from .protocol import BOX, IN_BASE


@dataclass(frozen=True, eq=False)
class Case:
    """A true robot and its campaign: `data` to identify it by, `clean` the same without noise; seen, true:
    (C, 3) [m] what the load moves the verification points by, as measured and as it is."""

    truth: Truth
    data: Campaign
    clean: Campaign
    seen: Array
    true: Array


def measured(grid: Campaign, check: Campaign, truth: Truth, seed: int) -> Case:
    """Both plans in Drake: the poses to identify the robot by, and those to verify it by."""
    data = simulate(grid, truth, seed=seed, instrument=IN_BASE)
    clean = replace(data, points=exact(grid, truth))
    seen = simulate(check, truth, seed=seed + 1, instrument=IN_BASE).points
    return Case(truth, data, clean, moved(seen), moved(exact(check, truth)))


def exact(plan: Campaign, truth: Truth) -> Array:
    """(N, T, 3) [m] where the targets are, without noise of robot and instrument."""
    quiet = replace(truth, sigma=0.0, repeatability=np.zeros(len(plan.robot.joints)))
    return simulate(plan, quiet, instrument=IN_BASE).points


def moved(points: Array) -> Array:
    """(C, 3) [m] loaded minus unloaded, of the first of the points (2C, T, 3) of a plan."""
    half = len(points) // 2
    return np.asarray(points[half:, 0] - points[:half, 0])


def modelled(robot: Robot, check: Campaign) -> Array:
    """(C, 3) [m] what the load moves the verification points by, as an extended robot has it."""
    return moved(places(replace(check, robot=robot)))


def errors(name: str, case: Case, found: Mapping[str, Array]) -> dict[str, float]:
    """Equation (22) at the verification points: what the load moves, as measured and as it is, less what a
    model says (raw: nothing)."""
    out: dict[str, float] = {}
    for key, said in {"raw": np.zeros_like(case.true), **found}.items():
        seen, true = (1e3 * np.linalg.norm(e - said, axis=1) for e in (case.seen, case.true))
        out |= {f"{name}_{key}_mm": seen.mean(), f"{name}_{key}_max_mm": seen.max()}
        out |= {f"{name}_{key}_true_mm": true.mean(), f"{name}_{key}_true_max_mm": true.max()}
    return out


def identifiable(plan: Campaign, force: Array, sigma: float) -> tuple[Table, dict[str, float]]:
    """Bounds of the stiffnesses by load, and the singular values of the plan's own."""
    loads = {
        "50 kg, tool on axis 6": on_axis(plan),
        "50 kg, our tool": plan,
        "A force from the side": pushed(plan, force),
    }
    least = [bounds(one, sigma)[0] for one in loads.values()]
    lines = [
        [f"K{j}", *(numbers.percent(b, 0) if b < 10 else "not seen" for b in row)]
        for j, row in enumerate(zip(*least, strict=True), start=1)
    ]
    table = Table("Least standard deviation of each stiffness from 27 poses", ("", *loads), lines)
    return table, by_joint("singular", bounds(plan, sigma)[1])


def bounds(plan: Campaign, sigma: float) -> tuple[Array, Array]:
    """(n,) least standard deviations of the stiffnesses over their values (Cramér–Rao), and (n,) singular
    values of their columns over the noise; sigma: [m] of a reading, per axis."""
    rows = load_pairs.difference_rows(plan)
    _, s, V = np.linalg.svd(rows.reshape(-1, rows.shape[2]) / (np.sqrt(2) * sigma), full_matrices=False)
    return np.sqrt(((V.T / np.maximum(s, 1e-12)) ** 2).sum(axis=1)), s


def on_axis(plan: Campaign) -> Campaign:
    """The plan with target and payload on the last axis."""
    name, xyz = plan.targets[0].name, plan.targets[0].xyz
    target = Target(name, (0.0, 0.0, xyz[2] if xyz else 0.0), fixed=True)
    return replace(plan, targets=(target,), load_com=plan.load_com * [0, 0, 1])


def pushed(plan: Campaign, force: Array) -> Campaign:
    """The plan with a force (3,) [N] at the target, as in machining, instead of the payload."""
    lever = problem_of(plan).rigid.R[-1] @ np.array(plan.targets[0].xyz)
    wrench = np.hstack([np.tile(force, (len(lever), 1)), np.cross(lever, force)])
    return plan.with_poses(
        wrench=wrench * (plan.poses.payload > 0)[:, None], payload=np.zeros_like(plan.poses.payload)
    )


def sideways(
    truth: Truth,
    model: CellModel,
    physical: Robot,
    check: Campaign,
    force: Array,
) -> dict[str, float]:
    """What the models miss under a force (3,) [N] that K1 feels, and what the printed K1 alone make of it."""
    check = pushed(check, force)
    true = moved(exact(check, truth))
    said = {
        "raw": np.zeros_like(true),
        "128": model.deflection(check)[len(true) :],
        "named": modelled(physical, check),
    }
    by_k1 = 1e3 * force[1] * BOX[:, 0].mean() ** 2 / TABLE_1[:, 0]
    return {
        **{f"side_{key}_mm": 1e3 * np.linalg.norm(true - e, axis=1).mean() for key, e in said.items()},
        "side_printed_least_mm": by_k1.min(),
        "side_printed_most_mm": by_k1.max(),
    }
