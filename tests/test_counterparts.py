"""The question of each study on measured robots: here a UR10 and an iiwa 7 that Drake measured."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from workbench import Truth, load_campaign, planned, random_poses, simulate, write_campaign
from workbench.campaign import Campaign, Target
from workbench.campaign.problem import problem_of
from workbench.effects.records import parse_effect
from workbench.files.faults import InputError
from workbench.robot.description import load_robot
from workbench.studies import PUBLISHED, counterparts
from workbench.studies.counterparts import measured, own_yield
from workbench.studies.study_run import StudyRun

YIELDS = 2e-5  # rad/(N·m) of the UR10's shoulder lift
SOFTER = 7e-5  # of the iiwa's joint 2
HEAVIER = 1.4  # times the torque of the stated masses is what the iiwa's sensors read
TARGETS = [Target(f"P{k}", place) for k, place in enumerate([(0, 0, 0.1), (0.1, 0, 0.1), (0, 0.1, 0.1)])]


def _simulated(name: str, q: np.ndarray, said: list[str]) -> Campaign:
    plan = planned(load_robot(name), q, targets=TARGETS)
    return simulate(
        plan, Truth(effects=tuple(parse_effect(t, problem_of(plan)) for t in said), sigma=1e-5), seed=1
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A UR10 that yields with a wavy elbow, and an iiwa that sweeps two joints, yields and reads its torques;
    the files do not say what yields or errs."""
    out = tmp_path_factory.mktemp("measured")
    rng = np.random.default_rng(0)
    ur10 = [
        f"joint_compliance:joint=shoulder_lift_joint,compliance={YIELDS}",
        "joint_map:joint=elbow_joint,variant=waves,amplitude=4e-4",
    ]
    q = random_poses(load_robot("ur10"), 552, rng)
    q[:, 2] /= 2  # within the turn that its map has
    write_campaign(out / "ur10-ipa", _simulated("ur10", q, ur10))
    q = np.zeros((120, 7))
    q[:, :2] = rng.uniform(-1.4, 1.4, (120, 2))
    iiwa = _simulated("iiwa7", q, [f"joint_compliance:joint=joint_2,compliance={SOFTER}"])
    torque = HEAVIER * own_yield.torque(problem_of(iiwa))
    write_campaign(out / "iiwa7-payload0", iiwa.with_poses(torque=torque))
    return out


def table(folder: Path, name: str):
    return counterparts.counterpart(name, StudyRun(folder, measured=folder))


def number(cell: str) -> float:
    return float(cell.split(" ±")[0].replace("−", "-").replace("\u202f", ""))


def test_without_measurements_a_study_says_how_to_give_them() -> None:
    for name in PUBLISHED:
        found = counterparts.counterpart(name, StudyRun(Path()))
        assert found.rows[0][0] == "not asked"
        assert "--measured" in found.rows[0][1]


def test_a_folder_without_them_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds none of ur10-ipa"):
        table(tmp_path, "kr500")


def test_what_the_folder_lacks_is_said(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder / "iiwa7-payload0", tmp_path / "iiwa7-payload0")
    note = table(tmp_path, "longlink").note
    assert "Not in the folder: ur10-ipa, ur5-tracker, iiwa7-torque." in note


def test_a_compliance_is_found_in_both_halves_within_its_interval(folder: Path) -> None:
    """With the iiwa per newton metre that its sensors read, not per that of its masses."""
    first, second, *iiwa = table(folder, "cylindrical").rows
    for row, true in ((first, YIELDS), (second, YIELDS), *((row, SOFTER / HEAVIER) for row in iiwa)):
        assert abs(number(row[3]) - 1e6 * true) < 1.5 * number(row[5]) < 10
    assert number(first[4]) < number(first[5])
    assert iiwa[0][4] == "not stated"


def test_what_is_missing_gains_more_than_cells(folder: Path) -> None:
    ur10 = table(folder, "kr500").rows[0]
    alone, *cut, whole = map(number, ur10[2:7])
    assert whole < 0.4 * alone
    assert min(cut) > 0.6 * alone


def test_a_sweep_of_joints_by_themselves_tells_no_yield(folder: Path) -> None:
    """A torque that hangs on the joint's angle alone leaves it to a function of the angle."""
    found = table(folder, "rx170")
    ur10, iiwa = found.rows[:3], found.rows[3:]
    assert number(ur10[1][5]) < 0.5 * number(ur10[0][5])  # the elbow's waves
    assert number(iiwa[0][1].rstrip(" %")) < 1
    assert number(iiwa[2][4]) > 5 * number(iiwa[0][4])
    assert "where the free share is least (0 %)" in found.note


def test_a_table_of_geometry_holds_sag(folder: Path) -> None:
    found = table(folder, "longlink")
    assert "more than half in both in 2 of 2" in found.note


def test_six_ranges_of_a_joint_have_the_same_compliance_where_nothing_else_errs(folder: Path) -> None:
    *_, plain, mapped = table(folder, "kr120").rows
    for row in (plain, mapped):
        assert np.allclose([number(cell) for cell in row[3:9]], 1e6 * SOFTER / HEAVIER, rtol=0.1)
    assert number(plain[9].removeprefix("p = ")) > 0.001


def test_a_fit_without_poses_is_that_which_never_had_them(folder: Path) -> None:
    """One linear step from the fit to all poses, beside the fit to the rest alone."""
    campaign = load_campaign(folder / "ur10-ipa/campaign.toml")
    robot = measured.Measured(measured.CAMPAIGNS[0], problem_of(campaign))
    half = robot.halves(robot.fitted(robot.yields))[0]
    rest = measured.Measured(robot.known, problem_of(campaign.some(np.flatnonzero(~half.out))))
    alone = rest.estimate(rest.fitted(robot.yields))
    assert half.state.values[0][0] == pytest.approx(alone.value, abs=0.02 * alone.half)


def test_groups_left_out_give_the_error_of_a_mean() -> None:
    """The mean of groups of like size, for which the jackknife is the textbook's standard error."""
    groups = np.random.default_rng(2).normal(size=12)
    changes = np.array([np.delete(groups, k).mean() - groups.mean() for k in range(12)])
    std = groups.std(ddof=1) / np.sqrt(12)
    assert measured.jackknife(changes[:, None])[0, 0] == pytest.approx(std**2)
    assert measured.half_95(changes) == pytest.approx(2.201 * std, rel=1e-3)
