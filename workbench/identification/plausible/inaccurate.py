"""A robot whose zeros and lengths are off in many places at once, by what those of machines are.

Fitted, such errors are gone: no mistake in a table goes away so.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..fit import Fit, fit, start_state
from ..model import Model, State
from ..noise import Covariance
from .few_poses import measured_and_needed
from .misfit import USUAL, Sample, misfit

FARTHEST_TURN = np.radians(6.0)  # of a joint or its zero: mastered wrong, a belt some teeth off
FARTHEST_SHIFT = 0.02  # m, of a joint: more is another variant of the robot
EXACT = 1e-3  # m, one sigma to which points are believed: they outweigh what is expected of machines
WILD = 5.0  # times the middle pose's misfit: poses from there on do not count,
MUCH = 0.012  # of the spread, to be left
MOST = 0.9  # where at least so many do: more than a tenth is no chance


def inaccurate(problem: Problem, data: Sample, enough: float) -> str | None:
    """How far the geometry is from the URDF's where that, as machines are, leaves `enough` at most."""
    measured, needed = measured_and_needed(problem)
    if measured <= needed:  # whatever the points are, it would explain them
        return None
    campaign = problem.campaign.some(data.rows)
    some = Problem(problem.robot, problem.arm, campaign, problem.compensator)
    with suppress(ArithmeticError):
        return _told(_geometry(some), data, enough * float(np.sqrt(1 - needed / measured)))
    return None


def _geometry(problem: Problem) -> Fit:
    """Fitted to those poses that are not far off all others."""
    model, start = Model(problem, ()), start_state(problem)
    weight = _usual(problem, model, start)
    noise = Covariance(np.full(problem.seen.shape, EXACT), np.zeros(problem.arm.n), weight)
    return fit(model, start, noise)


def _usual(problem: Problem, model: Model, start: State) -> Array:
    """(N,) 1 of a pose that is no farther off than usual, else 0."""
    off = np.linalg.norm(problem.campaign.points - model.predict(start), axis=2)
    farthest = np.where(problem.seen, off, 0.0).max(axis=1)
    return np.asarray((farthest <= WILD * np.median(farthest)).astype(np.float64))


def _told(geometry: Fit, data: Sample, enough: float) -> str | None:
    problem, fitted = geometry.model.problem, geometry.state.geometry
    change = fitted - problem.arm.geometry
    shift, turn = np.linalg.norm(change[:, :3], axis=1), np.linalg.norm(change[:, 3:], axis=1)
    if shift.max() > FARTHEST_SHIFT or turn.max() > FARTHEST_TURN:
        return None
    counted = geometry.noise.weight > 0
    nearly_all = data.only(np.flatnonzero(counted)).changed(arm=data.arm.with_geometry(fitted))
    left = misfit(nearly_all)
    if counted.mean() < MOST or left.share > enough:
        return None
    names = problem.arm.names
    longest, widest = int(np.argmax(shift)), int(np.argmax(turn))
    much = (
        f" That leaves {1e3 * left.middle * left.spread:.2g} mm, which is much." if left.share > MUCH else ""
    )
    if left.displaced:
        far = f"{1e3 * (left.displaced * left.spread + USUAL):.0f} mm"
        much += f" Targets are found up to {far} from where they are stated: the measured places are used."
    return (
        f"The geometry is up to {1e3 * shift[longest]:.1f} mm ({names[longest - 1]}) and "
        f"{np.degrees(turn[widest]):.2f}° ({names[widest - 1]}) from the URDF's: it is fitted. Joints may be "
        f"mastered wrong, or this is another variant of the {problem.robot.title}.{much}"
    )
