"""From campaigns to a Diagnosis: prepared, searched for causes, written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from ..identification.fit import Fit, refit
from ..identification.heldout import heldout
from .competition import Selection, compete
from .findings import Parts, assemble
from .prepared import Progress, prepare
from .result import Diagnosis, NotTestable
from .stages import rms_mm, without


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
    selection = compete(prepared, candidates)
    if not prepared.noise_known and selection.fit.model.effects:
        prepared = prepared.with_noise_of(selection.fit)
    selection = _worth_it(selection, seed)
    progress("writing down what was found")
    diagnosis = assemble(Parts(prepared, selection, candidates, tuple(not_testable), seed, test))
    return Outcome(diagnosis, prepared.problem, selection.fit)


def _worth_it(selection: Selection, seed: int) -> Selection:
    """Without effects that bring the tool no nearer to its place on poses that they were not fitted on."""
    result = selection.fit
    while result.model.effects:
        best = rms_mm(heldout(result, seed=seed))
        gains = [without(result, [i], seed) - best for i in range(len(result.model.effects))]
        worst = int(np.argmin(gains))
        if gains[worst] > 0:
            break
        result = refit(result, [e for i, e in enumerate(result.model.effects) if i != worst])
    return replace(selection, fit=result)


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
