"""Errors by the load on a joint: the stated robot's, so that they do not depend on what else is fitted. A
function of the fitted load, with masses fitted beside it, makes a product of two unknown numbers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import RX, RZ, TX, Arm, Array, Frames
from ...robot.loads import Loads, wrenches
from ...robot.rotations import cross
from ..base import Depends, Param, motion_said, short
from ..kinds import DirectEffect, LoadEffect
from ..masses import usually_mounted
from ..place import Where
from .base import Unnamed, each

LEAST = 1e-3  # N·m: what bears no more turns nothing
LEVELS = 1e-3  # of a lever: a joint as upright as that bears no weight
SHIFT = 0.3  # m: a shift's usual size is that of a turn at this distance
FOOT = 1.5  # m: with what is uneven a third of the tilt, a base half a metre above where it turns is usual


@dataclass(frozen=True)
class Torque(Unnamed, DirectEffect):
    """A joint's error by its torque, even: what is odd in it is a compliance. largest [N·m, N]: torque of
    the campaign."""

    variant: str = "torque"
    largest: float = 1.0

    depends: ClassVar[Depends] = frozenset({"load"})
    by_loads: ClassVar[bool] = True
    settings: ClassVar[tuple[str, ...]] = ("size", "largest")
    functions: ClassVar[int] = 2
    unit: ClassVar[str] = "N·m"

    @property
    def variable(self) -> str:
        return f"torque of {self.where.joint}"

    def x(self, problem: Problem) -> Array:
        return _own_load(problem, problem.joint(self.where.joint))

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x = self.x(problem) / self.largest
        column = int(problem.arm.axial[problem.joint(self.where.joint)])
        return {column: np.column_stack([x**2, np.abs(x)])}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Torque]:
        out = []
        for j, name in enumerate(problem.arm.names):
            load = _own_load(problem, j)
            most = float(np.abs(load).max(initial=0.0))
            if np.ptp(load) > 1e-3 * max(most, 1.0):
                out.append(cls(Where(joint=name), largest=most))
        return out


@dataclass(frozen=True)
class Load(Unnamed, DirectEffect):
    """A joint's frame shifts and turns with every force and moment on it. force [N], moment [N·m]: the
    largest of the campaign."""

    variant: str = "load"
    size: float = 5e-5
    force: float = 1.0
    moment: float = 1.0

    depends: ClassVar[Depends] = frozenset({"load"})
    by_loads: ClassVar[bool] = True
    settings: ClassVar[tuple[str, ...]] = ("size", "force", "moment")
    functions: ClassVar[int] = 36
    unit: ClassVar[str] = "N·m"

    @property
    def variable(self) -> str:
        return f"load on {self.where.joint}"

    def x(self, problem: Problem) -> Array:
        return np.asarray(np.linalg.norm(self.wrench(problem)[:, RX:], axis=1))

    def wrench(self, problem: Problem) -> Array:
        return np.asarray(problem.nominal_load.local[:, problem.joint(self.where.joint) + 1])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        first = 6 * (problem.joint(self.where.joint) + 1)
        out = each(range(first, first + 6), self.wrench(problem) / ([self.force] * 3 + [self.moment] * 3))
        return {column: basis * (SHIFT if column < first + RX else 1.0) for column, basis in out.items()}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        out = []
        for j, name in enumerate(problem.arm.names):
            load = np.abs(problem.nominal_load.local[:, j + 1]).max(axis=0, initial=0.0)
            force, moment = float(load[:RX].max()), float(load[RX:].max())
            if min(force, moment) > 1e-3:
                out.append(cls(Where(joint=name), force=force, moment=moment))
        return out


def _own_load(problem: Problem, j: int) -> Array:
    """(N,) torque or force of a joint of the stated robot."""
    load = problem.nominal_load.local
    return np.asarray(load.reshape(len(load), -1)[:, problem.arm.axial[j]])


@dataclass(frozen=True)
class Weights(Unnamed, DirectEffect):
    """What a joint gives under weights beyond it that the model lacks: its torque is linear in their first
    moments, whatever these are (Atkeson et al. 1986)."""

    depends: ClassVar[Depends] = frozenset({"joints"})
    by_loads: ClassVar[bool] = True
    unit: ClassVar[str] = "m"

    def x(self, problem: Problem) -> Array:
        """(N,) [m] lever of a weight at the flange."""
        j, where = problem.joint(self.where.joint), problem.rigid
        lever = cross(where.p[-1] - where.origin[:, j + 1], _down(problem.arm))
        return np.asarray((lever * where.axes[:, j + 1, RZ]).sum(axis=1))

    def moved_by(self, problem: Problem, slot: int) -> Array:
        """(N, 3) the joint's torque by a first moment in the frame behind a slot, over its weight."""
        j, where = problem.joint(self.where.joint), problem.rigid
        across = cross(_down(problem.arm), where.axes[:, j + 1, RZ])
        return np.asarray(np.einsum("ni,nij->nj", across, where.R[slot]))

    @classmethod
    def turned(cls, problem: Problem, every: Iterable[Self]) -> list[Self]:
        """Those whose joint weights can turn."""
        return [one for one in every if any(np.ptp(b) > LEVELS for b in one.motion(problem).values())]


@dataclass(frozen=True)
class OwnWeights(Weights):
    """Weights of the links, of an arm whose model has none. links: so many lie beyond."""

    variant: str = "own weights"
    links: int = 1

    always: ClassVar[bool] = True
    lacks: ClassVar[str] = "state the links' masses in the URDF"
    settings: ClassVar[tuple[str, ...]] = ("size", "links")

    @property
    def functions(self) -> int:
        return 3 * int(self.links)

    @property
    def variable(self) -> str:
        return f"weights beyond {self.where.joint}, which the model lacks"

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        j, arm = problem.joint(self.where.joint), problem.arm
        basis = [self.moved_by(problem, k) / (k - j) for k in range(j + 1, arm.n + 1)]  # smaller outwards
        return {int(arm.axial[j]): np.concatenate(basis, axis=1)}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[OwnWeights]:
        """Turning joints that weights can turn, of an arm whose links have none."""
        arm = problem.arm
        if arm.weighed or not arm.gravity.any():
            return []
        turning = [j for j in range(arm.n) if not arm.prismatic[j]]
        return cls.turned(problem, [cls(Where(joint=arm.names[j]), links=arm.n - j) for j in turning])


@dataclass(frozen=True)
class ToolsWeight(Weights):
    """The weight of a tool that nobody stated, on a joint of the wrist. furthest [m]: its largest lever, were
    it at the flange.

    Without a stiffness and a load both numbers of a product are nothing to begin with, and neither shows
    alone."""

    variant: str = "tool's weight"
    furthest: float = 1.0

    lacks: ClassVar[str] = "state the tool's mass and centre of mass (`[tool]` in campaign.toml)"
    settings: ClassVar[tuple[str, ...]] = ("size", "furthest")
    functions: ClassVar[int] = 4

    @property
    def variable(self) -> str:
        return f"the weight of a tool that nobody stated, on {self.where.joint}"

    @property
    def like(self) -> str:
        return "a wrist that yields under a tool that nobody stated"

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        lever = self.x(problem)[:, None] / self.furthest
        basis = np.concatenate([lever, self.moved_by(problem, -1)], axis=1)
        return {int(problem.arm.axial[problem.joint(self.where.joint)]): basis}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[ToolsWeight]:
        """Turning joints without a stiffness that bear less of the stated arm than of what is usually
        mounted, where nobody stated that, and some poses are without a payload."""
        arm, c = problem.arm, problem.campaign
        alone = c.load_mass[c.poses.payload] == 0.0
        if not arm.weighed or not arm.gravity.any() or c.tool_mass > 0 or not alone.any():
            return []
        mounted = usually_mounted(problem) * float(np.linalg.norm(arm.gravity))
        out = []
        for j, joint in enumerate(problem.robot.joints):
            one = cls(Where(joint=joint.name))
            furthest = max(float(np.abs(one.x(problem)).max(initial=0.0)), LEVELS)
            borne = float(np.abs(_own_load(problem, j)[alone]).max())
            if not arm.prismatic[j] and not joint.data.stiffness and borne < mounted * furthest:
                out.append(replace(one, furthest=furthest))
        return cls.turned(problem, out)


def _down(arm: Arm) -> Array:
    """(3,) the direction of gravity."""
    return np.asarray(arm.gravity / np.linalg.norm(arm.gravity))


@dataclass(frozen=True)
class Uneven(Unnamed, DirectEffect):
    """What yields to a moment, but not alike in all directions. largest [N·m]: moment of the campaign."""

    size: float = 5e-5
    largest: float = 1.0

    depends: ClassVar[Depends] = frozenset({"load"})
    by_loads: ClassVar[bool] = True
    settings: ClassVar[tuple[str, ...]] = ("size", "largest")
    unit: ClassVar[str] = "N·m"

    def x(self, problem: Problem) -> Array:
        return np.asarray(np.linalg.norm(self.moment(problem), axis=1))

    @abstractmethod
    def moment(self, problem: Problem) -> Array:
        """(N, ·) [N·m] the moment's components."""

    @classmethod
    def bearing(cls, problem: Problem, places: Iterable[Where]) -> list[Self]:
        """At those places that bear a moment."""
        every = [cls(where) for where in places]
        most = [float(one.x(problem).max(initial=0.0)) for one in every]
        return [replace(one, largest=m) for one, m in zip(every, most, strict=True) if m > LEAST]


@dataclass(frozen=True)
class UnevenTilt(Uneven):
    """What tilts under moment, a base or a joint's bearing, does not do so alike in all directions, nor
    evenly: softer about one axis across than about the other, whichever these are, and softer or stiffer
    under a large moment. A base does not turn about its own origin either, but about the foot of a pedestal.
    The moment is the overturning one."""

    variant: str = "uneven tilt"

    @property
    def of_base(self) -> bool:
        return self.where.joint is None

    @property
    def functions(self) -> int:
        return 4 if self.of_base else 3

    @property
    def variable(self) -> str:
        return "overturning moment" if self.of_base else f"overturning moment on {self.where.joint}"

    def moment(self, problem: Problem) -> Array:
        """(N, 2) [N·m] overturning moment, about both axes across."""
        return np.asarray(problem.nominal_load.local[:, self.slot(problem), RX : RX + 2])

    def slot(self, problem: Problem) -> int:
        return 0 if self.where.joint is None else problem.joint(self.where.joint) + 1

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x, y = self.moment(problem).T / self.largest
        size, first = np.hypot(x, y), 6 * self.slot(problem)
        tilt = {first + RX: [x, y, size * x], first + RX + 1: [-y, x, size * y]}
        if not self.of_base:
            return {column: np.column_stack(basis) for column, basis in tilt.items()}
        none = np.zeros_like(x)
        out = {column: np.column_stack([*basis, none]) for column, basis in tilt.items()}
        foot = {TX: FOOT * y, TX + 1: -FOOT * x}
        return out | {column: np.column_stack([none, none, none, way]) for column, way in foot.items()}

    def sentence(self, values: Array) -> str:
        per_kNm = values / self.largest * 1e9  # µrad, µrad, µrad, FOOT µm
        size, softest = np.hypot(*per_kNm[:2]), np.degrees(np.arctan2(per_kNm[1], per_kNm[0])) / 2 % 180
        frame = "the base's" if self.of_base else f"{self.where.joint}'s"
        said = (
            f"It is not alike in all directions: {short(size)} µrad per kN·m more about the axis at "
            f"{softest:.0f}° to {frame} x, as much less across it"
        )
        if not self.of_base:
            return f"{said}."
        return (
            f"{said}; and the base's origin moves by {short(abs(per_kNm[3]) * FOOT)} µm per kN·m, as where "
            "it turns about a foot."
        )

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[UnevenTilt]:
        """The base and the joints, where there is a moment on them."""
        return cls.bearing(problem, [Where(), *(Where(joint=name) for name in problem.arm.names)])


@dataclass(frozen=True)
class TippingTilt(Uneven):
    """A bearing with play does not tip as far about one axis across as about the other, nor about that of the
    moment alone. The moment is the overturning one; from `most` of its largest on nothing tips any more."""

    variant: str = "tipping tilt"
    most: float = 0.1

    functions: ClassVar[int] = 4
    settings: ClassVar[tuple[str, ...]] = (*Uneven.settings, "most")

    @property
    def variable(self) -> str:
        return f"the side of the overturning moment on {self.where.joint}"

    def moment(self, problem: Problem) -> Array:
        """(N, 2) [N·m] overturning moment, about both axes across."""
        return np.asarray(problem.nominal_load.local[:, problem.joint(self.where.joint) + 1, RX : RX + 2])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        first = 6 * (problem.joint(self.where.joint) + 1) + RX
        tipped = np.tanh(self.moment(problem) / (self.most * self.largest))
        return each((first, first + 1), tipped)

    def sentence(self, values: Array) -> str:
        most = motion_said(float(np.linalg.norm(values.reshape(2, 2), 2)))
        return f"It does not tip alike about all axes: by up to {most} more or less."

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[TippingTilt]:
        """The joints, where there is a moment on them."""
        return cls.bearing(problem, [Where(joint=name) for name in problem.arm.names])


@dataclass(frozen=True)
class StatedForces(Unnamed, LoadEffect):
    """What pulls at the arm from outside is all larger, or smaller, than stated, as by a load cell that is
    off or a pulley that holds back. size: the share of it, one sigma, that a calibrated cell is off.

    It looks as if all joints were softer alike, and so competes with nothing: it makes their numbers less
    sure."""

    variant: str = "stated forces"
    size: float = 0.02

    depends: ClassVar[Depends] = frozenset({"load"})
    functions: ClassVar[int] = 1
    variable: ClassVar[str] = "the external forces, as far as all are off"

    @property
    def params(self) -> tuple[Param, ...]:
        return (
            Param("scale", "1", self.size, "external forces over the stated, minus one", spread=self.size),
        )

    def x(self, problem: Problem) -> Array:
        return np.asarray(np.linalg.norm(problem.campaign.poses.wrench[:, :RX], axis=1))

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        return arm, replace(loads, wrench=loads.wrench + values[0] * problem.campaign.poses.wrench)

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        stated, none = problem.campaign.poses.wrench, np.zeros(len(problem.q))
        alone = Loads(none, np.zeros((len(none), 3)), stated, np.zeros((len(none), problem.arm.n)))
        weightless = replace(problem.arm, gravity=np.zeros(3))
        return wrenches(weightless, where, alone).local[..., None]

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[StatedForces]:
        return [cls()] if problem.campaign.poses.wrench.any() else []
