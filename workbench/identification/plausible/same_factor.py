"""Lengths that are all off by the same factor: no robot is made so, the points are of another scale."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtr

from ...robot.kinematics import Array
from ..fit import Fit

LEAST = 1e-3  # of the lengths: aluminium that is 40 K warmer grows as much
CHANCE = 1e-4  # that lengths which have nothing to do with each other look so
TOLD = 100.0  # times what is taken for granted of a length: the data tell it
LONG = 1.0  # times what a length may be off by: a shorter one can be off by all of itself, whatever the scale


def common_factor(geometry: Fit) -> list[str]:
    """A remark where the points are larger or smaller than the robot, as by its lengths.

    A machine's lengths, whichever the data tell, are off independently of each other, by as much as they are:
    a common factor shows as the slope of their errors over their sizes, and Student's t says whether it is by
    chance.
    """
    errors, sizes = _told_lengths(geometry)
    long = np.abs(sizes) > LONG
    errors, sizes = errors[long], sizes[long]
    if len(errors) < 3:
        return []
    square = float(sizes @ sizes)
    factor = float(sizes @ errors) / square
    left = float(np.sum((errors - factor * sizes) ** 2)) / (len(errors) - 1)
    std = float(np.sqrt(left / square)) + 1e-12
    if abs(factor) < LEAST or 2 * stdtr(len(errors) - 1, -abs(factor) / std) > CHANCE:
        return []
    robot, known = geometry.model.problem.robot, 1 / (1 + factor)
    return [
        f"All lengths come out {1 + factor:.4f} ± {std:.4f} times those of the {robot.title}: no robot is "
        "made so. The points are of another scale (the instrument's correction for air, a unit), or this is "
        f"another size of robot. If it is the instrument, say scale = {known:.4f} under [known]."
    ]


def _told_lengths(geometry: Fit) -> tuple[Array, Array]:
    """Combinations of shifts that the data tell, whatever frames, targets and turns are: how far they are
    off, and how large they are, both (k,) in units of what is expected of machines."""
    columns, arm = geometry.columns, geometry.model.problem.arm
    J = (geometry.J * columns.prior).reshape(-1, len(columns.prior))
    every = np.arange(J.shape[1])
    shifts = every[columns.geometry_slice][columns.geometry % 6 < 3]
    others = np.setdiff1d(every, shifts)
    normal = J.T @ J + np.eye(J.shape[1])
    across = normal[np.ix_(shifts, others)]
    own = normal[np.ix_(shifts, shifts)] - across @ np.linalg.solve(normal[np.ix_(others, others)], across.T)
    certain, ways = np.linalg.eigh(own)
    ways = ways[:, certain > TOLD]
    slot, axis = np.divmod(columns.geometry[columns.geometry % 6 < 3], 6)
    nominal = np.einsum("sji,sj->si", arm.R, arm.p)[slot, axis]
    off = (geometry.state.geometry - arm.geometry)[slot, axis]
    return ways.T @ (off / columns.prior[shifts]), ways.T @ (nominal / columns.prior[shifts])
