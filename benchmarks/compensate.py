"""10,000 samples of a path on a KR 500 with twelve effects, corrected in batch.

Beside two references measured in the same run: SciPy's least_squares pose by pose on the same model, and
a plain matrix product.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares
from timing import shortest

from workbench.correction.command import compensate
from workbench.correction.conditions import Conditions
from workbench.correction.path_shapes import Run, spiral, work_frame
from workbench.correction.paths import Path
from workbench.correction.solve import settle
from workbench.correction.trajectory import Trajectory, trajectory_of
from workbench.robot.description import Robot, load_robot
from workbench.robot.kinematics import Array
from workbench.robot.schema import EffectRecord

POINTS = 10_000
SOLVED_BY_SCIPY = 10  # poses
HEAVY = Conditions("heavy", 250.0, (0.15, 0.0, 0.05), temperature=28.0)
X_FT = np.eye(4)
X_FT[:3, 3] = [0.1, 0.02, 0.25]
TWELVE_EFFECTS = (
    EffectRecord(cause="joint_compliance", joint="joint_3", values={"relative": 0.4}),
    EffectRecord(
        cause="gear_kinematic_error", joint="joint_4", order=200.0, values={"sin": 2e-4, "cos": 6e-5}
    ),
    EffectRecord(cause="gear_eccentricity", joint="joint_1", variant="1", values={"sin": 8e-5, "cos": -3e-5}),
    EffectRecord(cause="gear_ratio", joint="joint_6", values={"relative": 5e-5}),
    EffectRecord(cause="backlash", joint="joint_2", values={"half_width": 4e-5}),
    EffectRecord(cause="backlash", joint="joint_5", values={"half_width": 8e-5}),
    EffectRecord(cause="bearing_tilt", joint="joint_1", values={"compliance": 2e-8}),
    EffectRecord(cause="link_bending", link="link_2", values={"compliance": 1.5e-8}),
    EffectRecord(cause="gravity_compensator", variant="charge", values={"relative": -0.15}),
    EffectRecord(cause="hose_torque", joint="joint_4", values={"rate": 30.0}),
    EffectRecord(cause="payload", payload="heavy", variant="mass", values={"mass": 9.0}),
    EffectRecord(cause="thermal_growth", values={"coefficient": 1.15e-5}),
)


def pose_by_pose(trajectory: Trajectory, direction: Array | None) -> Array:
    """Commanded joints of every sample by SciPy, finite differences, from the nominal joints."""
    found = np.empty_like(trajectory.q)
    for i in range(len(trajectory.q)):
        here = trajectory.extended.at(trajectory.q[i : i + 1], None, slice(i, i + 1))
        extended = replace(trajectory.extended, problem=here)
        one = replace(trajectory, X=trajectory.X[i : i + 1], extended=extended)
        side = None if direction is None else direction[i : i + 1]

        def error(q: Array, one: Trajectory = one, side: Array | None = side) -> Array:
            return one.tip.scaled(settle(one, q[None], side).error)[0]

        found[i] = least_squares(error, trajectory.q[i], xtol=1e-12, ftol=1e-12, gtol=1e-12).x
    return found


def main() -> None:
    robot: Robot = replace(load_robot("kr500"), effects=TWELVE_EFFECTS)
    whole = spiral(Run(work_frame([1.8, 0.2, 0.8]), speed=0.03, acceleration=0.1, period=0.003043))
    assert whole.X is not None
    path = Path(whole.time[:POINTS], X=whole.X[:POINTS])
    done = compensate(robot, path, HEAVY, tool=X_FT)
    batch = shortest(lambda: compensate(robot, path, HEAVY, tool=X_FT))
    given = shortest(lambda: compensate(robot, path, HEAVY, tool=X_FT, start=done.q_nominal[0]))
    some = np.linspace(0, POINTS - 1, SOLVED_BY_SCIPY).astype(int)
    few = Path(path.time[some], X=path.X[some]) if path.X is not None else path
    trajectory = trajectory_of(robot, few, HEAVY, X_FT, done.q_nominal[0])
    sides = None if done.direction is None else done.direction[some]
    single = shortest(lambda: pose_by_pose(trajectory, sides), 1) / SOLVED_BY_SCIPY
    apart = np.abs(pose_by_pose(trajectory, sides) - done.q_command[some]).max()
    square = np.random.default_rng(0).normal(size=(1000, 1000))
    product = shortest(lambda: square @ square)
    print(f"{len(path)} samples, error {done.before_mm.mean():.3f} -> {done.after_mm.max():.1e} mm")
    print(f"batch            {batch:6.3f} s, {1e6 * batch / POINTS:.0f} us a sample, {done.rounds} rounds")
    print(f"batch, start given {given:4.3f} s")
    print(f"SciPy, one pose  {single:6.3f} s  -> batch is {single * POINTS / batch:.0f} times as fast; "
          f"joints differ by {apart:.1e} rad")  # fmt: skip
    print(f"matrix product of 1000 x 1000: {product:.4f} s; batch / product = {batch / product:.1f}")


if __name__ == "__main__":
    main()
