"""Measuring programs: the planned joints come back out of every format, each from its side."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from program_paths import read_program
from test_controller import MAKERS

from workbench.campaign.file import pose_columns
from workbench.cli.main import main
from workbench.correction.programs import Program, as_urdf, find_format, measuring_program
from workbench.files.faults import InputError
from workbench.files.tables import Layout, read_table
from workbench.robot.convention import Controller
from workbench.robot.description import load_robot


def planned_joints(name: str, count: int = 12) -> np.ndarray:
    robot, rng = load_robot(name), np.random.default_rng(3)
    lower, upper = (np.array([getattr(joint, side) for joint in robot.joints]) for side in ("lower", "upper"))
    return rng.uniform(0.9 * lower, 0.9 * upper, (count, len(lower)))


def measured(program: Program) -> Program:
    """The targets at which a measuring program stands still, without what it passes on the way to them."""
    still = program.dwell > 0
    return replace(program, q=program.q[still], dwell=program.dwell[still], time=None)


@pytest.mark.parametrize("name", MAKERS)
def test_the_joints_come_back_and_the_arm_stands_still_at_each(name: str) -> None:
    robot, format, q = load_robot(name), find_format(MAKERS[name][0]), planned_joints(name)
    sides = np.random.default_rng(4).choice([-1.0, 1.0], q.shape)
    program = measuring_program(robot, q, format, 2.5, sides=sides)
    assert format.check(program) == []
    back = as_urdf(format.read(format.write(program)), robot)
    assert back.q is not None
    still = measured(back)
    (_, joint) = format.joint_rounding()
    np.testing.assert_allclose(still.q, q, atol=3 * joint)
    assert still.dwell == pytest.approx(2.5)
    assert back.dwell[0::2].max() == 0
    step = back.q[1::2] - back.q[0::2]
    assert (np.sign(step) == sides).all()
    assert np.abs(np.degrees(step)) == pytest.approx(2.0, abs=1e-2)


def test_without_sides_every_joint_arrives_upwards_but_at_its_end() -> None:
    robot = load_robot("kr500")
    q = planned_joints("kr500")
    q[0, 0] = robot.joints[0].lower
    program = as_urdf(measuring_program(robot, q, find_format("krl")), robot)
    assert program.q is not None
    step = program.q[1::2] - program.q[0::2]
    assert (step > -1e-12).all()
    assert step[0, 0] == pytest.approx(0)


def test_what_cannot_be_measured() -> None:
    robot, q = load_robot("kr500"), planned_joints("kr500")
    with pytest.raises(InputError, match="pose 3: joint_2: is out of its range"):
        measuring_program(
            robot, np.where(np.arange(12)[:, None] * [0, 1, 0, 0, 0, 0] == 2, 9.0, q), find_format("krl")
        )
    with pytest.raises(InputError, match="dwell: is 0 s"):
        measuring_program(robot, q, find_format("krl"), 0)
    with pytest.raises(InputError, match="--as-urdf"):
        measuring_program(replace(robot, controller=Controller()), q, find_format("rapid"))
    assert measuring_program(
        replace(robot, controller=Controller()), q, find_format("rapid"), as_urdf=True
    ).notes


def test_plan_writes_poses_and_program(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "day_1"
    call = ["plan", "irb120", "--poses", "4", "--quick", "--format", "rapid", "--dwell", "3"]
    assert main([*call, "--json", "--out", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    names = ["poses.csv", "campaign.toml", "measure.mod", "index.html", "scene.html", "plan.json"]
    assert told["files"] == [str(out / name) for name in names]
    robot = load_robot("irb120")
    table = read_table(out / "poses.csv", Layout(), pose_columns(robot), "poses")
    q = np.stack([table.numbers[f"q{i}"] for i in range(1, 7)], axis=1)
    program = measured(as_urdf(read_program(out / "measure.mod", "rapid"), robot))
    np.testing.assert_allclose(program.q, q, atol=1e-5)
    assert program.dwell == pytest.approx(3 + 2 * 3.0)  # three reflectors
    (out / "measure.mod").write_text("mine")
    assert main([*call, "--out", str(out)]) == 2
    assert "measure.mod: is there already, with other content" in capsys.readouterr().err
    assert (out / "measure.mod").read_text() == "mine"


def test_poses_on_the_way_are_passed() -> None:
    robot, q = load_robot("irb120"), planned_joints("irb120", 4)
    via = [(), (q[0] / 2,), (), (q[1] / 2, q[2] / 2)]
    program = as_urdf(measuring_program(robot, q, find_format("rapid"), via=via), robot)
    assert program.q is not None
    assert program.dwell.tolist() == [0, 4, 0, 0, 4, 0, 4, 0, 0, 0, 4]
    np.testing.assert_allclose(program.q[[2, 7, 8]], [q[0] / 2, q[1] / 2, q[2] / 2], atol=1e-9)
    np.testing.assert_allclose(measured(program).q, q, atol=1e-9)


@pytest.mark.parametrize("n", [3, 4, 5])
def test_an_arm_of_fewer_joints_is_measured_where_its_controller_takes_them(n: int) -> None:
    """Fanuc has arms of four and five joints."""
    robot = load_robot("irb120")
    short = replace(robot, joints=robot.joints[:n])
    q = np.random.default_rng(n).uniform(-1.0, 1.0, (4, n))
    ls = find_format("ls")
    program = measuring_program(short, q, ls, as_urdf=True)
    if n < 4:
        (fault,) = ls.check(program)
        assert fault.what == "3 turning joints, Fanuc LS takes 4 to 6"
        return
    assert not ls.check(program)
    back = measured(ls.read(ls.write(program))).q
    np.testing.assert_allclose(back, q, atol=1e-5)
    (fault,) = find_format("krl").check(measuring_program(short, q, find_format("krl"), as_urdf=True))
    assert fault.what == f"{n} turning joints, KUKA KRL takes 6"
