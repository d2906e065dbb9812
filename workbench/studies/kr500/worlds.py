"""The paper's experiment with every value free: what its tracker and its force sensor read.

Poses, levers and torques come from the arm's own kinematics; what yields moves the SMR to first order, which
Drake's loaded equilibrium confirms to a micrometre.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench import (
    Array,
    Campaign,
    Fault,
    InputError,
    Problem,
    Robot,
    Target,
    cells,
    load_robot,
    path_shapes,
    planned,
    problem_of,
    random_geometry,
    rotation_about,
)

from .printed import CUTS, MASS, SIZE, TILTS
from .reach import WRIST, joints, rises

Values = Mapping[str, float]
Law = Callable[[Values, Problem, Array], Array]  # values, problem, wrenches (N, S, 6) -> motions (N, S, 6)
IN_BASE = np.eye(3)[None], np.zeros((1, 3))  # the paper measures in the base frame
GRAVITY = 9.80665
ALONG = 0.7  # of the prior: the long side along y
STEEPEST = np.deg2rad([127.0, 14.0])  # of upper arm and forearm above the level: joints 2 and 5


@dataclass(frozen=True, eq=False)
class World:
    """One experiment: `grid`, the points of all cells with three rotations, and `check`, a random point
    in each of the finest cells; all poses without load, then all with it. box: (2, 3) [m]; cuts: cells
    along its sides; geometry: (S, 6) what the kinematics are truly off by."""

    values: Values
    box: Array
    cuts: Mapping[str, tuple[int, int, int]]
    grid: Problem
    check: Problem
    geometry: Array


@dataclass(frozen=True, eq=False)
class Poses:
    """Of M poses. moved: (M, 3) [m] what the load moves the SMR by; J: (M, 3, n) [m/rad] its Jacobian,
    nominal and as calibrated; lever: the same of the point that the model takes the force to act at; R:
    (M, 3, 3) of the flange; force: (3,) [N] of load and cables."""

    moved: Array
    J: tuple[Array, Array]
    lever: tuple[Array, Array]
    R: Array
    force: Array
    scatter: Array

    def read(self, values: Values, rng: np.random.Generator) -> Array:
        """(M, 3) [m] what the tracker reads of `moved`: its noise, and the robot's scatter, of two
        standstills."""
        joints = np.sqrt(2) * values["scatter"] * self.scatter * rng.normal(size=(len(self.moved), 6))
        noise = np.sqrt(2) * values["sigma"] * rng.normal(size=self.moved.shape)
        return self.moved + (self.J[1] @ joints[:, :, None])[:, :, 0] + noise

    def columns(self, values: Values, calibrated: bool, rng: np.random.Generator) -> Array:
        """(M, 3, n) [m·N·m] what one unit of each joint's compliance moves the SMR by, equation (9),
        under the force that the sensor reads: turned, scaled, off and with noise."""
        drift = np.array([values.get(f"drift_{axis}", 0.0) for axis in "xyz"])
        turned = self.R
        for axis in "xyz":
            turned = turned @ rotation_about(axis, np.radians(values.get(f"turn_{axis}", 0.0)))
        off = (turned @ (drift + values["sensor"] * rng.normal(size=(len(self.R), 3)))[:, :, None])[:, :, 0]
        true = np.einsum("nji,j->ni", self.R, self.force)
        force = values.get("gain", 1.0) * np.einsum("nij,nj->ni", turned, true) + off
        torque = np.einsum("nij,ni->nj", self.lever[calibrated], force)
        return np.asarray(self.J[calibrated] * torque[:, None])


def world(values: Values, rng: np.random.Generator) -> World:
    """The experiment with these values. Raises `InputError` where the robot cannot reach the box."""
    robot = charged(_robot(), values)
    long_x = values["along"] >= ALONG
    turn = [0, 1, 2] if long_x else [1, 0, 2]
    half = np.array(SIZE)[turn] / 2
    centre = np.array([_ahead(values, half), values["y"], values["z"]])
    cuts = {key: (cut[1], cut[0], cut[2]) if long_x else cut for key, cut in CUTS.items()}
    box = np.array([centre - half, centre + half])
    fine = cells(box, cuts["128"])
    grid = problem_of(plan(robot, fine.samples, TILTS, values))
    check = replace(grid, campaign=plan(robot, fine.draw(rng), (0.0,), values))
    return World(values, box, cuts, grid, check, random_geometry(grid.arm, rng))


@lru_cache(maxsize=1)
def _robot() -> Robot:
    return load_robot("kr500")


def charged(robot: Robot, values: Values) -> Robot:
    """The robot with so much more gas pressure and length than its own."""
    gas = robot.compensator
    assert gas is not None
    assert gas.precharge
    assert gas.gas_length
    changed = {"precharge": values["charge"] * gas.precharge, "gas_length": values["gas"] * gas.gas_length}
    return replace(robot, compensator=gas.model_copy(update=changed))


def _ahead(values: Values, half: Array) -> float:
    """[m] x of the centre of a box with such half sides (3,): `near` says where, between the nearest and the
    farthest that the arm can serve."""
    x = np.linspace(0.8, 2.6, 91)
    offsets = half * (np.indices((3, 5, 3)).reshape(3, -1).T / [1.0, 2.0, 1.0] - 1)
    tool = [values["smr_x"], values["smr_y"], values["smr_z"] + WRIST]
    possible = np.ones(len(x), dtype=bool)
    for tilt in TILTS:
        wrist = np.array([0.0, values["y"], values["z"]]) + offsets - path_shapes.tilted(tilt) @ tool
        upper, fore, near = rises(wrist + x[:, None, None] * [1.0, 0.0, 0.0])
        possible &= (near & (upper < STEEPEST[0]) & (fore < STEEPEST[1])).all(axis=1)
    if not possible.any():
        raise InputError(Fault("box", "is out of reach wherever it lies", "another height or tool"))
    return float(np.quantile(x[possible], values["near"]))


def plan(robot: Robot, points: Array, tilts: tuple[float, ...], values: Values) -> Campaign:
    """The SMR at each point (M, 3), the tool straight down and tilted about its y [deg]."""
    R = np.array([path_shapes.tilted(tilt) for tilt in tilts] * len(points))
    smr = (values["smr_x"], values["smr_y"], values["smr_z"])
    q = joints(robot, np.repeat(points, len(tilts), axis=0) - R @ smr, R)
    side = [values.get("side_x", 0.0), values.get("side_y", 0.0), 0.0, 0.0, 0.0, 0.0]
    return planned(
        robot,
        np.tile(q, (2, 1)),
        targets=[Target("SMR", smr, fixed=True)],
        tool=(values["tool"], (0.0, 0.0, 0.1)),
        payloads={"mass": (MASS, [values[f"mass_{axis}"] for axis in "xyz"])},
        payload=[""] * len(q) + ["mass"] * len(q),
        wrench=np.vstack([np.zeros((len(q), 6)), np.tile(side, (len(q), 1))]) if any(side) else None,
        title="KR 500, one SMR, with and without 50 kg",
    )


def posed(w: World, problem: Problem, law: Law, moment: bool) -> Poses:
    """What happens in the poses of a world where the arm yields by `law`. moment: the model knows where
    the load hangs; else it takes the force to act at the SMR, as equations (7) to (9) do."""
    values, half = w.values, len(problem.q) // 2
    true = replace(problem, arm=problem.arm.with_geometry(w.geometry))
    motion = law(values, true, true.nominal_load.local)
    smr = problem.stated_targets[0]
    load = np.array([values[f"mass_{axis}"] for axis in "xyz"]) if moment else smr
    all_of = _moves(true, smr, half)
    J = [_jacobian(one, place, half) for place in (smr, load) for one in (problem, true)]
    return Poses(
        np.einsum("nsci,nsc->ni", all_of, motion[half:] - motion[:half]),
        (J[0], J[1]),
        (J[2], J[3]),
        problem.rigid.R[-1][:half],
        np.array([values.get("side_x", 0.0), values.get("side_y", 0.0), -MASS * GRAVITY]),
        np.array([joint.data.repeatability or 0.0 for joint in problem.robot.joints]),
    )


def both(w: World, law: Law, moment: bool) -> tuple[Poses, Poses]:
    """What happens in the poses to identify the robot by, and in those to verify it by."""
    return posed(w, w.grid, law, moment), posed(w, w.check, law, moment)


def _moves(problem: Problem, place: Array, count: int) -> Array:
    """(count, S, 6, 3) what the motions of all slots move a place (3,) [m] of the flange by, in the
    first poses."""
    axes = problem.rigid.axes[:count]
    turns = np.cross(axes[:, :, 3:], _levers(problem, place, count)[:, :, None])
    return np.concatenate([axes[:, :, :3], turns], axis=2)


def _jacobian(problem: Problem, place: Array, count: int) -> Array:
    """(count, 3, n) [m/rad] what the joints move a place (3,) [m] of the flange by, in the first poses."""
    turns = np.cross(problem.rigid.axes[:count, 1:-1, 5], _levers(problem, place, count)[:, 1:-1])
    return turns.transpose(0, 2, 1)


def _levers(problem: Problem, place: Array, count: int) -> Array:
    """(count, S, 3) [m] from each slot to a place (3,) [m] of the flange, in the first poses."""
    where = problem.rigid
    p = where.p[-1] + where.R[-1] @ place
    return np.asarray(p[:count, None] - where.origin[:count])
