"""The files of a plan that is driven: poses, a campaign to fill in, programs that stand still at each
pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from shlex import quote

import numpy as np

from ...campaign import Campaign
from ...campaign.write import campaign_text, own_robot, poses_text
from ...correction.conditions import carried, conditions_of
from ...correction.programs import Format, Program, measuring_program
from .block import Drive
from .reach import Reach

COMMENTS = (
    "A plan of `workbench plan`. Measure it, put what the instrument saw into points.csv (pose_id, target,",
    "x_mm, y_mm, z_mm), and say",
)


def table_files(drive: Drive, reach: Reach, folder: Path, before: str = "") -> dict[Path, bytes]:
    """`poses.csv` and `campaign.toml` by their paths in the folder, with the robot where it is one's own.
    before: what was measured already, as a command names it: both are diagnosed together."""
    records = replace(proposed(drive.records, reach), cell=reach.cell)
    blank = np.full_like(records.poses.q, np.nan)  # columns to fill in
    if drive.torque:
        records = records.with_poses(torque=blank)
    if drive.warmth and records.poses.temperature is None:
        records = records.with_poses(temperature=blank[:, 0])
    return {
        folder / "poses.csv": poses_text(records).encode(),
        folder / "campaign.toml": campaign_text(folder, records, comments(drive, folder, before)).encode(),
        **{path: text.encode() for path, text in own_robot(folder, records.robot).items()},
    }


def comments(drive: Drive, folder: Path, before: str) -> tuple[str, ...]:
    """What a `campaign.toml` says of how it is measured, and which columns are planned only."""
    measured = " ".join(filter(None, (before, quote(str(folder / "campaign.toml")))))
    poses = drive.records.poses
    planned = ["t_s (when)"]
    planned += [] if poses.temperature is None else ["temp_degC (how warm the arm was)"]
    planned += ["fx_N ... (how it was pulled)"] if poses.wrench.any() else []
    columns = ", ".join(planned)
    return (
        *COMMENTS,
        f"  workbench diagnose {measured}",
        f"Planned, not measured, in poses.csv: {columns}. Put in what was so, or take the column out.",
        drive.measured,
        *drive.block_lines,
    )


def proposed(records: Campaign, reach: Reach) -> Campaign:
    """With the direction into which each reflector is to open, where the plan chose one."""
    turned = {} if reach.sight is None else reach.sight.proposals
    return replace(
        records, targets=tuple(replace(t, opens=turned.get(t.name, t.opens)) for t in records.targets)
    )


def programs(
    drive: Drive, format: Format, share: float, stem: str, as_urdf: bool = False
) -> dict[str, Program]:
    """A measuring program for each block of the drive, by its name. Raises `InputError`."""
    poses, out = drive.records.poses, {}
    for number, block in enumerate(drive.blocks, 1):
        name = f"{stem}_{block.name}" if block.name else stem
        inside = slice(block.start, block.stop)
        made = measuring_program(
            drive.records.robot,
            poses.q[inside],
            format,
            drive.still_s,
            sides=poses.side[inside] if poses.side is not None else None,
            via=drive.via[inside],
            name=name,
            load=carried(conditions_of(drive.records, block.state.payload)),
            share=share,
            as_urdf=as_urdf,
        )
        said = () if drive.plainly else (f"block {number} of {len(drive.blocks)}", *block.state.lines)
        out[name] = replace(made, notes=(*map(_remark, (*said, drive.measured)), *made.notes))
    return out


def _remark(text: str) -> str:
    """On one line, in letters that every controller reads."""
    return " ".join(text.replace(";", ",").split()).encode("ascii", "replace").decode()
