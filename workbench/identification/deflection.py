"""What loads move an arm's points by, as it is modelled, and which part of the arm does it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem, problem_of
from ..effects.records import stated_effects
from ..robot.beam import bending_compliance
from ..robot.description import Robot
from ..robot.kinematics import RX, RY, RZ, TZ, Array, point_jacobian
from .model import Model, Prediction


@dataclass(frozen=True)
class Budget:
    """Motions of the first target by what yields: parts: kind → (N, n, 3) [m] in the base frame, of each
    joint ("torsion"), bearing ("overturning") and link ("link"); whole: (N, 3) of everything together, the
    arm's answer to its own sag included; moment: (N, n) [N·m] length of the moment at each joint."""

    parts: Mapping[str, Array]
    whole: Array
    moment: Array


def places(campaign: Campaign) -> Array:
    """(N, T, 3) [m] where the targets are under the stated loads, as modelled, in the base frame."""
    return _loaded(problem_of(campaign)).base


def deflection(campaign: Campaign) -> Array:
    """(N, T, 3) [m] how far the stated loads and the arm's own weight move the targets, in the base frame."""
    problem = problem_of(campaign)
    return _loaded(problem).base - _unloaded(problem)


def deflection_budget(campaign: Campaign) -> Budget:
    """Who moves the first target of the campaign's N poses by how much: each part's own yield, seen there.

    Under the stated loads, as modelled; in m. The loads are those of `deflection`.
    """
    problem = problem_of(campaign)
    arm, robot, now = problem.arm, problem.robot, _loaded(problem)
    J = point_jacobian(now.where.axes, now.where.origin, now.base[:, :1], problem.on[:1])
    J = J.reshape(len(problem.q), 3, arm.slots, 6)
    parts = {}
    for kind in ("torsion", "overturning", "link"):
        C = np.zeros((arm.slots, 6, 6))
        for i, joint in enumerate(robot.joints, start=1):
            if kind == "torsion":
                axial = TZ if arm.prismatic[i - 1] else RZ
                C[i, axial, axial] = 1 / (joint.data.stiffness or np.inf)
            elif kind == "overturning":
                C[i, [RX, RY], [RX, RY]] = 1 / (joint.data.tilt_stiffness or np.inf)
            else:
                stiffness = robot.bending_stiffness.get(joint.link, np.inf)
                C[i + 1] = bending_compliance(arm.span[i + 1]) / stiffness
        moved = np.einsum("ncsk,skl,nsl->nsc", J, C, now.load.local)
        parts[kind] = moved[:, 2:] if kind == "link" else moved[:, 1:-1]
    moment = np.linalg.norm(now.load.local[:, 1:-1, 3:], axis=2)
    return Budget(parts, now.base[:, 0] - _unloaded(problem)[:, 0], moment)


def with_compliance(robot: Robot, share: float) -> Robot:
    """The robot with this share of the compliance of its joints and bearings; 0: all rigid, links too."""
    joints = []
    for joint in robot.joints:
        stated = {key: getattr(joint.data, key) for key in ("stiffness", "tilt_stiffness")}
        new = {key: value / share if share and value else None for key, value in stated.items()}
        joints.append(replace(joint, data=joint.data.model_copy(update=new)))
    return replace(robot, joints=tuple(joints), bending_stiffness=robot.bending_stiffness if share else {})


def _loaded(problem: Problem) -> Prediction:
    model = Model(problem, (), tuple(stated_effects(problem)))
    return model.loaded(model.in_base())


def _unloaded(problem: Problem) -> Array:
    """(N, T, 3) the targets of the same robot, ratios and all, if nothing pulled on it."""
    arm = replace(problem.arm, compliance=np.zeros_like(problem.arm.compliance), gravity=np.zeros(3))
    campaign = problem.campaign.with_poses(wrench=np.zeros_like(problem.campaign.poses.wrench))
    return _loaded(replace(problem, arm=arm, campaign=campaign, compensator=None)).base
