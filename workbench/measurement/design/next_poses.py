"""The verb: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...campaign import Campaign
from ...campaign.cell import CellData
from ...campaign.payloads import payload
from ...correction.programs.measuring import DWELL_S
from ...diagnosis.found import Decision
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ..driving.drive import NoWay, drive
from ..driving.reach import Reach
from ..driving.ways import Ways
from .accuracy import plan_accuracy, plan_accuracy_in_time
from .accuracy_plan import AccuracyPlan
from .candidates import reach_of
from .discrimination import plan_discrimination, plan_discrimination_in_time
from .discrimination_plan import DiscriminationPlan
from .fedorov import Search
from .prior_information import PriorInformation, from_campaign, from_robot
from .settle import found_by, is_found, plan_settling, plan_settling_in_time

POSES = 30
MOST = 10_000  # poses of a plan
POOL, QUICK_POOL = 1200, 400  # candidate records,
PER_POSE, QUICK_PER_POSE = 4, 2  # or so many for each that is chosen
STARTS, QUICK_STARTS = 3, 1  # of the exchange

Plan = AccuracyPlan | DiscriminationPlan
Progress = Callable[[str], None]


def plan(
    source: Campaign | Robot,
    poses: int | None = None,
    *,
    tell: str | None = None,
    known: Sequence[str] = (),
    seed: int = 0,
    quick: bool = False,
    minutes: float | None = None,
    cell: CellData | None = None,
    dwell: float = DWELL_S,
    torque: bool = False,
    payloads: Mapping[str, tuple[float, Sequence[float]]] | None = None,
    reflectors: Sequence[str] = (),
    progress: Progress = lambda _: None,
) -> Plan:
    """The next poses to measure: for accuracy, or to tell rival causes apart.

    source: a campaign, of which what it has shown already counts, or a robot that was not measured yet.
    poses: how many to choose (30). tell: causes, "A,B", each as in `--effect`, the first with its size where
    it was found, several such ties parted by semicolons; or the path of a `result.json`, all ties of which
    are to be settled. What was found is settled by as few poses as do it where none are said. known: facts
    as `--known` takes them. seed: of the poses on offer; quick: fewer of them. cell: what stands around the
    robot (default: what the campaign says); minutes: in place of a number of poses the time that they may
    take, loads, stops on the way and targets chosen with them; dwell: [s] of a standstill with one target;
    torque: the drives' torques are to be recorded too, as in a campaign that has them; payloads: further
    loads that can be mounted, name → mass [kg] and centre of mass [m, flange frame]; reflectors: links, or
    "base", that get a target more. progress: is told each step in words. Raises `InputError` where there is
    no plan.

    >>> from workbench import load_robot, plan
    >>> chosen = plan(load_robot("cylindrical"), 5, quick=True)
    >>> chosen.records.poses.q.shape  # joints to go to [rad, m]
    (5, 3)
    >>> chosen.plan_mm < chosen.random_mm  # expected error after them, and after as many random ones
    True
    """
    if poses is not None and poses < 1:
        raise InputError(Fault("--poses", f"is {poses}", "give a number of poses"))
    if poses is not None and minutes is not None:
        raise InputError(Fault("--poses, --minutes", "are two limits", "give the number or the time"))
    progress("fitting the campaign" if isinstance(source, Campaign) else "loading the robot")
    prior = _prior(source, tell, known).with_payloads(payloads or {}).with_reflectors(reflectors)
    prior = replace(prior, torques=torque)
    around = reach_of(prior, seed, cell)
    seconds = None if minutes is None else 60 * minutes
    count = (poses or POSES) if seconds is None else _likely(around, seconds, dwell)
    if count > MOST:
        said = "--poses" if seconds is None else "--minutes"
        raise InputError(Fault(said, f"asks for {count} poses", f"{MOST} are the most"))
    asked = _Asked(prior, tell, poses, seconds, count, dwell, seed, quick, progress)
    try:
        made = asked.planned(around)
    except NoWay:
        progress("looking closely at the ways between all poses: some that coarse looks promised are none")
        made = asked.planned(replace(around, closely=True))
    if made.drive is None:
        return made
    before, planned = prior.problem.campaign.poses, made.drive.records.poses
    warmth = before.temperature is not None or planned.temperature is not None
    return replace(made, drive=replace(made.drive, torque=torque or prior.problem.drives > 0, warmth=warmth))


def _prior(source: Campaign | Robot, tell: str | None, known: Sequence[str]) -> PriorInformation:
    """What is known of a campaign's robot, or of one that was not measured."""
    if isinstance(source, Campaign):
        return from_campaign(source.with_known(known), partial(found_by, tell))
    return from_robot(source, known)


@dataclass(frozen=True, eq=False)
class _Asked:
    """What a plan is asked for, as `plan` has it. poses, seconds: its limit, if any is said; count: how many
    poses that is, about."""

    prior: PriorInformation
    tell: str | None
    poses: int | None
    seconds: float | None
    count: int
    dwell: float
    seed: int
    quick: bool
    progress: Progress

    def planned(self, around: Reach) -> Plan:
        """The plan in the order in which it is driven. Raises InputError, and `NoWay` where a way that coarse
        looks promised is none."""
        search, ways = self._search(around), Ways(around)
        what = f"{self.count}" if self.seconds is None else f"for {self.seconds / 60:g} min"
        self.progress(f"choosing {what} of about {search.pool} possible records")
        return _driven(self._chosen(search, ways), self.prior, around, ways, self.dwell, self.progress)

    @property
    def _found(self) -> bool:
        """Whether it is to settle what a diagnosis found."""
        return self.tell is not None and is_found(self.tell)

    def _search(self, around: Reach) -> Search:
        """Fewer records on offer where many plans are tried: in time, and of what was found."""
        fast = self.quick or self._found or self.seconds is not None
        of = (QUICK_POOL, QUICK_PER_POSE, QUICK_STARTS) if fast else (POOL, PER_POSE, STARTS)
        pool, per_pose, starts = of
        return Search(max(pool, per_pose * self.count), starts, self.seed, around.draw, around.cell.driving)

    def _chosen(self, search: Search, ways: Ways) -> Plan:
        """The records, in no order yet."""
        if self.seconds is None:
            if self.tell is None:
                return plan_accuracy(self.prior, self.count, search)
            if self._found:
                return plan_settling(self.prior, self.tell, self.poses, search)
            return plan_discrimination(self.prior, self.tell, self.count, search)
        if self.tell is None:
            return plan_accuracy_in_time(self.prior, self.seconds, search, ways, self.dwell)
        in_time = plan_settling_in_time if self._found else plan_discrimination_in_time
        return in_time(self.prior, self.tell, self.seconds, search, ways, self.dwell)


def follow_up(
    campaign: Campaign,
    decision: Decision,
    *,
    seed: int = 0,
    quick: bool = False,
    progress: Progress = lambda _: None,
) -> Plan:
    """The plan that the command of a decision makes; campaign: the one that was diagnosed. Raises
    `InputError` as `plan`, and `ValueError` where the decision is no plan."""
    if decision.poses is None or decision.command is None:
        raise ValueError(f"no poses decide it: {decision.words}")
    asked = shlex.split(decision.command)
    tell = asked[asked.index("--tell") + 1] if "--tell" in asked else None
    torque = "--torque" in asked
    mounted, links = (
        [asked[i + 1] for i, word in enumerate(asked) if word == option]
        for option in ("--payload", "--reflector")
    )
    return plan(
        campaign,
        decision.poses,
        tell=tell,
        seed=seed,
        quick=quick,
        torque=torque,
        payloads=dict(payload(text, campaign.robot) for text in mounted),
        reflectors=links,
        progress=progress,
    )


def _likely(around: Reach, seconds: float, dwell: float) -> int:
    """How many poses a time may hold, about, were each as far from the next as nodes of the map are."""
    nodes = around.map.nodes
    way = around.time(nodes[:, None], nodes)
    np.fill_diagonal(way, np.inf)
    return max(1, int(seconds / (dwell + float(np.median(way.min(axis=1))))))


def _driven(
    made: Plan, prior: PriorInformation, around: Reach, ways: Ways, dwell: float, progress: Progress
) -> Plan:
    """The plan in the order in which it is driven."""
    made = replace(made, faults=prior.faults, reach=around)
    if made.records is None or made.random is None:
        return made
    progress("looking for the shortest way")
    driven, random = drive(made.records, ways, dwell), drive(made.random, ways, dwell)
    skipped = tuple(name for name in random.targets if name not in driven.targets)
    made = replace(made, reach=around.looking_at(driven.targets), skipped=skipped)
    return made.with_drive(driven, random)
