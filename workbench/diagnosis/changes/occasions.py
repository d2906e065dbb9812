"""Campaigns of one robot as occasions: each prepared and searched by itself, then told the same effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...campaign import Campaign, join
from ...campaign.joined import labels_of
from ...campaign.problem import Problem, problem_of
from ...effects.base import Effect
from ...identification.fit import Fit, fit, refit, start_state
from ...identification.model import Model
from ...identification.noise import Covariance
from ...robot.kinematics import Array
from ..candidates import testable
from ..competition import compete
from ..prepared import Prepared, Progress, prepare
from ..scatter import alike


@dataclass(frozen=True, eq=False)
class Occasion:
    """One campaign. fit: of its own frames, targets and geometry and the effects that all occasions share;
    misfit: the noise does not explain what that leaves, so that the likelihood is too sure."""

    label: str
    prepared: Prepared
    fit: Fit
    misfit: bool

    @property
    def problem(self) -> Problem:
        return self.fit.model.problem

    def at(self, result: Fit) -> Occasion:
        """The same, linearised elsewhere."""
        return replace(self, fit=result)


def occasions_of(campaigns: Sequence[Campaign], progress: Progress) -> tuple[list[Occasion], Problem]:
    """The occasions in the order given, and all their poses as one problem. Raises `InputError`."""
    campaigns = _told_apart(campaigns)
    join(list(campaigns))  # refuses what is not one robot, before anything is computed
    labels = labels_of(campaigns)
    prepared, searched = [], []
    for campaign, label in zip(campaigns, labels, strict=True):
        progress(f"{label}: by itself")
        prepared.append(prepare(campaign))
        searched.append(compete(prepared[-1], testable(prepared[-1].problem)[0]))
    whole = problem_of(join([one.problem.campaign for one in prepared]))
    shared = _shared([selection.fit for selection in searched], whole)
    out, first = [], 0
    for one, selection, label in zip(prepared, searched, labels, strict=True):
        poses = np.arange(first, first + len(one.problem.q))
        first += len(poses)
        part = _part(whole, poses)
        noise = _noise(selection.fit.noise, part)
        model = Model(part, (), one.known_effects)
        began = fit(model, start_state(part), noise)
        misfit = one.noise.source == "residual" or not alike(noise, one.covariance)
        out.append(Occasion(label, one, refit(began, shared), misfit))
    return out, whole


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
    """What any of the campaigns shows by itself, once for each cause, place and form."""
    found: dict[object, Effect] = {}
    for result in fits:
        for effect in result.model.effects:
            if effect.where.payload in (None, *whole.campaign.payload_names):
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
    return np.concatenate([local, change, *result.state.values])
