"""Does the instrument see the targets? A ray to each against all hulls, and the cone of its reflector."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...robot.hulls import STANDING, Hull
from ...robot.kinematics import Arm, Array, frames

SHORT = 0.03  # m before a target where its ray ends: the reflector itself, on the body that carries it
TRIED = 300  # directions among which the best for a reflector is looked for


@dataclass(frozen=True, eq=False)
class Sight:
    """An instrument and what it looks at. eye: (3,) [m] in the base frame; cone: half of it [rad]; places:
    (T, 3) [m] behind slots `on`; opens: (T, 3) unit vectors there, NaN where a reflector has no direction
    yet; names: (T) of the targets; chosen: (T) whether the direction is the plan's.
    """

    arm: Arm
    hulls: Sequence[Hull]
    eye: Array
    cone: float
    places: Array
    on: Sequence[int]
    opens: Array
    names: Sequence[str]
    chosen: Sequence[bool] = ()

    @property
    def proposals(self) -> dict[str, tuple[float, float, float]]:
        """Direction that the plan chose, by target, in the URDF's frame of its link."""
        ways = {
            name: self.arm.R_link[k].T @ way
            for name, k, way, own in zip(self.names, self.on, self.opens, self.chosen, strict=False)
            if own and np.isfinite(way).all()
        }
        return {name: tuple(round(float(v), 3) for v in way) for name, way in ways.items()}  # type: ignore[misc]

    def of(self, names: Collection[str]) -> Sight:
        """The view of some of its targets."""
        kept = [t for t, name in enumerate(self.names) if name in names]
        return replace(
            self,
            places=self.places[kept],
            on=[self.on[t] for t in kept],
            opens=self.opens[kept],
            names=[self.names[t] for t in kept],
            chosen=[self.chosen[t] for t in kept] if len(self.chosen) else (),
        )

    def lines(self, q: Array) -> NDArray[np.bool_]:
        """(N, T) which targets no body hides in poses q: (N, n)."""
        where = frames(self.arm, q)
        points = where.points(self.places, self.on)
        clear = np.ones(points.shape[:2], dtype=bool)
        for hull in self.hulls:
            if hull.slot == STANDING:
                eye, ends = np.broadcast_to(self.eye, (len(q), 3)), points
            else:
                R, p = where.R[hull.slot], where.p[hull.slot]
                eye = np.einsum("nji,nj->ni", R, self.eye - p)
                ends = np.einsum("nji,ntj->nti", R, points - p[:, None])
            for t, slot in enumerate(self.on):
                carries = hull.slot != STANDING and abs(hull.slot - min(slot, self.arm.n)) <= 1
                clear[:, t] &= ~hides(hull, eye, ends[:, t], carries)
        return clear

    def directions(self, q: Array) -> Array:
        """(N, T, 3) unit vectors from each target to the instrument, in the frame behind the target's
        slot."""
        where = frames(self.arm, q)
        way = self.eye - where.points(self.places, self.on)
        way /= np.linalg.norm(way, axis=2, keepdims=True)
        return np.stack(
            [np.einsum("nji,nj->ni", where.R[k], way[:, t]) for t, k in enumerate(self.on)], axis=1
        )

    def sees(self, q: Array) -> NDArray[np.bool_]:
        """(N,) in which poses q: (N, n) all targets are seen, inside of the cones that have a direction."""
        across = np.einsum("ntj,tj->nt", self.directions(q), self.opens)
        inside = np.isnan(across) | (across > np.cos(self.cone))
        out: NDArray[np.bool_] = inside.all(axis=1)
        out[out] = self.lines(q[out]).all(axis=1)
        return out

    def turned(self, q: Array, rng: np.random.Generator) -> Sight:
        """With a direction for each reflector that has none: one after the other that by which most of the
        poses q: (N, n) are seen."""
        left, opens = q[self.sees(q)], self.opens.copy()
        for t in np.flatnonzero(np.isnan(opens[:, 0])):
            if not len(left):
                break
            way = self.directions(left)[:, t]
            tried = way[rng.choice(len(way), min(TRIED, len(way)), replace=False)]
            inside = way @ tried.T > np.cos(self.cone)
            mean = way[inside[:, int(np.argmax(inside.sum(axis=0)))]].mean(axis=0)
            opens[t] = mean / np.linalg.norm(mean)
            left = left[way @ opens[t] > np.cos(self.cone)]
        return replace(self, opens=opens, chosen=tuple(np.isnan(self.opens[:, 0])))


def hides(hull: Hull, eye: Array, end: Array, carries: bool) -> NDArray[np.bool_]:
    """(N,) whether the hull is in the way from eye (N, 3) to `SHORT` before end (N, 3), all in its frame.
    carries: the target sits on this body or on its neighbour, which may hold the end itself."""
    way = end - eye
    length = np.linalg.norm(way, axis=1)
    slope, room = way @ hull.normals.T, hull.offsets - eye @ hull.normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        at = room / slope
    enters = np.where(slope < 0, at, -np.inf).max(axis=1)
    leaves = np.where(slope > 0, at, np.inf).min(axis=1)
    beside = ((slope == 0) & (room < 0)).any(axis=1)
    last = 1 - SHORT / np.maximum(length, SHORT)
    crossed = ~beside & (np.maximum(enters, 0.0) < np.minimum(leaves, last))
    holds = (slope <= room).all(axis=1)
    return crossed & ~holds if carries else (crossed | holds)
