"""A joint swept alone in small steps, a target on its link: the joint's error over its angle, and its lines.

Olabi et al. (2012), section III: the measured angle minus the commanded one; what the model says of the load
is taken off, the rest is the gear. The circle on which the target runs is found from the points' places
across and off it, never along it: so no error of the joint goes into the instrument's frame, but for a
constant turn, which no instrument outside can know.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..campaign import Campaign, Target
from ..campaign.planned import planned
from ..campaign.problem import Problem, problem_of
from ..diagnosis.run import diagnose
from ..diagnosis.weighing.scan import spectrum
from ..effects.base import Effect
from ..effects.gear_eccentricity import GearEccentricity
from ..effects.gear_kinematic_error import GearKinematicError
from ..effects.place import Where
from ..effects.records import stated_effects
from ..identification.fit import Fit, fit, refit
from ..identification.model import Model
from ..identification.noise import Covariance, stated_noise
from ..robot.description import Robot
from ..robot.kinematics import Array

FREE = 1.0  # rad: a joint that is free to stand anywhere
SURE = 13.8  # χ² with 2 degrees of freedom that chance reaches once in a thousand
DROP = 3.84  # of a likelihood ratio at the ends of a 95 % interval


@dataclass(frozen=True)
class GearLine:
    """One line of a gear's error: order in cycles per joint turn with its 95 % interval, amplitude and its
    standard deviation [rad]."""

    order: float
    low: float
    high: float
    amplitude: float
    std: float


def sweep(
    robot: Robot, joint: str, q: ArrayLike, ends: tuple[float, float], count: int, target: Target
) -> Campaign:
    """A plan: joint from end to end [rad] in `count` poses, the others as in q (n,), one target."""
    every = np.tile(np.asarray(q, dtype=np.float64), (count, 1))
    every[:, robot.joint_names.index(joint)] = np.linspace(*ends, count)
    degrees = np.rad2deg(ends)
    title = f"{robot.title}, {joint} from {degrees[0]:.0f} to {degrees[1]:.0f} deg in {count} poses"
    return planned(robot, every, targets=(target,), title=title)


def joint_error(campaign: Campaign, joint: str) -> Array:
    """(N,) measured minus predicted angle of a joint [rad], its mean taken out.

    What the campaign's robot says of loads and gears is in the prediction: a rigid robot leaves the whole
    error, one with its stiffness leaves the gear's.
    """
    problem, model, noise = _ready(campaign)
    j = problem.joint(joint)
    free = np.where(np.arange(problem.arm.n) == j, FREE, noise.joint)
    circle = fit(model, None, replace(noise, joint=free), geometry=False)
    rows = 3 * problem.seen.shape[1]
    g = circle.line.direct[:, :rows, int(problem.arm.axial[j])]
    r = np.nan_to_num(circle.residual).reshape(len(g), -1)
    error = (g * r).sum(axis=1) / (g**2).sum(axis=1)
    return np.asarray(error - error.mean())


def fit_sweep(campaign: Campaign, effects: Sequence[Effect]) -> Fit:
    """Effects, instrument frame and target fitted to a sweep; geometry and the robot's own effects hold."""
    _, model, noise = _ready(campaign)
    return fit(replace(model, effects=tuple(effects)), None, noise, geometry=False)


def gear_of(campaign: Campaign, joint: str) -> Fit:
    """The gear of a swept joint: the lines that the diagnosis finds, ratio known or not, and run-out of one
    cycle per turn where it is beyond chance (p < 0.001)."""
    lines: list[Effect] = [
        effect
        for effect in diagnose(campaign).fit.model.effects
        if effect.cause == GearKinematicError.cause and effect.where.joint == joint
    ]
    with_run_out = fit_sweep(campaign, [*lines, GearEccentricity(Where(joint=joint), "1")])
    return with_run_out if with_run_out.wald(len(lines)) > SURE else fit_sweep(campaign, lines)


def shaft(lines: Sequence[GearLine]) -> tuple[float, list[int]]:
    """The shaft whose turns the largest line counts in whole cycles, together with most others: its turns per
    joint turn, and the cycles per turn of each line (0: not of this shaft).

    The harmonic-drive type errs twice per turn; so the shaft turns half as often as the largest line cycles.
    """
    turns = lines[0].order / 2
    cycles = []
    for line in lines:
        whole = round(line.order / turns)
        near = abs(line.order - whole * turns) <= max(line.high - line.low, 0.3)
        cycles.append(whole if near else 0)
    return turns, cycles


def gear_lines(found: Fit) -> list[GearLine]:
    """The gear lines of a fit, largest first, with the interval of each order."""
    lines = []
    for i, effect in enumerate(found.model.effects):
        if effect.where.order is not None:
            values, covariance = found.effect_values(i)
            amplitude = effect.report(values, covariance)[0]
            low, high = _order_interval(found, effect)
            lines.append(GearLine(effect.where.order, low, high, amplitude.value, amplitude.std))
    return sorted(lines, key=lambda line: -line.amplitude)


def _order_interval(found: Fit, effect: Effect) -> tuple[float, float]:
    """95 % interval of a line's order, from the likelihood along the order, the other lines kept."""
    without = refit(found, [e for e in found.model.effects if e is not effect])
    j = found.model.problem.joint(effect.where.joint)
    width = 2 * np.pi / float(np.ptp(found.model.problem.q[:, j]))
    orders = (effect.where.order or 0.0) + np.linspace(-width / 2, width / 2, 401)
    T = spectrum(without, j, orders)
    inside = orders[T.max() - DROP <= T]
    return float(inside.min()), float(inside.max())


def _ready(campaign: Campaign) -> tuple[Problem, Model, Covariance]:
    problem = problem_of(campaign)
    noise = stated_noise(problem)
    if noise is None:
        raise ValueError(f"{campaign.title}: state the instrument's noise")
    return problem, Model(problem, (), tuple(stated_effects(problem))), noise
