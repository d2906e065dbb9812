"""Plans for a time, and the smallest campaign that settles what a diagnosis left open."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from program_paths import read_program

from workbench import Truth, load_robot, plan, planned, random_poses, simulate
from workbench.campaign.cell import CellData, DrivingData
from workbench.cli.main import main
from workbench.files.faults import InputError
from workbench.measurement.design.candidates import Factors, candidates
from workbench.measurement.design.prior_information import from_robot
from workbench.robot.schema import LoadData

HEAVY = {"heavy": LoadData(mass_kg=2.0)}
SLOW = CellData(driving=DrivingData(speed_share=0.03, reflector_s=0.0))


@pytest.fixture(scope="module")
def loaded():
    return replace(load_robot("cylindrical"), payloads=HEAVY)


def test_a_plan_keeps_to_its_time():
    """A slow robot stops on its way, and this is worth more than its best poses alone."""
    made = plan(replace(load_robot("irb120"), payloads=HEAVY), minutes=4, cell=SLOW, quick=True)
    assert 3.4 < made.drive.total_s / 60 < 4.3
    assert made.stops > 0
    assert made.over_poses > 1.2
    assert made.gain > 1.2
    facts = made.to_json()
    assert facts["stops_on_the_way"] == made.stops
    assert facts["information_per_hour_over_random"] == made.gain


def test_a_target_that_takes_too_long_is_left_out(tmp_path, capsys):
    """Reflectors that are moved by hand: what is measured, and for how long, stands in what is written."""
    (tmp_path / "cell.toml").write_text("schema = 1\n[driving]\nreflector_s = 60\n")
    call = ["plan", "irb120", "--minutes", "5", "--quick", "--format", "krl", "--json"]
    assert main([*call, "--cell", str(tmp_path / "cell.toml"), "--out", str(tmp_path)]) == 0
    facts = json.loads(capsys.readouterr().out)
    measured, left_out = facts["drive"]["targets"], facts["targets_left_out"]
    assert sorted([*measured, *left_out]) == ["T1", "T2", "T3"]
    assert left_out
    still = 4 + 60 * (len(measured) - 1)
    assert facts["drive"]["standstill_s"] == still
    records = sum(block["standstills"] for block in facts["drive"]["blocks"])
    assert facts["drive"]["standing_minutes"] == pytest.approx(records * still / 60)
    said = f"At every standstill, {still} s, measure {', '.join(measured)}."
    page, campaign, program = (
        (tmp_path / name).read_text() for name in ("index.html", "campaign.toml", "measure.src")
    )
    assert said in page
    assert f"Leave out {', '.join(left_out)}" in page
    assert said in campaign
    assert sorted(tomllib.loads(campaign)["targets"]) == measured
    assert f"; {said}" in program
    assert f"WAIT SEC {still}" in program


def test_a_further_reflector_takes_its_seconds(loaded):
    """By hand or by a tracker that turns: the same poses take longer, the information is the same."""
    quick, slow = (
        plan(loaded, 8, cell=CellData(driving=DrivingData(reflector_s=s)), quick=True) for s in (0.0, 30.0)
    )
    count = len(quick.drive.records.poses)
    assert slow.drive.standing_s - quick.drive.standing_s == pytest.approx(count * 2 * 30.0)
    assert slow.plan_mm == pytest.approx(quick.plan_mm)


def test_a_load_that_takes_too_long_to_mount_stays_away(loaded):
    driving = DrivingData(load_change_min=300.0)
    made = plan(loaded, minutes=8, cell=CellData(driving=driving))
    assert len(made.drive.blocks) == 1
    assert made.drive.pauses_s == 0


def test_an_arm_is_worked_warm_where_there_is_time_for_it():
    def made(wait):
        cell = CellData(driving=DrivingData(warm_up_min=wait))
        told = "thermal_growth,gear_ratio:joint=joint_2"
        return plan(load_robot("cylindrical"), tell=told, minutes=4, cell=cell, quick=True)

    quick = made(0.5)
    assert quick.drive.total_s < 4.4 * 60
    assert set(quick.records.poses.temperature) == {20.0, 30.0}
    assert quick.least > 10
    with pytest.raises(InputError, match="4 min are too short for poses warm and cold"):
        made(300.0)


def test_a_time_that_is_too_short_is_refused(loaded):
    with pytest.raises(InputError, match="are too short for"):
        plan(loaded, minutes=0.2, cell=SLOW)


def test_pulls_are_on_offer_where_they_can_be_rigged():
    prior = from_robot(load_robot("kr500"))
    offered = candidates(prior, 80, Factors(pull=500.0), np.random.default_rng(0))
    pulled = offered.poses.wrench[:, 1] == 500.0
    assert pulled.mean() == 0.5
    assert not np.delete(offered.poses.wrench, 1, axis=1).any()
    pull = CellData(driving=DrivingData(pull_N=500.0))
    told = "joint_compliance:joint=joint_1,gear_eccentricity:joint=joint_1"
    made = plan(load_robot("kr500"), 10, tell=told, cell=pull, quick=True)
    assert (made.records.poses.wrench[:, 1] == 500.0).any()
    assert made.drive.pauses_s >= 300


def ambiguous(folder: Path, relative: float) -> Path:
    cause = {
        "cause": "gear_ratio",
        "joint": "joint_1",
        "status": "ambiguous",
        "parameters": [{"name": "relative", "value": relative, "std": 1e-6, "unit": "1"}],
        "rivals": [{"cause": "bearing_tilt", "joint": "joint_1", "probability": 0.4}],
    }
    path = folder / "result.json"
    path.write_text(json.dumps({"schema": 1, "causes": [cause]}))
    return path


@pytest.fixture(scope="module")
def measured():
    robot = load_robot("cylindrical")
    q = random_poses(robot, 20, np.random.default_rng(4))
    return replace(simulate(planned(robot, q), Truth(sigma=3e-5), seed=4), noise_sigma=3e-5)


def test_the_smallest_campaign_that_settles_a_result(tmp_path, measured):
    small = plan(measured, tell=str(ambiguous(tmp_path, 5e-5)), quick=True)
    assert small.least >= 40
    assert small.needed <= len(small.records.poses) < 60
    assert "the size that was found" in small.text
    large = plan(measured, tell=str(ambiguous(tmp_path, 3e-3)), quick=True)
    assert large.least >= 40
    assert len(large.records.poses) <= len(small.records.poses)
    fewer = plan(measured, len(small.records.poses) // 2, tell=str(ambiguous(tmp_path, 5e-5)), quick=True)
    assert fewer.least < small.least


def test_a_size_that_no_cause_has_is_remarked_on_and_one_without_effect_refused(measured):
    odd = plan(measured, 8, tell="gear_ratio:joint=joint_1,relative=5,bearing_tilt:joint=joint_1", quick=True)
    assert "is said to be 1e+05 times its usual size" in odd.text
    with pytest.raises(InputError, match=r"link_mass.*cannot show in this model"):
        plan(measured, 8, tell="gear_ratio:joint=joint_1,relative=3e-4,link_mass:link=link_1", quick=True)


def test_a_cause_is_told_in_the_size_that_was_found(tmp_path, measured):
    """As the commands of a diagnosis say it: the same plan as for its result.json."""
    found = json.loads(ambiguous(tmp_path, 3e-4).read_text())["causes"][0]
    said = ",".join(f"{p['name']}={p['value']}" for p in found["parameters"])
    first = f"{found['cause']}:joint={found['joint']},{said}"
    others = [f"{r['cause']}:joint={r['joint']}" for r in found["rivals"]]
    made = plan(measured, tell=",".join([first, *others]), quick=True)
    same = plan(measured, tell=str(tmp_path / "result.json"), quick=True)
    assert made.least == pytest.approx(same.least, rel=1e-6)
    assert made.count == same.count
    with pytest.raises(InputError, match="names one cause, not two"):
        plan(measured, tell=first, quick=True)


def test_poses_and_minutes_are_two_limits(tmp_path, capsys):
    assert main(["plan", "irb120", "--poses", "5", "--minutes", "5", "--out", str(tmp_path / "plan")]) == 2
    assert "--poses, --minutes: are two limits" in capsys.readouterr().err


def test_the_result_of_another_robot_is_refused(tmp_path, measured):
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"schema": 1, "robot": "somebody's", "causes": []}))
    with pytest.raises(InputError, match="is of somebody's, the campaign of "):
        plan(measured, tell=str(path), quick=True)


def test_a_result_that_leaves_nothing_open_is_refused(tmp_path, measured):
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"schema": 1, "causes": []}))
    with pytest.raises(InputError, match="leaves no cause ambiguous"):
        plan(measured, tell=str(path), quick=True)
    with pytest.raises(InputError, match="needs the campaign that was diagnosed"):
        plan(measured.robot, tell=str(path), quick=True)
    path.write_text("[]")
    with pytest.raises(InputError, match=r"is no result.json of a diagnosis"):
        plan(measured, tell=str(path), quick=True)


def test_every_block_has_a_val3_application_of_its_own(tmp_path):
    """Their programs have the same file names: in one folder the last would drive the others' points."""
    call = ["plan", "rx170", "--payload", "heavy=20:0,0,100", "--poses", "15", "--quick", "--format", "val3"]
    call += ["--tell", "joint_compliance:joint=joint_3,link_mass:link=link_3"]
    main([*call, "--out", str(tmp_path)])
    applications = sorted(tmp_path.glob("*/*.pjx"))
    assert len(applications) == 2  # without and with the load
    for application in applications:
        assert {file.name for file in application.parent.glob("*.pgx")} == {"start.pgx", "stop.pgx"}
        assert "load" in (application.parent / "start.pgx").read_text()
    still = [int((read_program(application, "val3").dwell > 0).sum()) for application in applications]
    poses = (tmp_path / "poses.csv").read_text().splitlines()[1:]
    assert sorted(still) == sorted([sum("heavy" in p for p in poses), sum("heavy" not in p for p in poses)])


def test_what_was_found_is_settled_in_a_time(tmp_path, measured):
    """A result.json with several ties, as `--poses` takes it; more time settles more."""
    ratio = json.loads(ambiguous(tmp_path, 5e-5).read_text())["causes"][0]
    other = ratio | {"joint": "joint_2", "rivals": [{"cause": "tracker_scale", "probability": 0.3}]}
    told = tmp_path / "two.json"
    told.write_text(json.dumps({"schema": 1, "causes": [ratio, other]}))
    short, long = (plan(measured, tell=str(told), minutes=minutes) for minutes in (2, 6))
    assert 1.5 < short.drive.total_s / 60 < 2.2
    assert 5 < long.drive.total_s / 60 < 6.4
    assert short.count < long.count
    assert 0 < short.worth[0] <= long.worth[0]
    assert long.settles
    assert "This plan is expected to settle it." in long.text


def test_a_cause_with_its_size_is_settled_in_a_time(tmp_path, measured):
    """As in `--poses`: of as many poses the same λ now, and as many are said to settle it."""
    said = "gear_ratio:joint=joint_1,relative=5e-5,bearing_tilt:joint=joint_1,probability=0.4"
    timed = plan(measured, tell=said, minutes=3)
    same = plan(measured, len(timed.records.poses), tell=said, quick=True)
    assert timed.found
    assert timed.drive.total_s / 60 < 3.3
    assert timed.hardest[0].now == pytest.approx(same.hardest[0].now, rel=1e-6)
    assert timed.needed == pytest.approx(same.needed, rel=0.5)


def test_a_rival_that_nothing_would_show_leaves_no_tie(tmp_path, measured):
    """A vertical column: no load bends its sliding joint, so that its compliance is no rival of anything."""
    causes = json.loads(ambiguous(tmp_path, 5e-5).read_text())["causes"]
    hidden = causes[0] | {"rivals": [{"cause": "link_mass", "link": "link_1", "probability": 0.4}]}
    told = tmp_path / "hidden.json"
    told.write_text(json.dumps({"schema": 1, "causes": [hidden]}))
    with pytest.raises(InputError, match=r"link_mass.*cannot show in this model"):
        plan(measured, tell=str(told), quick=True)
