"""Parameters of an ortho-parallel arm with a spherical wrist, for closed-form inverse kinematics.

Brandstötter et al. 2014: lengths a1 a2 b c1 c2 c3 c4; joint angles are sign · q − offset.
A calibrated arm is ortho-parallel only nearly: the parameters are those that come nearest to its flange.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ...files.faults import Fault, InputError
from ...robot.kinematics import Arm, Array, frames
from ...robot.rotations import rotation_about
from .content import Content
from .text import commented, number
from .urdf import Files

LENGTHS = ("a1", "a2", "b", "c1", "c2", "c3", "c4")
EXACT = 1e-6  # m: how near the nominal arm must come to count as ortho-parallel


def flange(parameters: Array, signs: Array, q: Array) -> tuple[Array, Array]:
    """Flange (N, 3) [m] and its rotation (N, 3, 3). parameters: (13,) lengths, then offsets; signs: (6,)."""
    a1, a2, b, c1, c2, c3, c4 = parameters[:7]
    t = (signs * q - parameters[7:]).T
    upper, fore = rotation_about("y", t[1]), rotation_about("y", t[1] + t[2])
    turned = rotation_about("z", t[0])
    wrist = np.array([a1, b, 0.0]) + upper @ [0.0, 0.0, c2] + fore @ [a2, 0.0, c3]
    R = turned @ fore @ rotation_about("z", t[3]) @ rotation_about("y", t[4]) @ rotation_about("z", t[5])
    return (turned @ wrist[..., None])[..., 0] + [0.0, 0.0, c1] + R @ [0.0, 0.0, c4], R


def fit(content: Content) -> tuple[Array, Array]:
    """Parameters (13,) and signs (6,). Raises `InputError` for an arm of another kind."""
    arm, q = content.arm, content.problem.q
    what = "is no ortho-parallel arm with a spherical wrist"
    fault = Fault(f"{content.robot.name}: --to opw", what, "use dh")
    if arm.n != 6 or arm.prismatic.any():
        raise InputError(fault)
    nominal = arm.with_geometry(np.zeros_like(arm.geometry))
    start, signs = _pattern(nominal)
    ideal = _nearest(nominal, q, start, signs)
    p, R = flange(ideal, signs, q)
    where = frames(nominal, q)
    if max(np.abs(p - where.p[-1]).max(), np.abs(R - where.R[-1]).max()) > EXACT:
        raise InputError(fault)
    return _nearest(arm, q, ideal, signs), signs


def near(content: Content) -> tuple[Array, Array]:
    """Flange (N, 3) [m] and its rotation (N, 3, 3) of the fitted arm in the content's poses."""
    return flange(*fit(content), content.problem.q)


def write(content: Content, header: list[str]) -> Files:
    """NAME_opw.yaml, as ROS-Industrial's opw_kinematics_plugin reads it."""
    parameters, signs = fit(content)
    lines = ["opw_kinematics_geometric_parameters:"]
    values = [number(round(value, 13)) for value in parameters]
    lines += [f"  {name}: {value}" for name, value in zip(LENGTHS, values[:7], strict=True)]
    offsets = ", ".join(values[7:])
    lines.append(f"opw_kinematics_joint_offsets: [{offsets}]")
    lines.append(f"opw_kinematics_joint_sign_corrections: [{', '.join(str(int(s)) for s in signs)}]")
    return {f"{content.robot.name}_opw.yaml": commented(header) + "\n".join(lines) + "\n"}


def _nearest(arm: Arm, q: Array, start: Array, signs: Array) -> Array:
    where = frames(arm, q)

    def left(parameters: Array) -> Array:
        p, R = flange(parameters, signs, q)
        return np.concatenate([(p - where.p[-1]).ravel(), 0.1 * (R - where.R[-1]).ravel()])

    return np.asarray(least_squares(left, start, method="lm", xtol=1e-15, ftol=1e-15).x)


def _pattern(arm: Arm) -> tuple[Array, Array]:
    """Signs, and offsets with lengths to begin from, read off the axes at q = 0."""
    here = frames(arm, np.zeros((1, arm.n)))
    axis, p = here.R[1:-1, 0, :, 2], here.p[1:, 0]
    signs, t = np.ones(6), np.zeros(6)
    signs[0] = np.sign(axis[0, 2])
    t[0] = np.arctan2(-axis[1, 0], axis[1, 1])
    if abs(t[0]) > np.pi / 2 + 1e-9:
        t[0], signs[1] = t[0] - np.copysign(np.pi, t[0]), -1.0
    R = rotation_about("z", t[0])
    signs[2] = 1.0 if axis[2] @ R[:, 1] > 0 else -1.0
    up = R.T @ (p[2] - p[1])
    t[1] = np.arctan2(up[0], up[2])
    wrist = _crossing(p[3], axis[3], p[4], axis[4])
    along = R.T @ axis[3]
    signs[3] = 1.0 if axis[3] @ (wrist - p[2]) > 0 else -1.0
    along = signs[3] * along
    t[2] = np.arctan2(along[0], along[2]) - t[1]
    R = R @ rotation_about("y", t[1] + t[2])
    bend = R.T @ axis[4]
    t[3] = np.arctan2(-bend[0], bend[1])
    if abs(t[3]) > np.pi / 2 + 1e-9:
        t[3], signs[4] = t[3] - np.copysign(np.pi, t[3]), -1.0
    R = R @ rotation_about("z", t[3])
    out = R.T @ here.R[-1, 0, :, 2]
    t[4] = np.arctan2(out[0], out[2])
    R = R @ rotation_about("y", t[4])
    signs[5] = 1.0 if axis[5] @ R[:, 2] > 0 else -1.0
    left = R.T @ here.R[-1, 0]
    t[5] = np.arctan2(left[1, 0], left[0, 0])
    lengths = np.array([0.1, 0.0, 0.0, p[1, 2], np.linalg.norm(p[2] - p[1]), 0.5, 0.1])
    return np.concatenate([lengths, -t]), signs


def _crossing(p: Array, a: Array, r: Array, b: Array) -> Array:
    """Where two lines come nearest: on the first."""
    A = np.stack([a, -b], axis=1)
    return p + a * np.linalg.lstsq(A, r - p, rcond=None)[0][0]
