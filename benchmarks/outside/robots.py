"""Robots that `workbench` does not bring along: five made here, five changed from its models.

The made ones are of the build of an ABB IRB 2600, a Stäubli TX90, a UR16, an arm of seven joints and a SCARA;
masses, centres and stiffnesses are guesses of the right order.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

DEGREE = 3.141592653589793 / 180


@dataclass(frozen=True)
class Link:
    """A joint and its link, as written in the URDF: m, kg; limits in degrees (sliding: m)."""

    origin: str
    axis: str
    lower: float
    upper: float
    mass: float
    centre: str
    sliding: bool = False


@dataclass(frozen=True)
class Made:
    """`payload`, kg; `rpy` turns the flange; per joint, or unknown: `stiffness`, N·m/rad, `ratio` of the
    gear, `repeatability`, rad; `pose_repeatability`, mm, as of a data sheet, or unknown.
    """

    name: str
    title: str
    payload: float
    links: tuple[Link, ...]
    rpy: str = "0 0 0"
    stiffness: tuple[float, ...] = ()
    ratio: tuple[float, ...] = ()
    repeatability: tuple[float, ...] = ()
    pose_repeatability: str = ""


BASE = Link("", "", 0, 0, 30, "0 0 0.1")
MADE = (
    Made(
        "irb2600like",
        "IRB 2600-like",
        15,
        (
            Link("0 0 0.445", "0 0 1", -175, 175, 75, "0.05 0 -0.08"),
            Link("0.15 0 0", "0 1 0", -95, 155, 45, "0 0.01 0.32"),
            Link("0 0 0.7", "0 1 0", -175, 75, 42, "0.08 0 0.07"),
            Link("0 0 0.115", "1 0 0", -200, 200, 13, "0.42 0 0"),
            Link("0.795 0 0", "0 1 0", -120, 120, 3.2, "0.02 0 0"),
            Link("0.085 0 0", "1 0 0", -200, 200, 0.8, "-0.01 0 0"),
        ),
        rpy="0 1.570796 0",
        stiffness=(6e5, 8e5, 5e5, 8e4, 6e4, 3e4),
        ratio=(168, 180, 154, 98, 85, 60),
        repeatability=(5e-6,) * 3 + (1.2e-5,) * 3,
    ),
    Made(
        "tx90like",
        "TX90-like",
        7,
        (
            Link("0 0 0.478", "0 0 1", -175, 175, 30, "0.01 0 -0.05"),
            Link("0.05 0 0", "0 1 0", -130, 147, 26, "0 0.03 0.2"),
            Link("0 0.05 0.425", "0 1 0", -145, 145, 18, "0 0 0.06"),
            Link("0 0 0", "0 0 1", -200, 200, 9, "0 0 0.24"),
            Link("0 0 0.425", "0 1 0", -115, 140, 2.5, "0 0 0.02"),
            Link("0 0 0.1", "0 0 1", -200, 200, 0.4, "0 0 -0.01"),
        ),
        pose_repeatability="0.03",
    ),
    Made(
        "ur16like",
        "UR16-like",
        14,
        (
            Link("0 0 0.1807", "0 0 1", -180, 180, 7.37, "0 0.02 -0.03"),
            Link("0 0.176 0", "0 1 0", -180, 180, 10.45, "0.21 0 0"),
            Link("0.4784 -0.137 0", "0 1 0", -155, 155, 4.32, "0.19 0 0.01"),
            Link("0.36 0.135 0", "0 1 0", -180, 180, 2.18, "0 0.01 0"),
            Link("0 0 -0.11985", "0 0 1", -180, 180, 2.03, "0 0.01 0"),
            Link("0 0.11655 0", "0 1 0", -180, 180, 0.9, "0 -0.02 0"),
        ),
        rpy="-1.570796 0 0",
        ratio=(101,) * 6,
        pose_repeatability="0.05",
    ),
    Made(
        "sevenlike",
        "seven joints",
        10,
        (
            Link("0 0 0.36", "0 0 1", -170, 170, 7, "0 -0.03 0.0"),
            Link("0 0 0", "0 1 0", -115, 115, 6.5, "0 0.02 0.15"),
            Link("0 0 0.42", "0 0 1", -165, 165, 4, "0 0.03 0"),
            Link("0 0 0", "0 -1 0", -115, 115, 4.5, "0 0.0 0.14"),
            Link("0 0 0.4", "0 0 1", -165, 165, 2.4, "0 0.02 -0.1"),
            Link("0 0 0", "0 1 0", -115, 115, 2.6, "0 0 0.02"),
            Link("0 0 0.126", "0 0 1", -170, 170, 0.6, "0 0 -0.02"),
        ),
        stiffness=(6e4, 6e4, 4e4, 4e4, 2.5e4, 1.5e4, 1.5e4),
        ratio=(160,) * 4 + (100,) * 3,
        repeatability=(5e-6,) * 7,
    ),
    Made(
        "scaralike",
        "SCARA",
        3,
        (
            Link("0 0 0.4", "0 0 1", -140, 140, 12, "0.2 0 0.02"),
            Link("0.4 0 0", "0 0 1", -145, 145, 9, "0.2 0 0.05"),
            Link("0.4 0 0", "0 0 -1", 0, 0.3, 2, "0 0 0.1", sliding=True),
            Link("0 0 -0.1", "0 0 1", -180, 180, 0.5, "0 0 0"),
        ),
        pose_repeatability="0.02",
    ),
)


@dataclass(frozen=True)
class Changed:
    """A model of the project with all its lengths and masses times a number."""

    model: str
    name: str
    payload: float
    lengths: float
    masses: float


CHANGED = (
    Changed("ur10", "ur10s", 6, 0.85, 0.7),
    Changed("irb120", "irb120x", 6, 1.7, 4.0),
    Changed("lrmate200id", "lrmatex", 8, 1.4, 2.5),
    Changed("kr120", "kr120h", 110, 1.0, 1.12),
    Changed("rx170", "rx170h", 30, 1.0, 1.08),
)


def _link(name: str, link: Link) -> str:
    """A link whose inertia is a cube's."""
    side = max(0.05, link.mass ** (1 / 3) * 0.08)
    inertia = link.mass * side * side / 3
    moments = " ".join(
        f'{key}="{inertia:.6g}"' if key in ("ixx", "iyy", "izz") else f'{key}="0"'
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    return (
        f'<link name="{name}"><inertial><origin xyz="{link.centre}" rpy="0 0 0"/><mass value="{link.mass}"/>'
        f"<inertia {moments}/></inertial></link>"
    )


def _joint(number: int, link: Link) -> str:
    kind, unit = ("prismatic", 1) if link.sliding else ("revolute", DEGREE)
    parent = f"arm{number - 1}" if number > 1 else "base"
    limits = f'lower="{link.lower * unit:.6f}" upper="{link.upper * unit:.6f}"'
    return (
        f'<joint name="a{number}" type="{kind}"><origin xyz="{link.origin}" rpy="0 0 0"/>'
        f'<parent link="{parent}"/><child link="arm{number}"/><axis xyz="{link.axis}"/>'
        f'<limit {limits} effort="1000" velocity="3"/></joint>'
    )


def _write_made(robot: Made, folder: Path) -> None:
    count = len(robot.links)
    links = [_link(f"arm{number}", link) for number, link in enumerate(robot.links, 1)]
    joints = [_joint(number, link) for number, link in enumerate(robot.links, 1)]
    flange = (
        f'<joint name="flange_fix" type="fixed"><origin xyz="0 0 0" rpy="{robot.rpy}"/>'
        f'<parent link="arm{count}"/><child link="flange"/></joint>'
    )
    head = ['<?xml version="1.0"?>', f'<robot name="{robot.name}">', _link("base", BASE)]
    urdf = [*head, *links, '<link name="flange"/>', *joints, flange, "</robot>"]
    (folder / f"{robot.name}.urdf").write_text("\n".join(urdf), encoding="utf-8")
    said = ["schema = 1", f'name = "{robot.name}"', f'title = "{robot.title}"', f'urdf = "{robot.name}.urdf"']
    pose = robot.pose_repeatability
    said += ['flange = "flange"', f"pose_repeatability_mm = {pose}" if pose else ""]
    for joint in range(count):
        said += ["[[joints]]", f'name = "a{joint + 1}"']
        said += [f"stiffness = {robot.stiffness[joint]:.1f}"] if robot.stiffness else []
        said += [f"gear_ratio = {robot.ratio[joint]:.1f}"] if robot.ratio else []
        said += [f"repeatability = {robot.repeatability[joint]:.2e}"] if robot.repeatability else []
    (folder / f"{robot.name}.toml").write_text("\n".join(said) + "\n", encoding="utf-8")


def _scaled(words: str, by: float) -> str:
    return " ".join(f"{float(word) * by:.6g}" for word in words.split())


def _write_changed(robot: Changed, models: Path, folder: Path) -> None:
    """The model without shapes and controller, scaled."""
    tree = ElementTree.parse(models / robot.model / f"{robot.model}.urdf")
    for link in tree.getroot().iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass, inertia, origin = (inertial.find(name) for name in ("mass", "inertia", "origin"))
        mass.set("value", f"{float(mass.get('value')) * robot.masses:.6g}")
        for key, value in inertia.attrib.items():
            moment = float(value) * robot.masses * robot.lengths * robot.lengths
            inertia.set(key, f"{moment:.8g}")
        if origin is not None:
            origin.set("xyz", _scaled(origin.get("xyz"), robot.lengths))
    for joint in tree.getroot().iter("joint"):
        origin = joint.find("origin")
        if origin is not None:
            origin.set("xyz", _scaled(origin.get("xyz"), robot.lengths))
    tree.write(folder / f"{robot.name}.urdf")
    said = (models / robot.model / f"{robot.model}.toml").read_text(encoding="utf-8")
    for table in ("[controller]", "[controller.loop]", "[source]"):
        said = said.split(table)[0]
    said = re.sub(r"^name( *)= .*$", rf'name\1= "{robot.name}"', said, count=1, flags=re.MULTILINE)
    said = re.sub(r"^urdf( *)= .*$", rf'urdf\1= "{robot.name}.urdf"', said, flags=re.MULTILINE)
    (folder / f"{robot.name}.toml").write_text(said, encoding="utf-8")


def write_robots(models: Path, folder: Path) -> None:
    """Writes NAME/NAME.toml and NAME/NAME.urdf of all ten into `folder`."""
    for robot in (*MADE, *CHANGED):
        (folder / robot.name).mkdir(parents=True, exist_ok=True)
        if isinstance(robot, Made):
            _write_made(robot, folder / robot.name)
        else:
            _write_changed(robot, models, folder / robot.name)
