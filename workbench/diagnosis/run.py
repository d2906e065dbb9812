"""From campaigns to a Diagnosis: prepared, searched for causes, written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from threadpoolctl import threadpool_limits

from ..campaign import Campaign, load_campaign
from ..campaign.problem import Problem
from ..campaign.same_robot import check_same_robot
from ..effects.base import Effect
from ..identification.fit import Fit
from .candidates import testable
from .data_faults.changed_between import changed_between
from .data_faults.moved_setup import by_no_chance
from .data_faults.wild_points import wild_beside
from .found import NotTestable
from .given import Searched, search_with_given
from .prepared import Prepared, Progress, prepare
from .result import Diagnosis
from .search.competition import Selection, compete
from .search.refuted import judged, with_none_refuted
from .telling.findings import Parts, assemble
from .telling.on_test_campaign import test_figures

Given = Campaign | str | Path
NOISES = 2  # times a noise is taken from a fit: what joints scatter shows once turns are as fine as they are
CLEANED_AGAIN = 2  # times: what causes were explained by data faults hides others


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
    where the data are unusable, or the test of another robot.

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
    with threadpool_limits(1, "blas"):  # many small products: threads of BLAS only wait for each other
        return _diagnosed(
            _all_loaded(campaigns, known), None if test is None else _loaded(test), progress, seed
        )


def _diagnosed(campaigns: list[Campaign], test: Campaign | None, progress: Progress, seed: int) -> Outcome:
    if test is not None:
        check_same_robot(campaigns[0].robot, test)
    prepared = prepare(campaigns, progress)
    campaigns.clear()  # of a large one, parts stand in `prepared`: the whole takes room
    if test is not None:  # what cannot be used is refused before the search
        progress("looking at the test campaign")
        test_figures(prepared.nominal, prepared.geometry, test)
    test = test or prepared.spare
    progress("testing causes")
    found, not_testable = _searched(prepared, seed, progress)
    for _ in range(CLEANED_AGAIN):
        mended, since = _mended(prepared, found)
        if mended is None:
            break
        prepared = mended
        progress("testing causes without the data faults that they hid")
        found, not_testable = _searched(prepared, seed, progress, since)
    if found.selection.against:
        progress("testing causes without those that their own numbers refute")
    selection = with_none_refuted(found.prepared, found.selection, found.candidates, seed)
    found = replace(found, selection=selection)
    progress("writing down what was found")
    missing = (*not_testable, *found.not_testable)
    parts = Parts(found.prepared, found.selection, found.candidates, missing, seed, test, found.said)
    return Outcome(assemble(parts), found.prepared.problem, found.selection.fit, found.prepared)


def _mended(prepared: Prepared, found: Searched) -> tuple[Prepared | None, Selection | None]:
    """Without data faults that show beside what was found alone, None where there is none: wild points,
    zeros, loads and scales that are others in some campaigns, or else steps in time. And what was found,
    where the search may go on from that."""
    selection = found.selection
    wild = wild_beside(selection.fit, prepared.least)
    if wild.faults:
        return prepared.mended(wild), None
    if not selection.nameless and selection.fit.lasting is selection.fit:
        return None, None
    problem, moved = changed_between(selection)
    if moved:
        return prepared.counted(problem, moved), None
    steps, near = selection.steps, selection.fit.lasting
    sure = [step for step in steps if by_no_chance(near, step, [one for one in steps if one is not step])]
    return (prepared.split(sure), selection) if sure else (None, None)


def _searched(
    prepared: Prepared, seed: int, progress: Progress, since: Selection | None = None
) -> tuple[Searched, tuple[NotTestable, ...]]:
    """The search for all that these data can show, and what they cannot; since: what was found already."""
    candidates, missing = testable(prepared.problem)
    search = partial(_search, seed=seed, since=since)
    return search_with_given(prepared, candidates, search, progress), tuple(missing)


def _search(
    prepared: Prepared, candidates: Sequence[Effect], seed: int, since: Selection | None
) -> tuple[Prepared, Selection]:
    """The causes that explain the data, and the noise that they leave where there was none."""
    selection = compete(prepared, candidates, since)
    for _ in range(NOISES):
        fit = selection.fit
        finer = prepared.with_turns_of(fit) or prepared.with_distances(fit) or prepared.with_silent(fit)
        if finer is None:
            break
        prepared, selection = finer, compete(finer, candidates)
    if not prepared.noise_known and selection.fit.model.effects:
        prepared = prepared.with_noise_of(selection.fit)
    return prepared, judged(prepared, selection, candidates, seed)


def _all_loaded(campaigns: Given | Sequence[Given], known: Sequence[str]) -> list[Campaign]:
    """The campaigns, with facts beside those of the first one's `[known]`."""
    several = [campaigns] if isinstance(campaigns, Campaign | str | Path) else campaigns
    loaded = [_loaded(one) for one in several]
    return [loaded[0].with_known(known), *loaded[1:]]


def _loaded(given: Given) -> Campaign:
    return given if isinstance(given, Campaign) else load_campaign(given)
