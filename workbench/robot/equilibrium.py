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


class NoRest(InputError, ArithmeticError):
    """The arm as stated does not come to rest under its loads as stated."""

    def __init__(self) -> None:
        what = "the loaded arm finds no rest: a stiffness is far too small for its load"
        super().__init__(Fault("robot", what, "check stiffness, masses, wrenches and effects"))


def equilibrium(
    arm: Arm,
    q: Array,
    direct: Array,
    loads: Loads,
    law: Law,
    tolerance: float = 1e-13,
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
        if step < tolerance or (step < 1e3 * tolerance and step > 0.5 * last):  # as still as rounding allows
            return motion + change, where, load
        if not step < RUNAWAY:
            break
        last = step
        motion = motion + (change if preconditioner is None else preconditioner(change))
    raise NoRest
