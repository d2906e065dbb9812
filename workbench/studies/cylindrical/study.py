"""A cylindrical robot: stiffness from 50 loaded poses, and a circle drawn under load (source 000).

Three joints on virtual springs. The paper identifies the springs from deflections with 10 µm of noise and
prints stiffnesses that are 22 % and 4 % off. Question: what noise, or what fault, makes such errors?
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from workbench.campaign import Campaign, Target, write_campaign
from workbench.campaign.planned import planned
from workbench.campaign.problem import problem
from workbench.correction import Conditions, compensate
from workbench.correction.path_shapes import Run, circle, work_frame
from workbench.effects.joint_compliance import JointCompliance
from workbench.identification.fit import Fit, fit
from workbench.identification.model import Model
from workbench.identification.model_file import write_fit
from workbench.identification.restated import restated
from workbench.measurement.load_pairs import difference_rows
from workbench.report.charts import OURS, PRINTED, Series, Trace, plane, rows
from workbench.report.drawing import MIDDLE, Figure
from workbench.report.story import tell
from workbench.report.study import Shown, Study
from workbench.robot.description import Robot, load_robot
from workbench.robot.kinematics import Array
from workbench.simulation.virtual_campaign import Truth, simulate
from workbench.studies.telling import each

TABLE_1 = np.array([1e6, 2e6, 0.5e6])  # printed: the stiffnesses that made the paper's data
TABLE_2 = np.array([7.8e5, 20.9e5, 5.2e5])  # printed: the stiffnesses that it identified
SIGMA = 1e-5  # m, printed: noise of a deflection
WRENCH = np.array([500.0, -250.0, 1000.0, 0.0, 0.0, 0.0])  # N, N·m, printed for the circle
HAND = [Target("E", (0.0, 0.0, 0.0), fixed=True)]
IN_BASE = np.eye(3)[None], np.zeros((1, 3))  # an instrument that stands in the robot's base
CIRCLE = circle(0.15, Run(work_frame([0.75, 0.0, 0.75])))
ENLARGED = 60.0


def study(folder: Path, seed: int, quick: bool, progress: Callable[[str], None]) -> Study:
    """Identification, the question about its errors, and the circle."""
    robot = load_robot("cylindrical")
    progress("measuring 50 poses before and after loading")
    plan = fifty_poses(robot, seed)
    campaign = simulate(plan, Truth(sigma=SIGMA / np.sqrt(2)), seed=seed)
    write_campaign(folder / "campaign", campaign, comments=["simulated in Drake"])
    found = identified(campaign)
    write_fit(folder / "model.toml", found)
    ours, std = stiffness(found)

    progress("asking what would make the printed errors")
    A = difference_rows(plan).reshape(-1, 3)  # eq. (7): deflections per relative compliance
    bound = SIGMA * np.sqrt(np.diag(np.linalg.inv(A.T @ A)))
    off = TABLE_1 / TABLE_2 - 1  # of the printed compliances
    chi2 = float(off @ A.T @ A @ off) / SIGMA**2
    needed = SIGMA * float(np.sqrt(chi2 / 3))
    noise = np.random.default_rng([seed, 1]).normal(scale=needed, size=(len(A), 200 if quick else 5000))
    spread = np.std(1 / (1 + np.linalg.lstsq(A, noise)[0]), axis=1)
    numbers = {
        **each("true", TABLE_1),
        **each("printed", TABLE_2),
        **each("printed", TABLE_2 / TABLE_1 - 1, "_off"),
        **each("printed", abs(off) / bound, "_sigma"),
        **each("stiffness", ours),
        **each("stiffness", ours / TABLE_1 - 1, "_off"),
        **each("stiffness", 1.96 * std, "_half"),
        **each("bound", bound),
        **each("spread", spread),
        "printed_off_in_sigma": float((abs(off) / bound).max()),
        "printed_chi2": chi2,
        "printed_p": float(stats.chi2.sf(chi2, 3)),
        "noise_stated_mm": 1e3 * SIGMA,
        "noise_needed_mm": 1e3 * needed,
        "noise_over_stated": needed / SIGMA,
    }
    for name, which in {"both": (True, True), "lever": (True, False), "force": (False, True)}.items():
        numbers |= explained(name, plan, A, which)

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


def fifty_poses(robot: Robot, seed: int) -> Campaign:
    """Fifty random poses within the limits, without load and then with it."""
    lower, upper = np.array([(joint.lower, joint.upper) for joint in robot.joints]).T
    q = np.random.default_rng([seed, 0]).uniform(lower, upper, size=(50, 3))
    return planned(
        robot, np.tile(q, (2, 1)), targets=HAND, wrench=np.repeat([0 * WRENCH, WRENCH], 50, axis=0)
    )


def identified(campaign: Campaign) -> Fit:
    """Compliances of a robot that is thought to be rigid; the paper's robot has no errors of geometry."""
    job = problem(replace(campaign, robot=restated(campaign.robot, stiffness=None)))
    return fit(Model(job, tuple(JointCompliance.sites(job))), geometry=False)


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


def explained(name: str, plan: Campaign, A: Array, which: tuple[bool, bool]) -> dict[str, float]:
    """The fault that comes nearest to the printed errors, its errors, and what its fit leaves.

    Link 2 is longer, the force smaller, than the program has them, by what `which` leaves free. A:
    deflections that the program expects.
    """
    free = np.flatnonzero(which)

    def made(size: Array) -> tuple[Array, float]:
        length, force = np.bincount(free, size, minlength=2)
        geometry = np.zeros((5, 6))
        geometry[3, 2] = length  # joint 3 slides along its z
        load = replace(plan, wrench=(1 - force) * plan.wrench)
        p = simulate(load, Truth(geometry=geometry), instrument=IN_BASE).points[:, 0]
        moved = (p[50:] - p[:50]).ravel()
        k = np.linalg.lstsq(A, moved)[0]  # eq. (9)
        return 1 / k - 1, float(np.sqrt(np.mean((moved - A @ k) ** 2)))

    def missed(size: Array) -> Array:
        return made(size)[0] - (TABLE_2 / TABLE_1 - 1)

    best = least_squares(missed, np.full(len(free), 0.01)).x
    length, force = np.bincount(free, best, minlength=2)
    errors, residual = made(best)
    return {
        **each(name, errors, "_off"),
        f"{name}_length_mm": 1e3 * length,
        f"{name}_force": force,
        f"{name}_residual_mm": 1e3 * float(np.hypot(residual, SIGMA)),
        f"{name}_residual_p": float(stats.chi2.sf(len(A) * (1 + (residual / SIGMA) ** 2), len(A) - 3)),
    }


def drawn(robot: Robot, beliefs: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
    """The circle's points (M, 3) and its errors under load, uncompensated and with each belief's commands."""
    errors = {}
    for name, k in beliefs.items():
        done = compensate(with_stiffness(robot, k), CIRCLE, Conditions(wrench=WRENCH))
        wanted = done.X_desired[:, :3, 3]
        for which, q in (("uncompensated", done.q_nominal), (name, done.q_command)):
            plan = planned(robot, q, targets=HAND, wrench=np.tile(WRENCH, (len(q), 1)))
            errors[which] = simulate(plan, Truth(), instrument=IN_BASE).points[:, 0] - wanted
    return wanted, errors


def stiffness_figure(ours: Array, std: Array) -> Figure:
    low, middle, high = (100 * (ours * (1 + z * std) / TABLE_1 - 1) for z in (-1.96, 0, 1.96))
    series = {
        "ours, 95 %": Series(middle, low, high, OURS),
        "printed": Series(100 * (TABLE_2 / TABLE_1 - 1), colour=PRINTED),
    }
    title = "Our intervals hold the true stiffnesses; the printed ones lie far outside"
    names = ["joint 1", "joint 2", "joint 3"]
    return rows("stiffness", title, names, series, "identified stiffness over the true one, minus one, %")


def circle_figure(wanted: Array, error: dict[str, Array]) -> Figure:
    lines = {}
    for (name, e), colour in zip(error.items(), (PRINTED, MIDDLE, OURS), strict=True):
        x, y, _ = 1e3 * (wanted + ENLARGED * e).T
        lines[name] = Trace(x, y, colour)
    lines["wanted"] = Trace(1e3 * wanted[:, 0], 1e3 * wanted[:, 1], style="--")
    title = f"The circle from above, errors {ENLARGED:.0f} times enlarged (figures 5 and 6 of the paper)"
    return plane("above", title, lines, "x, mm", "y, mm")


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
