"""A tiny robot and campaign as files, for tests of what comes in: two turning joints and a sliding one."""

from __future__ import annotations

from pathlib import Path

import pytest

from workbench.campaign import load_campaign
from workbench.files.faults import InputError

URDF = """<robot name="tiny">
  <link name="world_mount"/><link name="link_1"/><link name="link_2"/><link name="link_3"/>
  <link name="tool0"/>
  <joint name="joint_1" type="revolute"><parent link="world_mount"/><child link="link_1"/>
    <axis xyz="0 0 1"/><limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>
  <joint name="joint_2" type="revolute"><parent link="link_1"/><child link="link_2"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="rail" type="prismatic"><parent link="link_2"/><child link="link_3"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="link_3"/><child link="tool0"/></joint>
</robot>
"""
ROBOT = 'schema = 1\nname = "tiny"\nurdf = "tiny.urdf"\nflange = "tool0"\n'
TOML = """schema = 1
title = "Tiny"
robot = "robot/tiny.toml"
[poses]
file = "poses.csv"
[points]
file = "points.csv"
[targets.T1]
xyz_mm = [100.0, 0.0, 50.0]
[targets.T2]
on = "link_2"
[payloads.heavy]
mass_kg = 250.0
com_mm = [150.0, 0.0, 10.0]
"""
POSES = "pose_id,q1_deg,q2_rad,q3_mm\na,10,0.5,100\nb,-20,0.25,200\nc,30,-0.5,0\n"
POINTS = (
    "pose_id,target,x_mm,y_mm,z_mm\na,T1,1000,2000,3000\na,T2,1,2,3000\nb,T1,-1.5,2e3,0.25\nc,T1,4,5,600\n"
)
BARE = """schema = 1
robot = "robot/tiny.toml"
[poses]
file = "poses.csv"
{poses}[points]
file = "points.csv"
{points}"""


def write_robot(folder: Path) -> Path:
    """The tiny robot under `folder`/robot; returns its TOML."""
    robot = folder / "robot"
    robot.mkdir(parents=True, exist_ok=True)
    (robot / "tiny.urdf").write_text(URDF)
    (robot / "tiny.toml").write_text(ROBOT)
    return robot / "tiny.toml"


def write_example(folder: Path, toml: str = TOML, poses: str = POSES, points: str = POINTS) -> Path:
    """The campaign in `folder`; returns its TOML."""
    write_robot(folder)
    (folder / "poses.csv").write_text(poses)
    (folder / "points.csv").write_text(points)
    (folder / "campaign.toml").write_text(toml)
    return folder / "campaign.toml"


def faults(path: Path) -> list[str]:
    """All faults of a campaign, with the folder taken out."""
    with pytest.raises(InputError) as caught:
        load_campaign(path)
    return [str(fault).replace(f"{path.parent}/", "") for fault in caught.value.faults]
