"""What stands in a TOML is of the kind that its key has: no text or truth value is a number."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from workbench.campaign.file import NoiseData, PosesFile, TargetData
from workbench.files.faults import InputError
from workbench.robot.description import load_robot
from workbench.robot.find import find_robot
from workbench.robot.schema import EffectRecord, JointData, LoadData


@pytest.mark.parametrize(
    ("table", "values", "told"),
    [
        (NoiseData, {"sigma_mm": True}, "is true, not a number"),
        (NoiseData, {"sigma_mm": "0.03"}, "is '0.03', not a number"),
        (NoiseData, {"pose": "yes"}, "is 'yes', not true or false"),
        (TargetData, {"xyz_mm": [150, True, 50]}, "is true, not a number"),
        (TargetData, {"fixed": 1}, "is 1, not true or false"),
        (LoadData, {"mass_kg": "12"}, "is '12', not a number"),
        (PosesFile, {"file": "a.csv", "skip": "0"}, "is '0', not a number"),
        (PosesFile, {"file": "a.csv", "columns": {"q1": 0}}, "columns count from 1"),
        (EffectRecord, {"cause": "backlash", "values": {"width": "1"}}, "is '1', not a number"),
    ],
)
def test_texts_and_truth_values_are_no_numbers(table, values, told):
    with pytest.raises(ValidationError, match=told) as caught:
        table(**values)
    assert caught.value.error_count() == 1


def test_whole_numbers_are_numbers_and_columns_have_either():
    assert NoiseData(sigma_mm=1).sigma_mm == 1.0
    assert JointData(name="a", stiffness=10_000).stiffness == 10_000
    assert PosesFile(file="a.csv", columns={"q1": 2, "q2": "-J2"}).columns == {"q1": 2, "q2": "-J2"}


def robot_with(tmp_path: Path, text: str, name: str = "mine") -> Path:
    """The cylindrical robot under another name, with more in its TOML."""
    toml = find_robot("cylindrical")
    urdf = tmp_path / "cylindrical.urdf"
    urdf.write_text(toml.with_name("cylindrical.urdf").read_text())
    said = toml.read_text().replace('name    = "cylindrical"', f'name    = "{name}"', 1)
    (tmp_path / "mine.toml").write_text(said + text)
    return tmp_path / "mine.toml"


@pytest.mark.parametrize("name", ["../../mine", "my robot", "a/b", ".hidden"])
def test_a_robots_name_is_one_of_a_file(tmp_path, name):
    assert load_robot(str(robot_with(tmp_path, ""))).name == "mine"
    with pytest.raises(InputError, match=r"line 3: name: is no name of a file") as caught:
        load_robot(str(robot_with(tmp_path, "", name)))
    assert len(caught.value.faults) == 1


def test_a_joint_or_link_is_stated_once(tmp_path):
    twice = '\n[[links]]\nname = "link_2"\n' * 2
    with pytest.raises(InputError, match=r"links\.link_2: is there 2 times; keep one table"):
        load_robot(str(robot_with(tmp_path, twice)))
