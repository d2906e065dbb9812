"""One run of the closed loop: the sampled controller on the simulated robot."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ...robot.kinematics import Array
from ...robot.loop import Loop
from ...robot.rotations import tool_pose
from .cascade import Cascade, Delay, Gains, SetPoints, set_points
from .control import feed_forward
from .drives import Drives, drives
from .dynamics import Along, Dynamics
from .gains import gains
from .gears import Gears
from .limits import Limits, OnLimit
from .machine import Machine, machine
from .mechanics import Mechanics
from .motion import Motion, interpolated
from .rest import rest

WILD = 1e6  # rad/s, m/s: no drive turns so fast
LONGEST_STEP = 5e-4  # s: of the integration; a stiff arm moves too far in a slow drive's period
STILL = 1e-9  # rad, m: frames that move less along a path stay


@dataclass(frozen=True, eq=False)
class Run:
    """What happened. states: (M, 2·nq) at `times` (M,) [s]; tool: (N, 4, 4) poses at the path's samples;
    links: (N, L, 4, 4) those of base and links; q: (N, n) joints as they are then (motor and gear together);
    motor: (N, n) motors' error to their command [rad, m, on the joint's side]; torque: (T, n) of the drives,
    a row per drive period. wall: [s] of processor time that it took."""

    times: Array
    states: Array
    tool: Array
    links: Array
    q: Array
    motor: Array
    torque: Array
    wall: float
    notes: tuple[str, ...]

    @property
    def real_time_factor(self) -> float:
        return float(self.times[-1] / max(self.wall, 1e-9))


def first_step(loop: Loop) -> float:
    """[s] of an integration to begin with: a whole part of the drive period."""
    return loop.drive_period / ceil(loop.drive_period / LONGEST_STEP - 1e-9)


def run(
    truth: Mechanics,
    nominal: Mechanics,
    motion: Motion,
    *,
    loop: Loop | None = None,
    tuned: Gains | None = None,
    tool: Array | None = None,
    step: float | None = None,
    at_rest: bool = True,
    reaction: bool = True,
    offset: Array | None = None,
    on_limit: OnLimit = "saturate",
) -> Run:
    """Simulates a robot under a motion.

    nominal: what the controller's feed-forward knows. loop: the controller (default: the robot's own);
    tuned: its gains (default: made for the start of the motion). step: [s] of the integration, at most
    (default: `first_step`). at_rest: it starts loaded and at rest; else with all springs slack.
    reaction: of the gear errors on the motors. offset: (n,) of the joints' encoders (repeatability). Raises
    OverLimit where a drive is asked for too much and `on_limit` is "stop", ArithmeticError where the arm
    finds no rest.
    """
    loop = loop or truth.robot.loop
    drive = drives(truth, motion.q[0], loop)
    tuned = tuned or gains(truth, drive, loop, motion.q[:1])
    if offset is not None:
        motion = replace(motion, q=motion.q + offset)
    told = set_points(motion, feed_forward(nominal, motion, loop), drive, loop)
    parts = ceil(loop.drive_period / (step or first_step(loop)) - 1e-9)
    step = loop.drive_period / parts
    built = machine(truth, drive)
    count = (len(told.q) - 1) * parts
    dynamics = Dynamics(
        truth,
        built,
        drive,
        loop,
        Gears(truth, motion.q),
        _along(truth, motion, step * (np.arange(count) + 0.5)),
        step,
        reaction,
    )
    dynamics.side = motion.side.tolist()
    hold = rest(dynamics, motion.q[0])
    if not at_rest:
        dynamics.put(motion.q[0])
    seen = _counted(motion.q[0], drive.count) if drive.count.any() else motion.q[0]
    cascade = Cascade.at_rest(loop, tuned, seen, hold - told.feed[0])
    limits = [
        Limits(what, truth.arm.names, truth.arm.prismatic, limit, on_limit, loop.drive_period)
        for what, limit in (("torque", drive.torque), ("speed", drive.speed))
    ]
    started = time.process_time()
    states, torque = _run(dynamics, cascade, told, limits, drive, parts, hold)
    wall = time.process_time() - started
    times = step * np.arange(len(states))
    X, links, joints, motor = _seen(dynamics, motion, times, states, tool)
    saturated = [note for limit in limits for note in limit.notes()]
    notes = (*truth.notes, *drive.notes, *tuned.notes, *saturated)
    return Run(times, states, X, links, joints, motor, torque, wall, notes)


def _counted(q: Array, count: Array) -> Array:
    """What encoders with steps `count` (n,) say at motors q (n,)."""
    return np.asarray(count * np.round(q / count))


def _run(
    dynamics: Dynamics,
    cascade: Cascade,
    told: SetPoints,
    limits: list[Limits],
    drive: Drives,
    parts: int,
    hold: Array,
) -> tuple[Array, Array]:
    """States (M, 2 V) of the plant after every step, and torques asked for (T, n)."""
    loop, motors = cascade.loop, dynamics.machine.motors
    delay, ticks, size = Delay(loop.delay / dynamics.h, parts), len(told.q) - 1, dynamics.size
    counts = bool(drive.count.any())
    torque_limit, speed_limit = limits
    states = np.empty((ticks * parts + 1, 2 * size))
    states[0, :size], states[0, size:] = dynamics.q, dynamics.v
    asked = np.empty((ticks, len(hold)))
    waiting = [hold] * delay.kept
    for tick in range(ticks):
        now = tick * loop.drive_period
        seen = dynamics.q[motors]
        cascade.measure(_counted(seen, drive.count) if counts else seen)
        if tick % loop.cycles == 0:
            cascade.correct(told.q[tick])
        wanted = speed_limit.within(told.v[tick] + cascade.correction, now)
        torque, integral = cascade.torque(wanted, told.feed[tick])
        cut = torque_limit.within(torque, now)
        # a drive that gives less than asked does not go on integrating
        cascade.integral = integral if cut is torque else np.where(cut == torque, integral, cascade.integral)
        asked[tick] = cut
        if not dynamics.v @ dynamics.v < WILD**2:
            raise ArithmeticError("the simulation diverged")
        waiting.append(cut)
        for i in range(parts):
            k = tick * parts + i
            dynamics.advance(delay.acting(waiting, i), k)
            states[k + 1, :size], states[k + 1, size:] = dynamics.q, dynamics.v
        waiting.pop(0)
    return states, asked


def _along(truth: Mechanics, motion: Motion, times: Array) -> Along:
    """What the path decides, at the middle of every step."""

    def at(values: Array) -> Array | None:
        if not values.any():
            return None
        flat = values.reshape(len(values), -1)
        if len(values) == len(motion.sample_times):
            flat = interpolated(times, motion.sample_times, flat)
        else:
            flat = np.tile(flat[0], (len(times), 1))
        return np.asarray(flat.reshape(len(times), *values.shape[1:]))

    moves = float(np.ptp(truth.placed, axis=0).max(initial=0.0)) > STILL
    placed = at(truth.placed) if moves else None
    law, charge = truth.compensator, None
    if law is not None:
        charge = at(np.broadcast_to(law.charge, len(truth.wrench)).astype(float))
    return Along(at(truth.wrench), at(truth.torque), charge, placed)


def _seen(
    dynamics: Dynamics, motion: Motion, times: Array, states: Array, tool: Array | None
) -> tuple[Array, Array, Array, Array]:
    """Poses of the tool (N, 4, 4) and of base and links (N, L, 4, 4), joints (N, n) and the motors' errors
    (N, n) at the samples."""
    built: Machine = dynamics.machine
    plant, context = dynamics.plant, dynamics.context
    half = states.shape[1] // 2
    way = CubicHermiteSpline(times, states[:, :half], states[:, half:])
    at = np.clip(motion.sample_times, times[0], times[-1])
    positions = way(at)
    X_FT = tool_pose(tool)
    X, bodies = np.empty((len(positions), 4, 4)), built.built.bodies[:-1]
    links = np.empty((len(positions), len(bodies), 4, 4))
    for i, q in enumerate(positions):
        dynamics.place(min(int(at[i] / dynamics.h), len(times) - 2))
        plant.SetPositions(context, q)
        X[i] = built.flange.CalcPoseInWorld(context).GetAsMatrix4() @ X_FT
        for k, body in enumerate(bodies):
            links[i, k] = body.EvalPoseInWorld(context).GetAsMatrix4()
    joints = positions[:, built.motors].copy()
    motor = joints - interpolated(motion.sample_times, motion.times, motion.q)
    sprung = np.flatnonzero(built.own >= 0)
    joints[:, sprung] += positions[:, built.springs[built.own[sprung]]]
    return X, links, joints, motor
