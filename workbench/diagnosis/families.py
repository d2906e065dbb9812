"""Families without a name: does the residual depend on a joint, two joints, torque, time, approach?

They give power against causes that are not in the catalogue, and say what an unknown one depends on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..identification.fit import Fit
from ..robot.kinematics import RX, Array

Kind = Literal[
    "joint", "tilt", "pair", "torque", "clock", "side", "payload", "attitude", "bearing", "product"
]
MOVES = 1e-3  # rad or m: a joint that moves less than this shows no function of itself


@dataclass(frozen=True)
class Family:
    """Motions (N, D, a), whitened, times functions of the pose (N, b).

    kind: of the variable: a joint's own angle (error about its axis, or across it: "tilt"), two joints, a
    joint's torque, the clock (time, order, temperature), a joint's side of approach, the payload. joints:
    numbers of the joints that it is about. variable: for people; x: (N,) to plot against.
    """

    kind: Kind
    joints: tuple[int, ...]
    variable: str
    unit: str
    motions: Array
    functions: Array
    x: Array

    @property
    def joint(self) -> int | None:
        """The one joint that it is about; None where there is none, or more."""
        return self.joints[0] if len(self.joints) == 1 else None

    @property
    def columns(self) -> Array:
        """(N, D, a·b): every motion with every function."""
        n_poses, rows = self.motions.shape[:2]
        product = self.motions[..., None] * self.functions[:, None, None, :]
        return np.asarray(product).reshape(n_poses, rows, -1)


def families(fit: Fit) -> Iterator[Family]:
    """All families that the campaign's columns allow."""
    arm = fit.model.problem.arm
    moves = [_whitened(fit, int(column), 1) for column in arm.axial]
    yield from _joint_families(fit, moves)
    yield from _torque_families(fit, moves)
    yield from _clock_families(fit)
    yield from _side_families(fit, moves)
    yield from _payload_families(fit)
    yield from _attitude_family(fit)
    yield from _bearing_family(fit)


def _whitened(fit: Fit, column: int, count: int) -> Array:
    """(N, D, count) whitened motions of the points by `count` motions of slots, from `column` on."""
    return np.asarray(np.matmul(fit.whitener, fit.line.direct[:, :, column : column + count]))


def _joint_families(fit: Fit, moves: list[Array]) -> Iterator[Family]:
    """Functions of one joint, about its axis and across it; of two joints."""
    problem = fit.model.problem
    arm, q = problem.arm, problem.q
    angle = [np.where(arm.prismatic[j], 3.0, 1.0) * q[:, j] for j in range(arm.n)]
    moved = [j for j in range(arm.n) if np.ptp(q[:, j]) > MOVES]
    for j in moved:
        waves = np.column_stack([f(k * angle[j]) for k in (1, 2, 3, 4) for f in (np.sin, np.cos)])
        own = np.column_stack([angle[j], angle[j] ** 2, waves])
        yield Family("joint", (j,), arm.names[j], "rad", moves[j], own, q[:, j])
        tilt = _whitened(fit, 6 * (j + 1) + RX, 2)
        yield Family("tilt", (j,), f"{arm.names[j]} (tilt)", "rad", tilt, waves[:, :4], q[:, j])
    for i in moved:
        for j in moved:
            if i != j:
                si, ci, sj, cj = np.sin(angle[i]), np.cos(angle[i]), np.sin(angle[j]), np.cos(angle[j])
                mixed = np.column_stack([angle[j], sj, cj, si * sj, si * cj, ci * sj, ci * cj])
                name = f"{arm.names[i]} with {arm.names[j]}"
                yield Family("pair", (i, j), name, "rad", moves[i], mixed, q[:, j])


def product_families(fit: Fit, joint: int) -> Iterator[Family]:
    """One joint's error by products of waves of two other joints: for a joint that scatters."""
    problem = fit.model.problem
    arm, q = problem.arm, problem.q
    moves = _whitened(fit, int(arm.axial[joint]), 1)
    turning = [j for j in range(arm.n) if j != joint and not arm.prismatic[j] and np.ptp(q[:, j]) > MOVES]
    waves = {
        j: np.column_stack([f(k * q[:, j]) for k in (1, 2, 3) for f in (np.sin, np.cos)]) for j in turning
    }
    for a, j in enumerate(turning):
        for k in turning[a + 1 :]:
            mixed = (waves[j][:, :, None] * waves[k][:, None, :]).reshape(len(q), -1)
            name = f"{arm.names[joint]} with {arm.names[j]} and {arm.names[k]}"
            yield Family("product", (joint, j, k), name, "rad", moves, mixed, q[:, j])


def _torque_families(fit: Fit, moves: list[Array]) -> Iterator[Family]:
    arm = fit.model.problem.arm
    torque = fit.line.prediction.load.local.reshape(len(fit.r), -1)[:, arm.axial]
    for j in range(arm.n):
        size = np.abs(torque[:, j]).max()
        if np.ptp(torque[:, j]) > 1e-3 * max(size, 1.0):
            x = torque[:, j] / size
            bent = np.column_stack([x**2, np.abs(x)])  # what is odd in the torque is a yield
            yield Family("torque", (j,), f"torque of {arm.names[j]}", "N·m", moves[j], bent, torque[:, j])


def _clock_families(fit: Fit) -> Iterator[Family]:
    c = fit.model.problem.campaign
    base = _whitened(fit, 0, 6)
    order = np.linspace(-1, 1, len(c.poses.q))
    if c.poses.time is not None and np.isfinite(c.poses.time).all() and np.ptp(c.poses.time) > 0:
        order = 2 * (c.poses.time - c.poses.time.min()) / np.ptp(c.poses.time) - 1
        yield Family(
            "clock", (), "time", "s", base, np.column_stack([order, order**2, order**3]), c.poses.time
        )
    else:
        functions = np.column_stack([order, order**2])
        yield Family("clock", (), "order of measurement", "1", base, functions, order)
    if (
        c.poses.temperature is not None
        and np.isfinite(c.poses.temperature).all()
        and np.ptp(c.poses.temperature) > 0
    ):
        warm = c.poses.temperature - c.poses.temperature.mean()
        yield Family("clock", (), "temperature", "°C", base, warm[:, None], c.poses.temperature)


def _side_families(fit: Fit, moves: list[Array]) -> Iterator[Family]:
    problem = fit.model.problem
    c, names = problem.campaign, problem.arm.names
    if c.poses.side is not None:
        for j in range(len(names)):
            if np.ptp(c.poses.side[:, j]) > 0:
                side = c.poses.side[:, j]
                form = np.column_stack([side, side * np.sin(c.poses.q[:, j]), side * np.cos(c.poses.q[:, j])])
                yield Family("side", (j,), f"approach of {names[j]}", "1", moves[j], form, side)


def _payload_families(fit: Fit) -> Iterator[Family]:
    problem = fit.model.problem
    c = problem.campaign
    present = [i for i in range(len(c.payload_names)) if (c.poses.payload == i).any()]
    if len(present) > 1:
        which = np.column_stack([(c.poses.payload == i).astype(float) for i in present[1:]])
        flange = _whitened(fit, 6 * (problem.arm.n + 1), 6)
        yield Family("payload", (), "payload", "1", flange, which, c.poses.payload.astype(float))


def _attitude_family(fit: Fit) -> Iterator[Family]:
    """The tool on the flange, by the way that the hand points."""
    problem = fit.model.problem
    flange = _whitened(fit, 6 * (problem.arm.n + 1), 6)
    R = problem.rigid.R[-1]
    way = np.column_stack([R[:, :, 2], R[:, :, 0], np.tanh(8 * R[:, :, 2])])
    yield Family("attitude", (), "attitude of the hand", "1", flange, way, R[:, 2, 2])


def _bearing_family(fit: Fit) -> Iterator[Family]:
    """The instrument's turn about its vertical, by the bearing."""
    points = fit.line.prediction.points
    middle = np.nanmean(points, axis=1)
    bearing = np.arctan2(middle[:, 1], middle[:, 0])
    if np.ptp(bearing) < MOVES:
        return
    turn = np.stack([-points[..., 1], points[..., 0], np.zeros_like(points[..., 0])], axis=-1)
    turn = turn.reshape(len(turn), -1, 1)
    drives = np.zeros((len(turn), fit.whitener.shape[2] - turn.shape[1], 1))
    motion = np.matmul(fit.whitener, np.concatenate([turn, drives], axis=1))
    waves = np.column_stack([f(k * bearing) for k in (1, 2, 3, 4, 5) for f in (np.sin, np.cos)])
    yield Family("bearing", (), "bearing from the instrument", "rad", motion, waves, bearing)
