"""What comes beside a new robot: a campaign to fill in, and a README of the next steps."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..files.toml import toml_key
from ..robot.new_robot import NewRobot
from .guess import Guessed, Misfit, guess_both, guess_points, guess_poses

MOST_TARGETS = 8  # with a place for each in the template
LACKING = "# NOT FOUND: "
POINTS = "pose_id,target,x_mm,y_mm,z_mm\n"


def template_files(
    robot: NewRobot,
    folder: Path,
    poses: Path | None = None,
    points: Path | None = None,
    misfit: Misfit = lambda _, __: np.inf,
) -> dict[Path, str]:
    """`campaign.toml` and `README.md` for the new robot's folder, and both tables with their headers alone.

    poses, points: tables that there are already; their layout is guessed and written into `campaign.toml`.
    misfit: [m] of points (N, 3) [m] and the robot at joints (N, n) [rad, m], where both are in one table.
    """
    joints = robot.chain.joints
    both, carried, names = None, list[str](), list[str]()
    if poses is not None and points is not None and poses.resolve() == points.resolve():
        both = guess_both(poses, joints, misfit)
    columns = [f"q{i}_{'deg' if joint.kind == 'revolute' else 'mm'}" for i, joint in enumerate(joints, 1)]
    files = {Path("README.md"): _README.format(name=robot.name, flange=robot.flange.flange)}
    if poses is None:
        files[Path("poses.csv")] = ",".join(["pose_id", *columns]) + "\n"
        told = _POSES.format(
            mapping=", ".join(f'{name} = "J{i}"' for i, name in enumerate(columns, 1)),
            first=columns[0],
            other="rad" if joints[0].kind == "revolute" else "m",
        )
    else:
        joints_told = both[0] if both else guess_poses(poses, joints)
        told, carried = _section(poses, folder, joints_told), joints_told.payloads
        names = joints_told.ids
    if points is None:
        files[Path("points.csv")] = POINTS
        seen, targets = _POINTS, ["T1"]
    else:
        guessed = both[1] if both else guess_points(points, names)
        seen, targets = _section(points, folder, guessed), guessed.targets or ["T1"]
    in_order = ", ".join(joint.name for joint in joints)
    filled = {"poses": told, "points": seen, "targets": _targets(targets), "payloads": _payloads(carried)}
    files[Path("campaign.toml")] = _TOML.format(robot=robot.name, joints=in_order, **filled)
    return files


def _targets(names: Sequence[str]) -> str:
    """A place to fill in for each target, as far as they are few."""
    told = [
        f"# [targets.{toml_key(name)}]\n# xyz_mm = [0.0, 0.0, 100.0]"
        for name in (names if len(names) <= MOST_TARGETS else names[:1])
    ]
    told[0] += "      # about where it sits in the flange's frame; absent = unknown"
    return "\n".join(told)


def _payloads(names: Sequence[str]) -> str:
    """A place to fill in for each payload that the poses name, declared so that the campaign can be read."""
    if not names:
        return _PAYLOAD
    told = [f"{LACKING}what {', '.join(names)} weigh{'s' * (len(names) == 1)}: 0 kg until you say it here"]
    told += [
        f"[payloads.{toml_key(name)}]\nmass_kg = 0.0                   # TODO\n"
        "com_mm  = [0.0, 0.0, 0.0]       # TODO, in the flange's frame"
        for name in names
    ]
    return "\n".join(told)


def _section(table: Path, folder: Path, guessed: Guessed) -> str:
    """The keys of a table whose layout was guessed."""
    file = Path(os.path.relpath(table.resolve(), folder.resolve())).as_posix()
    lines = [f"file = {_value(file)}", "# Guessed from the file; `workbench check` says whether it fits."]
    lines += [f"{key} = {_value(value)}" for key, value in guessed.keys.items()]
    if guessed.lacking:
        has = f"; the file has: {', '.join(filter(None, guessed.header))}" if guessed.header else ""
        why = f" ({guessed.why})" if guessed.why else ""
        say = " Say them under columns." if guessed.header or guessed.keys else ""
        lines.append(f"{LACKING}{', '.join(guessed.lacking)}{why}{has}.{say}")
    return "\n".join(lines)


def _value(value: Any) -> str:
    """A value as TOML has it, tables in one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml_key(key)} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return json.dumps(value, ensure_ascii=False)


_TOML = """\
# What was measured. All keys: docs/files/campaign.md of the workbench.
schema = 1
title  = "{robot}"
robot  = "{robot}.toml"

# What the controller was told, a row per pose. Joints in order: {joints}
# Where you have them, more columns tell more: dir1 ... (+1, -1: side from which a joint came), payload, t_s,
# temp_degC, tau1_Nm ... (torque of each drive, from its current: 3 % is enough), fx_N fy_N fz_N
# mx_Nm my_Nm mz_Nm (what pulls at the arm from outside, at the flange's origin, on the base's axes)
[poses]
{poses}

# What the instrument saw, in its own frame
[points]
{points}

{targets}

# [noise]
# sigma_mm = 0.03                 # of the instrument, per axis; absent = estimated from repeated poses

# [tool]
# mass_kg = 5.0
# com_mm  = [0.0, 0.0, 50.0]      # in the flange's frame

{payloads}
"""

_PAYLOAD = """\
# [payloads.heavy]                # named in the column `payload` of the poses
# mass_kg = 20.0
# com_mm  = [0.0, 0.0, 150.0]"""

_POSES = """\
file = "poses.csv"
# separator = ";"     # decimal = ",", skip = 4, header = false, comment = "//", encoding = "latin-1"
# columns = {{ {mapping} }}
# A sign that the controller counts the other way: {first} = "-J1". Another unit than the name says:
# units = {{ {first} = "{other}" }}"""

_POINTS = """\
file = "points.csv"
# template = "spatial-analyzer"   # or "spatial-analyzer-csv", "leica", "polyworks"
# columns = { pose_id = 1, target = 2, x_mm = 3, y_mm = 4, z_mm = 5 }   # number (1 = first) or header name
# wide = { T1 = ["X1", "Y1", "Z1"], T2 = ["X2", "Y2", "Z2"] }           # targets side by side"""

_README = """\
# {name}

Made by `workbench init`. The robot is `{name}.toml`, with `{name}.urdf` beside it.

1. `workbench check {name}.toml` draws it and says what is not known. Is the flange `{flange}` right? Fill in
   gear ratios and stiffness in `{name}.toml` where you know them, and under `[controller]` how its controller
   counts the joints.
2. `workbench plan {name}.toml --poses 60 --out poses.csv` proposes poses to measure. Or use what you have:
   put the controller's joints into `poses.csv` and the instrument's points into `points.csv`, or name your
   own files and columns in `campaign.toml`.
3. `workbench check campaign.toml` reads both, fits the instrument's frame and shows which points look wrong.
4. `workbench diagnose campaign.toml --out found` says what is wrong and why: open `found/index.html`.
5. `workbench compensate PATH.csv --model found/model.toml` corrects a path, joints and frames as in
   `{name}.urdf`. With `--format krl` (or rapid, ls, val3, urscript) it writes a program for the controller:
   state `[controller]` for that, in `{name}.toml` before step 4, or in `found/model.toml`; without it the
   program has joints and frames as the URDF has them, and says so.
"""
