"""Stiffness axis by axis: one joint is loaded, the link before it and the link behind it are watched.

The local method of Olabi et al. (2012): a force turns the joint, instruments on both links see how far, and
the difference of the two is the joint's own turn (eq. 2 there); then torque = K · turn. Here the joints
before it are fitted beside it, from the targets on the link before it: the same difference, with its
uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..campaign import Campaign, Target
from ..campaign.planned import planned
from ..campaign.problem import problem_of
from ..effects.joint_compliance import JointCompliance
from ..identification.fit import fit
from ..identification.model import Model
from ..identification.noise import Covariance
from ..robot.description import Robot
from ..robot.kinematics import RZ

POINTER = 1000.0  # m


@dataclass(frozen=True)
class LocalStiffness:
    """Stiffness of one joint with its 95 % interval [N·m/rad]; torque: largest change about the joint
    [N·m], turn: what it makes [rad]; relative_std: one sigma of K over K."""

    joint: str
    value: float
    low: float
    high: float
    torque: float
    turn: float
    relative_std: float


def local_plan(
    robot: Robot,
    q: ArrayLike,
    wrench: ArrayLike,
    loads: ArrayLike,
    targets: Sequence[Target],
) -> Campaign:
    """One pose q (n,) [rad] under M loads [N], each `wrench` (6,) times as much: N and N·m at the flange
    origin per N of load, in the base frame."""
    size = np.asarray(loads, dtype=np.float64)
    return planned(
        robot,
        np.tile(np.asarray(q, dtype=np.float64), (len(size), 1)),
        targets=targets,
        wrench=np.outer(size, np.asarray(wrench, dtype=np.float64)),
    )


def levels(robot: Robot, q: ArrayLike, joint: str) -> tuple[Target, Target]:
    """Electronic levels on the links before and behind a joint, in pose q (n,), across its axis.

    A level tells an angle and no place: the end of a pointer so long (`POINTER`) that the link's shift is
    nothing beside the noise at its end, which is the level's noise [rad] times its length. (Such an end also
    sees the turn about the vertical, which a level does not; in these tests nothing turns that way.) Raises
    ValueError for a joint that stands upright: a level sees no turn about the vertical.
    """
    problem = problem_of(planned(robot, np.array([q], dtype=np.float64), targets=()))
    slot = problem.arm.slot_of_joint(joint)
    across = np.cross([0.0, 0.0, 1.0], problem.rigid.axes[0, slot, RZ])
    if np.linalg.norm(across) < 0.5:
        raise ValueError(f"{joint} stands upright: a level sees no turn about the vertical")
    across *= POINTER / np.linalg.norm(across)
    found = []
    for name, k in (("before", slot - 1), ("behind", slot)):
        end = problem.rigid.origin[0, slot] + across  # both start at the joint: what shifts it shifts both
        place = problem.arm.R_link[k].T @ problem.rigid.R[k, 0].T @ (end - problem.rigid.p[k, 0])
        found.append(Target(name, (float(place[0]), float(place[1]), float(place[2])), problem.arm.links[k]))
    return found[0], found[1]


def identify(campaign: Campaign, joint: str, levelled: bool = False) -> LocalStiffness:
    """The stiffness of one joint from its loads. The model's own geometry holds.

    levelled: the points are the ends of levels, along the base's axes; else an instrument's frame is sought.
    Levels don't see joints that turn across their axis: these keep the model's stiffness. Noise as the
    campaign states it; the arm stands still throughout, so its repeatability counts nothing.
    """
    problem = problem_of(campaign)
    j = problem.joint(joint)
    axes = problem.rigid.axes[0, 1 : j + 2, RZ]
    beside = [i for i in range(j + 1) if not levelled or abs(axes[i] @ axes[j]) > 0.1]
    sites = JointCompliance.each(problem)
    model = Model(problem, tuple(sites[i] for i in beside))
    in_base = model.in_base()
    sigma = np.full(problem.seen.shape, campaign.noise_sigma or 1e-5)
    noise = Covariance(sigma, np.zeros(problem.arm.n), np.ones(len(problem.q)))
    found = fit(model, in_base if levelled else None, noise, geometry=False)
    values, covariance = found.effect_values(len(beside) - 1)
    compliance, std = 1 + float(values[0]), float(np.sqrt(covariance[0, 0]))
    stated = problem.robot.joints[j].data.stiffness or np.inf
    torque = float(np.ptp(problem.nominal_load.local.reshape(len(problem.q), -1)[:, problem.arm.axial[j]]))
    return LocalStiffness(
        joint,
        stated / compliance,
        stated / (compliance + 1.96 * std),
        stated / max(compliance - 1.96 * std, 1e-12),
        torque,
        torque * compliance / stated,
        std / compliance,
    )
