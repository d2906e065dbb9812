"""A model of its own for every cell: fitted, predicting, correcting paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ...campaign import Campaign, Target
from ...campaign.planned import planned
from ...campaign.problem import problem_of
from ...correction.command import Compensation, compensate
from ...correction.conditions import Conditions
from ...correction.paths import Path
from ...correction.trajectory import nominal_joints
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ...robot.kinematics import Array
from ..deflection import places
from ..fit import Fit, start_state
from .grid import Cells, Index, cells
from .two_steps import external, identified, part

FEWEST_PER_CELL = 3  # poses of a cell with load, and without


@dataclass(frozen=True, eq=False)
class Commands:
    """A path of N samples commanded cell by cell. q: (N, n) joints; pieces: samples, cell and command of each
    stretch; jump_mm: (walls,) by how much the commanded place jumps where the path goes through a wall."""

    q: Array
    pieces: tuple[tuple[slice, int, Compensation], ...]
    jump_mm: Array


@dataclass(frozen=True, eq=False)
class CellModel:
    """Parameters that vary from cell to cell. robots: the extended robot of each cell, weightless (`load`);
    tool: (3,) [m] place on the flange whose nominal position says which cell counts; fits: of each stiffness
    (none when read from files)."""

    cells: Cells
    robots: tuple[Robot, ...]
    tool: Array
    fits: tuple[Fit, ...] = ()

    def cell_of(self, points: ArrayLike) -> Index:
        """(N,) number of the cell of each point (N, 3) [m]. Raises `InputError` for points outside."""
        return self.cells.of(points)

    @property
    def stiffness(self) -> tuple[Array, Array]:
        """K (cells, n) [N·m/rad, N/m] as fitted, and the standard deviation of each compliance over its
        nominal value; of joints that the robot's TOML gives a stiffness."""
        k, std = np.empty((2, len(self.fits), len(self.robots[0].joints)))
        for i, one in enumerate(self.fits):
            for j, joint in enumerate(self.robots[i].joints):
                name = f"joint_compliance/{joint.name}"
                k[i, j] = (joint.data.stiffness or np.nan) / (1 + one.value(name))
                std[i, j] = one.std(name)
        return k, std

    def predict(self, plan: Campaign) -> Array:
        """(N, 3) [m] where the tool comes to rest in the poses of a plan under its loads, base frame."""
        tip = (Target("tool", (float(self.tool[0]), float(self.tool[1]), float(self.tool[2])), fixed=True),)
        plan = replace(external(plan), targets=tip, points=np.full((len(plan.poses.q), 1, 3), np.nan))
        where, out = self.cell_of(_places(plan, self.tool)), np.empty((len(plan.poses.q), 3))
        for cell in np.unique(where):
            here = replace(part(plan, where == cell), robot=self.robots[cell])
            out[where == cell] = places(here)[:, 0]
        return out

    def deflection(self, plan: Campaign) -> Array:
        """(N, 3) [m] by how much the loads of a plan move the tool."""
        plan = external(plan)
        return self.predict(plan) - self.predict(plan.with_poses(wrench=np.zeros_like(plan.poses.wrench)))

    def compensate(self, path: Path, wrench: ArrayLike | None = None, start: Array | None = None) -> Commands:
        """Commands that keep the tool on the path: each stretch by the model of its cell.

        wrench: (6,) or (N, 6) [N, N·m] on the robot at the flange origin, base frame; None: the path's.
        start: (n,) joints near the first pose: the cells hold in the posture that they were measured in.
        Parameters jump at a wall, and so does the command. Raises `InputError` for paths out of the cells.
        """
        nominal = replace(self.robots[0], geometry={}, effects=())
        tool = np.eye(4)
        tool[:3, 3] = self.tool
        q = nominal_joints(nominal, path, tool, start)
        given = path.wrench if wrench is None else wrench
        load = np.broadcast_to(np.zeros(6) if given is None else np.asarray(given, dtype=float), (len(q), 6))
        where = self.cell_of(_places(planned(nominal, q), self.tool))
        walls = (np.flatnonzero(np.diff(where)) + 1).tolist()
        pieces: list[tuple[slice, int, Compensation]] = []
        command, jumps, ahead = np.empty_like(q), [], np.full(3, np.nan)
        for begin, end in pairwise([0, *walls, len(q)]):
            # and the first sample behind the wall: how far from here does the next cell command it?
            some = slice(min(begin, len(q) - 2), min(end + 1, len(q)))
            own = slice(begin - some.start, end - some.start)
            piece = Path(path.time[some], q[some], title=path.title)
            made = compensate(self.robots[where[begin]], piece, Conditions(wrench=load[some]), tool=tool)
            jumps.append(1e3 * float(np.linalg.norm(made.X_command[own][0, :3, 3] - ahead)))
            ahead = made.X_command[-1, :3, 3]
            command[begin:end] = made.q_command[own]
            pieces.append((slice(begin, end), int(where[begin]), made))
        return Commands(command, tuple(pieces), np.array(jumps[1:]))


def fit_cells(
    campaign: Campaign,
    box: ArrayLike,
    counts: Sequence[int],
    *,
    instrument: tuple[Array, Array] | None = None,
    kinematics: bool = True,
) -> CellModel:
    """Cells of a box (2, 3) [m], each fitted from the poses whose nominal tool point lies in it.

    The campaign is fitted as it is: `prepare(campaign).problem.campaign` is without its data faults, and
    split where the instrument moved. The tool point is its first target. instrument: R (K, 3, 3), t (K, 3)
    [m] of the base in the instrument's frame per set-up, where it is known; None: registered once on all
    poses. kinematics=False keeps the robot's own. Raises `InputError` with the cells that lack poses with
    load or without.
    """
    grid, tool = cells(box, counts), _tool_point(campaign)
    if instrument is None:
        state = start_state(problem_of(campaign))
        instrument = state.R, state.t
    R, t = (given[campaign.poses.setup] for given in instrument)
    points = np.einsum("nji,ntj->nti", R, campaign.points - t[:, None])
    known = tuple(replace(target, fixed=True) for target in campaign.targets)
    told = replace(external(campaign), points=points, targets=known)
    told = replace(told.with_poses(setup=np.zeros_like(told.poses.setup)), setup_names=("",))
    where, loaded = _places(told, tool), told.poses.wrench.any(axis=1)
    inside = [grid.holds(cell, where) for cell in range(len(grid))]
    count = [((here & ~loaded).sum(), (here & loaded).sum()) for here in inside]
    mend = f"measure {FEWEST_PER_CELL} of each at least, or take larger cells"
    few = [
        Fault(grid.name(cell), f"has {empty} poses without load and {full} with", mend)
        for cell, (empty, full) in enumerate(count)
        if min(empty, full) < FEWEST_PER_CELL
    ]
    if few:
        raise InputError(few)
    robots, fits = zip(*(identified(part(told, here), kinematics) for here in inside), strict=True)
    return CellModel(grid, robots, tool, fits)


def _tool_point(campaign: Campaign) -> Array:
    """(3,) [m] the first target in the flange frame."""
    target = campaign.targets[0]
    if target.xyz is None or target.on != "flange":
        mend = "state its xyz_mm"
        raise InputError(Fault(f"target {target.name}", "is no known place on the flange", mend))
    return np.array(target.xyz)


def _places(plan: Campaign, tool: Array) -> Array:
    """(N, 3) [m] nominal places of the tool point, base frame."""
    nominal = replace(plan.robot, geometry={}, effects=())
    where = problem_of(replace(plan, robot=nominal)).rigid
    return np.asarray(where.points(tool[None], [where.arm.n + 1])[:, 0])
