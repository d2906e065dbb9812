"""Torques of the drives as a second witness: they show loads that positions hide behind geometry.

What a drive exerts holds the load's torque, times a motor constant that is known to a few percent, plus
friction and an offset. So per joint an offset, a scale and the side of approach are taken out, and what
is left is compared: a compensator that has lost charge changes the torque, an eccentric gear does not.
"""

from __future__ import annotations

import numpy as np

from ..robot.kinematics import Array
from .problem import Problem

SHOWS = 0.5  # share of a joint's torque that the model must explain for the column to be believed
FEWEST = 10  # torques of a joint from which its noise is taken
TAKEN = 3  # numbers that are taken out: offset, scale and side
FREE = 0.5  # share of the poses that must be left when wrong loads are taken out as well
TILT = 5e-3  # rad: how far the axis of a joint may lie from the model's
LEAST = 1e-6  # N·m, N: of a joint without any load
FAINT = 1e-3  # of the torque: a load that makes less of it in its usual size is no part of it


def project(problem: Problem, values: Array) -> Array:
    """(N, n, p) values without what each joint's offset, scale and approach can make of them; zero where
    no torque was measured. The scale is that of the nominal arm's torques."""
    measured = problem.campaign.poses.torque
    assert measured is not None
    expected = problem.nominal_load.local.reshape(len(problem.q), -1)[:, problem.arm.axial]
    out = np.zeros_like(values)
    for j in range(measured.shape[1]):
        seen = np.isfinite(measured[:, j])
        basis = [np.ones(int(seen.sum())), expected[seen, j]]
        if problem.campaign.poses.side is not None:
            basis.append(problem.campaign.poses.side[seen, j].astype(float))
        B = np.column_stack(basis)
        B = B / np.maximum(np.linalg.norm(B, axis=0), 1e-12)
        Q = np.linalg.svd(B, full_matrices=False)[0][:, np.linalg.svd(B, compute_uv=False) > 1e-9]
        part = values[seen, j]
        out[seen, j] = part - Q @ (Q.T @ part)
    return out


def axis_error(problem: Problem) -> Array:
    """(n,) [N·m, N] torque (RMS) that the stated loads make at each joint if its axis is off by `TILT`: no
    model of the torques is better, and at a vertical axis there is hardly any other."""
    slot, component = np.divmod(problem.arm.axial, 6)
    load = problem.nominal_load.local.reshape(len(problem.q), -1, 2, 3)
    own = load[:, slot, component // 3]
    return np.asarray(TILT * np.sqrt((own**2).sum(axis=2).mean(axis=0)) + LEAST)


def noise(problem: Problem, moved: Array | None = None) -> Array:
    """(n,) one sigma of each joint's torque about the model [N·m, N]; infinite where the model explains
    less than `SHOWS` of it (no load on that joint, or a column that means something else).

    moved: (N, n, p) what every load that may be wrong makes of the torques, in its usual size, as `project`
    leaves it: none of that is noise, so a wrong load does not hide itself. The largest parts of it are taken
    out, as long as `FREE` of the poses are left to judge by.
    """
    measured = problem.campaign.poses.torque
    assert measured is not None
    left = project(problem, np.nan_to_num(measured)[..., None])[..., 0]
    sigma, least = np.full(measured.shape[1], np.inf), axis_error(problem)
    for j in range(len(sigma)):
        seen = np.isfinite(measured[:, j])
        count = int(seen.sum())
        if count < FEWEST:
            continue
        total = float(np.std(measured[seen, j]))
        rest, free = left[seen, j], count - TAKEN
        if moved is not None:
            U, size, _ = np.linalg.svd(moved[seen, j], full_matrices=False)
            most = max(int((1 - FREE) * count) - TAKEN, 0)
            U = U[:, : min(most, int((size > FAINT * np.sqrt(count) * total).sum()))]
            rest, free = rest - U @ (U.T @ rest), free - U.shape[1]
        rms = max(float(np.sqrt(np.sum(rest**2) / free)), float(least[j]))
        if rms**2 < (1 - SHOWS) * total**2:
            sigma[j] = rms
    return sigma
