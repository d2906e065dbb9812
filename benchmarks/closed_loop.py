"""Real-time factor of the closed loop with everything on, beside Drake's plain plant in the same run.

    python benchmarks/closed_loop.py

Processor time, not wall time: it moves less with the machine's load. The plain plant is the same robot with
its springs and dampers and nothing else, in Drake's Simulator with third-order Runge–Kutta at the same step;
it falls freely, so for a short time.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests")]

from extended_example import extended_kr500  # noqa: E402

from workbench.campaign.problem import Problem  # noqa: E402
from workbench.correction.command import compensate  # noqa: E402
from workbench.correction.conditions import Conditions, path_campaign  # noqa: E402
from workbench.correction.extended_arm import extended_arm  # noqa: E402
from workbench.correction.path_shapes import Run, circle, work_frame  # noqa: E402
from workbench.correction.paths import Path as ToolPath  # noqa: E402
from workbench.robot.compensator import compensator_law  # noqa: E402
from workbench.robot.description import Robot, load_robot  # noqa: E402
from workbench.robot.elastic_plant import elastic_twin  # noqa: E402
from workbench.robot.rigid_plant import arrays  # noqa: E402
from workbench.simulation.closed_loop.control import nominal_mechanics  # noqa: E402
from workbench.simulation.closed_loop.drives import Drives, drives  # noqa: E402
from workbench.simulation.closed_loop.gains import gains  # noqa: E402
from workbench.simulation.closed_loop.machine import machine  # noqa: E402
from workbench.simulation.closed_loop.mechanics import Mechanics, mechanics  # noqa: E402
from workbench.simulation.closed_loop.motion import motion  # noqa: E402
from workbench.simulation.closed_loop.simulation import run  # noqa: E402

WANTED = 5.0  # times real time


def plain_plant(truth: Mechanics, drive: Drives, q: np.ndarray, step: float, seconds: float) -> float:
    """Real-time factor of Drake's plant with its springs and dampers alone."""
    built = machine(truth, drive)
    simulator = Simulator(built.plant)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", step)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    positions = np.zeros(built.plant.num_positions())
    positions[built.motors] = q
    built.plant.SetPositions(simulator.get_mutable_context(), positions)
    started = time.process_time()
    simulator.AdvanceTo(seconds)
    return seconds / (time.process_time() - started)


def loaded_pose(robot: Robot, loads: Conditions) -> tuple[float, float]:
    """Processor time [ms] of a loaded pose in Drake: the median pose and the worst, each at its best of
    five."""
    q = np.array([0.3, -1.0, 1.2, 0.4, 0.7, 0.2]) + np.random.default_rng(0).uniform(-0.3, 0.3, (20, 6))
    path = ToolPath(np.arange(float(len(q))), q=q)
    law = compensator_law(robot, arrays(robot))
    extended = extended_arm(Problem(robot, arrays(robot), path_campaign(robot, path, q, loads), law))
    poses = []
    for j in range(len(q)):
        here = extended.at(q[j : j + 1], np.ones((1, 6)), slice(j, j + 1))
        arm, pull = extended.loads(here)
        poses.append((q[j], extended.direct(here)[0], pull))
    still = np.abs([direct for _, direct, _ in poses]).max(axis=0)
    moved = [(int(slot), int(component)) for slot, component in zip(*np.nonzero(still), strict=True)]
    law = poses[0][2].compensator
    twin = elastic_twin(arm, robot, extended.acting.yielding(arm), moved, law)
    took = np.full((5, len(q)), np.inf)
    for i, j in np.ndindex(took.shape):
        started = time.process_time()
        twin.equilibrium(*poses[j])
        took[i, j] = time.process_time() - started
    return float(1e3 * np.median(took.min(axis=0))), float(1e3 * took.min(axis=0).max())


def main() -> int:
    """Prints both factors; status 1 when everything on is slower than it has to be."""
    robot = extended_kr500()
    loads = Conditions(
        "heavy", 250.0, (0.15, 0.0, 0.05), wrench=(100.0, 0.0, -200.0, 0.0, 0.0, 20.0), temperature=25.0
    )
    path = circle(0.15, Run(work_frame((1.6, 0.3, 0.9)), speed=0.2, acceleration=0.5, period=0.01))
    q = compensate(robot, path, loads).q_command
    truth = mechanics(robot, path, q, loads)
    nominal = nominal_mechanics(robot, truth)
    moved = motion(path.time, q, sided=True)
    drive = drives(truth, q[0], robot.loop)
    tuned = gains(truth, drive, robot.loop, q[:1])
    step = robot.loop.drive_period
    best, alone = 0.0, 0.0
    for _ in range(3):
        best = max(best, run(truth, nominal, moved, tuned=tuned).real_time_factor)
        alone = max(alone, plain_plant(truth, drive, q[0], step, 0.3))
    parts = f"{len(truth.gives)} springs of slots, 6 of joints, 6 drives, {len(truth.gear)} gear errors"
    print(f"everything on   {best:5.2f} x real time (step {1e3 * step:g} ms, {parts})")
    slower = robot.loop.model_copy(update={"drive_period": 1e-3, "delay": 1e-3})
    factor = max(run(truth, nominal, moved, loop=slower).real_time_factor for _ in range(3))
    print(f"everything on   {factor:5.2f} x real time (step 1 ms: drives sampled every 1 ms)")
    print(f"plain plant     {alone:5.2f} x real time (Runge–Kutta 3, same step)")
    print(f"ratio           {best / alone:5.2f}")
    for what, one in (("its TOML's", load_robot("kr500")), ("everything", robot)):
        middle, worst = loaded_pose(one, loads)
        print(f"a loaded pose   {middle:5.2f} ms in Drake, {worst:.2f} ms the worst of 20 ({what})")
    return 0 if best >= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
