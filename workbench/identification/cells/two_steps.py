"""Kinematics from poses without load, stiffness from what a load moves: the two steps of Jiao et al. 2020.

Its model is d = D(J K⁻¹ Jᵀ) f, eq. (9), f as a force sensor at the flange shows it: the arm's own weight
is no part of it and stays in the kinematics, eqs. (1)–(4). So here the robot is weightless and without
compensator, and a payload is a wrench at the flange.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.problem import problem_of
from ...effects.joint_compliance import JointCompliance
from ...effects.records import record
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ...robot.kinematics import Arm, Array, moved_base
from ..deflection import places
from ..fit import Fit, fit
from ..model import Model, State
from ..noise import Covariance, required_noise

COMPUTED_WEIGHT = 1e3  # how much more than a measured place a computed one counts


def external(campaign: Campaign) -> Campaign:
    """The campaign of a weightless robot: payloads as wrenches at the flange, tool and own weight left out.

    What is external already stays as it is.
    """
    robot = campaign.robot
    where = problem_of(campaign).rigid
    weight = campaign.load_mass[campaign.poses.payload, None] * np.array(robot.gravity)
    lever = (where.R[-1] @ campaign.load_com[campaign.poses.payload][..., None])[..., 0]
    wrench = campaign.poses.wrench + np.hstack([weight, np.cross(lever, weight)])
    return replace(
        campaign.with_poses(wrench=wrench, payload=np.zeros_like(campaign.poses.payload)),
        robot=replace(robot, gravity=(0.0, 0.0, 0.0), compensator=None),
        payload_names=("",),
        load_mass=np.zeros(1),
        load_com=np.zeros((1, 3)),
        tool_mass=0.0,
    )


def part(campaign: Campaign, chosen: NDArray[np.bool_]) -> Campaign:
    """Some poses of a campaign, without what an external load does not ask for."""
    return campaign.some(np.flatnonzero(chosen)).with_poses(
        side=None, time=None, temperature=None, torque=None, readback=None
    )


def identified(campaign: Campaign, kinematics: bool = True) -> tuple[Robot, Fit]:
    """The extended robot of a campaign with poses with and without load, and the fit of its stiffness.

    campaign: `external`, its points in the base frame, its targets where they are stated. kinematics=False
    keeps the robot's own. Raises `InputError` where no pose was measured both with and without load.
    """
    robot = campaign.robot
    empty = np.asarray(~campaign.poses.wrench.any(axis=1))
    if kinematics:
        model = Model(problem_of(part(campaign, empty)))
        found = fit(model, model.in_base())
        robot = robot.corrected(seated(model.problem.arm, found.state))
    stiffness = _from_differences(replace(campaign, robot=robot), empty)
    pairs = zip(stiffness.model.effects, stiffness.state.values, strict=True)
    return replace(robot, effects=tuple(record(effect, values) for effect, values in pairs)), stiffness


def _from_differences(campaign: Campaign, empty: NDArray[np.bool_]) -> Fit:
    """The joints' compliances from loaded minus unloaded places, both put where the kinematics has them."""
    same = problem_of(campaign).positions
    first = {number: i for i, number in reversed(list(enumerate(same))) if empty[i]}
    pair = np.array([first.get(number, -1) for number in same])
    used = empty | (pair >= 0)
    if used.sum() == empty.sum():
        raise InputError(Fault(campaign.title, "no pose was measured with and without load", "measure both"))
    rest = places(campaign.with_poses(wrench=np.zeros_like(campaign.poses.wrench)))
    moved = rest + np.where(empty[:, None, None], 0.0, campaign.points - campaign.points[pair])
    differences = problem_of(part(replace(campaign, points=moved), used))
    noise = required_noise(differences)
    both = Covariance(
        np.sqrt(2) * noise.sigma, np.sqrt(2) * noise.joint, np.where(empty[used], COMPUTED_WEIGHT, 1.0)
    )
    model = Model(differences, tuple(JointCompliance.each(differences)))
    return fit(model, model.in_base(), both, geometry=False)


def seated(arm: Arm, state: State) -> Array:
    """(S, 6) a state's geometry, with what it gave the instrument's frame put into the first joint.

    For an instrument that is known to stand in the base frame: then the robot stands where it was seen.
    """
    return moved_base(arm, state.geometry, state.R[0], state.t[0])
