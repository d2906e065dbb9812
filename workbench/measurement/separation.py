"""Yield and gear error of a swept joint told apart: by a known stiffness, or by the sweep alone.

A residual torque that is smooth along the sweep makes an error that is smooth too, and so do a gear's run-out
and a ratio that is a little wrong. What tells them apart within the sweep is only how their curves differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import problem_of
from ..diagnosis.weighing.scan import spectrum
from ..effects.base import Effect
from ..effects.gear_eccentricity import GearEccentricity
from ..effects.gear_kinematic_error import GearKinematicError
from ..effects.gear_ratio import GearRatio
from ..effects.joint_compliance import JointCompliance
from ..effects.place import Where
from ..identification.fit import Fit
from ..identification.restated import restated
from ..robot.description import Robot
from ..robot.kinematics import Array
from .sweep import GearLine, fit_sweep, gear_lines, joint_error

# What the gear may do besides its lines: in words, and how many of the smooth forms are free.
GEAR_FORMS = {
    "errs in its lines only": 0,
    "may also run out once per turn": 1,
    "…, twice, and in its ratio": 3,
}
ORDERS = np.arange(3.0, 700.0, 0.5)


@dataclass(frozen=True)
class Alone:
    """Stiffness from the sweep alone [N·m/rad], one sigma over it, and χ² of the points."""

    stiffness: float
    relative_std: float
    chi2: float


@dataclass(frozen=True, eq=False)
class Separation:
    """A sweep of N poses, told apart; angles in rad.

    q, error, gear: (N,) joint, its whole error, and the error without what the load makes; torque: (N,)
    residual [N·m], spring: (N,) its change by a compensator 1 % stronger; fundamental, lines_only: (N,) the
    fitted largest line, and all lines; before, after: how far a line of each of
    `orders` stands out of the noise, in σ, without and with the lines; alone: assumption on the gear → what
    the sweep says by itself; noise: σ of one pose's error.
    """

    q: Array
    error: Array
    gear: Array
    torque: Array
    spring: Array
    fundamental: Array
    lines_only: Array
    lines: Sequence[GearLine]
    orders: Array
    before: Array
    after: Array
    alone: dict[str, Alone]
    noise: float

    @property
    def yielded(self) -> Array:
        """(N,) [rad] what the load makes, its mean taken out."""
        return self.error - self.gear


def separate(robot: Robot, swept: Campaign, believed: Fit, joint: str) -> Separation:
    """The sweep by its known stiffness, and by itself.

    robot: nominal; swept: names the robot with the stiffness that is known; believed: the gear's fit to it.
    """
    j, problem = robot.joint_names.index(joint), problem_of(swept)
    nominal = robot.joints[j].data.stiffness
    if robot.compensator is None or nominal is None:
        raise ValueError(f"{robot.name}: needs a compensator, and a stiffness of {joint}")
    lines: list[Effect] = [e for e in believed.model.effects if isinstance(e, GearKinematicError)]
    stronger = robot.compensator.model_copy(update={"rate": 1.01 * (robot.compensator.rate or 0.0)})
    torque, other = (
        p.nominal_load.local.reshape(len(p.q), -1)[:, p.arm.axial[j]]
        for p in (problem, problem_of(replace(swept, robot=replace(swept.robot, compensator=stronger))))
    )
    waves = [_wave(believed, i, problem.q[:, j]) for i in range(len(lines))]
    bare = fit_sweep(swept, [e for e in believed.model.effects if e not in lines])
    column = believed.line.direct[:, :3, int(problem.arm.axial[j])]
    return Separation(
        q=problem.q[:, j],
        error=joint_error(replace(swept, robot=restated(robot, stiffness=None)), joint),
        gear=joint_error(swept, joint),
        torque=torque,
        spring=other - torque,
        fundamental=max(waves, key=lambda wave: float(wave.std())),
        lines_only=np.sum(waves, axis=0),
        lines=gear_lines(believed),
        orders=ORDERS,
        before=np.sqrt(np.maximum(spectrum(bare, j, ORDERS), 0.0)),
        after=np.sqrt(np.maximum(spectrum(believed, j, ORDERS), 0.0)),
        alone=_alone(replace(swept, robot=restated(swept.robot, [joint], stiffness=nominal)), lines, joint),
        noise=float((swept.noise_sigma or 0.0) / np.sqrt((column**2).sum(axis=1)).mean()),
    )


def _wave(found: Fit, i: int, q: Array) -> Array:
    effect = found.model.effects[i]
    order = effect.where.order or 0.0
    sine, cosine = found.state.values[i]
    return np.asarray(sine * np.sin(order * q) + cosine * np.cos(order * q))


def _alone(swept: Campaign, lines: list[Effect], joint: str) -> dict[str, Alone]:
    """The joint's stiffness from the sweep, for what the gear is allowed to do besides."""
    place = Where(joint=joint)
    smooth: list[Effect] = [GearEccentricity(place, "1"), GearEccentricity(place, "2"), GearRatio(place)]
    [yields] = [e for e in JointCompliance.each(problem_of(swept)) if e.where == place]
    found = {}
    for said, count in GEAR_FORMS.items():
        result = fit_sweep(swept, [*lines, *smooth[:count], yields])
        (value,), covariance = result.effect_values(len(lines) + count)
        compliance = 1 + float(value)
        std = float(np.sqrt(covariance[0, 0])) / abs(compliance)
        found[said] = Alone(1 / (yields.nominal * compliance), std, result.chi2)
    return found
