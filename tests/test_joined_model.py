"""What a model of several campaigns is of: the tool that is mounted now, which is the last campaign's."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench import (
    Target,
    Truth,
    load_robot,
    planned,
    predict,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
    stated_conditions,
    write_fit,
)
from workbench.campaign import join
from workbench.campaign.planned import TARGETS
from workbench.campaign.stepped import split_campaign
from workbench.cli.main import main
from workbench.diagnosis.prepared import prepare
from workbench.files.faults import InputError
from workbench.identification.model_file import as_robot
from workbench.identification.prediction import posed
from workbench.measurement.design.prior_information import from_prepared, from_robot

TOOLS = (60.0, 90.0)  # kg
FARTHER = 0.07  # m: the second tool is longer
OF_FIRST = [1e3 * np.array(target.xyz) for target in TARGETS]


def campaigns(poses=(40, 25), tools=TOOLS, name="kr500"):
    """One robot with two tools, the first measured at more poses."""
    robot, rng = load_robot(name), np.random.default_rng(12)
    truth = Truth(geometry=random_geometry(problem_of(planned(robot, np.zeros((1, 6)))).arm, rng), sigma=3e-5)
    out = []
    for k, (count, mass) in enumerate(zip(poses, tools, strict=True)):
        places = [(x, y, z + k * FARTHER) for x, y, z in (target.xyz for target in TARGETS)]
        targets = [Target(f"T{i + 1}", place) for i, place in enumerate(places)]
        tool = (mass, (0.05, 0.0, 0.15))
        q = random_poses(robot, count, rng)
        plan = planned(robot, q, targets=targets, tool=tool, title=f"c{k + 1}")
        path = Path(f"c{k + 1}/campaign.toml")
        out.append(replace(simulate(plan, truth, seed=k), path=path))
    return out


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The model of both, as a file."""
    path = tmp_path_factory.mktemp("joined") / "model.toml"
    write_fit(path, prepare(campaigns()).geometry)
    return path


def places(robot):
    return [np.array(point.xyz_mm) for point in robot.uncertainty.points]


@pytest.mark.parametrize("first", [0, 1])
def test_a_model_of_several_campaigns_is_of_the_tool_of_the_last(first):
    each = campaigns()
    robot = as_robot(prepare([each[first], each[1 - first]]).geometry)
    assert robot.uncertainty.campaign == each[1 - first].title
    for place, other in zip(places(robot), OF_FIRST, strict=True):
        assert place[2] - other[2] == pytest.approx(1e3 * FARTHER * (1 - first), abs=1.0)
    assert robot.payloads[robot.mounted].mass_kg == pytest.approx(TOOLS[1 - first])


def test_where_the_last_shows_its_tool_too_seldom_it_is_the_one_measured_most():
    robot = as_robot(prepare(campaigns(poses=(40, 4))).geometry)
    assert robot.uncertainty.campaign == "c1"


def test_a_model_of_one_campaign_names_none():
    robot = as_robot(prepare(campaigns()[0]).geometry)
    assert (robot.uncertainty.campaign, robot.mounted) == ("", "")


def test_predict_says_whose_tool_it_is(model, tmp_path, capsys):
    said = "The points are those of the tool of c2: T1 (c2), T2 (c2), T3 (c2)."
    assert main(["predict", str(model), "--volume", "20", "--out", str(tmp_path / "a")]) == 0
    assert said in capsys.readouterr().out
    assert said in (tmp_path / "a" / "index.html").read_text(encoding="utf-8")
    assert main(["predict", str(model), "--volume", "20", "--out", str(tmp_path / "b"), "--json"]) == 0
    assert said in json.loads(capsys.readouterr().out)["notes"]


def test_poses_that_do_not_say_what_the_arm_carries_have_the_tool_that_is_mounted(model, tmp_path, capsys):
    robot = load_robot(model)
    q = random_poses(robot, 5, np.random.default_rng(0))
    told = posed(robot, q)
    assert (told.tool_mass + told.load_mass[told.poses.payload]).tolist() == pytest.approx([TOOLS[1]] * 5)
    named = predict(robot, q, "tool (c2)")
    assert np.array_equal(predict(robot, q).corrected, named.corrected)
    loads = stated_conditions(robot)
    assert (loads.payload, loads.payload_mass) == ("tool (c2)", pytest.approx(TOOLS[1]))
    made = "simulate", str(model), "--random", "4", "--out", str(tmp_path / "made")
    assert main(list(made)) == 0
    poses = (tmp_path / "made" / "poses.csv").read_text()
    assert poses.count("tool (c2)") == 4
    path = tmp_path / "path.csv"
    path.write_text(
        "t_s," + ",".join(f"q{j}_deg" for j in range(1, 7)) + "\n0,0,-70,90,5,45,0\n1,5,-70,90,5,45,0\n"
    )
    capsys.readouterr()
    assert main(["compensate", str(path), "--model", str(model), "--out", str(tmp_path / "out.csv")]) == 0
    assert "the arm is taken to carry tool (c2), the tool mounted last" in capsys.readouterr().err


def test_a_model_that_is_mounted_with_what_it_does_not_know_is_refused(model, tmp_path):
    text = model.read_text().replace('mounted = "tool (c2)"', 'mounted = "tool (c3)"')
    broken = model.with_name("broken.toml")
    broken.write_text(text)
    with pytest.raises(InputError, match=r"mounted: no payload 'tool \(c3\)'"):
        load_robot(broken)


def test_a_plan_mounts_what_goes_with_the_tool_that_is_mounted(model):
    prior = from_prepared(prepare(campaigns()))
    names = prior.problem.campaign.payload_names
    assert [names[i] for i in prior.mountable] == ["tool (c2)"]
    more = prior.with_payloads({"block": (10.0, (0.0, 0.0, 0.1))})
    names, load = more.problem.campaign.payload_names, more.problem.campaign.payloads["block"]
    assert [names[i] for i in more.mountable] == ["tool (c2)", "block"]
    assert load[0] == pytest.approx(TOOLS[1] + 10)
    alone = from_prepared(prepare(campaigns()[0]))
    assert alone.mountable.tolist() == [0]
    by_model = from_robot(load_robot(model))
    names = by_model.problem.campaign.payload_names
    assert [names[i] for i in by_model.mountable] == ["tool (c2)"]


def test_the_later_part_of_a_set_up_stands_behind_the_earlier():
    """The last set-up is the last campaign's, whose zeros and scale the model has."""
    both = join(campaigns())
    split = split_campaign(both, 20)
    assert split.setup_names == ("c1", "c1 after pose c1/20", "c2")
    assert np.unique(split.poses.setup, return_counts=True)[1].tolist() == [20, 20, 25]
    assert (np.diff(split.poses.setup) >= 0).all()
    assert split.of_campaign.tolist() == [0] * 40 + [1] * 25
