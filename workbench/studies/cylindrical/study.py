"""A cylindrical robot: stiffness from 50 loaded poses, and a circle drawn under load (homework, 2020).

Three joints on virtual springs. The paper identifies the springs from deflections with a little noise and
prints stiffnesses that are off by far more. Question: what noise, or what fault, makes such errors?
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Campaign,
    Conditions,
    Figure,
    Fit,
    Model,
    Robot,
    Shown,
    Study,
    StudyRun,
    Target,
    Truth,
    as_package,
    by_joint,
    catalogue,
    charts,
    compensate,
    fit,
    load_robot,
    path_shapes,
    planned,
    problem_of,
    restated,
    run_study,
    simulate,
    tell,
    write_campaign,
    write_fit,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from .printed import FORCE, NUMBERS, POSES, SIGMA, TABLE_1, TABLE_2
from .question import IN_BASE, explained, noise_needed

WRENCH = np.concatenate([FORCE, np.zeros(3)])  # N, N·m, at the flange
HAND_TARGETS = [Target("E", (0.0, 0.0, 0.0), fixed=True)]
CIRCLE = path_shapes.circle(0.15, path_shapes.Run(path_shapes.work_frame([0.75, 0.0, 0.75])))
ENLARGED = 60.0


def study(run: StudyRun) -> Study:
    """Identification, the question about its errors, and the circle."""
    folder, seed, quick, progress = run.folder, run.seed, run.quick, run.say
    robot = load_robot("cylindrical")
    progress(f"measuring {POSES} poses before and after loading")
    plan = loaded_poses(robot, seed)
    campaign = simulate(plan, Truth(sigma=SIGMA / np.sqrt(2)), seed=seed)
    write_campaign(folder / "campaign", campaign, comments=["simulated in Drake"])
    found = identified(campaign)
    write_fit(folder / "model.toml", found)
    ours, std = stiffness(found)

    progress("asking what would make the printed errors")
    numbers = {
        **NUMBERS,
        **by_joint("stiffness", ours),
        **by_joint("stiffness", ours / TABLE_1 - 1, "_off"),
        **by_joint("stiffness", 1.96 * std, "_half"),
        **noise_needed(plan, seed, 200 if quick else 5000),
    }
    for name, free in {"both": (True, True), "lever": (True, False), "force": (False, True)}.items():
        numbers |= explained(name, plan, free)

    progress("drawing the circle under load")
    wanted, error = drawn(robot, {"Table 2 as printed": TABLE_2, "ours": ours})
    shaken = np.random.default_rng([seed, 2]).normal(scale=SIGMA, size=wanted.shape)
    for name, e in zip(("uncompensated", "printed", "ours"), error.values(), strict=True):
        size, seen = (1e3 * np.linalg.norm(x, axis=1) for x in (e, e + shaken))
        numbers |= {f"{name}_mean_mm": size.mean(), f"{name}_largest_mm": size.max()}
        numbers |= {f"{name}_measured_mm": seen.mean()}
    numbers["printed_over_ours"] = numbers["printed_mean_mm"] / numbers["ours_mean_mm"]

    items = {"stiffness": stiffness_figure(ours, std), "above": circle_figure(wanted, error)}
    shown = Shown(np.array([0.0, 0.25, 0.25]), wanted, error, noise=SIGMA)
    files = {"Campaign": "campaign/campaign.toml", "Model": "model.toml"}
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, shown, "stiffness", files)


def loaded_poses(robot: Robot, seed: int) -> Campaign:
    """Random poses within the limits, without load and then with it."""
    lower, upper = np.array([(joint.lower, joint.upper) for joint in robot.joints]).T
    q = np.random.default_rng([seed, 0]).uniform(lower, upper, size=(POSES, 3))
    return planned(
        robot, np.tile(q, (2, 1)), targets=HAND_TARGETS, wrench=np.repeat([0 * WRENCH, WRENCH], POSES, axis=0)
    )


def identified(campaign: Campaign) -> Fit:
    """Compliances of a robot that is thought to be rigid; the paper's robot has no errors of geometry."""
    problem = problem_of(replace(campaign, robot=restated(campaign.robot, stiffness=None)))
    return fit(Model(problem, tuple(catalogue()["joint_compliance"].sites(problem))), geometry=False)


def stiffness(found: Fit) -> tuple[Array, Array]:
    """(3,) stiffnesses and their relative standard deviations."""
    pairs = [found.effect_values(j) for j in range(3)]
    k, variance = np.array([v[0] for v, _ in pairs]), np.array([c[0, 0] for _, c in pairs])
    return 1 / k, np.sqrt(variance) / k


def with_stiffness(robot: Robot, values: Array) -> Robot:
    """The robot on other springs."""
    for name, k in zip(robot.joint_names, values, strict=True):
        robot = restated(robot, [name], stiffness=float(k))
    return robot


def drawn(robot: Robot, beliefs: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
    """The circle's points (M, 3) and its errors under load, uncompensated and with each belief's commands."""
    errors = {}
    for name, k in beliefs.items():
        done = compensate(with_stiffness(robot, k), CIRCLE, Conditions(wrench=WRENCH))
        wanted = done.X_desired[:, :3, 3]
        for which, q in (("uncompensated", done.q_nominal), (name, done.q_command)):
            plan = planned(robot, q, targets=HAND_TARGETS, wrench=np.tile(WRENCH, (len(q), 1)))
            errors[which] = simulate(plan, Truth(), instrument=IN_BASE).points[:, 0] - wanted
    return wanted, errors


def stiffness_figure(ours: Array, std: Array) -> Figure:
    low, middle, high = (100 * (ours * (1 + z * std) / TABLE_1 - 1) for z in (-1.96, 0, 1.96))
    series = {
        "ours, 95 %": charts.Series(middle, low, high, charts.OURS),
        "printed": charts.Series(100 * (TABLE_2 / TABLE_1 - 1), colour=charts.PRINTED),
    }
    title = "Our intervals hold the true stiffnesses; the printed ones lie far outside"
    names = ["joint 1", "joint 2", "joint 3"]
    return charts.rows(
        "stiffness", title, names, series, "identified stiffness over the true one, minus one, %"
    )


def circle_figure(wanted: Array, error: dict[str, Array]) -> Figure:
    lines = {}
    for (name, e), colour in zip(error.items(), (charts.PRINTED, charts.MIDDLE, charts.OURS), strict=True):
        x, y, _ = 1e3 * (wanted + ENLARGED * e).T
        lines[name] = charts.Trace(x, y, colour)
    lines["wanted"] = charts.Trace(1e3 * wanted[:, 0], 1e3 * wanted[:, 1], style="--")
    title = f"The circle from above, errors {ENLARGED:.0f} times enlarged (figures 5 and 6 of the paper)"
    return charts.plane("above", title, lines, "x, mm", "y, mm")


if __name__ == "__main__":
    run_study(study)
