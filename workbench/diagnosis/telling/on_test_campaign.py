"""Errors on a campaign that nothing was fitted on."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign, Target
from ...campaign.other_tools import tool_as_in
from ...campaign.problem import Problem
from ...campaign.stepped import was_split
from ...files.faults import Fault, InputError
from ...identification.fit import Fit, fit
from ...identification.model import Model, State
from ...identification.noise import Covariance
from ...identification.plausible import believed
from ...identification.plausible.check import REFUSED
from ...identification.plausible.misfit import USUAL
from ...identification.registration import register, spread_of
from ...robot.kinematics import Array
from ..data_faults.moved_setup import Step, split_setup, step_in_time
from ..data_faults.wild_points import ROUNDS, mended, wild_limit, without_gross, without_impossible
from ..found import FaultFound, TestFigures
from .remarks_on_test import beyond_measured, elsewhere, nothing_new, worse

TEST = "of the test"  # a set-up that nobody named


def test_figures(nominal: Fit, final: Fit, campaign: Campaign) -> TestFigures:
    """Errors before (nominal robot) and after (what lasts of the final model) on `campaign`.

    Frame and targets come from the fitted set-up of the same name; only set-ups that the fitted
    campaigns do not have, or have in two parts, get their own, fitted on the test poses, as does what comes
    after a step in the test's course. Data faults are left out by the rules of the fit; the figures of all
    points stand beside.
    """
    final = final.lasting
    fitted = final.model.problem
    if fitted.campaign.tool_mass == 0.0:
        campaign = tool_as_in(fitted.campaign.payloads, campaign)
    every = Problem(fitted.robot, fitted.arm, campaign, fitted.compensator)
    possible = without_impossible(every)
    placed, apart = _set_up_anew(possible.problem, final)
    meant, said = believed(_as_found(placed, final))
    problem, faults = _cleaned(meant, final)
    step = _step(problem, final) if problem.seen.any() else None
    if step is not None:  # as in a fit: what came after it has a frame and targets of its own
        problem, faults = _cleaned(split_setup(meant, step.first), final)
        faults = (step.fault(problem), *faults)
    before, after = _errors(problem, nominal), _errors(problem, final)
    if not problem.seen.any():
        raise InputError(Fault(str(campaign.path), "no usable point is left", "look at the points"))
    whole = after if step is None else _errors(meant, final)
    off = np.linalg.norm(possible.problem.campaign.points - whole.predicted, axis=2)
    all_points = np.where(problem.seen & (step is None), after.length, off)
    beyond = beyond_measured(problem.campaign, final)
    moved = elsewhere(problem.campaign, after.predicted, _new_setups(problem, fitted), beyond)
    no_better = worse(before.length, after.length, beyond)
    mm = 1e3
    return TestFigures(
        campaign=campaign.title,
        before_mean_mm=mm * float(np.nanmean(before.length)),
        after_mean_mm=mm * float(np.nanmean(after.length)),
        after_rms_mm=mm * float(np.sqrt(np.nanmean(after.length**2))),
        after_max_mm=mm * float(np.nanmax(after.length)),
        before_max_mm=mm * float(np.nanmax(before.length)),
        n_points=int(np.isfinite(after.length).sum()),
        all_mean_mm=mm * float(np.nanmean(all_points)),
        all_rms_mm=mm * float(np.sqrt(np.nanmean(all_points**2))),
        faults=(*possible.faults, *faults),
        notes=(*apart, *map(str, moved), *nothing_new(campaign, final), *no_better, *said),
        moved=tuple((one.setup, mm * one.shift, mm * one.left) for one in moved),
    )


def _set_up_anew(problem: Problem, final: Fit) -> tuple[Problem, tuple[str, ...]]:
    """The test campaign with a name for a set-up that has none, as the fitted one, and stands so far from
    it that the points would be refused as of no such robot: nobody said that it is the same. And a word on
    it."""
    campaign, fitted = problem.campaign, final.model.problem
    if "" not in campaign.setup_names or "" not in fitted.campaign.setup_names:
        return problem, ()
    beyond = beyond_measured(campaign, final)
    found = elsewhere(campaign, _errors(problem, final).predicted, _new_setups(problem, fitted), beyond)
    one = next((one for one in found if not one.setup), None)
    if one is None or one.before <= REFUSED * spread_of(campaign.points[problem.seen]):
        return problem, ()
    said = (
        f"The test campaign was set up anew ({1e3 * one.shift:.3g} mm and {np.degrees(one.turn):.2g}° from "
        "where the fit has instrument and base): their frame and the targets are fitted to its own points."
    )
    names = tuple(name or TEST for name in campaign.setup_names)
    return replace(problem, campaign=replace(campaign, setup_names=names)), (said,)


def _as_found(problem: Problem, final: Fit) -> Problem:
    """The test campaign with targets that the fit found elsewhere stated there, on average over its set-ups:
    that they are not where they are stated was said of the fit's campaign."""
    campaign, fitted = problem.campaign, final.model.problem.campaign
    known = [fitted.setup_names.index(name) for name in campaign.setup_names if name in fitted.setup_names]
    names = [target.name for target in fitted.targets]
    found = dict[int, Array]()
    for i, target in enumerate(campaign.targets):
        if known and target.name in names and target.xyz is not None:
            place = final.state.targets[known, names.index(target.name)].mean(axis=0)
            if np.linalg.norm(place - problem.stated_targets[i]) > USUAL:
                found[i] = place
    return problem.stating(found)


test_figures.__test__ = False  # type: ignore[attr-defined]  # not a pytest function


@dataclass(frozen=True)
class _Errors:
    """predicted: (N, T, 3) [m] points of the test campaign; length: (N, T) [m] errors, NaN where not seen."""

    predicted: Array
    length: Array


def _cleaned(problem: Problem, final: Fit) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The test campaign without its data faults, as the final model shows them."""
    gross = without_gross(replace(problem, arm=problem.arm.with_geometry(final.state.geometry)))
    problem, faults = replace(gross.problem, arm=problem.arm), gross.faults
    beyond = beyond_measured(problem.campaign, final)
    least = np.full(len(problem.campaign.targets), float(np.median(final.noise.sigma)))
    for _ in range(ROUNDS):
        errors = _errors(problem, final)
        limit = wild_limit(problem, errors.length, least)
        limit[_as_a_whole(problem, errors.length > limit) & beyond] = np.inf
        found = mended(problem, errors.predicted, limit, lambda other: _errors(other, final).predicted)
        if not found.faults:
            break
        problem, faults = found.problem, (*faults, *found.faults)
    return problem, faults


def _step(problem: Problem, final: Fit) -> Step | None:
    """A step in time of the instrument or the tool in the course of the test, beside frames and targets of
    its own."""
    model = _model(problem, final)
    sigma = np.full(problem.seen.shape, float(np.median(final.noise.sigma)))
    noise = Covariance(sigma, np.zeros(problem.arm.n), np.ones(len(problem.q)))
    with suppress(ArithmeticError):  # an arm too soft to stand there: the figures say so
        return step_in_time(fit(model, _carried(model.problem, final), noise, geometry=False))
    return None


def _as_a_whole(problem: Problem, off: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N,) all that was seen of a pose is off (N, T): its robot may be. No wild shot is told from that where
    nothing like the pose was measured."""
    return np.asarray((off | ~problem.seen).all(axis=1))


def _errors(problem: Problem, result: Fit) -> _Errors:
    """The test campaign's points as a fit predicts them, and its errors."""
    model = _model(problem, result)
    state = _carried(model.problem, result)
    if new := _new_setups(problem, result.model.problem):
        state = _own_setups(model, state, new)
    predicted = model.predict(state)
    length = np.linalg.norm(problem.campaign.points - predicted, axis=2)
    return _Errors(predicted, np.where(problem.seen, length, np.nan))


def _model(problem: Problem, result: Fit) -> Model:
    """The test campaign on the fitted geometry, with effects of the fit that last and act there as well."""
    fitted = result.model.problem.campaign
    known = tuple(
        (effect, values)
        for effect, values in result.model.acting(result.state)
        if effect.lasting
        and effect.needs(problem) is None
        and problem.campaign.has_as_in(fitted, effect.where.payload)
    )
    return Model(replace(problem, arm=problem.arm.with_geometry(result.state.geometry)), (), known)


def _new_setups(problem: Problem, fitted: Problem) -> list[str]:
    """Set-ups of the test whose frames no fit has."""
    known = fitted.campaign.setup_names
    return [name for name in problem.campaign.setup_names if name not in known or was_split(name, known)]


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
            match = _same_target(target, fitted.targets)
            if match is not None:
                targets[k, i] = result.state.targets[source, match]
    return State(result.state.geometry, R, t, targets)


def _same_target(target: Target, fitted: Sequence[Target]) -> int | None:
    """Which of the fitted targets it is: the one of its name, unless that is stated elsewhere and another one
    there (the names were exchanged). None where it is none of them."""
    named = [j for j, other in enumerate(fitted) if other.name == target.name]
    there = [
        j
        for j, other in enumerate(fitted)
        if target.xyz is not None
        and other.xyz is not None
        and np.allclose(other.xyz, target.xyz, rtol=0, atol=1e-6)
    ]
    return next(iter(there if named and there and named[0] not in there else named), None)


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
