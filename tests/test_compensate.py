"""Compensated commands put the tool on the path in Drake's own equilibrium; what cannot be run is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from extended_example import extended, extended_kr500
from scipy.spatial.transform import Rotation, Slerp

from workbench.campaign import Target
from workbench.campaign.planned import planned
from workbench.campaign.problem import problem_of
from workbench.correction.command import Compensation, compensate
from workbench.correction.conditions import Conditions
from workbench.correction.path_shapes import Run, pocket, raster, spiral, work_frame
from workbench.correction.paths import Path
from workbench.correction.programs import RoundingEffect
from workbench.correction.solve import turning_sides
from workbench.correction.trajectory import nominal_joints, trajectory_of
from workbench.effects.backlash import Backlash
from workbench.effects.gear_eccentricity import GearEccentricity
from workbench.effects.gear_kinematic_error import GearKinematicError
from workbench.effects.gear_ratio import GearRatio
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.joint_map import JointMap
from workbench.effects.place import Where
from workbench.effects.thermal_growth import ThermalGrowth
from workbench.files.faults import InputError
from workbench.robot.description import Robot, load_robot
from workbench.robot.rotations import pose, rotation_about
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, simulate

HEAVY = Conditions("heavy", 250.0, (0.15, 0.0, 0.05), 60.0, (0.05, 0.0, 0.1), temperature=28.0)
TOOL = np.eye(4)
TOOL[:3, 3] = [0.1, 0.02, 0.25]
WORK = work_frame([1.8, 0.2, 0.8])
SPIRAL = spiral(Run(WORK, speed=0.03, acceleration=0.1, period=0.05))
CORNERS = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0]])


def in_drake(robot: Robot, done: Compensation, conditions: Conditions, every: int) -> np.ndarray:
    """Distance [m] of three points of the tool from where they should be, at some samples."""
    some = np.unique(np.append(np.arange(0, len(done.path), every), len(done.path) - 1))
    corners = CORNERS @ done.tool[:3, :3].T + done.tool[:3, 3]
    payloads = {conditions.payload: (conditions.payload_mass, conditions.payload_com)}
    wrench = done.path.wrench if done.path.wrench is not None else conditions.wrench
    plan = planned(
        robot,
        done.q_command[some],
        targets=tuple(Target(f"T{i}", tuple(corner)) for i, corner in enumerate(corners)),
        payloads=payloads if conditions.payload else None,
        payload=[conditions.payload] * len(some) if conditions.payload else None,
        tool=(conditions.tool_mass, conditions.tool_com),
        wrench=None if wrench is None else np.broadcast_to(wrench, (len(done.path), 6))[some],
        direction=None if done.direction is None else done.direction[some],
        temperature=None if conditions.temperature is None else np.full(len(some), conditions.temperature),
    )
    still = Truth(repeatability=np.zeros(len(robot.joints)))
    seen = simulate(plan, still, instrument=(np.eye(3)[None], np.zeros((1, 3)))).points
    wanted = np.einsum("nij,tj->nti", done.X_desired[some][:, :3, :3], CORNERS)
    return np.linalg.norm(seen - wanted - done.X_desired[some][:, None, :3, 3], axis=2)


def test_kr500_with_everything_draws_the_spiral_in_drake() -> None:
    robot = extended_kr500()
    conditions = replace(HEAVY, wrench=[120.0, -40.0, -200.0, 5.0, 0.0, 10.0])
    done = compensate(robot, SPIRAL, conditions, tool=TOOL)
    assert done.before_mm.max() > 2.0
    assert done.after_mm.max() < 1e-6
    assert not done.left_out
    assert in_drake(robot, done, conditions, 20).max() < 1e-8
    # and the uncorrected command is as far off as the model says
    plain = replace(done, q_command=done.q_nominal, direction=turning_sides(done.q_nominal))
    assert in_drake(robot, plain, conditions, 200)[:, 0] == pytest.approx(
        1e-3 * done.before_mm[np.unique(np.append(np.arange(0, len(SPIRAL), 200), len(SPIRAL) - 1))], abs=1e-7
    )


def test_what_is_left_between_the_points_is_what_drake_has_there() -> None:
    """A straight line of three points: as the controller joins them, halfway."""
    robot = extended_kr500(ripple=0.0)
    assert SPIRAL.X is not None
    X = np.repeat(SPIRAL.X[:1], 3, axis=0)
    X[:, 0, 3] += [0.0, 0.4, 0.8]
    path = Path(np.array([0.0, 4.0, 8.0]), X=X)
    done = compensate(robot, path, HEAVY, tool=TOOL)
    assert done.between_mm > 0.01
    assert any("left halfway" in line for line in done.lines())
    middle = 0.5 * (done.X_command[1:, :3, 3] + done.X_command[:-1, :3, 3])
    turns = Rotation.from_matrix(done.X_command[:, :3, :3])
    turn = [Slerp([0, 1], turns[[i, i + 1]])(0.5).as_matrix() for i in range(2)]
    told = Path(path.time[1:], X=pose(middle, np.array(turn)))
    q = nominal_joints(robot, told, TOOL, start=done.q_command[0])
    wanted = replace(
        done, path=told, q_command=q, X_desired=X[1:] * 0.5 + X[:-1] * 0.5, direction=done.direction[1:]
    )
    assert in_drake(robot, wanted, HEAVY, 1)[:, 0] == pytest.approx(done.between, rel=1e-3)


def test_a_load_or_a_robot_that_was_not_measured_is_said() -> None:
    robot = load_robot("kr500")
    assert any("nothing in this model was identified" in n for n in compensate(robot, SPIRAL, HEAVY).notes)
    known = extended_kr500()
    assert not any("identified" in note for note in compensate(known, SPIRAL, HEAVY).notes)


def test_first_order_methods_are_worse_but_close() -> None:
    robot = extended_kr500(ripple=0.0)
    error = {
        method: compensate(robot, SPIRAL, HEAVY, tool=TOOL, method=method).after_mm.max()
        for method in ("exact", "mirror", "double", "geometry")
    }
    before = compensate(robot, SPIRAL, HEAVY, tool=TOOL).before_mm.max()
    assert error["exact"] < 1e-6
    for method in ("mirror", "double"):
        assert 100 * error["exact"] < error[method] < 0.02 * before
    assert error["geometry"] > 10 * error["mirror"]


def test_joint_correction_of_source_003_takes_joint_errors_only() -> None:
    robot = load_robot("kr500")
    gears = extended(
        robot,
        [
            (GearEccentricity(Where(joint="joint_2"), "1"), [1e-4, 5e-5]),
            (JointCompliance(Where(joint="joint_3"), nominal=1 / 5.83e6), [0.3]),
        ],
        size=0.0,
    )
    done = compensate(gears, SPIRAL, HEAVY, method="joint")
    assert done.after_mm.max() < 0.02 * done.before_mm.max()
    with_geometry = extended(robot, [], size=5e-4)
    done = compensate(with_geometry, SPIRAL, Conditions(), method="joint")
    assert done.after_mm.max() > 0.3 * done.before_mm.max()


def test_wrench_per_point_and_payload_change_the_command() -> None:
    robot = extended_kr500(ripple=0.0)
    push = np.zeros((len(SPIRAL), 6))
    push[:, 0] = 800 * np.sin(SPIRAL.time)
    pushed = compensate(robot, replace(SPIRAL, wrench=push), HEAVY, tool=TOOL)
    assert in_drake(robot, pushed, HEAVY, 100).max() < 1e-8
    free = compensate(robot, SPIRAL, HEAVY, tool=TOOL)
    assert np.abs(pushed.X_command - free.X_command)[:, :3, 3].max() > 1e-4
    with pytest.raises(InputError, match="of its own"):
        compensate(robot, replace(SPIRAL, wrench=push), replace(HEAVY, wrench=[1.0] * 6))


def test_seven_joints_keep_their_redundancy(tmp_path) -> None:
    robot = load_robot(write_random_robot(tmp_path, 4, "7R"))
    q = np.linspace([0.2, 0.6, 0.1, 0.9, -0.3, 0.7, 0.2], [0.5, 0.4, 0.3, 1.1, -0.1, 0.8, 0.0], 200)
    path = Path(np.linspace(0, 10, 200), q=q)
    bent = extended(robot, [(GearRatio(Where(joint="joint_3")), [2e-4])])
    done = compensate(bent, path)
    assert done.after_mm.max() < 1e-6
    assert np.array_equal(done.q_nominal, q)
    assert in_drake(bent, done, Conditions(), 20).max() < 1e-8
    # the correction has nothing along the null space of the nominal arm
    trajectory = trajectory_of(bent, path, Conditions())
    null = np.linalg.svd(trajectory.jacobian(slice(None)))[2][:, -1]
    change = done.q_command - q
    along = np.abs(np.einsum("ni,ni->n", null, change))
    assert along.max() < 0.02 * np.linalg.norm(change, axis=1).max()
    # and tool poses alone give a joint path without jumps, near the given start
    poses = Path(path.time, X=done.X_desired)
    found = nominal_joints(bent, poses, start=q[0])
    assert np.abs(found[0] - q[0]).max() < 1e-9
    assert np.abs(np.diff(found, axis=0)).max() < 5 * np.abs(np.diff(q, axis=0)).max()


@pytest.mark.parametrize("name", ["PRRR", "cylindrical"])
def test_sliding_joints_and_few_joints_follow_the_position(tmp_path, name: str) -> None:
    robot = load_robot(write_random_robot(tmp_path, 2, name) if name == "PRRR" else name)
    n = len(robot.joints)
    q = np.linspace(np.full(n, 0.2), np.full(n, 0.4), 150)
    path = Path(np.linspace(0, 10, 150), q=q)
    case = problem_of(planned(robot, q))
    screw = next(one for one in JointMap.places(case) if one.sliding and one.variant == "smooth")
    run_out = GearEccentricity(Where(joint=robot.joint_names[-1 if n == 4 else 0]), "1")
    bent = extended(robot, [(run_out, [2e-4, 0.0]), (screw, [0.0, 2e-4, *[0.0] * (len(screw.params) - 2)])])
    done = compensate(bent, path, Conditions(tool_mass=5.0))
    assert done.position_only
    turned = 1e3 * np.linalg.norm(done.after[:, 3:], axis=1).max()
    assert any(f"it stays off by up to {turned:.2g} mrad" in line for line in done.lines())
    assert done.before_mm.min() > 0.1
    assert done.after_mm.max() < 1e-6
    assert in_drake(bent, done, Conditions(tool_mass=5.0), 15)[:, 0].max() < 1e-8
    back = nominal_joints(robot, Path(path.time, X=done.X_desired), start=q[0])
    assert np.abs(back - q).max() < 1e-9
    program = done.program("A", "joints")
    assert program.sliding == tuple(joint.kind == "prismatic" for joint in robot.joints)


SCARA = """<robot name="scara"><link name="base"/>
  <link name="arm"/><link name="forearm"/><link name="spindle"/><link name="quill"/>
  <joint name="J1" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint>
  <joint name="J2" type="revolute"><parent link="arm"/><child link="forearm"/><origin xyz="0.3 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5"/></joint>
  <joint name="R" type="revolute"><parent link="forearm"/><child link="spindle"/><origin xyz="0.25 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
  <joint name="Z" type="prismatic"><parent link="spindle"/><child link="quill"/>
    <axis xyz="0 0 -1"/><limit lower="0" upper="0.2"/></joint></robot>"""


def test_four_joints_turn_the_tool_as_far_as_they_can(tmp_path) -> None:
    """A SCARA's turn about the vertical is wanted, followed and corrected; its tilt nobody can."""
    (tmp_path / "scara.urdf").write_text(SCARA)
    (tmp_path / "scara.toml").write_text('schema=1\nname="scara"\nurdf="scara.urdf"\nflange="quill"\n')
    robot = load_robot(tmp_path / "scara.toml")
    q = np.linspace([0.2, 0.5, -1.0, 0.02], [0.8, 1.1, 1.0, 0.15], 80)
    bent = extended(robot, [], size=1e-3)
    done = compensate(bent, Path(np.linspace(0, 4, 80), q=q))
    assert np.abs(done.before[:, 5]).min() > 1e-3
    assert done.after_mm.max() < 1e-6
    assert np.abs(done.after[:, 5]).max() < 1e-5  # the tilt's square is left of it
    assert 1e-3 < np.linalg.norm(done.after[:, 3:5], axis=1).max() < 2e-3
    poses = Path(np.linspace(0, 4, 80), X=done.X_desired)
    assert poses.X is not None
    assert np.abs(nominal_joints(robot, poses, start=q[0]) - q).max() < 1e-9
    assert compensate(bent, poses).after[:, 5] == pytest.approx(0, abs=1e-5)
    spun = np.linspace([0.3, 0.9, -2.0, 0.1], [0.3, 0.9, 2.0, 0.1], 80)  # in one place
    turns = compensate(bent, Path(np.linspace(0, 4, 80), q=spun)).X_desired
    assert np.abs(nominal_joints(robot, Path(poses.time, X=turns), start=spun[0]) - spun).max() < 1e-9
    # poses that no SCARA can take are reached, as near as their turn about the vertical allows
    far = poses.X.copy()
    far[:, :3, :3] = rotation_about("x", 0.5) @ far[:, :3, :3]
    off = compensate(bent, Path(poses.time, X=far))
    assert off.after_mm.max() < 1e-6
    assert np.linalg.norm(off.after[:, 3:], axis=1).max() < 0.51


def test_six_joints_of_which_four_are_parallel_are_no_six(tmp_path) -> None:
    """A palletizer whose rods have columns of their own: a roll that no joint makes is not asked for."""
    urdf = """<robot name="pal"><link name="l0"/>"""
    for i, (xyz, axis) in enumerate(
        [("0 0 .6", "0 0 1"), (".3 0 .2", "0 1 0"), ("0 0 1.2", "0 1 0"), ("0 0 0", "0 1 0"),
         ("1.3 0 0", "0 1 0"), (".2 0 -.1", "0 0 -1")]
    ):  # fmt: skip
        urdf += f"""<link name="l{i + 1}"/><joint name="q{i + 1}" type="continuous"><parent link="l{i}"/>
          <child link="l{i + 1}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/></joint>"""
    (tmp_path / "pal.urdf").write_text(urdf + "</robot>")
    (tmp_path / "pal.toml").write_text('schema=1\nname="pal"\nurdf="pal.urdf"\nflange="l6"\n')
    robot = extended(load_robot(tmp_path / "pal.toml"), [])
    q = np.linspace([0.1, 0.2, -0.2, 0.5, -0.5, 0.3], [0.6, 0.5, -0.5, 0.2, -0.2, 0.9], 40)
    done = compensate(robot, Path(np.linspace(0, 4, 40), q=q))
    assert done.position_only
    assert done.after_mm.max() < 1e-6
    assert np.linalg.norm(done.after[:, 3:], axis=1).max() < np.linalg.norm(done.before[:, 3:], axis=1).max()


def test_branch_is_that_of_the_start_and_stays() -> None:
    robot = load_robot("kr500")
    path = raster(0.6, 0.4, 0.05, Run(work_frame([1.4, -0.2, 0.9]), speed=0.3, period=0.01))
    default = nominal_joints(robot, path)
    assert np.abs(np.diff(default, axis=0)).max() < 0.05
    flipped = default[0] + [0, 0, 0, np.pi, 0, 0]
    flipped[3] -= 2 * np.pi * np.round(flipped[3] / (2 * np.pi))
    flipped[4] = -flipped[4]
    other = nominal_joints(robot, path, start=flipped)
    assert np.sign(other[:, 4]).tolist() == [np.sign(flipped[4])] * len(path)
    assert np.abs(np.diff(other, axis=0)).max() < 0.05
    again = nominal_joints(robot, path)
    assert np.array_equal(default, again)


def test_sides_of_approach() -> None:
    q = np.array([0.0, 0.0, 1.0, 1.0 - 1e-8, 2.0, 2.0, 1.5, 1.0, 1.0, 1.5])
    assert turning_sides(q[:, None])[:, 0].tolist() == [1, 1, 1, 1, 1, 1, -1, -1, -1, 1]
    assert turning_sides(-q[:, None])[:, 0].tolist() == [-1, -1, -1, -1, -1, -1, 1, 1, 1, -1]
    assert not turning_sides(np.zeros((5, 1))).any()
    rng = np.random.default_rng(0)
    noisy = np.cumsum(np.abs(rng.normal(size=100))) * 1e-3 + 1e-8 * rng.normal(size=100)
    assert (turning_sides(noisy[:, None]) == 1).all()


def test_backlash_is_commanded_from_the_side_the_arm_goes_to() -> None:
    robot = load_robot("kr500")
    loose = extended(robot, [(Backlash(Where(joint="joint_1")), [1e-4])], size=0.0)
    there = np.concatenate([np.linspace(-0.2, 0.2, 100), np.linspace(0.2, -0.2, 100)[1:]])
    q = np.tile([0.0, -1.2, 1.6, 0.1, 0.8, 0.0], (199, 1))
    q[:, 0] = there
    done = compensate(loose, Path(np.arange(199.0), q=q))
    shift = done.q_command[:, 0] - compensate(replace(loose, effects=()), done.path).q_command[:, 0]
    assert shift[:100] == pytest.approx(1e-4, abs=1e-9)
    assert shift[100:] == pytest.approx(-1e-4, abs=1e-9)
    assert in_drake(loose, done, Conditions(), 30).max() < 1e-8


def test_a_ripple_too_fast_is_left_out_and_said() -> None:
    robot = extended(
        load_robot("kr500"),
        [(GearKinematicError(Where(joint="joint_1", order=460.0)), [5e-5, 0.0])],
        size=0.0,
    )
    q = np.tile([0.0, -1.2, 1.6, 0.1, 0.8, 0.0], (2000, 1))
    time = 0.002 * np.arange(2000)
    speed = np.where(time < 2, 0.1, 0.5)  # 7 Hz, then 37 Hz
    q[:, 0] = np.cumsum(speed) * 0.002 - 0.5
    path = Path(time, q=q)
    done = compensate(robot, path)
    (left,) = done.left_out
    assert left.highest_hz == pytest.approx(460 * 0.5 / (2 * np.pi), rel=1e-3)
    assert left.spans == ((999, 1999),)
    lever = np.linalg.norm(done.X_desired[0, :2, 3])
    assert left.max_mm == pytest.approx(1e3 * lever * 5e-5, rel=0.01)
    assert done.after_mm[:990].max() < 1e-6
    assert done.after_mm.max() == pytest.approx(left.max_mm, rel=0.01)
    assert any("left out" in text for text in done.lines())
    all_of_it = compensate(robot, path, bandwidth_hz=100.0)
    assert not all_of_it.left_out
    assert all_of_it.after_mm.max() < 1e-6
    coarse = compensate(robot, Path(time[::50], q=q[::50]), bandwidth_hz=100.0)
    assert any("samples per cycle" in note for note in coarse.notes)
    lines = [
        (GearKinematicError(Where(joint="joint_1", order=order)), [5e-5, 0.0]) for order in (230.0, 460.0)
    ]
    several = compensate(
        extended(load_robot("kr500"), lines, size=0.0), Path(time[::50], q=q[::50]), bandwidth_hz=100.0
    )
    (said,) = (note for note in several.notes if "samples per cycle" in note)  # the faster one's
    assert said.startswith("gear_kinematic_error(joint_1): down to 0.27 samples per cycle")
    assert said.endswith("30 times as closely")


def test_temperature_and_time_that_are_not_given_are_said() -> None:
    robot = extended(load_robot("kr500"), [(ThermalGrowth(), [1.2e-5])], size=0.0)
    cold = compensate(robot, SPIRAL)
    assert any("20 °C" in note for note in cold.notes)
    warm = compensate(robot, SPIRAL, Conditions(temperature=30.0))
    assert not any("20 °C" in note for note in warm.notes)
    growth = 10 * 1.2e-5 * np.linalg.norm(cold.X_desired[0, :3, 3])
    shift = np.linalg.norm((warm.X_command - cold.X_command)[:, :3, 3], axis=1)
    assert shift == pytest.approx(growth, rel=0.1)
    assert warm.after_mm.max() < 1e-6


def test_shapes_with_corners_come_out_exact() -> None:
    robot = extended_kr500(ripple=5e-5)
    path = pocket(0.2, 0.12, 0.03, Run(WORK, speed=0.05, acceleration=0.5, period=0.02))
    done = compensate(robot, path, HEAVY, tool=TOOL)
    assert done.after_mm.max() < 1e-6


def test_what_is_left_is_said_as_far_as_anybody_can_know_it() -> None:
    """The exact correction leaves 1e-9 mm of the model's own errors: no accuracy of a robot."""
    robot = extended(load_robot("irb120"), [])
    q = np.linspace([0.0, 0.2, -0.4, 0.2, 0.5, 0.1], [0.2, 0.3, -0.3, 0.3, 0.6, 0.2], 9)
    first, second, *_ = compensate(robot, Path(np.arange(9.0), q=q)).lines()
    assert first.endswith("at most) uncorrected, less than 0.001 mm corrected")
    assert "workbench predict" in second
    assert str(RoundingEffect(4e-12, 9e-12, 0.0)) == "rounding moves the tool by less than 0.001 mm"
    assert "0.002 mm (mean)" in str(RoundingEffect(2e-3, 4e-3, 0.0))


def test_what_another_base_takes_of_the_uncorrected_error_is_said() -> None:
    """Axis 1 stands 3 mm beside where the base has it; else the arm sags by some micrometres."""
    robot = replace(load_robot("kr500"), geometry={"joint_1": {"tx": 3e-3, "rz": 1e-3}})
    q = np.linspace([0.0, -1.5, 1.6, 0.2, 0.6, 0.1], [0.3, -1.3, 1.5, 0.1, 0.7, 0.2], 15)
    shifted = compensate(robot, Path(np.linspace(0.0, 5.0, 15), q=q))
    assert shifted.before_mm.max() > 2.0
    assert shifted.before_anew_mm.max() < 0.01
    assert any("once the base or the work object is taken anew" in line for line in shifted.lines())
    wavy = extended(robot, [(GearKinematicError(Where(joint="joint_1", order=20.0)), [1e-3, 0.2])], size=0.0)
    waving = compensate(wavy, Path(np.linspace(0.0, 5.0, 15), q=q))
    assert waving.before_anew_mm.max() > 0.3
