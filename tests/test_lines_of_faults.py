"""Faults of a TOML that its schema does not see have their line too."""

import pytest
from campaign_example import TOML, write_example

from workbench.campaign import load_campaign
from workbench.files.faults import Fault, InputError
from workbench.files.toml_place import with_lines
from workbench.robot.description import load_robot

ROBOT = """\
schema = 1
name = "arm"
urdf = "tiny.urdf"
flange = "tool0"

[[joints]]
name = "nowhere"

[[links]]
name = "no_link"
bending_stiffness = 5e7

[geometry.elsewhere]
tx = 0.1
"""


def line_of(text, part):
    return next(i for i, line in enumerate(text.splitlines(), 1) if part in line)


def test_of_a_robot(tmp_path):
    write_example(tmp_path / "one")
    path = tmp_path / "one" / "robot" / "arm.toml"
    path.write_text(ROBOT)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    assert [fault.place for fault in caught.value.faults] == [
        f"{path} line {line_of(ROBOT, '[[joints]]')}: joints.nowhere",
        f"{path} line {line_of(ROBOT, '[[links]]')}: links.no_link",
        f"{path} line {line_of(ROBOT, 'geometry.elsewhere')}: geometry.elsewhere",
    ]


@pytest.mark.parametrize(
    ("more", "key", "line"),
    [
        ('[targets.T9]\nxyz_mm = [0.0, 0.0, 1.0]\non = "nowhere"\n', "targets.T9.on", 'on = "nowhere"'),
        ("[targets.T9]\nfixed = true\n", "targets.T9.fixed", "fixed = true"),
        ('[targets."T 9"]\nfixed = true\n', 'targets."T 9".fixed', "fixed = true"),
    ],
)
def test_of_a_campaign(tmp_path, more, key, line):
    path = write_example(tmp_path / "one", TOML + more)
    with pytest.raises(InputError) as caught:
        load_campaign(path)
    assert caught.value.faults[0].place == f"{path} line {line_of(TOML + more, line)}: {key}"


def test_a_robot_that_is_not_there(tmp_path):
    text = TOML.replace("robot/tiny.toml", "robot/teeny.toml")
    assert text != TOML
    path = write_example(tmp_path / "one", text)
    with pytest.raises(InputError) as caught:
        load_campaign(path)
    assert caught.value.faults[0].place.startswith(f"{path} line {line_of(text, 'teeny')}: robot = ")


def test_what_has_no_line_stays_as_it_is(tmp_path):
    path = tmp_path / "one.toml"
    path.write_text("a = 1\n[[b]]\nname = 'x'\n")
    for place in (
        f"{path} line 3: b",
        f"{path}: b.y",
        f"{path}: c",
        "other.toml: a",
        str(path),
        f"{path}: 'a",
    ):
        fault = Fault(place, "is wrong")
        assert with_lines([fault], path) == [fault]
    assert with_lines([Fault(f"{path}: b.x.z", "is wrong")], path)[0].place == f"{path} line 2: b.x.z"
