"""Load a campaign: `campaign.toml` and its two tables, joined on `pose_id`."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from ..files.faults import Fault, InputError, read_text
from ..files.tables import Layout, Table, parse_table, read_table, suggest
from ..files.toml_place import with_lines
from ..robot.description import Robot, load_robot
from ..robot.find import find_robot, list_robots
from .assemble import assemble, some
from .check import check_points, check_poses, check_targets
from .controller_joints import by_the_controllers_names, joints_in_order, stated, to_urdf
from .data import Campaign
from .file import ANGLES, CampaignFile, pose_columns, read_campaign_file
from .point_table import number_points, number_poses, read_points, undecided
from .program_joints import joint_table
from .six_dof import check_one_body, with_six_dof
from .turns import told_by_the_robot


def load_campaign(path: str | Path) -> Campaign:
    """Load and check a campaign.

    path: its campaign.toml, or the folder with it; the tables that it names lie beside it. Columns carry
    units (`q1_deg`, `x_mm`), the campaign is in rad, m, kg, N and s. Raises `InputError` with all faults of
    all its files at once.

    >>> import numpy as np
    >>> from workbench import Truth, load_robot, planned, random_poses, simulate
    >>> from workbench import load_campaign, write_campaign
    >>> robot = load_robot("cylindrical")
    >>> plan = planned(robot, random_poses(robot, 12, np.random.default_rng(0)))
    >>> path = write_campaign("measured", simulate(plan, Truth(sigma=2e-5)))
    >>> campaign = load_campaign("measured/campaign.toml")
    >>> campaign.poses.q.shape, campaign.points.shape, campaign.noise_sigma
    ((12, 3), (12, 3, 3), 2e-05)
    """
    path = campaign_file(path)
    try:
        return _loaded(path)
    except InputError as error:
        raise InputError(with_lines(error.faults, path)) from None


def _loaded(path: Path) -> Campaign:
    """The campaign of a campaign.toml. Raises `InputError`, its faults without lines in that file."""
    file = read_campaign_file(path)
    points = read_points(path.parent / file.points.file, file, f"{path}: points")
    faults = [*points.faults, *check_points(points, file.noise.sigma_mm is not None)]
    try:
        robot = _robot(path, file)
    except InputError as error:
        raise InputError([*error.faults, *faults]) from None
    poses = _poses_table(path, file, robot)
    faults = [
        *check_targets(path, file, robot),
        *poses.faults,
        *check_poses(poses, robot, file.payloads),
        *faults,
    ]
    if faults:
        raise InputError(faults)
    if file.poses.joints == "controller":
        to_urdf(poses, stated(robot, f"{path}: poses.joints"))
    try:
        if not undecided(points, file):
            return joined(path, file, robot, poses, points)
        number(poses, points)
        file, said = told_by_the_robot(file, robot, poses, points)
        points = read_points(path.parent / file.points.file, file, f"{path}: points")
        for name in ANGLES:  # of those that are left out everything is said already
            points.numbers.pop(name, None)
        campaign = joined(path, file, robot, poses, points)
        return replace(campaign, warnings=(said, *campaign.warnings))
    except NotInOrder:
        named = read_points(path.parent / file.points.file, file, f"{path}: points", named=True)
        raise InputError(named.faults) from None


def campaign_file(path: str | Path) -> Path:
    """The campaign.toml in a folder, if that has one; else the path itself."""
    inside = Path(path) / "campaign.toml"
    return inside if inside.is_file() else Path(path)


class NotInOrder(Exception):
    """The points name no poses, and are not as many."""


def number(poses: Table, points: Table) -> bool:
    """Names poses and points by their order where the tables do not; whether the points were.

    Raises `InputError` without any points; `NotInOrder` where there is nothing to join them by."""
    number_poses(poses)
    if not len(points):
        what = "not one point was seen: x, y and z are empty in every row"
        raise InputError(Fault(str(points.path), what, "are `columns` right?"))
    in_order = "pose_id" not in points.texts
    if in_order and not number_points(points, poses):
        raise NotInOrder
    return in_order


def joined(path: Path, file: CampaignFile, robot: Robot, poses: Table, points: Table) -> Campaign:
    """The campaign of tables without faults, joined in order where they name no poses.

    Raises `InputError`; `NotInOrder` where there is nothing to join the points by.
    """
    in_order = number(poses, points)
    if faults := _no_match(poses, points):
        raise InputError(faults)
    campaign = assemble(path, file, robot, poses, points)
    check_one_body(campaign, file)
    said = (f"{points.path}: no column pose_id: the points are joined to the poses in order",) * in_order
    return with_six_dof(replace(campaign, warnings=(*said, *campaign.warnings)))


def _poses_table(path: Path, file: CampaignFile, robot: Robot) -> Table:
    """The table of poses, its joints as they stand there."""
    table, place = path.parent / file.poses.file, f"{path}: poses"
    layout: Layout = file.poses
    columns = pose_columns(robot)
    if file.poses.joints == "controller":
        convention = stated(robot, f"{place}.joints")
        layout = by_the_controllers_names(table, file.poses, convention)
        columns = pose_columns(robot, joints_in_order(robot, convention))
    if file.poses.template is None:
        return read_table(table, layout, columns, place)
    try:
        text = joint_table(read_text(table, layout.encoding), file.poses.template, table)
    except InputError as error:
        return Table(table, faults=list(error.faults))
    return parse_table(text, table, layout, columns, place)


def _robot(path: Path, file: CampaignFile) -> Robot:
    """The robot that the campaign names."""
    try:
        found = find_robot(file.robot, beside=path.parent)
    except InputError as error:
        (fault,) = error.faults
        close = suggest(file.robot, [item.stem for item in list_robots()])
        mend = f"{close} {fault.mend}" if close else fault.mend
        raise InputError(Fault(f"{path}: robot = {file.robot!r}", fault.what, mend)) from None
    return load_robot(found)


def _no_match(poses: Table, points: Table) -> list[Fault]:
    told, seen = poses.texts["pose_id"], points.texts["pose_id"]
    if set(told) & set(seen):
        return []
    what = f"no pose_id is among those of {poses.path}: here {some(seen)}, there {some(told)}"
    mend = (
        "both tables name a pose by the same pose_id; where `columns` leave it out, poses count from 1, and "
        "points stand in the order of the poses"
    )
    if any(part in told for name in seen[:1] for part in re.split(r"[\W_]+", name)):
        mend = "name poses alike in both; part names that hold pose and target into two columns"
    return [Fault(str(points.path), what, mend)]
