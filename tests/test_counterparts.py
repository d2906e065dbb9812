"""The question of each study on a measured robot: here a UR10 that Drake measured, its faults known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from workbench import Truth, planned, random_poses, simulate, write_campaign
from workbench.campaign import Target
from workbench.campaign.problem import problem_of
from workbench.effects.records import parse_effect
from workbench.files.faults import InputError
from workbench.robot.description import load_robot
from workbench.studies import PUBLISHED, counterparts
from workbench.studies.study_run import StudyRun

YIELDS = 2e-5  # rad/(N·m) of the shoulder lift


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign with the true robot's yield and a wavy elbow, both of which its file does not tell."""
    out = tmp_path_factory.mktemp("measured")
    robot = load_robot("ur10")
    q = random_poses(robot, 4 * counterparts.BLOCK, np.random.default_rng(0))
    targets = [Target(f"P{k}", place) for k, place in enumerate([(0, 0, 0.1), (0.1, 0, 0.1), (0, 0.1, 0.1)])]
    plan = planned(robot, q, targets=targets)
    said = [
        f"joint_compliance:joint=shoulder_lift_joint,compliance={YIELDS}",
        "joint_map:joint=elbow_joint,variant=waves,amplitude=4e-4",
    ]
    truth = Truth(effects=tuple(parse_effect(text, problem_of(plan)) for text in said), sigma=1e-5)
    write_campaign(out / counterparts.CAMPAIGN, simulate(plan, truth, seed=1))
    return out


def table(folder: Path, name: str):
    return counterparts.counterpart(name, StudyRun(folder, measured=folder))


def test_without_measurements_a_study_says_how_to_give_them() -> None:
    for name in PUBLISHED:
        found = counterparts.counterpart(name, StudyRun(Path()))
        assert found.rows[0][0] == "not asked"
        assert "--measured" in found.rows[0][1]


def test_a_folder_without_them_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not there"):
        table(tmp_path, "kr500")


def test_a_compliance_is_found_in_both_halves(folder: Path) -> None:
    for row in table(folder, "cylindrical").rows:
        assert abs(float(row[2]) - 1e6 * YIELDS) < 3 * float(row[4]) < 6


def test_what_is_missing_gains_more_than_cells(folder: Path) -> None:
    rows = table(folder, "kr500").rows
    alone, *cut, whole = (float(row[2]) for row in rows)
    assert whole < 0.3 * alone
    assert min(cut) > 0.6 * alone


def test_a_function_of_its_own_widens_the_yield(folder: Path) -> None:
    _, simple, others, own = table(folder, "rx170").rows
    assert float(others[1]) < 0.5 * float(simple[1])  # the elbow's waves
    assert float(own[3]) > float(others[3])


def test_a_table_of_geometry_holds_sag(folder: Path) -> None:
    found = table(folder, "longlink")
    assert "holds sag" in found.note
    assert any(
        "shoulder lift" in row[0] and abs(float(row[1].split()[0].replace("−", "-"))) > 0.5
        for row in found.rows
    )


def test_six_ranges_of_a_joint_each_have_a_compliance(folder: Path) -> None:
    rows = table(folder, "kr120").rows
    assert len(rows) == counterparts.GROUPS
    assert (
        np.median([abs(float(row[2].replace("−", "-")) - 1e6 * YIELDS) / float(row[3]) for row in rows]) < 2
    )
