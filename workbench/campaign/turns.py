"""How a 6-D measurement says how its target is turned: by a quaternion, angles about axes, or a vector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

import numpy as np
from scipy.spatial.transform import Rotation

from ..files.tables import Table
from ..robot.description import Robot
from ..robot.kinematics import Array, frames
from ..robot.rotations import angle_between, from_quaternions, from_vectors
from .file import ANGLES, QUATERNION, CampaignFile, Turns

FITS = np.radians(1.0)  # by which the target turns otherwise than the flange, in half of the moves
CLEARLY = 3.0  # times as far off are other ways of reading the angles
SAME = np.radians(0.1)  # by which two ways of reading differ that are one


def rotations(numbers: Mapping[str, Array], turns: Turns) -> Array:
    """(M, 3, 3) of the columns of a table of points, as `turns` says."""
    if turns == "quaternion":
        return from_quaternions(np.stack([numbers[name] for name in QUATERNION], axis=1))
    angles = np.stack([numbers[name] for name in ANGLES], axis=1)
    if turns == "vector":
        return from_vectors(angles)
    order = ["xyz".index(axis) for axis in turns]
    return np.asarray(Rotation.from_euler(turns, angles[:, order]).as_matrix())


def told_by_the_robot(
    file: CampaignFile, robot: Robot, poses: Table, points: Table
) -> tuple[CampaignFile, str]:
    """The campaign's file with how the angles of its 6-D measurement turn the target, where it does not say:
    that one by which the target turns as far as the flange does from pose to pose, whatever frames the two
    are in. And what is to be said of it. Without one the turns are left out.

    poses, points: with their `pose_id`, angles in rad.
    """
    rows = dict(zip(poses.texts["pose_id"], range(len(poses)), strict=True))
    names = points.texts.get("target", [""] * len(points))
    of_first = [i for i, name in enumerate(names) if name == names[0]]
    at = {points.texts["pose_id"][i]: i for i in of_first}  # the last shot of each
    seen = [(rows[name], i) for name, i in at.items() if name in rows]
    found: tuple[Turns, ...] = ()
    if len(seen) > 1:
        pose, row = np.array(seen).T
        flange = _flange(robot, poses)[pose]
        found = _ways(flange, {name: points.numbers[name][row] for name in ANGLES})
    place = f"{points.path}: rx, ry, rz"
    if not found:
        plain = file.points.model_copy(update={"turned_mm": None})
        said = (
            f"{place} do not turn as the flange does, in whatever order: they are left out, and the targets "
            "are points; if they are right, say how they turn it: turns under [points]"
        )
        return file.model_copy(update={"points": plain}), said
    told = file.points.model_copy(update={"turns": found[0]})
    words = "a rotation vector" if found[0] == "vector" else f"angles about fixed axes, {', '.join(found[0])}"
    said = f'{place} are read as {words}, as the flange turns so: say turns = "{found[0]}" under [points]'
    return file.model_copy(update={"points": told}), said


def _flange(robot: Robot, poses: Table) -> Array:
    """(N, 3, 3) how the nominal robot's flange is turned."""
    from ..robot.rigid_plant import arrays

    q = np.stack([poses.numbers[f"q{i}"] for i in range(1, len(robot.joints) + 1)], axis=1)
    return frames(arrays(robot), q).R[-1]


def _ways(flange: Array, angles: Mapping[str, Array]) -> tuple[Turns, ...]:
    """The ways of reading by which a target turns as far as the flange (N, 3, 3) from pose to pose, all of
    them alike; none where none does, or several that differ."""
    ways: dict[Turns, Array] = {way: rotations(angles, way) for way in get_args(Turns) if way != "quaternion"}
    right = angle_between(flange[:-1], flange[1:])
    off = {way: float(np.median(np.abs(angle_between(R[:-1], R[1:]) - right))) for way, R in ways.items()}
    best = min(off, key=lambda way: off[way])
    near = tuple(way for way in sorted(off, key=lambda way: off[way]) if off[way] <= CLEARLY * off[best])
    alike = all(float(angle_between(ways[best], ways[way]).max()) < SAME for way in near)
    return near if off[best] < FITS and alike else ()
