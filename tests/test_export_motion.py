"""The exported Diagram and `verify`'s simulated robot move alike."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from test_export import package

from workbench.correction.command import compensate
from workbench.correction.conditions import Conditions
from workbench.correction.path_shapes import Run, line, work_frame
from workbench.robot.description import load_robot
from workbench.robot.extended_robot.effects import BANDWIDTH
from workbench.robot.loop import Loop
from workbench.robot.schema import EffectRecord
from workbench.simulation.closed_loop.drives import drives
from workbench.simulation.closed_loop.dynamics import Along, Dynamics
from workbench.simulation.closed_loop.gears import Gears
from workbench.simulation.closed_loop.machine import machine
from workbench.simulation.closed_loop.mechanics import mechanics
from workbench.simulation.closed_loop.motion import motion
from workbench.simulation.closed_loop.rest import rest
from workbench.simulation.export import export

LOAD = Conditions("heavy", 40.0, (0.05, 0.02, 0.15), 5.0, (0.0, 0.01, 0.05))
FREE = Loop(coulomb=0.0, viscous=0.0, gas_exponent=1.0)  # the exported robot has no friction, its gas no heat
STEP, LENGTH = 1e-4, 0.3  # s: a light wrist on a strong damper is stiff
EVERY = 50  # steps between looks
EFFECTS = (
    EffectRecord(cause="foundation", values={"compliance": 4e-9}),
    EffectRecord(cause="bearing_tilt", joint="joint_2", values={"compliance": 2e-8}),
    EffectRecord(cause="link_mass", link="link_3", variant="mass", values={"mass": 12.0}),
    EffectRecord(cause="gear_ratio", joint="joint_1", values={"relative": 2e-4}),
    EffectRecord(cause="gear_eccentricity", joint="joint_3", values={"sin": 1e-4, "cos": 5e-5}),
    EffectRecord(cause="gear_kinematic_error", joint="joint_2", order=50.0, values={"sin": 2e-5, "cos": 0.0}),
    EffectRecord(cause="gravity_compensator", variant="preload", values={"preload": 400.0}),
)
GAS = EffectRecord(cause="gravity_compensator", variant="exponent", values={"exponent": 0.15})


def simulated(folder, q, wanted, step):
    """Tool poses (M, 4, 4) of the exported Diagram under Drake's Simulator; step None: as it comes."""
    module, builder = package(folder), DiagramBuilder()
    added = module.AddExtendedRobot(builder)
    source = builder.AddSystem(TrajectorySource(wanted))
    builder.Connect(source.get_output_port(), added.GetInputPort("desired_state"))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    module.Settle(added, context, q)
    simulator = Simulator(diagram, context)
    if step is not None:
        ResetIntegratorFromFlags(simulator, "runge_kutta3", step)
        simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.Initialize()
    port, own, poses = added.GetOutputPort("tool_pose"), added.GetMyContextFromRoot(context), []
    for k in range(round(LENGTH / STEP / EVERY) + 1):
        simulator.AdvanceTo(EVERY * k * STEP)
        poses.append(port.Eval(own).GetAsMatrix4())
    return np.array(poses)


def ours(truth, q, wanted):
    """The same of the machine that `verify` steps, by the same rule, under the exported drives' law."""
    drive = drives(truth, q[0], FREE)
    built = machine(truth, drive)
    dynamics = Dynamics(truth, built, drive, FREE, Gears(truth, q), Along(), STEP)
    rest(dynamics, q[0])
    size, n = dynamics.size, truth.arm.n
    inertia = np.diag(built.plant.CalcMassMatrix(built.plant.CreateDefaultContext()))[built.motors]

    def forces(x, v):
        dynamics.set(x[:size], v)
        force = dynamics.drakes()
        if dynamics.bodies.active:
            force += dynamics.bodies.at(0, None)
        dynamics.springs.add(v, dynamics.x.tolist(), dynamics.side, force)
        return force

    def rate(t, x):
        told = wanted.value(t)[:, 0]
        hold = -forces(x, np.zeros(size))[built.motors]
        force = forces(x, x[size:])
        off, slow = told[:n] - x[:size][built.motors], told[n:] - x[size:][built.motors]
        force[built.motors] += hold + inertia * (BANDWIDTH**2 * off + 2 * BANDWIDTH * slow)
        M = built.plant.CalcMassMatrix(dynamics.context)
        return np.concatenate([x[size:], np.linalg.solve(M, force)])

    x, poses = np.concatenate([dynamics.q, np.zeros(size)]), []
    for k in range(round(LENGTH / STEP) + 1):
        if k % EVERY == 0:
            dynamics.set(x[:size], x[size:])
            poses.append(built.flange.CalcPoseInWorld(dynamics.context).GetAsMatrix4())
        t = k * STEP
        a = rate(t, x)
        b = rate(t + STEP / 2, x + STEP / 2 * a)
        c = rate(t + STEP, x + STEP * (2 * b - a))
        x = x + STEP / 6 * (a + 4 * b + c)
    return np.array(poses)


@pytest.mark.parametrize("name", ["kr500", "rx170"])
def test_the_exported_diagram_moves_as_verify_does(tmp_path, name):
    """A command of `verify`, from rest: gas or coil, springs, gears with their reaction, masses, loads."""
    robot = replace(load_robot(name), effects=(*EFFECTS, GAS) if name == "kr500" else EFFECTS)
    export(robot, "drake", tmp_path, conditions=LOAD)
    path = line(0.02, Run(work_frame((1.3, 0.2, 0.9)), speed=0.1, acceleration=0.5, period=0.02))
    command = compensate(robot, path, LOAD)
    truth = mechanics(robot, path, command.q_command, LOAD)
    moved = motion(path.time, command.q_command)
    states = np.hstack([moved.q, moved.v]).T
    wanted = PiecewisePolynomial.FirstOrderHold(moved.times, states)
    there, found = simulated(tmp_path, moved.q[0], wanted, STEP), ours(truth, moved.q, wanted)
    assert np.ptp(there[:, :3, 3], axis=0).max() > 1e-3  # it moves
    assert np.abs(there - found).max() < 1e-9
    assert np.abs(simulated(tmp_path, moved.q[0], wanted, None) - found).max() < 1e-8  # as the header says
