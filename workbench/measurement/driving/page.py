"""The page of a plan: what it brings, how it is driven, what was checked; and the scene beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from ...report.folder import json_bytes
from ...report.markup import render
from ...report.numbers import MISSING
from ...report.study import Tile
from .block import Drive
from .reach import REFLECTOR, Reach
from .scene import scene

FILES = {"scene.html": "3-D scene", "poses.csv": "Poses", "campaign.toml": "Campaign", "plan.json": "Numbers"}


@dataclass(frozen=True, eq=False)
class PlanPage:
    """What the page shows. title, headline: of the plan; worth: what it brings, a line each; gain:
    information per hour over that of random poses, None where unknown; data: for `plan.json`, the inputs'
    hashes among it."""

    title: str
    headline: str
    worth: Sequence[str]
    gain: float | None
    drive: Drive
    reach: Reach
    data: dict[str, Any]


def page_files(page: PlanPage) -> dict[str, bytes]:
    """`index.html`, `scene.html` and `plan.json`."""
    text = render(
        "plan.html",
        title=page.title,
        files=FILES,
        headline=page.headline,
        tiles=_tiles(page),
        worth=page.worth,
        driven=page.drive.lines,
        blocks=_blocks(page.drive),
        checked=_checked(page.reach),
        **_table(page.drive),
        inputs=page.data["inputs"].items(),
        version=version("robot-workbench"),
    )
    return {
        "index.html": text.encode(),
        "scene.html": scene(page.drive, page.reach).encode(),
        "plan.json": json_bytes(page.data),
    }


def _tiles(page: PlanPage) -> list[Tile]:
    drive = page.drive
    own = int((~drive.check).sum())
    tiles = [
        Tile("Time", "", f"{drive.total_s / 60:.0f}", "min", drive.spent),
        Tile("Poses", "", f"{own}", "", f"and {int(drive.check.sum())} returns to a check pose"),
    ]
    if page.gain is not None:
        tiles.append(Tile("Information per hour", "", f"{page.gain:.1f}", "×", "that of random poses"))
    return tiles


def _blocks(drive: Drive) -> list[list[str]]:
    return [
        [
            f"{number}",
            block.preparing or MISSING,
            block.state.load,
            block.state.pull or "none",
            block.state.warmth or "as it is",
            f"{block.stop - block.start}",
            f"{drive.begins_s(block) / 60:.0f} min",
        ]
        for number, block in enumerate(drive.blocks, 1)
    ]


def _checked(reach: Reach) -> list[str]:
    """What was looked at, what could not be."""
    driving, carried = reach.cell.driving, [one.name for one in reach.cell.obstacles]
    floor = "no floor" if driving.floor_mm is None else f"a floor at {driving.floor_mm:g} mm"
    if reach.reflectors:
        carried.append(f"reflectors as cubes of {1e3 * REFLECTOR:g} mm ({', '.join(reach.reflectors)})")
    bodies = ", ".join([f"{len(reach.hulls)} convex hulls", floor, *carried])
    lines = [
        f"Every pose, the approach to it and the straight joint motion to the next: {bodies}; all keep "
        f"{driving.clearance_mm:g} mm from each other.",
    ]
    if reach.collisions.ignored:
        pairs = "; ".join(f"{a} and {b}" for a, b in reach.collisions.ignored)
        lines.append(f"Not checked, since they touch as they are built: {pairs}.")
    if reach.sight is None:
        lines.append("Not checked: what the instrument sees. No [instrument] says where it stands.")
    else:
        cone = np.degrees(reach.sight.cone)
        lines.append(
            f"The instrument sees {', '.join(reach.sight.names)} at every pose: no body is in the way, and "
            f"the ray comes in within {cone:.0f}° of where the reflector opens."
        )
        for name, way in reach.sight.proposals.items():
            x, y, z = way
            lines.append(
                f"Mount {name} so that it opens towards ({x:g}, {y:g}, {z:g}) in the frame that carries it."
            )
    if not any(one.on != "base" for one in reach.cell.obstacles):
        lines.append('Not checked: tool and payload. Give them as [[obstacles]] with on = "flange".')
    lines.append("Not known here: cables, fences, people. Drive it slowly the first time.")
    return lines


def _table(drive: Drive) -> dict[str, Any]:
    """Every standstill: name, minute, load, pull and warmth where the plan has these, joints in degrees or
    mm, how many poses the way leads by."""
    records, robot = drive.records, drive.records.robot
    units = np.array([1e3 if joint.kind == "prismatic" else 180 / np.pi for joint in robot.joints])
    names = [f"{joint.name} [{'mm' if joint.kind == 'prismatic' else '°'}]" for joint in robot.joints]
    time = records.poses.time
    assert time is not None
    states = [block.state for block in drive.blocks for _ in range(block.start, block.stop)]
    state = {"Load": [one.load for one in states]}
    if any(one.pull for one in states):
        state["Pull"] = [one.pull or "none" for one in states]
    if any(one.warmth for one in states):
        state["Arm"] = [one.warmth for one in states]
    rows = [
        [
            records.poses.ids[i],
            f"{time[i] / 60:.1f}",
            *(column[i] for column in state.values()),
            *(f"{value:.1f}" for value in records.poses.q[i] * units),
            f"by {len(drive.via[i])}" if drive.via[i] else "",
        ]
        for i in range(len(records.poses))
    ]
    head = ["Pose", "Minute", *state, *names, "Detour"]
    first = 2 + len(state)
    return {"head": head, "rows": rows, "numbers": (1, *range(first, first + len(names)))}
