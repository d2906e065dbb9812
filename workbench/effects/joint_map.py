"""A joint's error as a free function of its own position: gear, screw, encoder or bearing, not told apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Effect, Param, motion_said
from .guideway import Guideway
from .kinds import TransmissionEffect
from .place import Parameter, Where
from .travel import MOVES, OverTravel, measured, rms, whole
from .unnamed.base import SLIDES

LENGTHS = {"broad": 1.5, "smooth": 0.7, "waves": 0.25, "fine": 0.1, "jagged": 0.5}  # rad: it forgets itself
POSES_A_WAVE = 12  # joint positions for each wave of a jagged map: with few any scatter looks like it
TURNS = 2 * np.pi + MOVES  # rad that a joint travels: some angles were measured in two of its turns
ROUGH = 0.5  # rad: what forgets itself sooner has more waves in a turn than a run-out
USUAL_SLIDING = 3e-5  # m, of a screw's or a rack's: ISO 3408-3 allows 23 µm (grade 5) … 52 µm (7) in 300 mm


@dataclass(frozen=True)
class JointMap(OverTravel, TransmissionEffect):
    """Δq = f(q), a free function of the joint's own position: a Gaussian process (Rasmussen & Williams 2006)
    that forgets itself over the length of `variant`, broad to fine, or is "jagged": with large waves and ever
    smaller ones, as measured gears have them. What nobody measured is no error in the mean, and as unsure as
    the map is large. Of a joint that turns more than once it may be the same in every turn (`variant` "fine
    around", say): what is measured in one holds in the others.

    Of a sliding joint it is the pitch error of a screw or a rack over the travel, all in m. Its guide is a
    bearing that is as long as the travel: where that is not straight, the carriage strays with all six
    components of its motion (`variant` "guide"; ISO 230-1: straightness, roll, pitch, yaw).
    """

    sliding: bool = False

    cause: ClassVar[str] = "joint_map"
    title: ClassVar[str] = "A joint errs as a function of its own angle"
    called: ClassVar[str] = "error over the range"
    as_rounded: ClassVar[bool] = True
    equation: ClassVar[str] = "Delta q = f(q)"
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
    def params(self) -> tuple[Param, ...]:
        return tuple(
            Param(f"wave_{k}", self.unit, float(s), spread=float(s)) for k, s in enumerate(self.sizes, 1)
        )

    @property
    def jagged(self) -> bool:
        return self.variant.startswith("jagged")

    @property
    def unit(self) -> str:
        return "m" if self.sliding else "rad"

    @property
    def heading(self) -> str:
        return "A joint errs as a function of its own travel" if self.sliding else self.title

    def sized(self, scale: float) -> JointMap:
        return replace(self, size=scale * self.size)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        return None if cls.sites(problem) else "no joint travels far enough"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Effect]:
        """Joints that travel, in lengths of less than half of that, those that turn more than once around the
        turn as well; jagged ones where there are poses enough for their waves; and the guides of those that
        slide."""
        found = [cls.over(problem, j) for j in range(problem.arm.n)]
        every = [place._of_length(v) for place in found if place is not None for v in LENGTHS]
        maps = [one for one in every if 2 * one.length < one.travelled]
        around = [turn for one in maps if one.travelled > TURNS for turn in one._around()]
        most = int(problem.positions.max()) / POSES_A_WAVE
        told = [one for one in (*maps, *around) if not one.jagged or len(one.sizes) < most]
        return [*told, *Guideway.sites(problem)]

    def _around(self) -> list[JointMap]:
        """The same in every turn of a joint that turns; one of a few waves is a run-out with what it has
        beside it."""
        if self.sliding or self.length > ROUGH:
            return []
        return [replace(self, variant=f"{self.variant} around", around=1.0)]

    @classmethod
    def over(cls, problem: Problem, j: int) -> JointMap | None:
        """The smoothest map over what a joint travels; None where it hardly moves."""
        travelled = measured(problem, j)
        return None if travelled is None else cls._at(problem, j).over_range(travelled)

    @classmethod
    def _at(cls, problem: Problem, j: int) -> JointMap:
        """The smoothest map of a joint, over a turn or all that it slides."""
        one = cls(Where(joint=problem.arm.names[j]))
        if problem.arm.prismatic[j]:
            one = replace(one, size=USUAL_SLIDING, sliding=True)
        return one.over_range(whole(problem, j))._of_length("smooth")

    def _of_length(self, variant: str) -> JointMap:
        """The same in another length: of a sliding joint as of one that turns by `SLIDES` per metre."""
        return replace(self, variant=variant, length=LENGTHS[variant] / (SLIDES if self.sliding else 1.0))

    @classmethod
    def off(cls, problem: Problem, j: int, size: float) -> Sequence[tuple[float, JointMap]]:
        """Companion of an effect of a joint's angle: how far [rad, m] a real one is off its form."""
        place = cls.over(problem, j)
        return [] if place is None else [(size / place.size, place)]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Effect]:
        every = [cls._at(problem, j) for j in range(problem.arm.n)]
        maps = [one._of_length(v) for one in every for v in LENGTHS]
        around = [turn for one in maps for turn in one._around()]
        return [*maps, *around, *Guideway.places(problem)]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        return self.waves(q, joints)

    def beyond(self, q: Array, joints: tuple[str, ...]) -> Array:
        return self.size * self.forgotten(q, joints)

    @property
    def names(self) -> tuple[str, ...]:
        return ("amplitude", *(p.name for p in self.params))

    def given(self, numbers: Mapping[str, float]) -> Array:
        if "amplitude" in numbers:  # any map of that RMS size: a single wave
            first = np.zeros(len(self.sizes))
            first[min(2, len(first) - 1)] = np.sqrt(2) * numbers["amplitude"]
            return first
        return super().given(numbers)

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        """RMS of the map over the range."""
        size, std = rms(values, covariance)
        return (
            Parameter("amplitude", size, std, self.unit, "RMS of the map over the joint's range", least=0.0),
        )

    def sentence(self, values: Array) -> str:
        size = motion_said(np.sqrt((values**2).sum() / 2), self.sliding)
        if self.sliding:
            low, high = 1e3 * np.array(self.between)
            return (
                f"{self.where.joint} errs by {size} RMS as a function of its own travel "
                f"({low:.0f} … {high:.0f} mm): screw or rack, scale or guide."
            )
        low, high = np.degrees(self.between)
        over = f"{low:z.0f} … {high:z.0f}°".replace("-", "−")
        return (
            f"{self.where.joint} errs by {size} RMS as a function of its own angle ({over}"
            f"{', the same in every turn' if self.around else ''}): gear, encoder or bearing."
        )
