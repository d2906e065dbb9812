"""The files of a plan that is driven: poses, a campaign to fill in, programs that stand still at each
pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...campaign import Campaign
from ...campaign.write import campaign_text, own_robot, poses_text
from ...correction.conditions import carried, conditions_of
from ...correction.programs import Format, Program, measuring_program
from .drive import Drive
from .reach import Reach

COMMENTS = (
    "A plan of `workbench plan`. Measure it, put what the instrument saw into points.csv (pose_id, target,",
    "x_mm, y_mm, z_mm), and say `workbench diagnose campaign.toml`. Column t_s of poses.csv is planned: put",
    "the times in at which it was measured, or take it out.",
)


def table_files(drive: Drive, reach: Reach, folder: Path) -> dict[Path, bytes]:
    """`poses.csv` and `campaign.toml` by their paths in the folder, with the robot where it is one's own."""
    records = replace(proposed(drive.records, reach), cell=reach.cell)
    return {
        folder / "poses.csv": poses_text(records).encode(),
        folder / "campaign.toml": campaign_text(folder, records, (*COMMENTS, drive.measured)).encode(),
        **{path: text.encode() for path, text in own_robot(folder, records.robot).items()},
    }


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
    for block in drive.blocks:
        name = f"{stem}_{block.name}" if block.name else stem
        inside = slice(block.start, block.stop)
        payload = drive.records.payload_names[block.payload]
        made = measuring_program(
            drive.records.robot,
            poses.q[inside],
            format,
            drive.still_s,
            sides=poses.side[inside] if poses.side is not None else None,
            via=drive.via[inside],
            name=name,
            load=carried(conditions_of(drive.records, payload)),
            share=share,
            as_urdf=as_urdf,
        )
        out[name] = replace(made, notes=(drive.measured, *made.notes))
    return out
