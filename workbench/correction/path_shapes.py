"""Paths by their shape: circle, line, raster, logarithmic spiral, pocket.

A shape is drawn in the xy-plane of a work frame W, whose pose `X_BW` in the robot's base frame says where
the work lies; the tool keeps one orientation `R_WT` there. The tool runs at constant `speed` [m/s]; with an
`acceleration` [m/s²] it starts and ends at rest, and stops at every sharp corner (without one it takes
corners at full speed, as no machine can). Samples come every `period` [s] and at each corner.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..files.faults import Fault, InputError
from ..robot.kinematics import Array
from ..robot.rotations import pose, rotation_about
from .paths import Path

Piece = tuple[float, Callable[[Array], Array]]  # length [m], and distances (K,) → points (K, 2) [m] in W
DOWN = np.diag([1.0, -1.0, -1.0])  # the tool's z into the plane, its x along the plane's x


@dataclass(frozen=True, eq=False)
class Run:
    """Where the work lies and how the tool runs along it; see the module."""

    X_BW: Array
    speed: float = 0.03
    acceleration: float | None = None
    period: float = 0.004
    R_WT: Array = field(default_factory=DOWN.copy)


def work_frame(
    origin: ArrayLike, normal: ArrayLike = (0.0, 0.0, 1.0), along: ArrayLike = (1.0, 0.0, 0.0)
) -> Array:
    """(4, 4) X_BW from its origin [m], its z axis `normal`, and the direction that its x goes `along`."""
    z = np.asarray(normal, float) / np.linalg.norm(normal)
    x = np.asarray(along, float) - (z @ np.asarray(along, float)) * z
    x = x / np.linalg.norm(x)
    return pose(np.asarray(origin, float)[None], np.stack([x, np.cross(z, x), z], axis=1)[None])[0]


def line(length: float, run: Run) -> Path:
    """From W's origin along its x, `length` [m]."""
    return _run("line", [_straight(np.zeros(2), np.array([length, 0.0]))], run)


def circle(radius: float, run: Run, turns: float = 1.0) -> Path:
    """About W's origin from its x axis, counter-clockwise (turns < 0: clockwise); radius [m]."""

    def points(s: Array) -> Array:
        angle = np.sign(turns) * s / radius
        return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    return _run("circle", [(2 * np.pi * abs(turns) * radius, points)], run)


def raster(length: float, width: float, spacing: float, run: Run) -> Path:
    """Lines of `length` [m] along x, `spacing` [m] apart over `width` [m], to and fro, from W's origin."""
    rows = round(width / spacing) + 1 if spacing > 0 else 0
    if rows < 2:
        raise InputError(Fault("raster", f"{width} m at {spacing} m spacing is no raster", "space it closer"))
    corners = [
        np.array([x, i * spacing])
        for i in range(rows)
        for x in ((0.0, length) if i % 2 == 0 else (length, 0.0))
    ]
    return _run("raster", _polygon(corners), run)


def spiral(run: Run, start: float = 0.024, growth: float = 0.15, angle: float = 4 * np.pi) -> Path:
    """Logarithmic spiral R = start · exp(growth · θ) [m], θ from 0 to `angle`.

    Without arguments it is that of Olabi et al. 2012.
    """
    slope = np.hypot(1.0, growth) / growth

    def points(s: Array) -> Array:
        # s = slope · start · (exp(growth θ) − 1)
        radius = start + s / slope
        theta = np.log(radius / start) / growth
        return radius[:, None] * np.stack([np.cos(theta), np.sin(theta)], axis=1)

    return _run("spiral", [(slope * start * np.expm1(growth * angle), points)], run)


def pocket(length: float, width: float, step: float, run: Run) -> Path:
    """A rectangle of length × width [m] about W's origin, cleared from the middle outwards.

    Rectangles `step` [m] apart, each run counter-clockwise from its lower left corner; all corners sharp.
    """
    loops = int(np.ceil(min(length, width) / 2 / step - 1e-9)) if step > 0 else 0
    if loops < 1:
        raise InputError(Fault("pocket", f"no room for a step of {step} m", "give sizes above zero"))
    corners: list[Array] = []
    for inset in step * np.arange(loops)[::-1]:
        x, y = length / 2 - inset, width / 2 - inset
        corners += [np.array(c) for c in ((-x, -y), (x, -y), (x, y), (-x, y), (-x, -y))]
    return _run("pocket", _polygon(corners), run)


def _polygon(corners: Sequence[Array]) -> list[Piece]:
    """Straight pieces between corners; none of no length."""
    return [_straight(a, b) for a, b in pairwise(corners) if np.linalg.norm(b - a) > 0]


def _straight(a: Array, b: Array) -> Piece:
    length = float(np.linalg.norm(b - a))
    return length, lambda s: a + np.outer(s / length, b - a)


def _run(title: str, pieces: Sequence[Piece], run: Run) -> Path:
    """Time along the pieces, and the tool's pose at each instant."""
    _check(title, pieces, run)
    times, points = [np.zeros(1)], [pieces[0][1](np.zeros(1))]
    now = 0.0
    for length, place in pieces:
        duration = _duration(length, run)
        ticks = np.arange(np.floor(now / run.period) + 1, np.ceil((now + duration) / run.period - 1e-9))
        local = np.append(ticks * run.period - now, duration)
        local = local[(local > 1e-9) & ((local < duration - 1e-9) | (local == duration))]
        times.append(now + local)
        points.append(place(_distance(local, length, duration, run)))
        now += duration
    flat = np.concatenate(points)
    p = run.X_BW[:3, 3] + flat @ run.X_BW[:3, :2].T
    R = np.broadcast_to(run.X_BW[:3, :3] @ run.R_WT, (len(p), 3, 3))
    return Path(np.concatenate(times), X=pose(p, R), title=title)


def _duration(length: float, run: Run) -> float:
    """[s] of one piece: at constant speed, or from rest to rest."""
    if run.acceleration is None:
        return length / run.speed
    ramp = run.speed**2 / run.acceleration  # both ramps together
    if length < ramp:
        return 2 * float(np.sqrt(length / run.acceleration))
    return length / run.speed + run.speed / run.acceleration


def _distance(time: Array, length: float, duration: float, run: Run) -> Array:
    """Distance [m] along a piece at times (K,) from its start: a trapezoidal velocity profile."""
    if run.acceleration is None:
        return np.minimum(run.speed * time, length)
    half = np.minimum(time, duration - time)
    ramp = min(run.speed / run.acceleration, duration / 2)
    way = np.where(
        half < ramp,
        0.5 * run.acceleration * half**2,
        run.acceleration * ramp * (half - ramp / 2),
    )
    return np.clip(np.where(time <= duration / 2, way, length - way), 0.0, length)


def _check(title: str, pieces: Sequence[Piece], run: Run) -> None:
    """Raises `InputError` for sizes that make no path."""
    faults = [
        Fault(f"{title}: {name}", f"is {value}", "give a number above zero")
        for name, value in (("speed", run.speed), ("acceleration", run.acceleration), ("period", run.period))
        if value is not None and not (np.isfinite(value) and value > 0)
    ]
    if not pieces or not all(np.isfinite(length) and length > 0 for length, _ in pieces):
        faults.append(Fault(title, "has no length", "give sizes above zero"))
    for name, R in (("X_BW", np.asarray(run.X_BW)[:3, :3]), ("R_WT", np.asarray(run.R_WT))):
        if R.shape != (3, 3) or not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0:
            faults.append(Fault(f"{title}: {name}", "is no rotation", "three axes at right angles, length 1"))
    if faults:
        raise InputError(faults)


def tilted(angle_deg: float) -> Array:
    """R_WT of a tool that looks down onto the plane and is tilted about W's y."""
    return np.asarray(rotation_about("y", np.radians(angle_deg)) @ DOWN)
