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


def noise(problem: Problem) -> Array:
    """(n,) one sigma of each joint's torque about the model [N·m, N]; infinite where the model explains
    less than `SHOWS` of it (no load on that joint, or a column that means something else)."""
    measured = problem.campaign.poses.torque
    assert measured is not None
    left = project(problem, np.nan_to_num(measured)[..., None])[..., 0]
    sigma = np.full(measured.shape[1], np.inf)
    for j in range(len(sigma)):
        seen = np.isfinite(measured[:, j])
        if seen.sum() < 10:
            continue
        total = float(np.std(measured[seen, j]))
        rms = float(np.sqrt(np.sum(left[seen, j] ** 2) / max(seen.sum() - 3, 1)))
        if total > 0 and rms**2 < (1 - SHOWS) * total**2:
            sigma[j] = max(rms, 1e-6 * total)
    return sigma
