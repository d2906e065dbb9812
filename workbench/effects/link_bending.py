"""A link bends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.beam import bending_compliance
from ..robot.kinematics import RX, Arm, Array
from ..robot.rotations import skew
from .base import Depends, Effect, Param, Rest, Slopes, grouped
from .bearing_tilt import BearingTilt
from .drawn import Drawn
from .kinds import MOST_SHIFT, MOST_TURN, DirectEffect, LinearYield
from .place import Where
from .unnamed.link_ends import OfLink, OwnWeight, PivotForce, UnevenBending

UNEVEN = 0.3  # of the bending: a section that is twice as stiff in one direction
SHORTEST = 0.05  # m, shorter links are taken as rigid
ROOMS = 13  # places of a ram's guide to choose from
OUT = 0.8  # of the least length of a ram that stands out, how much of it the guide may still hold


@dataclass(frozen=True)
class LinkBending(LinearYield):
    """A cantilever from joint to joint under the force F and moment M at its end, over its length l:

    w = (F l³/3 + M l²/2)/EI,  turn = (F l²/2 + M l)/EI, both across the link.

    The parameter is 1/EI [1/(N·m²)], over the model's where the TOML states a bending stiffness. The
    link's own weight counts at its joints only; what it bends the link by itself, spread along it as nobody
    knows, is a companion. Liu et al., eqs. (15)–(20).

    A ram slides out of a guide that stays where it is (`variant` "ram"): its l grows with the travel.
    """

    nominal: float = 0.0

    cause: ClassVar[str] = "link_bending"
    title: ClassVar[str] = "A link bends"
    shifts: ClassVar[bool] = True
    load_name: ClassVar[str] = "bending load F l³/3 + M l²/2"
    load_unit: ClassVar[str] = "N·m³"
    equation: ClassVar[str] = "w = (F l^3 \\/ 3 + M l^2 \\/ 2) \\/ E I"
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "a target on the link near its joint, or loads in two directions",
        "bearing_tilt": "targets at both ends of the link",
        "gravity_compensator": "the motor torque of joint 2, or a target on the link near its joint",
        "foundation": "targets on the base casting",
        "payload": "weigh what the flange carries",
        "link_mass": "a target on the link near its joint, or weigh the link",
        "link_bending": "a target on each link near its joint",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "1/EI of the link, over the model's" if self.nominal else "1/EI of the link"
        return (Param("compliance", "1/(N·m²)", 2e-8, meaning, lower=-self.nominal),)

    @property
    def stated(self) -> bool:
        return self.nominal > 0

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[LinkBending]:
        """Moving links longer than 5 cm, and rams that stood out by different lengths."""
        return [*cls._links(problem), *(ram for ram in RamBending.of(problem) if ram.stands_out(problem))]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[LinkBending]:
        return [*cls._links(problem), *RamBending.of(problem)]

    @staticmethod
    def _links(problem: Problem) -> list[LinkBending]:
        arm, stated = problem.arm, problem.robot.bending_stiffness
        return [
            LinkBending(Where(link=arm.links[k]), nominal=1 / stated.get(arm.links[k], np.inf))
            for k in range(1, arm.n + 1)
            if np.linalg.norm(arm.span[k + 1]) > SHORTEST
        ]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real link gives way at its bearings as well, under its own weight, wherever that is, and under
        more or less of the compensator's force."""
        arm, slot = problem.arm, self.slot(problem.arm)
        ends = [name for k, name in enumerate(arm.names, start=1) if k in (slot - 1, slot)]
        tilts = [one for one in BearingTilt.even(problem) if one.where.joint in ends]
        every: list[OfLink] = [*OwnWeight.sites(problem), *PivotForce.sites(problem)]
        own = [one for one in every if one.where == self.where]
        return [*((0.3, one) for one in tilts), *((self._share(problem, one), one) for one in own)]

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """Some links do not bend alike in all directions."""
        uneven = [one for one in UnevenBending.sites(problem) if one.where == self.where]
        return [(UNEVEN * self.lever(problem.arm), one) for one in uneven]

    def _share(self, problem: Problem, own: OfLink) -> float:
        """What a link's own weight or the compensator bends it by, over the usual size of that, where the
        link is as soft as is usual; no more than what hangs on it does."""
        ends = np.linalg.norm(self.moved(problem)[:, :RX], axis=1)
        return own.largest / max(float(ends.max(initial=0.0)), own.largest)

    def slot(self, arm: Arm) -> int:
        return arm.slot_of_link(str(self.where.link)) + 1

    def moved(self, problem: Problem) -> Array:
        """(N, 6) [m, rad] shift and turn of the link's end at EI = 1 N·m², under the nominal loads."""
        arm = problem.arm
        return np.asarray(problem.nominal_load.local[:, self.slot(arm)] @ self.compliance(arm).T)

    def compliance(self, arm: Arm) -> Array:
        return bending_compliance(arm.span[self.slot(arm)])

    def lever(self, arm: Arm) -> float:
        """What its end moves by where the line from its root to it tilts by 1 rad [m]: the link's length."""
        return float(np.linalg.norm(arm.span[self.slot(arm)]))

    def sentence(self, values: Array) -> str:
        total = values[0] + self.nominal
        if total <= 0:
            return f"{self.where.link} does not bend."
        return f"{self.where.link} bends: its stiffness EI is {grouped(1 / total, 2)} N·m²."


@dataclass(frozen=True)
class RamBending(LinkBending):
    """A cantilever along a sliding joint's axis, from its guide to the link's end: of length l = q + what the
    link has beyond the joint's frame + `room` [m], as nobody knows where the guide ends. What lies beside
    the axis is rigid. It bends under the loads as the model states them.
    """

    variant: str = "ram"
    room: float = 0.0
    rooms: tuple[float, float] = field(default=(0.0, 0.0), compare=False, repr=False)  # m, least and most
    reach: float = field(default=1.0, compare=False, repr=False)  # m, of what stood out furthest

    settings: ClassVar[tuple[str, ...]] = ("room",)
    depends: ClassVar[Depends] = frozenset({"joints", "load"})
    in_drake: ClassVar[str] = DirectEffect.in_drake
    in_proportion: ClassVar[bool] = False  # its length has a part as well

    @classmethod
    def of(cls, problem: Problem) -> list[RamBending]:
        """Every link that slides."""
        arm = problem.arm
        rams = [cls(Where(link=arm.links[k])) for k in range(1, arm.n + 1) if arm.prismatic[k - 1]]
        return [ram._with_rooms(ram.out(problem)) for ram in rams]

    def _with_rooms(self, out: Array) -> RamBending:
        least = float(out[np.argmin(np.abs(out))])
        return replace(self, rooms=(-OUT * least, float(out.mean())), reach=float(np.abs(out).max()))

    def finer(self) -> Sequence[RamBending]:
        """The same ram out of longer and shorter guides."""
        return [replace(self, room=float(room)) for room in np.linspace(*self.rooms, ROOMS)]

    def out(self, problem: Problem) -> Array:
        """(N,) [m] what stands out of the guide, along the joint's axis."""
        slot = self.slot(problem.arm)
        return np.asarray(problem.q[:, slot - 2] + problem.arm.p[slot, 2] + self.room)

    def stands_out(self, problem: Problem) -> bool:
        """Whether it always stood out to the same side, by different lengths."""
        out = self.out(problem)
        return bool((out * np.sign(out[0]) > 0).all() and np.ptp(out) > SHORTEST)

    def moved(self, problem: Problem) -> Array:
        arm, slot, out = problem.arm, self.slot(problem.arm), self.out(problem)
        axis = arm.R[slot].T[:, 2]
        beside = np.eye(6)  # of a wrench at the end: what it is on the axis
        beside[RX:, :RX] = skew(arm.span[slot] - axis * (axis @ arm.span[slot]))
        lever = np.where(np.arange(6) < RX, out[:, None], 1.0)  # of a force and of a shift, not of a turn
        load = lever * (problem.nominal_load.local[:, slot] @ beside.T)
        moved = lever * (load @ bending_compliance(axis).T)
        return np.asarray((np.abs(out)[:, None] * moved) @ beside)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        first, moved = 6 * self.slot(problem.arm), self.moved(problem)
        return {first + k: moved[:, k : k + 1] for k in range(6)}

    def compliance(self, arm: Arm) -> Array:
        """None that is the same in all poses: `motion` has it."""
        return np.zeros((6, 6))

    def components(self, arm: Arm) -> tuple[int, ...]:
        C = bending_compliance(arm.R[self.slot(arm)].T[:, 2])
        return tuple(int(i) for i in np.flatnonzero(C.any(axis=0)))

    def jacobian(self, problem: Problem, line: Slopes, values: Array) -> Array:
        first = 6 * self.slot(problem.arm)
        return np.asarray(line.direct[:, :, first : first + 6] @ self.moved(problem)[:, :, None])

    def under(self, line: Slopes, wrench: Array, values: Array) -> None:
        return None

    def yields_to(self, line: Slopes, wrench: Array, values: Array) -> None:
        return None

    def prior(self, problem: Problem) -> Array:
        share = np.abs(self.moved(problem)) / np.repeat([MOST_SHIFT, MOST_TURN], 3)
        return np.array([min(1e3 * self.params[0].typical, 1 / max(float(share.max()), 1e-300), self.held)])

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        load = np.linalg.norm(self.moved(problem)[:, :RX], axis=1)
        what, place = f"{self.load_name} at {self.where}", f"deflection of {self.where}"
        return Drawn(load, what, self.load_unit, values[0] * load, place, "m")

    def lever(self, arm: Arm) -> float:
        return self.reach

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        return []

    def sentence(self, values: Array) -> str:
        stiffness = grouped(1 / values[0], 2)
        return f"{self.where.link} bends where it stands out: its stiffness EI is {stiffness} N·m²."
