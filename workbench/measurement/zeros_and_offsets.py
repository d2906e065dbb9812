"""Joint zeros θ and offsets d from points of one ball, where lengths a and twists α are known.

The second step of Liu et al., eqs. (33)–(35), after the circle points: rows are those of standard
Denavit–Hartenberg (`denavit_hartenberg.py`). Marks on the base give the frame. A `SimulatedArm` is built as
one table and told as another, which is how a study of such a calibration knows the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..campaign import Campaign, Target, join
from ..campaign.planned import planned
from ..campaign.problem import problem_of
from ..effects.base import Effect
from ..effects.bearing_tilt import BearingTilt
from ..effects.gear_ratio import GearRatio
from ..effects.joint_compliance import JointCompliance
from ..effects.records import stated_effects
from ..identification.denavit_hartenberg import axial_columns, corrections, with_rows
from ..identification.fit import Fit, fit
from ..identification.model import Model
from ..identification.noise import required_noise
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.schema import EffectRecord
from ..simulation.virtual_campaign import Truth, simulate

FRAME = 0.01  # noise of a mark on the base over that of the ball: measured often, it gives the frame


@dataclass(frozen=True)
class SimulatedArm:
    """An arm built as rows `practical` (n, 4), told as rows `nominal`, which its URDF has.

    instrument: R (1, 3, 3), t (1, 3) [m] of the base in the instrument's frame; targets: the ball on the hand
    first, then the marks on the base; sigma: noise per axis [m]; payloads: name → mass and centre of mass.
    """

    nominal: Array
    practical: Array
    instrument: tuple[Array, Array]
    targets: Sequence[Target]
    sigma: float
    payloads: Mapping[str, tuple[float, Sequence[float]]] = field(default_factory=dict)

    def poses(self, count: int, seed: int | Sequence[int], limit: float = 90) -> Array:
        """(count, n) random joints within ±limit [°]."""
        shape = count, len(self.nominal)
        return np.radians(limit) * np.random.default_rng(seed).uniform(-1, 1, shape)

    def measured(
        self,
        robot: Robot,
        q: Array,
        seed: Sequence[int],
        targets: Sequence[Target] = (),
        payload: Sequence[str] | None = None,
        ratio: Array | None = None,
        yields: Mapping[int, Callable[[Array], Array]] | None = None,
    ) -> Campaign:
        """Measured in Drake in poses q: (N, n), with the robot's compliance.

        targets: other ones; payload: (N) names; ratio: (n,) travel over the commanded one, minus one;
        yields: further laws, as in `Truth`.
        """
        payloads = self.payloads if payload else None
        plan = planned(robot, q, targets=targets or self.targets, payloads=payloads, payload=payload)
        problem = problem_of(plan)
        geometry, behind = corrections(problem.arm, self.nominal, self.practical)
        places = problem.stated_targets.copy()
        hand = np.array(problem.on) == problem.arm.n + 1
        places[hand] = places[hand] @ behind[:3, :3].T + behind[:3, 3]
        ratios = zip(
            GearRatio.sites(problem), [] if ratio is None else ratio[:, None], strict=ratio is not None
        )
        truth = Truth(
            geometry,
            tuple(ratios),
            yields=yields or {},
            targets=places,
            sigma=self.sigma,
        )
        number = int(np.random.default_rng(seed).integers(2**31))
        return simulate(plan, truth, seed=number, instrument=self.instrument)


def with_rows_and_ratios(robot: Robot, nominal: Array, rows: Array, ratio: Array) -> Robot:
    """The robot with DH rows (n, 4) instead of the URDF's `nominal` and travel over commanded travel (n,)."""
    ratios = tuple(
        EffectRecord(cause=GearRatio.cause, joint=name, values={"relative": float(r - 1)})
        for name, r in zip(robot.joint_names, ratio, strict=True)
    )
    return replace(with_rows(robot, nominal, rows), effects=ratios)


def with_ball(campaign: Campaign, x: float) -> Campaign:
    """The first target known to sit x [m] along the flange's x axis: the last row's a."""
    return replace(campaign, targets=(replace(campaign.targets[0], xyz=(x, 0, 0)), *campaign.targets[1:]))


def identified(campaign: Campaign, robot: Robot, free: Sequence[int] | None = None) -> Fit:
    """Fits d and θ of the robot (or `free` columns of its geometry); the marks on the base give the frame.

    Raises `InputError` where the campaign states no noise.
    """
    problem = problem_of(replace(campaign, robot=robot))
    noise = required_noise(problem)
    weight = np.where([target.on == "base" for target in campaign.targets], FRAME, 1.0)
    columns = axial_columns(robot) if free is None else free
    model = Model(problem, (), tuple(stated_effects(problem)))
    return fit(model, noise=replace(noise, sigma=noise.sigma * weight), geometry=columns)


def fit_at_once(campaigns: Sequence[Campaign], robot: Robot, compliance: bool = True) -> Fit:
    """One fit instead of two steps: all geometry, ratios and targets, and the compliance of the joints and
    bearings that gravity loads: neither an upright first joint nor what turns the ball about itself."""
    freed = [
        replace(c, robot=robot, targets=tuple(replace(t, fixed=t.on == "base") for t in c.targets))
        for c in campaigns
    ]
    problem = problem_of(join(freed) if len(freed) > 1 else freed[0])
    effects: list[Effect] = list(GearRatio.sites(problem))
    if compliance:
        effects += [*JointCompliance.each(problem)[1:-1], *BearingTilt.even(problem)[:-1]]
    return fit(Model(problem, tuple(effects)))


def error_of(found: Fit, judged: Campaign) -> Array:
    """(N, 3) [m] measured minus predicted ball in poses that were not fitted, seen from the last set-up."""
    problem, own = problem_of(replace(judged, robot=found.model.problem.robot)), found.model.problem.campaign
    place = [target.name for target in own.targets].index("ball")
    state = replace(
        found.state,
        R=found.state.R[-1:],
        t=found.state.t[-1:],
        targets=np.concatenate(
            [found.state.targets[-1:, place, None], problem.stated_targets[None, 1:]], axis=1
        ),
    )
    return np.asarray((judged.points - replace(found.model, problem=problem).predict(state))[:, 0])


def error_lengths(found: Fit, judged: Campaign) -> Array:
    """(N,) [mm] length of these errors."""
    return np.asarray(1e3 * np.linalg.norm(error_of(found, judged), axis=1))
