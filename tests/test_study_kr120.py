"""The KR 120 study: gas springs on any linkage, accounts of Table I, the plan, and the deciding
measurement."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from study_checks import captions_stand_alone, poses_are_counted

from workbench import Truth, parse_effect, simulate
from workbench.campaign import load_campaign
from workbench.report.study import LEAST, Study
from workbench.robot.description import load_robot
from workbench.robot.kinematics import RZ
from workbench.studies.kr120 import decides, linkages, plans, printed, stories, world
from workbench.studies.kr120 import study as kr120
from workbench.studies.running import run_script
from workbench.studies.study_run import StudyRun


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kr120")


class Fewer(StudyRun):
    """Half as many draws as in a quick run, but for those that say how well the charge is found."""

    def draws(self, full: int, quick: int) -> int:
        return quick // 2 if quick >= 24 and quick != 40 else quick


@pytest.fixture(scope="module", params=[pytest.param(None, marks=pytest.mark.slow)])
def found(folder: Path) -> Study:
    """With half the poses in the campaigns that decide: of them it is tested that all are diagnosed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(decides, "POSES", decides.POSES // 2)
        return run_script(kr120.study, Fewer(folder, 0, quick=True, workers=1))


def test_pairs_are_those_of_drake() -> None:
    """The batch world against Drake's simulation of the same machine: soft gear, bearing, bending, floor."""
    plan = plans.plan(1)
    zone = world.soft_zone(1.5e-4, 600.0)
    k = plans.compliances(plans.robot())
    machine = world.World(
        k,
        law=zone,
        bearing=np.array([0.0, 3e-8, 0.0]),
        bending=np.array([2e-8, 0.0]),
        foundation=2e-9,
        sigma=0.0,
    )
    said = [
        "bearing_tilt:joint=joint_2,compliance=3e-8",
        "link_bending:link=link_2,compliance=2e-8",
        "foundation:compliance=2e-9",
    ]
    truth = Truth(
        effects=tuple(parse_effect(text, plan.problem) for text in said),
        yields={2: lambda wrench: np.eye(6)[RZ] * zone(wrench[RZ])[0]},
        sigma=0.0,
        repeatability=np.zeros(6),
    )
    setups = len(plan.problem.campaign.setup_names)
    frames = np.tile(np.eye(3), (setups, 1, 1)), np.zeros((setups, 3))
    measured = simulate(plan.problem.campaign, truth, instrument=frames)
    made = measured.points[plan.count :] - measured.points[: plan.count]
    assert np.abs(world.moved(plan, machine) - made).max() < 1e-9


def test_the_estimate_finds_the_compliances_that_made_the_pairs() -> None:
    plan, rng = plans.plan(0), np.random.default_rng(0)
    k = plans.compliances(plans.robot())
    exact = world.estimated(plan, world.World(k, sigma=0.0), rng)
    assert exact.k == pytest.approx(k[[0, *[1] * 6, 2, 3, 4, 5]], rel=0.02)  # the rest is second order
    noisy = [world.estimated(plan, world.World(k, sigma=3e-5), rng) for _ in range(40)]
    scatter = np.std([each.k for each in noisy], axis=0)
    assert scatter == pytest.approx(np.sqrt(2) * 3e-5 * exact.cofactor, rel=0.4)
    assert np.mean([each.residual for each in noisy]) == pytest.approx(np.sqrt(2) * 3e-5, rel=0.05)


def test_plans_are_as_the_paper_says() -> None:
    for number in range(3):
        plan = plans.plan(number)
        counts = np.bincount(plan.group)
        assert plan.count == printed.CONFIGURATIONS
        assert (counts >= 3).all()
        assert (counts <= 7).all()
        q2 = plan.problem.q[: plan.count, 1]
        assert q2 == pytest.approx(plan.angles[plan.group], abs=1e-6)


def test_gears_are_chosen_so_that_every_account_prints_the_same_level() -> None:
    values = {p: prior.middle for p, prior in stories.accounts(3)[3].priors.items()}
    machine = stories.levelled(stories.soft, values, plans.plan(0), 0)
    exact = world.estimated(plans.plan(0), replace(machine, sigma=0.0), np.random.default_rng(0))
    assert stories.mean_of_six(exact.k) == pytest.approx(stories.mean_of_six(printed.TABLE_1), rel=0.02)


def test_no_linkage_that_the_arm_holds_makes_table_1() -> None:
    drawn = linkages.linkages(500, 20, 1)
    assert drawn.numbers["change"].max() < 0.25 * linkages.CHANGE_1
    assert (drawn.numbers["fit_p"][:20] < 0.05).all()
    assert np.isnan(drawn.numbers["fit_p"][20:]).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_claims_of_the_linkages_hold_for_any_seed(seed: int) -> None:
    drawn = linkages.linkages(300, 10, seed)
    assert (drawn.numbers["share_of_table"] < 0.1).mean() >= LEAST
    assert (drawn.numbers["fit_p"][:10] < 0.01).mean() >= LEAST


def test_table_1_needs_an_absurd_gas_spring(found: Study) -> None:
    n = found.numbers
    assert n["own_most_MN"] < 0.05
    assert n["table_1_least_MN"] > 1.0
    assert n["table_1_chi2"] > n["one_sigma_chi2"] > 20  # 3 dof
    assert n["any_order_chi2"] < n["one_sigma_chi2"]
    assert n["own_sV_m"] == pytest.approx(163 / 1.01 * 0.547, rel=1e-3)
    assert 1e-3 < n["added_share"] < 3e-3


def test_pressures_of_a_kr_300_give_charge_and_exponent(found: Study) -> None:
    n = found.numbers
    assert n["gauge_bar"] == pytest.approx(163, abs=3)
    assert n["gauge_rms_bar"] < 3
    assert abs(n["gauge_exponent"] - 1.2) < 0.25


def test_optimum_plan_beats_random_ones_and_forces_help(found: Study) -> None:
    n = found.numbers
    assert n["rho0_mm"] < n["rho0_best_mm"] < n["rho0_median_mm"]
    assert n["rho0_force_mm"] < n["rho0_median_mm"]
    assert n["hanging_tells_k1"] == 0.0  # gravity makes no torque about an upright axis
    assert n["pulled"] == 6


def test_every_account_is_judged_by_table_1(found: Study) -> None:
    table = next(t for t in found.tables if t.title.startswith("What each account reproduces"))
    assert len(table.rows) == len(stories.TELL) == 10
    assert table.rows[0][0].startswith("authors")
    assert "misses" in table.rows[0][1]  # the gas spring the arm can hold does not make the six
    n = found.numbers
    assert n["p_gas"] < 0.01
    assert sum(n[f"p_{name}"] for name in stories.TELL) == pytest.approx(1.0)
    assert n["blind_share"] < 0.01  # loaded minus unloaded does not see the charge


def test_charge_lies_in_its_intervals(found: Study) -> None:
    n = found.numbers
    # torques alone: an error of the column that goes with the joint's own angle looks like a little charge
    for witness, surer, known in (("points", 0.05, 5), ("torque", 0.08, 4), ("both", 0.05, 5)):
        assert abs(n[f"{witness}_charge"] - n["other_charge"]) < 2 * n[f"{witness}_charge_half"] < surer
        assert abs(n[f"{witness}_length"] - n["other_length"]) < 2 * n[f"{witness}_length_half"] < 0.3
        assert n[f"{witness}_charge_mass_half"] > known * n[f"{witness}_charge_half"]


def test_what_is_said_is_what_was_found(found: Study) -> None:
    assert found.claims["spring_small"].stands
    assert found.claims["no_spring_fits"].stands
    text = " ".join([found.headline, found.summary, found.box.supports])
    assert ("several stay possible" in text) == found.claims["several_left"].stands
    deciding = next(t for t in found.tables if t.title.startswith("How often"))
    assert [row[0] for row in deciding.rows] == list(decides.WAYS.values())


def test_tables_and_files_are_complete(found: Study, folder: Path) -> None:
    assert len(found.figures) == 8
    for name in ("index.html", "report.pdf", "scene.html"):
        assert (folder / name).stat().st_size > 500, name
    written_numbers = json.loads((folder / "result.json").read_text())["numbers"]
    assert set(written_numbers) == {name for name, value in found.numbers.items() if np.isfinite(value)}
    for link in found.files.values():
        assert (folder / link).exists()
    campaign = load_campaign(folder / "campaign" / "campaign.toml")
    assert campaign.robot.compensator is not None
    stated = load_robot("kr120").compensator
    assert stated is not None
    assert campaign.robot.compensator.piston_area == stated.piston_area


def test_captions_stand_alone(found: Study) -> None:
    captions_stand_alone(found, "KUKA KR 120")


def test_poses_are_counted_that_the_robot_could_stand_in(found: Study) -> None:
    poses_are_counted(found, 0.95)
