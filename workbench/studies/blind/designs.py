"""Robots and campaign designs, drawn at random: what is measured, before anything is hidden in it."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign, Target
from ...campaign.planned import TARGETS, planned, random_poses
from ...campaign.problem import problem_of
from ...identification.noise import Covariance
from ...robot.description import Robot, load_robot
from ...robot.kinematics import Array
from ...simulation.random_robot import write_random_robot
from ...simulation.virtual_campaign import random_geometry

Ints = NDArray[np.int64]
ROBOTS = ("kr500", "ur5", "6R", "7R")
LOAD_MASSES = {"kr500": (60.0, 400.0), "ur5": (1.0, 5.0), "6R": (8.0, 50.0), "7R": (8.0, 50.0)}  # kg
REPEATED, RETURNS = 10, 5  # poses that are returned to, and how often they are measured
HELDOUT = 60  # poses of the campaign that judges
SCALE_BAR = (
    Target("B1", (1.2, -0.9, 0.3), on="base", fixed=True),
    Target("B2", (-0.4, 1.6, 0.2), on="base", fixed=True),
)


@dataclass(frozen=True)
class Design:
    """What is measured and with what errors, without any hidden cause.

    plan: the campaign to measure; judge: other poses of the same robot and set-up. repeatability: (n,)
    true one sigma of the joints; sigma [m]: noise per axis; stated: the campaign says sigma (else it has
    repeats). geometry: (S, 6) true errors; targets: (T, 3) true places.
    """

    plan: Campaign
    judge: Campaign
    repeatability: Array
    sigma: float
    stated: bool
    geometry: Array
    targets: Array

    @property
    def noise(self) -> Covariance:
        """The true noise of the plan's points."""
        return Covariance(
            np.full(self.plan.points.shape[:2], self.sigma),
            self.repeatability,
            np.ones(len(self.plan.poses.q)),
        )


def draw_robot(kind: str, folder: Path, rng: np.random.Generator) -> Robot:
    """The robot of a kind; a random arm is written into `folder`."""
    seed = int(rng.integers(1_000_000))
    return load_robot(kind if kind in ("kr500", "ur5") else write_random_robot(folder, seed, kind))


def draw_design(
    robot: Robot, kind: str, needs: Set[str], rng: np.random.Generator, stated: bool | None
) -> Design:
    """A design on a robot.

    needs: of "direction", "time", "temperature", "clock only" (time, but no thermometer), "payload",
    "readback", "scale bar"; other columns come and go. stated: the campaign states sigma; None: drawn.
    """
    stated = bool(rng.random() < 0.7) if stated is None else stated
    robot, repeatability = _repeatability(robot, stated, rng)
    columns = _columns(needs, rng)
    two = "payload" in needs or rng.random() < 0.6
    count = int(rng.integers(60, (130 if two else 200) + 1))
    poses = random_poses(robot, count, rng, share=float(rng.uniform(0.6, 0.95)))
    index, load = _records(count, two, stated, rng)
    direction = rng.choice([-1.0, 1.0], poses.shape)[index]
    other = random_poses(robot, HELDOUT, rng, share=0.6)
    other_load = rng.integers(0, 2, HELDOUT) if two else np.zeros(HELDOUT, dtype=np.int64)
    clock = np.cumsum(rng.uniform(25, 50, len(index)) + 900.0 * (np.diff(load, prepend=load[0]) != 0))
    clock -= clock[0]
    cell = _draw_cell(robot, kind, two, columns, "scale bar" in needs, float(clock[-1]), rng)
    plan = cell.campaign(poses[index], load, direction, clock, rng)
    side = rng.choice([-1.0, 1.0], other.shape)
    judge = cell.campaign(other, other_load, side, np.sort(rng.uniform(0, clock[-1], HELDOUT)), rng)
    problem = problem_of(plan)
    off = [np.zeros(3) if target.fixed else 5e-4 * rng.normal(size=3) for target in cell.targets]
    size = float(np.exp(rng.uniform(np.log(1e-4), np.log(1e-3))))
    sigma = float(np.exp(rng.uniform(np.log(1e-5), np.log(5e-5))))
    geometry = random_geometry(problem.arm, rng, size, size)
    return Design(plan, judge, repeatability, sigma, stated, geometry, problem.stated_targets + off)


@dataclass(frozen=True)
class _Cell:
    """What stays the same from pose to pose: robot, tool and payload, targets, columns, how it warms up.

    warm: from `warm[0]` by `warm[1]` [°C] with the time constant `warm[2]` [s].
    """

    robot: Robot
    targets: tuple[Target, ...]
    mass: float
    com: tuple[float, ...]
    two: bool
    columns: set[str]
    warm: tuple[float, float, float]

    def campaign(
        self, q: Array, load: Ints, direction: Array, clock: Array, rng: np.random.Generator
    ) -> Campaign:
        """What is told: poses q: (N, n), loads (N,) of 0 and 1, sides of approach (N, n), times (N,)."""
        warmth = self.warm[0] + self.warm[1] * (1 - np.exp(-clock / self.warm[2]))
        told = self.columns
        plan = planned(
            self.robot,
            q,
            targets=self.targets,
            payloads={"heavy": (self.mass, self.com)} if self.two else None,
            tool=(0.15 * self.mass, (0.0, 0.0, 0.06)),
            payload=["heavy" if heavy else "" for heavy in load] if self.two else None,
            direction=direction if "direction" in told else None,
            time=clock if "time" in told else None,
            temperature=warmth if "temperature" in told else None,
            readback=q + 2e-5 * rng.normal(size=q.shape) if "readback" in told else None,
        )
        return replace(plan, title=f"{self.robot.title}, {len(q)} poses")


def _draw_cell(
    robot: Robot,
    kind: str,
    two: bool,
    columns: set[str],
    scale_bar: bool,
    span: float,
    rng: np.random.Generator,
) -> _Cell:
    warm = float(rng.uniform(18, 23)), float(rng.uniform(4, 12)), float(rng.uniform(0.2, 0.8) * span)
    targets = _targets(scale_bar, rng)
    mass = float(np.exp(rng.uniform(*np.log(LOAD_MASSES[kind]))))
    com = tuple(float(x) for x in rng.uniform([-0.08, -0.08, 0.05], [0.08, 0.08, 0.2]))
    return _Cell(robot, targets, mass, com, two, columns, warm)


def _repeatability(robot: Robot, stated: bool, rng: np.random.Generator) -> tuple[Robot, Array]:
    """The robot as its TOML has it and its joints' true repeatability: as in the TOML, or near it."""
    n = len(robot.joints)
    said = robot.repeatability
    if not said.any() and rng.random() < 0.5:
        said = np.full(n, np.exp(rng.uniform(np.log(2e-6), np.log(1e-5))))
        if stated:
            joints = tuple(
                replace(joint, data=joint.data.model_copy(update={"repeatability": float(value)}))
                for joint, value in zip(robot.joints, said, strict=True)
            )
            robot = replace(robot, joints=joints)
    return robot, said if stated else said * rng.uniform(0.75, 1.3, n)


def _columns(needs: Set[str], rng: np.random.Generator) -> set[str]:
    """Columns that are recorded: what is needed, and by chance others."""
    columns = set(needs)
    chance = {"direction": 0.75, "time": 0.4, "temperature": 0.25, "readback": 0.1}
    columns |= {name for name, share in chance.items() if rng.random() < share}
    if "temperature" in columns or "clock only" in needs:
        columns.add("time")
    return columns - {"temperature"} if "clock only" in needs else columns


def _records(count: int, two: bool, stated: bool, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Index of the pose and load (0 or 1) of each record: load after load, poses in random order.

    Every pose is measured with both loads, or each with one of them. Without a stated sigma some
    poses are returned to, at random times.
    """
    index = np.arange(count, dtype=np.int64)
    load = np.zeros(count, dtype=np.int64)
    if two and rng.random() < 0.5:
        index, load = np.tile(index, 2), np.repeat([0, 1], count)
    elif two:
        load = rng.permutation(np.arange(count) % 2)
    if not stated:
        again = rng.choice(len(index), REPEATED, replace=False)
        extra = np.tile(again, RETURNS - 1)
        index, load = np.concatenate([index, index[extra]]), np.concatenate([load, load[extra]])
    order = np.lexsort([rng.random(len(index)), load])
    return index[order], load[order]


def _targets(scale_bar: bool, rng: np.random.Generator) -> tuple[Target, ...]:
    """One to three targets on the flange; with a scale bar, calibrated ones and two on the base."""
    count = 3 if scale_bar else int(rng.integers(1, 4))
    places = [np.array(target.xyz) * rng.uniform(0.7, 1.5, 3) for target in TARGETS[:count]]
    own = [
        Target(target.name, tuple(float(x) for x in place), fixed=scale_bar)  # type: ignore[arg-type]
        for target, place in zip(TARGETS, places, strict=False)
    ]
    return (*own, *(SCALE_BAR if scale_bar else ()))
