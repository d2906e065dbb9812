"""The long-link study: what the tables cannot tell, what bends, accounts, calibration, what would show
load."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from study_checks import captions_stand_alone, poses_are_counted

from workbench import deflection, planned, with_compliance
from workbench import denavit_hartenberg as dh
from workbench.campaign import load_campaign
from workbench.report.study import LEAST, Study
from workbench.robot.description import load_robot
from workbench.studies.longlink import arm, circular, driven, linear, printed, recursion, stories
from workbench.studies.longlink import study as longlink
from workbench.studies.running import run_script
from workbench.studies.study_run import StudyRun


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("longlink")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    return run_script(longlink.study, StudyRun(folder, 0, quick=True, workers=1))


def test_the_linear_arm_is_drakes_to_a_twentieth() -> None:
    """Table III's arm that yields, measured in Drake, against tips and sag of the pool."""
    robot = with_compliance(load_robot("longlink"), 0.5)
    q = linear.poses(20, [0, 90, 0], 90)
    made = replace(arm.ARM, sigma=0.0).measured(robot, q, [0, 1])
    R, t = arm.STATION[0][0], arm.STATION[1][0]
    seen = (made.points[:, 0] - t) @ R - linear.tip(printed.TABLE_2, q)
    where = linear.pool(90, False)
    assert np.allclose(linear.poses(linear.POOL, [0, 90, 0], 90)[:20], q)
    half = np.full(7, 0.5)
    told = np.einsum("ncij,ij->nc", where.entries[:20], printed.TABLE_3 - printed.TABLE_2)
    told += sum(np.einsum("njc,j->nc", where.parts[kind][:20], half) for kind in ("torsion", "overturning"))
    told += where.parts["link"][:20].sum(axis=1)
    assert np.linalg.norm(told - seen, axis=1).mean() < 0.05 * np.linalg.norm(seen, axis=1).mean()


def test_an_arm_that_only_sags_gets_a_table_that_makes_its_error() -> None:
    sag = np.ones(7)
    only = linear.Wrong(np.zeros((7, 4)), sag, sag, np.zeros(7), np.zeros(7), np.zeros((7, 4)), 0.0, 5e-5)
    rng = np.random.default_rng(0)
    each = [linear.calibrated(linear.pool(90, False), only, 13, 12, rng) for _ in range(20)]
    before, table = (np.mean([stories.mean_mm(x) for x in part]) for part in (
        [e.before for e in each], [e.geometry for e in each]
    ))  # fmt: skip
    assert table == pytest.approx(before, rel=0.15)
    assert before > 10
    assert max(abs(e.table[0, linear.ALPHA]) for e in each) < np.radians(0.05)


def test_a_known_table_is_found() -> None:
    """Without sag, ratios and noise: circles give a and α, points d and θ as far as they decide."""
    table = printed.TABLE_3 - printed.TABLE_2
    only = linear.Wrong(
        table, np.zeros(7), np.zeros(7), np.zeros(7), np.zeros(7), np.zeros((7, 4)), 0.0, 1e-7
    )
    found = linear.calibrated(linear.pool(90, False), only, 13, 12, np.random.default_rng(1))
    assert stories.mean_mm(found.after) < 0.02
    assert found.table[:6, linear.THETA] == pytest.approx(table[:6, linear.THETA], abs=2e-4)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_claims_of_the_arms_hold_for_any_seed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    draws = [
        circular.arms({k: p.at(float(rng.random())) for k, p in circular.PRIORS.items()}, seed + 10 * i)
        for i in range(40)
    ]
    assert np.mean([d["share_sag"] > 0.8 for d in draws]) >= LEAST
    assert (
        np.mean([max(abs(d["alpha_1_sag"]), abs(d["alpha_1_free"])) < circular.HALF_ALPHA for d in draws])
        >= LEAST
    )


def test_compensation_once_leaves_the_second_order_and_a_wrong_stiffness_its_share() -> None:
    found = list(recursion.compensated(load_robot("longlink"), 0.4).values())
    known, less, links = found
    assert known[1] < 0.02 * known[0]
    assert known[2] < 0.1 * known[1]
    assert less[-1] == pytest.approx(recursion.MISSED * known[0], rel=0.1)
    assert links[-1] == pytest.approx(known[0], rel=0.05)  # links alone explain nothing


def test_the_path_is_met_by_the_rigid_arm() -> None:
    path = recursion.circle()
    q = recursion._joints(path, np.tile(recursion.START, (len(path), 1)))
    assert dh.chain(printed.TABLE_3, q)[:, -1, :3, 3] == pytest.approx(path, abs=1e-9)


@pytest.mark.slow
def test_tables_differ_by_the_printed_error_as_they_have_to(found: Study) -> None:
    n = found.numbers
    assert 24 < n["mean_90_mm"] < 27
    assert 28 < n["mean_45_mm"] < 31
    assert 29 < n["mean_30_mm"] < 32
    assert 20 < n["mean_120_mm"] < 22
    assert n["share_alpha_1"] > 0.4  # one twist
    assert n["share_lengths"] < 0.05
    assert 0.4 < n["above_floor_90"] < 0.8  # many poses are below it
    assert found.claims["circular"].stands
    assert found.claims["alpha_tells"].stands
    assert n["z_geometry"] < n["z_sag"]


@pytest.mark.slow
def test_links_of_the_printed_stiffness_bend_by_micrometres(found: Study) -> None:
    n = found.numbers
    assert 1e-3 < n["bending_own_mm"] < n["bending_loaded_mm"] < 0.1
    assert n["bending_eq21_mm"] < 0.1
    assert n["bending_loaded_mm"] < 0.01 * n["mean_90_mm"]
    assert n["sag_mm"] > 100 * n["bending_loaded_mm"]  # the joints as assumed
    assert 1 < n["link_7_um"] < 100
    shares = [n[f"sag_share_{s}_mm"] for s in (25, 50, 75, 100)]
    assert shares == sorted(shares)


@pytest.mark.slow
def test_every_account_is_judged_by_all_that_is_printed(found: Study) -> None:
    table = next(t for t in found.tables if t.title.startswith("What each account reproduces"))
    assert len(table.rows) == len(stories.OWN) == 7
    n = found.numbers
    assert sum(n[f"p_{name}"] for name in stories.OWN) == pytest.approx(1.0)
    assert n["p_sag"] < 0.01


@pytest.mark.slow
def test_circle_points_hold_the_truth(found: Study) -> None:
    n = found.numbers
    assert n["circle_hits"] >= 0.85 * n["circle_intervals"]
    assert n["half_a_mm"] < 0.3
    assert n["bias_a_mm"] > 3 * n["half_a_mm"]  # deflection has to be taken out


@pytest.mark.slow
def test_d_and_theta_are_identified(found: Study) -> None:
    n = found.numbers
    assert n["rank"] == 18  # of 20: not d₂ − d₃, not θ₇
    assert n["d_theta_hits"] >= 0.8 * n["d_theta_intervals"]
    assert n["d_theta_intervals"] == 12
    assert n["known_mean_mm"] < n["designed_mean_mm"] / 10
    assert n["rigid_mean_mm"] > 3 * n["known_mean_mm"]
    assert n["all_40_mean_mm"] < 0.15 < n["all_13_mean_mm"]


@pytest.mark.slow
def test_two_loads_show_what_unloaded_poses_do_not(found: Study) -> None:
    n = found.numbers
    assert n["detectable_two"] < n["detectable_more"] < n["detectable_one"]
    assert n["gain_two"] > 1.5  # against as many unloaded points
    for plan in ("one", "more", "two", "links"):
        shares = [n[f"{kind}_{plan}"] for kind in ("named", "among", "wrong", "nothing")]
        assert sum(shares) == pytest.approx(1.0)
    assert n["rigid_heldout_mm"] > 3 * n["noise_mean_mm"]


@pytest.mark.slow
def test_tables_and_files_are_complete(found: Study, folder: Path) -> None:
    assert len(found.figures) == 6
    for name in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (folder / name).stat().st_size > 500, name
    for link in found.files.values():
        assert (folder / link).exists()
    written = load_campaign(folder / "campaign" / "campaign.toml")
    assert len(written.poses.q) == 50
    stiffness = [joint.data.stiffness for joint in written.robot.joints]
    assert stiffness[1] == pytest.approx(2e5 / found.numbers["share"])
    written_numbers = json.loads((folder / "result.json").read_text())["numbers"]
    assert set(written_numbers) == {name for name, value in found.numbers.items() if np.isfinite(value)}


def test_sag_of_the_pool_is_the_deflection() -> None:
    """The parts of the pool's sag add up to what the arm moves by, to what its own sag adds."""
    q = linear.poses(20, [0, 90, 0], 90)
    whole = deflection(planned(linear.assumed(), q, targets=arm.ARM.targets[:1]))[:, 0]
    parts = sum(part[:20].sum(axis=1) for part in linear.pool(90, False).parts.values())
    assert np.linalg.norm(parts - whole, axis=1).max() < 0.03 * np.linalg.norm(whole, axis=1).max()


@pytest.mark.slow
def test_captions_stand_alone(found: Study) -> None:
    captions_stand_alone(found, "Seven-joint arm")


@pytest.mark.slow
def test_poses_are_counted_that_the_robot_could_stand_in(found: Study) -> None:
    poses_are_counted(found, 0.4)


def test_a_compensated_path_is_better_in_closed_loop_too() -> None:
    [(seconds, errors)] = driven.driven(load_robot("longlink"), 0.3, (driven.FAST,)).items()
    found = driven.driven_numbers({seconds: errors})
    statics = recursion.compensated(load_robot("longlink"), 0.3)["compliance known"]
    assert errors[0] == pytest.approx(statics[0], rel=0.02)
    assert found["driven_once_mm"] < 0.1 * found["driven_none_mm"]
    assert errors[2] > 10 * statics[2]  # inertia and lag, which no statics takes away
