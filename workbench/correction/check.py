"""Whether a path can be for this robot at all: shapes, numbers, time, units. Raises `InputError`."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from ..files.faults import Fault, InputError, counted
from ..robot.description import Robot
from ..robot.kinematics import Arm, Array
from .paths import Path

NUMBER = re.compile(r"\d[\d.]*")


def sample_faults(path: Path, rows: Iterable[int], whats: Iterable[str], mend: str) -> list[Fault]:
    """One fault per line of the path's file, of however many samples this stands for, with the numbers of the
    first: the first lines in full, the rest counted."""
    found = dict[tuple[str, str], Fault]()
    for row, what in zip(rows, whats, strict=True):
        fault = Fault(path.place(row), what, mend)
        found.setdefault((fault.place, NUMBER.sub("", what)), fault)
    return counted(list(found.values()))


def check_path(robot: Robot, arm: Arm, path: Path, X_FT: Array) -> None:
    """Raises `InputError` with everything that is wrong before any kinematics."""
    faults = _check_shapes(robot, path, X_FT)
    if not faults:
        faults = _check_numbers(path)
    if not faults:
        faults = _check_units(robot, arm, path, X_FT)
    if faults:
        raise InputError(faults)


def _check_shapes(robot: Robot, path: Path, X_FT: Array) -> list[Fault]:
    place = path.file or path.title or "path"
    count, n = len(path.time), len(robot.joints)
    if (path.q is None) == (path.X is None):
        return [Fault(place, "has both joints and tool poses, or neither", "a path is one or the other")]
    faults = []
    if path.q is not None and path.q.shape != (count, n):
        what = f"has {path.q.shape[-1]} joints, {robot.name} has {n}"
        faults.append(Fault(place, what, "is it a path for another robot?"))
    if path.X is not None and path.X.shape != (count, 4, 4):
        faults.append(Fault(place, f"tool poses have shape {path.X.shape}", f"give ({count}, 4, 4)"))
    if count < 2:
        faults.append(Fault(place, "has one sample only", "a path needs two at least"))
    R = np.asarray(X_FT)[:3, :3]
    if np.shape(X_FT) != (4, 4) or not np.allclose(R @ R.T, np.eye(3), atol=1e-6):
        faults.append(Fault("tool", "is no pose (4, 4)", "rotation and place in the flange frame"))
    if n < 3:
        faults.append(Fault(robot.name, f"has {n} joints", "following a path takes three at least"))
    return faults


def _check_numbers(path: Path) -> list[Fault]:
    numbers = [("t_s", path.time[:, None])]
    if path.q is not None:
        numbers.append(("joints", path.q))
    if path.X is not None:
        numbers.append(("tool pose", path.X.reshape(len(path), -1)))
    faults = []
    for what, values in numbers:
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        faults += sample_faults(
            path, bad, [f"{what}: not a number"] * len(bad), "give a number in every cell"
        )
    if faults:
        return faults
    back = np.flatnonzero(np.diff(path.time) <= 0) + 1
    whats = [f"t_s is {path.time[i]:.6g} s, after {path.time[i - 1]:.6g} s" for i in back]
    faults = sample_faults(path, back, whats, "time has to rise from line to line")
    if path.X is not None:
        R = path.X[:, :3, :3]
        off = np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)) > 1e-6
        off |= np.linalg.det(R) < 0
        bad = np.flatnonzero(off)
        whats = ["the orientation is no rotation"] * len(bad)
        faults += sample_faults(path, bad, whats, "three axes at right angles, length 1")
    return faults


def reach(arm: Arm, X_FT: Array, upper: Array) -> float:
    """[m] A sphere about the second axis that the tool cannot leave: all links stretched."""
    slides = np.where(np.isfinite(upper), np.abs(upper), 0.0)[arm.prismatic].sum()
    return float(np.linalg.norm(arm.p[2:], axis=1).sum() + np.linalg.norm(X_FT[:3, 3]) + slides)


def _check_units(robot: Robot, arm: Arm, path: Path, X_FT: Array) -> list[Fault]:
    """Numbers that would fit the arm if they were a thousand times as large, or as small, or in degrees.
    Joints within a turn are radians, of another arm or pose: which leaves its limits is told by line."""
    place = path.file or path.title or "path"
    if path.X is not None:
        far = np.linalg.norm(path.X[:, :3, 3], axis=1)
        most = float(np.linalg.norm(arm.p[1])) + reach(arm, X_FT, robot.limits[:, 1])
        said = (
            f"the tool is {far.min() * 1e3:.3g} to {far.max() * 1e3:.3g} mm from the base, the arm reaches "
        )
        said += f"{most * 1e3:.0f} mm"
        if far.max() < 0.01 * most and far.max() > 0:
            return [Fault(place, said, "are the numbers metres? then name the columns x_m y_m z_m")]
        if far.min() > 50 * most:
            return [Fault(place, said, "are the numbers millimetres? then name the columns x_mm y_mm z_mm")]
    if path.q is not None:
        turning = ~arm.prismatic
        limit = robot.limits[turning]
        q = path.q[:, turning]
        outside = (q < limit[:, 0]) | (q > limit[:, 1])
        small, most = np.deg2rad(q), float(np.abs(q).max(initial=0.0))
        fits = ((small >= limit[:, 0]) & (small <= limit[:, 1])).all()
        if most > 2 * np.pi and fits and outside.any(axis=1).mean() > 0.5:
            said = f"turns joints by up to {most:.4g} rad, outside their limits"
            return [Fault(place, said, "are the numbers degrees? then name the columns q1_deg ...")]
    return []
