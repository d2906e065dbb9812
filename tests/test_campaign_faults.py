"""Campaigns: every fault is told with its file, line, column and how to mend it; all of them at once."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from campaign_example import POINTS, POSES, TOML, faults, write_example
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.campaign import load_campaign
from workbench.files.faults import InputError
from workbench.robot.description import load_robot


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("schema = 1", "schema = 2"), "schema: Input should be 1 (is 2)"),
        (("schema = 1\n", ""), "schema: is missing; schema = 1"),
        (('robot = "robot/tiny.toml"', ""), 'robot: is missing; robot = "kr500", or the path'),
        (("[poses]\n", "[pose]\n"), "pose: unknown key; did you mean 'poses'?"),
        (("xyz_mm", "xyz_m"), "targets.T1.xyz_m: unknown key; did you mean 'xyz_mm'?"),
        (("[100.0, 0.0, 50.0]", "[100.0, 0.0]"), "targets.T1.xyz_mm.2: is missing"),
        (("[100.0, 0.0, 50.0]", "[nan, 0.0, 1.0]"), "targets.T1.xyz_mm.0: Input should be a finite"),
        (('on = "link_2"', "fixed = true"), "targets.T2.fixed: a fixed target needs its place; give xyz_mm"),
        (("mass_kg = 250.0", "mass_kg = -1"), "payloads.heavy.mass_kg: Input should be greater than"),
        (("mass_kg = 250.0\n", ""), "payloads.heavy.mass_kg: is missing; mass_kg = 60.0, say"),
        (('file = "poses.csv"', 'file = "poses.csv"\nseparator = "::"'), "poses.separator: String should"),
        (('file = "poses.csv"', 'file = "poses.csv"\ncolumns = { t_s = 0 }'), "poses.columns.t_s"),
        (("[payloads.heavy]", "[noise]\nsigma_mm = 0.0\n[payloads.heavy]"), "noise.sigma_mm: Input should"),
        (("schema = 1", "schema ="), "is not TOML: Invalid value (at line 1, column 9)"),
        (("robot/tiny.toml", "robot/big.toml"), "robot = 'robot/big.toml': no such robot file"),
        (("robot/tiny.toml", "ur_5"), "robot = 'ur_5': no such robot; did you mean 'ur5'?"),
        (
            ("robot/tiny.toml", "robot/tiny.urdf"),
            "robot = 'robot/tiny.urdf': is a robot's description, not the robot's TOML; name a robot TOML "
            "that has it as `urdf`: `workbench init` writes one",
        ),
    ],
)
def test_faults_of_the_toml(tmp_path: Path, change: tuple[str, str], told: str) -> None:
    assert change[0] in TOML
    got = faults(write_example(tmp_path, TOML.replace(*change, 1)))
    said = [re.sub(r"^campaign.toml line \d+: ", "campaign.toml: ", fault) for fault in got]
    assert any(fault.startswith(f"campaign.toml: {told}") for fault in said), got


def test_a_robot_is_no_campaign() -> None:
    """Said in one line, where each of its keys is one that a campaign does not know."""
    with pytest.raises(InputError) as caught:
        load_campaign(load_robot("irb120").path or "")
    (fault,) = caught.value.faults
    assert fault.what == "is a robot, not a campaign"


def test_a_table_pasted_twice_does_not_flood_the_screen(tmp_path: Path) -> None:
    rows = "".join(f"p{row},0,0,0\n" for row in range(30))
    told = faults(write_example(tmp_path, poses=POSES + rows + rows))
    assert told[0].startswith("poses.csv: pose_id 'p0' twice, lines 5 and 35; every row")
    assert told[-1].startswith("poses.csv: 20 more pose_ids several times")
    assert len(told) == 11


def test_missing_table(tmp_path: Path) -> None:
    (told,) = faults(write_example(tmp_path, TOML.replace('file = "points.csv"', 'file = "punkte.csv"')))
    assert told == "punkte.csv: no such file; check the path"


@pytest.mark.parametrize(
    ("poses", "told"),
    [
        (
            POSES.replace("q1_deg", "q1_mm"),
            "poses.csv line 1: column 'q1_mm': joint_1 turns, which 'mm' does not fit; name it q1_deg",
        ),
        (
            POSES.replace("q3_mm", "q3_deg"),
            "poses.csv line 1: column 'q3_deg': rail slides, which 'deg' does not fit; name it q3_mm or q3_m",
        ),
        (
            POSES.replace("q2_rad,", "").replace(",0.5,", ",").replace(",0.25,", ",").replace(",-0.5,", ","),
            "poses.csv line 1: no column q2_deg or q2_rad; add it",
        ),
        (POSES.replace("b,-20", "a,-20"), "poses.csv: pose_id 'a' twice, lines 2 and 3; every row is a pose"),
        (POSES.replace("b,", "a,").replace("c,", "a,"), "poses.csv: pose_id 'a' 3 times, lines 2, 3 and 4"),
        (POSES.replace(",200", ",zwei"), "poses.csv line 3: q3_mm is 'zwei', not a number; a pose needs all"),
        (
            POSES.replace("\n", ",1\n").replace("q3_mm,1", "q3_mm,q4_deg"),
            "poses.csv: column 'q4_deg', but tiny has 3 joints; take it out, or mend `robot`",
        ),
        (
            POSES.replace("\n", ",1\n").replace("q3_mm,1", "q3_mm,r1_deg"),
            "poses.csv: r1 but no r2, r3; give all 3 joints or none",
        ),
        (
            POSES.replace("\n", ",2\n").replace("q3_mm,2", "q3_mm,dir1"),
            "poses.csv line 2: dir1 is not a sign; write -1, 0 or 1 (0: none or not known)",
        ),
        (
            POSES.replace("\n", ",heavi\n").replace("q3_mm,heavi", "q3_mm,payload"),
            "poses.csv line 2: payload 'heavi' is not declared; did you mean 'heavy'?",
        ),
        (
            POSES.replace("\n", ",none\n").replace("q3_mm,none", "q3_mm,payload"),
            "poses.csv line 2: payload 'none' is not declared; [payloads] has: heavy; empty = no payload",
        ),
        (
            POSES.replace("\n", ",\n").replace("q3_mm,", "q3_mm,fx_N"),
            "poses.csv line 2: fx_N is empty; write 0 where there is none",
        ),
    ],
)
def test_faults_of_the_poses(tmp_path: Path, poses: str, told: str) -> None:
    got = faults(write_example(tmp_path, poses=poses))
    assert any(fault.startswith(told) for fault in got), got


@pytest.mark.parametrize(
    ("points", "told"),
    [
        (
            POINTS.replace("pose_id", "id"),
            "points.csv line 1: no column pose_id; add it, or say which it is: columns = { pose_id = ... }",
        ),
        (POINTS.replace("target", "smr"), "points.csv line 1: no column target; add it, or say which it is"),
        (POINTS.replace("a,T2", "a,"), "points.csv line 3: target is empty; name the target of every point"),
        (
            POINTS.replace("2e3", ""),
            "points.csv line 4: y_mm is empty; leave x, y and z empty, or the line out, of a point",
        ),
        (
            POINTS.replace("\n", ",1\n").replace("z_mm,1", "z_mm,sx_mm"),
            "points.csv: sx but no sy_mm, sz_mm; give all three or none",
        ),
        (
            POINTS.replace("\n", ",1,1,0\n").replace("z_mm,1,1,0", "z_mm,sx_mm,sy_mm,sz_mm"),
            "points.csv line 2: sx_mm, sy_mm, sz_mm: an uncertainty of 0 (4 of 4 lines) is none",
        ),
        (
            POINTS.replace("\n", ",1,1,-1\n").replace("z_mm,1,1,-1", "z_mm,sx_mm,sy_mm,sz_mm"),
            "points.csv line 2: sz_mm is below 0; an uncertainty is positive",
        ),
        (
            POINTS.replace("\na", "\n1").replace("\nb", "\n2").replace("\nc", "\n3"),
            "points.csv: no pose_id is among those of poses.csv: here '1', '2', '3', there 'a', 'b', 'c'",
        ),
    ],
)
def test_faults_of_the_points(tmp_path: Path, points: str, told: str) -> None:
    got = faults(write_example(tmp_path, points=points))
    assert any(fault.startswith(told) for fault in got), got


@pytest.mark.parametrize("name", ["{}_T1", "World::{}::T1", "{}-T1"])
def test_names_that_hold_pose_and_target_are_told_as_that(tmp_path: Path, name: str) -> None:
    points = "pose_id,x_mm,y_mm,z_mm\n" + "".join(f"{name.format(p)},1,2,3\n" for p in "abc")
    toml = TOML.replace('[targets.T2]\non = "link_2"\n', "")
    (told,) = faults(write_example(tmp_path, toml, points=points))
    assert told.endswith("part names that hold pose and target into two columns")


def test_faults_of_all_files_at_once(tmp_path: Path) -> None:
    toml = TOML.replace('on = "link_2"', 'on = "elbow"')
    poses = POSES.replace("b,-20", "a,x")
    points = POINTS.replace("600", "nan")
    assert faults(write_example(tmp_path, toml, poses, points)) == [
        "campaign.toml line 11: targets.T2.on: tiny has no link 'elbow'; "
        "one of ['flange', 'base', 'tool0', 'world_mount', 'link_1', 'link_2', 'link_3']",
        "poses.csv line 3: q1_deg is 'x', not a number; a pose needs all its joints",
        "poses.csv: pose_id 'a' twice, lines 2 and 3; every row is a pose with a name of its own",
        "points.csv line 5: z_mm is empty; "
        "leave x, y and z empty, or the line out, of a point that was not seen",
    ]


def test_a_wrong_robot_does_not_hide_the_faults_of_the_points(tmp_path: Path) -> None:
    toml = TOML.replace("robot/tiny.toml", "nobody")
    told = faults(write_example(tmp_path, toml, points=POINTS.replace("600", "x")))
    assert len(told) == 2
    assert told[0].startswith("campaign.toml line 3: robot = 'nobody': no such robot; known: ")


SCRAPS = [
    ",",
    ";",
    "\n",
    "",
    "nan",
    "1e999",
    '"',
    "a",
    "T1",
    "q1_deg",
    "_",
    "-",
    "x_mm",
    "heavy",
    "é",
    "\t",
    "[",
    "=",
]
CHANGES = st.lists(st.tuples(st.integers(0, 400), st.integers(0, 5), st.sampled_from(SCRAPS)), max_size=3)


@settings(max_examples=150, deadline=None)
@given(changes=st.tuples(CHANGES, CHANGES, CHANGES))
def test_whatever_the_files_hold_it_is_loaded_or_told(
    tmp_path_factory: pytest.TempPathFactory, changes: tuple[list[tuple[int, int, str]], ...]
) -> None:
    texts = []
    for text, edits in zip((TOML, POSES, POINTS), changes, strict=True):
        for start, length, scrap in edits:
            at = start % (len(text) + 1)
            text = text[:at] + scrap + text[at + length :]
        texts.append(text)
    path = write_example(tmp_path_factory.mktemp("scraps"), *texts)
    try:
        campaign = load_campaign(path)
    except InputError as error:
        told = [str(fault) for fault in error.faults]
    else:
        told = []
        assert np.isfinite(campaign.poses.q).all()
        assert np.array_equal(np.isfinite(campaign.points).all(axis=2), campaign.seen)
    assert not any("\n" in line for line in told)
