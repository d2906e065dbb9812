"""path.csv as a table: the columns that it may have, and what can be wrong with them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from ..campaign.file import QUATERNION as QUATERNION_NAMES
from ..campaign.file import WRENCH_COLUMNS, joint_column
from ..files.faults import Fault
from ..files.tables import Column, Table, number_text
from ..robot.description import Robot
from ..robot.kinematics import Array

FARTHEST = 1e6  # m, beyond all measure
SHORTEST = 1e-9  # s, from line to line
MOST_JOINTS = 20  # looked for where no robot says how many
TIME = Column("t", ("time",), required=True, mend="every sample needs its time")
POSITION = tuple(Column(name, ("length",)) for name in ("x", "y", "z"))
QUATERNION = tuple(Column(name) for name in QUATERNION_NAMES)
ABC = tuple(Column(name, ("angle",)) for name in ("a", "b", "c"))
TEMPERATURE = Column("temp", ("temperature",))
DWELL = Column("dwell", ("time",), mend="write 0 where the robot does not stop")


def path_columns(robot: Robot | None) -> list[Column]:
    """The columns of `path.csv`; without a robot its joints may turn or slide."""
    if robot is None:
        joints = [Column(f"q{index}", ("angle", "length")) for index in range(1, MOST_JOINTS + 1)]
    else:
        joints = [joint_column(f"q{index}", joint) for index, joint in enumerate(robot.joints, 1)]
    return [TIME, *POSITION, *QUATERNION, *ABC, *WRENCH_COLUMNS, TEMPERATURE, DWELL, *joints]


def names(*columns: Column) -> list[str]:
    """Their names without units."""
    return [column.name for column in columns]


def stacked(table: Table, wanted: Iterable[str]) -> Array:
    """(N, n) columns [SI] beside each other."""
    return np.stack([table.numbers[name] for name in wanted], axis=1)


def check_samples(table: Table, robot: Robot | None, fewest: int) -> list[str]:
    """The joint columns (none: tool poses); everything that is wrong becomes a fault of the table."""
    _check_time(table, fewest)
    joints = _joint_names(table, robot)
    poses = [name for name in names(*POSITION, *QUATERNION, *ABC) if name in table.numbers]
    if joints and poses:
        one, other = (
            next(table.labels[name] for name in given if name in table.labels) for given in (joints, poses)
        )
        what = f"has joints ({one}, ...) and tool poses ({other}, ...)"
        table.faults.append(Fault(str(table.path), what, "a path is one or the other: take one out"))
    elif not joints and not poses:
        mend = "give q1_deg ... , or x_mm y_mm z_mm with qw qx qy qz or with a_deg b_deg c_deg"
        table.faults.append(Fault(str(table.path), "has neither joints nor tool poses", mend))
    elif poses:
        _check_poses(table)
    return joints


def _joint_names(table: Table, robot: Robot | None) -> list[str]:
    """The joint columns; faults where one between is missing or the robot has more."""
    given = [name for name in table.numbers if name[0] == "q" and name[1:].isdigit()]
    if not given:
        return []
    count = max(int(name[1:]) for name in given) if robot is None else len(robot.joints)
    names = [f"q{index}" for index in range(1, count + 1)]
    absent = [name for name in names if name not in given]
    if absent:
        table.faults.append(
            Fault(str(table.path), f"no column {', '.join(absent)}", "a path needs all joints")
        )
    for name in table.unused:
        if robot is not None and re.match(r"q\d+(_|$)", name):
            what = f"column {name!r}, but {robot.name} has {count} joints"
            table.faults.append(Fault(str(table.path), what, "take it out, or name the right robot"))
    return names


def _check_time(table: Table, fewest: int) -> None:
    """Time rises; of a run that lies behind, every line is told. A dwell is no negative time."""
    time = table.numbers.get("t")
    if time is None:
        return
    reached = np.fmax.accumulate(time)
    back = np.flatnonzero(time[1:] < reached[:-1] + SHORTEST) + 1
    whats = [
        f"{table.labels['t']} is {number_text(now)} s, after {number_text(before)} s"
        for now, before in zip(time[back], reached[back - 1], strict=True)
    ]
    table.add_faults(back.tolist(), whats, ["time has to rise from line to line"] * len(back))
    if (dwell := table.numbers.get("dwell")) is not None:
        table.add_fault_where(dwell < 0, "dwell", "is negative", DWELL.mend)
        long = np.flatnonzero((dwell[:-1] > np.diff(time) + SHORTEST) & (np.diff(time) > 0))
        said = [
            f"rests {number_text(rest)} s, {number_text(left)} s before the next line"
            for rest, left in zip(dwell[long], np.diff(time)[long], strict=True)
        ]
        mend = "t_s counts the rest as well: let the next line come later"
        table.add_faults(long.tolist(), said, [mend] * len(long))
    if len(time) < fewest:
        table.faults.append(Fault(str(table.path), "has one sample only", "a path needs two at least"))


def _check_poses(table: Table) -> None:
    for name in names(*POSITION):
        beyond = np.flatnonzero(np.abs(table.numbers.get(name, np.zeros(0))) > FARTHEST).tolist()
        whats = [f"{table.labels[name]} is beyond {FARTHEST / 1e3:g} km" for _ in beyond]
        table.add_faults(beyond, whats, ["mend the number"] * len(beyond))
    quaternion, angles = (any(name in table.numbers for name in names(*some)) for some in (QUATERNION, ABC))
    _need(table, POSITION)
    if quaternion and angles:
        mend = "keep qw qx qy qz or a_deg b_deg c_deg"
        table.faults.append(Fault(str(table.path), "gives the orientation twice", mend))
    elif angles:
        _need(table, ABC)
    elif quaternion:
        if _need(table, QUATERNION):
            with np.errstate(over="ignore"):
                length = np.linalg.norm(stacked(table, names(*QUATERNION)), axis=1)
            off = np.flatnonzero(np.abs(length - 1.0) > 1e-3)
            whats = [f"qw qx qy qz has length {length[row]:.4g}, not 1" for row in off]
            table.add_faults(off.tolist(), whats, ["is one of the four wrong, or their order?"] * len(off))
    else:
        mend = "give qw qx qy qz, or a_deg b_deg c_deg (KUKA: R = Rz(a) Ry(b) Rx(c))"
        table.faults.append(Fault(str(table.path), "has no orientation", mend))


def _need(table: Table, columns: Sequence[Column]) -> bool:
    """Whether all of these columns are there; a fault where not."""
    absent = [column.written[0] for column in columns if column.name not in table.numbers]
    if absent:
        what = f"no column {', '.join(absent)}"
        table.faults.append(Fault(str(table.path), what, "a tool pose needs place and orientation"))
    return not absent
