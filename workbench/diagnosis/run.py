"""From campaigns to a Diagnosis: prepared, searched for causes, written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..campaign import Campaign, load_campaign
from ..campaign.known import with_known
from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from ..identification.fit import Fit, refit
from ..identification.heldout import heldout
from .competition import Selection, compete
from .findings import Parts, assemble
from .given import search_with_given
from .prepared import Prepared, Progress, prepare
from .result import Diagnosis, NotTestable
from .stages import rms_mm, without

Given = Campaign | str | Path
FAINT = 0.1  # of the noise, or of what is left per axis: a gain that decides nothing


@dataclass(frozen=True)
class Outcome:
    """The diagnosis with what later steps need: the final fit, the problem it was made on, and the
    preparation that a plan begins with."""

    diagnosis: Diagnosis
    problem: Problem
    fit: Fit
    prepared: Prepared

    def __repr__(self) -> str:
        return f"Outcome: {self.diagnosis!r}"

    def _repr_html_(self) -> str:
        return self.diagnosis._repr_html_()


def diagnose(
    campaigns: Given | Sequence[Given],
    test: Given | None = None,
    progress: Progress = lambda _: None,
    seed: int = 0,
    known: Sequence[str] = (),
) -> Outcome:
    """What the simulation gets wrong, why, and the gain of saying so.

    campaigns: one, or several of one robot, which are fitted together; each as loaded, or the path of its
    campaign.toml. test: poses kept apart; nothing is fitted on it but the frame and targets of set-ups that
    the campaigns do not have. progress: is told each step in words. seed: of the groups of poses that are
    held out in turn. known: facts beside those of `[known]`, as `--known` takes them. Raises `InputError`
    where the data are unusable.

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
    test = None if test is None else _loaded(test)
    prepared = prepare(_all_loaded(campaigns, known), progress)
    del campaigns  # of a large one, parts stand in `prepared`: the whole takes room
    test = test or prepared.spare
    progress("testing causes")
    candidates, not_testable = testable(prepared.problem)
    found = search_with_given(prepared, candidates, partial(_search, seed=seed), progress)
    progress("writing down what was found")
    missing = (*not_testable, *found.not_testable)
    parts = Parts(found.prepared, found.selection, found.candidates, missing, seed, test, found.said)
    return Outcome(assemble(parts), found.prepared.problem, found.selection.fit, found.prepared)


def _search(prepared: Prepared, candidates: Sequence[Effect], seed: int) -> tuple[Prepared, Selection]:
    """The causes that explain the data, and the noise that they leave where there was none."""
    selection = compete(prepared, candidates)
    if not prepared.noise_known and selection.fit.model.effects:
        prepared = prepared.with_noise_of(selection.fit)
    return prepared, _worth_it(selection, seed)


def _all_loaded(campaigns: Given | Sequence[Given], known: Sequence[str]) -> list[Campaign]:
    """The campaigns, with facts beside those of the first one's `[known]`."""
    several = [campaigns] if isinstance(campaigns, Campaign | str | Path) else campaigns
    loaded = [_loaded(one) for one in several]
    return [with_known(loaded[0], known), *loaded[1:]]


def _loaded(given: Given) -> Campaign:
    return given if isinstance(given, Campaign) else load_campaign(given)


def _worth_it(selection: Selection, seed: int) -> Selection:
    """Without effects that bring the tool no nearer to its place on poses that they were not fitted on. Where
    something is left without a name, causes that bring less than a tenth of the noise keep none either."""
    kept, error = selection, rms_mm(heldout(selection.fit, seed=seed))
    while kept.fit.model.effects:
        gains = _gains(kept, error, seed)
        worst = int(np.argmin(gains))
        if gains[worst] > 0:
            break
        rest = [effect for i, effect in enumerate(kept.fit.model.effects) if i != worst]
        fit = refit(kept.fit, rest)
        after = rms_mm(heldout(fit, seed=seed))
        if after > error:
            break  # it holds others in place
        kept, error = replace(kept, fit=fit), after
    result, nameless = kept.fit, kept.nameless
    if not nameless:
        return kept
    least = FAINT * max(1e3 * result.noise.usual, error / np.sqrt(3))
    alone = without(result, nameless, seed)
    gains_mm = {e.key: without(result, [*nameless, *own], seed) - alone for e, own in kept.groups}
    together = without(result, range(len(result.model.effects)), seed) - alone
    return replace(kept, faint=frozenset(k for k, gain in gains_mm.items() if min(gain, together) < least))


def _gains(selection: Selection, whole: float, seed: int) -> list[float]:
    """What each effect brings [mm] on poses held out: one with a name beside the others that have one, one
    without beside all. whole: RMS [mm] with all."""
    fit, nameless = selection.fit, selection.nameless
    named = without(fit, nameless, seed)
    return [
        without(fit, [i], seed) - whole if i in nameless else without(fit, [*nameless, i], seed) - named
        for i in range(len(fit.model.effects))
    ]


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
