"""Which poses can be driven to and seen, and random ones of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...campaign.cell import CellData, ObstacleData
from ...campaign.planned import random_poses
from ...campaign.problem import Problem
from ...correction.programs.measuring import approaches
from ...files.faults import Fault, InputError
from ...robot.collisions import Collisions, collisions
from ...robot.description import Robot
from ...robot.hulls import STANDING, Hull, box_points, hull_of, mesh_points, robot_hulls
from ...robot.kinematics import Arm, Array
from ...robot.meshes import pictures
from ...robot.rotations import from_zyx
from .roadmap import NODES, Roadmap, clear_ways, roadmap
from .sight import Sight

UNSTATED = {
    "revolute": np.pi / 2,
    "prismatic": 1.0,
}  # rad/s, m/s: full speed of a joint of which none is known
START_STOP = 0.4  # s that a motion takes longer for starting and stopping
USUAL = 300  # poses that show what is built to touch, and how poses hang together
SWEPT = 10  # of them, in which joints are turned all the way
FEWEST = 10  # of them that have to be free
FIRST = 6000  # random poses for which reflectors are turned
MOST_DRAWN = 400  # times as many random poses as are wanted: then it is given up
REFLECTOR = 0.038  # m: a reflector's largest usual size, 1.5 inch

Draw = Callable[[int, np.random.Generator], Array]  # so many random poses (count, n)


@dataclass(frozen=True, eq=False)
class Reach:
    """A robot in its cell. hulls: all bodies, those standing around too; free: (V, n) poses free of them;
    sight: None where no instrument is stated; places:
    (T, 3) [m] of the targets, NaN unknown, behind slots `on`; names: (T) of them; reflectors: of those that
    are bodies too. closely: whether what hangs together is looked at closely, which takes its time, and not
    only what is driven."""

    robot: Robot
    arm: Arm
    cell: CellData
    hulls: tuple[Hull, ...]
    collisions: Collisions
    free: Array
    sight: Sight | None
    places: Array
    on: tuple[int, ...]
    names: tuple[str, ...]
    reflectors: tuple[str, ...]
    closely: bool = False

    @cached_property
    def confined(self) -> NDArray[np.bool_]:
        """(n,) joints that are kept within one turn: more would run into something from most poses."""
        return _confined(self.robot, self.collisions, self.free[:SWEPT])

    @cached_property
    def map(self) -> Roadmap:
        """Free poses that hang together."""
        free = within_a_turn(self.robot, self.free[:NODES], self.confined)
        return roadmap(self.collisions, partial(_time, self.robot, self.cell), free, self.closely)

    @property
    def unchecked(self) -> list[tuple[str, str]]:
        """Pairs of a body of the robot and one that stands around, which touch in nearly all poses, so that
        they are not checked."""
        own = {self.robot.base, *self.robot.links}
        return [pair for pair in self.collisions.ignored if not own.issuperset(pair)]

    def looking_at(self, names: Collection[str]) -> Reach:
        """The same where of the targets these alone are measured."""
        gone = [name not in names for name in self.names]
        return replace(
            self,
            places=np.where(np.array(gone)[:, None], np.nan, self.places),
            sight=None if self.sight is None else self.sight.of(names),
        )

    def time(self, start: Array, end: Array) -> Array:
        """[s] of straight joint motions from poses (..., n) to others."""
        return _time(self.robot, self.cell, start, end)

    def approaches(self, q: Array, side: Array) -> Array:
        """(N, n) where the arm comes to before poses q (N, n), of which side (N, n) says the last motion."""
        return approaches(self.robot, q, side)

    def good(self, q: Array, linked: bool = True) -> NDArray[np.bool_]:
        """(N,) which poses q (N, n) are seen, free with the ways to them from below and from above, and, if
        `linked`, within reach of the others."""
        out = np.ones(len(q), dtype=bool) if self.sight is None else self.sight.sees(q)
        for side in (0.0, 1.0, -1.0):
            kept = q[out]
            out[out] = self.collisions.free(self.approaches(kept, np.full_like(kept, side)))
        if linked:
            out[out] = self.map.holds(q[out])
        return out

    def draw(self, count: int, rng: np.random.Generator, linked: bool = True) -> Array:
        """Random poses (count, n) that are `good`; of those that need not be `linked`, joints may be a turn
        farther. Raises InputError where hardly any is."""
        kept: list[Array] = []
        drawn, batch = 0, 2 * count
        while len(kept) < count:
            q = random_poses(self.robot, batch, rng)
            if linked:
                q = within_a_turn(self.robot, q, self.confined)
            kept.extend(q[self.good(q, linked)])
            drawn += batch
            if drawn > MOST_DRAWN * count:
                raise InputError(self._why(q, len(kept), drawn))
            batch = min(20_000, max(batch, int(1.2 * (count - len(kept)) * drawn / max(1, len(kept)))))
        return np.array(kept[:count])

    def _why(self, q: Array, kept: int, drawn: int) -> Fault:
        seen = np.ones(len(q), dtype=bool) if self.sight is None else self.sight.sees(q)
        free = self.collisions.free(q)
        what = (
            f"only {kept} of {drawn} random poses can be measured: {100 * free.mean():.0f} % are free of "
            f"collision, {100 * seen.mean():.1f} % are seen by the instrument"
        )
        mend = (
            "move [instrument], turn the reflectors (opens), or leave more room (clearance_mm, [[obstacles]])"
        )
        return Fault(self.robot.name, what, mend)


def reach(
    problem: Problem,
    places: Array,
    cell: CellData,
    rng: np.random.Generator,
    shown: NDArray[np.bool_] | None = None,
) -> Reach:
    """The robot of a problem in its cell. places: (T, 3) [m] of its targets behind their slots; shown: (T,)
    those that have to be seen (default: all). Raises `InputError`."""
    robot, arm = problem.robot, problem.arm
    hulls = (*robot_hulls(robot, arm), *_obstacles(robot, arm, cell))
    driving = cell.driving
    floor = None if driving.floor_mm is None else 1e-3 * driving.floor_mm
    usual = random_poses(robot, USUAL, rng)
    reflectors = _reflectors(problem, places)
    every = (*hulls, *reflectors.values())
    bodies = collisions(robot, arm, every, floor, 1e-3 * driving.clearance_mm, usual)
    free = usual[bodies.free(usual)]
    if len(free) < FEWEST:
        what = f"{USUAL - len(free)} of {USUAL} random poses collide: {_touching(bodies, usual)}"
        raise InputError(
            Fault(robot.name, what, "mend [[obstacles]], floor_mm and clearance_mm of [driving]")
        )
    sight = _sight(problem, places, shown, cell, hulls)
    names = tuple(target.name for target in problem.campaign.targets)
    targets = places, tuple(problem.on), names, tuple(reflectors)
    found = Reach(robot, arm, cell, hulls, bodies, free, sight, *targets)
    if found.sight is None or not np.isnan(found.sight.opens).any():
        return found
    q = random_poses(robot, FIRST, rng)
    free = q[bodies.free(q)]
    return replace(found, sight=found.sight.turned(free, rng))


def _confined(robot: Robot, bodies: Collisions, q: Array) -> NDArray[np.bool_]:
    """(n,) joints that may turn more than once, but not without running into something from most poses q."""
    out = np.zeros(q.shape[1], dtype=bool)
    for j, joint in enumerate(robot.joints):
        if joint.kind == "revolute" and np.isfinite(joint.upper) and joint.upper - joint.lower > 2 * np.pi:
            start, end = q.copy(), q.copy()
            start[:, j], end[:, j] = joint.lower, joint.upper
            out[j] = clear_ways(bodies, start, end, closely=False).mean() < 0.5
    return out


def within_a_turn(robot: Robot, q: Array, confined: NDArray[np.bool_]) -> Array:
    """Poses (N, n) that look the same, with the confined joints within half a turn of the middle of their
    range."""
    middle = np.array(
        [(j.lower + j.upper) / 2 if np.isfinite(j.upper - j.lower) else 0.0 for j in robot.joints]
    )
    return np.where(confined, middle + (q - middle + np.pi) % (2 * np.pi) - np.pi, q)


def _time(robot: Robot, cell: CellData, start: Array, end: Array) -> Array:
    longest = (np.abs(end - start) / (cell.driving.speed_share * full_speed(robot))).max(axis=-1)
    return np.asarray(np.where(longest > 0, longest + START_STOP, 0.0))


def full_speed(robot: Robot) -> Array:
    """(n,) [rad/s, m/s] as the URDF states them, or assumed."""
    said = [joint.velocity if np.isfinite(joint.velocity) else UNSTATED[joint.kind] for joint in robot.joints]
    return np.array(said)


def _touching(bodies: Collisions, q: Array) -> str:
    """The pairs that touch most often."""
    found = Counter(pair for one in q for pair in bodies.touching(one))
    return ", ".join(f"{a} with {b}" for (a, b), _ in found.most_common(3))


def _sight(
    problem: Problem,
    places: Array,
    shown: NDArray[np.bool_] | None,
    cell: CellData,
    hulls: tuple[Hull, ...],
) -> Sight | None:
    """Of the instrument to the targets that move; a 6-D probe is one, in the middle of its points."""
    if cell.instrument is None:
        return None
    wanted = np.isfinite(places).all(axis=1) & (np.ones(len(places), dtype=bool) if shown is None else shown)
    moving = [t for t, k in enumerate(problem.on) if k > 0 and wanted[t]]
    said = [problem.campaign.targets[t].opens for t in moving]
    opens = np.array([(np.nan,) * 3 if way is None else way for way in said]).reshape(-1, 3)
    on = [problem.on[t] for t in moving]
    opens = np.array([problem.arm.R_link[k] @ way for k, way in zip(on, opens, strict=True)]).reshape(-1, 3)
    opens /= np.linalg.norm(opens, axis=1, keepdims=True)
    seen = places[moving]
    names = [problem.campaign.targets[t].name for t in moving]
    if problem.campaign.six_dof and moving:
        known = opens[~np.isnan(opens[:, 0])]
        seen, on, opens = seen.mean(axis=0, keepdims=True), on[:1], (known if len(known) else opens)[:1]
        names = names[:1]
    if not moving:
        return None
    eye = 1e-3 * np.array(cell.instrument.xyz_mm)
    cone = float(np.radians(cell.instrument.acceptance_deg))
    return Sight(problem.arm, hulls, eye, cone, seen, on, opens, names)


def _reflectors(problem: Problem, places: Array) -> dict[str, Hull]:
    """The bodies of targets that move, by name, where their places (T, 3) [m] are known. Of a 6-D probe only
    points are known, which need not be on it."""
    arm, found = problem.arm, dict[str, Hull]()
    for target, slot, place in zip(problem.campaign.targets, problem.on, places, strict=True):
        if slot == 0 or problem.campaign.six_dof or not np.isfinite(place).all():
            continue
        points = place + box_points([REFLECTOR] * 3)
        if slot > arm.n:
            slot, points = arm.n, _on_last_link(arm, points)
        hull = hull_of(target.name, slot, points)
        assert hull is not None
        found[target.name] = hull
    return found


def _obstacles(robot: Robot, arm: Arm, cell: CellData) -> list[Hull]:
    """What stands around the robot and what it carries."""
    out = []
    for one in cell.obstacles:
        R = from_zyx(np.radians([one.abc_deg]))[0]
        points = _points(one) @ R.T + 1e-3 * np.array(one.xyz_mm)
        slot = STANDING
        if one.on in ("flange", robot.flange):
            slot, points = arm.n, _on_last_link(arm, points)
        elif one.on in robot.links:
            slot = 1 + robot.links.index(one.on)
            points = points @ arm.R_link[slot].T
        elif one.on not in ("base", robot.base):
            mend = f"base, flange or one of {', '.join(robot.links)}"
            raise InputError(Fault(f"obstacles {one.name!r}", f"on = {one.on!r} is no link", mend))
        hull = hull_of(one.name, slot, points)
        if hull is None:
            raise InputError(Fault(f"obstacles {one.name!r}", f"{one.mesh} cannot be read", "give box_mm"))
        out.append(hull)
    return out


def _on_last_link(arm: Arm, points: Array) -> Array:
    """Points (V, 3) [m] of the flange's frame in that of the last link, which carries it."""
    return points @ arm.R[-1].T + arm.p[-1]


def _points(one: ObstacleData) -> Array:
    if one.box_mm is not None:
        return box_points([1e-3 * edge for edge in one.box_mm])
    import tempfile

    assert one.mesh is not None
    key = (one.mesh, "1 1 1")
    with tempfile.TemporaryDirectory(prefix="workbench-obstacles-") as folder:
        parts = pictures([(key, Path(one.mesh))], Path(folder)).get(key, [])
        found = [mesh_points(part) for part in parts]
    return np.concatenate(found) if found else np.zeros((0, 3))
