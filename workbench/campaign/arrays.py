"""A campaign out of arrays or data frames, by the same way as one out of files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..files.faults import Fault, InputError
from ..files.tables import Column, Layout, Table, number_text, parse_table, table_text
from ..robot.description import Robot, load_robot
from ..robot.schema import toml_faults
from .check import check_points, check_poses, check_targets
from .data import Campaign
from .file import CampaignFile, point_columns, pose_columns
from .load import NotInOrder, joined
from .point_table import seen_rows


def campaign_from_arrays(
    robot: Robot | str | Path,
    q: Any,
    points: Any,
    sigma: float | None = None,
    sections: Mapping[str, Any] | None = None,
    title: str = "arrays",
) -> Campaign:
    """A campaign out of arrays or data frames, checked like one out of files.

    robot: as loaded, by name or by its TOML. q: (N, n) commanded joints [rad, m], or a data frame
    (pandas, polars, a mapping of columns) with the columns of `poses.csv`. points: (N, 3) or
    (N, T, 3) [m] in the instrument's frame, NaN where not seen, or a data frame with the columns of
    `points.csv`. sigma: of the instrument [m, per axis]. sections: more of `campaign.toml` by its keys
    (`targets`, `tool`, ...).
    Raises `InputError`.

    >>> import numpy as np
    >>> from workbench import campaign_from_arrays
    >>> q = np.random.default_rng(0).uniform(0.1, 0.5, (12, 3))
    >>> campaign_from_arrays("cylindrical", q, points=np.ones((12, 3)) + q, sigma=3e-5).n_points
    12
    """
    robot = robot if isinstance(robot, Robot) else load_robot(robot)
    said: dict[str, Any] = {"schema": 1, "title": title, "robot": robot.name, **(sections or {})}
    said |= {"poses": {"file": "q"}, "points": {"file": "points"}}
    if sigma is not None:
        said["noise"] = {**said.get("noise", {}), "sigma_mm": 1e3 * sigma}
    place = Path(title)
    try:
        file = CampaignFile.model_validate(said)
    except ValidationError as error:
        raise InputError(toml_faults(place, error, CampaignFile)) from None
    poses = _poses(q, robot)
    seen = _points(points, file)
    faults = [*check_targets(place, file, robot), *poses.faults, *seen.faults]
    if not faults:
        faults = [
            *check_poses(poses, robot, file.payloads),
            *check_points(seen, file.noise.sigma_mm is not None),
        ]
    if faults:
        raise InputError(faults)
    try:
        return joined(place, file, robot, poses, seen)
    except NotInOrder:
        what = f"{len(seen)} points without pose_id for {len(poses)} poses"
        raise InputError(Fault("points", what, "give as many, or name the poses")) from None


def _poses(q: Any, robot: Robot) -> Table:
    if _is_frame(q):
        return _framed(q, "q", pose_columns(robot))
    values = np.asarray(q, dtype=float)
    n = len(robot.joints)
    if values.ndim != 2 or values.shape[1] != n:
        mend = f"(N, {n}) [rad, m]: {robot.name} has {n} joints"
        raise InputError(Fault("q", f"has the shape {values.shape}", mend))
    table = _table("q", {f"q{j + 1}": column for j, column in enumerate(values.T)})
    rows = np.flatnonzero(~np.isfinite(values).all(axis=1)).tolist()
    mend = "a pose needs all its joints"
    table.add_faults(rows, ["a joint is not a number"] * len(rows), [mend] * len(rows))
    return table


def _points(points: Any, file: CampaignFile) -> Table:
    if _is_frame(points):
        return seen_rows(_framed(points, "points", point_columns(file)))
    values = np.asarray(points, dtype=float)
    if values.ndim not in (2, 3) or values.shape[-1] != 3:
        raise InputError(Fault("points", f"has the shape {values.shape}", "(N, 3) or (N, T, 3) [m]"))
    values = values[:, None] if values.ndim == 2 else values
    names = list(file.targets) or [f"T{k + 1}" for k in range(values.shape[1])]
    if len(names) != values.shape[1]:
        what = f"{values.shape[1]} targets, but {len(names)} are declared"
        raise InputError(Fault("points", what, "one for each"))
    pose, target = np.nonzero(np.isfinite(values).all(axis=2))
    table = _table("points", dict(zip("xyz", values[pose, target].T, strict=True)))
    table.texts |= {"pose_id": [str(i + 1) for i in pose], "target": [names[k] for k in target]}
    return table


def _table(name: str, numbers: dict[str, Any]) -> Table:
    rows = len(next(iter(numbers.values())))
    labels = {key: key for key in numbers}
    return Table(Path(name), np.arange(1, rows + 1), numbers, labels=labels)


def _is_frame(data: Any) -> bool:
    """A data frame of pandas or polars, or a mapping of columns."""
    return hasattr(data, "columns") or isinstance(data, Mapping)


def _framed(frame: Any, name: str, wanted: Sequence[Column]) -> Table:
    """The table that the frame's own text would be: column names state units, as in a file."""
    header = [str(column) for column in (frame if isinstance(frame, Mapping) else frame.columns)]
    columns = [[_cell(value) for value in frame[column]] for column in header]
    return parse_table(table_text(header, zip(*columns, strict=True)), Path(name), Layout(), wanted)


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return number_text(float(value), 17) if isinstance(value, float | np.floating) else str(value)
