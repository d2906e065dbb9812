"""The verb: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...campaign import Campaign
from ...campaign.cell import CellData
from ...campaign.known import with_known
from ...correction.programs.measuring import DWELL_S
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ..driving import drive, reach
from ..driving.ways import Ways
from .accuracy import AccuracyPlan, plan_accuracy
from .discrimination import DiscriminationPlan, plan_discrimination
from .fedorov import Search
from .prior_information import from_campaign, from_robot

POOL, QUICK_POOL = 1200, 400  # candidate records,
PER_POSE, QUICK_PER_POSE = 4, 2  # or so many for each that is chosen
STARTS, QUICK_STARTS = 3, 1  # of the exchange

Plan = AccuracyPlan | DiscriminationPlan
Progress = Callable[[str], None]


def plan(
    source: Campaign | Robot,
    poses: int = 30,
    *,
    tell: str | None = None,
    known: Sequence[str] = (),
    seed: int = 0,
    quick: bool = False,
    cell: CellData | None = None,
    dwell: float = DWELL_S,
    progress: Progress = lambda _: None,
) -> Plan:
    """The next poses to measure: for accuracy, or to tell rival causes apart.

    source: a campaign, of which what it has shown already counts, or a robot that was not measured yet.
    poses: how many to choose. tell: causes, "A,B", each as in `--effect`. known: facts as `--known` takes
    them. seed: of the poses on offer; quick: fewer of them. cell: what stands around the robot (default: what the
    campaign says); dwell: [s] of a standstill. progress: is told each step in words. Raises `InputError` where
    there is no plan.

    >>> from workbench import load_robot, plan
    >>> chosen = plan(load_robot("cylindrical"), 5, quick=True)
    >>> chosen.records.poses.q.shape  # joints to go to [rad, m]
    (5, 3)
    >>> chosen.plan_mm < chosen.random_mm  # expected error after them, and after as many random ones
    True
    """
    if poses < 1:
        raise InputError(Fault("--poses", f"is {poses}", "give a number of poses"))
    progress("fitting the campaign" if isinstance(source, Campaign) else "loading the robot")
    if isinstance(source, Campaign):
        prior = from_campaign(with_known(source, known))
    else:
        prior = from_robot(source, known)
    campaign = prior.problem.campaign
    around = reach(
        prior.problem, prior.places, cell or campaign.cell, np.random.default_rng([seed, 24]), prior.shown
    )
    if quick:
        search = Search(max(QUICK_POOL, QUICK_PER_POSE * poses), QUICK_STARTS, seed, around.draw)
    else:
        search = Search(max(POOL, PER_POSE * poses), STARTS, seed, around.draw)
    progress(f"choosing {poses} of about {search.pool} possible records")
    made: Plan
    if tell is not None:
        made = plan_discrimination(prior, tell, poses, search)
    else:
        made = plan_accuracy(prior, poses, search)
    made = replace(made, faults=prior.faults, reach=around)
    if made.records is None or made.random is None:
        return made
    progress("looking for the shortest way")
    ways = Ways(around)
    return made.with_drive(drive(made.records, ways, dwell), drive(made.random, ways, dwell))
