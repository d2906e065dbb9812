"""Shapes: where they go, how fast, and what cannot be drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workbench.correction.path_shapes import Run, circle, line, pocket, raster, spiral, tilted, work_frame
from workbench.correction.paths import Path, load_path, write_path
from workbench.files.faults import InputError

FRAME = work_frame([1.5, 0.2, 0.8], normal=[0.1, -0.2, 1.0], along=[1.0, 1.0, 0.0])
PLAIN = Run(FRAME, speed=0.05)
RAMPED = Run(FRAME, speed=0.05, acceleration=0.1)


def flat(path: Path) -> np.ndarray:
    """Points in the work frame (N, 3)."""
    assert path.X is not None
    return (path.X[:, :3, 3] - FRAME[:3, 3]) @ FRAME[:3, :3]


def speed(path: Path) -> np.ndarray:
    return np.linalg.norm(np.diff(flat(path), axis=0), axis=1) / np.diff(path.time)


SHAPES = {
    "line": lambda run: line(0.3, run),
    "circle": lambda run: circle(0.1, run),
    "raster": lambda run: raster(0.2, 0.06, 0.02, run),
    "spiral": lambda run: spiral(run),
    "pocket": lambda run: pocket(0.2, 0.12, 0.02, run),
}


@pytest.mark.parametrize("run", [PLAIN, RAMPED], ids=["constant", "ramped"])
@pytest.mark.parametrize("name", SHAPES)
def test_shapes_lie_in_their_plane_and_keep_to_speed(name: str, run: Run) -> None:
    path = SHAPES[name](run)
    assert path.X is not None
    assert np.abs(flat(path)[:, 2]).max() < 1e-12
    assert (np.diff(path.time) > 0).all()
    assert np.diff(path.time).max() <= run.period + 1e-9
    assert speed(path).max() <= run.speed * (1 + 1e-6)
    R = path.X[:, :3, :3]
    assert np.abs(R - FRAME[:3, :3] @ run.R_WT).max() < 1e-12


def test_constant_speed_is_constant() -> None:
    assert speed(circle(0.1, PLAIN)).min() > 0.05 * (1 - 1e-4)
    assert speed(spiral(PLAIN)).min() > 0.05 * (1 - 1e-3)


def test_ramps_start_and_end_at_rest_within_the_acceleration() -> None:
    path = raster(0.2, 0.06, 0.02, RAMPED)
    v = speed(path)
    assert v[0] < 0.1 * RAMPED.period
    assert v[-1] < 0.1 * RAMPED.period
    whole = np.isclose(np.diff(path.time), RAMPED.period)
    both = whole[1:] & whole[:-1]
    assert np.abs(np.diff(v)[both] / RAMPED.period).max() < 0.1 * 1.01
    # the shortest piece, 20 mm, just reaches the speed: 0.05² / 0.1 = 25 mm are needed for both ramps
    assert path.time[-1] == pytest.approx(4 * (0.2 / 0.05 + 0.5) + 3 * 2 * np.sqrt(0.02 / 0.1))


def test_spiral_is_that_of_the_source() -> None:
    points = flat(spiral(PLAIN))
    radius = np.hypot(points[:, 0], points[:, 1])
    theta = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert np.abs(radius - 0.024 * np.exp(0.15 * theta)).max() < 1e-12
    assert theta[-1] == pytest.approx(4 * np.pi)


def test_corners_are_hit_and_a_circle_closes() -> None:
    points = flat(pocket(0.2, 0.12, 0.02, PLAIN))
    for corner in ([-0.1, -0.06], [0.1, -0.06], [0.1, 0.06], [-0.1, 0.06], [-0.06, -0.02]):
        assert np.linalg.norm(points[:, :2] - corner, axis=1).min() < 1e-12
    there_and_back = flat(circle(0.1, PLAIN))
    assert np.abs(there_and_back[0] - there_and_back[-1]).max() < 1e-12
    clockwise = flat(circle(0.1, PLAIN, turns=-0.25))
    assert clockwise[-1] == pytest.approx([0.0, -0.1, 0.0], abs=1e-12)


def test_tool_tilts() -> None:
    path = line(0.1, replace(PLAIN, R_WT=tilted(15.0)))
    assert path.X is not None
    z = path.X[0, :3, 2]
    assert np.degrees(np.arccos(-z @ FRAME[:3, 2])) == pytest.approx(15.0)


@pytest.mark.parametrize(
    ("shape", "text"),
    [
        (lambda: circle(0.0, PLAIN), "no length"),
        (lambda: line(np.nan, PLAIN), "no length"),
        (lambda: raster(0.1, 0.01, 0.05, PLAIN), "no raster"),
        (lambda: pocket(0.1, 0.1, 0.0, PLAIN), "no room"),
        (lambda: line(0.1, replace(PLAIN, speed=0.0)), "speed"),
        (lambda: line(0.1, replace(PLAIN, acceleration=-1.0)), "acceleration"),
        (lambda: line(0.1, replace(PLAIN, R_WT=2 * np.eye(3))), "no rotation"),
    ],
)
def test_what_cannot_be_drawn(shape, text: str) -> None:
    with pytest.raises(InputError, match=text):
        shape()


def test_a_shape_goes_to_file_and_back(tmp_path) -> None:
    path = circle(0.05, Run(FRAME, period=0.1))
    path = replace(path, wrench=np.tile([1.0, 2.0, -3.0, 0.5, 0.0, 0.0], (len(path), 1)))
    path = replace(path, temperature=np.linspace(20, 25, len(path)))
    write_path(tmp_path / "circle.csv", path)
    back = load_path(tmp_path / "circle.csv")
    assert path.X is not None
    assert back.X is not None
    assert back.wrench is not None
    assert back.temperature is not None
    assert np.abs(back.X - path.X).max() < 1e-9
    assert np.abs(back.wrench - path.wrench).max() < 1e-12
    assert np.abs(back.temperature - path.temperature).max() < 1e-9
    assert back.place(3) == f"{tmp_path / 'circle.csv'} line 5"
