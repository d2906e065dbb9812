"""Charge and gas length of a compensator, from where the arm stands and from what its drives exert."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...campaign import Campaign, torque_columns
from ...campaign.problem import problem_of
from ...effects.base import Effect
from ...effects.gravity_compensator import GravityCompensator
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ..fit import Fit, fit
from ..model import Model
from ..noise import required_noise
from .gas_spring import GasLength

Witness = Literal["points", "torque", "both"]
BLIND = 1e3  # m: noise with which points say nothing
LENGTH_ROUNDS = 3
EFFECTS = GravityCompensator(variant="charge"), GasLength(variant="gas_length")


@dataclass(frozen=True)
class Charge:
    """Relative errors of charge and gas length over the model's, with their standard deviations."""

    charge: float
    charge_std: float
    length: float
    length_std: float


def identify_charge(
    campaign: Campaign, witness: Witness, torque_share: float = 0.03, unknown: Sequence[Effect] = ()
) -> Charge:
    """Charge and length from absolute poses, all geometry free, from the drives' torques, or from both.

    torque_share: noise of a torque as a share of the joint's largest; unknown: effects that are fitted
    beside (a stiffness, a mass) because nobody knows them better. Raises InputError without a gas
    compensator, noise, or the torques that are asked.
    """
    if witness != "points" and campaign.poses.torque is None:
        raise InputError(Fault(campaign.title, "has no torques", "record tau1_Nm ... in poses.csv"))
    used = campaign.with_poses(torque=None) if witness == "points" else campaign
    charge = length = 1.0
    # torques follow the length along a tangent: each round starts where the last ended
    for _ in range(LENGTH_ROUNDS):
        here = replace(used, robot=_recharged(campaign.robot, charge, length))
        found = _fitted(here, witness, torque_share, unknown)
        (more, charge_variance), (longer, length_variance) = (found.effect_values(i) for i in range(2))
        factors = charge, length
        charge, length = charge * (1 + float(more[0])), length * (1 + float(longer[0]))
    charge_std, length_std = (
        factor * float(np.sqrt(variance[0, 0]))
        for factor, variance in zip(factors, (charge_variance, length_variance), strict=True)
    )
    return Charge(charge - 1, charge_std, length - 1, length_std)


def _fitted(campaign: Campaign, witness: Witness, torque_share: float, unknown: Sequence[Effect]) -> Fit:
    problem = problem_of(campaign)
    noise = required_noise(problem)
    if campaign.poses.torque is not None:
        believed = np.isfinite(torque_columns.noise(problem))
        largest = np.nanmax(np.abs(campaign.poses.torque), axis=0)
        noise = replace(noise, torque=np.where(believed, torque_share * largest, np.inf))
    if witness == "torque":
        noise = replace(noise, sigma=np.full_like(noise.sigma, BLIND))
    return fit(Model(problem, (*EFFECTS, *unknown)), noise=noise)


def _recharged(robot: Robot, charge: float, length: float) -> Robot:
    """The robot with its compensator's charge and gas length times these factors."""
    gas = robot.compensator
    if gas is None or gas.precharge is None or gas.gas_length is None:
        raise InputError(Fault(robot.name, "has no gas compensator", "describe it under [compensator]"))
    new = {"precharge": charge * gas.precharge, "gas_length": length * gas.gas_length}
    return replace(robot, compensator=gas.model_copy(update=new))
