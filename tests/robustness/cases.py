# ruff: noqa: E501  # lists of data
"""Spoilt inputs, each from a number: files in a folder, and the command that is given them."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mutators import TABLE, TOML, URDF, VALUES, spoilt

from workbench.cli.main import main

TINY_URDF = """<robot name="tiny">
  <link name="world_mount"/>
  <link name="link_1"><inertial><origin xyz="0 0 0.2"/><mass value="20"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="link_2"><inertial><mass value="10"/>
    <inertia ixx="0.5" iyy="0.5" izz="0.5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="link_3"/><link name="tool0"/>
  <joint name="joint_1" type="revolute"><parent link="world_mount"/><child link="link_1"/>
    <origin xyz="0 0 0.4" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>
  <joint name="joint_2" type="revolute"><parent link="link_1"/><child link="link_2"/>
    <origin xyz="0.1 0 0.3"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="rail" type="prismatic"><parent link="link_2"/><child link="link_3"/>
    <origin xyz="0.5 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="link_3"/><child link="tool0"/></joint>
</robot>
"""
TINY_TOML = """schema = 1
name = "tiny"
title = "A tiny robot"
urdf = "tiny.urdf"
flange = "tool0"
gravity = [0.0, 0.0, -9.8]

[[joints]]
name = "joint_1"
stiffness = 1e6
gear_ratio = 100.0
rotor_inertia = 0.001

[[joints]]
name = "joint_2"
stiffness = 5e5
repeatability = 1e-5
tilt_stiffness = 1e6

[[links]]
name = "link_2"
bending_stiffness = 1e5

[payloads.heavy]
mass_kg = 20.0
com_mm = [10.0, 0.0, 50.0]
"""
MODEL = """
[geometry.joint_2]
tx = 0.0005
rz = 0.001

[[effects]]
cause = "gear_eccentricity"
joint = "joint_1"
variant = "1"
values = { amplitude = 0.0002, phase = 0.3 }

[[effects]]
cause = "joint_compliance"
joint = "joint_2"
values = { relative = 0.2 }
"""
CAMPAIGN = """schema = 1
title = "Tiny"
robot = "tiny.toml"

[poses]
file = "poses.csv"

[points]
file = "points.csv"

[targets.T1]
xyz_mm = [100.0, 0.0, 50.0]

[targets.T2]
xyz_mm = [0.0, 80.0, 20.0]
on = "flange"

[noise]
sigma_mm = 0.03

[tool]
mass_kg = 5.0
com_mm = [0.0, 0.0, 50.0]

[payloads.heavy]
mass_kg = 20.0
com_mm = [10.0, 0.0, 50.0]
"""
JOINT_PATH = "t_s,q1_deg,q2_deg,q3_mm\n" + "".join(f"{0.1 * i:g},{i},{5 + i},{100 + i}\n" for i in range(6))
TOOL_PATH = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "".join(
    f"{0.1 * i:g},{800 + i},{10 * i},700,1,0,0,0\n" for i in range(6)
)
SMALL = 4  # poses: read, placed, and refused before a fit
WHOLE = 16  # poses: diagnosed


@dataclass(frozen=True)
class Case:
    """kind: what is spoilt; what: how; arguments: of the command, which runs in the case's folder."""

    kind: str
    what: str
    arguments: tuple[str, ...]


def seeds(folder: Path) -> dict[str, str]:
    """The sound files, by name; the campaign is simulated."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {
        "tiny.urdf": TINY_URDF,
        "tiny.toml": TINY_TOML,
        "model.toml": TINY_TOML + MODEL,
        "campaign.toml": CAMPAIGN,
        "joints.csv": JOINT_PATH,
        "tool.csv": TOOL_PATH,
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    call = ["simulate", str(folder / "tiny.toml"), "--payload", "heavy", "--approach", "--hours", "1"]
    for poses, names in (
        (SMALL, ("poses.csv", "points.csv")),
        (WHOLE, ("more_poses.csv", "more_points.csv")),
    ):
        assert main([*call, "--random", str(poses // 2), "--out", str(folder / "made")]) == 0
        for name, table in zip(names, ("poses.csv", "points.csv"), strict=True):
            files[name] = (folder / "made" / table).read_text().replace("T3", "T2")
            files[name] = "\n".join(dict.fromkeys(files[name].splitlines())) + "\n"
    return files


Draw = Callable[[random.Random, dict[str, str]], Case]


def _file(name: str, ways: list, *arguments: str) -> Draw:  # type: ignore[type-arg]
    def draw(rng: random.Random, files: dict[str, str]) -> Case:
        files[name], how = spoilt(rng, files[name], ways)
        return Case(name, how, arguments)

    return draw


def _whole(name: str, ways: list) -> Draw:  # type: ignore[type-arg]
    """A campaign that is diagnosed to its end unless it is refused."""

    def draw(rng: random.Random, files: dict[str, str]) -> Case:
        for table in ("poses.csv", "points.csv"):
            files[table] = files[f"more_{table}"]
        files[name], how = spoilt(rng, files[name], ways)
        return Case(f"{name}, diagnosed", how, ("diagnose", "campaign.toml", "--json"))

    return draw


CALLS = [
    ("simulate", "tiny.toml", "--random", "2", "--payload", "a=5:1,2,3", "--tool", "3", "--sigma-mm", "0.1",
     "--geometry-mm", "0.1", "--geometry-mrad", "0.2", "--shots", "2", "--hours", "1", "--warm-degC", "5",
     "--effect", "backlash:joint=joint_1,half_width=1e-4", "--approach", "--seed", "3", "--out", "out"),
    ("simulate", "tiny.toml", "--grid", "joint_1=-10:10:3,rail=0:100:2", "--effect", "gear_ratio:joint=joint_2"),
    ("simulate", "tiny.toml", "--poses", "poses.csv", "--payload", "heavy", "--json"),
    ("compensate", "joints.csv", "--model", "model.toml", "--format", "csv", "--payload", "heavy", "--seed", "1"),
    ("compensate", "tool.csv", "--model", "model.toml", "--format", "krl", "--out", "out.src"),
    ("verify", "nothing.csv", "--model", "model.toml", "--truth", "tiny.toml", "--workers", "1", "--quick"),
    ("plan", "nothing.toml", "--poses", "5", "--tell", "gear_ratio,backlash", "--seed", "0", "--quick"),
    ("diagnose", "campaign.toml", "--test", "campaign.toml", "--seed", "1", "--out", "out"),
    ("study", "case", "gear_ratio/x"), ("robots", "--json"), ("causes",), ("demo", "--out", "tiny.toml"),
]  # fmt: skip
EFFECTS = [
    "", ":", "backlash", "backlash:", "backlash:joint", "backlash:joint=", "backlash:joint=joint_9", "unknown:joint=joint_1",
    "backlash:joint=joint_1,half_width=nan", "gear_ratio:joint=joint_1,relative=inf", "joint_map:joint=joint_1",
    "joint_compliance:joint=joint_2,relative=-1", "joint_compliance:joint=joint_2,relative=-2", "payload:payload=heavy,mass=-1e9",
    "link_mass:link=link_1,mass=1e300", "gear_kinematic_error:joint=joint_1,order=0,amplitude=1",
    "gear_kinematic_error:joint=joint_1,order=nan,amplitude=1", "gear_kinematic_error:joint=joint_1,order=1e300,amplitude=1",
    "thermal_growth:link=link_1,coefficient=1e308", "foundation:compliance=1e9", "tracker_scale:scale=1e300",
    "wrist_coupling:joint=joint_1,other=joint_1", "drift:rate=1", "gear_eccentricity:joint=joint_1,amplitude=100",
]  # fmt: skip


def _arguments(rng: random.Random, files: dict[str, str]) -> Case:
    call = list(rng.choice(CALLS))
    how = []
    for _ in range(rng.choice([1, 1, 2, 3])):
        i = rng.randrange(len(call) + 1)
        way = rng.choice(["value", "value", "value", "effect", "drop", "twice", "swap"])
        # a null byte is no argument that a process can get, and numbers of poses stay such that it ends
        value = rng.choice([v for v in VALUES if "\x00" not in v and v not in ("1e3", "1e5", "1e12", "360")])
        if way == "drop":
            del call[i : i + 1]
        elif way == "twice":
            call[i:i] = call[i : i + 2]
        elif way == "swap" and call:
            j = rng.randrange(len(call))
            call[i % len(call)], call[j] = call[j], call[i % len(call)]
        elif way == "effect" and call[:1] == ["simulate"]:
            call += ["--effect", rng.choice(EFFECTS)]
        else:
            call[i : i + 1] = [value]
        how.append(way)
    if call[:1] == ["demo"] or call[:2] in (["study", "all"], ["study", "blind"]):  # would run for minutes
        call = [*call, "--out", "tiny.toml"]
    return Case("command line", "+".join(how), tuple(call))


DIAGNOSE = ("diagnose", "campaign.toml", "--json")
SIMULATE = ("simulate", "tiny.toml", "--random", "2", "--json")
QUICK: list[tuple[int, Draw]] = [  # how often, and what
    (6, _file("points.csv", TABLE, *DIAGNOSE)),
    (6, _file("poses.csv", TABLE, *DIAGNOSE)),
    (6, _file("campaign.toml", TOML, *DIAGNOSE)),
    (3, _file("poses.csv", TABLE, "simulate", "tiny.toml", "--poses", "poses.csv", "--json")),
    (6, _file("tiny.toml", TOML, *SIMULATE)),
    (8, _file("tiny.urdf", URDF, *SIMULATE)),
    (3, _file("model.toml", TOML, "simulate", "model.toml", "--random", "2", "--payload", "heavy", "--json")),
    (2, _file("model.toml", TOML, "compensate", "joints.csv", "--model", "model.toml")),
    (
        3,
        _file("joints.csv", TABLE, "compensate", "joints.csv", "--model", "model.toml", "--payload", "heavy"),
    ),
    (2, _file("tool.csv", TABLE, "compensate", "tool.csv", "--model", "model.toml")),
    (8, _arguments),
]
LONG: list[tuple[int, Draw]] = [
    (1, _whole("points.csv", TABLE)),
    (1, _whole("poses.csv", TABLE)),
    (1, _whole("campaign.toml", TOML)),
    (1, _whole("tiny.toml", TOML)),
    (1, _whole("tiny.urdf", URDF)),
]


def draw(number: int, sound: dict[str, str], draws: list[tuple[int, Draw]]) -> tuple[Case, dict[str, str]]:
    """The case of a number, and its files."""
    rng, files = random.Random(number), dict(sound)
    (chosen,) = rng.choices([one for _, one in draws], [often for often, _ in draws])
    return chosen(rng, files), files
