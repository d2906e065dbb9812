"""The tool's points in the robot's base frame, and what moves them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Target
from ...campaign.planned import planned
from ...campaign.problem import Problem
from ...effects.acting import Acting
from ...robot.kinematics import Array
from ...robot.rotations import body_jacobian
from ..model import Model
from ..parameters import columns
from ..rows import jacobian


@dataclass(frozen=True)
class ToolMotion:
    """Points (N, T, 3) [m] in the base frame, and how they move: J (N, T, 3, P) by the numbers `names` (the
    base's shift and turn, the targets' places, geometry, effects), direct (N, T, 3, 6 S) by the slots'
    motions, joint (N, T, 3, n) by the joints."""

    points: Array
    names: tuple[str, ...]
    J: Array
    direct: Array
    joint: Array


def tool_problem(problem: Problem, targets: Sequence[Target]) -> Problem:
    """The poses of a problem, with these targets on the flange, seen from the base."""
    c = problem.campaign
    unseen = planned(c.robot, c.poses.q, targets=targets)
    unseen = replace(unseen, points=np.zeros_like(unseen.points))  # numbers to be had of all targets
    poses = replace(c.poses, torque=None, setup=np.zeros(len(c.poses), dtype=np.int64))
    names = ("points", "shots", "targets", "setup_names", "sigma", "noise_sigma", "six_dof")
    told = {name: getattr(unseen, name) for name in names}
    return replace(problem, campaign=replace(c, poses=poses, **told))


def tool_points(problem: Problem, acting: Acting = Acting()) -> Array:  # noqa: B008
    """(N, T, 3) [m] points in the base frame, of a `tool_problem`."""
    return _model(problem, acting).loaded(_model(problem, acting).in_base()).base


def tool_motion(problem: Problem, acting: Acting) -> ToolMotion:
    """Points of a `tool_problem` and their derivatives, the effects' values included."""
    effects = tuple(effect for effect, _ in acting)
    model = Model(problem, effects)
    state = replace(model.in_base(), values=tuple(values for _, values in acting))
    line = model.linearise(state)
    points = line.prediction.base
    shape = points.shape
    line = replace(line, frame=body_jacobian(points).reshape(shape[0], -1, 6))
    cols = columns(problem, effects)
    rows = 3 * shape[1]
    same = np.broadcast_to(np.eye(rows), (shape[0], rows, rows))
    J = jacobian(model, line, cols, state, same).columns
    direct = line.direct.reshape(*shape, -1)
    joint = direct[..., problem.arm.axial]
    return ToolMotion(points, told_apart(cols.names), J.reshape(*shape, -1), direct, joint)


def in_its_base(rows: Array) -> Array:
    """Rows (P, k) of a covariance's root, in the order of `ToolMotion`, for the tool in a base that is known:
    in the instrument's frame base and axis 1 are unsure together and cancel, in the base axis 1 stands alone.
    """
    return np.vstack([np.zeros_like(rows[:6]), rows[6:]])


def turns_of(points: Array, seen: NDArray[np.bool_]) -> Array:
    """(N, 3, 3 T) [rad/m] how a rigid tool turns by the motions of its points (N, T, 3), of those that are
    `seen` (N, T), in least squares."""
    middle = np.where(seen[..., None], points, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)[:, None]
    A = np.where(seen[..., None, None], body_jacobian(points - middle[:, None]), 0.0)
    return np.asarray(np.linalg.pinv(A.reshape(len(A), -1, 6))[:, 3:])


def told_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Names, the second of a kind with its number behind it."""
    met: Counter[str] = Counter()
    out = []
    for name in names:
        met[name] += 1
        out.append(name if met[name] == 1 else f"{name}#{met[name]}")
    return tuple(out)


def _model(problem: Problem, acting: Acting) -> Model:
    return Model(problem, (), tuple(acting))
