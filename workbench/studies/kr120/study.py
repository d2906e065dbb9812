"""KUKA KR 120 with a gas spring: what makes joint 2's stiffness differ from angle to angle?

Klimchik et al. (2017) load the robot in 31 configurations, give joint 2 a compliance of its own at each of
six angles, and put the difference between them down to the gas spring. Question: can a gas spring make it,
what else can, and which measurement decides?
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Campaign,
    Figure,
    Fit,
    FittedSpring,
    Problem,
    Rig,
    Study,
    StudyRun,
    Table,
    Target,
    as_package,
    catalogue,
    fit_any_order,
    fit_spring,
    gas_spring,
    group_plan,
    load_pairs,
    load_robot,
    planned,
    problem_of,
    run_study,
    shown_of,
    simulate,
    stored,
    tell,
    write_fit,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from . import figures
from .compensator import blind_to_charge, charge_by_witness
from .decides import WAYS, diagnosed, reversing, three_loads
from .machines import LEAK, MACHINES, SIGMA, machines, true_compliances
from .printed import CONFIGURATIONS, HALF_1, LOAD, MARKERS_APART, MARKERS_BEFORE, NUMBERS, TABLE_1
from .verdicts import deciding, verdict_table

SIX = slice(1, 7)
PER_ANGLE = (7, 6, 5, 5, 4, 4)  # the paper says: three to seven
GROUP = [group for group, count in enumerate(PER_ANGLE) for _ in range(count)] * 2

# not in the paper: the story says why
ANGLES = np.radians(np.linspace(-140, -5, 6))
ACROSS, BEFORE = MARKERS_APART / 2, MARKERS_BEFORE
MARKER_PLACES = (ACROSS, 0.0, BEFORE), (-ACROSS, 0.0, BEFORE), (0.0, ACROSS, BEFORE)  # m, on the flange
DRIVE_NOISE = 0.03  # share of a joint's largest torque
RIG = Rig(
    targets=[Target(f"M{i}", place, fixed=True) for i, place in enumerate(MARKER_PLACES, start=1)],
    load=(LOAD, MARKER_PLACES[0]),
    sideways=np.array([0.0, 200.0, 0.0]),
    tool=(25.0, MARKER_PLACES[0]),
    sigma=SIGMA,
    limits={"joint_1": 0.7, "joint_4": np.pi, "joint_5": 1.9, "joint_6": np.pi},
)
TEST_POSE, TEST_FORCE = np.radians([0, -60, 90, 0, 60, 0]), np.array([300.0, 100.0, -500.0])
INSTRUMENT = np.eye(3), np.array([3.2, -1.4, -0.6])
FILES = {
    "Robot": "robot/kr120.toml",
    "Campaign, soft gear": "campaign/soft/campaign.toml",
    "Campaign, leak": "campaign/leak/campaign.toml",
    "Model": "model.toml",
}


def study(run: StudyRun) -> Study:
    """Table I on simulated machines, the gas spring that it would need, and the measurement that decides."""
    folder, seed, quick, progress = run.folder, run.seed, run.quick, run.say
    robot = stored(folder / "robot" / "kr120.toml", load_robot("kr120"))
    progress(f"choosing {CONFIGURATIONS} configurations in six groups")
    A0 = RIG.moved(robot, TEST_POSE, TEST_FORCE)
    plan = group_plan(robot, "joint_2", ANGLES, PER_ANGLE, RIG, A0, 250 if quick else 1500, seed)

    progress("measuring them before and after loading: Table I")
    truth = machines(robot, seed)
    data = {
        name: load_pairs.measure_pairs(plan.campaign, true, seed, INSTRUMENT) for name, true in truth.items()
    }
    fits = {name: by_angle(campaign) for name, campaign in data.items()}
    k = {"printed": (TABLE_1, HALF_1), **{name: with_half(found) for name, found in fits.items()}}
    constant = true_compliances(robot)
    numbers = NUMBERS | figures.plan_numbers(plan) | figures.compliance_numbers(k, constant)
    for name in ("gas", "soft"):
        one = load_pairs.fit_pairs(data[name], catalogue()["joint_compliance"].sites, SIGMA)
        zone = load_pairs.fit_soft_zone(data[name], "joint_2", SIGMA)
        numbers |= figures.fit_numbers(name, {"one": one, "six": fits[name], "soft": zone})

    progress("fitting gas springs to six stiffnesses")
    stretched = figures.stretched(ANGLES)
    arm = problem_of(planned(robot, stretched))
    six = {name: (values[SIX], half[SIX]) for name, (values, half) in k.items()}
    springs = needed_springs(arm, six)
    numbers |= figures.spring_numbers(springs) | figures.own_spring_numbers(arm, ANGLES)

    progress("identifying charge and gas length")
    numbers |= blind_to_charge(data["leak"], LEAK, SIGMA)
    numbers |= charge_by_witness(robot, truth["gas"], RIG, DRIVE_NOISE, 60 if quick else 150, seed)

    progress("diagnosing richer campaigns")
    loads = three_loads(robot, RIG, 30 if quick else 70, seed)
    rich = {name: simulate(loads, truth[name], seed=seed + 1, torque_sigma=DRIVE_NOISE) for name in MACHINES}
    outcomes = diagnosed(folder / "campaign", data, rich, seed)
    best = outcomes[WAYS[-1]]["soft"]
    write_fit(folder / "model.toml", best.fit)
    numbers |= reversing(best.problem) | deciding(outcomes)

    items: dict[str, Table | Figure] = {
        "torque": figures.torque_figure(robot, stretched, RIG.load, RIG.tool),
        "plans": figures.plan_figure(plan),
        "table_1": figures.compliance_table(k, constant),
        "stiffness": figures.stiffness_figure(arm, ANGLES, six, springs["table_1"]),
        "bias": figures.bias_figure(robot, stretched),
        "verdicts": verdict_table("Verdicts, by what is hidden in the machine", MACHINES, outcomes),
    }
    shown = shown_of(best.diagnosis, best.problem.q[0])
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, shown, "stiffness", FILES)


def by_angle(campaign: Campaign) -> Fit:
    """The paper's model: a serial chain without compensator, joint 2 with a compliance at each angle."""
    serial = replace(campaign, robot=replace(campaign.robot, compensator=None))
    return load_pairs.fit_pairs(serial, lambda problem: load_pairs.grouped(problem, "joint_2", GROUP), SIGMA)


def with_half(found: Fit) -> tuple[Array, Array]:
    """Compliances (11,) and half widths of their 95 % intervals."""
    values, std = load_pairs.compliances(found)
    return values, 1.96 * std


def needed_springs(problem: Problem, six: Mapping[str, tuple[Array, Array]]) -> dict[str, FittedSpring]:
    """Eq. (12): the gas springs that Table I would need, and the one that the soft gear's values would."""
    law = problem.compensator
    assert law is not None
    gas = gas_spring.linkage(problem.arm, law), law.data.piston_area or 0.0, ANGLES
    (k, half), (soft, soft_half) = six["printed"], six["soft"]
    return {
        "table_1": fit_spring(*gas, k, half / 1.96),
        "one_sigma": fit_spring(*gas, k, half),
        "any_order": fit_any_order(*gas, k, half),
        "soft_gear": fit_spring(*gas, soft, soft_half / 1.96),
    }


if __name__ == "__main__":
    run_study(study)
