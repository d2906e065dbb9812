"""Cells in files: `cells.toml` (box, counts, tool) and a model.toml for each cell beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, ValidationError

from ...files.faults import Fault, InputError
from ...files.section import Section
from ...files.toml import read_toml, toml_text
from ...files.whole import put_all
from ...robot.description import load_robot
from ...robot.rigid_plant import arrays
from ...robot.schema import toml_faults
from ..model_file import model_files
from .cell_model import CellModel
from .grid import cells

Vector = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Count = Annotated[int, Field(ge=1)]


class _File(Section):
    schema_: Literal[1] = Field(alias="schema")
    lower_mm: Vector
    upper_mm: Vector
    counts: tuple[Count, Count, Count]
    tool_mm: Vector
    models: tuple[str, ...]


def write_cells(folder: str | Path, model: CellModel) -> Path:
    """Writes `cells.toml` and `cell_001.toml` ... into the folder; returns the path of the first.

    The models come in the order of the cells: x slowest, z fastest. All files are written, or none.
    """
    folder, grid = Path(folder), model.cells
    names = [f"cell_{i + 1:03d}.toml" for i in range(len(grid))]
    made: dict[Path, bytes | str] = {
        path: text
        for name, robot in zip(names, model.robots, strict=True)
        for path, text in model_files(folder / name, robot, arrays(robot).geometry, robot.effects).items()
    }
    table = {
        "schema": 1,
        "lower_mm": _mm(grid.lower),
        "upper_mm": _mm(grid.upper),
        "counts": list(grid.counts),
        "tool_mm": _mm(model.tool),
        "models": names,
    }
    put_all(made | {folder / "cells.toml": toml_text(table)})
    return folder / "cells.toml"


def load_cells(path: str | Path) -> CellModel:
    """The cells of a `cells.toml`. Raises `InputError` with its faults, or those of a model."""
    path = Path(path)
    content = read_toml(path)
    try:
        file = _File.model_validate(content)
    except ValidationError as error:
        raise InputError(toml_faults(path, error, _File)) from None
    grid = cells(1e-3 * np.array([file.lower_mm, file.upper_mm]), file.counts)
    if len(file.models) != len(grid):
        what = f"{len(file.models)} models for {len(grid)} cells"
        raise InputError(Fault(f"{path}: models", what, "name one per cell, x slowest, z fastest"))
    robots = tuple(load_robot(path.parent / name) for name in file.models)
    return CellModel(grid, robots, 1e-3 * np.array(file.tool_mm))


def _mm(vector: np.ndarray) -> list[float]:
    return [round(1e3 * float(x), 9) for x in vector]
