"""One run of the closed loop in Drake: continuous plant, third-order Runge–Kutta at a fixed step."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Integrator, LogVectorOutput, MatrixGain, VectorLogSink
from scipy.interpolate import CubicHermiteSpline

from ...robot.kinematics import Array
from ...robot.rotations import tool_pose
from .control import Controller, drives, feed_forward
from .forces import Forces, table_at
from .machine import Machine, machine
from .mechanics import Mechanics
from .motion import Motion, interpolated

INTEGRATION_STEP = 1e-3  # s


@dataclass(frozen=True, eq=False)
class Run:
    """What happened. states: (M, 2·nq) at `times` (M,) [s]; tool: (N, 4, 4) poses at the path's samples;
    q: (N, n) joints of the rigid twin that look like the arm then (motor and gear together);
    motor: (N, n) motors' error to their command [rad, m, on the joint's side]. wall: [s] that it took."""

    times: Array
    states: Array
    tool: Array
    q: Array
    motor: Array
    wall: float
    notes: tuple[str, ...]

    @property
    def real_time_factor(self) -> float:
        return float(self.times[-1] / max(self.wall, 1e-9))


def run(
    truth: Mechanics,
    nominal: Mechanics,
    motion: Motion,
    *,
    tool: Array | None = None,
    controller: Controller | None = None,
    step: float = INTEGRATION_STEP,
    at_rest: bool = True,
    reaction: bool = True,
    offset: Array | None = None,
) -> Run:
    """Simulates the true robot under a motion.

    nominal: what the controller's feed-forward knows. at_rest: it starts loaded and at rest; else with all
    springs slack. reaction: of the gear errors on the motors. offset: (n,) of the joints' encoders
    (repeatability).
    """
    controller = controller or Controller()
    drive = drives(truth, motion.q[0], controller)
    if offset is not None:
        motion = replace(motion, q=motion.q + offset)
    plant_of = machine(truth, drive.rotor)
    forces = Forces(
        truth,
        plant_of,
        drive,
        motion,
        feed_forward(nominal, motion, controller, drive),
        _along(motion, truth.wrench),
        _along(motion, truth.torque),
        reaction,
    )
    diagram, log = _diagram(plant_of, forces)
    simulator = Simulator(diagram)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", step)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    root = simulator.get_mutable_context()
    own = plant_of.plant.GetMyMutableContextFromRoot(root)
    rest = forces.rest()
    if not at_rest:
        rest[plant_of.springs] = 0.0
    plant_of.plant.SetPositions(own, rest)
    started = time.perf_counter()
    simulator.Initialize()
    simulator.AdvanceTo(motion.duration)
    wall = time.perf_counter() - started
    found = log.FindLog(root)
    times, states = found.sample_times().copy(), found.data().T.copy()
    if not np.isfinite(states).all():
        raise ArithmeticError("the simulation diverged")
    X, joints, motor = _seen(plant_of, motion, times, states, tool)
    return Run(times, states, X, joints, motor, wall, (*truth.notes, *drive.notes))


def _diagram(plant_of: Machine, forces: Forces) -> tuple[Diagram, VectorLogSink]:
    """Plant, forces, and the integral of the motors' positions, which the controller feeds on."""
    builder = DiagramBuilder()
    plant, n = plant_of.plant, len(plant_of.motors)
    builder.AddSystem(plant)
    builder.AddSystem(forces)
    select = np.zeros((n, plant.num_multibody_states()))
    select[np.arange(n), plant_of.motors] = 1.0
    motors, travel = builder.AddSystem(MatrixGain(select)), builder.AddSystem(Integrator(n))
    state = plant.get_state_output_port()
    builder.Connect(state, forces.state)
    builder.Connect(state, motors.get_input_port())
    builder.Connect(motors.get_output_port(), travel.get_input_port())
    builder.Connect(travel.get_output_port(), forces.travel)
    builder.Connect(forces.get_output_port(), plant.get_applied_generalized_force_input_port())
    log = LogVectorOutput(state, builder)
    return builder.Build(), log


def _along(motion: Motion, values: Array) -> Array | None:
    """At the motion's instants; None where there is nothing."""
    if not values.any():
        return None
    if len(values) != len(motion.sample_times):
        return np.tile(values[0], (len(motion.q), 1))
    return table_at(motion, values)


def _seen(
    plant_of: Machine, motion: Motion, times: Array, states: Array, tool: Array | None
) -> tuple[Array, Array, Array]:
    """Tool poses (N, 4, 4), joints of the rigid twin (N, n) and the motors' errors (N, n) at the samples."""
    plant = plant_of.plant
    context = plant.CreateDefaultContext()
    half = states.shape[1] // 2
    way = CubicHermiteSpline(times, states[:, :half], states[:, half:])
    positions = way(np.clip(motion.sample_times, times[0], times[-1]))
    X_FT = tool_pose(tool)
    X = np.empty((len(positions), 4, 4))
    for i, q in enumerate(positions):
        plant.SetPositions(context, q)
        X[i] = plant_of.flange.CalcPoseInWorld(context).GetAsMatrix4() @ X_FT
    joints = positions[:, plant_of.motors].copy()
    commanded = interpolated(motion.sample_times, motion.times, motion.q)
    motor = joints - commanded
    sprung = np.flatnonzero(plant_of.own >= 0)
    joints[:, sprung] += positions[:, plant_of.springs[plant_of.own[sprung]]]
    return X, joints, motor
