"""Which column of an instrument's table names the pose, when the names of the poses are known."""

from __future__ import annotations

import pytest
from test_instrument_files import ANGLES, ARM, PLACES, cells
from test_program_joints import KRL, SIX

from workbench.campaign.guess import guess_points, guess_poses

COUNT = [str(i) for i in range(1, 13)]
NAMED = [f"P{i}" for i in COUNT]


def named_by(tmp_path, names, row, poses):
    """Columns of the pose and of the target in a table of names, with a row per pose and target."""
    rows = [row(i, t) + f",{cells(PLACES[i, t])}" for i in range(12) for t in range(3)]
    (tmp_path / "points.csv").write_text("\n".join([*([f"{names},X,Y,Z"] if names else []), *rows, ""]))
    columns = guess_points(tmp_path / "points.csv", poses).keys["columns"]
    return columns.get("pose_id"), columns.get("target")


@pytest.mark.parametrize("poses", [COUNT, NAMED])
def test_a_running_number_of_the_points_names_no_pose(tmp_path, poses):
    """A third of the points were taken to be of the poses of their number, the others left out."""
    found = named_by(tmp_path, "No,Reflector", lambda i, t: f"{3 * i + t + 1},T{t}", poses)
    assert found == (None, "Reflector")
    two = [f"{2 * i + t + 1},T{t},{cells(PLACES[i, t])}" for i in range(12) for t in range(2)]
    (tmp_path / "points.csv").write_text("\n".join(["No,Reflector,X,Y,Z", *two, ""]))
    assert "pose_id" not in guess_points(tmp_path / "points.csv", poses).keys["columns"]


def test_the_column_that_holds_the_names_of_the_poses_counts(tmp_path):
    """However it is called, and whichever comes first."""
    label = named_by(tmp_path, "Label,Reflector", lambda i, t: f"P{i + 1},T{t}", NAMED)
    assert label == ("Label", "Reflector")
    turned = named_by(tmp_path, "Group,Point", lambda i, t: f"T{t},P{i + 1}", NAMED)
    assert turned == ("Point", "Group")
    single = [f"Day {i % 2},P{i + 1},{cells(PLACES[i, 0])}" for i in range(12)]
    (tmp_path / "points.csv").write_text("\n".join(["Group,Point,X,Y,Z", *single, ""]))
    assert "target" not in guess_points(tmp_path / "points.csv", NAMED).keys["columns"]
    assert named_by(tmp_path, "", lambda i, t: f"T{t},{i + 1}", COUNT) == (2, 1)
    assert named_by(tmp_path, "", lambda i, t: f"T{t},{i + 1}", []) == (1, 2)


def test_what_happens_to_be_a_few_of_the_names_is_none(tmp_path):
    found = named_by(tmp_path, "Markers,Reflector", lambda i, t: f"{3 + i % 2},T{t}", COUNT)
    assert found == (None, "Reflector")


def test_names_that_agree_with_none_stay_what_they_are_called(tmp_path):
    """Reading the campaign tells both lists of names then."""
    assert named_by(tmp_path, "Name,SMR", lambda i, t: f"Q{i},T{t}", NAMED) == ("Name", "SMR")


def test_poses_tell_their_names(tmp_path):
    (tmp_path / "cal.dat").write_text(KRL)
    assert guess_poses(tmp_path / "cal.dat", SIX).ids == ["P1", "P2"]
    rows = [cells(row) for row in ANGLES]
    head = ",".join(f"J{j}" for j in range(1, 7))
    (tmp_path / "t.csv").write_text("\n".join([head, *rows, ""]))
    assert guess_poses(tmp_path / "t.csv", ARM).ids == COUNT
    named = [f"{name},{row}" for name, row in zip(NAMED, rows, strict=True)]
    (tmp_path / "t.csv").write_text("\n".join([f"Name,{head}", *named, ""]))
    assert guess_poses(tmp_path / "t.csv", ARM).ids == NAMED
