"""The guide of a sliding joint is not straight: a form of `joint_map`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import RX, Arm, Array
from .base import Depends, Param, Rest, motion_said
from .drawn import Drawn
from .kinds import GRID, DirectEffect
from .place import Parameter, Where
from .travel import Ends, OverTravel, measured, rms, whole

LENGTHS = {"slow guide": 0.25, "guide": 0.1}  # share of the travel over which it forgets itself
USUAL = 5e-5  # m, of straightness: makers of guides state 10 to 50 µm over some metres
TURN = 1.0  # rad per m: 50 µrad of roll, pitch and yaw with 50 µm of straightness
ALONG = 0.3  # of that: pitch and yaw about another place make it; a rack has causes of its own
SIZES = np.array([1.0, 1.0, ALONG, TURN, TURN, TURN])  # of its parts, over `size`
PARTS = ("across x", "across y", "along", "turn about x", "turn about y", "roll")
SAID = {"amplitude": (0, 1), "along": (2,), "tilt": (3, 4), "roll": (5,)}  # which parts, in one size
MEANING = {
    "amplitude": "RMS of the carriage's straying across its guide",
    "along": "RMS of what it strays along its guide",
    "tilt": "RMS of its turn across the guide (pitch and yaw)",
    "roll": "RMS of its turn about the guide",
}


@dataclass(frozen=True)
class Guideway(OverTravel, DirectEffect):
    """The carriage of a sliding joint strays with all six components of its motion (ISO 230-1: straightness,
    positioning, roll, pitch and yaw), each a free function of the travel. It turns about where the next
    joint sits on it, on the joint's own axes (z along the travel). size: of the shifts across [m], of
    the other parts as `SIZES` has them."""

    variant: str = "guide"

    cause: ClassVar[str] = "joint_map"
    title: ClassVar[str] = "A joint's guide is not straight"
    called: ClassVar[str] = "guide error"
    equation: ClassVar[str] = "xi = f(q)"
    depends: ClassVar[Depends] = frozenset({"joints"})
    separate: ClassVar[dict[str, str]] = {}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Guideway]:
        """Sliding joints that travel."""
        return [guide for j in cls._slides(problem) for guide in cls._over(problem, j, measured(problem, j))]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Guideway]:
        return [guide for j in cls._slides(problem) for guide in cls._over(problem, j, whole(problem, j))]

    @staticmethod
    def _slides(problem: Problem) -> list[int]:
        return np.flatnonzero(problem.arm.prismatic).tolist()

    @classmethod
    def _over(cls, problem: Problem, j: int, ends: Ends | None) -> list[Guideway]:
        if ends is None:
            return []
        one = cls(Where(joint=problem.arm.names[j]), size=USUAL).over_range(ends)
        return [replace(one, variant=name, length=share * one.travelled) for name, share in LENGTHS.items()]

    @cached_property
    def params(self) -> tuple[Param, ...]:
        return tuple(
            Param(f"{part.replace(' ', '_')}_{k}", unit, factor * float(s), spread=factor * float(s))
            for i, part in enumerate(PARTS)
            for unit, factor in [("m" if i < RX else "rad", float(SIZES[i]))]
            for k, s in enumerate(self.sizes, 1)
        )

    @property
    def heading(self) -> str:
        return self.title

    def sized(self, scale: float) -> Guideway:
        return replace(self, size=scale * self.size)

    def slot(self, arm: Arm) -> int:
        """The next one, which the carriage carries along."""
        return arm.slot_of_joint(str(self.where.joint)) + 1

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        arm, slot = problem.arm, self.slot(problem.arm)
        parts = np.kron(np.eye(6), self.waves(problem.q, arm.names)[:, None, :])  # (N, 6, 6 K): a block each
        axes = np.kron(np.eye(2), arm.R[slot].T)  # the carriage's axes on those of the slot
        moved = np.einsum("ij,njk->ink", axes, parts)
        return {6 * slot + i: moved[i] for i in range(6)}

    def ends(self, problem: Problem) -> Mapping[int, Array]:
        first, arm = 6 * self.slot(problem.arm), problem.arm
        size = self.size * self.forgotten(problem.q, arm.names)
        return {
            first + i: size if i < RX else TURN * size for i in range(6)
        }  # whichever way the slot is turned

    def parts(self, values: Array) -> Array:
        """(6, K) of the values (6 K,)."""
        return np.asarray(values.reshape(6, -1))

    @property
    def names(self) -> tuple[str, ...]:
        return (*SAID, *(p.name for p in self.params))

    def given(self, numbers: Mapping[str, float]) -> Array:
        out = self.parts(super().given(numbers))
        for name in SAID.keys() & numbers.keys():  # any of that RMS size: a single wave
            out[SAID[name][0], min(2, out.shape[1] - 1)] += np.sqrt(2) * numbers[name]
        return out.ravel()

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        K = len(self.sizes)
        out = []
        for name, parts in SAID.items():
            own = np.concatenate([np.arange(K * i, K * i + K) for i in parts])
            size, std = rms(values[own], covariance[np.ix_(own, own)])
            out.append(Parameter(name, size, std, "m" if parts[0] < RX else "rad", MEANING[name], least=0.0))
        return tuple(out)

    def sentence(self, values: Array) -> str:
        sizes = {p.name: p.value for p in self.report(values, np.zeros((len(values), len(values))))}
        low, high = 1e3 * np.array(self.between)
        return (
            f"The carriage of {self.where.joint} strays along its travel ({low:.0f} … {high:.0f} mm): "
            f"{motion_said(sizes['amplitude'], True)} RMS across, {motion_said(sizes['along'], True)} along, "
            f"{motion_said(sizes['roll'])} of roll, {motion_said(sizes['tilt'])} of pitch and yaw. "
            "Its guide is not straight."
        )

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Of its six parts the one that moves the tool most, over the travel."""
        joints, j = problem.arm.names, problem.joint(self.where.joint)
        parts = self.parts(values)
        sizes = np.sqrt((parts**2).sum(axis=1))
        reach = np.linalg.norm(rest.where.p[-1] - rest.where.p[j + 1], axis=1).mean()
        i = int(np.argmax(np.where(np.arange(6) < RX, 1.0, reach) * sizes))
        sweep = np.tile(problem.q.mean(axis=0), (GRID, 1))
        sweep[:, j] = np.linspace(problem.q[:, j].min(), problem.q[:, j].max(), GRID)
        size, curve = (self.waves(q, joints) @ parts[i] for q in (problem.q, sweep))
        name, unit = f"{self.where.joint}'s carriage: {PARTS[i]}", "m" if i < RX else "rad"
        return Drawn(1e3 * problem.q[:, j], joints[j], "mm", size, name, unit, (1e3 * sweep[:, j], curve))
