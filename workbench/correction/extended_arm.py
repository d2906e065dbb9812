"""The extended robot along a path: what its tool does at given joints, a few thousand samples at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.acting import WHOLE, Acting, Shares
from ..effects.records import from_record, is_mounted
from ..robot.kinematics import Arm, Array, Frames, frames
from ..robot.loads import Loads, Wrenches, wrenches

PART = 1000  # samples at a time: the arrays of one part stay in the cache
FEW = 32  # samples that are enough to place an effect
LACKING = {"temperature": "the arm is taken as at 20 °C", "time": "it is left out"}

Select = slice | NDArray[np.int64]


def parts(count: int) -> Iterator[slice]:
    """The samples in parts."""
    for start in range(0, count, PART):
        yield slice(start, min(start + PART, count))


@dataclass(frozen=True, eq=False)
class ExtendedArm:
    """The robot with its corrections and effects, on a path's samples.

    problem: of the whole path (loads, time, temperature; its joints and directions are replaced);
    acting: the effects that act on a tool. notes: what is left out for want of data.
    """

    problem: Problem
    acting: Acting = Acting()  # noqa: RUF009
    notes: tuple[str, ...] = ()

    @property
    def arm(self) -> Arm:
        return self.problem.arm

    def at(self, q: Array, direction: Array | None, part: Select) -> Problem:
        """The problem of some samples: joints q (K, n) and sides of approach (K, n)."""
        c = self.problem.campaign
        campaign = replace(
            c.with_poses(
                q=q,
                side=direction,
                ids=("",) * len(q),
                payload=c.poses.payload[part],
                wrench=c.poses.wrench[part],
                time=None if c.poses.time is None else c.poses.time[part],
                temperature=None if c.poses.temperature is None else c.poses.temperature[part],
                setup=c.poses.setup[part],
            ),
            points=c.points[part],
            shots=c.shots[part],
        )
        return replace(self.problem, campaign=campaign)

    def direct(self, problem: Problem, shares: Shares = WHOLE) -> Array:
        """(K, S, 6) motions that do not depend on load; `shares` (K,) of some effects, by their number."""
        return self.acting.direct(problem, shares)

    def loads(self, problem: Problem) -> tuple[Arm, Loads]:
        """Arm and loads with the effects that change what pulls."""
        return self.acting.loads(problem, self.arm)

    def move(self, problem: Problem, sag: Array, shares: Shares) -> tuple[Frames, Array]:
        """Frames under a sag (K, S, 6), and the sag that these frames' wrenches make."""
        arm, loads = self.loads(problem)
        where = frames(arm, problem.q, self.direct(problem, shares) + sag)
        return where, self.acting.yielding(arm).motion(wrenches(arm, where, loads).local)

    def wrenches(self, problem: Problem, where: Frames) -> Wrenches:
        """Wrenches at given frames."""
        arm, loads = self.loads(problem)
        return wrenches(arm, where, loads)

    @property
    def sided(self) -> bool:
        """Whether any effect depends on the side of approach."""
        return "side" in self.acting.uses


def extended_arm(problem: Problem) -> ExtendedArm:
    """The robot's own corrections and effects on a path (as a problem).

    Effects of the instrument and of loads that are not carried do nothing here; those that hang on
    something that is not given for the path are named in the notes. Raises `InputError` for a model that
    is not this robot's.
    """
    thinned = _thinned(problem)
    acting, notes = [], []
    for item in problem.robot.effects:
        kind = catalogue().get(item.cause)
        seen_only = kind is not None and kind.acts == "instrument"
        if seen_only or not is_mounted(item, thinned):
            continue
        if kind is not None and not kind.places(thinned):
            notes.append(f"{item.cause} is left out: {kind.needs(thinned) or 'it has no place on this path'}")
            continue
        effect, values = from_record(item, thinned, f"{problem.robot.path}: effects.{item.cause}")
        acting.append((effect, values))
        for what, lacking in LACKING.items():
            if getattr(problem.campaign.poses, what) is None and what in effect.uses:
                notes.append(f"{effect.label} needs the {what} of the path: {lacking}")
    return ExtendedArm(problem, Acting(tuple(acting)), tuple(notes))


def _thinned(problem: Problem) -> Problem:
    """Some samples of a path: enough to place the effects."""
    some = np.unique(np.linspace(0, len(problem.q) - 1, FEW).astype(np.int64))
    return ExtendedArm(problem).at(problem.q[some], None, some)
