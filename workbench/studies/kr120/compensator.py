"""The KR 120's compensator itself: what its gas does, and who tells its charge and its gas length?

Loaded minus unloaded is blind to it. Two other witnesses are not: where the unloaded arm stands, and what
its drives exert. Both know the charge as well as they know what acts like it: joint 2's stiffness, and
link 2's weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench import (
    Array,
    Effect,
    Problem,
    Rig,
    Robot,
    Table,
    Truth,
    catalogue,
    gas_spring,
    identify_charge,
    numbers,
    planned,
    pressure,
    problem_of,
    random_poses,
    simulate,
)

from .decides import GAS
from .plans import CLEAR, FLOOR, JOINT, spring
from .printed import KR300_ANGLES, KR300_PISTON, KR300_PRESSURES, KR300_TANKS

GAS_LENGTH = gas_spring.GasLength(variant="gas_length")
OTHER_CHARGE, OTHER_LENGTH = -0.08, 0.12  # of the model's: what is hidden in this machine
WARMER, PER_KELVIN = 10.0, 1 / 293.15  # K, 1/K of an ideal gas at 20 °C
FAST, LOST = 1.3, 0.1  # exponent, share


def charge_by_witness(
    robot: Robot, usual: Truth, rig: Rig, drive_noise: float, poses: int, seed: int
) -> dict[str, float]:
    """Charge and gas length from unloaded poses, from motor torque, from both: with all else known, beside
    joint 2's stiffness, beside link 2's centre of mass."""
    q = random_poses(robot, poses, np.random.default_rng([seed, 2]), floor=FLOOR, clear=CLEAR)
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
    found_all: dict[str, float] = {"other_charge": OTHER_CHARGE, "other_length": OTHER_LENGTH}
    for witness in ("points", "torque", "both"):
        for name, unknown in beside.items():
            found = identify_charge(measured, witness, drive_noise, unknown)
            found_all |= {f"{witness}_charge{name}": found.charge, f"{witness}_length{name}": found.length}
            found_all[f"{witness}_charge{name}_half"] = 1.96 * found.charge_std
            found_all[f"{witness}_length{name}_half"] = 1.96 * found.length_std
    return found_all


def gauged(triangle: gas_spring.Linkage) -> dict[str, float]:
    """What nine pressures of a KR 300 say of its gas, on this robot's linkage."""
    gas = pressure.fit_gas(triangle, KR300_ANGLES, KR300_PRESSURES)
    length = KR300_TANKS / KR300_PISTON
    exponent = pressure.fit_gas(triangle, KR300_ANGLES, KR300_PRESSURES, length=length)
    coil = pressure.fit_coil(triangle, KR300_ANGLES, KR300_PRESSURES)
    return {
        "gauge_count": float(gas.count),
        "gauge_bar": 1e-5 * float(gas.values[0]),
        "gauge_bar_half": 1.96e-5 * float(gas.std[0]),
        "gauge_length_mm": 1e3 * float(gas.values[1]),
        "gauge_tank_mm": 1e3 * length,
        "gauge_length_mm_half": 1.96e3 * float(gas.std[1]),
        "gauge_exponent": float(exponent.values[1]),
        "gauge_exponent_half": 1.96 * float(exponent.std[1]),
        "gauge_rms_bar": 1e-5 * gas.rms,
        "coil_rms_bar": 1e-5 * coil.rms,
        "gas_told_from_coil": float(pressure.told_apart(gas, coil)),
    }


def changed_gas(problem: Problem, angles: Array, reach: float) -> Table:
    """What other gas does: largest change of torque, shift of the stretched arm's flange, change of
    stiffness."""
    triangle, law = spring(problem)
    gear = problem.robot.joints[JOINT].data.stiffness or np.inf
    faster = replace(law, data=law.data.model_copy(update={"exponent": FAST}))
    others = {
        f"{WARMER:.0f} K warmer ({numbers.percent(PER_KELVIN, 2)} per K)": replace(
            law, charge=1 + WARMER * PER_KELVIN
        ),
        f"moved fast, exponent {FAST:.1f} in place of 1": faster,
        f"{numbers.percent(LOST, 0)} of the charge lost": replace(law, charge=1 - LOST),
    }
    rows = []
    torque, added = gas_spring.bias(triangle, law, angles), gas_spring.added_stiffness(triangle, law, angles)
    for words, other in others.items():
        change = np.abs(gas_spring.bias(triangle, other, angles) - torque).max()
        stiffer = np.abs(gas_spring.added_stiffness(triangle, other, angles) - added).max() / gear
        shift = 1e3 * change / gear * reach
        rows.append(
            [
                words,
                numbers.significant(float(change), 2),
                numbers.mm(float(shift)),
                numbers.percent(float(stiffer), 2),
            ]
        )
    head = ("Gas", "Torque on joint 2, N·m", "Flange of the stretched arm, mm", "Joint 2's stiffness")
    note = "Largest change over the angles, from the robot's own gas, at 20 °C and slowly moved."
    return Table("What warmth, fast moves and a leak change: the torque, not the stiffness", head, rows, note)
