"""The command line: what it writes, what it prints, and what it says when the input is wrong."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_cli_options import COMMANDS

from workbench.campaign import load_campaign
from workbench.campaign.own_weight import too_weak
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.write import write_campaign
from workbench.cli.main import main
from workbench.effects import catalogue
from workbench.identification.model_file import write_model
from workbench.robot.description import load_robot
from workbench.robot.schema import GEOMETRY
from workbench.simulation.virtual_campaign import Truth, simulate

ROOT = Path(__file__).resolve().parents[1]
EFFECTS = [
    "--effect", "gear_kinematic_error:joint=joint_4,order=200,amplitude=2e-4,phase=0.6",
    "--effect", "backlash:joint=joint_5,half_width=1e-4",
]  # fmt: skip
DESIGN = ["--random", "40", "--payload", "heavy=250:0,0,150", "--tool", "60:0,0,80", "--approach"]
FILES = {"result.json", "index.html", "report.pdf", "scene.html", "residuals.csv", "model.toml", "urdf"}
KEYS = {
    "schema", "robot", "campaign", "n_poses", "n_points", "noise", "stages", "test", "verdict", "causes",
    "remainder", "not_testable", "detectable", "faults",
}  # fmt: skip
STAGE = {"name", "parameters", "heldout_rms_mm", "heldout_mean_mm", "heldout_max_mm", "fit_rms_mm"}
CAUSE = {"cause", "status", "gain_mm", "probability", "parameters", "rivals", "separate_by"}
PLACE = {"joint", "other", "link", "payload", "order"}


def call(capsys, *arguments):
    """Exit status, standard output, standard error."""
    capsys.readouterr()
    status = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return status, out, err


def faults(capsys, *arguments):
    """The fault lines of a call that must be refused."""
    status, out, err = call(capsys, *arguments)
    lines = err.splitlines()
    assert status == 2, err
    assert out == ""
    assert all(line.startswith(("error: ", "warning: ", "… ")) for line in lines), err
    return [line.removeprefix("error: ") for line in lines if line.startswith("error: ")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A simulated campaign and its diagnosis."""
    folder = tmp_path_factory.mktemp("loop")
    assert main(["simulate", "kr500", *DESIGN, *EFFECTS, "--out", str(folder / "one")]) == 0
    assert main(["diagnose", str(folder / "one/campaign.toml"), "--out", str(folder / "found")]) == 0
    return folder


def edited(folder, tmp_path, name, old, new, count=-1):
    """The campaign in a folder of its own, with one of its files changed."""
    for file in ("campaign.toml", "poses.csv", "points.csv"):
        text = (folder / "one" / file).read_text(encoding="utf-8")
        if file == name:
            assert old in text
            text = text.replace(old, new, count)
        (tmp_path / file).write_text(text, encoding="utf-8")
    return tmp_path / "campaign.toml"


# ---------------------------------------------------------------- lists


def test_robots(capsys):
    status, out, _ = call(capsys, "robots")
    assert status == 0
    names = [line.split()[0] for line in out.splitlines()]
    assert names == sorted(names)
    assert "kr500" in names
    listed = json.loads(call(capsys, "robots", "--json")[1])
    assert {k: v for k, v in listed[-1].items() if k != "title"} == {"name": "ur5", "joints": 6}
    assert len(listed) == len(out.splitlines())


def test_causes(capsys):
    status, out, _ = call(capsys, "causes")
    assert status == 0
    names = [line.split()[0] for line in out.splitlines()]
    assert names == [*catalogue(), "geometry", "unknown"]
    assert any("half_width [rad]" in line for line in out.splitlines())
    listed = {item["cause"]: item for item in json.loads(call(capsys, "causes", "--json")[1])}
    assert list(listed) == names
    assert listed["geometry"]["parameters"] == []
    assert listed["backlash"]["parameters"] == [{"name": "half_width", "unit": "rad"}]
    assert listed["backlash"]["sits_at"] == "joint"


# ---------------------------------------------------------------- the loop


def test_simulated_campaign_loads(folder):
    campaign = load_campaign(folder / "one/campaign.toml")
    assert (campaign.n_poses, campaign.n_points) == (80, 240)
    assert campaign.payload_names == ("", "heavy")
    assert campaign.tool_mass == 60.0
    assert campaign.poses.side is not None
    assert campaign.noise_sigma == pytest.approx(3e-5)
    assert "# hidden: backlash:joint=joint_5," in (folder / "one/campaign.toml").read_text()


def test_diagnose_writes_everything(folder):
    written = {path.name: path.stat().st_size for path in (folder / "found").iterdir()}
    assert set(written) == FILES
    assert min(written.values()) > 1000
    assert (folder / "found/report.pdf").read_bytes().startswith(b"%PDF")


def test_result_has_the_keys_of_its_schema(folder):
    result = json.loads((folder / "found/result.json").read_text(encoding="utf-8"))
    assert set(result) >= KEYS
    assert result["schema"] == 1
    assert (result["robot"], result["n_poses"], result["n_points"]) == ("kr500", 80, 240)
    assert result["noise"] == {"sigma_mm": pytest.approx(0.03), "source": "stated"}
    assert [stage["name"] for stage in result["stages"]][:2] == ["nominal", "geometry"]
    assert all(set(stage) - {"note"} == STAGE for stage in result["stages"])
    assert result["stages"][0]["parameters"] == 0
    assert result["test"] is None
    assert result["verdict"] == "named"
    assert {(c["cause"], c["joint"]) for c in result["causes"]} == {
        ("gear_kinematic_error", "joint_4"),
        ("backlash", "joint_5"),
    }
    for cause in result["causes"]:
        assert set(cause) - PLACE == CAUSE
        assert all(set(p) == {"name", "value", "std", "unit"} for p in cause["parameters"])
    assert set(result["remainder"]) == {"chi2", "dof", "p_value"}
    assert all({"cause", "why"} <= set(item) <= {"cause", "why", *PLACE} for item in result["not_testable"])
    size = {"cause", "size", "unit"}
    assert all(size <= set(item) <= {*size, *PLACE} for item in result["detectable"])
    assert result["faults"] == []


def test_json_is_alone_on_standard_output(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = call(capsys, "diagnose", folder / "one/campaign.toml", "--json")
    assert status == 0
    assert json.loads(out) == json.loads((folder / "found/result.json").read_text(encoding="utf-8"))
    assert out.count("\n") == 1
    assert "…" in err
    assert list(tmp_path.iterdir()) == []
    facts = call(capsys, "simulate", "ur5", "--random", 3, "--out", tmp_path / "ur5", "--json")[1]
    assert json.loads(facts) == {"robot": "ur5", "n_poses": 3, "folder": str(tmp_path / "ur5")}


def test_the_verdict_on_a_terminal(folder, capsys, tmp_path):
    status, out, _ = call(
        capsys, "diagnose", folder / "one/campaign.toml", "--out", tmp_path / "new" / "folder"
    )
    assert status == 0
    assert "NAMED       gear_kinematic_error (joint_4 at 200 cycles per turn)" in out
    assert f"{tmp_path}/new/folder/index.html" in out
    assert {path.name for path in (tmp_path / "new/folder").iterdir()} == FILES
    assert len(out.splitlines()) < 25


def test_several_campaigns_are_one(tmp_path, capsys):
    for seed in (1, 2):
        made = ("simulate", "cylindrical", "--random", 15)
        assert call(capsys, *made, "--seed", seed, "--out", tmp_path / str(seed))[0] == 0
    status, out, _ = call(
        capsys, "diagnose", tmp_path / "1/campaign.toml", tmp_path / "2/campaign.toml", "--json"
    )
    assert status == 0
    assert json.loads(out)["n_poses"] == 30


def test_a_test_campaign_is_only_judged(folder, capsys):
    status, out, _ = call(
        capsys, "diagnose", folder / "one/campaign.toml", "--test", folder / "one/campaign.toml", "--json"
    )
    assert status == 0
    result = json.loads(out)
    assert result["n_poses"] == 80
    assert set(result["test"]) >= {
        "campaign",
        "before_mean_mm",
        "after_mean_mm",
        "after_rms_mm",
        "after_max_mm",
    }
    assert result["test"]["after_mean_mm"] < 0.06 < result["test"]["before_mean_mm"]


def test_model_is_a_robot_again(folder, tmp_path, capsys):
    model = folder / "found/model.toml"
    robot = load_robot(model)
    assert {item.cause for item in robot.effects} == {"gear_kinematic_error", "backlash"}
    first, *others = robot.joint_names
    assert first not in robot.geometry  # that is where the base is
    corrections = [[robot.geometry[name][key] for key in GEOMETRY] for name in others]
    geometry = np.array([[0.0] * 6, [0.0] * 6, *corrections, [0.0] * 6])  # base, first joint, ..., flange
    write_model(folder / "found/again.toml", robot, geometry, robot.effects)
    assert (folder / "found/again.toml").read_bytes() == model.read_bytes()
    (folder / "found/again.toml").unlink()
    # what the model knows is not found again, and what it predicts is what was measured
    text = (folder / "one/campaign.toml").read_text().replace('"kr500"', f'"{model}"')
    (folder / "one/known.toml").write_text(text)
    status, out, _ = call(capsys, "diagnose", folder / "one/known.toml", "--json")
    assert status == 0
    again = json.loads(out)
    assert again["verdict"] == "nothing_missing"
    assert again["stages"][0]["fit_rms_mm"] < 0.06
    status, *_ = call(
        capsys, "simulate", model, "--random", 5, "--payload", "heavy", "--out", tmp_path / "simulated"
    )
    assert status == 0
    simulated = load_campaign(tmp_path / "simulated/campaign.toml")
    assert simulated.robot.effects == robot.effects
    assert (simulated.tool_mass, simulated.load_mass.tolist()) == (60.0, [0.0, 250.0])


# ---------------------------------------------------------------- paths


@pytest.fixture
def path(tmp_path):
    rows = [f"{0.1 * i:.1f},{0.2 * i - 5},-70,90,5,45,0" for i in range(30)]
    file = tmp_path / "path.csv"
    file.write_text("\n".join(["t_s," + ",".join(f"q{j}_deg" for j in range(1, 7)), *rows, ""]))
    return file


def test_compensate_writes_a_program(folder, path, capsys):
    model = folder / "found/model.toml"
    status, out, err = call(capsys, "compensate", path, "--model", model, "--format", "krl")
    assert status == 0
    assert "30 samples, 2.9 s: the model expects" in out
    assert "the model knows heavy (--payload NAME)" in err
    (program,) = path.parent.glob("*.src")
    assert str(program) in out
    assert "LIN" in program.read_text()
    target = path.parent / "out.csv"
    status, out, err = call(
        capsys, "compensate", path, "--model", model, "--payload", "heavy", "--out", target, "--json"
    )
    assert (status, err) == (0, "")
    heavy = json.loads(out)
    assert heavy["files"] == [str(target)]
    assert heavy["after_max_mm"] < 1e-3 < 1.0 < heavy["before_rms_mm"]
    assert {"samples", "left_out", "troubles", "notes", "rounding"} <= set(heavy)
    same = call(
        capsys, "compensate", path, "--model", model, "--payload", "heavy", "--out", target, "--json",
        "--campaign", folder / "one/campaign.toml",
    )  # fmt: skip
    assert json.loads(same[1])["before_rms_mm"] == pytest.approx(heavy["before_rms_mm"], rel=1e-12)


def test_compensate_refuses_and_writes_nothing(folder, path, capsys):
    model = folder / "found/model.toml"
    before = sorted(path.parent.iterdir())
    (fault,) = faults(capsys, "compensate", path, "--model", model, "--payload", "light")
    assert "known: heavy" in fault
    (fault,) = faults(capsys, "compensate", path.with_name("no.csv"), "--model", model)
    assert "no.csv: no such file" in fault
    (fault,) = faults(capsys, "compensate", path, "--model", path.with_name("no.toml"))
    assert "no.toml" in fault
    path.write_text(path.read_text().replace(",90,", ",390,"))
    assert faults(capsys, "compensate", path, "--model", model)
    assert sorted(path.parent.iterdir()) == before


# ---------------------------------------------------------------- wrong input


def refused(capsys, campaign, *more):
    """Faults of a diagnosis, which must leave nothing behind."""
    out = campaign.parent / "out"
    found = faults(capsys, "diagnose", campaign, *more, "--out", out)
    assert not out.exists()
    return [fault.replace(f"{campaign.parent}/", "") for fault in found]


def test_no_such_campaign(tmp_path, capsys):
    (fault,) = refused(capsys, tmp_path / "campaign.toml")
    assert fault.startswith("campaign.toml: no such file")


def test_a_file_that_is_no_campaign(tmp_path, capsys):
    (tmp_path / "campaign.toml").write_text("pose_id,x\n1,2\n")
    (fault,) = refused(capsys, tmp_path / "campaign.toml")
    assert "is not TOML" in fault


def test_every_fault_has_a_line(folder, tmp_path, capsys):
    campaign = edited(folder, tmp_path, "poses.csv", "q3_deg", "q3", 1)
    text = (tmp_path / "points.csv").read_text().splitlines()
    text[4] = "1,T1,n/m,2,3"
    text[9] = text[9].rsplit(",", 1)[0] + ",x"
    (tmp_path / "points.csv").write_text("\n".join(text) + "\n")
    found = refused(capsys, campaign)
    assert len(found) >= 3
    assert any(fault.startswith("points.csv line 5") and "x_mm is 'n/m'" in fault for fault in found)
    assert any(fault.startswith("points.csv line 10") for fault in found)
    assert any(fault.startswith("poses.csv") and "q3" in fault for fault in found)


def test_unknown_robot(folder, tmp_path, capsys):
    (fault,) = refused(capsys, edited(folder, tmp_path, "campaign.toml", '"kr500"', '"kr5000"'))
    assert "no such robot" in fault
    assert "kr500" in fault.split("kr5000", 1)[1]
    (fault,) = faults(capsys, "simulate", "kr5000", "--random", 3, "--out", tmp_path / "out")
    assert "known:" in fault
    assert not (tmp_path / "out").exists()


def test_units_mixed_up(folder, tmp_path, capsys):
    found = refused(capsys, edited(folder, tmp_path, "points.csv", "x_mm,y_mm,z_mm", "x_m,y_m,z_m"))
    assert len(found) == 1
    assert "millimetres, not metres" in found[0]
    poses = (folder / "one/poses.csv").read_text().splitlines()[0]
    joints = ",".join(f"q{j}_deg" for j in range(1, 7))
    assert joints in poses
    found = refused(capsys, edited(folder, tmp_path, "poses.csv", joints, joints.replace("deg", "rad")))
    assert len(found) == 1
    assert "degrees, not radians" in found[0]


def test_units_mixed_up_in_the_test_campaign(folder, tmp_path, capsys):
    wrong = edited(folder, tmp_path, "points.csv", "x_mm,y_mm,z_mm", "x_m,y_m,z_m")
    out = tmp_path / "out"
    (fault,) = faults(capsys, "diagnose", folder / "one/campaign.toml", "--test", wrong, "--out", out)
    assert "millimetres, not metres" in fault
    assert not out.exists()


def test_faults_of_all_campaigns_at_once(folder, tmp_path, capsys):
    campaign = edited(folder, tmp_path, "campaign.toml", '"kr500"', '"kr5000"')
    found = refused(capsys, campaign, tmp_path / "missing.toml", "--test", tmp_path / "lost.toml")
    assert len(found) == 3


def test_different_robots_are_not_fitted_together(folder, tmp_path, capsys):
    main(["simulate", "ur5", "--random", "3", "--out", str(tmp_path / "ur5")])
    found = faults(capsys, "diagnose", folder / "one/campaign.toml", tmp_path / "ur5/campaign.toml")
    assert any("robot 'ur5', but 'kr500'" in fault for fault in found)


def test_out_is_a_file(folder, tmp_path, capsys):
    (tmp_path / "out").write_text("mine")
    for command in (
        ["diagnose", folder / "one/campaign.toml"],
        ["simulate", "ur5", "--random", 3],
        ["demo", "--quick"],
    ):
        (fault,) = faults(capsys, *command, "--out", tmp_path / "out")
        assert "is a file, not a folder" in fault
    assert (tmp_path / "out").read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--random", "3", "--effect", "rust"], "no cause 'rust'"),
        (["--random", "3", "--effect", "gear_ratio:joint=joint_9"], "no joint 'joint_9'"),
        (["--random", "3", "--effect", "gear_ratio:joint=joint_1,relative=much"], "not a number"),
        (["--random", "3", "--effect", "backlash:joint=joint_1"], "no column dir1..dir6"),
        (["--random", "3", "--payload", "heavy"], "is no NAME=KG"),
        (["--random", "3", "--payload", "heavy=-3"], "is no KG"),
        (["--random", "3", "--tool", "much"], "is no KG"),
        (["--random", "0"], "give a number of poses"),
        (["--grid", "joint_9=0:1:2"], "no joint 'joint_9'"),
        (["--grid", "joint_2=0:1"], "JOINT=FROM:TO:COUNT"),
        (["--poses", "no.csv"], "no such file"),
    ],
)
def test_simulate_refuses(tmp_path, capsys, options, said):
    (fault,) = faults(capsys, "simulate", "kr500", *options, "--out", tmp_path / "out")
    assert said in fault
    assert not (tmp_path / "out").exists()


def test_simulate_tells_an_effect_that_moves_nothing(tmp_path, capsys):
    options = ["--random", "3", "--payload", "box=3", "--effect", "payload:payload=box"]
    status, _, err = call(capsys, "simulate", "irb120", *options, "--out", tmp_path)
    assert status == 0
    assert "warning: payload(box) moves no point in these poses" in err


def test_simulate_takes_all_that_a_file_of_poses_says(tmp_path, capsys):
    rows = [
        "pose_id,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,payload,dir2,t_s,temp_degC,fz_N,setup,"
        + ",".join(f"r{j}_deg" for j in range(1, 7)),
        "a,0,-90,90,0,45,0,,1,0,20,0,A,0,-90,90,0,45,0",
        "b,10,-80,80,5,40,0,heavy,-1,60,25,-100,B,10.1,-80,80,5,40,0",
        "c,10,-70,80,5,40,30,heavy,1,120,26,0,B,10,-70,80,5,40,30",
    ]
    (tmp_path / "plan.csv").write_text("\n".join([*rows, ""]))
    command = ["simulate", "kr500", "--poses", tmp_path / "plan.csv", "--out", tmp_path / "made"]
    fault, _ = faults(capsys, *command)
    assert "plan.csv line 3" in fault
    assert "payload 'heavy' is not known" in fault
    assert "--payload heavy=KG" in fault
    call(capsys, *command, "--payload", "heavy=200")
    made = load_campaign(tmp_path / "made/campaign.toml")
    assert [made.payload_names[k] for k in made.poses.payload] == ["", "heavy", "heavy"]
    assert made.poses.side[:, 1].tolist() == [1, -1, 1]
    assert made.poses.time.tolist() == [0, 60, 120]
    assert made.poses.temperature.tolist() == [20, 25, 26]
    assert made.poses.wrench[:, 2].tolist() == [0, -100, 0]
    assert [made.setup_names[k] for k in made.poses.setup] == ["A", "B", "B"]
    assert np.degrees(made.poses.readback[:, 0]).tolist() == pytest.approx([0, 10.1, 10])
    status, *_ = call(capsys, *command, "--payload", "heavy=200", "--effect", "readback_joints:weight=1")
    assert status == 0


def test_simulate_on_a_grid_and_from_a_file(folder, tmp_path, capsys):
    status, *_ = call(
        capsys,
        "simulate",
        "kr500",
        "--grid",
        "joint_1=-30:30:3,joint_2=-90:-45:2",
        "--out",
        tmp_path / "grid",
    )
    assert status == 0
    grid = load_campaign(tmp_path / "grid/campaign.toml")
    assert grid.n_poses == 6
    assert grid.poses.q[0] == pytest.approx([-0.5235987756, -1.5707963268, 0, 0, 0, 0], abs=1e-9)
    status, *_ = call(
        capsys, "simulate", "kr500", "--poses", tmp_path / "grid/poses.csv", "--out", tmp_path / "same"
    )
    assert status == 0
    assert load_campaign(tmp_path / "same/campaign.toml").poses.q == pytest.approx(grid.poses.q)


def test_a_failure_is_not_the_user_s(folder, capsys, monkeypatch):
    def broken(*_):
        raise ArithmeticError("the fit does not converge")

    monkeypatch.setattr(sys.modules["workbench.diagnosis.prepared"], "problem", broken)
    status, out, err = call(capsys, "diagnose", folder / "one/campaign.toml", "--json")
    assert (status, out) == (1, "")
    assert "failed: ArithmeticError: the fit does not converge" in err


def test_a_case_that_is_none_is_refused(capsys):
    found = faults(capsys, "study", "case", "gear_ratio/x", "rust/1", "--json")
    assert len(found) == 2
    assert "like gear_ratio/3; known: backlash, " in found[0]


def test_ctrl_c_in_a_command(capsys, monkeypatch):
    def stopped():
        raise KeyboardInterrupt

    monkeypatch.setattr("workbench.robot.find.list_robots", stopped)
    assert call(capsys, "robots") == (130, "", "interrupted\n")


# ---------------------------------------------------------------- as a process


def process(*arguments, **environment):
    return subprocess.run(
        [sys.executable, "-m", "workbench", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, **environment},
    )


def test_help_is_instant():
    loaded = (
        "import sys; from workbench.cli.main import command_line; command_line(); "
        "sys.exit(any(m in sys.modules for m in ('numpy', 'pydrake', 'pydantic', 'multiprocessing')))"
    )
    assert subprocess.run([sys.executable, "-c", loaded], check=False).returncode == 0
    done = process("--help")
    assert done.returncode == 0
    assert all(f"\n    {name.split()[0]}" in done.stdout for name in COMMANDS)


def test_a_wrong_call_is_2():
    for arguments in ([], ["paint"], ["simulate", "kr500"], ["diagnose"], ["compensate", "path.csv"]):
        done = process(*arguments)
        assert done.returncode == 2
        assert done.stdout == ""
        assert "Traceback" not in done.stderr


def test_json_from_a_process_with_a_poor_terminal(folder):
    done = process("diagnose", folder / "one/campaign.toml", "--json", PYTHONIOENCODING="ascii")
    assert done.returncode == 0
    assert json.loads(done.stdout)["verdict"] == "named"
    done = process("diagnose", Path("no such.toml"), "--json", PYTHONIOENCODING="ascii")
    assert done.returncode == 2
    assert done.stderr.startswith("error: no such.toml")


@pytest.mark.parametrize(
    ("effect", "option"),
    [
        ("backlash:joint=joint_2", "--approach"),
        ("drift:rate_x=1e-6", "--hours"),
        ("thermal_growth:coefficient=1e-5", "--warm-degC"),
    ],
)
def test_an_effect_that_needs_a_column_names_its_option(tmp_path, capsys, effect, option):
    asked = ["simulate", "kr500", "--random", "3", "--effect", effect, "--out", str(tmp_path / "one")]
    (fault,) = faults(capsys, *asked)
    assert fault.endswith(f"({option})")


@pytest.mark.parametrize(("more", "what"), [([], "no [controller]"), (["--as-urdf"], "3 turning joints")])
def test_a_plan_for_no_program_is_refused_before_its_poses_are_chosen(tmp_path, capsys, more, what):
    toml = tmp_path / "short.toml"
    joint = (
        '<joint name="j{0}" type="revolute"><parent link="l{1}"/><child link="l{0}"/><origin xyz="0 0 0.4"/>'
    )
    turn = '<axis xyz="{} 0 1"/><limit lower="-2" upper="-1" velocity="1" effort="1"/></joint>'
    links = "".join(f'<link name="l{i}"/>' for i in range(4))
    arm = "".join(joint.format(i, i - 1) + turn.format(i % 2) for i in (1, 2, 3))
    (tmp_path / "short.urdf").write_text(f'<robot name="short">{links}{arm}</robot>')
    toml.write_text('schema = 1\nname = "short"\nurdf = "short.urdf"\nflange = "l3"\n')
    status, out, err = call(
        capsys, "plan", toml, "--poses", "5", "--format", "krl", *more, "--out", tmp_path / "plan"
    )
    assert (status, out) == (2, "")
    assert what in err
    assert "choosing" not in err


def test_check_tells_of_drives_that_do_not_bear_the_arm(tmp_path, capsys):
    """Many public descriptions have 1 in the place of an effort that nobody knew."""
    robot = load_robot("ur10")
    shoulder = robot.joint_names[1]
    head, joint, rest = robot.urdf.read_text().partition(f'<joint name="{shoulder}"')
    (tmp_path / "arm.urdf").write_text(head + joint + re.sub('effort="[^"]*"', 'effort="1"', rest, count=1))
    text = robot.path.read_text().replace(robot.urdf.name, "arm.urdf")
    (tmp_path / "arm.toml").write_text(text)
    assert main(["check", str(tmp_path / "arm.toml"), "--out", str(tmp_path / "out"), "--json"]) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    (said,) = (text for text in warnings if "effort" in text)
    assert f"{shoulder} holds up to " in said
    assert "its drive bears 1 N·m" in said
    assert too_weak(robot) == []


def test_a_plan_says_that_nothing_pulls_in_it(tmp_path, capsys):
    """Of a campaign that external forces pulled at the poses are planned as if there were none."""
    robot, rng = load_robot("irb120"), np.random.default_rng(0)
    q = np.repeat(random_poses(robot, 16, rng), 2, axis=0)
    wrench = np.zeros((len(q), 6))
    wrench[1::2, :3] = rng.normal(size=(16, 3)) * 30.0
    for name, pulls in (("pulled", wrench), ("free", None)):
        write_campaign(tmp_path / name, simulate(planned(robot, q, wrench=pulls), Truth(sigma=3e-5)))
        status, out, err = call(
            capsys, "plan", tmp_path / name, "--poses", "3", "--quick", "--out", tmp_path / f"{name}.csv"
        )
        assert status == 0, err
        assert ("without the external forces" in out) == (name == "pulled")
