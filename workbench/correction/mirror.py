"""First-order corrections of the sources, for comparison: the error, taken once, with the other sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array
from ..robot.rotations import from_vectors, pose
from .extended_arm import ExtendedArm, parts
from .inverse import newton
from .solve import Rest, correct
from .trajectory import Trajectory

Command = tuple[Array, NDArray[np.bool_]]


def mirror(trajectory: Trajectory, rest: Rest, direction: Array | None) -> Command:
    """P′ = P − ΔP (Jiao et al. 2020, eq. 16): the tool's error is taken off the commanded pose."""
    R, p = trajectory.X[:, :3, :3], trajectory.X[:, :3, 3]
    T = _resting(trajectory, rest)
    return _inverse(trajectory, pose(2 * p - T[:, :3, 3], R @ T[:, :3, :3].transpose(0, 2, 1) @ R))


def double(trajectory: Trajectory, rest: Rest, direction: Array | None) -> Command:
    """T_end = 2 T − T_7 (Liu et al.): on the matrices; the nearest rotation is taken."""
    T = 2 * trajectory.X - _resting(trajectory, rest)
    U, _, V = np.linalg.svd(T[:, :3, :3])
    return _inverse(trajectory, pose(T[:, :3, 3], U @ V))


def joint(trajectory: Trajectory, rest: Rest, direction: Array | None) -> Command:
    """Q_ref = Q − ΔQ (Olabi et al. 2012, eq. 4): each joint's error of stiffness and gear; no geometry."""
    problem = trajectory.extended.at(rest.q, direction, slice(0, len(rest.q)))
    motion = trajectory.extended.direct(problem) + rest.sag
    dq = motion.reshape(len(rest.q), -1)[:, trajectory.nominal.axial]
    return rest.q - dq, np.ones(len(rest.q), dtype=bool)


def geometry(trajectory: Trajectory, rest: Rest, direction: Array | None) -> Command:
    """The corrected lengths, twists and joint zeros only, exactly: what a usual calibration gives."""
    problem = trajectory.extended.problem
    rigid = replace(problem.arm, compliance=np.zeros_like(problem.arm.compliance))
    only = replace(trajectory, extended=ExtendedArm(replace(problem, arm=rigid)))
    found = correct(only, rest.q, None, np.zeros_like(rest.sag), {})
    return found.q, found.there


METHODS: Mapping[str, Callable[[Trajectory, Rest, Array | None], Command]] = {
    "mirror": mirror,
    "double": double,
    "joint": joint,
    "geometry": geometry,
}


def _resting(trajectory: Trajectory, rest: Rest) -> Array:
    """(N, 4, 4) tool poses of the extended robot, from its error to the path."""
    turn = from_vectors(-rest.error[:, 3:])
    return pose(trajectory.X[:, :3, 3] - rest.error[:, :3], turn @ trajectory.X[:, :3, :3])


def _inverse(trajectory: Trajectory, X: Array) -> Command:
    """Joints of the nominal arm, next to those of the path."""
    q, there = np.empty_like(trajectory.q), np.empty(len(X), dtype=bool)
    for part in parts(len(X)):
        q[part], there[part] = newton(trajectory.nominal, trajectory.tip, X[part], trajectory.q[part])
    return q, there
