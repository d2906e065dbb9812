"""Does the arm run into itself, the floor, or what stands around it? Drake's SceneGraph on convex hulls."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, count

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Box, Convex, Shape
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody, SpatialInertia
from pydrake.planning import RobotDiagramBuilder, SceneGraphCollisionChecker

from .description import Robot
from .drake_faults import quiet
from .hulls import STANDING, Hull
from .kinematics import Arm, Array
from .plants import urdf_plant

TOUCHES = 1e-6  # m: bodies that are nearer touch, as those that end where others begin
ALWAYS = 0.95  # share of all poses in which bodies that touch are built so
STEP = 0.2  # rad (m) of all joints together between two quick looks, which find most of what is in the way
NEAR = 0.2  # m: how much room is measured at a look on a way; more counts as this
SHARE, LEAST = 0.5, 1e-3  # of the clearance, and m: what a body may travel unseen between two looks
FLOOR, AROUND = "floor", "surroundings"
WIDE, DEEP = 100.0, 100.0  # m, of the floor's box: nothing is below it


@dataclass(frozen=True, eq=False)
class Collisions:
    """A checker for one robot in its surroundings. order: (n,) where its joints stand in Drake's positions;
    slots: (bodies,) the arm's slot that carries each of Drake's bodies, 0 for what stands; levers: (n, n + 1)
    [m/rad, 1] how far each joint moves what a slot carries, at most; clearance: [m] that all keep; ignored:
    pairs of bodies that touch in the zero pose, or nearly always: they are built so; such as are only nearer
    than the clearance there have none."""

    checker: SceneGraphCollisionChecker
    order: NDArray[np.int64]
    slots: NDArray[np.int64]
    levers: Array
    clearance: float
    ignored: tuple[tuple[str, str], ...] = ()

    def free(self, q: Array) -> NDArray[np.bool_]:
        """(N,) in which poses q: (N, n) all bodies keep clear of each other."""
        if not len(q):
            return np.zeros(0, dtype=bool)
        found = self.checker.CheckConfigsCollisionFree(list(self._drakes(q)), parallelize=False)
        return np.array(found, dtype=bool)

    def clear_way(self, start: Array, end: Array) -> bool:
        """Whether the straight joint motion between two poses (n,) is free: to either side of a look no two
        bodies move farther on each other than they are apart there, or than a share of the clearance."""
        way = self._drakes(np.array([start, end]))
        if not self.checker.CheckEdgeCollisionFree(way[0], way[1]):
            return False
        travel, least = self.travel(np.abs(end - start)), max(SHARE * self.clearance, LEAST)
        unseen = [(0.0, 1.0)]
        while unseen:
            first, last = unseen.pop()
            at = (first + last) / 2
            near = self.checker.CalcRobotClearance(way[0] + (way[1] - way[0]) * at, NEAR)
            apart = near.distances()
            if np.min(apart, initial=0.0) < 0:
                return False
            own, other = (np.fromiter(map(int, k), int) for k in (near.robot_indices(), near.other_indices()))
            pairs = travel[self.slots[own], self.slots[other]]
            seen = float(np.min(np.maximum(apart, least) / pairs, initial=NEAR / travel.max()))
            unseen += [(a, b) for a, b in ((first, at - seen), (at + seen, last)) if a < b]
        return True

    def travel(self, turned: Array) -> Array:
        """(n + 1, n + 1) [m] how far what two slots carry can move on each other, at most, while the joints
        turn by this much (n,), LEAST at least."""
        moved = np.cumsum(np.vstack([np.zeros(len(turned) + 1), turned[:, None] * self.levers]), axis=0)
        between = np.triu(np.diag(moved) - moved)  # [a, b]: by joints a + 1 to b
        return np.maximum(between + between.T, LEAST)

    def touching(self, q: Array) -> set[tuple[str, str]]:
        """Names of the bodies that come too near to each other in a pose (n,)."""
        return {pair for pair, apart in self.apart(q).items() if apart < 0}

    def apart(self, q: Array) -> dict[tuple[str, str], float]:
        """[m] beyond the clearance between bodies in a pose (n,), of those that are nearer: below zero."""
        plant, found = self.checker.plant(), dict[tuple[str, str], float]()
        near = self.checker.CalcRobotClearance(self._drakes(q[None])[0], 0.0)
        for a, b, apart in zip(near.robot_indices(), near.other_indices(), near.distances(), strict=True):
            pair = _pair(plant.get_body(a), plant.get_body(b))
            found[pair] = min(float(apart), found.get(pair, np.inf))
        return found

    def _drakes(self, q: Array) -> Array:
        out = np.zeros_like(q)
        out[:, self.order] = q
        return out


def collisions(
    robot: Robot, arm: Arm, hulls: Sequence[Hull], floor: float | None, clearance: float, seen: Array
) -> Collisions:
    """The checker of a robot with these hulls. floor: its height [m] in the base frame; clearance [m] that
    all bodies keep; seen: (N, n) usual poses, which show what is built to touch."""
    with quiet():
        builder = RobotDiagramBuilder(time_step=0.0)
        plant = builder.plant()
        urdf_plant(robot, plant, lambda grown: _add(grown, robot, arm, hulls, floor))
        own = plant.GetBodyByName(robot.base).model_instance()
        checker = SceneGraphCollisionChecker(
            model=builder.Build(),
            robot_model_instances=[own],
            edge_step_size=STEP,
            env_collision_padding=clearance,
            self_collision_padding=clearance,
        )
    plant = checker.plant()
    order = np.array([plant.GetJointByName(name).position_start() for name in robot.joint_names])
    slot = {name: k for k, name in enumerate(arm.links)}
    bodies = (plant.get_body(BodyIndex(k)) for k in range(plant.num_bodies()))
    slots = np.array([slot.get(body.name(), 0) if body.model_instance() == own else 0 for body in bodies])
    found = Collisions(checker, order, slots, _levers(robot, arm, hulls), clearance)
    robots = {body.name() for body in (plant.get_body(index) for index in plant.GetBodyIndices(own))}
    zero, usual = found.apart(np.zeros(arm.n)), [found.apart(q) for q in seen]

    def built_so(nearer: float) -> set[tuple[str, str]]:
        at_zero = {pair for pair, apart in zero.items() if apart < nearer and robots.issuperset(pair)}
        often = Counter(pair for one in usual for pair, apart in one.items() if apart < nearer)
        return at_zero | {pair for pair, times in often.items() if times >= ALWAYS * len(seen)}

    near, touch = built_so(0.0), built_so(TOUCHES - clearance)
    for a, b in near - touch:  # they may come as near as they like, but no nearer than that
        checker.SetPaddingBetween(plant.GetBodyByName(a), plant.GetBodyByName(b), 0.0)
    for a, b in touch:
        checker.SetCollisionFilteredBetween(plant.GetBodyByName(a), plant.GetBodyByName(b), True)
    return replace(found, ignored=tuple(sorted(touch)))


def _levers(robot: Robot, arm: Arm, hulls: Sequence[Hull]) -> Array:
    """(n, n + 1) bounds on how far [m] 1 rad (1 m) of each joint moves what a slot carries."""
    out = np.zeros((arm.n, arm.n + 1))
    ends = np.nan_to_num(robot.limits, posinf=np.pi, neginf=-np.pi)
    slide = np.where(arm.prismatic, np.abs(ends).max(axis=1), 0.0)
    for hull in hulls:
        far = float(np.linalg.norm(hull.vertices, axis=1).max())
        for slot in range(hull.slot, 0, -1):
            j = slot - 1
            out[j, hull.slot] = 1.0 if arm.prismatic[j] else max(out[j, hull.slot], far)
            far += float(np.linalg.norm(arm.p[slot])) + float(slide[j])
    return out


def _add(plant: MultibodyPlant, robot: Robot, arm: Arm, hulls: Sequence[Hull], floor: float | None) -> None:
    plant.AddModelInstance(AROUND)
    if floor is not None:
        _register(plant, _standing(plant, FLOOR), FLOOR, Box(WIDE, WIDE, DEEP), [0, 0, floor - DEEP / 2])
    for number, hull in enumerate(hulls):
        name = f"{hull.name} ({number})"  # of a shape: two on one body may be called alike
        if hull.slot == STANDING:
            _register(plant, _standing(plant, hull.name), name, Convex(hull.vertices.T.copy(), name))
        else:
            body = plant.GetBodyByName(arm.links[hull.slot])
            corners = (hull.vertices @ arm.R_link[hull.slot]).T.copy()
            _register(plant, body, name, Convex(corners, name))


def _standing(plant: MultibodyPlant, said: str) -> RigidBody:
    """A body of the surroundings; numbered where another, or a link, is called so."""
    name = next(
        one for one in chain([said], (f"{said} {k}" for k in count(2))) if not plant.HasBodyNamed(one)
    )
    body = plant.AddRigidBody(name, plant.GetModelInstanceByName(AROUND), SpatialInertia.Zero())
    plant.WeldFrames(plant.world_frame(), body.body_frame())
    return body


def _register(
    plant: MultibodyPlant, body: RigidBody, name: str, shape: Shape, place: Sequence[float] = (0, 0, 0)
) -> None:
    plant.RegisterCollisionGeometry(body, RigidTransform(np.array(place)), shape, name, CoulombFriction(0, 0))


def _pair(a: RigidBody, b: RigidBody) -> tuple[str, str]:
    first, second = sorted((str(a.name()), str(b.name())))
    return first, second
