"""From campaigns to a Diagnosis: data faults, noise, geometry, causes, verdict, figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..campaign import Campaign, join
from ..campaign.problem import Problem, problem
from ..effects import catalogue
from ..effects.base import Effect, LoadEffect
from ..effects.records import stated_effects
from ..identification import drive_torque
from ..identification.fit import Fit, fit, refit, start_state
from ..identification.heldout import heldout
from ..identification.model import Model
from ..identification.registration import check_units
from .data_faults import clean, split_setup, step_in_time
from .findings import Parts, assemble
from .noise_choice import choose, from_residual
from .result import Diagnosis, FaultFound, NotTestable
from .search import Search, Selection, bounded
from .verdict import SURE, remainder, stands_out

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Outcome:
    """The diagnosis with what later steps need: the final fit and the problem it was made on."""

    diagnosis: Diagnosis
    problem: Problem
    fit: Fit


def diagnose(
    campaigns: Campaign | Sequence[Campaign],
    test: Campaign | None = None,
    progress: Progress = lambda _: None,
    seed: int = 0,
) -> Outcome:
    """What the simulation gets wrong, why, and the gain of saying so.

    Several campaigns of one robot are fitted together. Nothing is fitted on `test` but the frame and
    targets of set-ups that the campaigns do not have. Raises InputError where the data are unusable.
    """
    campaign = campaigns if isinstance(campaigns, Campaign) else join(list(campaigns))
    progress("loading the robot")
    whole = problem(campaign)
    check_units(whole)
    known_effects = tuple(stated_effects(whole))
    start = start_state(whole)
    progress("looking for data faults")
    model = Model(whole, (), known_effects)
    guess, noise, notes = choose(whole, model.linearise(start))
    cleaned = clean(whole, start, guess, known_effects, judged=noise.source != "residual")
    whole, faults = cleaned.problem, list(cleaned.faults)
    step = step_in_time(cleaned.fit)
    if step is not None:
        whole = split_setup(whole, step.first)
        moved = {"moved_instrument": "the instrument's frame", "changed_setup": "the tool with its targets"}
        what = f"{moved[step.kind]} steps by {step.size * 1e3:.2f} mm before this pose"
        name = whole.campaign.pose_ids[step.first]
        faults.append(FaultFound(step.kind, name, None, what, "frame and targets fitted anew from here on"))
        start = start_state(whole)
        guess, noise, _ = choose(whole, Model(whole, (), known_effects).linearise(start))
    else:
        start = cleaned.fit.state
    progress("fitting geometry")
    model, covariance = Model(whole, (), known_effects), guess
    geometry = fit(model, start, covariance)
    known = noise.source != "residual"
    if not known:
        covariance, noise = from_residual(geometry)
    if whole.drives:
        covariance = replace(covariance, torque=drive_torque.noise(whole))
    if not known or whole.drives:
        geometry = fit(model, geometry.state, covariance)
    progress("testing causes")
    nominal = fit(model, replace(start, geometry=whole.arm.geometry), covariance, geometry=False)
    candidates, not_testable = testable(whole)
    selection = _search(nominal, geometry, candidates, known)
    if not known and selection.effects:
        covariance, noise = from_residual(selection.fit)
        geometry = fit(model, geometry.state, covariance)
        selection = _search(nominal, geometry, candidates, known)
    progress("writing down what was found")
    parts = Parts(
        whole,
        noise,
        nominal,
        geometry,
        selection,
        tuple(faults),
        tuple(notes),
        tuple(not_testable),
        known,
        seed,
        test,
    )
    diagnosis = assemble(parts)
    return Outcome(diagnosis, whole, selection.fit)


def _search(nominal: Fit, geometry: Fit, candidates: Sequence[Effect], known: bool) -> Selection:
    """The search; where something unknown is left, causes that do not stand out of it are taken back."""
    search = Search(nominal, geometry, candidates, known)
    selection = search.run()
    for _ in range(3):
        absurd = _absurd(selection.fit)
        if not absurd:
            break
        candidates = [effect for effect in candidates if effect not in absurd]
        search = Search(nominal, geometry, candidates, known)
        selection = search.run()
    while selection.chosen and remainder(selection.fit, known).structured:
        kept = [
            index
            for i, index in enumerate(selection.chosen)
            if stands_out(selection.fit, i) * selection.tries[i] < SURE
        ]
        if len(kept) == len(selection.chosen):
            break
        selection = search.select(selection.pool, kept)
    return _material(search, selection) if geometry.model.problem.drives else selection


def _absurd(result: Fit) -> list[Effect]:
    """Effects whose fitted numbers no machine can have, by more than their uncertainty: they make up for
    something else."""
    return [
        effect
        for i, effect in enumerate(result.model.effects)
        if not bounded(effect.params, *result.effect_values(i))
    ]


def _material(search: Search, selection: Selection) -> Selection:
    """Without loads that only the drives' torques feel: they bring the tool no nearer to its place."""
    kept = list(selection.chosen)
    everything = _heldout_rms(selection.fit)
    for index in selection.chosen:
        effect = selection.pool.candidates[index]
        if isinstance(effect, LoadEffect):
            rest = [e for e in selection.fit.model.effects if e != effect]
            if _heldout_rms(refit(selection.fit, rest)) < 1.001 * everything:
                kept.remove(index)
    return selection if len(kept) == len(selection.chosen) else search.select(selection.pool, kept)


def _heldout_rms(result: Fit) -> float:
    return float(np.sqrt(np.nanmean(heldout(result) ** 2)))


def testable(whole: Problem) -> tuple[list[Effect], list[NotTestable]]:
    """Candidates of the catalogue at every place, and the causes that the data cannot show."""
    candidates: list[Effect] = []
    missing: list[NotTestable] = []
    for cause, kind in catalogue().items():
        why = kind.needs(whole)
        if why is not None:
            missing.append(NotTestable(cause, why))
            continue
        candidates += kind.sites(whole)
    return candidates, missing
