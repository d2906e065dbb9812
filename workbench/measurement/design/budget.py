"""Poses, targets, loads, pulls and stops on the way chosen together, for the most information in a time.

Poses of an exchange lie far from each other, and a large arm spends most of the time on its way. So fewer of
them are chosen, and the arm stops between them as well, where that is worth more per second; a load or a
session stays away where it is not worth mounting or waiting for, and a target where it is not worth the
instrument's turning to it. What a plan is worth is 1/e², e the expected error after it (`accuracy`), λ
(`t_optimal`), or how much more what is true is believed (`settle`); what it costs is the time that driving it
takes, worked out in full for every trial.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...files.faults import Fault, InputError
from ..driving.block import Drive
from ..driving.drive import drive, sessions
from ..driving.ways import Ways
from .candidates import random_rows

MOST_STOPS = 3  # between two poses of the exchange
FEWEST = 6  # poses of the exchange
TRIAL = 20  # poses of the exchange from which the time of one is taken
SAMPLE = 40  # random records that say which target is missed least
SESSIONS = 2  # place of the sessions among a plan's levels
NEAR, CLOSER = 0.05, 4  # how far from the time a plan may end, of it, and how often it is mended

Rows = NDArray[np.int64]
Levels = tuple[tuple[int, ...], ...]  # the pulls, the loads and the sessions of a plan


class Question(ABC):
    """What a plan is for, over candidate records."""

    offered: Campaign

    @cached_property
    def levels(self) -> Rows:
        """(C, 3) numbers of each candidate's pull, load and session, without anything first."""
        poses = self.offered.poses
        session = np.unique(sessions(self.offered), return_inverse=True)[1].ravel()
        return np.column_stack([(poses.wrench != 0).any(axis=1), poses.payload, session]).astype(np.int64)

    @property
    def targets(self) -> tuple[str, ...]:
        """What is measured."""
        return tuple(target.name for target in self.offered.targets)

    @cached_property
    def fewer(self) -> Question | None:
        """The same without the target on the arm that some random records miss least; None where one is
        left."""
        moving = [target.name for target in self.offered.targets if target.on != "base"]
        if self.offered.six_dof or len(moving) < 2:
            return None
        some = self.offered.some(random_rows(len(self.offered.poses), SAMPLE, 0))
        without = [[name for name in self.targets if name != gone] for gone in moving]
        return self.looking_at(max(without, key=lambda names: self.worth(some.looking_at(names))))

    @abstractmethod
    def looking_at(self, names: Collection[str]) -> Question:
        """The same where of the targets these alone are measured."""

    @abstractmethod
    def chosen(self, among: Rows, count: int) -> Rows:
        """The best `count` records among these candidates."""

    @abstractmethod
    def worth(self, records: Campaign) -> float:
        """Information of some records: it doubles with their number, nearly."""


@dataclass(frozen=True, eq=False)
class Trial:
    """A plan that was tried: of which targets, which levels, how many stops between two poses, how it is
    driven, its worth."""

    question: Question
    levels: Levels
    stops: int
    drive: Drive
    worth: float

    @property
    def choice(self) -> tuple[tuple[str, ...], Levels, int]:
        """Targets, levels and stops."""
        return self.question.targets, self.levels, self.stops

    @property
    def rate(self) -> float:
        """Information per second."""
        return self.worth / self.drive.total_s


def in_time(question: Question, ways: Ways, dwell: float, seconds: float) -> tuple[Trial, Trial]:
    """The plan of most information in a time, found by changing one factor after the other, and the best of
    poses alone: with a single load, without stops, all targets that there is time for. Raises `InputError`
    where the time is too short."""
    every = tuple(tuple(int(k) for k in np.unique(column)) for column in question.levels.T)
    nothing = tuple(some[:1] for some in every)
    first: Question | None = question
    alone = None
    while first is not None and alone is None:
        alone, first = _fitted(first, ways, dwell, seconds, nothing, 0), first.fewer
    if alone is None:
        what = f"{seconds / 60:g} min are too short for {FEWEST} poses"
        raise InputError(Fault("--minutes", what, "give more time, or a larger speed_share in [driving]"))
    best, tried, better = alone, {alone.choice}, True
    while better:
        better = False
        for asked, levels, stops in _beside(best, every):
            if (asked.targets, levels, stops) in tried:
                continue
            tried.add((asked.targets, levels, stops))
            made = _fitted(asked, ways, dwell, seconds, levels, stops)
            if made is not None and made.rate > best.rate:
                best, better = made, True
                break
    return best, alone


def check_sessions(question: Question, best: Trial, seconds: float, tells: float) -> None:
    """tells: worth below which a plan tells nothing. Raises InputError where that is for want of time between
    sessions."""
    if best.worth < tells and len(best.levels[SESSIONS]) < len(np.unique(question.levels[:, SESSIONS])):
        what = f"{seconds / 60:g} min are too short for poses warm and cold, or early and late"
        mend = "give more time: from one to the next it takes warm_up_min of [driving]"
        raise InputError(Fault("--minutes", f"{what}, and others do not tell these causes apart", mend))


def _beside(trial: Trial, every: Levels) -> Iterator[tuple[Question, Levels, int]]:
    """What differs from a trial in one factor."""
    asked, levels, stops = trial.question, trial.levels, trial.stops
    if asked.fewer is not None:
        yield asked.fewer, levels, stops
    for other in (stops + 1, stops - 1):
        if 0 <= other <= MOST_STOPS:
            yield asked, levels, other
    for k, there in enumerate(every):
        for some in _sets(there):
            if k != SESSIONS or some[0] == there[0]:  # what is later comes after the first
                yield asked, (*levels[:k], some, *levels[k + 1 :]), stops


def _sets(every: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Sets of a factor's levels that are tried: each alone, the first with each other, and all."""
    found = [(k,) for k in every] + [(every[0], k) for k in every[1:]] + [every]
    return list(dict.fromkeys(found))


def _fitted(
    question: Question, ways: Ways, dwell: float, seconds: float, levels: Levels, stops: int
) -> Trial | None:
    """As many records of these levels as fit into the time; None where hardly any does."""
    inside = [np.isin(column, some) for column, some in zip(question.levels.T, levels, strict=True)]
    among = np.flatnonzero(np.all(inside, axis=0))
    count, made = min(TRIAL, len(among)), None
    for _ in range(CLOSER):
        records = question.offered.some(question.chosen(among, count))
        driven = drive(records, ways, dwell)
        if stops:
            driven = drive(_with_stops(driven.plan, ways, stops), ways, dwell)
        if driven.total_s <= seconds * (1 + NEAR):
            made = driven
        if abs(driven.total_s - seconds) <= NEAR * seconds:
            break
        each = (driven.moving_s + driven.standing_s) / count
        wanted = int((seconds - driven.pauses_s) / each)
        if wanted < FEWEST:
            break
        wanted = min(wanted, len(among))
        if wanted == count:
            break
        count = wanted
    return None if made is None else Trial(question, levels, stops, made, question.worth(made.plan))


def _with_stops(plan: Campaign, ways: Ways, stops: int) -> Campaign:
    """The records of a plan in the order of its drive, with stops on the way from each to the next of the
    same load, where these can be measured."""
    poses = plan.poses
    loads = np.column_stack([poses.payload, poses.wrench, sessions(plan)])
    start = np.flatnonzero((loads[1:] == loads[:-1]).all(axis=1))
    share = np.arange(1, stops + 1) / (stops + 1)
    q = (poses.q[start, None] + share[:, None] * (poses.q[start + 1] - poses.q[start])[:, None]).reshape(
        -1, poses.q.shape[1]
    )
    own = np.repeat(start, stops)
    good = ways.reach.good(q)
    rows = np.concatenate([np.arange(len(poses)), own[good]])
    return plan.some(rows).with_poses(
        q=np.concatenate([poses.q, q[good]]), ids=tuple(str(i + 1) for i in range(len(rows)))
    )
