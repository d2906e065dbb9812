"""Campaigns of one robot as occasions: each prepared and searched by itself, then told the same effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...campaign import Campaign, join
from ...campaign.joined import labels_of
from ...campaign.problem import Problem, problem_of
from ...effects.base import Effect
from ...effects.given import Exclusion, may_be
from ...files.faults import Fault, InputError
from ...identification.fit import Fit, fit, refit, start_state
from ...identification.model import Model, State
from ...identification.noise import Covariance
from ...identification.plausible import enough_beside_others, enough_together, too_few_alone
from ...robot.kinematics import Array
from ..candidates import testable
from ..found import GivenFact
from ..given import search_with_given
from ..noise.scatter import alike
from ..prepared import Prepared, Progress, prepare
from ..search.competition import Selection, compete
from .coherence import coherence
from .known import held_against, only, said_of_all


@dataclass(frozen=True, eq=False)
class Occasion:
    """One campaign. fit: of its own frames, targets and geometry and the effects that all occasions share;
    misfit: the noise does not explain what that leaves, so that the likelihood is too sure; coherence: how
    much alike that is in neighbouring poses; excluded: causes that are known not to be there."""

    label: str
    prepared: Prepared
    fit: Fit
    misfit: bool
    coherence: float
    excluded: tuple[Exclusion, ...] = ()

    @property
    def problem(self) -> Problem:
        return self.fit.model.problem

    def may_be(self, effect: Effect) -> bool:
        """Whether nobody said what it is, or that it is not there."""
        return may_be(effect, self.fit.model.given, self.excluded)

    def at(self, state: State) -> Occasion:
        """The same, linearised elsewhere; where it is, if an arm so soft does not stand."""
        try:
            return replace(self, fit=fit(self.fit.model, state, self.fit.noise, max_iterations=1))
        except ArithmeticError:
            return self


def occasions_of(campaigns: Sequence[Campaign], progress: Progress) -> tuple[list[Occasion], Problem]:
    """The occasions in the order given, and all their poses as one problem. Raises `InputError`."""
    campaigns = _told_apart(campaigns)
    join(list(campaigns))  # refuses what is not one robot, before anything is computed
    labels = labels_of(campaigns)
    problems = [problem_of(campaign) for campaign in campaigns]
    common = said_of_all(problems)
    prepared, searched, told = list[Prepared](), list[Fit](), list[Sequence[GivenFact]]()
    for campaign, label, said in zip(campaigns, labels, common, strict=True):
        progress(f"{label}: by itself")
        one = prepare(replace(campaign, known=only(said, campaign.known)), enough=enough_beside_others)
        found, facts = _searched(one)
        prepared.append(one)
        searched.append(found)
        told.append(facts)
    known = held_against(problems, common, told)
    prepared = [
        replace(one.with_given(own.given), notes=(*one.notes, *own.notes))
        for one, own in zip(prepared, known, strict=True)
    ]
    enough_together([one.problem for one in prepared])
    prepared, searched = _with_noise_of_others(prepared, searched)
    whole = problem_of(join([one.problem.campaign for one in prepared]))
    shared = _shared(searched, whole)
    out, first = [], 0
    for one, found, label, own in zip(prepared, searched, labels, known, strict=True):
        poses = np.arange(first, first + len(one.problem.q))
        first += len(poses)
        part = _part(whole, poses)
        noise = _noise(found.noise, part)
        model = Model(part, (), one.known_effects, own.given)
        began = fit(model, start_state(part), noise)
        misfit = one.noise.source == "residual" or not alike(noise, one.covariance)
        own_fit = refit(began, shared)
        out.append(Occasion(label, one, own_fit, misfit, coherence(own_fit), own.excluded))
    return out, whole


def with_same_effects(occasions: Sequence[Occasion]) -> list[Occasion]:
    """The occasions, each with its own geometry, and all with the mean of their effects. Of what is common to
    them, columns differ by their poses alone there: where a joint is softer at one, heavier links at all
    would do more at that one, and look like its change."""
    states = [one.fit.state for one in occasions]
    given = np.mean([state.given for state in states], axis=0)
    values = tuple(np.mean(each, axis=0) for each in zip(*(state.values for state in states), strict=True))
    return [one.at(replace(one.fit.state, values=values, given=given)) for one in occasions]


def _searched(prepared: Prepared) -> tuple[Fit, Sequence[GivenFact]]:
    """The fit with the causes that a campaign shows by itself, and what became of what was given; one of few
    poses shows none."""
    if too_few_alone(prepared.problem):
        return prepared.geometry, ()

    def search(beside: Prepared, candidates: Sequence[Effect]) -> tuple[Prepared, Selection]:
        return beside, compete(beside, candidates)

    found = search_with_given(prepared, testable(prepared.problem)[0], search)
    return found.selection.fit, found.said


def _with_noise_of_others(
    prepared: Sequence[Prepared], searched: Sequence[Fit]
) -> tuple[list[Prepared], list[Fit]]:
    """Campaigns of too few poses to show how much the robot scatters, or the instrument where nobody stated
    it, scatter as the campaign with the most poses does. Raises InputError where no other can say it."""
    most = max(range(len(prepared)), key=lambda k: len(prepared[k].problem.q))
    source, usual = prepared[most], searched[most].noise
    told, fits = list[Prepared](), list[Fit]()
    for one, found in zip(prepared, searched, strict=True):
        if too_few_alone(one.problem):
            if one.noise.source == "residual" and too_few_alone(source.problem):
                mend = "say sigma_mm under [noise]"
                raise InputError(Fault(str(one.problem.campaign.path), "no campaign shows the noise", mend))
            own = replace(
                one.covariance, joint=np.maximum(one.covariance.joint, usual.joint), body=usual.body
            )
            if one.noise.source == "residual":
                sigma = np.full_like(own.sigma, usual.usual)
                own = replace(own, sigma=sigma, turn_ratio=usual.turn_ratio, about=usual.about)
                one = replace(one, noise=source.noise)
            one, found = replace(one, covariance=own), replace(found, noise=own)
        told.append(one)
        fits.append(found)
    return told, fits


def _told_apart(campaigns: Sequence[Campaign]) -> list[Campaign]:
    """Campaigns made in memory share a path: those that hold other points get one of their own."""
    out = list[Campaign]()
    for number, campaign in enumerate(campaigns, 1):
        twins = [other for other in out if other.path.resolve() == campaign.path.resolve()]
        same = any(np.array_equal(campaign.points, twin.points, equal_nan=True) for twin in twins)
        if twins and not same:
            campaign = replace(
                campaign, path=campaign.path.parent / f"campaign {number}" / campaign.path.name
            )
        out.append(campaign)
    return out


def _shared(fits: Sequence[Fit], whole: Problem) -> list[Effect]:
    """What any of the campaigns shows by itself, once for each cause, place and form; of a load, where all
    mean one by its name."""
    found: dict[object, Effect] = {}
    for result in fits:
        for effect in result.model.effects:
            if whole.campaign.has_as_in(result.model.problem.campaign, effect.where.payload):
                found.setdefault((effect.key, effect.variant), effect)
    return list(found.values())


def _part(whole: Problem, poses: np.ndarray) -> Problem:
    """Only these poses of the joined campaign, with the set-ups and targets that they have."""
    return replace(whole, campaign=whole.campaign.some(poses).measured())


def _noise(own: Covariance, part: Problem) -> Covariance:
    """A campaign's noise, with a row of drive torques where only another campaign recorded them."""
    if part.drives and own.torque is None:
        return replace(own, torque=np.full(part.arm.n, np.inf))
    return own


def numbers_of(occasion: Occasion) -> Array:
    """(P,) what is fitted at an occasion, as far from its prior's mean as the occasion's state is; zero for
    frames and targets, which every occasion has to itself."""
    result, problem = occasion.fit, occasion.problem
    change = (result.state.geometry - problem.arm.geometry).ravel()[result.columns.geometry]
    local = np.zeros(result.columns.geometry_slice.start)
    given = result.model.given_values(result.state) - [item.value for item in result.model.given]
    return np.concatenate([local, change, given, *result.state.values])
