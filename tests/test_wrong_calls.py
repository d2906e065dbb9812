"""Calls and tables that no robot can be told: refused by name before anything is written."""

from pathlib import Path

import numpy as np
import pytest

from workbench import load_robot
from workbench.cli.main import main
from workbench.cli.told import beyond_limits

HEAD = "pose_id," + ",".join(f"q{j}_deg" for j in range(1, 7))
ROWS = ["a,10,-60,60,5,40,20", "b,20,-50,50,5,30,20"]
ROOT = Path(__file__).resolve().parents[1]
MODEL = ROOT / "reports" / "example" / "model.toml"


def wrong(capsys, *call):
    """What a call that is refused says; options and inputs alike end with 2."""
    try:
        status = main([str(word) for word in call])
    except SystemExit as end:
        status = end.code
    assert status == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--sigma-mm", "-1", "no length of zero or more"),
        ("--sigma-mm", "nan", "no length of zero or more"),
        ("--sigma-mm", "1e300", "too large"),
        ("--geometry-mm", "inf", "no length of zero or more"),
        ("--geometry-mrad", "nan", "no angle of zero or more"),
        ("--hours", "-1", "no time of zero or more"),
        ("--warm-degC", "1e6", "too large"),
        ("--shots", "1000000000", "too many"),
        ("--random", "1000000000", "give a number of poses, 1000000 at most"),
        ("--effect", "joint_compliance:joint=joint_2,relative=-5", "relative = -5 cannot be; between -1 and"),
        ("--effect", "gear_eccentricity:joint=joint_3,sin=50", "sin = 50 cannot be"),
        ("--effect", "gear_kinematic_error:joint=joint_2,order=-3", "order is -3"),
    ],
)
def test_sizes_that_cannot_be_are_not_simulated(tmp_path, capsys, option, value, said):
    out = tmp_path / "out"
    call = ["simulate", "kr500", "--random", "3", f"{option}={value}", "--out", out]
    assert said in wrong(capsys, *call)
    assert not out.exists()


@pytest.mark.parametrize(
    ("grid", "said"),
    [
        ("joint_2=-60:20:0", "is no JOINT=FROM:TO:COUNT"),
        ("joint_2=nan:20:9", "is no JOINT=FROM:TO:COUNT"),
        ("joint_2=0:10:100000000000", "more than 1000000 poses"),
        ("joint_1=0:1:2000,joint_2=0:1:2000", "more than 1000000 poses"),
        ("joint_2=-60:20:9,joint_2=0:1:2", "joint_2 is there twice"),
    ],
)
def test_grids_without_poses_or_with_too_many(tmp_path, capsys, grid, said):
    assert said in wrong(capsys, "simulate", "kr500", "--grid", grid, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", [["simulate", "kr500"], ["plan", "kr500", "--quick"]])
def test_a_load_has_one_mass(tmp_path, capsys, command):
    count = "--random" if command[0] == "simulate" else "--poses"
    call = [*command, count, "3", "--payload", "heavy=250", "--payload", "heavy=100", "--out", tmp_path / "o"]
    assert "'heavy' is given twice" in wrong(capsys, *call)


@pytest.mark.parametrize("command", ["simulate", "predict"])
@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([HEAD, ROWS[0], ROWS[0]], "pose_id 'a' twice, lines 2 and 3"),
        ([HEAD + ",q7_deg", *(row + ",5" for row in ROWS)], "column 'q7_deg', but kr500 has 6 joints"),
        ([HEAD + ",dir1", *(row + ",2" for row in ROWS)], "line 2: dir1 is not a sign"),
        (
            [HEAD.replace("q1_deg", "q1_rad"), "a,1e300,-60,60,5,40,20"],
            "are these degrees? then name it q1_deg",
        ),
        ([HEAD.replace(",q6_deg", ""), "a,10,-60,60,5,40"], "no column q6_deg"),
    ],
)
def test_a_table_of_poses_is_read_as_strictly_as_a_campaigns(tmp_path, capsys, command, rows, said):
    (tmp_path / "poses.csv").write_text("\n".join(rows))
    robot = MODEL if command == "predict" else "kr500"
    told = wrong(capsys, command, robot, "--poses", tmp_path / "poses.csv", "--out", tmp_path / "out")
    assert said in told
    assert not (tmp_path / "out").exists()


def test_simulated_poses_beyond_the_limits_are_told(tmp_path, capsys):
    """Degrees in a column of radians: everything turns too far."""
    robot = load_robot("kr500")
    q = np.zeros((4, 6))
    q[1:, 1] = 40.0
    assert beyond_limits(robot, q) == ["beyond the limits of joint_2 (at 3 of 4 poses): are these its units?"]
    assert main(["simulate", "kr500", "--grid", "joint_2=-60:60:3", "--out", str(tmp_path / "o")]) == 0
    assert "warning: beyond the limits of joint_2 (at 1 of 3 poses)" in capsys.readouterr().err


def test_the_campaign_of_a_robot_with_the_same_names_of_joints_is_another_robots(tmp_path, capsys):
    assert load_robot("kr120").joint_names == load_robot("kr500").joint_names
    assert main(["simulate", "kr120", "--random", "3", "--out", str(tmp_path / "c")]) == 0
    campaign = tmp_path / "c" / "campaign.toml"
    said = "is of kr120, which is not the robot of"
    assert said in wrong(capsys, "predict", MODEL, "--poses", campaign, "--out", tmp_path / "out")
    path = tmp_path / "path.csv"
    path.write_text(f"t_s,{HEAD.removeprefix('pose_id,')}\n0,10,-60,60,5,40,20\n1,11,-60,60,5,40,20\n")
    call = ["compensate", path, "--model", MODEL, "--campaign", campaign, "--out", tmp_path / "out.csv"]
    assert said in wrong(capsys, *call)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["c", "path.csv"]


@pytest.mark.parametrize("option", ["--tool", "--base"])
def test_a_frame_is_in_millimetres_and_not_in_the_next_country(capsys, option):
    call = ["compensate", "path.csv", "--model", "kr500", option, "9e9,0,0"]
    assert "'9e9,0,0' is more than 1 km away" in wrong(capsys, *call)


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("[instrument]\nxyz_mm = [9e9, 0, 0]", "instrument.xyz_mm.0"),
        ("[driving]\nfloor_mm = -9e9", "driving.floor_mm"),
        ('[[obstacles]]\nname = "b"\nbox_mm = [1e9, 1, 1]', "obstacles.0.box_mm.0"),
        ("[driving]\nreflector_s = 1e15", "driving.reflector_s"),
    ],
)
def test_a_cell_is_no_larger_than_a_kilometre(tmp_path, capsys, cell, said):
    (tmp_path / "cell.toml").write_text(f"schema = 1\n{cell}\n")
    call = ["plan", "kr500", "--poses", "3", "--cell", tmp_path / "cell.toml", "--out", tmp_path / "out"]
    assert said in wrong(capsys, *call)


@pytest.mark.parametrize("name", ["a/b", "..", "", "my robot"])
def test_a_robots_name_names_files(tmp_path, capsys, name):
    urdf = ROOT / "models" / "kr500" / "kr500.urdf"
    assert "--name" in wrong(capsys, "init", urdf, "--name", name, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_floor_above_the_robot_is_told(tmp_path, capsys):
    """It is checked by nobody where everything lies below it: 5 m for 5 dm, say."""
    (tmp_path / "cell.toml").write_text("schema = 1\n[driving]\nfloor_mm = 5000\n")
    call = [
        "plan",
        "kr500",
        "--quick",
        "--poses",
        "3",
        "--cell",
        tmp_path / "cell.toml",
        "--out",
        tmp_path / "o",
    ]
    assert main([str(word) for word in call]) == 0
    assert "warning: floor and link_3 touch in nearly all poses" in capsys.readouterr().err
