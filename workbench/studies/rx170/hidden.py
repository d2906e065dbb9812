"""The robot as it is, which no step of the study sees."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from workbench import Array, EffectRecord, Robot, stored

# The true gears: cycles per joint turn, amplitude, phase [rad]. Joint 2's fundamental swells along the stroke
# (199, 201); its third harmonic, the shaft (100), the motor (140) and run-out (1) add their own.
GEARS = {
    "joint_1": ((200, 5e-5, 0.9),),
    "joint_2": (
        *((199, 8e-6, 0.2), (200, 7e-5, 0.6), (201, 8e-6, 1.0), (400, 1.5e-5, 1.1), (600, 5e-6, 2.5)),
        *((100, 1.2e-5, 2.0), (140, 8e-6, 0.3), (1, 5e-5, 0.5)),
    ),
    "joint_3": ((200, 5e-5, 1.7), (400, 1e-5, 0.4), (1, 4e-5, 2.0)),
    "joint_4": ((96, 6e-5, 0.2),),
    "joint_5": ((88, 6e-5, 1.2),),
    "joint_6": ((72, 8e-5, 2.2),),
}


def hidden(folder: Path, robot: Robot, seed: int) -> tuple[Robot, Array]:
    """The robot as it is, which no step sees, and its stiffness over Table I: (6,), 10 to 20 % off."""
    rng = np.random.default_rng([seed, 170])
    share = 1 + rng.choice([-1, 1], 6) * rng.uniform(0.1, 0.2, 6)
    effects = [
        EffectRecord(cause="joint_compliance", joint=name, values={"relative": 1 / s - 1})
        for name, s in zip(robot.joint_names, share, strict=True)
    ]
    for joint, lines in GEARS.items():
        for order, a, phase in lines:
            size = {"amplitude": a, "phase": phase}
            effects.append(
                EffectRecord(cause="gear_eccentricity", joint=joint, variant="1", values=size)
                if order == 1
                else EffectRecord(cause="gear_kinematic_error", joint=joint, order=order, values=size)
            )
    return stored(folder / "truth.toml", robot, effects), share
