"""A campaign looked at before any fit: the instrument's frame and the targets found, nothing calibrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..campaign import Campaign, torque_columns
from ..campaign.problem import Problem, problem_of
from ..effects import catalogue
from ..effects.given import exclusions, given_facts
from ..files.faults import Fault, InputError
from ..identification.iso_9283 import Repeatability, repeatability
from ..identification.plausible import believed, enough_poses
from ..identification.registration import register
from ..robot.kinematics import Array
from .candidates import untold
from .data_faults.wild_points import FARTHEST
from .found import NotTestable
from .noise.distances import far_too_much

SUSPICIOUS = 5.0  # times the median distance of what the arm carries: it errs, what stands beside it does not


@dataclass(frozen=True)
class FirstLook:
    """Where the points are beside a robot that is as its URDF says.

    points: (M, 3) [m] measured, in the base frame; error: (M, 3) [m] measured minus nominal; pose, target:
    (M,) their numbers; suspicious: (M,) far off the others; usual: [m] the median distance; q: (n,) joints of
    the middle pose. repeats: what repeated poses show, where there are enough. not_testable: causes that such
    data cannot show. wrong: why joints, points and robot do not belong together; remarks: what is worth a
    word of it.
    """

    campaign: Campaign
    points: Array
    error: Array
    pose: NDArray[np.int64]
    target: NDArray[np.int64]
    suspicious: NDArray[np.bool_]
    usual: float
    q: Array
    repeats: Repeatability | None
    not_testable: tuple[NotTestable, ...]
    remarks: tuple[str, ...]
    wrong: tuple[Fault, ...]

    @property
    def distance(self) -> Array:
        """(M,) [m] of each point from where the nominal robot has it."""
        return np.asarray(np.linalg.norm(self.error, axis=1))

    @property
    def names(self) -> list[str]:
        """Pose and target of each point."""
        ids, targets = self.campaign.poses.ids, self.campaign.targets
        return [f"{ids[i]} {targets[t].name}" for i, t in zip(self.pose, self.target, strict=True)]


def first_look(campaign: Campaign) -> FirstLook:
    """Registers the points with the nominal robot, and judges whether they belong to it."""
    possible = np.asarray((np.abs(campaign.poses.q) <= FARTHEST).all(axis=1))
    if 0 < possible.sum() < len(possible):  # a warning says which joint is not
        campaign = campaign.some(np.flatnonzero(possible))
    problem = problem_of(campaign)
    no_faults: tuple[Fault, ...] = ()
    try:
        problem, remarks = believed(problem)
        wrong = no_faults
    except InputError as unfit:
        remarks, wrong = [], unfit.faults
    wrong = (*_known_wrong(problem), *wrong)
    R, t, targets = register(problem)
    setup, on = campaign.poses.setup, problem.on
    nominal = np.empty_like(campaign.points)
    measured = np.empty_like(campaign.points)
    for k in range(len(R)):
        here = setup == k
        nominal[here] = problem.rigid.points(targets[k], on)[here]
        measured[here] = (campaign.points[here] - t[k]) @ R[k]
    pose, target = np.nonzero(problem.seen)
    points, error = measured[pose, target], (measured - nominal)[pose, target]
    distance = np.linalg.norm(error, axis=1)
    carried = np.array(problem.on)[target] > 0
    usual = float(np.median(distance[carried] if carried.any() else distance))
    middle = np.argmin(np.linalg.norm(problem.q - np.median(problem.q, axis=0), axis=1))
    missing = [(cause, untold(kind, problem)) for cause, kind in catalogue().items()]
    return FirstLook(
        campaign,
        points,
        error,
        pose,
        target,
        distance > SUSPICIOUS * usual,
        usual,
        problem.q[middle],
        repeatability(problem),
        tuple(NotTestable(cause, why) for cause, why in missing if why is not None),
        (
            *remarks,
            *_few_poses(problem),
            *far_too_much(problem, error[carried]),
            *torque_columns.remarks(problem),
        ),
        wrong,
    )


def _few_poses(problem: Problem) -> list[str]:
    """What the poses are too few for, to be told: beside others of the robot they need not be enough."""
    try:
        return enough_poses(problem)
    except InputError as few:
        return [f"{fault.what}; {fault.mend.partition('; ')[0]}" for fault in few.faults]


def _known_wrong(problem: Problem) -> list[Fault]:
    """What is wrong with `[known]`: a cause that there is not, a fact that cannot be."""
    faults = list[Fault]()
    for reading in (given_facts, exclusions):
        try:
            reading(problem)
        except InputError as error:
            faults += error.faults
    return faults
