"""Poses measured before and after loading: what the load alone moves, and compliances from it.

Each configuration is a set-up of its own, so the instrument's frame is fitted anew to it: whatever is
equal before and after (geometry, zeros, dead weight, a compensator's pull) goes into that frame, and only
loaded minus unloaded speaks. That is the linear estimate k = (Σ BᵀB)⁻¹ Σ Bᵀ Δp of Klimchik et al. (2017),
eqs. (8)–(11), with the workbench's own statics for B and iterated about the loaded pose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..campaign import Campaign, Target
from ..campaign.planned import planned
from ..campaign.problem import Problem, problem_of
from ..effects.base import Effect
from ..effects.joint_compliance import JointCompliance
from ..identification.fit import Fit, fit, start_state
from ..identification.model import Model
from ..identification.noise import Covariance
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..simulation.virtual_campaign import Truth, simulate

Load = tuple[float, Sequence[float]]


def pairs(
    robot: Robot, q: Array, load: Load, pull: Array, targets: Sequence[Target], tool: Load, title: str = ""
) -> Campaign:
    """The plan: each of C configurations q: (C, n) before and after loading, its own set-up.

    load: mass [kg] and place [m] on the flange of what hangs there, where `pull` is zero; pull: (C, 3) [N]
    force at the same place instead, as a cable exerts it, in the base frame. Rows 0..C−1 are before loading.
    """
    count = len(q)
    pulled = [bool(force.any()) for force in pull]
    plan = planned(
        robot,
        np.vstack([q, q]),
        targets=targets,
        payloads={"load": load},
        payload=[""] * count + ["" if by_cable else "load" for by_cable in pulled],
        tool=tool,
        setup=[f"P{i + 1}" for i in range(count)] * 2,
        title=title,
    )
    where = problem_of(plan).rigid
    lever = where.R[-1][count:] @ np.asarray(load[1])
    wrench = np.zeros((2 * count, 6))
    wrench[count:] = np.hstack([pull, np.cross(lever, pull)])
    return plan.with_poses(wrench=wrench)


def fit_pairs(campaign: Campaign, effects: Callable[[Problem], Sequence[Effect]], sigma: float) -> Fit:
    """Effects from loaded minus unloaded poses; sigma: noise per axis [m]. Geometry stays as it is."""
    problem = problem_of(campaign)
    setups = len(campaign.setup_names)
    start = start_state(problem_of(as_one_setup(campaign)))  # the instrument stood still: one serves all
    R, t, targets = (np.repeat(part, setups, axis=0) for part in (start.R, start.t, start.targets))
    start = replace(start, R=R, t=t, targets=targets)
    noise = Covariance(np.full(problem.seen.shape, sigma), np.zeros(problem.arm.n), np.ones(len(problem.q)))
    return fit(Model(problem, tuple(effects(problem))), start, noise, geometry=False)


def measure_pairs(plan: Campaign, truth: Truth, seed: int, instrument: tuple[Array, Array]) -> Campaign:
    """The pairs of a plan, measured in Drake by an instrument that stands still: R (3, 3), t (3,).

    The robot stands still while it is loaded, so its repeatability is in both readings alike.
    """
    half, setups = len(plan.poses.q) // 2, len(plan.setup_names)
    spread = [joint.data.repeatability or 0.0 for joint in plan.robot.joints]
    rest = np.random.default_rng([seed, 0]).normal(scale=spread, size=(half, len(spread)))
    still = replace(truth, repeatability=np.zeros(len(spread)), joints=lambda _: np.tile(rest, (2, 1)))
    R, t = (np.repeat(part[None], setups, axis=0) for part in instrument)
    return simulate(plan, still, seed=seed, instrument=(R, t))


def as_one_setup(campaign: Campaign) -> Campaign:
    """The same records read as absolute poses: one instrument frame for all."""
    return replace(campaign.with_poses(setup=np.zeros_like(campaign.poses.setup)), setup_names=("",))


def compliances(found: Fit) -> tuple[Array, Array]:
    """Fitted compliances (E,) and their standard deviations [rad/(N·m)], in the effects' order."""
    nominal = np.array([getattr(effect, "nominal", 0.0) for effect in found.model.effects])
    one = [found.effect_values(i) for i in range(len(nominal))]
    relative = np.array([values[0] for values, _ in one])
    std = np.array([np.sqrt(covariance[0, 0]) for _, covariance in one])
    return nominal * (1 + relative), nominal * std


def difference_rows(campaign: Campaign) -> Array:
    """(C, 3T, n) motion of the targets by the load of C pairs, per unit of each joint's compliance over the
    model's. The rows A of that paper's criteria (14), (17), (18), about the nominal loaded pose."""
    problem = problem_of(as_one_setup(campaign))
    model = Model(problem)
    line = model.linearise(model.in_base())
    parts = [model.effect_jacobian(line, effect, np.zeros(1)) for effect in JointCompliance.each(problem)]
    rows = np.concatenate(parts, axis=2)
    half = len(problem.q) // 2
    return np.asarray(rows[half:] - rows[:half])
