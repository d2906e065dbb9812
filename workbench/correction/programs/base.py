"""A robot program, free of any controller: poses or joints, time, dwell, tool.

Writers and readers of the controllers' own formats (`format.py` and one file each) start and end
here. SI units; millimetres and degrees exist only in the files.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...robot import rotations
from ...robot.kinematics import Array
from ...robot.schema import LoadData
from .arcs import chords_and_tangents

STANDSTILL = 1e-6  # m and rad: a shorter leg is a standstill; most formats write no finer
SHARE_OF_LEG = 0.4  # a corner is rounded over less than half of the shorter leg (RAPID, UR: their limit)
FINEST_BLEND = 1e-5  # m: controllers take hundredths of a millimetre


@dataclass(frozen=True, eq=False)
class Program:
    """Points that a robot is to pass with its tool (`kind` "poses") or with its joints ("joints").

    name:    name on the controller
    X:       (N, 4, 4) tool poses in the base frame [m], or None
    q:       (N, n) joints, base to flange [rad or m], or None; beside poses it gives the start posture
             and the rails (a reader that finds rails beside poses gives q with the rails only)
    time:    (N,) when the tool arrives [s], or None: a file does not say, or joint moves at `share`, to stop
             and be measured
    dwell:   (N,) standstill after arrival [s]; one number counts for all points
    tool:    (4, 4) pose of the tool in the flange frame; identity = X are flange poses
    sliding: one flag per column of q: True = sliding joint; empty = all turn
    blend:   how far from a corner the tool may leave the line, at most [m]; 0 = stop at every point
    share:   of the joints' full speed, for joint moves
    base:    (4, 4) frame in the controller's world in which the file states the poses; X is in the world
    load:    what the flange carries, tool included, in the flange frame; None = not said in the file
    via:     (N, 4, 4) pose over which the circular leg to each point goes, NaN where it is straight; or None
    tolerance: how far corners may be cut, at most [m]; 0 = as `blend` has it
    posture: (N, 3) flags: wrist centre in front of axis 1, elbow up, joint 5 positive; or None (`posture.py`)
    notes:   lines of comment that the file begins with

    World, flange and joints are the controller's own, with its zeros and signs: `shown.py` makes them.
    """

    name: str
    X: Array | None = None
    q: Array | None = None
    time: Array | None = None
    dwell: Array = field(default_factory=lambda: np.zeros(1))
    tool: Array = field(default_factory=lambda: np.eye(4))
    kind: Literal["poses", "joints"] = "poses"
    sliding: tuple[bool, ...] = ()
    blend: float = 1e-3
    share: float = 0.1
    base: Array = field(default_factory=lambda: np.eye(4))
    load: LoadData | None = None
    via: Array | None = None
    tolerance: float = 0.0
    posture: NDArray[np.bool_] | None = None
    notes: tuple[str, ...] = ()

    @property
    def in_world(self) -> bool:
        """No base: the poses are the controller's world's."""
        return bool((self.base == np.eye(4)).all())

    @property
    def in_base(self) -> Array:
        """(N, 4, 4) tool poses in `base`, as files state them."""
        assert self.X is not None
        return self.X if self.in_world else np.linalg.inv(self.base) @ self.X

    @property
    def via_in_base(self) -> Array:
        """(N, 4, 4) poses over which circular legs go, in `base`; NaN where straight."""
        if self.via is None:
            return np.full((self.count, 4, 4), np.nan)
        return self.via if self.in_world else np.linalg.inv(self.base) @ self.via

    @property
    def circular(self) -> NDArray[np.bool_]:
        """(N,) which points are reached on a circle."""
        return np.asarray(np.isfinite(self.via_in_base[:, 0, 3]))

    @property
    def passing(self) -> NDArray[np.bool_]:
        """(N,) points of a path of joints that are passed without a stop: inner ones without dwell."""
        inner = np.zeros(self.count, dtype=bool)
        inner[1:-1] = True
        return inner & (self.dwell == 0) & (self.time is not None) & (self.blend > 0)

    @property
    def leg_times(self) -> Array:
        """(N,) duration of the leg to each point [s], dwell not counted; the first, and without time: NaN."""
        if self.time is None:
            return np.full(self.count, np.nan)
        return np.concatenate([[np.nan], np.diff(self.time) - self.dwell[:-1]])

    @property
    def at_flange(self) -> bool:
        """No tool: the poses are the flange's."""
        return bool((self.tool == np.eye(4)).all())

    def __post_init__(self) -> None:
        points = self.X if self.kind == "poses" else self.q
        if points is None:
            raise ValueError(f"a program of kind {self.kind!r} needs {'X' if self.kind == 'poses' else 'q'}")
        count = len(points)
        _set(self, "dwell", np.broadcast_to(np.asarray(self.dwell, float).ravel(), (count,)).copy())
        frames = [(name, (count, 4, 4)) for name in ("X", "via")] + [
            (name, (4, 4)) for name in ("tool", "base")
        ]
        for name, shape in (*frames, ("q", (count, -1)), ("time", (count,))):
            value: ArrayLike | None = getattr(self, name)
            if value is not None:
                _set(self, name, np.asarray(value, dtype=float).reshape(shape))
        if self.q is not None:
            _set(self, "sliding", tuple(self.sliding) or (False,) * self.q.shape[1])
            if len(self.sliding) != self.q.shape[1]:
                raise ValueError(f"{len(self.sliding)} flags in `sliding` for {self.q.shape[1]} joints")

    @property
    def count(self) -> int:
        return len(self.dwell)

    @property
    def rails(self) -> Array:
        """(N, r) positions of the sliding joints [m]."""
        return np.zeros((self.count, 0)) if self.q is None else self.q[:, np.array(self.sliding, dtype=bool)]

    @property
    def arm(self) -> Array:
        """(N, a) positions of the turning joints [rad]."""
        return np.zeros((self.count, 0)) if self.q is None else self.q[:, ~np.array(self.sliding, dtype=bool)]

    @property
    def speed(self) -> Array:
        """(N,) tool speed on the leg to each point [m/s], from time; the first leg goes as the second."""
        legs = legs_of(self)
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = np.where(legs.distance < STANDSTILL, 0.0, legs.distance / legs.duration)
        if self.count > 1:
            speed[0] = speed[1]
        return np.asarray(speed)


def _set(program: Program, name: str, value: Any) -> None:
    object.__setattr__(program, name, value)


@dataclass(frozen=True, eq=False)
class Legs:
    """The ways between the points; entry i is the leg that ends at point i (entry 0: no way).

    distance [m], angle [rad], duration [s]: (N,); duration NaN without time, 0 where all of it is pause
    speed [m/s], turn [rad/s]: (N,), what a controller is told; `turning` legs only rotate
    pause:  (N,) standstill at the point [s]: its dwell and the standing legs that follow it
    blend:  (N,) rounding of the corner [m], 0 = the tool stops there
    corner: (N,) change of direction at the point [rad]
    """

    distance: Array
    angle: Array
    duration: Array
    speed: Array
    turn: Array
    turning: NDArray[np.bool_]
    pause: Array
    blend: Array
    corner: Array


def legs_of(program: Program) -> Legs:
    """The legs of a program of poses, with speeds, pauses and corners as controllers want them."""
    n = program.count
    distance, angle = np.zeros(n), np.zeros(n)
    leave = arrive = np.zeros((0, 3))
    if program.X is not None and n > 1:
        distance[1:], leave, arrive = chords_and_tangents(program.X, program.via)
        angle[1:] = rotations.angle_between(program.X[:-1, :3, :3], program.X[1:, :3, :3])
    duration = program.leg_times
    if program.time is not None:
        duration[0] = 0.0
    still = (distance < STANDSTILL) & (angle < STANDSTILL)
    turning = (distance < STANDSTILL) & ~still
    pause = program.dwell.copy()
    pause[:-1] += np.where(still[1:] & (duration[1:] > 0), duration[1:], 0.0)
    duration = np.where(still & (duration > 0), 0.0, duration)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = _carried(np.where(distance < STANDSTILL, np.nan, distance / duration))
        turn = np.where(turning, angle / duration, np.nan)
    cosine = np.nan_to_num(np.einsum("ij,ij->i", arrive[:-1], leave[1:]), nan=1.0)
    corner = np.zeros(n)
    corner[1 : 1 + len(cosine)] = np.arccos(np.clip(cosine, -1.0, 1.0))
    blend = _blends(program, distance, pause, cosine)
    return Legs(distance, angle, duration, speed, turn, turning, pause, blend, corner)


def _carried(speed: Array) -> Array:
    """Standing and turning legs take the speed of the last moving leg before them (or the first one)."""
    known = np.flatnonzero(np.isfinite(speed))
    if not len(known):
        return speed
    last = np.searchsorted(known, np.arange(len(speed)), side="right") - 1
    return np.asarray(speed[known[np.maximum(last, 0)]])


def _blends(program: Program, distance: Array, pause: Array, cosine: Array) -> Array:
    """Corner rounding per point: not at the ends, not at a standstill, within both legs' share, and, where
    the program has a tolerance, so short that the rounded corner stays within it.

    cosine: (N − 2,) of the change of direction. A rounding that begins r before a corner that turns by θ
    passes it at about r sin(θ/2)/2 (the parabola between the two lines).
    """
    blend = np.zeros(program.count)
    if program.kind == "poses" and program.count > 2:
        room = SHARE_OF_LEG * np.minimum(distance[1:-1], distance[2:])
        if program.tolerance > 0:
            half = np.sqrt(np.clip((1 - cosine) / 2, 0.0, 1.0))
            with np.errstate(divide="ignore"):
                room = np.minimum(room, 2 * program.tolerance / half)
        blend[1:-1] = np.minimum(program.blend, room)
    blend[(pause > 0) | (blend < FINEST_BLEND)] = 0.0
    return blend
