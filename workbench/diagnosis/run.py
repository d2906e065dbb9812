"""From campaigns to a Diagnosis: prepared, searched for causes, written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from ..identification.fit import Fit, refit
from ..identification.heldout import heldout
from .findings import Parts, assemble
from .prepared import Prepared, Progress, prepare
from .result import Diagnosis, NotTestable
from .screen import bounded
from .search import Search, Selection
from .verdict import STANDS_OUT, remainder, stands_out


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

    campaigns: one, or several of one robot, which are fitted together. test: poses kept apart; nothing is
    fitted on it but the frame and targets of set-ups that the campaigns do not have. progress: is told
    each step in words. seed: of the groups of poses that are held out in turn. Raises `InputError` where
    the data are unusable.

    >>> import numpy as np
    >>> from workbench import Truth, load_robot, parse_effect, planned, problem, random_poses
    >>> from workbench import diagnose, simulate
    >>> robot = load_robot("cylindrical")
    >>> plan = planned(robot, random_poses(robot, 30, np.random.default_rng(1)))
    >>> hidden = "gear_eccentricity:joint=joint_1,variant=1,amplitude=5e-4,phase=0.4"
    >>> wheel = parse_effect(hidden, problem(plan))
    >>> outcome = diagnose(simulate(plan, Truth(effects=(wheel,), sigma=2e-5), seed=1))
    >>> [finding.label for finding in outcome.diagnosis.causes]
    ['gear_eccentricity(joint_1)']
    """
    prepared = prepare(campaigns, progress)
    progress("testing causes")
    candidates, not_testable = testable(prepared.problem)
    selection = _search(prepared, candidates)
    if not prepared.noise_known and selection.effects:
        prepared = prepared.with_noise_of(selection.fit)
        selection = _search(prepared, candidates)
    progress("writing down what was found")
    diagnosis = assemble(Parts(prepared, selection, tuple(not_testable), seed, test))
    return Outcome(diagnosis, prepared.problem, selection.fit)


def _search(prepared: Prepared, candidates: Sequence[Effect]) -> Selection:
    """The search; where something unknown is left, causes that do not stand out of it are taken back."""
    nominal, geometry, known = prepared.nominal, prepared.geometry, prepared.noise_known
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
            if stands_out(selection.fit, i) * selection.tries[i] < STANDS_OUT
        ]
        if len(kept) == len(selection.chosen):
            break
        selection = search.select(selection.pool, kept)
    return _material(search, selection) if prepared.problem.drives else selection


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
        if effect.acts == "load":
            rest = [e for e in selection.fit.model.effects if e != effect]
            if _heldout_rms(refit(selection.fit, rest)) < 1.001 * everything:
                kept.remove(index)
    return selection if len(kept) == len(selection.chosen) else search.select(selection.pool, kept)


def _heldout_rms(result: Fit) -> float:
    return float(np.sqrt(np.nanmean(heldout(result) ** 2)))


def testable(problem: Problem) -> tuple[list[Effect], list[NotTestable]]:
    """Candidates of the catalogue at every place, and the causes that the data cannot show."""
    candidates: list[Effect] = []
    missing: list[NotTestable] = []
    for cause, kind in catalogue().items():
        why = kind.needs(problem)
        if why is not None:
            missing.append(NotTestable(cause, why))
            continue
        candidates += kind.sites(problem)
    return candidates, missing
