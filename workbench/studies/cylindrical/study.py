"""A cylindrical robot: stiffness from 50 loaded poses, and a circle drawn under load (homework, 2020).

Three joints on virtual springs. The paper identifies the springs from deflections with a little noise and
prints stiffnesses that are off by far more. Question: how did the printed stiffnesses come to be?
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import stats

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
    Table,
    Truth,
    account_items,
    as_package,
    by_joint,
    catalogue,
    charts,
    checked,
    clear_numbers,
    clear_poses,
    clear_table,
    compensate,
    counterpart,
    fit,
    judge,
    load_pairs,
    load_robot,
    nominal_joints,
    path_shapes,
    planned,
    problem_of,
    redrawn,
    restated,
    run_study,
    simulate,
    stored,
    tell,
    tornado,
    write_campaign,
    write_fit,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from .accounts import ITEMS, accounts
from .deflections import CIRCLE_RADIUS, GRAVITY, HAND_TARGETS, LENGTH, STROKE
from .headline import OF_DRAWS, OF_ODDS, OF_RUN, draws, in_sigma, odds
from .printed import FORCE, NUMBERS, POSES, SIGMA, TABLE_1, TABLE_2

IN_BASE = np.eye(3)[None], np.zeros((1, 3))  # an instrument that stands in the robot's base
CENTRE = np.array([LENGTH + STROKE / 2, 0.0, 0.75])
CIRCLE = path_shapes.circle(CIRCLE_RADIUS, path_shapes.Run(path_shapes.work_frame(CENTRE), period=0.04))
ENLARGED = 60.0
FILES = {
    "Campaign": "full/campaign.toml",
    "Campaign, light load": "light/campaign.toml",
    "Model": "model.toml",
}


def study(run: StudyRun) -> Study:
    """Identification, the accounts of its errors, and the circle."""
    robot = load_robot("cylindrical")
    run.say("judging six accounts of the printed stiffnesses")
    judged = judge(accounts(), ITEMS, run.draws(2000, 400), run, chunk=200)
    drawn = draws(run)
    numbers = NUMBERS | judged.numbers() | drawn.by_name()
    items: dict[str, Table | Figure] = {
        **account_items(judged),
        "tornado": tornado(drawn, "lighter", "tornado", "how many times lighter the load has to be"),
    }

    run.say(f"measuring {POSES} poses before and after loading, in Drake")
    loads = {"full": 1.0, "light": 1 / numbers["lighter_mid"]}
    found = {name: measured(robot, scale, run, name) for name, scale in loads.items()}
    write_fit(run.folder / "model.toml", found["full"])
    for name, identified in found.items():
        k, std = stiffness(identified)
        numbers |= by_joint(f"{name}", k) | by_joint(f"{name}", k / TABLE_1 - 1, "_off")
        numbers |= by_joint(f"{name}", 1.96 * std, "_half")
    exact, _ = stiffness(measured(robot, 1.0, run, "exact", noise=1e-3))
    ours, _ = stiffness(found["full"])
    numbers["without"] = float(np.abs(exact / TABLE_1 - 1).max())
    numbers |= in_sigma(load_pairs.difference_rows(loaded_poses(robot, run.seed, 1.0)).reshape(-1, 3))
    numbers["chi2_p"] = float(stats.chi2.sf(numbers["chi2"], 3))

    run.say("drawing the circle under load, in Drake")
    wanted, error, circles = under_load(robot, {"exact": exact, "printed": TABLE_2, "ours": ours}, run.seed)
    numbers |= circles
    clear = clear_poses(
        robot,
        {
            "identification": loaded_poses(robot, run.seed, 1.0).poses.q[:POSES],
            "circle, evenly": nominal_joints(robot, CIRCLE)[::10],
        },
    )
    numbers |= clear_numbers(clear)
    items |= {"clear": clear_table(clear), "measured": counterpart("cylindrical", run)}
    shaken = np.random.default_rng([run.seed, 2]).normal(scale=SIGMA, size=wanted.shape)
    items |= {
        "stiffness": stiffness_figure(found),
        "five": circle_figure("five", wanted, error, "exact", 0 * shaken),
        "six": circle_figure("six", wanted, error, "printed", shaken),
    }
    shown = Shown(
        np.array([0.0, 0.25, 0.25]), wanted, {k: error[k] for k in ("uncompensated", "printed")}, noise=SIGMA
    )
    stands = checked(OF_DRAWS, numbers, drawn) | checked(OF_RUN, numbers)
    stands |= checked(OF_ODDS, numbers, redrawn(judged, odds))
    story = Path(__file__).with_name("story.md")
    told = tell(story, robot, numbers, items, shown, "odds", FILES, stands)
    hidden = dict(zip(robot.joint_names, TABLE_1.tolist(), strict=True))
    return replace(told, sealed={f"{name}/campaign.toml": {"stiffness": hidden} for name in found})


def loaded_poses(robot: Robot, seed: int, load: float) -> Campaign:
    """Random poses within the limits, without load and then with a share of the circle's."""
    lower, upper = robot.limits.T
    q = np.random.default_rng([seed, 0]).uniform(lower, upper, size=(POSES, 3))
    wrench = np.zeros((2 * POSES, 6))
    wrench[POSES:, :3] = load * FORCE
    return planned(robot, np.tile(q, (2, 1)), targets=HAND_TARGETS, wrench=wrench)


def measured(robot: Robot, load: float, run: StudyRun, name: str, noise: float = 1.0) -> Fit:
    """The paper's identification on deflections out of Drake: compliances of a robot that is thought to be
    rigid; the paper's robot has no errors of geometry. noise: over the stated; a deflection is a difference
    of two readings."""
    truth = Truth(sigma=noise * SIGMA / np.sqrt(2))
    campaign = simulate(loaded_poses(robot, run.seed, load), truth, seed=run.seed)
    rigid = stored(run.folder / "rigid" / "cylindrical.toml", restated(robot, stiffness=None))
    believed = replace(campaign, robot=rigid)
    write_campaign(run.folder / name, believed, comments=["simulated in Drake"])
    problem = problem_of(believed)
    return fit(Model(problem, tuple(catalogue()["joint_compliance"].sites(problem))), geometry=False)


def stiffness(found: Fit) -> tuple[Array, Array]:
    """(3,) stiffnesses and their relative standard deviations."""
    pairs = [found.effect_values(j) for j in range(3)]
    k, variance = np.array([v[0] for v, _ in pairs]), np.array([c[0, 0] for _, c in pairs])
    return 1 / k, np.sqrt(variance) / k


def under_load(
    robot: Robot, beliefs: dict[str, Array], seed: int
) -> tuple[Array, dict[str, Array], dict[str, float]]:
    """The circle with its errors, and their sizes with the weight of the links and without."""
    mass = float(problem_of(loaded_poses(robot, seed, 1.0)).arm.mass[2:].sum())
    wanted, error = circle(robot, beliefs, 0.0)
    _, bare = circle(robot, beliefs, mass)
    sizes = {"mass": mass}
    for key, each in (("", error), ("bare_", bare)):
        for name, e in each.items():
            size = 1e3 * np.linalg.norm(e, axis=1)
            sizes |= {
                f"{key}{name}_mean_mm": float(size.mean()),
                f"{key}{name}_largest_mm": float(size.max()),
            }
    sizes |= {"circle_mm": sizes["uncompensated_mean_mm"], "bare_mm": sizes["bare_uncompensated_mean_mm"]}
    return wanted, error, sizes | {"left": sizes["printed_mean_mm"] / sizes["circle_mm"]}


def circle(robot: Robot, beliefs: dict[str, Array], lifted: float) -> tuple[Array, dict[str, Array]]:
    """The circle's points (M, 3) and its errors under load, uncompensated and with each belief's commands.
    lifted: mass [kg] of the links that a force upward takes the weight off."""
    wrench = np.concatenate([FORCE + np.array([0.0, 0.0, lifted * GRAVITY]), np.zeros(3)])
    errors = dict[str, Array]()
    for name, k in beliefs.items():
        believed = robot
        for joint, value in zip(robot.joint_names, k, strict=True):
            believed = restated(believed, [joint], stiffness=float(value))
        done = compensate(believed, CIRCLE, Conditions(wrench=wrench))
        wanted = done.X_desired[:, :3, 3]
        own = {} if errors else {"uncompensated": done.q_nominal}  # whatever is believed
        for which, q in (own | {name: done.q_command}).items():
            plan = planned(robot, q, targets=HAND_TARGETS, wrench=np.tile(wrench, (len(q), 1)))
            errors[which] = simulate(plan, Truth(), instrument=IN_BASE).points[:, 0] - wanted
    return wanted, errors


def stiffness_figure(found: dict[str, Fit]) -> Figure:
    series = {"printed": charts.Series(100 * (TABLE_2 / TABLE_1 - 1), colour=charts.PRINTED)}
    for name, words in (("full", "ours, the circle's load, 95 %"), ("light", "ours, the light load, 95 %")):
        k, std = stiffness(found[name])
        low, middle, high = (100 * (k * (1 + z * std) / TABLE_1 - 1) for z in (-1.96, 0, 1.96))
        series[words] = charts.Series(middle, low, high)
    title = "Stiffness from 50 poses with 10 µm of noise, under two loads, beside the printed one"
    names = ["joint 1", "joint 2", "joint 3"]
    return charts.rows(
        "stiffness", title, names, series, "identified stiffness over the true one, minus one, %"
    )


def circle_figure(name: str, wanted: Array, error: dict[str, Array], belief: str, shaken: Array) -> Figure:
    lines = {}
    for key, words, colour in (
        ("uncompensated", "uncompensated", charts.PRINTED),
        (belief, "compensated", charts.OURS),
    ):
        x, y, _ = 1e3 * (wanted + ENLARGED * (error[key] + shaken)).T
        lines[words] = charts.Trace(x, y, colour)
    lines["wanted"] = charts.Trace(1e3 * wanted[:, 0], 1e3 * wanted[:, 1], style="--")
    said = {"exact": "without noise, stiffness as it then comes out", "printed": "with noise and Table 2"}
    title = f"The circle from above {said[belief]}; errors {ENLARGED:.0f} times enlarged"
    return charts.plane(name, title, lines, "x, mm", "y, mm")


if __name__ == "__main__":
    run_study(study)
