"""The paper's protocol run in a world: stiffness for each cell, and what is left at the verification
points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench import Array

from . import springs
from .printed import CUTS
from .worlds import Poses, World


@dataclass(frozen=True, eq=False)
class Tried:
    """Of each model: K (C, n) [N·m/rad]; what is left at the verification points (M, 3) [m], as the
    tracker reads it and as it is. Models: `raw` (none), `theory` (nominal kinematics), `constant`, `2`,
    `16`, `128`, and `same`, constant from the measurements of all 128 cells."""

    K: Mapping[str, Array]
    read: Mapping[str, Array]
    true: Mapping[str, Array]

    @property
    def errors(self) -> dict[str, Array]:
        """(M,) [mm] equation (22), as the tracker reads it."""
        return {key: 1e3 * np.linalg.norm(left, axis=1) for key, left in self.read.items()}

    def mean(self, key: str) -> float:
        """[mm] what a model truly leaves, on average."""
        return float(1e3 * np.linalg.norm(self.true[key], axis=1).mean())


def tried(w: World, poses: tuple[Poses, Poses], rng: np.random.Generator, solver: str) -> Tried:
    """poses: what happens in those of the world, to identify the robot by and to verify it by."""
    grid, check = poses
    values, solve = w.values, {"plain": springs.plain, "damped": springs.damped}[solver]
    read = grid.read(values, rng)
    nominal = springs.normal(grid.columns(values, False, rng), read)
    again = grid.read(values, rng) if values["again"] > 0.5 else read
    calibrated = springs.normal(grid.columns(values, True, rng), again)
    cuts = {"theory": w.cuts["constant"], **{key: w.cuts[key] for key in CUTS}, "same": w.cuts["constant"]}
    used = {key: springs.poses_of(cut, w.cuts["128"]) for key, cut in cuts.items()}
    used["same"] = np.arange(len(read))[None]
    half = len(w.check.q) // 2
    points = w.check.rigid.points(w.check.stated_targets, w.check.on)[:half, 0]
    K, left, true = {}, {"raw": check.read(values, rng)}, {"raw": check.moved}
    for key, cut in cuts.items():
        equations = nominal if key == "theory" else calibrated
        compliance = solve(springs.summed(equations, used[key]), values)
        here = springs.of_points(points, w.box, cut, compliance)[:, :, None]
        told = (check.columns(values, key != "theory", rng) @ here)[:, :, 0]
        K[key], left[key], true[key] = 1 / compliance, check.read(values, rng) - told, check.moved - told
    return Tried(K, left, true)
