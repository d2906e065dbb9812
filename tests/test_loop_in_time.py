"""The sampled controller: margins, limits, steps; and the simulated robot's motion against Drake's
Simulator."""

import re
from dataclasses import replace

import numpy as np
import pytest
from extended_example import extended
from held_still import hold
from pydantic import ValidationError
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from workbench import parse_effect, problem, stored
from workbench.correction.command import compensate
from workbench.correction.conditions import Conditions, path_campaign
from workbench.correction.path_shapes import Run, circle, line, work_frame
from workbench.correction.paths import Path
from workbench.effects.backlash import Backlash
from workbench.effects.gear_kinematic_error import GearKinematicError
from workbench.effects.gear_ratio import GearRatio
from workbench.effects.place import Where
from workbench.effects.records import record
from workbench.effects.wrist_coupling import WristCoupling
from workbench.files.faults import InputError
from workbench.robot.description import load_robot
from workbench.robot.find import list_robots
from workbench.robot.kinematics import frames
from workbench.robot.loads import Loads
from workbench.robot.loop import Loop
from workbench.robot.plant_diagram import plant_diagram
from workbench.simulation.closed_loop import dynamics as dynamics_module
from workbench.simulation.closed_loop import verify
from workbench.simulation.closed_loop.cascade import Cascade, Delay, Gains
from workbench.simulation.closed_loop.control import inertial_torque, nominal_mechanics
from workbench.simulation.closed_loop.drives import drives
from workbench.simulation.closed_loop.dynamics import Along, Dynamics
from workbench.simulation.closed_loop.elastic import inertial_wrenches, with_elastic_lead
from workbench.simulation.closed_loop.friction import Rubbing, gone_over, mean_on_the_way
from workbench.simulation.closed_loop.gains import STABLE, _Linear, gains
from workbench.simulation.closed_loop.gears import Gears
from workbench.simulation.closed_loop.limits import Limits, OverLimit
from workbench.simulation.closed_loop.machine import machine
from workbench.simulation.closed_loop.mechanics import mechanics
from workbench.simulation.closed_loop.motion import motion
from workbench.simulation.closed_loop.rest import rest
from workbench.simulation.closed_loop.runs import Task, World, simulate
from workbench.simulation.closed_loop.simulation import first_step, run

FREE = Loop(coulomb=0.0, viscous=0.0)
LATE = Loop(drive_period=1e-3, delay=1e-3)  # 1 ms hold, 1 ms delay
HEAVY = Conditions("heavy", 250.0, (0.15, 0.0, 0.05))
FRAME = work_frame((1.6, 0.3, 0.9))


def short(name, loads=None, turn=0.1, length=0.5):
    """A robot on a short way from the middle of its ranges."""
    robot = load_robot(name)
    low = np.array([max(j.lower, -1.5) for j in robot.joints])
    high = np.array([min(j.upper, 1.5) for j in robot.joints])
    time = np.linspace(0.0, length, 21)
    q = low + (0.45 + turn * time[:, None] / length) * (high - low)
    truth = mechanics(robot, Path(time, q=q), q, loads or Conditions())
    return truth, nominal_mechanics(robot, truth), motion(time, q), q


def spectral_radius(mechanics, drive, loop, gains, q, factor, later):
    """Growth of the least stable motion over a position period, at joints q (n,), with `factor` times the
    gains and `later` [s] more delay; below 1 it dies out."""
    return _Linear(machine(mechanics, drive), drive, loop, q).least_stable(gains, factor, later)[0]


@pytest.mark.parametrize("name", [path.stem for path in list_robots()])
def test_every_robot_is_stable_with_a_millisecond_of_hold_and_of_delay(name):
    """Its motors follow a second of motion, and it bears twice the gains at both ends."""
    truth, nominal, moved, q = short(name, turn=0.03, length=1.0)
    drive = drives(truth, q[0], LATE)
    tuned = gains(truth, drive, LATE, q[[0, -1]])
    done = run(truth, nominal, moved, loop=LATE, tuned=tuned)
    assert np.abs(done.motor).max() < 2e-3
    for at in (q[0], q[-1]):
        assert spectral_radius(truth, drive, LATE, tuned, at, 1.0, 0.0) < 1
        assert spectral_radius(truth, drive, LATE, tuned, at, LATE.gain_margin, 0.0) < 1


@pytest.mark.parametrize("name", ["kr500", "rx170", "longlink"])
def test_the_delay_margin_is_there_and_ends(name):
    truth, _, _, q = short(name)
    drive = drives(truth, q[0], LATE)
    tuned = gains(truth, drive, LATE, q[:1])
    assert spectral_radius(truth, drive, LATE, tuned, q[0], 1.0, LATE.delay_margin) < 1
    assert spectral_radius(truth, drive, LATE, tuned, q[0], 1.0, 0.02) > 1


def test_a_loop_without_its_margin_swings_up():
    """What the linear analysis calls unstable diverges in the simulation, and what it calls stable does
    not."""
    truth, nominal, moved, q = short("kr500")
    joints = tuple(replace(joint, effort=np.inf) for joint in truth.robot.joints)
    truth = replace(truth, robot=replace(truth.robot, joints=joints))
    drive = drives(truth, q[0], LATE)
    tuned = gains(truth, drive, LATE, q[:1])
    # ten times the velocity's gain, which hold and delay do not allow
    wild = replace(tuned, kp=10 * tuned.kp, ki=10 * tuned.ki)
    assert spectral_radius(truth, drive, LATE, tuned, q[0], 10.0, 0.0) > 1
    calm = run(truth, nominal, moved, loop=LATE, tuned=tuned)
    assert np.abs(calm.motor).max() < 2e-3
    with pytest.raises(ArithmeticError, match="diverged"):
        run(truth, nominal, moved, loop=LATE, tuned=wild)


def test_less_delay_gives_more_bandwidth():
    truth, _, _, q = short("kr500")
    quick = Loop(drive_period=2.5e-4, delay=2.5e-4)
    slow, fast = (gains(truth, drives(truth, q[0], p), p, q[:1]) for p in (LATE, quick))
    assert (fast.reached >= slow.reached - 1e-12).all()
    assert fast.reached[0, 0] > 1.5 * slow.reached[0, 0]
    assert any("position loop" in note for note in slow.notes)


@pytest.mark.parametrize("name", ["kr500", "rx170"])
def test_stated_damping_is_used(name):
    truth, _, _, q = short(name)
    stated = [joint.data.damping for joint in truth.robot.joints]
    assert drives(truth, q[0], LATE).damping.tolist() == stated


def free(name, compensator=lambda law: law):
    """A robot free of drives, friction, dampers; its plant, its drives, its joints."""
    truth, _, _, q = short(name, HEAVY)
    truth = replace(truth, compensator=compensator(truth.compensator))
    drive = drives(truth, q[0], FREE)
    drive = replace(drive, damping=np.zeros_like(drive.damping))
    return truth, machine(truth, drive), drive, q


def falling(truth, built, drive, q, step):
    """Where it is after 0.15 s, let go with slack springs."""
    loop = FREE.model_copy(update={"gas_exponent": 1.0})  # the gas stays as warm as it is
    dynamics = Dynamics(truth, built, drive, loop, Gears(truth, q), Along(), step)
    dynamics.put(q[0])
    for k in range(round(0.15 / step)):
        dynamics.advance(np.zeros(truth.arm.n), k)
    return dynamics.q


@pytest.mark.parametrize("name", ["kr500", "rx170"])
def test_half_a_compensator_is_seen_in_the_loop(name):
    """A gas at the plant's port, or a coil in the plant."""
    whole, half = (
        falling(*free(name, lambda law, share=share: replace(law, charge=share)), 5e-4)
        for share in (1.0, 0.5)
    )
    built = free(name)[1]
    assert (built.cylinder is None) == (name == "rx170")
    assert built.plant.num_force_elements() == 1 + built.native.sum() + (name == "rx170")  # gravity too
    assert np.abs(whole - half).max() > 1e-4


@pytest.mark.parametrize("name", ["kr500", "rx170"])
def test_it_swings_as_in_drakes_simulator(name, monkeypatch):
    """Free of drives, friction and dampers, from slack springs: the same motion as Drake's own integration
    of the whole diagram, compensator and all, when the gas is looked at in every step."""
    monkeypatch.setattr(dynamics_module, "SEEN", 0.0)
    truth, built, drive, q = free(name)
    found = [falling(truth, built, drive, q, step) for step in (1e-4, 5e-5)]
    diagram = plant_diagram(built.plant, None, built.cylinder)
    simulator = Simulator(diagram)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", 1e-4)
    simulator.get_mutable_integrator().set_target_accuracy(1e-8)
    root = simulator.get_mutable_context()
    diagram.GetInputPort("joint_force").FixValue(root, np.zeros(built.plant.num_velocities()))
    diagram.GetInputPort("wrench").FixValue(root, [])
    context = built.plant.GetMyMutableContextFromRoot(root)
    start = np.zeros(built.plant.num_positions())
    start[built.motors] = q[0]
    built.plant.SetPositions(context, start)
    simulator.AdvanceTo(0.15)
    wanted = built.plant.GetPositions(context)
    assert np.abs(wanted[built.motors] - q[0]).max() > 1e-3  # it falls
    coarse, fine = (np.abs(x - wanted).max() for x in found)
    assert fine < 3e-7  # of undamped modes up to 500 Hz
    assert fine < 0.3 * coarse  # second order


def test_friction_along_a_step_is_the_mean_of_its_states():
    way = 2e-5
    for s, dx in ((0.3, 1e-5), (-0.9, 8e-5), (0.0, -3e-5), (1.0, -1e-6)):
        states = [gone_over(s, part * dx / way) for part in np.linspace(0, 1, 2001).tolist()]
        mean, slope = mean_on_the_way(s, dx / way)
        assert mean == pytest.approx(np.trapezoid(states, dx=1 / 2000), abs=2e-4)
        assert slope >= 0
        still, stiff = mean_on_the_way(s, 0.0)
        assert still == pytest.approx(s, abs=1e-4)
        assert stiff == pytest.approx(0.5, rel=1e-3)


def test_dry_friction_is_coulombs_and_higher_at_rest():
    """Of a motor that turns its link, and of a spring that stretches; viscous friction stands elsewhere."""
    truth, _, _, q = short("kr500")
    loop = Loop(stiction=1.3, load_side=0.2)
    drive = drives(truth, q[0], loop)
    built = machine(truth, drive)
    for speed, factor in ((1.0, 1.0), (1e-9, 1.3)):
        rubbing = Rubbing(built, drive, loop, 5e-4)
        rubbing.memory[:] = 1.0
        v, force = np.zeros(built.plant.num_velocities()), np.zeros(built.plant.num_velocities())
        v[built.motors] = speed
        rubbing.take(v, force)
        assert force[built.motors] == pytest.approx(-factor * drive.coulomb, rel=1e-3)
        assert force[built.own_at] == pytest.approx(-factor * 0.2 * drive.coulomb, rel=1e-3)


def test_a_turning_drive_is_slowed_by_its_viscous_friction():
    truth, _, _, q = short("kr500")
    drive = drives(truth, q[0], Loop())
    built = machine(truth, drive)
    dynamics = Dynamics(truth, built, drive, Loop(), Gears(truth, q), Along(), 5e-4)
    v, force = np.linspace(0.1, 1.0, dynamics.size), np.zeros(dynamics.size)
    dynamics.springs.add(v, [*dynamics.q, *v], dynamics.side, force)
    assert force[built.motors] == pytest.approx(-drive.viscous * v[built.motors])
    assert (drive.viscous > 0).all()


def test_a_torque_acts_after_its_delay():
    """Drives of other gains on slack springs: the same motion until the first torques that differ act."""
    truth, nominal, moved, q = short("kr500", length=0.1)
    loop = Loop(delay=2e-3)
    drive = drives(truth, q[0], loop)
    tuned = gains(truth, drive, loop, q[:1])
    soft, stiff = (
        run(truth, nominal, moved, loop=loop, tuned=replace(tuned, kp=k * tuned.kp), at_rest=False).states
        for k in (0.5, 1.0)
    )
    assert np.array_equal(soft[:6], stiff[:6])  # speeds are seen at the first tick, and 2 ms are four more
    assert not np.array_equal(soft[6], stiff[6])


def test_a_delay_may_end_within_a_step():
    """0.3 of a step of the first torque, 0.7 of the second; whole steps have one."""
    old, new = np.array([1.0]), np.array([2.0])
    within = Delay(1.3, 2)
    assert within.kept == 1
    assert [within.acting([old, new], i)[0] for i in range(2)] == pytest.approx([1.0, 0.3 * 1 + 0.7 * 2])
    assert [Delay(1.0, 2).acting([old, new], i)[0] for i in range(2)] == [1.0, 2.0]
    assert Delay(0.0, 2).acting([new], 0)[0] == 2.0


def test_a_delay_is_what_it_is_at_any_step():
    """Rounded up to whole steps, 0.5 ms were 0.75 at two steps of a drive that samples every 3 ms."""
    truth, nominal, moved, q = short("kr500", length=0.3)
    loop = Loop(position_period=3e-3, drive_period=3e-3, delay=5e-4, coulomb=0.0)
    tuned = gains(truth, drives(truth, q[0], loop), loop, q)
    coarse, fine = (
        run(truth, nominal, moved, loop=loop, tuned=tuned, step=step).tool[:, :3, 3]
        for step in (7.5e-4, 1e-4)
    )
    assert np.linalg.norm(coarse - fine, axis=1).max() < 1e-5


def test_gains_bear_all_of_a_path():
    """Folded, stretched, folded: nine times the inertia in the middle of the path."""
    robot = load_robot("kr500")
    folded, stretched = np.radians([[0, -130, 150, 0, 0, 0], [0, 0, 0, 0, 0, 0]])
    q = np.concatenate([np.linspace(folded, stretched, 20), np.linspace(stretched, folded, 20)])
    truth = mechanics(robot, Path(np.linspace(0, 8, 40), q=q), q, Conditions())
    drive = drives(truth, q[0], robot.loop)
    whole, start = gains(truth, drive, robot.loop, q), gains(truth, drive, robot.loop, q[:1])
    for pose in (folded, stretched):
        assert spectral_radius(truth, drive, robot.loop, whole, pose, robot.loop.gain_margin, 0.0) <= STABLE
    assert spectral_radius(truth, drive, robot.loop, start, stretched, 1.0, 0.0) > STABLE
    assert whole.kp == pytest.approx(start.kp)  # it is the position loop that has to be slower
    assert whole.kv[0] < 0.5 * start.kv[0]


def test_a_drive_is_no_slower_than_its_position_loop():
    with pytest.raises(ValidationError, match=r"no longer than position_period, 0\.001 s"):
        Loop(position_period=1e-3, drive_period=3e-3)


def test_the_velocity_is_filtered():
    loop = Loop(velocity_filter=7.5e-4)
    none = np.zeros(1)
    cascade = Cascade.at_rest(loop, Gains(none, none, none, none, none), none, none)
    seen = []
    for k in range(1, 9):
        cascade.measure(np.array([loop.drive_period * k]))  # 1 rad/s
        seen.append(cascade.speed[0])
    assert seen == pytest.approx(1 - 0.6 ** np.arange(1, 9))  # share 0.5 / (0.5 + 0.75)


def test_a_fast_stroke_heats_the_gas():
    """Without loss the pressure goes with the polytropic exponent of the loop, not with the law's at rest."""
    truth, _, _, q = short("kr500")
    law = truth.compensator
    drive, loop = drives(truth, q[0], FREE), Loop(gas_exponent=1.4, gas_time=1e9)
    built = machine(truth, drive)
    dynamics = Dynamics(truth, built, drive, loop, Gears(truth, q), Along(), 5e-4)
    place = np.zeros(dynamics.size)
    place[built.motors] = q[0]
    for k in range(401):
        place[built.motors[1]] = q[0, 1] + 0.3 * k / 400
        dynamics.set(place, np.zeros(dynamics.size))
        force = dynamics.bodies.at(k, 1e-3 if k else None)
        if k == 0:
            start = dynamics.bodies.gas.length
    polytropic = law.data.model_copy(update={"exponent": 1.4})
    same_at_start = (law.data.gas_length / start) ** (law.data.exponent - 1.4)
    other = replace(truth, compensator=replace(law, data=polytropic, charge=same_at_start))
    exact = Dynamics(other, machine(other, drive), drive, loop, Gears(truth, q), Along(), 5e-4)
    exact.set(place, np.zeros(dynamics.size))
    cold = Dynamics(truth, built, drive, FREE, Gears(truth, q), Along(), 5e-4)
    cold.set(place, np.zeros(dynamics.size))
    wanted, isothermal = (one.bodies.at(0, None)[built.motors[1]] for one in (exact, cold))
    assert abs(wanted - isothermal) > 0.01 * abs(wanted)
    assert force[built.motors[1]] == pytest.approx(wanted, abs=0.02 * abs(wanted - isothermal))


def test_a_motor_crosses_its_play_before_the_joint_follows():
    robot = extended(load_robot("kr500"), [(Backlash(Where(joint="joint_2")), [4e-5])])
    q = np.tile((0.3, -1.0, 1.2, 0.4, 0.7, 0.2), (2, 1))
    gears = Gears(mechanics(robot, Path(np.arange(2.0), q=q), q, Conditions()), q)
    side, motor, joint = [1.0] * 6, q[0].copy(), []
    for _ in range(10):
        motor[1] -= 1e-5
        side = gears.crossed(side, [0.0, -1e-5, 0.0, 0.0, 0.0, 0.0])
        joint.append(motor[1] + gears.errors(motor.tolist(), side)[0][1])
    assert np.ptp(joint[:8]) == pytest.approx(0.0, abs=1e-12)  # 8 steps of 10 µrad: twice the half width
    assert joint[9] - joint[8] == pytest.approx(-1e-5)


@pytest.mark.parametrize(
    ("effect", "value"),
    [
        (GearRatio(Where(joint="joint_3")), 3e-4),
        (WristCoupling(Where(joint="joint_6", other="joint_5")), 5e-4),
        (Backlash(Where(joint="joint_3")), 1e-4),
    ],
    ids=lambda value: getattr(value, "cause", ""),
)
def test_a_rigid_joint_bears_an_error_of_its_gear(effect, value):
    """There and back on an arm without springs: the drives give what they give without the error."""
    rigid, time = load_robot("irb120"), np.linspace(0.0, 1.0, 41)
    q = np.array([0.1, 0.2, -0.4, 0.2, 0.5, 0.1]) + 0.1 * np.sin(2 * np.pi * time)[:, None]
    torque = []
    for robot in (rigid, replace(rigid, effects=(record(effect, np.array([value])),))):
        truth = mechanics(robot, Path(time, q=q), q, Conditions())
        done = run(truth, nominal_mechanics(rigid, truth), motion(time, q, truth.sided))
        torque.append(np.abs(done.torque).max(axis=0))
    assert torque[1] == pytest.approx(torque[0], rel=0.05, abs=0.01)


def test_a_turned_round_joint_is_wound_up_by_friction_behind_its_gear():
    """Held at the same motor angle from both sides, the joint differs by 2 τ / K."""
    loop = Loop(coulomb=0.01, stiction=1.0, load_side=0.5)
    truth, _, _, q = short("kr500")
    truth = replace(truth, compensator=None)
    drive = drives(truth, q[0], loop)
    j, angle = 0, []
    for way in (1.0, -1.0):
        built = machine(truth, drive)
        dynamics = Dynamics(truth, built, drive, loop, Gears(truth, q), Along(), 5e-4)
        dynamics.rubbing.memory = np.full(2 * truth.arm.n, way)
        rest(dynamics, q[0])
        angle.append(dynamics.q[built.own_at[built.own[j]]])
    law = truth.axial[j]
    assert law is not None
    assert angle[0] - angle[1] == pytest.approx(-2 * 0.5 * drive.coulomb[j] * law.compliance, rel=1e-6)


def limited(part):
    """A KR 500 whose joint 2 has so much of the torque that it takes to hold it, and its run."""
    truth, nominal, moved, q = short("kr500", HEAVY, turn=0.15)
    held = run(truth, nominal, hold(q[0], 0.05)).torque[0, 1]
    joints = tuple(
        replace(joint, effort=part * abs(held)) if j == 1 else joint
        for j, joint in enumerate(truth.robot.joints)
    )
    return replace(truth, robot=replace(truth.robot, joints=joints)), nominal, moved


def test_a_drive_over_its_torque_stops_or_saturates():
    truth, nominal, moved = limited(1.1)
    with pytest.raises(OverLimit, match=r"joint_2 needs a torque of .* N·m, .* % over its limit"):
        run(truth, nominal, moved, on_limit="stop")
    done = run(truth, nominal, moved, on_limit="saturate")
    limit = truth.robot.joints[1].effort
    assert np.abs(done.torque[:, 1]).max() == pytest.approx(limit)
    assert any(note.startswith("joint_2: torque saturated for") for note in done.notes)


def test_a_sliding_joint_is_over_its_limit_of_force():
    with pytest.raises(OverLimit, match=r"rail needs a force of 3 N, 50 % over its limit of 2$"):
        Limits("torque", ("rail",), np.array([True]), np.array([2.0]), "stop", 1e-3).within(
            np.array([3.0]), 0.1
        )
    cut = Limits("torque", ("rail",), np.array([True]), np.array([2.0]), "saturate", 1e-3)
    assert cut.within(np.array([-3.0]), 0.1) == [-2.0]
    assert cut.notes()[0].startswith("rail: force saturated for")


def test_verify_says_where_a_limit_stops_it():
    robot = load_robot("kr500")
    slow = replace(
        robot, joints=(replace(robot.joints[0], velocity=0.01), *robot.joints[1:]), path=robot.path
    )
    path = line(0.1, Run(work_frame((1.6, 0.3, 0.9), along=(0.0, 1.0, 0.0)), speed=0.1, period=0.02))
    with pytest.raises(InputError, match=r"line, .* s after its start.*joint_1 needs a speed of .* over"):
        verify(path, slow, slow, speeds=None, repeats=0)


def test_speeds_that_a_drive_does_not_bear_are_told_and_the_slower_ones_kept():
    """Stopped or saturated: of a note that only one speed has it says which."""
    robot = load_robot("kr500")
    joints = (replace(robot.joints[0], velocity=0.03), *robot.joints[1:])
    slow = replace(robot, joints=joints, path=robot.path)
    path = line(0.04, Run(work_frame((1.6, 0.3, 0.9), along=(0.0, 1.0, 0.0)), speed=0.1, period=0.02))
    stopped = verify(path, slow, slow, speeds=[0.02, 0.1], repeats=0)
    assert [series.speed for series in stopped.series] == pytest.approx([0.02])
    assert any(re.match(r"not run at 0\.1 m/s: joint_1 needs a speed of", note) for note in stopped.notes)
    cut = verify(path, slow, slow, speeds=[0.02, 0.1], repeats=0, on_limit="saturate")
    assert len(cut.series) == 2
    assert any(note.startswith("at 0.1 m/s: joint_1: speed saturated") for note in cut.notes)


def test_no_gains_for_what_is_asked_is_the_calls_fault():
    robot = load_robot("kr500")
    path = line(0.04, Run(work_frame((1.6, 0.3, 0.9), along=(0.0, 1.0, 0.0)), speed=0.1, period=0.02))
    with pytest.raises(InputError, match="no gains are stable"):
        verify(path, robot, robot, speeds=None, repeats=0, loop=Loop(position_hz=1e-6))


def test_gains_may_be_others_than_are_made():
    """As of drives that somebody tuned worse; beyond what is stable they are refused."""
    truth, _, _, q = short("kr500")
    made, less = (
        gains(truth, drives(truth, q[0], loop), loop, q) for loop in (Loop(), Loop(gain_factor=0.7))
    )
    assert all(
        less.to_json()[name] == pytest.approx(0.7 * getattr(made, name), rel=1e-4)
        for name in ("kp", "ki", "kv")
    )
    with pytest.raises(InputError, match="gain_factor"):
        gains(truth, drives(truth, q[0], Loop()), Loop(gain_factor=10.0), q)


def test_the_controller_is_not_told_what_was_found_of_a_load(tmp_path):
    """Or it would know the weight in its uncorrected runs too."""
    robot = load_robot("kr500")
    q = np.tile([0.0, -1.0, 1.2, 0.0, 0.5, 0.0], (3, 1))
    path = Path(np.arange(3.0), q=q)
    of_path = problem(path_campaign(robot, path, q, HEAVY))
    heavier, values = parse_effect("payload:payload=heavy,mass=40", of_path)
    found = stored(tmp_path / "heavier.toml", robot, [record(heavier, values)])
    truth = mechanics(found, path, q, HEAVY)
    assert truth.mass == pytest.approx(290.0)
    nominal = nominal_mechanics(found, truth)
    assert nominal.mass == pytest.approx(250.0)
    assert nominal.moment == pytest.approx(250.0 * np.array(HEAVY.payload_com))


def test_a_limit_below_the_weight_is_mended_in_the_urdf():
    """Many URDFs of makers have a limit of 1 N·m: no speed helps there."""
    robot = load_robot("kr500")
    joints = tuple(replace(joint, effort=1.0) for joint in robot.joints)
    weak = replace(robot, joints=joints, path=robot.path)
    path = line(0.1, Run(work_frame((1.6, 0.3, 0.9), along=(0.0, 1.0, 0.0)), speed=0.1, period=0.02))
    with pytest.raises(InputError) as refused:
        verify(path, weak, weak, speeds=None, repeats=0)
    (fault,) = refused.value.faults
    assert "0 s after its start at rest" in fault.place
    assert re.search(r"\d{3,} % over its limit of 1$", fault.what)
    assert "kr500.urdf what its drive bears (effort in N·m; 0: not known)" in fault.mend
    assert "slower" not in fault.mend


def test_a_step_that_is_too_long_is_halved_by_itself():
    ripple = GearKinematicError(Where(joint="joint_1", order=800.0)), [3e-4, 0.0]
    robot = extended(load_robot("kr500"), [ripple])
    path = line(0.1, Run(work_frame((1.6, 0.3, 0.9), along=(0.0, 1.0, 0.0)), speed=0.2, period=0.01))
    command = compensate(robot, path, HEAVY)
    loop = Loop(position_period=5e-3, drive_period=5e-3, delay=0.0, velocity_filter=0.0)
    world = World(robot, robot, HEAVY, None, loop)
    task = Task("a coarse one", path, command.q_command, command.X_desired, settled=True)
    done = simulate(world, task)
    assert done.step < first_step(loop)
    whole = simulate(world, replace(task, settled=False))
    assert whole.step == first_step(loop) == 5e-4
    assert np.linalg.norm(done.tool[:, :3, 3] - whole.tool[:, :3, 3], axis=1).max() > 1e-6


def test_inertial_wrenches_are_drakes_inverse_dynamics():
    """Their axial parts are the torques that Drake's rigid arm needs against its inertia."""
    truth, _, moved, _ = short("kr500", HEAVY, turn=0.2, length=2.0)
    rows = slice(400, 8000, 16)
    t, q, v, a = moved.times[rows], moved.q[rows], moved.v[rows], moved.a[rows]
    arm = truth.arm
    n = len(t)
    loads = Loads(np.full(n, truth.mass), np.tile(truth.moment, (n, 1)), np.zeros((n, 6)), np.zeros((n, 6)))
    local = arm.own(inertial_wrenches(arm, frames(arm, q), loads, t))
    wanted = -inertial_torque(truth, q, v, a)
    middle = slice(5, -5)
    assert local[middle] == pytest.approx(wanted[middle], abs=2e-3 * np.abs(wanted).max())


def test_elastic_feed_forward_keeps_the_gain_at_speed():
    """A KR 500 with 250 kg on a circle at 0.3 m/s."""
    robot = load_robot("kr500")
    path = circle(0.15, Run(FRAME, speed=0.3, period=0.005))
    command = compensate(robot, path, HEAVY)
    truth = mechanics(robot, path, command.q_command, HEAVY)
    nominal = nominal_mechanics(robot, truth)
    static = motion(path.time, command.q_command)
    led = with_elastic_lead(static, robot, path, command.q_command, HEAVY, None, robot.loop)
    rms = []
    for moved in (motion(path.time, command.q_nominal), static, led):
        off = run(truth, nominal, moved).tool[:, :3, 3] - command.X_desired[:, :3, 3]
        rms.append(np.sqrt((off**2).sum(axis=1).mean()))
    assert rms[0] > 5 * rms[1] > 10 * rms[2]
