"""The KR 120's compensator itself: who tells its charge and its gas length?

Loaded minus unloaded is blind to it. Two other witnesses are not: where the unloaded arm stands, and what
its drives exert. Both know the charge as well as they know what acts like it: joint 2's stiffness, and
link 2's weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench import (
    Campaign,
    Effect,
    Rig,
    Robot,
    Truth,
    catalogue,
    gas_spring,
    identify_charge,
    load_pairs,
    planned,
    problem_of,
    random_poses,
    simulate,
)

GAS = catalogue()["gravity_compensator"](variant="charge")
GAS_LENGTH = gas_spring.GasLength(variant="gas_length")
OTHER_CHARGE, OTHER_LENGTH = -0.08, 0.12  # of the model's: what is hidden in this machine


def blind_to_charge(campaign: Campaign, lost: float, sigma: float) -> dict[str, float]:
    """What loaded minus unloaded says of a compensator that has lost a share of its charge."""
    found = load_pairs.fit_beside(campaign, GAS, sigma)
    values, covariance = found.effect_values(len(found.model.effects) - 1)
    half = 1.96 * float(np.sqrt(covariance[0, 0]))
    return {"lost_charge": lost, "pairs_charge": float(values[0]), "pairs_charge_half": half}


def charge_by_witness(
    robot: Robot, usual: Truth, rig: Rig, drive_noise: float, poses: int, seed: int
) -> dict[str, float]:
    """Charge and gas length from unloaded poses, from motor torque, from both: with all else known, beside
    joint 2's stiffness, beside link 2's centre of mass."""
    q = random_poses(robot, poses, np.random.default_rng([seed, 2]), floor=0.4, clear=0.6)
    plan = planned(robot, q, targets=rig.targets, tool=rig.tool)
    other = (GAS, np.array([OTHER_CHARGE])), (GAS_LENGTH, np.array([OTHER_LENGTH]))
    measured = simulate(plan, replace(usual, effects=other), seed=seed, torque_sigma=drive_noise)
    problem = problem_of(plan)
    masses = catalogue()["link_mass"].sites(problem)
    beside: dict[str, Sequence[Effect]] = {
        "": (),
        "_stiffness": catalogue()["joint_compliance"].sites(problem)[1:2],
        "_mass": [e for e in masses if e.where.link == "link_2" and e.variant == "com"],
    }
    numbers: dict[str, float] = {"other_charge": OTHER_CHARGE, "other_length": OTHER_LENGTH}
    for witness in ("points", "torque", "both"):
        for name, unknown in beside.items():
            found = identify_charge(measured, witness, drive_noise, unknown)
            numbers |= {f"{witness}_charge{name}": found.charge, f"{witness}_length{name}": found.length}
            numbers[f"{witness}_charge{name}_half"] = 1.96 * found.charge_std
            numbers[f"{witness}_length{name}_half"] = 1.96 * found.length_std
    return numbers
