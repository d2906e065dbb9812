"""Where the loaded arm rests: every yielding slot has moved by its law under its own wrench,

motion = direct + law(wrench(motion)),        law = C · wrench, plus what effects add.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..files.faults import Fault, InputError
from .kinematics import Arm, Array, Frames, frames
from .loads import Loads, Wrenches, wrenches

Law = Callable[[Array], Array]

RUNAWAY = 100.0  # m or rad in a round: no arm goes so far and comes back
STILL = 1e-13  # m or rad in a round: at rest
STILL_MOVES = 1e-3  # m or rad in a round: a pose that has found no rest when another runs away


class NoRest(InputError, ArithmeticError):
    """The arm as stated does not come to rest under its loads as stated; which: what runs away, and where."""

    def __init__(self, which: str = "") -> None:
        what = "the loaded arm finds no rest: a stiffness is far too small for its load"
        what += f" ({which})" if which else ""
        super().__init__(Fault("robot", what, "check stiffness, masses, wrenches and effects"))


def equilibrium(
    arm: Arm,
    q: Array,
    direct: Array,
    loads: Loads,
    law: Law,
    near: Array | None = None,
    preconditioner: Law | None = None,
) -> tuple[Array, Frames, Wrenches]:
    """Loaded motions (N, S, 6), frames and wrenches.

    `direct`: (N, S, 6) motions that do not depend on load; `law` gives the motions (N, S, 6) under
    the local wrenches (N, S, 6). Fixed point; the load moves the wrenches by about 1e-3 of
    themselves, so each round gains three digits. An arm that is almost the same saves rounds: `near`, its
    motions, and `preconditioner`, which makes a Newton step of a round's change (N, S, 6). Raises
    NoRest when an arm is so soft that it does not come to rest.
    """
    motion, last = direct if near is None else near, np.inf
    for _ in range(60):
        where = frames(arm, q, motion)
        load = wrenches(arm, where, loads)
        change = direct + law(load.local) - motion
        step = float(np.abs(change).max(initial=0.0))
        if step < STILL or (step < 1e3 * STILL and step > 0.5 * last):  # as still as rounding allows
            return motion + change, where, load
        if not step < RUNAWAY:
            break
        last = step
        motion = motion + (change if preconditioner is None else preconditioner(change))
    raise NoRest(_runs_away(arm, change))


def _runs_away(arm: Arm, change: Array) -> str:
    """What moves most in the last round's change (N, S, 6), and in how many poses something moves still."""
    moved = np.nan_to_num(np.abs(change), nan=np.inf, posinf=np.inf).max(axis=2)
    name = arm.slot_names[int(moved.max(axis=0).argmax())]
    count = int(np.count_nonzero(moved.max(axis=1) > STILL_MOVES))
    where = f"in at least {count} pose{'s' * (count != 1)}" if count else "little, but without end"
    return f"{name} yields most; {where}"
