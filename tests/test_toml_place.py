"""Faults of a TOML say their line and what may stand there."""

import pytest

from workbench import InputError, load_robot
from workbench.campaign.file import CampaignFile, read_campaign_file
from workbench.files.toml_place import keys_at, line_of, places
from workbench.robot.schema import RobotFile

ROBOT = """schema = 1
name = "arm"
urdf = "arm.urdf"
flange = "tool0"

[[joints]]
name = "j1"
stiffness = 1e5
[[joints]] # the second
name = "j2"
"stiffness" = -1

[controller]
names = ["A1", "A2"]
[[controller.couplings]]
joint = "A1"
on = "A2"
factr = 2

[payloads."big one"]
mass_kg = 3
colour = "red"
[source]
one = [
  [0, 1],
]
two = "a = b" # in a text
"""


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (("schema",), 1),
        (("joints", 0, "stiffness"), 8),
        (("joints", 1), 9),
        (("joints", 1, "stiffness"), 11),
        (("joints", 1, "damping"), 9),
        (("controller", "couplings", 0, "factr"), 18),
        (("controller", "couplings", 0, "factor"), 15),
        (("payloads", "big one", "colour"), 22),
        (("source", "two"), 27),
        (("gravity",), None),
    ],
)
def test_the_line_of_a_place_or_of_the_table_around_it(place, line):
    assert line_of(place, places(ROBOT)) == line


@pytest.mark.parametrize(
    ("model", "place", "some"),
    [
        (RobotFile, (), {"schema", "urdf", "compensator"}),
        (RobotFile, ("joints", 3), {"name", "stiffness", "tilt_stiffness"}),
        (RobotFile, ("compensator",), {"precharge", "free_length"}),
        (RobotFile, ("payloads", "heavy"), {"mass_kg", "com_mm"}),
        (RobotFile, ("controller", "couplings", 0), {"joint", "on", "factor"}),
        (CampaignFile, ("known", "facts", 1), {"cause", "parameter", "std"}),
        (CampaignFile, ("targets", "T1"), {"xyz_mm", "on", "fixed"}),
    ],
)
def test_the_keys_that_may_stand_at_a_place(model, place, some):
    keys = keys_at(model, place)
    assert some <= set(keys)
    assert keys == sorted(set(keys))


def test_where_the_schema_does_not_say_no_key_is_known():
    assert keys_at(RobotFile, ("source", "kinematics")) == []
    assert keys_at(RobotFile, ("nothing", "at all")) == []


def test_a_robots_faults_have_line_and_mend(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(ROBOT.replace('flange = "tool0"\n', 'titel = "Arm"\n'), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_robot(path)
    said = str(caught.value).splitlines()
    assert f'{path}: flange: is missing; flange = "tool0", say: a link of the URDF' in said
    assert f"{path} line 4: titel: unknown key; did you mean 'title'?" in said
    assert any(line.startswith(f"{path} line 11: joints.1.stiffness: ") for line in said)
    assert f"{path} line 18: controller.couplings.0.factr: unknown key; did you mean 'factor'?" in said
    assert f"{path} line 22: payloads.big one.colour: unknown key; known here: com_mm, mass_kg" in said


def test_a_campaigns_faults_have_line_and_mend(tmp_path):
    path = tmp_path / "campaign.toml"
    path.write_text(
        'schema = 1\nrobot = "kr500"\n[poses]\nfile = "a.csv"\n[points]\n[targets.T1]\nxyz = [0, 0, 0]\n',
        "utf-8",
    )
    with pytest.raises(InputError) as caught:
        read_campaign_file(path)
    assert sorted(str(caught.value).splitlines()) == [
        f'{path} line 5: points.file: is missing; file = "poses.csv", say',
        f"{path} line 7: targets.T1.xyz: unknown key; did you mean 'xyz_mm'?",
    ]
