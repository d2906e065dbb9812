"""KUKA KR 120 with a gas spring: what makes joint 2's stiffness differ from angle to angle? (source 002)

The paper loads the robot with 120 kg in 31 configurations, gives joint 2 a compliance of its own at each of
six angles, and puts the difference between them down to the gas spring. Question: can a gas spring make it,
what else can, and which measurement decides?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
from scipy import stats

from workbench.arm import Array
from workbench.campaign import Campaign, Target, write_campaign
from workbench.compensator.charge import EFFECTS, identify_charge
from workbench.compensator.gas_spring import added_stiffness, bias, linkage
from workbench.compensator.spring_fit import FittedSpring, fit_spring
from workbench.design.groups import Rig, group_plan
from workbench.diagnose.run import Outcome, diagnose
from workbench.effects.base import Effect
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.link_mass import LinkMass
from workbench.effects.lost_motion import LostMotion
from workbench.extended import write_fit, write_model
from workbench.fit import Fit
from workbench.poses import planned, random_poses
from workbench.problem import Problem, problem
from workbench.protocols.load_pairs import (
    as_one_setup,
    compliances,
    difference_rows,
    fit_pairs,
    grouped,
    measure_pairs,
    pairs,
)
from workbench.report.charts import OURS, PRINTED, Series, curves, histogram
from workbench.report.drawing import MIDDLE, NOISE, Figure
from workbench.report.numbers import decimals
from workbench.report.story import tell
from workbench.report.study import Study, Table
from workbench.robot import Robot, load_robot
from workbench.simulate import Truth, random_geometry, simulate
from workbench.studies.kr120_figures import bias_figure, reach, torque_figure
from workbench.studies.verdicts import in_space, verdict_table

# Table I as printed, 1e-6 rad/(N·m): k1, k2 at six angles, k3 to k6, and their intervals' half widths
NAMES = ("k1", "k21", "k22", "k23", "k24", "k25", "k26", "k3", "k4", "k5", "k6")
TABLE_1 = 1e-6 * np.array([1.13, 0.34, 0.36, 0.35, 0.28, 0.32, 0.26, 0.43, 0.95, 3.82, 4.01])
HALF_1 = 1e-6 * np.array([0.15, 0.004, 0.005, 0.005, 0.007, 0.011, 0.007, 0.007, 0.31, 0.27, 0.35])
SIX = slice(1, 7)
PER_ANGLE = (7, 6, 5, 5, 4, 4)  # printed: three to seven, 31 in all
GROUP = [group for group, count in enumerate(PER_ANGLE) for _ in range(count)] * 2

# not in the paper: the story says why
ANGLES = np.radians(np.linspace(-140, -5, 6))
MARKERS = [
    Target(f"M{i + 1}", place, fixed=True)
    for i, place in enumerate([(0.23, 0.0, 0.0755), (-0.23, 0.0, 0.0755), (0.0, 0.23, 0.0755)])
]
HALF_LOAD, LOAD, TOOL = ((mass, (0.23, 0.0, 0.0755)) for mass in (60.0, 120.0, 25.0))
TEST_POSE, TEST_FORCE = np.radians([[0, -60, 90, 0, 60, 0]]), np.array([[300.0, 100.0, -500.0]])
SIGMA, DRIVE_NOISE = 3e-5, 0.03
RIG = Rig(
    targets=MARKERS,
    load=LOAD,
    sideways=np.array([0.0, 200.0, 0.0]),
    tool=TOOL,
    sigma=SIGMA,
    limits={"joint_1": 0.7, "joint_4": np.pi, "joint_5": 1.9, "joint_6": np.pi},
)
CHARGE = 120e5  # Pa
GEAR, SOFT_ZONE, SOFT_TORQUE = 0.23e-6, float(np.radians(0.5 / 60)), 500.0
LEAK, OTHER_CHARGE, OTHER_LENGTH = -0.15, -0.08, 0.12
INSTRUMENT = np.eye(3), np.array([3.2, -1.4, -0.6])
GAS, GAS_LENGTH = EFFECTS
MODELS = ("one", "six", "soft")  # stiffnesses of joint 2: one, one per angle, one with a soft zone
HIDDEN = {"gas": "Gas spring alone", "soft": "Soft gear", "leak": f"Leak, {-100 * LEAK:.0f} % of the charge"}
WAYS = ("the 31 pairs, read as absolute poses", "poses under three loads", "… with motor torque")


def study(folder: Path, seed: int, quick: bool, progress: Callable[[str], None]) -> Study:
    """Table I on simulated machines, the gas spring that it would need, and the measurement that decides."""
    robot = charged(folder)
    progress("choosing 31 configurations in six groups")
    A0 = difference_rows(pairs(robot, TEST_POSE, LOAD, TEST_FORCE, MARKERS, TOOL))[0, :3]
    plan = group_plan(robot, "joint_2", ANGLES, PER_ANGLE, RIG, A0, 250 if quick else 1500, seed)
    numbers = {
        "rho0_mm": 1e3 * plan.rho0,
        "rho0_median_mm": 1e3 * float(np.median(plan.random)),
        "rho0_best_mm": 1e3 * float(plan.random.min()),
        "hanging_tells_k1": float(np.isfinite(plan.hanging)),
        "fewer": float(np.median(plan.random) / plan.rho0) ** 2,
        "pulled": float(plan.campaign.wrench.any(axis=1).sum()),
    }

    progress("measuring them before and after loading, on three machines")
    truth = machines(robot, seed)
    data = {name: measure_pairs(plan.campaign, true, seed, INSTRUMENT) for name, true in truth.items()}
    without_noise = {
        "exact": truth["gas"],
        "soft_100_bar": replace(truth["soft"], effects=(*truth["soft"].effects, (GAS, np.array([-1 / 6])))),
    }
    for name, true in without_noise.items():
        data[name] = measure_pairs(plan.campaign, replace(true, sigma=1e-9), seed, INSTRUMENT)
    k = {name: by_angle(campaign) for name, campaign in data.items()}
    for name, (values, half, _) in {**k, "printed": (TABLE_1, HALF_1, None)}.items():
        numbers |= {f"{key}_{name}": float(v) for key, v in zip(NAMES, values, strict=True)}
        numbers |= {f"{key}_{name}_half": float(h) for key, h in zip(NAMES, half, strict=True)}
        numbers[f"spread_{name}"] = float(np.ptp(values[SIX]) / values[SIX].mean())
    constant = true_compliances(robot)
    numbers["wider_than_printed"] = float(np.median(k["gas"][1] / HALF_1))
    numbers["soft_misses"] = float((abs(k["soft"][0] - constant) / k["soft"][1])[7:].max())
    for name in ("gas", "soft"):
        numbers |= rivals(name, data[name])
    numbers |= blind_to_charge(data["leak"])

    progress("fitting gas springs to six stiffnesses")
    job = problem(planned(robot, sweep()))
    springs = needed_springs(job, k["soft"])
    for name, spring in springs.items():
        numbers |= described(name, spring)
    numbers |= own_spring(job, robot)

    progress("identifying charge and gas length")
    numbers |= charge_by_witness(robot, truth["gas"], seed, 60 if quick else 150)

    progress("diagnosing richer campaigns")
    outcomes = deciding(folder, robot, data, truth, seed, 30 if quick else 70)
    best = outcomes[WAYS[-1]]["soft"]
    write_fit(folder / "model.toml", best.fit)
    bare, _, full = best.problem.nominal_load.local[:, 2, 5].reshape(3, -1)
    numbers |= {"rich_poses": float(len(bare)), "reversing": float((bare * full < 0).sum())}

    items: dict[str, Table | Figure] = {
        "torque": torque_figure(robot, sweep(), LOAD, TOOL),
        "plans": plan_figure(plan.random, plan.rho0),
        "table_1": table_1(k, constant),
        "stiffness": stiffness_figure(k["soft"], springs["table_1"], job),
        "bias": bias_figure(robot, sweep()),
        "verdicts": verdict_table("Verdicts, by what is hidden in the machine", HIDDEN, outcomes),
    }
    files = {
        "Robot": "robot/kr120.toml",
        "Campaign, soft gear": "campaign/soft/campaign.toml",
        "Campaign, leak": "campaign/leak/campaign.toml",
        "Model": "model.toml",
    }
    return tell(Path(__file__).with_suffix(".md"), robot, numbers, items, in_space(best), "stiffness", files)


def charged(folder: Path) -> Robot:
    """The KR 120 with the study's gas charge, written beside the study."""
    robot = load_robot("kr120")
    assert robot.compensator is not None
    gas = robot.compensator.model_copy(update={"precharge": CHARGE})
    path = folder / "robot" / "kr120.toml"
    write_model(path, replace(robot, compensator=gas), np.zeros((len(robot.joints) + 2, 6)), [])
    return load_robot(path)


def machines(robot: Robot, seed: int) -> dict[str, Truth]:
    """As the paper models it; with a soft gear in joint 2; with a leaking compensator."""
    job = problem(planned(robot, TEST_POSE))
    joint_2 = JointCompliance.sites(job)[1]
    usual = Truth(geometry=random_geometry(job.arm, np.random.default_rng([seed, 1])), sigma=SIGMA)

    def soft(wrench: Array) -> Array:
        x = wrench[5] / SOFT_TORQUE
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, SOFT_ZONE * x / np.sqrt(1 + x**2)])

    stiffer = joint_2, np.array([GEAR / joint_2.nominal - 1])
    return {
        "gas": usual,
        "soft": replace(usual, effects=(stiffer,), yields={joint_2.slot(job.arm): soft}),
        "leak": replace(usual, effects=((GAS, np.array([LEAK])),)),
    }


def true_compliances(robot: Robot) -> Array:
    """(11,) as Table I lists them, of a gear that is the same at all angles."""
    k = np.array([1 / (joint.data.stiffness or np.inf) for joint in robot.joints])
    return np.array([k[0], *[k[1]] * 6, *k[2:]])


def by_angle(campaign: Campaign) -> tuple[Array, Array, Fit]:
    """Compliances (11,) of the paper's model, a serial chain without compensator, and half widths (95 %)."""
    serial = replace(campaign, robot=replace(campaign.robot, compensator=None))
    found = fit_pairs(serial, lambda job: grouped(job, "joint_2", GROUP), SIGMA)
    values, std = compliances(found)
    return values, 1.96 * std, found


def rivals(name: str, campaign: Campaign) -> dict[str, float]:
    """χ² of the same pairs by three models of joint 2."""

    def with_zone(zone: LostMotion) -> Fit:
        return fit_pairs(campaign, lambda job: [*JointCompliance.sites(job), zone], SIGMA)

    zones = [zone for zone in LostMotion.sites(problem(campaign)) if zone.where.joint == "joint_2"]
    soft = min((with_zone(zone) for zone in zones), key=lambda found: found.chi2)
    one = fit_pairs(campaign, JointCompliance.sites, SIGMA)
    numbers: dict[str, float] = {}
    for model, found in zip(MODELS, (one, by_angle(campaign)[2], soft), strict=True):
        dof = found.point_rows - len(found.columns.names)
        numbers |= {f"{name}_{model}_chi2": found.chi2, f"{name}_{model}_dof": float(dof)}
        numbers[f"{name}_{model}_p"] = float(stats.chi2.sf(found.chi2, dof))
    return numbers


def blind_to_charge(campaign: Campaign) -> dict[str, float]:
    """What loaded minus unloaded says of the compensator's charge."""
    found = fit_pairs(campaign, lambda job: [*JointCompliance.sites(job), GAS], SIGMA)
    values, covariance = found.effect_values(len(found.model.effects) - 1)
    half = 1.96 * float(np.sqrt(covariance[0, 0]))
    return {"lost_charge": -LEAK, "pairs_charge": float(values[0]), "pairs_charge_half": half}


def needed_springs(job: Problem, soft: tuple[Array, Array, Fit]) -> dict[str, FittedSpring]:
    """Eq. (12): the gas springs that Table I would need, and the one that the soft gear's values would."""
    assert job.compensator is not None
    triangle, area = linkage(job.arm, job.compensator), job.compensator.data.piston_area or 0.0

    def needed(values: Array, sigma: Array) -> FittedSpring:
        return fit_spring(triangle, area, ANGLES, values, sigma)

    k, half = TABLE_1[SIX], HALF_1[SIX]
    orders = (needed(k[list(order)], half[list(order)]) for order in permutations(range(6)))
    return {
        "table_1": needed(k, half / 1.96),
        "one_sigma": needed(k, half),
        "any_order": min(orders, key=lambda spring: spring.chi2),
        "soft_gear": needed(soft[0][SIX], soft[1][SIX] / 1.96),
    }


def described(name: str, spring: FittedSpring) -> dict[str, float]:
    return {
        f"{name}_least_MN": 1e-6 * float(spring.force.min()),
        f"{name}_most_MN": 1e-6 * float(spring.force.max()),
        f"{name}_torque_kNm": 1e-3 * float(np.abs(spring.torque).max()),
        f"{name}_gear_MNm": 1e-6 * spring.stiffness,
        f"{name}_chi2": spring.chi2,
        f"{name}_p": float(stats.chi2.sf(spring.chi2, spring.dof)),
    }


def own_spring(job: Problem, robot: Robot) -> dict[str, float]:
    """What the robot's own gas spring does: force, torque, stiffness, and shift of the stretched arm."""
    law = job.compensator
    assert law is not None
    triangle, gear = linkage(job.arm, law), robot.joints[1].data.stiffness or np.inf
    force, torque = law.force(triangle.stretch(ANGLES)[0])[0], bias(triangle, law, ANGLES)
    added = added_stiffness(triangle, law, ANGLES)
    return {
        "a_mm": 1e3 * triangle.a,
        "L_mm": 1e3 * triangle.L,
        "alpha_deg": float(np.degrees(triangle.alpha)),
        "own_least_MN": 1e-6 * float(force.min()),
        "own_most_MN": 1e-6 * float(force.max()),
        "own_torque_kNm": 1e-3 * float(np.abs(torque).max()),
        "own_gear_MNm": 1e-6 * gear,
        "added_least_kNm": 1e-3 * float(added.min()),
        "added_most_kNm": 1e-3 * float(added.max()),
        "added_share": float(added.max()) / gear,
        "bias_shift_mm": 1e3 * float(np.abs(torque).max()) / gear * reach(job, 1),
    }


def charge_by_witness(robot: Robot, usual: Truth, seed: int, poses: int) -> dict[str, float]:
    """Charge and gas length from unloaded poses, from motor torque, from both: with all else known, beside
    joint 2's stiffness, beside link 2's centre of mass."""
    q = random_poses(robot, poses, np.random.default_rng([seed, 2]), floor=0.4, clear=0.6)
    plan = planned(robot, q, targets=MARKERS, tool=TOOL)
    other = (GAS, np.array([OTHER_CHARGE])), (GAS_LENGTH, np.array([OTHER_LENGTH]))
    measured = simulate(plan, replace(usual, effects=other), seed=seed, torque_sigma=DRIVE_NOISE)
    job = problem(plan)
    masses = [e for e in LinkMass.sites(job) if e.where.link == "link_2" and e.variant == "com"]
    beside: dict[str, Sequence[Effect]] = {
        "": (),
        "_stiffness": JointCompliance.sites(job)[1:2],
        "_mass": masses,
    }
    numbers: dict[str, float] = {"other_charge": OTHER_CHARGE, "other_length": OTHER_LENGTH}
    for witness in ("points", "torque", "both"):
        for name, unknown in beside.items():
            found = identify_charge(measured, witness, DRIVE_NOISE, unknown)
            numbers |= {f"{witness}_charge{name}": found.charge, f"{witness}_length{name}": found.length}
            numbers[f"{witness}_charge{name}_half"] = 1.96 * found.charge_std
            numbers[f"{witness}_length{name}_half"] = 1.96 * found.length_std
    return numbers


def deciding(
    folder: Path,
    robot: Robot,
    data: Mapping[str, Campaign],
    truth: Mapping[str, Truth],
    seed: int,
    poses: int,
) -> dict[str, dict[str, Outcome]]:
    """Diagnoses of each machine: of the paper's records, then of three loads, then with motor torque."""
    q = random_poses(robot, poses, np.random.default_rng([seed, 3]), floor=0.4, clear=0.6)
    loads = {"half": HALF_LOAD, "full": LOAD}
    plan = planned(
        robot,
        np.tile(q, (3, 1)),
        targets=MARKERS,
        payloads=loads,
        payload=[name for name in ("", *loads) for _ in range(poses)],
        tool=TOOL,
        title=f"{robot.title}, {poses} poses under three loads",
    )
    found: dict[str, dict[str, Outcome]] = {way: {} for way in WAYS}
    for name, true in truth.items():
        rich = simulate(plan, true, seed=seed + 1, torque_sigma=DRIVE_NOISE)
        write_campaign(folder / "campaign" / name, rich, comments=["simulated in Drake"])
        for way, campaign in zip(
            WAYS, (as_one_setup(data[name]), replace(rich, torque=None), rich), strict=True
        ):
            found[way][name] = diagnose(campaign, seed=seed)
    return found


def sweep() -> Array:
    """The arm stretched, joint 2 over its range: (N, 6)."""
    q = np.zeros((91, 6))
    q[:, 1] = np.linspace(ANGLES[0], ANGLES[-1], len(q))
    return q


def plan_figure(random: Array, rho0: float) -> Figure:
    marks = {
        "optimum": 1e3 * rho0,
        "best of 300 random": 1e3 * float(random.min()),
        "median": 1e3 * float(np.median(random)),
    }
    title = "The optimum plan against 300 random plans of the same size"
    return histogram("plans", title, 1e3 * random, "expected error at the test pose ρ0, mm", marks)


def table_1(k: Mapping[str, tuple[Array, Array, Fit]], constant: Array) -> Table:
    """Table I with intervals beside ours, 1e-6 rad/(N·m)."""
    columns = [TABLE_1, HALF_1, *k["gas"][:2], constant, *k["soft"][:2]]
    places = [2 if key in ("k1", "k4", "k5", "k6") else 3 for key in NAMES]
    rows = [
        [key, *(decimals(1e6 * float(column[i]), places[i]) for column in columns)]
        for i, key in enumerate(NAMES)
    ]
    head = ("10⁻⁶ rad/(N·m)", "Table I", "±", "Gas spring alone", "±", "True", "With soft gear", "±")
    note = (
        "± of ours: 95 %; what the paper's “CI” is it does not say. Angles of joint 2 in the printed order."
    )
    return Table("Compliances: the paper's Table I beside ours", head, rows, note)


def stiffness_figure(soft: tuple[Array, Array, Fit], needed: FittedSpring, job: Problem) -> Figure:
    def bars(k: Array, half: Array, colour: str) -> Series:
        return Series(1e-6 / k, 1e-6 / (k + half), 1e-6 / (k - half), colour, "o")

    assert job.compensator is not None
    alone = 1 / TABLE_1[SIX].mean() + added_stiffness(
        linkage(job.arm, job.compensator), job.compensator, ANGLES
    )
    series = {
        "gas spring alone": Series(1e-6 * alone, colour=MIDDLE),
        "needed gas spring, eq. (12)": Series(1e-6 / needed.compliance, colour=NOISE, style="--"),
        "Table I": bars(TABLE_1[SIX], HALF_1[SIX], PRINTED),
        "ours, with soft gear": bars(soft[0][SIX], soft[1][SIX], OURS),
    }
    title = "The gas spring leaves joint 2's stiffness flat; a soft gear scatters it as Table I does"
    return curves(
        "stiffness", title, np.degrees(ANGLES), series, "joint 2, °", "stiffness, MN·m/rad", height=3.4
    )


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
