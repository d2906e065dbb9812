"""The extended robot along a path: what its tool does at given joints, a few thousand samples at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import DirectEffect, Effect, InstrumentEffect, LoadEffect, YieldEffect
from ..effects.records import from_record
from ..robot.kinematics import Arm, Array, Frames, frames
from ..robot.loads import Loads, Wrenches, wrenches

PART = 1000  # samples at a time: the arrays of one part stay in the cache
FEW = 32  # samples that are looked at to see what an effect hangs on
PROBES = {"temperature": (20.0, 30.0), "time": (0.0, 1e12), "direction": (-1.0, 1.0)}

Select = slice | NDArray[np.int64]
Shares = Mapping[int, Array]
NOTHING: Shares = {}
NUDGE = 1e-6  # rad, for slopes


def parts(count: int) -> Iterator[slice]:
    """The samples in parts."""
    for start in range(0, count, PART):
        yield slice(start, min(start + PART, count))


@dataclass(frozen=True, eq=False)
class ExtendedArm:
    """The robot with its corrections and effects, on a path's samples.

    whole: the path as a problem (loads, time, temperature; its joints and directions are replaced);
    effects: those that act on a tool, each with its values. notes: what is left out for want of data.
    """

    whole: Problem
    effects: tuple[tuple[Effect, Array], ...]
    notes: tuple[str, ...] = ()

    @property
    def arm(self) -> Arm:
        return self.whole.arm

    def at(self, q: Array, direction: Array | None, part: Select) -> Problem:
        """The problem of some samples: joints q (K, n) and sides of approach (K, n)."""
        c = self.whole.campaign
        campaign = replace(
            c,
            q=q,
            direction=direction,
            pose_ids=("",) * len(q),
            payload=c.payload[part],
            wrench=c.wrench[part],
            time=None if c.time is None else c.time[part],
            temperature=None if c.temperature is None else c.temperature[part],
            setup=c.setup[part],
            points=c.points[part],
            shots=c.shots[part],
        )
        return replace(self.whole, campaign=campaign)

    def direct(self, problem: Problem, shares: Shares = NOTHING) -> Array:
        """(K, S, 6) motions that do not depend on load; `shares` (K,) of some effects, by their number."""
        out = np.zeros((len(problem.q), 6 * self.arm.slots))
        for i, (effect, values) in enumerate(self.effects):
            if isinstance(effect, DirectEffect):
                for column, basis in effect.motion(problem).items():
                    out[:, column] += shares.get(i, 1.0) * (basis @ values)
        return out.reshape(len(out), -1, 6)

    def gear_slope(self, problem: Problem, shares: Shares) -> Array:
        """(K, n) further motion of each joint per commanded motion, of the effects with an order."""
        slope = np.zeros(problem.q.shape)
        for i, (effect, values) in enumerate(self.effects):
            if effect.where.order is not None and isinstance(effect, DirectEffect):
                ahead = replace(problem, campaign=replace(problem.campaign, q=problem.q + NUDGE))
                column = int(self.arm.axial[problem.joint(effect.where.joint)])
                change = (effect.motion(ahead)[column] - effect.motion(problem)[column]) @ values
                slope[:, problem.joint(effect.where.joint)] += shares.get(i, 1.0) * change / NUDGE
        return slope

    def loads(self, problem: Problem) -> tuple[Arm, Loads]:
        """Arm and loads with the effects that change what pulls."""
        arm, loads = self.arm, problem.loads
        for effect, values in self.effects:
            if isinstance(effect, LoadEffect):
                arm, loads = effect.apply(problem, arm, loads, values)
        return arm, loads

    def sag(self, arm: Arm, local: Array) -> Array:
        """(K, S, 6) motions under the slots' wrenches (K, S, 6)."""
        n_samples = len(local)
        out = np.empty_like(local)
        for k in range(arm.slots):
            out[:, k] = local[:, k] @ arm.compliance[k].T
        for effect, values in self.effects:
            if isinstance(effect, YieldEffect):
                k = effect.slot(arm)
                out[:, k] += effect.law(arm, local[:, k], values)[0]
        return out.reshape(n_samples, -1, 6)

    def move(self, problem: Problem, sag: Array, shares: Shares = NOTHING) -> tuple[Frames, Array]:
        """Frames under a sag (K, S, 6), and the sag that these frames' wrenches make."""
        arm, loads = self.loads(problem)
        where = frames(arm, problem.q, self.direct(problem, shares) + sag)
        return where, self.sag(arm, wrenches(arm, where, loads).local)

    def wrenches(self, problem: Problem, where: Frames) -> Wrenches:
        """Wrenches at given frames."""
        arm, loads = self.loads(problem)
        return wrenches(arm, where, loads)


def extended_arm(problem: Problem) -> ExtendedArm:
    """The robot's own corrections and effects on a path (as a problem).

    Effects of the instrument and of payloads that are not carried do nothing here; those that hang on
    something that is not given for the path are named in the notes. Raises `InputError` for a model that
    is not this robot's.
    """
    few = _few(problem)
    acting, notes = [], []
    for item in problem.robot.effects:
        kind = catalogue().get(item.cause, Effect)
        if issubclass(kind, InstrumentEffect) or item.payload not in (None, *few.campaign.payload_names):
            continue
        if kind is not Effect and not kind.places(few):
            notes.append(f"{item.cause} is left out: {kind.needs(few) or 'it has no place on this path'}")
            continue
        effect, values = from_record(item, few, f"{problem.robot.path}: effects.{item.cause}")
        acting.append((effect, values))
        for what, lacking in (("temperature", "the arm is taken as at 20 °C"), ("time", "it is left out")):
            if getattr(problem.campaign, what) is None and _depends(effect, values, few, what):
                notes.append(f"{effect.label} needs the {what} of the path: {lacking}")
    return ExtendedArm(problem, tuple(acting), tuple(notes))


def _few(problem: Problem) -> Problem:
    """Some samples of a path: enough to see what an effect hangs on."""
    some = np.unique(np.linspace(0, len(problem.q) - 1, FEW).astype(np.int64))
    return ExtendedArm(problem, ()).at(problem.q[some], None, some)


def sided(arm: ExtendedArm) -> bool:
    """Whether any effect depends on the side of approach."""
    few = _few(arm.whole)
    return any(_depends(effect, values, few, "direction") for effect, values in arm.effects)


def _depends(effect: Effect, values: Array, few: Problem, what: str) -> bool:
    """Whether an effect changes with `what`: it is tried at two values."""
    probe = ExtendedArm(few, ((effect, values),))
    shape = few.q.shape if what == "direction" else (len(few.q),)
    tried = []
    for value in PROBES[what]:
        here = replace(few, campaign=replace(few.campaign, **{what: np.full(shape, value)}))  # type: ignore[arg-type]
        tried.append(
            np.concatenate([probe.direct(here).ravel(), probe.wrenches(here, few.rigid).local.ravel()])
        )
    return not np.array_equal(tried[0], tried[1])
