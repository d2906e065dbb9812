"""KUKA KR 120 with a gas spring: what makes joint 2's stiffness differ from angle to angle?

Klimchik et al. (2017) load the robot in 31 configurations, give joint 2 a compliance of its own at each of
six angles, and put the difference between them down to the gas spring. Question: can a gas spring make it,
what else can, and which measurement decides?
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Campaign,
    Draws,
    Figure,
    FittedSpring,
    Judged,
    Problem,
    Study,
    StudyRun,
    Table,
    account_items,
    as_package,
    clear_numbers,
    clear_poses,
    clear_table,
    counterpart,
    diagnose,
    fit_any_order,
    fit_spring,
    group_plan,
    judge,
    load_robot,
    planned,
    problem_of,
    run_study,
    shown_of,
    simulate,
    stored,
    tell,
    tornado,
    write_campaign,
    write_fit,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from . import figures, plans
from .assumed import OWN, common
from .compensator import changed_gas, charge_by_witness, gauged
from .decides import (
    DRIVE_NOISE,
    PRIORS,
    RIG,
    campaigns,
    deciding_draws,
    deciding_numbers,
    deciding_table,
    truths,
)
from .decides import POSES as DECIDING
from .linkages import linkage_figure, linkage_numbers, linkages
from .patterns import (
    blind_to_charge,
    machine_draws,
    pattern_figure,
    pattern_numbers,
    pattern_table,
    soft_numbers,
)
from .plans import POOL, QUICK_POOL, TEST_FORCE, TEST_POSE, spring
from .printed import CONFIGURATIONS, HALF_1, NUMBERS, SIX, TABLE_1
from .said import ODDS, TENTH, stands
from .stories import ITEMS, accounts

PER_ANGLE = (7, 6, 5, 5, 4, 4)  # the paper says: three to seven
ANGLES = np.radians(np.linspace(-140, -5, 6))  # of the one plan that is shown
SHOWN = ("gas", "soft", "sessions")  # in the figure of patterns
FILES = {"Robot": "robot/kr120.toml", "Campaign, soft gear": "campaign/campaign.toml", "Model": "model.toml"}


def study(run: StudyRun) -> Study:
    """The gas spring on any linkage, accounts of Table I, and the measurement that decides."""
    folder, seed = run.folder, run.seed
    if run.quick and run.workers is None:  # what is drawn is less than starting processes for it
        run = replace(run, workers=1)
    robot = stored(folder / "robot" / "kr120.toml", load_robot("kr120"))
    run.say("gas springs on linkages drawn at random")
    stretched = figures.stretched(ANGLES)
    arm = problem_of(planned(robot, stretched))
    springs = needed_springs(arm)
    drawn = linkages(run.draws(4000, 1000), run.draws(400, 60), seed)
    numbers = NUMBERS | figures.spring_numbers(springs) | figures.own_spring_numbers(arm, ANGLES)
    numbers |= linkage_numbers(drawn) | gauged(spring(arm)[0]) | {"blind_share": blind_to_charge()}

    run.say(f"choosing {CONFIGURATIONS} configurations in six groups")
    A0 = RIG.moved(robot, TEST_POSE, TEST_FORCE)
    plan = group_plan(robot, "joint_2", ANGLES, PER_ANGLE, RIG, A0, run.draws(400, 120), seed)
    numbers |= figures.plan_numbers(plan)

    run.say("holding each account against Table I")
    told = accounts(run.draws(POOL, QUICK_POOL))
    judged = judge(told, ITEMS, run.draws(300, 30), run, chunk=run.draws(75, 30))
    made = machine_draws(told, run.draws(100, 24), run)
    soft = machine_draws([a for a in told if a.name == "soft"], run.draws(600, 100), run, "soft")
    numbers |= judged.numbers() | pattern_numbers(made, [a.name for a in told]) | soft_numbers(soft)

    run.say("identifying charge and gas length")
    usual = truths({name: prior.middle for name, prior in PRIORS.items()}, seed)
    numbers |= charge_by_witness(robot, usual["gas"], RIG, DRIVE_NOISE, run.draws(80, 40), seed)

    run.say("diagnosing richer campaigns")
    decided = deciding_draws(run.draws(50, 1), run)
    numbers |= deciding_numbers(decided)
    campaign = simulate(campaigns("torque", seed), usual["soft"], seed=seed, torque_sigma=DRIVE_NOISE)
    write_campaign(folder / "campaign", campaign, comments=["simulated in Drake"])
    best = diagnose(campaign, seed=seed)
    write_fit(folder / "model.toml", best.fit)

    clear = clear_poses(robot, stood_in(plan.campaign, run.draws(POOL, QUICK_POOL), campaign))
    numbers |= clear_numbers(clear)
    items: dict[str, Table | Figure] = {
        "clear": clear_table(clear),
        "measured": counterpart("kr120", run),
        "torque": figures.torque_figure(robot, stretched, RIG.load, RIG.tool),
        "gas_table": changed_gas(arm, ANGLES, figures.reach(arm, 1)),
        "linkages": linkage_figure(drawn),
        "carries": linkage_tornado(drawn),
        "plans": figures.plan_figure(plan),
        "stiffness": figures.stiffness_figure(arm, ANGLES, springs["one_sigma"]),
        **shown_accounts(judged, made),
        "bias": figures.bias_figure(robot, stretched),
        "deciding": deciding_table(decided),
    }
    numbers |= {"tenth": TENTH, "odds_out": ODDS, "pool": float(len(told))}
    claims = stands(numbers, judged, drawn, made, soft, decided)
    shown = shown_of(best.diagnosis, best.problem.q[0])
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, shown, "linkages", FILES, claims)


def stood_in(shown: Campaign, pool: int, deciding: Campaign) -> dict[str, Array]:
    """What poses are for → their joints (N, n) [rad]."""
    return {
        "plan that is shown": shown.poses.q[:CONFIGURATIONS],
        f"pool of {pool} plans": np.concatenate(
            [plans.plan(i).problem.q[:CONFIGURATIONS] for i in range(pool)]
        ),
        "measurement that decides": deciding.poses.q[:DECIDING],
    }


def shown_accounts(judged: Judged, made: Draws) -> dict[str, Table | Figure]:
    """The accounts of Table I and what their machines do, as tables and figures."""
    return {
        **account_items(judged),
        "needs": allowed_table(judged),
        "pattern": pattern_figure(judged, SHOWN),
        "patterns": pattern_table(made, judged.accounts),
    }


def needed_springs(problem: Problem) -> dict[str, FittedSpring]:
    """Eq. (12) on the robot's own linkage: the gas springs that Table I would need, by how its CI is read."""
    triangle, law = spring(problem)
    area = law.data.piston_area or 0.0
    k, half = TABLE_1[SIX], HALF_1[SIX]

    def with_sigma(sigma: Array) -> FittedSpring:
        return fit_spring(triangle, area, ANGLES, k, sigma)

    return {
        "table_1": with_sigma(half / 1.96),
        "one_sigma": with_sigma(half),
        "any_order": fit_any_order(triangle, area, ANGLES, k, half),
    }


def allowed_table(judged: Judged) -> Table:
    """What each account is free to choose beyond what all leave open, and what all leave open."""
    rows = [
        [account.words, prior.words, prior.range, prior.why]
        for account in judged.accounts
        for prior in OWN[account.name][1].values()
    ]
    rows += [["all of them", prior.words, prior.range, prior.why] for prior in common(POOL).values()]
    head = ("Account", "Free value", "Allowed", "Why this range")
    return Table("What each account was free to choose", head, rows, numbers=())


def linkage_tornado(drawn: Draws) -> Figure:
    """Which assumption carries the change of stiffness."""
    return tornado(
        drawn,
        "change",
        "carries",
        "change of joint 2's stiffness over the six angles, kN·m/rad",
        1e-3,
        "Which assumption carries the change of joint 2's stiffness",
    )


if __name__ == "__main__":
    run_study(study)
