"""KUKA KR 120 with a gas spring: what makes joint 2's stiffness differ from angle to angle? (source 002)

The paper loads the robot with 120 kg in 31 configurations, gives joint 2 a compliance of its own at each of
six angles, and puts the difference between them down to the gas spring. Question: can a gas spring make it,
what else can, and which measurement decides?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.campaign import Campaign, Target
from workbench.campaign.planned import planned
from workbench.campaign.problem import Problem, problem
from workbench.effects.joint_compliance import JointCompliance
from workbench.identification.fit import Fit
from workbench.identification.gravity_compensator.charge import EFFECTS
from workbench.identification.gravity_compensator.gas_spring import linkage
from workbench.identification.gravity_compensator.spring_fit import FittedSpring, fit_any_order, fit_spring
from workbench.identification.model_file import write_fit
from workbench.identification.restated import stored
from workbench.measurement.group_plan import Rig, group_plan
from workbench.measurement.load_pairs import compliances, fit_pairs, fit_soft_zone, grouped, measure_pairs
from workbench.report.scene import shown_of
from workbench.report.story import Item, tell
from workbench.report.study import Study
from workbench.robot.description import Robot, load_robot
from workbench.robot.kinematics import Array
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate
from workbench.studies.kr120 import figures as told
from workbench.studies.kr120.compensator import blind_to_charge, charge_by_witness
from workbench.studies.kr120.decides import WAYS, diagnosed, reversing, three_loads
from workbench.studies.verdicts import verdict_table

# Table I as printed, 1e-6 rad/(N·m): k1, k2 at six angles, k3 to k6, and their intervals' half widths
NAMES = ("k1", "k21", "k22", "k23", "k24", "k25", "k26", "k3", "k4", "k5", "k6")
TABLE_1 = 1e-6 * np.array([1.13, 0.34, 0.36, 0.35, 0.28, 0.32, 0.26, 0.43, 0.95, 3.82, 4.01])
HALF_1 = 1e-6 * np.array([0.15, 0.004, 0.005, 0.005, 0.007, 0.011, 0.007, 0.007, 0.31, 0.27, 0.35])
SIX = slice(1, 7)
PER_ANGLE = (7, 6, 5, 5, 4, 4)  # printed: three to seven, 31 in all
GROUP = [group for group, count in enumerate(PER_ANGLE) for _ in range(count)] * 2

# not in the paper: the story says why
ANGLES = np.radians(np.linspace(-140, -5, 6))
PLACES = (0.23, 0.0, 0.0755), (-0.23, 0.0, 0.0755), (0.0, 0.23, 0.0755)  # m, on the flange
SIGMA, DRIVE_NOISE = 3e-5, 0.03  # m; share of a joint's largest torque
RIG = Rig(
    targets=[Target(f"M{i}", place, fixed=True) for i, place in enumerate(PLACES, start=1)],
    load=(120.0, PLACES[0]),
    sideways=np.array([0.0, 200.0, 0.0]),
    tool=(25.0, PLACES[0]),
    sigma=SIGMA,
    limits={"joint_1": 0.7, "joint_4": np.pi, "joint_5": 1.9, "joint_6": np.pi},
)
TEST_POSE, TEST_FORCE = np.radians([0, -60, 90, 0, 60, 0]), np.array([300.0, 100.0, -500.0])
INSTRUMENT = np.eye(3), np.array([3.2, -1.4, -0.6])
CHARGE = 120e5  # Pa, of the gas spring
GEAR, SOFT_ZONE, SOFT_TORQUE = 0.23e-6, float(np.radians(0.5 / 60)), 500.0  # rad/(N·m), rad, N·m
LEAK = 0.15  # of the charge
HIDDEN = {"gas": "Gas spring alone", "soft": "Soft gear", "leak": f"Leak, {100 * LEAK:.0f} % of the charge"}
FILES = {
    "Robot": "robot/kr120.toml",
    "Campaign, soft gear": "campaign/soft/campaign.toml",
    "Campaign, leak": "campaign/leak/campaign.toml",
    "Model": "model.toml",
}


def study(folder: Path, seed: int, quick: bool, progress: Callable[[str], None]) -> Study:
    """Table I on simulated machines, the gas spring that it would need, and the measurement that decides."""
    robot = charged(folder / "robot" / "kr120.toml")
    progress("choosing 31 configurations in six groups")
    A0 = RIG.moved(robot, TEST_POSE, TEST_FORCE)
    plan = group_plan(robot, "joint_2", ANGLES, PER_ANGLE, RIG, A0, 250 if quick else 1500, seed)

    progress("measuring them before and after loading: Table I")
    truth = machines(robot, seed)
    data = {name: measure_pairs(plan.campaign, true, seed, INSTRUMENT) for name, true in truth.items()}
    fits = {name: by_angle(campaign) for name, campaign in data.items()}
    k = {"printed": (TABLE_1, HALF_1), **{name: with_half(found) for name, found in fits.items()}}
    constant = true_compliances(robot)
    numbers = told.plan_numbers(plan) | told.compliance_numbers(NAMES, k, constant)
    for name in ("gas", "soft"):
        one = fit_pairs(data[name], JointCompliance.sites, SIGMA)
        zone = fit_soft_zone(data[name], "joint_2", SIGMA)
        numbers |= told.fit_numbers(name, {"one": one, "six": fits[name], "soft": zone})

    progress("fitting gas springs to six stiffnesses")
    stretched = told.stretched(ANGLES)
    arm = problem(planned(robot, stretched))
    six = {name: (values[SIX], half[SIX]) for name, (values, half) in k.items()}
    springs = needed_springs(arm, six)
    numbers |= told.spring_numbers(springs) | told.own_spring_numbers(arm, ANGLES)

    progress("identifying charge and gas length")
    numbers |= blind_to_charge(data["leak"], LEAK, SIGMA)
    numbers |= charge_by_witness(robot, truth["gas"], RIG, DRIVE_NOISE, 60 if quick else 150, seed)

    progress("diagnosing richer campaigns")
    loads = three_loads(robot, RIG, 30 if quick else 70, seed)
    rich = {name: simulate(loads, truth[name], seed=seed + 1, torque_sigma=DRIVE_NOISE) for name in HIDDEN}
    outcomes = diagnosed(folder / "campaign", data, rich, seed)
    best = outcomes[WAYS[-1]]["soft"]
    write_fit(folder / "model.toml", best.fit)
    numbers |= reversing(best.problem)

    items: dict[str, Item] = {
        "torque": told.torque_figure(robot, stretched, RIG.load, RIG.tool),
        "plans": told.plan_figure(plan),
        "table_1": told.compliance_table(NAMES, k, constant),
        "stiffness": told.stiffness_figure(arm, ANGLES, six, springs["table_1"]),
        "bias": told.bias_figure(robot, stretched),
        "verdicts": verdict_table("Verdicts, by what is hidden in the machine", HIDDEN, outcomes),
    }
    shown = shown_of(best.diagnosis, best.problem.q[0])
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, shown, "stiffness", FILES)


def charged(path: Path) -> Robot:
    """The KR 120 with the study's gas charge, written beside the study."""
    robot = load_robot("kr120")
    assert robot.compensator is not None
    return stored(
        path, replace(robot, compensator=robot.compensator.model_copy(update={"precharge": CHARGE}))
    )


def machines(robot: Robot, seed: int) -> dict[str, Truth]:
    """As the paper models it; with a soft gear in joint 2; with a leak; and two without noise."""
    job = problem(planned(robot, TEST_POSE[None]))
    joint_2, (gas, _) = JointCompliance.sites(job)[1], EFFECTS
    usual = Truth(geometry=random_geometry(job.arm, np.random.default_rng([seed, 1])), sigma=SIGMA)

    def soft_zone(wrench: Array) -> Array:
        x = wrench[5] / SOFT_TORQUE
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, SOFT_ZONE * x / np.sqrt(1 + x**2)])

    stiffer = joint_2, np.array([GEAR / joint_2.nominal - 1])
    soft = replace(usual, effects=(stiffer,), yields={joint_2.slot(job.arm): soft_zone})
    at_100_bar = gas, np.array([-1 / 6])
    return {
        "gas": usual,
        "soft": soft,
        "leak": replace(usual, effects=((gas, np.array([-LEAK])),)),
        "exact": replace(usual, sigma=1e-9),
        "soft_100_bar": replace(soft, effects=(stiffer, at_100_bar), sigma=1e-9),
    }


def true_compliances(robot: Robot) -> Array:
    """(11,) as Table I lists them, of a gear that is the same at all angles."""
    k = np.array([1 / (joint.data.stiffness or np.inf) for joint in robot.joints])
    return np.array([k[0], *[k[1]] * 6, *k[2:]])


def by_angle(campaign: Campaign) -> Fit:
    """The paper's model: a serial chain without compensator, joint 2 with a compliance at each angle."""
    serial = replace(campaign, robot=replace(campaign.robot, compensator=None))
    return fit_pairs(serial, lambda job: grouped(job, "joint_2", GROUP), SIGMA)


def with_half(found: Fit) -> tuple[Array, Array]:
    """Compliances (11,) and half widths of their 95 % intervals."""
    values, std = compliances(found)
    return values, 1.96 * std


def needed_springs(job: Problem, six: Mapping[str, tuple[Array, Array]]) -> dict[str, FittedSpring]:
    """Eq. (12): the gas springs that Table I would need, and the one that the soft gear's values would."""
    assert job.compensator is not None
    gas = linkage(job.arm, job.compensator), job.compensator.data.piston_area or 0.0, ANGLES
    (k, half), (soft, soft_half) = six["printed"], six["soft"]
    return {
        "table_1": fit_spring(*gas, k, half / 1.96),
        "one_sigma": fit_spring(*gas, k, half),
        "any_order": fit_any_order(*gas, k, half),
        "soft_gear": fit_spring(*gas, soft, soft_half / 1.96),
    }


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
