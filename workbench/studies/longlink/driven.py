"""The compensated path driven: sampled controller, drives, springs, Drake's dynamics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from workbench import Array, Path, Robot, Task, World, simulate_all, stated_conditions

from .recursion import circle, commands, with_table_3, yielding

ROUNDS = 3  # not compensated, once, twice
SLOW, FAST = 20.0, 5.0  # s for the circle


def driven(
    assumed: Robot,
    share: float,
    durations: Sequence[float],
    workers: int = 1,
    say: Callable[[str], None] = lambda _: None,
) -> dict[float, Array]:
    """Duration [s] → (ROUNDS,) root mean square error [mm] of the tip of a robot of Table III that yields by
    `share` of what is assumed, in closed loop: uncompensated, after (26) once, twice, its compliance known.
    The controller knows the weights; no joint rubs when it turns round, which nobody states."""
    true, wanted = yielding(assumed, share), circle()
    bare = with_table_3(assumed)
    loads = stated_conditions(bare)
    world = World(true, bare, loads, None, true.loop.model_copy(update={"coulomb": 0.0}))
    X = np.tile(np.eye(4), (len(wanted), 1, 1))
    X[:, :3, 3] = wanted
    tasks = [
        Task(f"circle in {duration:.0f} s, (26) {k} ×", Path(np.linspace(0, duration, len(X)), X=X), q, X)
        for duration in durations
        for k, q in enumerate(commands(true, wanted)[:ROUNDS])
    ]
    errors = [
        1e3 * np.sqrt(((outcome.tool[:, :3, 3] - wanted) ** 2).sum(axis=1).mean())
        for outcome in simulate_all(world, tasks, workers, say)
    ]
    return dict(zip(durations, np.reshape(errors, (-1, ROUNDS)), strict=True))


def driven_numbers(found: Mapping[float, Array]) -> dict[str, float]:
    """Of the fastest: errors [mm] uncompensated and after (26) once, and the seconds that it takes."""
    seconds = min(found)
    none, once, _ = found[seconds]
    return {"fast_s": seconds, "driven_none_mm": float(none), "driven_once_mm": float(once)}
