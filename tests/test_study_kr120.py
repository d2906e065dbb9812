"""The KR 120 study: Table I, the gas spring that it would need, the plan, and the deciding measurement."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from workbench.campaign import load_campaign
from workbench.report.study import Study
from workbench.robot.description import load_robot
from workbench.studies.kr120 import machines, printed
from workbench.studies.kr120 import study as kr120
from workbench.studies.running import run_script
from workbench.studies.study_run import StudyRun

STIFFNESSES = ("k21", "k22", "k23", "k24", "k25", "k26")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kr120")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    return run_script(kr120.study, StudyRun(folder, quick=True))


def test_gas_spring_alone_leaves_joint_2_as_it_is(found: Study) -> None:
    n = found.numbers
    assert 1e-3 < n["added_share"] < 3e-3  # physics: 0.5 to 5.3 kN·m/rad at 100 bar
    assert n["spread_exact"] < 0.01
    assert n["gas_six_p"] > 1e-3
    assert n["gas_one_chi2"] - n["gas_six_chi2"] < 16  # five stiffnesses more: p > 0.007
    for key in STIFFNESSES:
        assert abs(n[f"{key}_gas"] - n[f"{key}_exact"]) < 2 * n[f"{key}_gas_half"]


def test_wrist_and_elbow_lie_in_their_intervals(found: Study) -> None:
    truth = machines.true_compliances(load_robot("kr120"))
    off = {
        key: abs(found.numbers[f"{key}_gas"] - true) / found.numbers[f"{key}_gas_half"]
        for key, true in zip(printed.SPRING_NAMES, truth, strict=True)
    }
    assert max(off.values()) < 1.7  # of a 95 % half width, for eleven numbers
    assert sum(off[key] > 1 for key in ("k3", "k4", "k5", "k6")) <= 1


def test_intervals_are_like_the_printed_ones(found: Study) -> None:
    assert 0.5 < found.numbers["wider_than_printed"] < 2


def test_soft_gear_scatters_joint_2_more_than_noise_and_gas_spring(found: Study) -> None:
    n = found.numbers
    noise = max(n[f"{key}_soft_half"] / n[f"{key}_soft"] for key in STIFFNESSES)
    assert n["spread_soft"] > n["spread_gas"] + 2 * noise
    assert n["spread_soft_less_charged"] != pytest.approx(n["spread_soft"], rel=0.1)
    tile = next(tile for tile in found.tiles if "soft gear" in tile.label)
    assert f"{100 * n['spread_soft']:.0f}" in tile.after
    assert f"{100 * n['spread_soft']:.0f}" in found.headline


def test_residual_of_the_pairs_tells_a_soft_gear_from_six_stiffnesses(found: Study) -> None:
    n = found.numbers
    assert n["soft_six_p"] < 1e-6
    assert n["soft_soft_p"] > 1e-3
    assert n["soft_soft_dof"] > n["soft_six_dof"]


def test_table_1_needs_an_absurd_gas_spring(found: Study) -> None:
    n = found.numbers
    assert n["own_most_MN"] < 0.05
    assert n["table_1_least_MN"] > 1.0
    assert n["table_1_chi2"] > n["one_sigma_chi2"] > 20  # 3 dof
    assert n["any_order_p"] < 1e-4
    assert n["any_order_chi2"] < n["one_sigma_chi2"]


def test_optimum_plan_beats_all_random_ones(found: Study) -> None:
    n = found.numbers
    assert n["rho0_mm"] < n["rho0_best_mm"] < n["rho0_median_mm"]
    assert n["hanging_tells_k1"] == 0.0  # gravity makes no torque about an upright axis
    assert n["pulled"] == 6


def test_charge_lies_in_its_intervals_and_pairs_are_blind_to_it(found: Study) -> None:
    n = found.numbers
    for witness in ("points", "torque", "both"):
        assert abs(n[f"{witness}_charge"] - n["other_charge"]) < 2 * n[f"{witness}_charge_half"] < 0.03
        assert abs(n[f"{witness}_length"] - n["other_length"]) < 2 * n[f"{witness}_length_half"] < 0.2
        assert n[f"{witness}_charge_mass_half"] > 5 * n[f"{witness}_charge_half"]
    assert n["pairs_charge_half"] > 1.0  # more than the whole charge


def test_the_deciding_measurement_separates_soft_gear_and_leak(found: Study) -> None:
    verdicts = next(table for table in found.tables if table.title.startswith("Verdicts"))
    assert len(verdicts.rows) == 3
    for _, gas, soft, leak, apart in verdicts.rows:
        separate = (
            gas == "nothing missing"
            and "joint 2" in soft
            and "gravity compensator" not in soft
            and "gravity compensator" in leak
            and "joint 2" not in leak
        )
        assert apart == ("yes" if separate else "no")
    assert found.numbers["deciding"] == sum(row[-1] == "yes" for row in verdicts.rows) >= 1


def test_tables_and_files_are_complete(found: Study, folder: Path) -> None:
    assert [len(table.rows) for table in found.tables] == [11, 5, 3, 3, 3]
    assert len(found.figures) == 4
    for name in ("index.html", "report.pdf", "scene.html"):
        assert (folder / name).stat().st_size > 500, name
    assert set(json.loads((folder / "result.json").read_text())["numbers"]) == set(found.numbers)
    for link in found.files.values():
        assert (folder / link).exists()
    campaign = load_campaign(folder / "campaign" / "soft" / "campaign.toml")
    assert campaign.robot.compensator is not None
    stated = load_robot("kr120").compensator
    assert stated is not None
    assert campaign.robot.compensator.piston_area == stated.piston_area
