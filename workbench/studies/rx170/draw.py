"""Paths drawn in closed loop with the corrections of several beliefs, beside none."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from workbench import (
    Array,
    Path,
    Robot,
    Task,
    World,
    compensate,
    simulate_all,
    stated_conditions,
)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A path of N samples as drawn. wanted: (N, 3) [m]; time: (N,) [s]; q: (N, n) uncorrected joints;
    error: command → (N, 3) [m] tool minus wanted."""

    wanted: Array
    time: Array
    q: Array
    error: dict[str, Array]


def draw_corrected(
    truth: Robot,
    nominal: Robot,
    paths: Sequence[Path],
    beliefs: Mapping[str, Robot],
    start: Array,
    workers: int,
    progress: Callable[[str], None],
) -> list[Drawn]:
    """Each path on the simulated robot: uncorrected ("none"), and corrected by each belief, by name.

    Without dry friction, which the source does not state: what it does where a joint turns round is none of
    the errors that are corrected here.

    nominal: what the controller knows of the arm; start: (n,) joints near the first pose.
    """
    loads = stated_conditions(nominal)
    smooth = truth.loop.model_copy(update={"coulomb": 0.0})
    world = World(truth, nominal, loads, None, smooth)
    made = [
        {name: compensate(robot, path, loads, start=start) for name, robot in beliefs.items()}
        for path in paths
    ]
    commands = []
    for each in made:
        any_of_them = next(iter(each.values()))
        commands.append({"none": any_of_them.q_nominal} | {name: c.q_command for name, c in each.items()})
    wanted_poses = [next(iter(each.values())).X_desired for each in made]
    tasks = [
        Task(f"{name}, {path.title} of {path.time[-1] - path.time[0]:.1f} s", path, q, X)
        for path, each, X in zip(paths, commands, wanted_poses, strict=True)
        for name, q in each.items()
    ]
    done = iter(simulate_all(world, tasks, workers, progress))
    drawn = []
    for q, corrections in zip(commands, made, strict=True):
        outcomes = {name: next(done) for name in q}
        wanted = next(iter(corrections.values())).X_desired[:, :3, 3]
        error = {name: outcome.tool[:, :3, 3] - wanted for name, outcome in outcomes.items()}
        drawn.append(Drawn(wanted, outcomes["none"].time, q["none"], error))
    return drawn
