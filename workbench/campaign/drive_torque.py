"""Torques of the drives as a second witness: they show loads that positions hide behind geometry.

What a drive exerts holds the load's torque, times a motor constant that is known to a few percent, plus
friction and an offset. So per joint an offset, a scale and the friction of its side of approach are taken
out, and what is left is compared: a compensator that has lost charge changes the torque, an eccentric gear
does not. Cables, the motor's cogging and a sensor's crosstalk go with the joint's angle: what is no larger
than the torques are accurate, and does, is no load. What the columns mean at all is asked in
`torque_columns`.
"""

from __future__ import annotations

import numpy as np

from ..robot.kinematics import Array
from .drives import ACCURACY, LEAST
from .problem import Problem

SHOWS = 0.5  # share of a joint's torque that the model must explain for the column to be believed
FEWEST = 10  # torques of a joint from which its noise is taken
ROUNDS = 2  # of a load's size and what it leaves
WIDE = 1e3  # usual sizes of a load that nothing holds
TILT = 5e-3  # rad: how far the axis of a joint may lie from the model's


def project(problem: Problem, values: Array) -> Array:
    """(N, n, p) values without what each joint's drive may make of its own (`Drive`); zero where no torque
    was measured."""
    out = np.zeros_like(values)
    for j, drive in enumerate(problem.own_of_drives):
        out[drive.seen, j] = drive.left_of(values[drive.seen, j])
    return out


def axis_error(problem: Problem) -> Array:
    """(n,) [N·m, N] torque (RMS) that the stated loads make at each joint if its axis is off by `TILT`: no
    model of the torques is better, and at a vertical axis there is hardly any other."""
    slot, component = np.divmod(problem.arm.axial, 6)
    load = problem.nominal_load.local.reshape(len(problem.q), -1, 2, 3)
    own = load[:, slot, component // 3]
    return np.asarray(TILT * np.sqrt((own**2).sum(axis=2).mean(axis=0)) + LEAST)


def scatter(problem: Problem, moved: Array | None = None, largest: float = np.inf) -> Array:
    """(n,) [N·m, N] RMS of what the model leaves of each joint's torques, not less than `axis_error`;
    infinite where there are fewer than `FEWEST`.

    moved: (N, n, p) what a wrong load makes of the torques, as `project` leaves it, taken out as far as one
    size of it explains all joints, and not below the torques' `ACCURACY`; nothing of it where it would have
    to be larger than `largest`.
    """
    measured = problem.campaign.poses.torque
    assert measured is not None
    seen, least = np.isfinite(measured), axis_error(problem)
    known = np.nan_to_num(measured)
    left = project(problem, known[..., None])[..., 0]
    enough = seen.sum(axis=0) >= FEWEST
    free = np.maximum(seen.sum(axis=0) - [drive.taken.shape[1] for drive in problem.own_of_drives], 1)
    rms = np.maximum(np.sqrt((left**2).sum(axis=0) / free), least)
    least = np.maximum(least, np.minimum(rms, ACCURACY * np.abs(known).max(axis=0)))
    if moved is None:
        return np.where(enough, rms, np.inf)
    found, held = rms, np.eye(moved.shape[2]) / min(largest, WIDE)
    for _ in range(ROUNDS):
        columns = np.concatenate([(moved / found[:, None])[:, enough].reshape(-1, len(held)), held])
        wanted = np.concatenate([(left / found)[:, enough].ravel(), np.zeros(len(held))])
        size = np.linalg.lstsq(columns, wanted, rcond=None)[0]
        found = np.maximum(np.sqrt(((left - moved @ size) ** 2).sum(axis=0) / free), least)
    if np.abs(size).max(initial=0.0) <= largest:
        rms = found
    return np.where(enough, rms, np.inf)


def shown(rms: Array, total: Array) -> Array:
    """(n,) whether columns of that scatter are believed, of which the model leaves `rms` [N·m, N]."""
    return np.asarray(rms**2 < (1 - SHOWS) * total**2)
