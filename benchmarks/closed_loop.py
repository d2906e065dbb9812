"""Real-time factor of the closed loop with everything on, beside the elastic plant alone in the same run.

    python benchmarks/closed_loop.py

The second number says what our forces cost; it moves less with the machine's load than seconds do.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests")]

from extended_example import extended_kr500  # noqa: E402

from workbench.correction import Conditions, compensate  # noqa: E402
from workbench.correction.path_shapes import Run, circle, work_frame  # noqa: E402
from workbench.simulation.closed_loop.control import Controller, drives, nominal_mechanics  # noqa: E402
from workbench.simulation.closed_loop.machine import machine  # noqa: E402
from workbench.simulation.closed_loop.mechanics import Mechanics, mechanics  # noqa: E402
from workbench.simulation.closed_loop.motion import motion  # noqa: E402
from workbench.simulation.closed_loop.simulation import run  # noqa: E402


def plant_alone(truth: Mechanics, rotor: np.ndarray, q: np.ndarray, seconds: float) -> float:
    """Real-time factor of the plant without any force but gravity."""
    plant = machine(truth, rotor).plant
    simulator = Simulator(plant)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", 1e-3)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    positions = np.zeros(plant.num_positions())
    positions[machine(truth, rotor).motors] = q
    plant.SetPositions(simulator.get_mutable_context(), positions)
    started = time.perf_counter()
    simulator.AdvanceTo(seconds)
    return seconds / (time.perf_counter() - started)


def main() -> int:
    """Prints both factors; status 1 when everything on is slower than twice real time."""
    robot = extended_kr500()
    loads = Conditions("heavy", 250.0, (0.15, 0.0, 0.05), wrench=(100.0, 0.0, -200.0, 0.0, 0.0, 20.0))
    path = circle(0.15, Run(work_frame((1.6, 0.3, 0.9)), speed=0.2, acceleration=0.5, period=0.01))
    q = compensate(robot, path, loads).q_command
    truth = mechanics(robot, path, q, loads)
    nominal = nominal_mechanics(robot, truth)
    moved = motion(path.time, q, sided=True)
    factors = [run(truth, nominal, moved).real_time_factor for _ in range(3)]
    rotor = drives(truth, q[0], Controller()).rotor
    alone = plant_alone(truth, rotor, q[0], 2.0)
    best = max(factors)
    print(
        f"everything on   {best:5.2f} x real time ({len(truth.screws)} yielding screws, 6 springs, 6 drives)"
    )
    print(f"plant alone     {alone:5.2f} x real time")
    print(f"ratio           {best / alone:5.2f}")
    return 0 if best >= 2 else 1


if __name__ == "__main__":
    sys.exit(main())
