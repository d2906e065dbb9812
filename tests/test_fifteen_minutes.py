"""docs/tutorial.md: a published URDF, tables with other names and units, a first page in three commands."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
import urdf_example as example

from workbench import Truth, load_campaign, load_robot, planned, random_poses, simulate
from workbench.campaign.guess import guess_points, guess_poses
from workbench.cli.main import main
from workbench.robot.chain import MovingJoint
from workbench.robot.rigid_plant import arrays

TUTORIAL = (Path(__file__).resolve().parents[1] / "docs/tutorial.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """The published robot, measured with a wrong length of its forearm, in the folder of an instrument."""
    folder = tmp_path_factory.mktemp("acme")
    urdf = example.package(folder / "src/cloned")
    (folder / "true.toml").write_text(
        f'schema = 1\nname = "acme"\nurdf = "{urdf}"\nflange = "tool0"\n'
        "[geometry.wrist_2_joint]\ntx = 0.002\n"
    )
    robot = load_robot(folder / "true.toml")
    poses = random_poses(robot, 45, np.random.default_rng(3))
    geometry = arrays(robot).geometry
    campaign = simulate(planned(robot, poses), Truth(geometry=geometry, sigma=2e-5), seed=1)
    return folder, urdf, campaign


def german(folder, campaign):
    """As a spreadsheet writes it: semicolons, decimal commas, umlauts, units in brackets."""
    rows = ["Position Nr;" + ";".join(f"Achse {j} [°]" for j in range(1, 7)) + ";Prüfer"]
    for i, q in enumerate(np.degrees(campaign.poses.q), 1):
        rows.append(f"P{i};" + ";".join(f"{v:.6f}".replace(".", ",") for v in q) + ";Jürgen")
    rows[0] = rows[0].replace("Position Nr", "Pose Nr")
    (folder / "roboter.csv").write_text("\n".join(rows), encoding="latin-1")
    lines = ["// tracker export", "Pose\tTarget\tX [m]\tY [m]\tZ [m]\tRMS"]
    for i, t in np.argwhere(campaign.shots > 0):
        xyz = "\t".join(f"{v:.7f}" for v in campaign.points[i, t])
        lines.append(f"P{i + 1}\tSMR{t}\t{xyz}\t0.01")
    (folder / "tracker.txt").write_text("\n".join(lines), encoding="utf-16")


def test_the_tutorial_does_what_it_says(measured, monkeypatch, capsys):
    """Three of its commands reach the first page: init, check, diagnose."""
    folder, _, campaign = measured
    german(folder, campaign)
    rows = [f"{0.1 * i:.1f},{0.2 * i},-20,30,10,5,0" for i in range(20)]
    header = "t_s," + ",".join(f"q{j}_deg" for j in range(1, 7))
    (folder / "path.csv").write_text("\n".join([header, *rows, ""]))
    monkeypatch.chdir(folder)
    commands = re.findall(r"```sh\nworkbench (.*)\n```", TUTORIAL)
    assert [command.split()[0] for command in commands] == ["init", "plan", "check", "diagnose", "compensate"]
    said = {}
    for command in commands:
        assert main(command.split()) == 0, command
        said[command.split()[0]] = capsys.readouterr()
    assert "6 joints from base_link to tool0 (guessed: by its name" in said["init"].out
    assert re.search(r"3  elbow_joint +elbow_link +revolute, -172 .. 172°", said["init"].out), "for --flange"
    assert "stand at 0: finger_1, finger_2" in said["init"].err
    facts = json.loads((folder / "seen/check.json").read_text())
    assert facts["n_poses"] == 45
    assert facts["median_mm"] < 5
    assert facts["suspicious"] == []
    result = json.loads((folder / "found/result.json").read_text())
    assert result["verdict"] == "nothing_missing"
    nominal, geometry = (stage["heldout_rms_mm"] for stage in result["stages"][:2])
    assert geometry < 0.05 < 1 < nominal
    assert (folder / "found/index.html").is_file()
    assert (folder / "found/scene.html").stat().st_size < 5e6
    loaded = load_campaign("acme/campaign.toml")
    np.testing.assert_allclose(loaded.poses.q, campaign.poses.q, atol=1e-8)
    np.testing.assert_allclose(loaded.points, campaign.points, atol=1e-7)
    (code,) = re.findall(r"```python\n(.*?)```", TUTORIAL, flags=re.DOTALL)
    exec(compile(code, "tutorial.md", "exec"), {})
    assert capsys.readouterr().out.startswith("Outcome: Diagnosis of acme, acme: ")
    assert (folder / "found_too/result.json").read_bytes() == (folder / "found/result.json").read_bytes()


def test_check_shows_what_is_suspicious(measured, monkeypatch, tmp_path, capsys):
    _, urdf, campaign = measured
    monkeypatch.chdir(tmp_path)
    assert main(["init", str(urdf), "--name", "mine"]) == 0
    lines = ["pose_id,target,x_mm,y_mm,z_mm"]
    lines += [f"{i},T1," + ",".join(f"{1e3 * v:.4f}" for v in p[0]) for i, p in enumerate(campaign.points)]
    lines[8] = "7,T1,1500,-900,2000"
    Path("mine/points.csv").write_text("\n".join(lines))
    header = Path("mine/poses.csv").read_text()
    rows = [f"{i}," + ",".join(f"{v:.6f}" for v in q) for i, q in enumerate(np.degrees(campaign.poses.q))]
    Path("mine/poses.csv").write_text(header + "\n".join(rows))
    capsys.readouterr()
    assert main(["check", "mine/campaign.toml", "--out", "seen"]) == 0
    told = capsys.readouterr()
    said = told.out
    assert "declared" in said
    assert "declared" not in told.err  # once is enough
    assert "1 suspicious" in said
    assert "pose 7 T1: " in said
    assert "backlash: no column dir1..dir6" in said
    facts = json.loads(Path("seen/check.json").read_text())
    assert [item["point"] for item in facts["suspicious"]] == ["7 T1"]
    page = Path("seen/index.html").read_text()
    assert "1 suspicious" in page
    assert "var(--before)" in page  # red in the picture
    scene = Path("seen/scene.html").read_text()
    assert scene.count('"suspicious": [') + scene.count('"suspicious":[') == 1


def test_check_draws_what_does_not_fit_and_says_why(measured, monkeypatch, tmp_path, capsys):
    folder, urdf, campaign = measured
    german(folder, campaign)
    monkeypatch.chdir(tmp_path)
    tables = ["--poses", str(folder / "roboter.csv"), "--points", str(folder / "tracker.txt")]
    assert main(["init", str(urdf), "--name", "turned", *tables]) == 0
    path = Path("turned/campaign.toml")
    assert capsys.readouterr().out.endswith(f"Next: workbench check {path}\n")
    path.write_text(path.read_text().replace('"Achse 2 [°]"', '"-Achse 2 [°]"'))
    capsys.readouterr()
    assert main(["check", str(path), "--out", "seen"]) == 2
    said = capsys.readouterr()
    assert "q2" in said.err
    assert "do not belong together" in said.out
    assert Path("seen/scene.html").is_file()


def test_check_of_a_robot(measured, monkeypatch, tmp_path, capsys):
    _, urdf, _ = measured
    monkeypatch.chdir(tmp_path)
    assert main(["init", str(urdf)]) == 0
    assert capsys.readouterr().out.endswith(f"Next: workbench check {Path('acme/acme.toml')}\n")
    assert main(["check", "acme/acme.toml"]) == 0
    said = capsys.readouterr().out
    assert "no gear ratio of any joint" in said
    assert "without limits: wrist_3_joint" in said
    assert Path("reports/check/scene.html").is_file()
    assert main(["check", str(urdf)]) == 2
    assert "workbench init" in capsys.readouterr().err


def test_init_writes_over_nothing(measured, monkeypatch, tmp_path, capsys):
    _, urdf, _ = measured
    monkeypatch.chdir(tmp_path)
    assert main(["init", str(urdf), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["flange"] == {"link": "tool0", "why": "by its name"}
    before = {path: path.read_bytes() for path in Path("acme").rglob("*") if path.is_file()}
    assert main(["init", str(urdf)]) == 2
    assert "is there already; name another folder with --out" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in Path("acme").rglob("*") if path.is_file()} == before
    assert main(["init", str(urdf), "oops"]) == 2
    assert "is no NAME:=VALUE" in capsys.readouterr().err
    assert load_robot("acme/acme.toml").joint_names[0] == "shoulder_pan_joint"
    assert main(["check", "acme/campaign.toml"]) == 2  # nothing is filled in yet
    assert "has a header but no rows" in capsys.readouterr().err


def test_the_readmes_way_to_a_program_is_true(measured, monkeypatch, tmp_path, capsys):
    """As it stands the robot's path comes as a table; with the lines of [controller], as a program."""
    _, urdf, _ = measured
    monkeypatch.chdir(tmp_path)
    assert main(["init", str(urdf)]) == 0
    monkeypatch.chdir(tmp_path / "acme")
    rows = [f"{0.1 * i:.1f},{0.2 * i},-20,30,10,5,0" for i in range(5)]
    header = "t_s," + ",".join(f"q{j}_deg" for j in range(1, 7))
    Path("PATH.csv").write_text("\n".join([header, *rows, ""]))
    (step,) = re.findall(r"5\. `workbench (.*?)`", Path("README.md").read_text())
    command = step.replace("found/model.toml", "acme.toml").split()  # not diagnosed here
    assert main(command) == 0
    capsys.readouterr()
    assert main([*command, "--format", "krl", "--json"]) == 0
    said = capsys.readouterr()
    (warning,) = [line for line in said.err.splitlines() if line.startswith("warning: ")]
    assert "no [controller]" in warning
    assert warning.removeprefix("warning: ") in json.loads(said.out)["notes"]
    (program,) = [Path(file) for file in json.loads(said.out)["files"] if file.endswith(".src")]
    assert "not checked against the controller" in program.read_text()
    text = Path("acme.toml").read_text()
    start = text.index("# [controller]")
    rest = text.index("\n\n", start)
    Path("acme.toml").write_text(text[:start] + text[start:rest].replace("# ", "") + text[rest:])
    assert main([*command, "--format", "krl", "--force"]) == 0
    assert "no [controller]" not in capsys.readouterr().err
    assert "not checked against the controller" not in program.read_text()


def table(path, header, rows, separator=","):
    path.write_text("\n".join([*([header] if header else []), *(separator.join(row) for row in rows)]))
    return path


ANGLES = [[f"{30 * i + j}.5" for j in range(6)] for i in range(4)]


@pytest.mark.parametrize(
    ("header", "rows", "separator", "wanted"),
    [
        ("id,J1,J2,J3,J4,J5,J6", [[str(i), *a] for i, a in enumerate(ANGLES)], ",",
         {"pose_id": "id", **{f"q{j}_deg": f"J{j}" for j in range(1, 7)}}),
        ("A0 A1 A2 A3 A4 A5", [["0.1", "-0.2", "1", "2", "3", "-3"]], " ",
         {f"q{j + 1}_rad": f"A{j}" for j in range(6)}),
        ("", [[f"P{i}", *a] for i, a in enumerate(ANGLES)], ";",
         {"pose_id": 1, **{f"q{j}_deg": j + 1 for j in range(1, 7)}}),
        ("\t".join(f"{n}_joint" for n in reversed(example.NAMES)), ANGLES, "\t",
         {f"q{j}_deg": f"{n}_joint" for j, n in enumerate(example.NAMES, 1)}),
        ("t," + ",".join(f"actual_q_{j}" for j in range(6)), [["7", "0.1", "-0.2", "1", "2", "3", "-3"]], ",",
         {f"q{j + 1}_rad": f"actual_q_{j}" for j in range(6)}),
    ],
)  # fmt: skip
def test_tables_of_joints_are_guessed(tmp_path, header, rows, separator, wanted):
    """UR's own names for joints are those of the fourth table, its logger's those of the last."""
    joints = [MovingJoint(f"{name}_joint", "revolute", name, -3, 3, 1, 1) for name in example.NAMES]
    found = guess_poses(table(tmp_path / "t.csv", header, rows, separator), joints)
    assert found.keys["columns"] == wanted
    assert found.lacking == []


@pytest.mark.parametrize(
    ("header", "rows", "separator", "wanted"),
    [
        ("pose,name,x,y,z", [["1", "A", "2000", "1", "3"], ["1", "B", *"113"], ["2", "A", *"113"]], ",",
         {"columns": {"pose_id": "pose", "target": "name", "x_mm": "x", "y_mm": "y", "z_mm": "z"}}),
        ("", [["1", "2296.49", "-2416.25", "-442.56"], ["2", "2296.4", "-241.2", "-44.56"]], ", ",
         {"header": False, "columns": {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}}),
        ("", [["a", "A", "99.5", "mm", "-2.2", "mm", "9"], ["b", "A", "6.4", "mm", "2.5", "mm", "4.6"]], ",",
         {"header": False, "columns": {"pose_id": 1, "target": 2, "x_mm": 3, "y_mm": 5, "z_mm": 7}}),
        ("nr;T1_x;T1_y;T1_z;T2_x;T2_y;T2_z", [["1", *["2,5"] * 6], ["2", *["2,5"] * 6]], ";",
         {"separator": ";", "decimal": ",", "columns": {"pose_id": "nr"},
          "units": {"x_mm": "m", "y_mm": "m", "z_mm": "m"},
          "wide": {"T1": ["T1_x", "T1_y", "T1_z"], "T2": ["T2_x", "T2_y", "T2_z"]}}),
        ("0,1,2,3", [["7", "2296.49", "-2416.25", "-442.56"], ["8", "2296.4", "-241.2", "-44.56"]], ",",
         {"columns": {"pose_id": "0", "x_mm": "1", "y_mm": "2", "z_mm": "3"}}),
        ("pose_id,x_mm,y_mm,z_mm", [["a", "1", "2", "3"]], ",", {}),
        ("pose_id,x_mm,y_mm,z_mm,qw,qx,qy,qz", [["a", *"1231000"]], ",", {"turned_mm": 100.0}),
    ],
)  # fmt: skip
def test_tables_of_points_are_guessed(tmp_path, header, rows, separator, wanted):
    assert guess_points(table(tmp_path / "t.csv", header, rows, separator)).keys == wanted


def test_the_names_of_german_tables_are_known(tmp_path):
    joints = [MovingJoint(f"joint_{j}", "revolute", "link", -3, 3, 1, 1) for j in (1, 2)]
    poses = table(tmp_path / "roboter.csv", "Punkt;A1;A2", [["P1", "10", "20"], ["P2", "-90", "30"]], ";")
    assert guess_poses(poses, joints).keys["columns"] == {"pose_id": "Punkt", "q1_deg": "A1", "q2_deg": "A2"}
    rows = [["P1", "R1", *"123"], ["P2", "R1", *"456"]]
    points = table(tmp_path / "tracker.csv", "Punkt;Reflektor;X;Y;Z", rows, ";")
    found = guess_points(points).keys["columns"]
    assert (found["pose_id"], found["target"]) == ("Punkt", "Reflektor")


def test_what_is_not_found_is_said(measured, monkeypatch, tmp_path, capsys):
    _, urdf, _ = measured
    monkeypatch.chdir(tmp_path)
    table(Path("t.csv"), "alpha,beta", [["1", "2"]])
    assert main(["init", str(urdf), "--poses", "t.csv", "--points", "t.csv"]) == 0
    said = Path("acme/campaign.toml").read_text()
    assert "# NOT FOUND: joint 1, joint 2" in said
    assert "the file has: alpha, beta" in said
    capsys.readouterr()
    assert main(["check", "acme/campaign.toml"]) == 2
    assert "no column" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("beside", "wanted"),
    [
        (lambda i, a: ["0.7", "0.01", f"0.{i}", f"0.{a}"], (2, 3, 4)),  # a quaternion
        (lambda i, a: [f"0.0{i}", f"{1000 * i}.5", f"21.{a}"], (2, 3, 4)),  # RMS, time, temperature
        (lambda i, a: [f"0.{a}", "90.0", f"-{i}.5"], (2, 3, 4)),  # angles
        (lambda i, a: [f"{100 * i}.7", f"-{50 * a}.2", f"{80 * a}.9"], (5, 6, 7)),  # nominal, then measured
    ],
)
def test_places_without_names_are_those_that_vary(tmp_path, beside, wanted):
    rows = [
        [str(i), f"{100 * i}.5", f"-{50 * a}.25", f"{80 * a}.5", *beside(i, a)]
        for i, a in enumerate((3, 1, 4, 9, 5, 2, 6), 1)
    ]
    found = guess_points(table(tmp_path / "t.csv", "", rows))
    assert found.keys["columns"] == {"pose_id": 1, **dict(zip(("x_mm", "y_mm", "z_mm"), wanted, strict=True))}


def test_a_title_over_the_table_is_no_header(tmp_path):
    """It has fewer cells than the rows below it."""
    joints = [MovingJoint(f"joint_{j}", "revolute", "link", -3, 3, 1, 1) for j in (1, 2)]
    found = guess_poses(table(tmp_path / "t.csv", "Export of today", [["P1", "10", "20"]] * 3), joints)
    assert found.keys == {"skip": 1, "header": False, "columns": {"q1_deg": 2, "q2_deg": 3}}
    assert guess_points(tmp_path / "t.csv").lacking == ["x", "y", "z"]


def in_one(campaign, *columns):
    """Rows of one table without a header."""
    return [[f"{value:.6f}" for value in row] for row in np.concatenate(columns, axis=1)]


def guessed_of(name):
    return tomllib.loads(Path(name, "campaign.toml").read_text())


def test_joints_and_points_in_one_table_are_told_apart_by_the_robot(measured, monkeypatch, tmp_path, capsys):
    """Points in metres might be joints, zeros as well: only the right columns fit the robot."""
    _, urdf, campaign = measured
    monkeypatch.chdir(tmp_path)
    q, points = np.degrees(campaign.poses.q), campaign.points
    nothing = np.zeros((len(q), 3))
    table(Path("one.csv"), "", in_one(campaign, q, points[:, 0], nothing))
    assert main(["init", str(urdf), "--name", "one", "--poses", "one.csv", "--points", "one.csv"]) == 0
    found = guessed_of("one")
    assert found["poses"]["columns"] == {f"q{j}_deg": j for j in range(1, 7)}
    assert found["points"]["columns"] == {"x_m": 7, "y_m": 8, "z_m": 9}
    assert load_campaign("one/campaign.toml").points == pytest.approx(points[:, :1], abs=1e-6)
    wide = 1e3 * points[:, :3].reshape(len(q), 9)
    table(Path("three.csv"), "", in_one(campaign, wide, nothing, nothing, np.radians(q)))
    assert main(["init", str(urdf), "--name", "three", "--poses", "three.csv", "--points", "three.csv"]) == 0
    found = guessed_of("three")
    assert found["poses"]["columns"] == {f"q{j}_rad": 15 + j for j in range(1, 7)}
    assert found["points"]["wide"] == {"T1": [1, 2, 3], "T2": [4, 5, 6], "T3": [7, 8, 9]}
    assert load_campaign("three/campaign.toml").points == pytest.approx(points[:, :3], abs=1e-6)
    capsys.readouterr()
    table(Path("none.csv"), "", in_one(campaign, q, points[::-1, 0]))
    assert main(["init", str(urdf), "--name", "none", "--poses", "none.csv", "--points", "none.csv"]) == 0
    assert "NOT FOUND: x, y, z (joints and points in one table" in capsys.readouterr().err
    assert "columns" not in guessed_of("none")["poses"]


def test_joints_without_names_are_those_that_vary(tmp_path):
    """External axes stand still, and a program's words stand in the cells beside its numbers."""
    joints = [MovingJoint(f"joint_{j}", "revolute", "link", -3, 3, 1, 1) for j in range(1, 12)]
    rows = [[f"P{i}", *a, *["0"] * 6] for i, a in enumerate(ANGLES)]
    found = guess_poses(table(tmp_path / "t.csv", "", rows), joints[:6])
    assert found.keys["columns"] == {"pose_id": 1, **{f"q{j}_deg": j + 1 for j in range(1, 7)}}
    lines = [["VAR jointtarget j1 = j:{" + a[0], *a[1:], "0}{EJ 0", *["0"] * 5] for a in ANGLES]
    found = guess_poses(table(tmp_path / "t.mod", "", lines), joints[:6])
    assert found.lacking == [f"joint {j}" for j in range(1, 7)]
    assert "it takes 6 columns of numbers side by side" in found.why
    many = [[f"{i}.{j}" for j in range(1, 12)] for i in range(3)]
    found = guess_poses(table(tmp_path / "t.txt", ",".join(f"q{j}_rad" for j in range(1, 12)), many), joints)
    assert not found.lacking


def test_a_part_of_a_quaternion_names_no_pose(tmp_path):
    """Of x y z and four numbers more without a header: what has decimals is no name."""
    rng = np.random.default_rng(5)
    turns = rng.normal(size=(30, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    rows = np.hstack([rng.uniform(-500, 500, (30, 3)), turns])
    file = table(tmp_path / "points.csv", "", [[f"{value:.9f}" for value in row] for row in rows])
    found = guess_points(file)
    assert found.keys["columns"] == {"x_mm": 1, "y_mm": 2, "z_mm": 3}
