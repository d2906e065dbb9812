"""Paths and calls that cannot be: each fault by line, with its reason; nothing written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from extended_example import extended, extended_kr500
from program_paths import read_program

from workbench.campaign.planned import planned
from workbench.correction.command import compensate
from workbench.correction.conditions import Conditions, conditions_of
from workbench.correction.file import compensate_file
from workbench.correction.path_shapes import Run, circle, line, work_frame
from workbench.correction.paths import Path, write_path
from workbench.correction.programs import formats
from workbench.correction.trajectory import nominal_joints
from workbench.effects.gear_eccentricity import GearEccentricity
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.place import Where
from workbench.files.faults import InputError
from workbench.identification.model_file import write_model
from workbench.robot.description import Robot, load_robot
from workbench.robot.rigid_plant import arrays
from workbench.robot.rotations import angle_between
from workbench.simulation.random_robot import write_random_robot

WORK = work_frame([1.8, 0.2, 0.8])
CIRCLE = circle(0.1, Run(WORK, speed=0.1, period=0.05))
POSTURE = np.array([0.0, -1.2, 1.6, 0.1, 0.8, 0.0])


@pytest.fixture(scope="module")
def kr500() -> Robot:
    return extended_kr500()


def faults_of(robot: Robot, path: Path, **options: object) -> list[str]:
    with pytest.raises(InputError) as caught:
        compensate(robot, path, **options)  # type: ignore[arg-type]
    return [str(fault) for fault in caught.value.faults]


def test_out_of_reach_by_line(kr500: Robot) -> None:
    path = line(3.0, Run(work_frame([1.5, 0.0, 1.0]), speed=1.0, period=0.05))
    told = faults_of(kr500, path)
    first = int(told[0].split("line ")[1].split(":")[0])
    assert path.X is not None
    assert 2.0 < path.X[first - 2, 0, 3] < 3.0
    assert told[0].startswith(f"line.csv line {first}: the tool cannot get there")
    assert len(told) == 11
    assert "more like this up to here" in told[-1]
    assert told[-1].startswith(f"line.csv line {len(path) + 1}:")
    listed = replace(path, file="mine.csv", lines=tuple(range(10, 10 + len(path))))
    assert faults_of(kr500, listed)[0].startswith(f"mine.csv line {first + 8}:")


def test_an_arm_that_finds_no_rest_is_not_told_to_move_the_path(kr500: Robot) -> None:
    """Its path is well: a stiffness is not."""
    weak = JointCompliance(Where(joint="joint_2"), nominal=1e-7)
    told = faults_of(extended(load_robot("kr500"), [(weak, [1e5])]), CIRCLE)
    assert "the loaded arm finds no rest" in told[0]
    assert "check stiffness" in told[0]
    assert "move the path" not in told[0]


def test_out_of_range_names_joint_and_limit(kr500: Robot) -> None:
    q = np.linspace(POSTURE, POSTURE + 1.2 * np.eye(6)[2], 20)
    told = faults_of(kr500, Path(np.arange(20.0), q=q))
    assert "joint_3 at" in told[0]
    assert "upper limit 144.000" in told[0]
    # the path is inside, its correction is not
    edge = np.tile(POSTURE, (3, 1))
    edge[:, 0] = kr500.joints[0].upper - np.array([1e-2, 1e-6, 1e-2])
    pushed = extended(kr500, [(GearEccentricity(Where(joint="joint_1"), "1"), [0.0, 1e-3])], size=0.0)
    told = faults_of(pushed, Path(np.arange(3.0), q=edge))
    assert told == [told[0]]
    assert told[0].startswith("path.csv line 3: the corrected command: joint_1 at")


def test_velocity_and_singular_samples_are_named_not_clipped(kr500: Robot) -> None:
    q = np.linspace(POSTURE, POSTURE + 0.3 * np.eye(6)[0], 10)
    time = np.arange(10.0)
    time[5:] -= 0.99
    done = compensate(kr500, Path(time, q=q))
    (fast,) = (trouble for trouble in done.troubles if trouble.kind == "velocity")
    assert fast.index == 5
    assert "joint_1 at 19" in fast.what
    assert "limit 84.0" in fast.what
    through = np.tile(POSTURE, (21, 1))
    through[:, 4] = np.linspace(0.101, 0.011, 21)
    done = compensate(kr500, Path(np.arange(21.0), q=through))
    singular = [trouble.index for trouble in done.troubles if trouble.kind == "singular"]
    assert singular == list(range(singular[0], 21))
    assert 10 < singular[0] < 20
    assert all("joint_4 and joint_6" in trouble.what for trouble in done.troubles)
    assert done.after_mm.max() < 1e-6
    assert any("singular" in text for text in done.lines())


def test_a_singular_sample_that_cannot_be_corrected(kr500: Robot) -> None:
    q = np.tile(POSTURE, (3, 1))
    q[1, 4] = 0.0
    told = faults_of(kr500, Path(np.arange(3.0), q=q))
    assert told[0].startswith("path.csv line 3: the correction cannot be made here (near-singular)")
    assert len(told) == 1


def test_numbers_time_and_shape(kr500: Robot) -> None:
    assert CIRCLE.X is not None
    X, time = CIRCLE.X.copy(), CIRCLE.time.copy()
    X[4, 0, 3] = np.nan
    time[7] = np.inf
    told = faults_of(kr500, replace(CIRCLE, X=X, time=time))
    assert [text[:18] for text in told] == ["circle.csv line 9:", "circle.csv line 6:"]
    time = CIRCLE.time.copy()
    time[3] = time[1]
    assert "line 5: t_s is" in faults_of(kr500, replace(CIRCLE, time=time))[0]
    X = CIRCLE.X.copy()
    X[2, :3, :3] *= 1.01
    assert "line 4: the orientation is no rotation" in faults_of(kr500, replace(CIRCLE, X=X))[0]
    assert "both" in faults_of(kr500, replace(CIRCLE, q=np.zeros((len(CIRCLE), 6))))[0]
    assert "another robot" in faults_of(kr500, Path(np.arange(3.0), q=np.zeros((3, 7))))[0]
    assert "one sample" in faults_of(kr500, Path(np.zeros(1), q=np.zeros((1, 6))))[0]
    assert "no pose" in faults_of(kr500, CIRCLE, tool=np.eye(3))[0]


def test_wrong_units_are_guessed(kr500: Robot) -> None:
    assert CIRCLE.X is not None
    for factor, name in ((1e-3, "x_m y_m"), (1e3, "x_mm y_mm")):
        X = CIRCLE.X.copy()
        X[:, :3, 3] *= factor
        (told,) = faults_of(kr500, replace(CIRCLE, X=X))
        assert name in told
        assert "the arm reaches" in told
    q = np.rad2deg(np.linspace(POSTURE, POSTURE + 0.1, 5))
    (told,) = faults_of(kr500, Path(np.arange(5.0), q=q))
    assert "q1_deg" in told


def test_radians_of_another_arm_are_not_taken_for_degrees(kr500: Robot) -> None:
    told = faults_of(kr500, Path(np.arange(3.0), q=np.tile(POSTURE - 3.0 * np.eye(6)[1], (3, 1))))
    assert "joint_2 at" in told[0]
    assert not any("degrees?" in text for text in told)


def test_calls_that_are_wrong(kr500: Robot) -> None:
    assert "one of exact" in faults_of(kr500, CIRCLE, method="magic")[0]
    assert "bandwidth" in faults_of(kr500, CIRCLE, bandwidth_hz=0.0)[0]
    assert "shape" in faults_of(kr500, CIRCLE, conditions=Conditions(wrench=np.zeros((3, 6))))[0]
    assert "NaN" in faults_of(kr500, CIRCLE, conditions=Conditions(temperature=np.nan))[0]
    assert "mass" in faults_of(kr500, CIRCLE, conditions=Conditions("heavy", -1.0))[0]
    assert "name it" in faults_of(kr500, CIRCLE, conditions=Conditions(payload_mass=3.0))[0]
    light = {"light": (5.0, (0.0, 0.0, 0.1))}
    campaign = planned(kr500, POSTURE[None], payloads=light, tool=(2.0, (0, 0, 0.05)))
    stated = conditions_of(campaign, "light")
    assert (stated.payload_mass, stated.tool_mass, list(stated.payload_com)) == (5.0, 2.0, [0.0, 0.0, 0.1])
    with pytest.raises(InputError, match="known: light"):
        conditions_of(campaign, "heavy")
    robot = extended(kr500, [])
    robot = replace(robot, effects=tuple(replace_joint(item) for item in kr500.effects[:1]))
    assert "joint_9" in faults_of(robot, CIRCLE)[0]


def replace_joint(item):
    return item.model_copy(update={"joint": "joint_9"})


def test_an_arm_of_two_joints(kr500: Robot) -> None:
    few = replace(kr500, joints=kr500.joints[:2])
    assert few.joint_names == ("joint_1", "joint_2")
    from workbench.correction.check import check_path

    with pytest.raises(InputError, match="takes three"):
        check_path(few, arrays(kr500), Path(np.arange(2.0), q=np.zeros((2, 2))), np.eye(4))


def model_file(folder: FilePath, robot: Robot) -> FilePath:
    write_model(folder / "model.toml", robot, arrays(robot).geometry, robot.effects)
    return folder / "model.toml"


@pytest.mark.parametrize("format", sorted(formats()))
def test_from_file_to_program_and_back(tmp_path: FilePath, kr500: Robot, format: str) -> None:
    tool = np.eye(4)
    tool[:3, 3] = [0.1, 0.0, 0.2]
    write_path(tmp_path / "ring.csv", CIRCLE)
    conditions = Conditions("heavy", 250.0, (0.15, 0.0, 0.05), temperature=25.0)
    written = compensate_file(
        tmp_path / "ring.csv",
        model_file(tmp_path, kr500),
        format,
        tmp_path / f"ring_new{next(f.extension for f in formats().values() if f.name == format)}",
        conditions=conditions,
        tool=tool,
    )
    done = written.compensation
    assert done.after_mm.max() < 1e-6
    back = read_program(written.files[0], format)
    assert back.X is not None
    assert len(back.X) == len(CIRCLE)
    flange = back.X @ np.linalg.inv(back.tool if formats()[format].carries_tool else tool) @ tool
    error = 1e3 * np.linalg.norm((flange - done.X_command)[:, :3, 3], axis=1)
    assert error.max() <= written.rounding.max_mm * 1.01 + 1e-9
    assert angle_between(flange[:, :3, :3], done.X_command[:, :3, :3]).max() < 2e-5
    assert any("rounding" in text for text in written.lines())
    told = [text for text in written.warnings if "the controller is of KUKA" in text]
    assert bool(told) == (format not in ("csv", "krl"))
    # the controller's nominal inverse of what it reads is the command
    if format == "csv":
        again = nominal_joints(kr500, Path(CIRCLE.time, X=back.X), tool=tool, start=done.q_command[0])
        assert np.abs(again - done.q_command).max() < 1e-6


def test_a_dwell_of_the_path_is_in_the_program(tmp_path: FilePath, kr500: Robot) -> None:
    few = replace(
        CIRCLE, time=10.0 * np.arange(len(CIRCLE)), dwell=np.where(np.arange(len(CIRCLE)) == 3, 2.5, 0.0)
    )
    write_path(tmp_path / "ring.csv", few)
    model = model_file(tmp_path, kr500)
    (written,) = compensate_file(tmp_path / "ring.csv", model, "krl", tmp_path / "RING.src").files
    assert written.read_text().count("WAIT SEC 2.500") == 1
    assert few.dwell is not None
    np.testing.assert_allclose(read_program(written, "krl").dwell, few.dwell)


def test_joints_in_joints_out_for_seven(tmp_path: FilePath) -> None:
    robot = load_robot(write_random_robot(tmp_path, 4, "7R"))
    q = np.linspace([0.2, 0.6, 0.1, 0.9, -0.3, 0.7, 0.2], [0.5, 0.4, 0.3, 1.1, -0.1, 0.8, 0.0], 20)
    write_path(tmp_path / "seven.csv", Path(np.arange(20.0), q=q))
    bent = extended(robot, [])
    model = model_file(tmp_path, bent)
    written = compensate_file(tmp_path / "seven.csv", model)
    assert written.files == (tmp_path / "seven_compensated.csv",)
    back = read_program(written.files[0], "csv")
    assert back.q is not None
    assert np.abs(back.q - written.compensation.q_command).max() < 1e-9
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match="7 turning joints"):
        compensate_file(tmp_path / "seven.csv", model, "krl", tmp_path / "seven.src")
    with pytest.raises(InputError, match="no such format"):
        compensate_file(tmp_path / "seven.csv", model, "gcode")
    (tmp_path / "bad.csv").write_text("t_s,q1_deg\n0,1\n1,x\n")
    with pytest.raises(InputError, match="line 3"):
        compensate_file(tmp_path / "bad.csv", model)
    (tmp_path / "bad.csv").unlink()
    assert sorted(tmp_path.iterdir()) == before
