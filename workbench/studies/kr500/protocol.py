"""The paper's protocol: a box in cells, poses at their corners and centres, a fit for each cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench import (
    Array,
    Campaign,
    CellModel,
    Path,
    Robot,
    Target,
    cells,
    fit_cells,
    nominal_joints,
    path_shapes,
    planned,
    pose,
    two_steps,
)

from .printed import CUTS, MASS, TILTS

# not in the paper: the story says why
BOX = np.array([[0.95, -0.6, 1.3], [1.55, 0.6, 1.9]])
SMR, LOAD, TOOL = (0.08, 0.05, 0.25), (MASS, (0.06, 0.0, 0.2)), (10.0, (0.0, 0.0, 0.1))
HAND = pose(np.array([SMR]), np.eye(3)[None])[0]
IN_BASE = np.eye(3)[None], np.zeros((1, 3))  # the paper measures in the base frame


def plan(robot: Robot, points: Array, tilts: Sequence[float] = TILTS) -> Campaign:
    """The tool straight down at each point (M, 3) and tilted about its y [deg]: all poses without load, then
    all of them with 50 kg."""
    R = np.array([path_shapes.tilted(tilt) for tilt in tilts] * len(points))
    path = Path(clock(len(R)), X=pose(np.repeat(points, len(tilts), axis=0), R))
    q = nominal_joints(robot, path, HAND, start=np.deg2rad([0, -90, 90, 0, 60, 0]))
    return planned(
        robot,
        np.tile(q, (2, 1)),
        targets=[Target("SMR", SMR, fixed=True)],
        tool=TOOL,
        payloads={"mass": LOAD},
        payload=[""] * len(q) + ["mass"] * len(q),
        title="KR 500, one SMR, with and without 50 kg",
    )


def clock(count: int) -> Array:
    """(count,) [s] time enough from pose to pose."""
    return 10.0 * np.arange(count, dtype=np.float64)


def at(data: Campaign, cut: str) -> Campaign:
    """The poses at the corners and centres of these cells; finer cells have all of them."""
    every, some = (cells(BOX, CUTS[key]).samples for key in ("128", cut))
    here = (np.abs(every[:, None] - some).max(axis=2) < 1e-6).any(axis=1)
    return two_steps.part(data, np.tile(np.repeat(here, len(TILTS)), 2))


def fitted(data: Campaign) -> dict[str, CellModel]:
    """The paper's models, and constant stiffness from the measurements of all 128 cells."""
    found = {key: fit_cells(at(data, key), BOX, cut, instrument=IN_BASE) for key, cut in CUTS.items()}
    theory = fit_cells(at(data, "constant"), BOX, (1, 1, 1), instrument=IN_BASE, kinematics=False)
    return {"theory": theory, **found, "same": fit_cells(data, BOX, (1, 1, 1), instrument=IN_BASE)}
