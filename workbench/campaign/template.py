"""What comes beside a new robot: a campaign to fill in, and a README of the next steps."""

from __future__ import annotations

from pathlib import Path

from ..robot.new_robot import NewRobot

POINTS = "pose_id,target,x_mm,y_mm,z_mm\n"


def template_files(robot: NewRobot) -> dict[Path, str]:
    """`campaign.toml` and `README.md`, and both tables with their headers alone."""
    joints = robot.chain.joints
    units = ["deg" if joint.kind == "revolute" else "mm" for joint in joints]
    columns = [f"q{i}_{unit}" for i, unit in enumerate(units, 1)]
    campaign = _TOML.format(
        robot=robot.name,
        joints=", ".join(joint.name for joint in joints),
        mapping=", ".join(f'{name} = "J{i}"' for i, name in enumerate(columns, 1)),
        first=columns[0],
        other="rad" if joints[0].kind == "revolute" else "m",
    )
    return {
        Path("campaign.toml"): campaign,
        Path("poses.csv"): ",".join(["pose_id", *columns]) + "\n",
        Path("points.csv"): POINTS,
        Path("README.md"): _README.format(name=robot.name, flange=robot.flange.flange),
    }


_TOML = """\
# What was measured. All keys: docs/files/campaign.md, or `workbench check` this file.
schema = 1
title  = ""
robot  = "{robot}.toml"

[poses]                           # what the controller was told, a row per pose
file = "poses.csv"
# Joints in order: {joints}
# separator = ";"                 # decimal = ",", header = false, comment = "//", encoding = "latin-1"
# columns = {{ {mapping} }}
# A sign that the controller counts the other way: {first} = "-J1". Another unit than the name says:
# units = {{ {first} = "{other}" }}

[points]                          # what the instrument saw, a row per point, in its own frame
file = "points.csv"
# template = "spatial-analyzer"   # or "spatial-analyzer-csv", "leica", "polyworks"
# columns = {{ pose_id = 1, target = 2, x_mm = 3, y_mm = 4, z_mm = 5 }}   # number (1 = first) or header name
# wide = {{ T1 = ["X1", "Y1", "Z1"], T2 = ["X2", "Y2", "Z2"] }}           # targets side by side

# [targets.T1]
# xyz_mm = [0.0, 0.0, 100.0]      # about where it sits in the flange's frame; absent = unknown

# [noise]
# sigma_mm = 0.03                 # of the instrument, per axis; absent = estimated from repeated poses

# [tool]
# mass_kg = 5.0
# com_mm  = [0.0, 0.0, 50.0]      # in the flange's frame

# [payloads.heavy]                # named in the column `payload` of the poses
# mass_kg = 20.0
# com_mm  = [0.0, 0.0, 150.0]
"""

_README = """\
# {name}

Made by `workbench init`. The robot is `{name}.toml`, with `{name}.urdf` beside it.

1. `workbench check {name}.toml` draws it and says what is not known. Is the flange `{flange}` right? Fill in
   gear ratios and stiffness in `{name}.toml` where you know them.
2. `workbench plan {name}.toml --poses 60 --out poses.csv` proposes poses to measure. Or use what you have:
   put the controller's joints into `poses.csv` and the instrument's points into `points.csv`, or name your
   own files and columns in `campaign.toml`.
3. `workbench check campaign.toml` reads both, fits the instrument's frame and shows which points look wrong.
4. `workbench diagnose campaign.toml --out found` says what is wrong and why: open `found/index.html`.
5. `workbench compensate PATH.csv --model found/model.toml --format krl` corrects a path.
"""
