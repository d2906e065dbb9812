"""Noise of a 6-D measurement: of its shifts, which may be stated, and of its turns, which nobody states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.problem import Problem
from ...identification.fit import Fit
from ...identification.model import Linearisation
from ...identification.noise import FEWEST_DOF, LEAST, Covariance, turn_of_points
from ...identification.repeats import scatter_of_repeats
from ...identification.rows import from_middle, whitening
from ...robot.kinematics import Array
from .likeliest import CLEARLY, with_more

LESS = 0.8  # times the noise of a turn: by less it is as it was taken for
SIX = 6  # motions of a rigid pose


def of_poses(result: Fit) -> Covariance:
    """The noise that a fit's residual shows: variances of shifts and of turns, and the joints' common one
    where that is clearly there."""
    problem = result.model.problem
    about = _steadiest(result)
    unit = _unit(result, about)
    d, W = _motions(result, unit)
    turning = np.where(problem.arm.prismatic, 0.0, 1.0)
    J = W @ (result.line.by_joint * turning)[_used(result)]
    each = [np.repeat([1.0, 0.0], 3), np.repeat([0.0, 1.0], 3)]
    parts = [*(np.broadcast_to(np.diag(one), (len(d), SIX, SIX)) for one in each), J @ J.transpose(0, 2, 1)]
    shift, turn, joint = with_more(d, np.ones(d.shape, bool), parts, 2, _lost(result, d))
    return replace(unit, sigma=shift * unit.sigma, turn_ratio=turn / shift, joint=joint * turning)


def of_turns(result: Fit, stated: Covariance) -> Covariance | None:
    """A stated noise with that of its turning part from the residual of a fit, and with the point about which
    it turns; None where both are as they were taken for. More turning than it was taken for is what the fit
    has as scatter of the body's turns; less shows in the residual: a model's errors turn the tool too."""
    about = _steadiest(result)
    moved = replace(stated, about=about)
    more = result.noise.body[1]
    if more > 0:
        turn = float(np.hypot(1.0, more / turn_rad(result, stated)))
        return replace(moved, turn_ratio=stated.turn_ratio * turn)
    d, _ = _motions(result, result.noise)
    turn = float(np.sqrt(np.mean(d[:, 3:] ** 2) * _lost(result, d)))
    if turn < LESS:
        return replace(moved, turn_ratio=stated.turn_ratio * turn)
    return None if about == stated.about else moved


def turn_rad(result: Fit, noise: Covariance) -> float:
    """[rad] one sigma about each axis of a noise's turns."""
    problem = result.model.problem
    of_points = turn_of_points(problem, from_middle(problem, result.line.prediction.points))
    return noise.turn_ratio * noise.usual * float(np.median(of_points[_used(result)]))


def of_repeats(problem: Problem, line: Linearisation) -> Covariance | None:
    """The noise by how repeats scatter, the robot's part included; None where there are too few. Shifts have
    as many degrees of freedom as turns."""
    deviation, weight, dof = scatter_of_repeats(problem)
    each = dof / problem.seen.shape[1]
    if each < FEWEST_DOF:
        return None
    unit = Covariance(np.ones(problem.seen.shape), np.zeros(problem.arm.n), np.ones(len(weight)), dof=each)
    W = whitening(problem, line, unit)[:, :SIX, : 3 * problem.seen.shape[1]]
    d = np.einsum("nde,ne->nd", W, deviation.reshape(len(W), -1))
    shift, turn = (max(float(np.sqrt(np.sum(part**2) / each)), LEAST) for part in (d[:, :3], d[:, 3:]))
    return replace(unit, sigma=shift * unit.sigma, turn_ratio=turn / shift)


def _steadiest(result: Fit) -> int:
    """The target that scatters least, as far as that is clear; else the middle of all (-1)."""
    scatter = [
        float(np.mean(_motions(result, _unit(result, about))[0][:, :3] ** 2))
        for about in range(-1, result.residual.shape[1])
    ]
    rows = 3 * int(_used(result).sum())
    gain = rows * np.log(scatter[0] / np.array(scatter))
    best = int(np.argmax(gain))
    return best - 1 if gain[best] >= CLEARLY else -1


def _unit(result: Fit, about: int) -> Covariance:
    """A noise of 1 m of points and nothing else."""
    noise = result.noise
    none = np.zeros_like(noise.joint)
    every = np.ones_like(noise.sigma)
    return replace(noise, sigma=every, joint=none, turn_ratio=1.0, about=about, body=(0.0, 0.0))


def _motions(result: Fit, noise: Covariance) -> tuple[Array, Array]:
    """The motions (M, 6) of the poses that count, whitened by a noise, and what makes them of the points
    (M, 6, 3T)."""
    rows = 3 * result.residual.shape[1]
    W = whitening(result.model.problem, result.line, noise)[:, :SIX, :rows][_used(result)]
    r = np.nan_to_num(result.residual).reshape(-1, rows)[_used(result)]
    return np.einsum("nde,ne->nd", W, r), W


def _used(result: Fit) -> Array:
    """(N,) whether a pose counts."""
    return np.asarray(np.abs(result.whitener).sum(axis=(1, 2)) > 0)


def _lost(result: Fit, d: Array) -> float:
    """By how much a fit made squares smaller."""
    return float(d.size / max(d.size - result.rank, 1))
