"""A joint's error as a free function of its own position: gear, screw, encoder or bearing, not told apart."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Param, motion_said
from .kinds import TransmissionEffect
from .place import Parameter, Where
from .unnamed.base import SLIDES, turn

LENGTHS = {"broad": 1.5, "smooth": 0.7, "waves": 0.25, "fine": 0.1}  # rad: the error forgets itself
USUAL = 1e-4  # rad, usual size of a gear's or an encoder's error
USUAL_SLIDING = 3e-5  # m, of a screw's or a rack's: ISO 3408-3 allows 23 µm (grade 5) … 52 µm (7) in 300 mm
MARGIN = 0.1  # share of the range that the functions go beyond it, where nothing is known
FAINTEST = 0.02  # share of the largest wave below which a wave is left out
MOVES = 0.2  # rad that a joint must travel for a function of it to be seen
TRAVEL = 1.0  # m, of a sliding joint without bounds, where nothing was measured


@dataclass(frozen=True)
class JointMap(TransmissionEffect):
    """Δq = Σ a_k cos(π k (q − q₀)/L), a Gaussian process with the length of `variant`, broad to fine.

    The waves' prior sizes are the square roots of the process' spectrum (Rasmussen & Williams 2006): a
    function of usual size `size` that forgets itself over `length` [rad]. The joint was measured from q₀
    `first` over L `span` [rad], without `room` at both ends; beyond that the map forgets what it says as the
    process does, over `length`: what nobody measured is no error in the mean, and as unsure as the map is
    large.

    Of a sliding joint it is the pitch error of a screw or a rack over the travel, all in m.
    """

    first: float = -np.pi
    span: float = 2 * np.pi
    length: float = 0.25
    size: float = USUAL
    sliding: bool = False
    room: float = 0.0

    cause: ClassVar[str] = "joint_map"
    title: ClassVar[str] = "A joint errs as a function of its own angle"
    called: ClassVar[str] = "transmission error over the range"
    as_rounded: ClassVar[bool] = True
    equation: ClassVar[str] = "Delta q = f(q)"
    settings: ClassVar[tuple[str, ...]] = ("first", "span", "length", "size", "room")
    smooth: ClassVar[bool] = True
    separate: ClassVar[dict[str, str]] = {
        "gear_kinematic_error": "sweep the joint in steps far below its shortest period",
        "gear_eccentricity": "sweep the joint over {range}",
        "gear_ratio": "sweep the joint over {range}",
        "joint_compliance": "the same poses with another payload: a map does not change",
        "gravity_compensator": "record the motor torque of the joint",
        "link_mass": "record the motor torque of the joint, or weigh the link",
        "hose_torque": "repeat some poses with the hose pack taken off, or record the motor torque",
    }

    @cached_property
    def _sizes(self) -> Array:
        """(p,) prior size of each wave, from k = 1: a constant is the joint's zero."""
        k = np.arange(1, 1 + int(np.ceil(3.0 * self.span / (np.pi * self.length))))
        power = np.exp(-0.5 * (np.pi * k * self.length / self.span) ** 2)
        power = power[power > FAINTEST**2 * power[0]]
        return np.asarray(self.size * np.sqrt(2 * power / power.sum()))

    @cached_property
    def params(self) -> tuple[Param, ...]:
        return tuple(
            Param(f"wave_{k}", self.unit, float(s), spread=float(s)) for k, s in enumerate(self._sizes, 1)
        )

    @property
    def unit(self) -> str:
        return "m" if self.sliding else "rad"

    @property
    def local(self) -> bool:
        return True

    @property
    def heading(self) -> str:
        return "A joint errs as a function of its own travel" if self.sliding else self.title

    @property
    def kin(self) -> Hashable:
        return "own angle", self.where.joint

    def sized(self, scale: float) -> JointMap:
        return replace(self, size=scale * self.size)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        return None if cls.sites(problem) else "no joint travels far enough"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[JointMap]:
        """Joints that travel, in lengths of less than half of that."""
        found = [cls.over(problem, j) for j in range(problem.arm.n)]
        every = [place._of_length(v) for place in found if place is not None for v in LENGTHS]
        return [one for one in every if 2 * one.length < one.span / (1 + 2 * MARGIN)]

    @classmethod
    def over(cls, problem: Problem, j: int) -> JointMap | None:
        """The smoothest map over what a joint travels; None where it hardly moves."""
        low, high = float(problem.q[:, j].min()), float(problem.q[:, j].max())
        if high - low < MOVES / turn(problem)[j]:
            return None
        room = MARGIN * (high - low)
        return replace(cls._at(problem, j), first=low - room, span=high - low + 2 * room, room=room)

    @classmethod
    def _at(cls, problem: Problem, j: int) -> JointMap:
        """The smoothest map of a joint, over a turn or all that it slides."""
        joint, where = problem.robot.joints[j], Where(joint=problem.arm.names[j])
        if not problem.arm.prismatic[j]:
            return cls(where)._of_length("smooth")
        low, high = joint.lower, joint.upper
        if not np.isfinite(high - low):
            low, high = -TRAVEL / 2, TRAVEL / 2
        return cls(where, "", low, high - low, size=USUAL_SLIDING, sliding=True)._of_length("smooth")

    def _of_length(self, variant: str) -> JointMap:
        """The same in another length: of a sliding joint as of one that turns by `SLIDES` per metre."""
        return replace(self, variant=variant, length=LENGTHS[variant] / (SLIDES if self.sliding else 1.0))

    @classmethod
    def off(cls, problem: Problem, j: int, size: float) -> Sequence[tuple[float, JointMap]]:
        """Companion of an effect of a joint's angle: how far [rad, m] a real one is off its form."""
        place = cls.over(problem, j)
        return [] if place is None else [(size / place.size, place)]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[JointMap]:
        return [cls._at(problem, j)._of_length(v) for j in range(problem.arm.n) for v in LENGTHS]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        x = (q[:, joints.index(str(self.where.joint))] - self.first) / self.span
        waves = np.cos(np.pi * np.outer(np.clip(x, 0.0, 1.0), np.arange(1, 1 + len(self._sizes))))
        return waves * self._kept(q, joints)[:, None]

    def beyond(self, q: Array, joints: tuple[str, ...]) -> Array:
        return self.size * np.sqrt(1 - self._kept(q, joints) ** 2)

    def _kept(self, q: Array, joints: tuple[str, ...]) -> Array:
        """(N,) how much the process still has of what was measured, where q (N, n) is beyond."""
        x = q[:, joints.index(str(self.where.joint))] - self.first
        beyond = x - np.clip(x, self.room, self.span - self.room)
        return np.asarray(np.exp(-0.5 * (beyond / self.length) ** 2))

    @property
    def names(self) -> tuple[str, ...]:
        return ("amplitude", *(p.name for p in self.params))

    def given(self, numbers: Mapping[str, float]) -> Array:
        if "amplitude" in numbers:  # any map of that RMS size: a single wave
            first = np.zeros(len(self._sizes))
            first[min(2, len(first) - 1)] = np.sqrt(2) * numbers["amplitude"]
            return first
        return super().given(numbers)

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        """RMS of the map over the range."""
        rms = float(np.sqrt((values**2).sum() / 2))
        std = float(np.sqrt(values @ covariance @ values) / (2 * rms)) if rms > 0 else 0.0
        return (Parameter("amplitude", rms, std, self.unit, "RMS of the map over the joint's range"),)

    def sentence(self, values: Array) -> str:
        rms = motion_said(np.sqrt((values**2).sum() / 2), self.sliding)
        ends = np.array([self.first, self.first + self.span])
        if self.sliding:
            low, high = 1e3 * ends
            return (
                f"{self.where.joint} errs by {rms} RMS as a function of its own travel "
                f"({low:.0f} … {high:.0f} mm): screw or rack, scale or guide."
            )
        low, high = np.degrees(ends)
        return (
            f"{self.where.joint} errs by {rms} RMS as a function of its own angle "
            f"({low:.0f} … {high:.0f}°): gear, encoder or bearing."
        )
