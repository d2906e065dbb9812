"""How the instrument errs: by where it looks, and by what it looks at.

What a tracker's axes, encoders and range do wrong goes by its own polar coordinates (Loser & Kyle 1999,
Muralikrishnan et al. 2009). None of it is the robot's: without these such an error would be looked for there.
An error that goes smoothly by place, as of cameras, is not among them: from one set-up a robot's own smooth
errors look the same, and these are to be corrected.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ...robot.rotations import cross, nearest_turn
from ..base import Param
from ..coming_to_rest import start_and_span
from ..kinds import InstrumentEffect
from .base import MOVES, Unnamed, waves

CLOSEST = 0.5  # m: no tracker measures nearer points; where some are, the points' origin is no instrument
WAVES_IN_TIME = 6
IN_ORDER = 1e-5  # rad, or of the distance: what a tracker in order errs by, 15 µm + 6 µm/m
STEEPEST = 0.1  # cosine of the elevation: nor does its head look straight up


@dataclass(frozen=True)
class ByInstrument(Unnamed, InstrumentEffect):
    """An error of the instrument. It is the robot's no more than the room's: seen from another place it goes
    elsewhere."""

    lacks: ClassVar[str] = (
        "measure some of the poses from another place of the instrument, as another `setup`: what is of the "
        "robot stays, what is of the instrument goes along with it"
    )
    like: ClassVar[str] = "the instrument's own error, not the robot's"
    lasting: ClassVar[bool] = False

    def x(self, problem: Problem) -> Array:
        return _bearing(problem.campaign.points)


@dataclass(frozen=True)
class Bearing(ByInstrument):
    """The instrument turns about its vertical by the bearing."""

    variant: str = "bearing"

    functions: ClassVar[int] = 10
    variable: ClassVar[str] = "bearing from the instrument"

    def seen(self, problem: Problem, points: Array) -> Array:
        turn = np.stack([-points[..., 1], points[..., 0], np.zeros_like(points[..., 0])], axis=-1)
        return np.asarray(turn[..., None] * waves(self.x(problem), 5)[:, None, None, :])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls()] if np.ptp(_bearing(problem.campaign.points)) > MOVES else []


@dataclass(frozen=True)
class FromHead(ByInstrument):
    """An error in the polar coordinates of a head in the points' origin. distance [m]: a usual one of the
    campaign, at which it is as large as `size`."""

    size: float = IN_ORDER
    distance: float = 3.0

    settings: ClassVar[tuple[str, ...]] = ("size", "distance")

    @classmethod
    def at_hand(cls, problem: Problem) -> list[Self]:
        """Where a head may stand in the points' origin."""
        points = problem.campaign.points[problem.seen]
        return [cls(distance=float(np.median(np.linalg.norm(points, axis=1))))] if may_be_head(points) else []


@dataclass(frozen=True)
class Head(FromHead):
    """The tracker's own geometry: range by a constant and by elevation, azimuth and elevation by offsets and
    tilts of beam and axes and by encoders that run out, and by air that bends the beam."""

    variant: str = "head"

    functions: ClassVar[int] = 19
    variable: ClassVar[str] = "range, azimuth and elevation from the instrument"

    def seen(self, problem: Problem, points: Array) -> Array:
        away, azimuth, elevation, ray, across = _polar(problem)
        near, up, level = self.distance / away, np.sin(elevation), np.cos(elevation)
        turns = waves(azimuth.ravel(), 2).reshape(*azimuth.shape, 4)
        ranging = [near, level * near]
        even, both = np.ones_like(up), np.moveaxis(turns, -1, 0)
        turning = [even, up, near, *(level * both)]  # times the cosine of the elevation
        nodding = [near, even, up, level, np.sin(2 * elevation), np.cos(2 * elevation)]
        nodding += [up * near, 1 / near, *both[2:]]
        rise = cross(ray, across)
        ways = [(ray, ranging), (across, turning), (rise, nodding)]
        out = [way[..., None] * np.stack(by, axis=-1)[..., None, :] for way, by in ways]
        return np.asarray(away[..., None, None] * np.concatenate(out, axis=-1))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return cls.at_hand(problem)


@dataclass(frozen=True)
class Ranging(FromHead):
    """The range moves with time, as that of a head that warms up. start, span [s]: of the campaign."""

    variant: str = "ranging"
    start: float = 0.0
    span: float = 1.0

    settings: ClassVar[tuple[str, ...]] = (*FromHead.settings, "start", "span")
    variable: ClassVar[str] = "time (the instrument's range moves)"
    unit: ClassVar[str] = "s"
    functions: ClassVar[int] = WAVES_IN_TIME

    @property
    def params(self) -> tuple[Param, ...]:
        slower = np.arange(1, self.functions + 1) ** -1.5
        each = self.size * slower / np.linalg.norm(slower)
        return tuple(Param(f"weight_{k}", "rad", s, spread=s) for k, s in enumerate(map(float, each), 1))

    def x(self, problem: Problem) -> Array:
        return np.zeros(len(problem.q)) if problem.time is None else np.asarray(problem.time)

    def seen(self, problem: Problem, points: Array) -> Array:
        share = (self.x(problem) - self.start) / self.span
        cosines = np.cos(np.pi * np.outer(share, np.arange(1, self.functions + 1)))
        _, _, _, ray, _ = _polar(problem)
        return np.asarray(self.distance * ray[..., None] * cosines[:, None, None, :])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        if not problem.time_passes:
            return []
        first, span = start_and_span(problem)
        return [cls(distance=one.distance, start=first, span=span) for one in cls.at_hand(problem)]


@dataclass(frozen=True)
class OfReflectors(FromHead):
    """Each reflector shows its own error of range, by functions of how it is looked at; the points of a 6-D
    measurement are those of one probe. reflectors: their targets' names, none for the one that all are of. In
    a campaign with others (one that is planned), these show nothing."""

    reflectors: tuple[str, ...] = ()

    each: ClassVar[int] = 1

    @property
    def functions(self) -> int:
        return self.each * max(len(self.reflectors), 1)

    @abstractmethod
    def by(self, problem: Problem, ray: Array) -> Array:
        """(N, T, f) the functions, from the rays (N, T, 3)."""

    def seen(self, problem: Problem, points: Array) -> Array:
        _, _, _, ray, _ = _polar(problem)
        by = self.by(problem, ray)
        there = [target.name for target in problem.campaign.targets]
        which = np.array([[one == name for one in self.reflectors or [name]] for name in there], float)
        own = which[None, :, :, None] * by[:, :, None, :]  # (N, T, reflectors, f)
        own = own.reshape(*ray.shape[:2], -1)
        return np.asarray(self.distance * ray[..., None] * own[..., None, :])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        several = not problem.campaign.six_dof and len(problem.campaign.targets) > 1
        names = tuple(target.name for target in problem.campaign.targets) if several else ()
        return [cls(distance=one.distance, reflectors=names) for one in cls.at_hand(problem)]


@dataclass(frozen=True)
class Reflectors(OfReflectors):
    """A reflector of another radius, or of another glass, than the instrument was told: its range is off."""

    variant: str = "reflectors"

    variable: ClassVar[str] = "the reflector, whose range from the instrument is off"

    def by(self, problem: Problem, ray: Array) -> Array:
        return np.ones((*ray.shape[:2], 1))


@dataclass(frozen=True)
class Views(OfReflectors):
    """A reflector's range goes by how it is turned to the instrument, as glass and a ball off its centre
    make it."""

    variant: str = "views"
    each: ClassVar[int] = 9

    @property
    def variable(self) -> str:
        which = "the reflector or probe" if not self.reflectors else "each reflector"
        return f"how {which} is turned to the instrument"

    def by(self, problem: Problem, ray: Array) -> Array:
        u = ray @ _turn_of(problem)  # in the base
        frames, on = problem.rigid.R, problem.on
        u = np.stack([np.einsum("nij,ni->nj", frames[k], u[:, t]) for t, k in enumerate(on)], axis=1)
        x, y, z = np.moveaxis(u, -1, 0)
        return np.stack([np.ones_like(x), x, y, z, x * y, y * z, z * x, x**2 - y**2, 3 * z**2 - 1], axis=-1)


def may_be_head(points: Array) -> bool:
    """Whether the origin of points (M, 3) [m] may be the head that measured them."""
    away = np.linalg.norm(points, axis=1)
    level = np.hypot(points[:, 0], points[:, 1])
    return bool(away.min() >= CLOSEST and (level >= STEEPEST * away).all())


def _places(problem: Problem) -> Array:
    """(N, T, 3) [m] the measured points; where nothing was seen, the mean of all."""
    points, seen = problem.campaign.points, problem.seen[..., None]
    return np.where(seen, points, points[problem.seen].mean(axis=0))


def _polar(problem: Problem) -> tuple[Array, Array, Array, Array, Array]:
    """Distances, azimuths, elevations (N, T), rays and horizontal directions across them (N, T, 3)."""
    points = _places(problem)
    away = np.linalg.norm(points, axis=2)
    azimuth = np.arctan2(points[..., 1], points[..., 0])
    across = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros_like(azimuth)], axis=-1)
    return away, azimuth, np.arcsin(points[..., 2] / away), points / away[..., None], across


def _turn_of(problem: Problem) -> Array:
    """(3, 3) turn from the base to the instrument's frame, as the nominal arm has it."""
    middle = _places(problem).mean(axis=1)
    hand = problem.rigid.p[-1]
    return nearest_turn(hand - hand.mean(axis=0), middle - middle.mean(axis=0))


def _bearing(points: Array) -> Array:
    """(N,) direction [rad] in which the points (N, T, 3) of a pose stand."""
    seen = np.asarray(np.isfinite(points).all(axis=2))
    count = np.maximum(seen.sum(axis=1), 1)[:, None]
    middle = np.where(seen[..., None], points, 0.0).sum(axis=1) / count
    return np.asarray(np.arctan2(middle[:, 1], middle[:, 0]))
