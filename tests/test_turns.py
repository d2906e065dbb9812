"""A 6-D measurement that says its turns by angles or a vector, in whichever order the instrument has them."""

import csv
import io

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench import load_campaign, load_robot, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.cli.main import main

CELL = Rotation.from_rotvec([0.3, -1.1, 2.0])  # of the robot's base in the instrument's frame
HELD = Rotation.from_rotvec([-0.7, 0.4, 1.3])  # of the probe on the flange
WAYS = ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "vector"]
TOML = """schema = 1
robot = "ur5"
[poses]
file = "poses.csv"
[points]
file = "points.csv"
turned_mm = 100
{more}
"""


def text(header, rows):
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([header, *rows])
    return out.getvalue()


@pytest.fixture(scope="module")
def arm():
    """Joints [rad], and where a nominal robot holds a probe [mm] and how."""
    robot = load_robot("ur5")
    job = problem_of(planned(robot, random_poses(robot, 25, np.random.default_rng(2))))
    turn = CELL * Rotation.from_matrix(job.rigid.R[-1]) * HELD
    off = 4e-4 * np.random.default_rng(3).normal(size=(25, 3))  # that it is not the nominal robot
    return job.q, 1e3 * CELL.apply(job.rigid.p[-1]) + [3000, 20, 500], turn * Rotation.from_rotvec(off)


def numbers(turn, way):
    if way == "vector":
        return np.degrees(turn.as_rotvec())
    found = turn.as_euler(way, degrees=True)
    return found[:, [way.index(axis) for axis in "xyz"]]


def written(folder, arm, angles, more="", names=("rx_deg", "ry_deg", "rz_deg"), keys=True):
    q, place, _ = arm
    folder.mkdir(exist_ok=True)
    ids = [f"p{i}" for i in range(len(q))]
    header = ["pose_id", *(f"q{j}_deg" for j in range(1, 7))]
    rows = [[name, *row] for name, row in zip(ids, np.degrees(q).round(6).tolist(), strict=True)]
    (folder / "poses.csv").write_text(text(header, rows))
    both = np.column_stack([place, angles]).round(6).tolist()
    rows = [[name, *row] for name, row in zip(ids, both, strict=True)]
    (folder / "points.csv").write_text(text(["pose_id", "x_mm", "y_mm", "z_mm", *names], rows))
    (folder / "campaign.toml").write_text(TOML.format(more=more))
    return folder / "campaign.toml"


def right(arm):
    _, place, turn = arm
    return place[:, None] + np.stack([0 * place, turn.apply([100, 0, 0]), turn.apply([0, 100, 0])], axis=1)


@pytest.mark.parametrize("way", WAYS)
def test_the_robot_tells_how_angles_turn(tmp_path, arm, way):
    path = written(tmp_path, arm, numbers(arm[2], way))
    found = load_campaign(path)
    assert found.six_dof
    assert 1e3 * found.points == pytest.approx(right(arm), abs=1e-3)
    assert any(f'say turns = "{way}" under [points]' in said for said in found.warnings)
    said = written(tmp_path, arm, numbers(arm[2], way), f'turns = "{way}"')
    again = load_campaign(said)
    assert np.array_equal(again.points, found.points)
    assert not again.warnings


def test_radians_and_points_in_order(tmp_path, arm):
    angles = np.radians(numbers(arm[2], "zyx"))
    path = written(tmp_path, arm, angles, names=("rx_rad", "ry_rad", "rz_rad"))
    rows = (tmp_path / "points.csv").read_text().splitlines()
    (tmp_path / "points.csv").write_text("".join(row.partition(",")[2] + "\n" for row in rows))
    assert 1e3 * load_campaign(path).points == pytest.approx(right(arm), abs=1e-2)


def test_angles_of_something_else_are_left_out_and_told(tmp_path, arm):
    angles = np.random.default_rng(5).uniform(-90, 90, (25, 3))
    found = load_campaign(written(tmp_path, arm, angles))
    assert not found.six_dof
    assert found.points.shape == (25, 1, 3)
    assert any("do not turn as the flange does" in said for said in found.warnings)
    assert not any("turned_mm = 100" in said for said in found.warnings)  # which is stated


def test_faults_of_turns(tmp_path, arm, capsys):
    angles = numbers(arm[2], "xyz")
    path = written(tmp_path, arm, angles, 'turns = "quaternion"')
    assert main(["check", str(path)]) == 2
    assert "no column qw, qx, qy, qz" in capsys.readouterr().err
    path = written(tmp_path, arm, angles, 'turns = "xyx"')
    assert main(["check", str(path)]) == 2
    assert "points.turns" in capsys.readouterr().err
    angles = np.array(angles)
    angles[4, 1] = np.nan
    path = written(tmp_path, arm, angles, 'turns = "xyz"')
    (tmp_path / "points.csv").write_text((tmp_path / "points.csv").read_text().replace("nan", ""))
    assert main(["check", str(path)]) == 2
    assert "line 6: rx_deg or one of the two beside it is empty" in capsys.readouterr().err
