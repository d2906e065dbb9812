"""Cells: the grid, the two-step fit, prediction, commands, files, and what they say of bad input."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.campaign import Campaign, Target
from workbench.campaign.planned import planned
from workbench.campaign.problem import problem_of
from workbench.correction.path_shapes import Run, line, tilted, work_frame
from workbench.correction.paths import Path as DrawnPath
from workbench.correction.trajectory import nominal_joints
from workbench.diagnosis.prepared import prepare
from workbench.files.faults import InputError
from workbench.identification.cells import CellModel, cells, fit_cells, load_cells, write_cells
from workbench.identification.cells.two_steps import external, seated
from workbench.identification.fit import fit
from workbench.identification.model import Model
from workbench.robot.description import load_robot
from workbench.robot.rotations import pose
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate

BOX = np.array([[1.5, -0.3, 1.1], [1.9, 0.3, 1.5]])
TOOL = (0.08, 0.05, 0.25)
HAND = pose(np.array([TOOL]), np.eye(3)[None])[0]
IN_BASE = np.eye(3)[None], np.zeros((1, 3))
LOADED = load_robot("kr500")
ROBOT = replace(  # an instrument of 1 µm is of no use to a robot that does not repeat
    LOADED,
    joints=tuple(replace(j, data=j.data.model_copy(update={"repeatability": None})) for j in LOADED.joints),
)


def plan(points: np.ndarray, tilts: tuple[float, ...] = (-10.0, 0.0, 10.0)) -> Campaign:
    """All poses without load, then with 50 kg."""
    R = np.array([tilted(tilt) for tilt in tilts] * len(points))
    path = DrawnPath(10.0 * np.arange(len(R)), X=pose(np.repeat(points, len(tilts), axis=0), R))
    q = nominal_joints(ROBOT, path, HAND, start=np.deg2rad([0, -90, 90, 0, 60, 0]))
    return planned(
        ROBOT,
        np.tile(q, (2, 1)),
        targets=[Target("T", TOOL, fixed=True)],
        payloads={"mass": (50.0, (0.06, 0.0, 0.2))},
        payload=[""] * len(q) + ["mass"] * len(q),
        tool=(10.0, (0.0, 0.0, 0.1)),
    )


@pytest.fixture(scope="module")
def truth() -> Truth:
    arm = problem_of(plan(cells(BOX, (1, 1, 1)).samples)).arm
    return Truth(random_geometry(arm, np.random.default_rng(3)), sigma=1e-6, repeatability=np.zeros(6))


@pytest.fixture(scope="module")
def measured(truth: Truth) -> Campaign:
    return simulate(plan(cells(BOX, (1, 2, 1)).samples), truth, seed=1, instrument=IN_BASE)


@pytest.fixture(scope="module")
def model(measured: Campaign) -> CellModel:
    return fit_cells(measured, BOX, (1, 2, 1), instrument=IN_BASE)


def test_grid_has_shared_corners_once() -> None:
    grid = cells(BOX, (2, 3, 1))
    assert len(grid) == 6
    assert len(grid.samples) == 3 * 4 * 2 + 6
    assert len(np.unique(np.round(grid.samples, 9), axis=0)) == len(grid.samples)
    for cell in range(6):
        assert grid.holds(cell, grid.samples).sum() == 9
    assert grid.of(grid.draw(np.random.default_rng(0))).tolist() == list(range(6))


def test_points_outside_are_refused() -> None:
    with pytest.raises(InputError, match=r"1 of 2 are outside the cells, the first at \(3000, 0, 1200\) mm"):
        cells(BOX, (2, 2, 2)).of([[1.6, 0.0, 1.2], [3.0, 0.0, 1.2]])


@pytest.mark.parametrize(
    ("box", "counts", "said"),
    [
        (BOX[::-1], (1, 1, 1), "lower and its upper corner"),
        (BOX, (1, 0, 1), "three whole numbers"),
        (BOX, (1, 2), "three whole numbers"),
        (BOX[0], (1, 1, 1), "box"),
    ],
)
def test_bad_boxes_are_refused(box: np.ndarray, counts: tuple[int, ...], said: str) -> None:
    with pytest.raises(InputError, match=said):
        cells(box, counts)


def test_external_load_is_the_weight_at_its_place(measured: Campaign) -> None:
    told = external(measured)
    half = len(told.poses.q) // 2
    assert not told.poses.wrench[:half].any()
    np.testing.assert_allclose(told.poses.wrench[half:, :3], [[0, 0, -50 * 9.80665]] * half, atol=1e-12)
    assert not told.poses.wrench[:, 5].any()  # a weight turns nothing about the vertical
    again = external(told)
    np.testing.assert_array_equal(again.poses.wrench, told.poses.wrench)


def test_stiffness_is_found_where_the_mass_shows_it(model: CellModel) -> None:
    k, std = model.stiffness
    true = np.array([joint.data.stiffness for joint in ROBOT.joints])
    for j in (1, 2, 3, 4):
        assert (std[:, j] < 0.2).all()
        # beside noise: own weight pulls at the bent arm, which a weightless robot puts into K2, K3
        np.testing.assert_allclose(k[:, j], true[j], rtol=0.04 + 4 * std[:, j].max())
    assert (std[:, 0] > 1).all()  # a hanging mass does not turn the vertical axis


def test_deflection_is_that_of_the_true_robot(model: CellModel, truth: Truth) -> None:
    check = plan(cells(BOX, (2, 3, 2)).draw(np.random.default_rng(5)), (0.0,))
    points = simulate(check, replace(truth, sigma=0.0), instrument=IN_BASE).points[:, 0]
    half = len(points) // 2
    deflection = model.deflection(check)
    assert not deflection[:half].any()
    error = np.linalg.norm(points[half:] - points[:half] - deflection[half:], axis=1)
    assert error.max() < 4e-6 < 0.02 * np.linalg.norm(deflection[half:], axis=1).mean()
    np.testing.assert_allclose(model.predict(check), points, atol=3e-5)  # kinematics and load together


def test_instrument_may_stand_anywhere(model: CellModel, truth: Truth) -> None:
    plan_ = plan(cells(BOX, (1, 2, 1)).samples)
    elsewhere = fit_cells(simulate(plan_, truth, seed=1), BOX, (1, 2, 1))
    check = plan(cells(BOX, (1, 2, 1)).draw(np.random.default_rng(6)), (0.0,))
    np.testing.assert_allclose(elsewhere.deflection(check), model.deflection(check), atol=3e-6)


def test_a_prepared_campaign_gives_the_same_cells(model: CellModel, measured: Campaign) -> None:
    points = measured.points.copy()
    points[5] += 5e-3
    prepared = prepare(replace(measured, points=points))
    assert [(fault.kind, fault.pose_id) for fault in prepared.faults] == [("outlier", "6")]
    k, std = fit_cells(prepared.problem.campaign, BOX, (1, 2, 1), instrument=IN_BASE).stiffness
    seen = std < 0.2
    np.testing.assert_allclose(k[seen], model.stiffness[0][seen], rtol=0.05)
    harmed, _ = fit_cells(replace(measured, points=points), BOX, (1, 2, 1), instrument=IN_BASE).stiffness
    assert np.abs(harmed[seen] / model.stiffness[0][seen] - 1).max() > 0.2


def test_seated_geometry_stands_where_the_frame_put_it(truth: Truth) -> None:
    job = problem_of(simulate(plan(cells(BOX, (1, 1, 1)).samples), truth, seed=2, instrument=IN_BASE))
    model = Model(job)
    state = fit(model).state
    assert np.linalg.norm(state.R[0] - np.eye(3)) > 1e-6
    alone = model.start(np.eye(3)[None], np.zeros((1, 3)), state.targets)
    there = model.predict(replace(alone, geometry=seated(job.arm, state)))
    # gravity keeps its direction while the base turns by a milliradian: the rest is second order
    np.testing.assert_allclose(there, model.predict(state), atol=3e-6)


def test_commands_bring_the_loaded_robot_onto_the_path(model: CellModel, truth: Truth) -> None:
    frame = work_frame([1.7, -0.25, 1.3], along=(0, 1, 0))
    run = Run(frame, speed=0.1, period=0.5, R_WT=frame[:3, :3].T @ tilted(0.0))
    near = plan(np.array([[1.7, -0.2, 1.3]] * 2), (0.0,))
    path = line(0.5, run)
    weight, start = external(near).poses.wrench[-1], near.poses.q[0]
    made = model.compensate(path, weight, start=start)
    assert [cell for _, cell, _ in made.pieces] == [0, 1]
    assert len(made.jump_mm) == 1
    assert 0 < made.jump_mm[0] < 0.1
    job = planned(
        ROBOT,
        made.q,
        targets=[Target("T", TOOL, fixed=True)],
        payloads={"mass": (50.0, (0.06, 0.0, 0.2))},
        payload=["mass"] * len(made.q),
        tool=(10.0, (0.0, 0.0, 0.1)),
    )
    points = simulate(job, replace(truth, sigma=0.0), instrument=IN_BASE).points[:, 0]
    assert np.linalg.norm(points - path.X[:, :3, 3], axis=1).max() < 6e-5  # of 1 to 2 mm
    with pytest.raises(InputError, match="outside the cells"):
        model.compensate(line(0.8, run), weight, start=start)


def test_files_read_back(model: CellModel, tmp_path: Path) -> None:
    path = write_cells(tmp_path / "deep", model)
    again = load_cells(path)
    check = plan(cells(BOX, (1, 2, 1)).draw(np.random.default_rng(7)), (0.0,))
    np.testing.assert_allclose(again.predict(check), model.predict(check), atol=1e-12)
    text = path.read_text().replace('    "cell_002.toml",\n', "")
    path.write_text(text)
    with pytest.raises(InputError, match="1 models for 2 cells"):
        load_cells(path)
    path.write_text(text.replace("schema = 1", "schema = 2"))
    with pytest.raises(InputError, match="schema"):
        load_cells(path)
    with pytest.raises(InputError, match="no such file"):
        load_cells(tmp_path / "cells.toml")


def test_cells_without_poses_are_named(measured: Campaign) -> None:
    with pytest.raises(InputError) as refused:
        fit_cells(measured, BOX + np.array([[0, 0, 0], [0, 1.2, 0]]), (1, 3, 1), instrument=IN_BASE)
    (said,) = str(refused.value).splitlines()  # the first has all, the second those on the wall between them
    assert said == (
        "cell 3 (x 1500 … 1900, y 900 … 1500, z 1100 … 1500 mm): has 0 poses without load and 0 with; "
        "measure 3 of each at least, or take larger cells"
    )
    only = measured.with_poses(payload=np.zeros_like(measured.poses.payload))
    with pytest.raises(InputError, match="with; measure 3 of each"):
        fit_cells(only, BOX, (1, 1, 1), instrument=IN_BASE)
    unknown = replace(measured, targets=(Target("T"),))
    with pytest.raises(InputError, match="no known place on the flange"):
        fit_cells(unknown, BOX, (1, 1, 1), instrument=IN_BASE)
