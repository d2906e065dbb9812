"""First-order corrections of the sources, for comparison: the error, taken once, with the other sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array
from ..robot.rotations import pose
from .course import Course
from .extended_arm import ExtendedArm, parts
from .inverse import newton
from .solve import Rest, correct

Command = tuple[Array, NDArray[np.bool_]]


def mirror(course: Course, rest: Rest, direction: Array | None) -> Command:
    """P′ = P − ΔP (Jiao et al. 2020, eq. 16): the tool's error is taken off the commanded pose."""
    R, p = course.X[:, :3, :3], course.X[:, :3, 3]
    T = _resting(course, rest)
    return _inverse(course, pose(2 * p - T[:, :3, 3], R @ T[:, :3, :3].transpose(0, 2, 1) @ R))


def double(course: Course, rest: Rest, direction: Array | None) -> Command:
    """T_end = 2 T − T_7 (Liu et al.): on the matrices; the nearest rotation is taken."""
    T = 2 * course.X - _resting(course, rest)
    U, _, V = np.linalg.svd(T[:, :3, :3])
    return _inverse(course, pose(T[:, :3, 3], U @ V))


def joint(course: Course, rest: Rest, direction: Array | None) -> Command:
    """Q_ref = Q − ΔQ (Olabi et al. 2012, eq. 4): each joint's error of stiffness and gear; no geometry."""
    problem = course.extended.at(rest.q, direction, slice(0, len(rest.q)))
    motion = course.extended.direct(problem) + rest.sag
    dq = motion.reshape(len(rest.q), -1)[:, course.nominal.axial]
    return rest.q - dq, np.ones(len(rest.q), dtype=bool)


def geometry(course: Course, rest: Rest, direction: Array | None) -> Command:
    """The corrected lengths, twists and joint zeros only, exactly: what a usual calibration gives."""
    whole = course.extended.whole
    rigid = replace(whole.arm, compliance=np.zeros_like(whole.arm.compliance))
    only = replace(course, extended=ExtendedArm(replace(whole, arm=rigid)))
    found = correct(only, rest.q, None, np.zeros_like(rest.sag), {})
    return found.q, found.there


METHODS: Mapping[str, Callable[[Course, Rest, Array | None], Command]] = {
    "mirror": mirror,
    "double": double,
    "joint": joint,
    "geometry": geometry,
}


def _resting(course: Course, rest: Rest) -> Array:
    """(N, 4, 4) tool poses of the extended robot, from its error to the path."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(-rest.error[:, 3:]).as_matrix()
    return pose(course.X[:, :3, 3] - rest.error[:, :3], turn @ course.X[:, :3, :3])


def _inverse(course: Course, X: Array) -> Command:
    """Joints of the nominal arm, next to those of the path."""
    q, there = np.empty_like(course.q), np.empty(len(X), dtype=bool)
    for part in parts(len(X)):
        q[part], there[part] = newton(course.nominal, course.tip, X[part], course.q[part])
    return q, there
