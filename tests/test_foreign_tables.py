"""Tables as others keep them: side by side, without names, turned signs, encodings; and no files at all."""

from __future__ import annotations

import numpy as np
import pytest
from campaign_example import BARE, POINTS, POSES, TOML, faults, write_example

from workbench import InputError, campaign_from_arrays, load_campaign
from workbench.campaign import load_campaign as load


def campaign(folder, poses="", points="", tables=(POSES, POINTS)):
    return load(write_example(folder, BARE.format(poses=poses, points=points), *tables))


def test_targets_side_by_side(tmp_path):
    wide = "id;A x;A y;A z;B x;B y;B z\na;1;2;3;4;5;6\nb;;;;7;8;9\nc;10;11;12;;;\n"
    keys = 'separator = ";"\ncolumns = { pose_id = "id" }\nunits = { x_mm = "m", y_mm = "m", z_mm = "m" }\n'
    keys += 'wide = { A = ["A x", "A y", "A z"], B = [5, -6, 7] }\n'
    found = campaign(tmp_path, points=keys, tables=(POSES, wide))
    assert [target.name for target in found.targets] == ["A", "B"]
    assert found.shots.tolist() == [[1, 1], [0, 1], [1, 0]]
    assert found.points[0].tolist() == [[1, 2, 3], [4, -5, 6]]
    assert found.points[2, 0].tolist() == [10, 11, 12]


def test_faults_of_targets_side_by_side(tmp_path):
    wide = "id,x1,y1,z1\na,1,2,3\nb,4,,6\nc,oops,2,3\n"
    keys = 'columns = { pose_id = "id" }\nwide = { A = ["x1", "y1", "z1"] }\n'
    toml = BARE.format(poses="", points=keys)
    told = faults(write_example(tmp_path, toml, POSES, wide))
    assert len(told) == 1
    assert "line 4: x_mm ('x1') is 'oops', not a number" in told[0]
    told = faults(write_example(tmp_path, toml, POSES, wide.replace("oops", "1")))
    assert "line 3: y_mm ('y1') of A is empty" in told[0]
    told = faults(write_example(tmp_path, toml.replace('"z1"', '"zz"'), POSES, wide))
    assert "points.wide.A.columns.z_mm: no column 'zz' in the header" in told[0]


def test_without_names_the_rows_count(tmp_path):
    poses = "q1_deg,q2_rad,q3_mm\n10,0.5,100\n-20,0.25,200\n30,-0.5,0\n"
    points = "x_mm,y_mm,z_mm\n1000,0,0\n2000,0,0\n3000,0,0\n"
    found = campaign(tmp_path, tables=(poses, points))
    assert found.poses.ids == ("1", "2", "3")
    assert found.points[:, 0, 0].tolist() == [1.0, 2.0, 3.0]
    assert found.targets[0].name == "T1"
    assert any("joined to the poses in order" in line for line in found.warnings)
    two = "target,x_mm,y_mm,z_mm\n" + "".join(f"{t},{i},0,0\n" for t in "AB" for i in (1, 2, 3))
    assert campaign(tmp_path / "two", tables=(POSES, two)).points[:, 1, 0].tolist() == [1e-3, 2e-3, 3e-3]
    fewer = points.rsplit("\n", 2)[0]
    told = faults(write_example(tmp_path / "fewer", BARE.format(poses="", points=""), poses, fewer))
    assert "no column pose_id; add it, or say which it is" in told[0]


def test_wide_rows_are_poses_too(tmp_path):
    """As many as there are poses; a row of nothing but separators may not shift the others."""
    wide = "x1,y1,z1,note\n,,,moved away\n1000,0,0,\n3000,0,0,\n"
    keys = 'wide = { A = ["x1", "y1", "z1"] }\n'
    assert campaign(tmp_path, points=keys, tables=(POSES, wide)).poses.ids == ("b", "c")
    toml = BARE.format(poses="", points=keys)
    told = faults(write_example(tmp_path / "blank", toml, POSES, wide.replace("moved away", "")))
    assert "no column pose_id" in told[0]


def test_turned_columns(tmp_path):
    poses = "Name,J1,J2,L\na,10,0.5,100\nb,-20,0.25,200\nc,30,-0.5,0\n"
    keys = 'columns = { pose_id = "Name", q1_deg = "-J1", q2_rad = -3, q3_mm = "L" }\n'
    found = campaign(tmp_path, poses=keys, tables=(poses, POINTS))
    np.testing.assert_allclose(found.poses.q[0], [-np.radians(10), -0.5, 0.1])
    plain = campaign(tmp_path / "plain")
    np.testing.assert_allclose(found.poses.q[:, :2], -plain.poses.q[:, :2])
    told = faults(
        write_example(tmp_path, BARE.format(poses=keys.replace('"Name"', '"-Name"'), points=""), poses)
    )
    assert any("is a text, which has no sign" in fault for fault in told)
    told = faults(write_example(tmp_path, BARE.format(poses=keys.replace("-3", "0"), points=""), poses))
    assert any("columns count from 1" in fault for fault in told)


@pytest.mark.parametrize(("encoding", "stated"), [("latin-1", True), ("utf-16", False), ("utf-8-sig", False)])
def test_encodings(tmp_path, encoding, stated):
    path = write_example(tmp_path, BARE.format(poses="", points=""), POSES, POINTS)
    named = POINTS.replace("T1", "Würfel")
    (tmp_path / "points.csv").write_bytes(named.encode(encoding))
    if stated:
        assert any('encoding = "latin-1"' in fault for fault in faults(path))
        path.write_text(BARE.format(poses="", points=f'encoding = "{encoding}"\n'))
    assert load(path).targets[0].name == "Würfel"
    path.write_text(BARE.format(poses="", points='encoding = "klingon"\n'))
    assert any("is no encoding that is known" in fault for fault in faults(path))


@pytest.mark.parametrize(
    ("template", "text"),
    [
        ("spatial-analyzer", "// a comment\nWorld a T1 1000 2000 3000\nWorld b T1 1 2 3\nWorld c T1 4 5 6\n"),
        (
            "spatial-analyzer-csv",
            "W,a,T1,1000,2000,3000,0.01\nW,b,T1,1,2,3,0.01\nW,c,T1,4,5,6,0.01\n",
        ),
        ("leica", "a, 1000, 2000, 3000\nb, 1, 2, 3\nc, 4, 5, 6\n"),
        ("polyworks", "# x y z\na 1000 2000 3000\nb 1 2 3\nc 4 5 6\n"),
    ],
)
def test_exports_by_their_names(tmp_path, template, text):
    found = campaign(tmp_path, points=f'template = "{template}"\n', tables=(POSES, text))
    assert found.points[0, 0].tolist() == [1, 2, 3]
    assert [target.name for target in found.targets] == ["T1"]


def test_what_is_said_beside_a_template_counts(tmp_path):
    keys = 'template = "leica"\nseparator = ";"\nunits = { x_mm = "m" }\n'
    found = campaign(tmp_path, points=keys, tables=(POSES, "a; 1; 2000; 3000\nb;1;2;3\nc;4;5;6\n"))
    assert found.points[0, 0].tolist() == [1, 2, 3]
    told = faults(write_example(tmp_path, BARE.format(poses="", points='template = "faro"\n')))
    assert any("spatial-analyzer" in fault and "faro" in fault for fault in told)


def test_a_known_scale(tmp_path):
    plain = load_campaign(write_example(tmp_path))
    scaled = load_campaign(write_example(tmp_path / "scaled", TOML + "[known]\nscale = 1.001\n"))
    np.testing.assert_allclose(scaled.points, 1.001 * plain.points)


def test_arrays_are_a_campaign(tmp_path):
    plain = load_campaign(write_example(tmp_path))
    made = campaign_from_arrays(tmp_path / "robot/tiny.toml", plain.poses.q, plain.points, sigma=2e-5)
    np.testing.assert_array_equal(made.poses.q, plain.poses.q)
    np.testing.assert_array_equal(made.points, plain.points)
    assert made.noise_sigma == pytest.approx(2e-5)
    assert [target.name for target in made.targets] == ["T1", "T2"]
    sections = {"targets": {"A": {"xyz_mm": [1, 2, 3]}}, "tool": {"mass_kg": 3.0}}
    one = campaign_from_arrays(made.robot, plain.poses.q, plain.points[:, 0], sections=sections)
    assert one.targets[0].xyz == (0.001, 0.002, 0.003)
    assert one.tool_mass == 3.0


class Frame(dict):
    """As far as pandas and polars agree."""

    @property
    def columns(self):
        return list(self)


@pytest.mark.parametrize("kind", [Frame, dict])
def test_data_frames_state_their_units(tmp_path, kind):
    plain = load_campaign(write_example(tmp_path))
    q = plain.poses.q
    poses = kind(
        q1_deg=np.degrees(q[:, 0]), q2_rad=q[:, 1], q3_m=q[:, 2], dir1=[1, -1, 1], pose_id=["a", "b", "c"]
    )
    points = kind(pose_id=["a", "b", "c"], x_m=[1.0, 2.0, 3.0], y_m=[0.0] * 3, z_mm=[5, 5, 5])
    made = campaign_from_arrays(plain.robot, poses, points)
    np.testing.assert_allclose(made.poses.q, q, atol=1e-15)
    assert made.poses.side[:, 0].tolist() == [1, -1, 1]
    assert made.points[:, 0].tolist() == [[1, 0, 0.005], [2, 0, 0.005], [3, 0, 0.005]]


def test_wrong_arrays_are_told(tmp_path):
    robot = load_campaign(write_example(tmp_path)).robot
    q, points = np.zeros((4, 3)), np.ones((4, 3))
    for bad, match in [
        (dict(q=q[:, :2]), r"q: has the shape \(4, 2\); \(N, 3\)"),
        (dict(points=points[:, :2]), r"points: has the shape \(4, 2\)"),
        (dict(points=points[:3], q=q * np.nan), "q line 1: a joint is not a number"),
        (dict(sections={"targets": {"A": {}, "B": {}}}), "1 targets, but 2 are declared"),
        (dict(sections={"colour": "red"}), "colour: unknown key"),
        (dict(points={"x_mm": [1], "y_mm": [1], "z_mm": [1]}), "1 points without pose_id for 4 poses"),
        (dict(points={"x": [1], "y_mm": [1], "z_mm": [1]}), "does not say its unit"),
    ]:
        with pytest.raises(InputError, match=match):
            campaign_from_arrays(robot, **{"q": q, "points": points, **bad})


SIX_D = "id,x,y,z,q0,q1,q2,q3\na,1,2,3,1,0,0,0\nb,4,5,6,0.7071,0,0,0.7071\nc,7,8,9,0.5,0.5,0.5,0.5\n"
SIX_D_KEYS = """columns = { pose_id = "id", x_mm = "x", y_mm = "y", z_mm = "z", qw = "q0", qx = "q1", qy = "q2", qz = "q3" }
"""  # noqa: E501


def test_a_6d_measurement_is_three_points(tmp_path):
    found = campaign(tmp_path, points=SIX_D_KEYS + "turned_mm = 100\n", tables=(POSES, SIX_D))
    assert [target.name for target in found.targets] == ["T1", "T1_x", "T1_y"]
    assert found.six_dof
    assert 1e3 * found.points[0] == pytest.approx(np.array([[1, 2, 3], [101, 2, 3], [1, 102, 3]]))
    assert 1e3 * found.points[1] == pytest.approx(np.array([[4, 5, 6], [4, 105, 6], [-96, 5, 6]]))
    assert 1e3 * found.points[2] == pytest.approx(np.array([[7, 8, 9], [7, 108, 9], [7, 8, 109]]))
    alone = campaign(tmp_path / "alone", points=SIX_D_KEYS, tables=(POSES, SIX_D))
    assert alone.points.shape[1] == 1
    assert any("turned_mm = 100 under [points] makes three points of each" in one for one in alone.warnings)


BESIDE = """pose_id,target,x_mm,y_mm,z_mm,qw,qx,qy,qz
a,T1,1,2,3,1,0,0,0
a,B,9,9,9,{turn}
b,T1,4,5,6,1,0,0,0
b,B,9,9,9,{turn}
c,T1,7,8,9,1,0,0,0
c,B,9,9,9,{turn}
"""
ON_BASE = '[targets.T1]\n[targets.B]\non = "base"\n'


@pytest.mark.parametrize("turn", [",,,", "0,0,0,0"])
def test_a_6d_measurement_beside_a_reflector_is_not_read_and_the_advice_works(tmp_path, turn):
    points = BESIDE.format(turn=turn)
    (told,) = faults(
        write_example(tmp_path, BARE.format(poses="", points="turned_mm = 100\n") + ON_BASE, POSES, points)
    )
    assert "points.csv: no line of 'B' says how it is turned" in told
    assert "take turned_mm out" in told
    read = load_campaign(write_example(tmp_path, BARE.format(poses="", points="") + ON_BASE, POSES, points))
    assert [(target.name, target.on) for target in read.targets] == [("T1", "flange"), ("B", "base")]
    assert not read.six_dof


def test_a_6d_measurement_is_of_one_body(tmp_path):
    points = BESIDE.format(turn="1,0,0,0")
    toml = BARE.format(poses="", points="turned_mm = 100\n") + ON_BASE
    toml += '[targets.B_x]\non = "base"\n[targets.B_y]\non = "base"\n'
    (told,) = faults(write_example(tmp_path, toml, POSES, points))
    assert "points.turned_mm: the targets are on flange and base, but one 6-D measurement is of one" in told
    toml = BARE.format(poses="", points="") + ON_BASE + "[noise]\npose = true\n"
    (told,) = faults(write_example(tmp_path, toml, POSES, points))
    assert "noise.pose: the targets are on flange and base" in told


def test_an_empty_turn_of_a_target_that_has_others_is_told(tmp_path):
    toml = BARE.format(poses="", points=SIX_D_KEYS + "turned_mm = 100\n")
    (told,) = faults(write_example(tmp_path, toml, POSES, SIX_D.replace("0.5,0.5,0.5,0.5", ",,,")))
    assert "line 4: qw ('q0') and the three beside it are no quaternion" in told


def test_faults_of_a_6d_measurement(tmp_path):
    toml = BARE.format(poses="", points=SIX_D_KEYS + "turned_mm = 100\n")
    told = faults(write_example(tmp_path, toml, POSES, SIX_D.replace("0.5,0.5,0.5,0.5", "0,0,0,0")))
    assert len(told) == 1
    assert "line 4: qw ('q0') and the three beside it are no quaternion of length 1" in told[0]
    told = faults(write_example(tmp_path, BARE.format(poses="", points="turned_mm = 100\n"), POSES, POINTS))
    assert any("no column qw" in one for one in told)


@pytest.mark.parametrize(
    ("name", "rows", "said"),
    [
        ("pose_id,", "a,1,2,3\nb,,-,\nc,7,8,9\n", "without points"),
        ("", "1,2,3\n,,nan\n7,8,9\n", "joined to the poses in order"),
    ],
)
def test_a_row_of_what_was_not_seen_is_none(tmp_path, name, rows, said):
    """Left out as advised, the others had no longer been as many as the poses."""
    found = campaign(tmp_path, tables=(POSES, f"{name}x_mm,y_mm,z_mm\n{rows}"))
    assert found.poses.ids == ("a", "c")
    assert 1e3 * found.points[:, 0] == pytest.approx(np.array([[1, 2, 3], [7, 8, 9]]))
    assert any("1 pose ('b') without points, left out" in one for one in found.warnings)
    assert any(said in one for one in found.warnings)


def test_a_6d_measurement_that_was_not_seen_keeps_the_order(tmp_path):
    rows = SIX_D.replace("id,", "frame,").replace("4,5,6,0.7071,0,0,0.7071", ",,,,,,")
    keys = SIX_D_KEYS.replace('pose_id = "id", ', "") + "turned_mm = 100\n"
    found = campaign(tmp_path, points=keys, tables=(POSES, rows))
    assert found.poses.ids == ("a", "c")
    assert 1e3 * found.points[1] == pytest.approx(np.array([[7, 8, 9], [7, 108, 9], [7, 8, 109]]))


def test_a_table_in_which_nothing_was_seen_is_told(tmp_path):
    points = "pose_id,x_mm,y_mm,z_mm\na,,,\nb,,,\n"
    (told,) = faults(write_example(tmp_path, BARE.format(poses="", points=""), POSES, points))
    assert told.startswith("points.csv: not one point was seen: x, y and z are empty in every row")
