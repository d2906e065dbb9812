"""Every number of every sound file, beyond what is built or measured, and at the edge of it."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from cases import DIAGNOSE, SIMULATE, TINY_TOML, TINY_URDF, Case, seeds  # noqa: E402
from runner import run_case  # noqa: E402

from workbench.files.faults import InputError  # noqa: E402
from workbench.robot.description import Robot, load_robot  # noqa: E402
from workbench.robot.rigid_plant import arrays  # noqa: E402

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
EXTREMES = ("1e308", "1e-320")
MOST = 24  # numbers of a table: its first rows
CALLS = {
    "tiny.toml": SIMULATE,
    "tiny.urdf": SIMULATE,
    "model.toml": ("simulate", "model.toml", "--random", "2", "--payload", "heavy", "--json"),
    "joints.csv": ("compensate", "joints.csv", "--model", "model.toml", "--payload", "heavy"),
    "tool.csv": ("compensate", "tool.csv", "--model", "model.toml"),
    "poses.csv": ("simulate", "tiny.toml", "--poses", "poses.csv", "--json"),
    "campaign.toml": DIAGNOSE,
}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return seeds(tmp_path_factory.mktemp("sound"))


@pytest.mark.parametrize("name", CALLS)
def test_an_extreme_number_anywhere_is_refused_or_answered(
    tmp_path: Path, sound: dict[str, str], name: str
) -> None:
    text, ended = sound[name], []
    places = [*NUMBER.finditer(text)]
    for place in places[:MOST] if name.endswith(".csv") else places:
        for value in EXTREMES:
            files = {**sound, name: text[: place.start()] + value + text[place.end() :]}
            case = Case(name, f"{text[: place.start()][-40:]} -> {value}", CALLS[name])
            ended.append(run_case(len(ended), case, files, tmp_path / "case"))
    assert [(one.case.what, one.wrong, one.said) for one in ended if one.wrong] == []
    assert {one.status for one in ended} <= {"0", "2"}
    assert len(ended) >= 30
    assert any("beyond all measure" in one.said or "greater than" in one.said for one in ended)


def test_a_slide_kilometres_out_is_left_out_of_the_loads_too(tmp_path: Path, sound: dict[str, str]) -> None:
    header, first, second, *rest = sound["more_poses.csv"].splitlines()
    cells = second.split(",")
    cells[3] = "1e9"  # mm: with this pose the loaded arm would find no rest
    files = {**sound, "points.csv": sound["more_points.csv"]}
    files["poses.csv"] = "\n".join([header, first, ",".join(cells), *rest]) + "\n"
    ended = run_case(0, Case("poses.csv", "a slide 1000 km out", DIAGNOSE), files, tmp_path / "case")
    assert (ended.status, ended.wrong) == ("0", "")


def loaded(folder: Path, old: str, new: str) -> Robot:
    assert old in TINY_URDF + TINY_TOML
    (folder / "tiny.urdf").write_text(TINY_URDF.replace(old, new, 1))
    (folder / "tiny.toml").write_text(TINY_TOML.replace(old, new, 1))
    robot = load_robot(folder / "tiny.toml")
    arrays(robot)
    return robot


def test_limits_that_hold_nothing_are_none(tmp_path: Path) -> None:
    robot = loaded(tmp_path, 'lower="-3.2" upper="3.2" effort="1" velocity="1"',
                   'lower="-1e+16" upper="1e+16" effort="1.7976931348623157e308" velocity="inf"')  # fmt: skip
    joint = robot.joints[0]
    assert (joint.lower, joint.upper) == (-math.inf, math.inf)
    assert joint.effort == joint.velocity == math.inf


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('velocity="1"', 'velocity="-1"', "limit of velocity is -1"),
        ('effort="1"', 'effort="-1"', "limit of effort is -1"),
        ('upper="3.2"', 'upper="nan"', "is not a number"),
        ('xyz="0 0 0.4"', 'xyz="0 0 1e16"', "beyond all measure"),
        ('xyz="0 0 0.4"', 'xyz="0 0 nan"', "not finite"),
        ('value="20"', 'value="1e16"', "beyond all measure"),
        ("stiffness = 1e6", "stiffness = 1e16", "joints.stiffness: 1e+16 is beyond all measure"),
        ("gear_ratio = 100.0", "gear_ratio = -1e16", "joints.gear_ratio: -1e+16 is beyond all measure"),
        ("gear_ratio = 100.0", "gear_ratio = 1e-9", "no gear has such a ratio"),
        ("gravity = [0.0, 0.0, -9.8]", "gravity = [0.0, 0.0, 1e400]", "gravity: inf is beyond all measure"),
        ("stiffness = 1e6", f"stiffness = 1{'0' * 400}", "an integer of 401 digits is beyond all measure"),
        ("stiffness = 1e6", f"stiffness = 1{'0' * 5000}", "is not TOML"),
        ("stiffness = 1e6", "stiffness = 1e-10", "greater than or equal to 0.000000001"),
    ],
)
def test_what_no_robot_has_is_refused_with_its_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(InputError, match=r"tiny\.(urdf|toml)") as refused:
        loaded(tmp_path, old, new)
    assert said in str(refused.value)
