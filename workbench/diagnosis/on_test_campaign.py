"""Errors on a campaign that nothing was fitted on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..files.faults import Fault, InputError
from ..identification.fit import Fit, fit
from ..identification.model import Model, State
from ..identification.noise import Covariance
from ..identification.registration import check_units, register
from ..robot.kinematics import Array
from .result import TestFigures


def test_figures(nominal: Fit, final: Fit, campaign: Campaign) -> TestFigures:
    """Errors before (nominal robot) and after (final model) on `campaign`.

    Frame and targets come from the fitted set-up of the same name; only set-ups that the fitted
    campaigns do not have get their own, fitted on the test poses.
    """
    fitted = final.model.problem
    if campaign.robot.joint_names != fitted.robot.joint_names:
        raise InputError(
            Fault(
                str(campaign.path),
                f"its robot is {campaign.robot.name}",
                f"give a test of {fitted.robot.name}",
            )
        )
    problem = Problem(fitted.robot, fitted.arm, campaign, fitted.compensator)
    check_units(problem)
    before = _lengths(problem, nominal)
    after = _lengths(problem, final)
    mm = 1e3
    return TestFigures(
        campaign=campaign.title,
        before_mean_mm=mm * float(np.nanmean(before)),
        after_mean_mm=mm * float(np.nanmean(after)),
        after_rms_mm=mm * float(np.sqrt(np.nanmean(after**2))),
        after_max_mm=mm * float(np.nanmax(after)),
        before_max_mm=mm * float(np.nanmax(before)),
        n_points=int(np.isfinite(after).sum()),
    )


test_figures.__test__ = False  # type: ignore[attr-defined]  # not a pytest function


def _lengths(problem: Problem, result: Fit) -> Array:
    """(N, T) error lengths [m] of the test campaign, NaN where not seen."""
    known = tuple(
        (effect, values)
        for effect, values in result.model.acting(result.state)
        if effect.lasting
        and effect.needs(problem) is None
        and (effect.where.payload is None or effect.where.payload in problem.campaign.payload_names)
    )
    problem = replace(problem, arm=problem.arm.with_geometry(result.state.geometry))
    model = Model(problem, (), known)
    state = _carried(problem, result)
    new = [
        name for name in problem.campaign.setup_names if name not in result.model.problem.campaign.setup_names
    ]
    if new:
        state = _own_setups(model, state, new)
    residual = problem.campaign.points - model.predict(state)
    return np.asarray(np.where(problem.seen, np.linalg.norm(residual, axis=2), np.nan))


def _carried(problem: Problem, result: Fit) -> State:
    """The fitted state with frames and targets arranged for the test campaign's set-ups and targets."""
    fitted = result.model.problem.campaign
    R, t, targets = register(problem)
    for k, name in enumerate(problem.campaign.setup_names):
        if name not in fitted.setup_names:
            continue
        source = fitted.setup_names.index(name)
        R[k], t[k] = result.state.R[source], result.state.t[source]
        for i, target in enumerate(problem.campaign.targets):
            match = [j for j, other in enumerate(fitted.targets) if other.name == target.name]
            if match:
                targets[k, i] = result.state.targets[source, match[0]]
    return State(result.state.geometry, R, t, targets)


def _own_setups(model: Model, state: State, new: list[str]) -> State:
    """Frame and targets of set-ups that were not fitted, from the test poses, robot unchanged."""
    problem = model.problem
    c = problem.campaign
    weight = np.isin(np.array(c.setup_names)[c.poses.setup], new).astype(float)
    noise = Covariance(np.full(problem.seen.shape, 1e-4), np.zeros(problem.arm.n), weight)
    result = fit(model, state, noise, geometry=False)
    R, t, targets = state.R.copy(), state.t.copy(), state.targets.copy()
    for name in new:
        k = c.setup_names.index(name)
        R[k], t[k], targets[k] = result.state.R[k], result.state.t[k], result.state.targets[k]
    return replace(state, R=R, t=t, targets=targets)
