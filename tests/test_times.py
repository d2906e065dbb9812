"""Times as instruments and controllers write them: read as seconds, found by `init`, joined to the poses."""

import numpy as np
import pytest
from campaign_example import BARE, POSES, write_example

from workbench import load_campaign, load_robot
from workbench.campaign.guess import guess_points, guess_poses
from workbench.cli.main import main
from workbench.files.clock import is_time, seconds
from workbench.robot.chain import read_chain
from workbench.robot.urdf import read_urdf


@pytest.mark.parametrize(
    ("cells", "apart"),
    [
        (["9:59:58", "10:00:00", "10:00:01.5"], [0, 2, 3.5]),
        (["23:59:50", "00:00:10", "00:01:10"], [0, 20, 80]),  # over midnight
        (["11:59:58 PM", "12:00:01 am", "1:00:00 AM"], [0, 3, 3602]),
        (["2026-11-30 14:03:05", "2026-11-30T14:03:07.25Z", "2026-12-01 14:03:05"], [0, 2.25, 86400]),
        (["30.11.2026 08:00:00,5", "30.11.2026 08:00:01,0", "01.12.2026 08:00:00,5"], [0, 0.5, 86400]),
        (["11/30/2026 1:00:00 PM", "11/30/2026 1:00:02 PM", "12/01/2026 1:00:00 PM"], [0, 2, 86400]),
        (["3/4/2026 10:00", "4/4/2026 10:00", "5/4/2026 10:30"], [0, 86400, 174600]),  # in April
        (["3/30/26 10:00", "3/31/26 10:00", "4/1/26 10:00"], [0, 86400, 172800]),
        (["10:00:00", "", "10:00:05"], [0, np.nan, 5]),
    ],
)
def test_times_are_seconds_from_the_earliest(cells, apart):
    assert all(is_time(cell) for cell in cells if cell)
    assert seconds(cells) == pytest.approx(apart, nan_ok=True)


@pytest.mark.parametrize(
    "cell", ["", "P1", "12", "12.5", "25:00:00", "10:61", "13:00 PM", "2026-13-40 10:00", "1:2:3"]
)
def test_what_is_no_time(cell):
    assert not is_time(cell)
    assert np.isnan(seconds([cell])).all()


STAMPED = """pose_id,x_mm,y_mm,z_mm,measured
a,1,2,3,2026-11-30 10:00:00
a,1,2,3,2026-11-30 10:00:04
b,4,5,6,2026-11-30 10:01:00
c,7,8,9,2026-11-30 10:02:00
"""


def test_the_instruments_times_are_those_of_the_poses(tmp_path):
    toml = BARE.format(poses="", points='columns = { t_clock = "measured" }\n')
    found = load_campaign(write_example(tmp_path, toml, POSES, STAMPED))
    assert found.poses.time == pytest.approx([2, 60, 120])
    header, *rows = POSES.splitlines()
    timed = "\n".join([f"{header},t_s", *(f"{row},{7 * i}" for i, row in enumerate(rows))]) + "\n"
    own = load_campaign(write_example(tmp_path / "own", toml, timed, STAMPED))
    assert own.poses.time == pytest.approx([0, 7, 14])


def test_what_is_no_time_is_told_with_its_line(tmp_path, capsys):
    toml = BARE.format(poses="", points='columns = { t_clock = "measured" }\n')
    bad = STAMPED.replace("10:01:00", "ten")
    assert main(["check", str(write_example(tmp_path, toml, POSES, bad))]) == 2
    assert (
        "points.csv line 4: t_clock ('measured') is '2026-11-30 ten', not a time" in capsys.readouterr().err
    )


@pytest.mark.parametrize(
    ("name", "stamps", "mapped"),
    [
        ("Measured at", [f"30.11.2026 10:{i:02d}:00" for i in range(12)], "t_clock"),
        ("Time", [f"1{i // 6}:{i % 6}0:00" for i in range(12)], "t_clock"),
        ("Time (s)", [f"{7.5 * i}" for i in range(12)], "t_s"),
        ("time_ms", [f"{7500 * i}" for i in range(12)], "t_ms"),
        ("timestamp", [f"{1.796e9 + 7.5 * i:.2f}" for i in range(12)], "t_s"),
        ("time", [f"{7.5 * i}" for i in range(12)], None),  # of no unit
        ("Time (s)", ["3", "1", "9", "2", "8", "1", "7", "5", "6", "2", "4", "1"], None),
        ("Time", ["10:00:00"] * 12, None),
    ],
)
def test_init_finds_the_time(tmp_path, name, stamps, mapped):
    rng = np.random.default_rng(0)
    places = [",".join(f"{v:.3f}" for v in row) for row in rng.uniform(-900, 900, (12, 3))]
    rows = "".join(f"P{i},{at},{t}\n" for i, (at, t) in enumerate(zip(places, stamps, strict=True)))
    (tmp_path / "t.csv").write_text(f"Point,X,Y,Z,{name}\n{rows}")
    found = guess_points(tmp_path / "t.csv")
    times = {key: where for key, where in found.keys["columns"].items() if key.startswith("t_")}
    assert times == ({} if mapped is None else {mapped: name})
    assert not found.lacking


def test_init_finds_the_time_of_a_controllers_log(tmp_path):
    rng = np.random.default_rng(1)
    rows = [
        ",".join([f"2026-11-30 10:{i:02d}:00", *(f"{v:.3f}" for v in row)])
        for i, row in enumerate(rng.uniform(-90, 90, (12, 6)))
    ]
    (tmp_path / "j.csv").write_text("\n".join(["Timestamp,J1,J2,J3,J4,J5,J6", *rows, ""]))
    robot = load_robot("ur5")
    joints = read_chain(read_urdf(robot.urdf), robot.flange).joints
    assert guess_poses(tmp_path / "j.csv", joints).keys["columns"]["t_clock"] == "Timestamp"
