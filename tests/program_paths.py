"""Random programs of every kind that a controller takes, for round trips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from workbench.correction.programs import Format, Program, find_format
from workbench.correction.programs.files import beside
from workbench.files.faults import read_text
from workbench.robot import rotations
from workbench.robot.schema import LoadData


def read_program(path: Path, name: str) -> Program:
    """The program in a file of a format, or in a folder with one, and in all that belongs to it."""
    format = find_format(name)
    file = next(path.glob(f"*{format.extension}")) if path.is_dir() else path
    return format.read({one.name: read_text(one) for one in (file, *beside(file))})


def frame(rng: np.random.Generator, size: float) -> np.ndarray:
    return rotations.pose(rng.uniform(-size, size, 3), Rotation.random(rng=rng).as_matrix())


def random_path(rng: np.random.Generator, format: Format) -> Program:
    """Legs from a micrometre on, stops, turns on the spot, circles, rails, tools, bases, loads."""
    count = int(rng.integers(1, 13))
    kinds = rng.choice(["line", "short", "turn", "still", "circle"], count, p=[0.5, 0.15, 0.1, 0.1, 0.15])
    p, R = rng.uniform(-1.5, 1.5, 3), Rotation.random(rng=rng)
    X, via, time = [], np.full((count, 4, 4), np.nan), [float(rng.uniform(0, 5))]
    dwell = np.where(rng.random(count) < 0.2, rng.uniform(0.01, 3, count).round(2), 0.0)
    for i, kind in enumerate(kinds):
        if i:
            way = rng.normal(size=3)
            way /= np.linalg.norm(way)
            length = {"line": 10 ** rng.uniform(-3, -0.3), "short": 10 ** rng.uniform(-6, -4)}.get(kind, 0.0)
            if kind == "circle" and format.circles:
                length = rng.uniform(0.02, 0.2)
                side = np.cross(way, rng.normal(size=3))
                bulge = rng.uniform(0.1, 0.5) * length * side / np.linalg.norm(side)
                via[i] = rotations.pose(p + length * way / 2 + bulge, R.as_matrix())
            p = p + length * way
            if kind in ("line", "turn", "circle") and rng.random() < (1.0 if kind == "turn" else 0.6):
                R = Rotation.from_rotvec(rng.normal(size=3) * 0.3) * R
            speed = min(10 ** rng.uniform(-3, 0.2), 1.9)
            slow = float(rng.uniform(0.1, 4))
            time.append(time[-1] + dwell[i - 1] + (length / speed if length else slow))
        X.append(rotations.pose(p, R.as_matrix()))
    rails = 1 if format.most_rails and rng.random() < 0.3 else 0
    start = rng.random() < 0.6
    q = np.hstack([rng.uniform(0, 2, (count, rails)), rng.uniform(-3, 3, (count, 6 if start else 0))])
    return Program(
        "RANDOM",
        np.array(X),
        q if q.shape[1] else None,
        np.array(time),
        dwell,
        frame(rng, 0.3) if rng.random() < 0.5 else np.eye(4),
        sliding=(True,) * rails + (False,) * (6 if start else 0),
        blend=float(rng.choice([0.0, 1e-3, 5e-3])),
        share=float(rng.uniform(0.003, 1.0)),
        base=frame(rng, 1.0) if rng.random() < 0.3 else np.eye(4),
        load=LoadData(mass_kg=12.345, com_mm=(1.5, -20.25, 100.0)) if rng.random() < 0.5 else None,
        via=via if np.isfinite(via).any() else None,
    )


def random_targets(rng: np.random.Generator, format: Format) -> Program:
    """Joint targets: to stop at, with dwell, or a path with times."""
    count, rails = int(rng.integers(1, 13)), 1 if format.most_rails and rng.random() < 0.3 else 0
    dwell = np.where(rng.random(count) < 0.3, rng.uniform(0.01, 3, count).round(2), 0.0)
    time = None
    if rng.random() < 0.6:
        legs = np.concatenate([[0.0], rng.uniform(0.002, 8, count - 1)])
        time = np.cumsum(legs) + np.concatenate([[0.0], np.cumsum(dwell[:-1])])
    return Program(
        "RANDOM",
        q=np.hstack([rng.uniform(0, 2, (count, rails)), rng.uniform(-3, 3, (count, 6))]),
        time=time,
        dwell=dwell,
        kind="joints",
        sliding=(True,) * rails + (False,) * 6,
        share=float(rng.uniform(0.003, 1.0)),
    )
