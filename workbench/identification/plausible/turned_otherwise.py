"""6-D measurements whose turns were written down otherwise than they are read.

Three points of a frame say how it is turned: the numbers that stood in the table are computed back from that
and read in other ways.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ...campaign.problem import Problem
from ...robot import rotations
from ...robot.kinematics import Array
from .hypotheses import Hypothesis
from .misfit import Sample

SQUARE = 1e-3  # of their length, to which two arms of a frame are as long and at right angles
FIXED = "angles about fixed x, y, z (KUKA's C, B, A, FANUC's W, P, R)"
ALONG = "angles about x, y, z that turn along (Stäubli's)"

Turns = Callable[[Array], Array]


def turned_otherwise(problem: Problem, data: Sample) -> Iterator[Hypothesis]:
    """That the turns of a 6-D measurement, or all of it, are to be read in another way."""
    if not problem.campaign.six_dof or not _are_frames(data.points):
        return
    mend = "mend the header, or say under `columns` which is which"
    for said, order in (("last, not first", [3, 0, 1, 2]), ("first, not last", [1, 2, 3, 0])):
        yield _read(f"qw comes {said} of the four numbers of a quaternion", mend, _reordered(order))
    what = "the quaternions say how the instrument is turned in the target's frame"
    yield _read(what, "turn the signs of qx, qy and qz", lambda R: R.swapaxes(1, 2))
    what = "the poses are those of the instrument in the target's frame"
    yield Hypothesis("points", what, "invert them", _inverse)
    mend = "make the quaternions anew"
    yield _read(f"the turns are {FIXED}, and were taken for {ALONG}", mend, _fixed)
    yield _read(f"the turns are {ALONG}, and were taken for {FIXED}", mend, _along)
    in_order = "the turns are angles about z, y, x as they turn along (KUKA's A, B, C), in this order"
    yield _read(f"{in_order}, and were taken for angles about x, y, z", mend, _in_order)
    mend = "turn its sign, as the quaternions have it"
    for k, axis in enumerate("xyz"):
        what = f"{axis} of the places has the wrong sign, the turns have not"
        yield Hypothesis("points", what, mend, partial(_mirrored, axis=k))


def _read(what: str, mend: str, turns: Turns) -> Hypothesis:
    """That turns (N, 3, 3) are others."""

    def undo(data: Sample) -> Sample:
        place, R = _frames(data.points)
        return _with(data, place, turns(R))

    return Hypothesis("points", what, mend, undo)


def _reordered(order: list[int]) -> Turns:
    return lambda R: rotations.from_quaternions(rotations.quaternions(R)[:, order])


def _fixed(R: Array) -> Array:
    return rotations.from_zyx(rotations.xyz_angles(R)[:, ::-1])


def _along(R: Array) -> Array:
    return rotations.from_xyz(rotations.zyx_angles(R)[:, ::-1])


def _in_order(R: Array) -> Array:
    return rotations.from_zyx(rotations.xyz_angles(R))


def _mirrored(data: Sample, axis: int) -> Sample:
    place, R = _frames(data.points)
    return _with(data, place * np.where(np.arange(3) == axis, -1.0, 1.0), R)


def _inverse(data: Sample) -> Sample:
    place, R = _frames(data.points)
    back = R.swapaxes(1, 2)
    return _with(data, -(back @ place[:, :, None])[:, :, 0], back)


def _frames(points: Array) -> tuple[Array, Array]:
    """Places (N, 3) [m] and turns (N, 3, 3) of three points (N, 3, 3), one at a frame's origin and two on its
    x and y; any turn where they were not seen."""
    place, arms = points[:, 0], points[:, 1:] - points[:, :1]
    seen = np.isfinite(points).all(axis=(1, 2), keepdims=True)
    x, y = (arms / np.linalg.norm(arms, axis=2, keepdims=True)).swapaxes(0, 1)
    return place, np.where(seen, np.stack([x, y, np.cross(x, y)], axis=2), np.eye(3))


def _with(data: Sample, place: Array, R: Array) -> Sample:
    """The sample with its frames at places (N, 3) [m], turned R (N, 3, 3)."""
    arms = np.linalg.norm(data.points[:, 1:] - data.points[:, :1], axis=2)[..., None]
    points = np.repeat(place[:, None], 3, axis=1)
    points[:, 1:] += arms * R[:, :, :2].swapaxes(1, 2)
    return data.changed(points=points)


def _are_frames(points: Array) -> bool:
    """Whether points (N, T, 3) are three of a frame each."""
    whole = points[np.isfinite(points).all(axis=(1, 2))]
    if points.shape[1] != 3 or not len(whole):
        return False
    x, y = np.median(np.linalg.norm(whole[:, 1:] - whole[:, :1], axis=2), axis=0)
    across = np.median(np.abs(np.sum((whole[:, 1] - whole[:, 0]) * (whole[:, 2] - whole[:, 0]), axis=1)))
    return bool(abs(x - y) <= SQUARE * x and across <= SQUARE * x * y)
