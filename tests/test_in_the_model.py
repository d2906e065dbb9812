"""A robot diagnosed again with the model of an earlier diagnosis: what is new beside what was known."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import found, measured, named

from workbench.campaign import Campaign, join
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.cli.arguments import conditions
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.result import Diagnosis
from workbench.effects.records import parse_effect, record, stated_effects
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.model_file import write_fit
from workbench.identification.noise import Covariance
from workbench.report.content import content
from workbench.report.terminal import short_verdict
from workbench.robot.description import Robot, load_robot
from workbench.robot.schema import LoadData
from workbench.simulation.virtual_campaign import Truth, simulate

COM = (0.1, 0.0, 0.05)  # m


def extended(campaign: Campaign, *effects: str) -> Campaign:
    """The campaign of the robot as an earlier diagnosis described it."""
    job = problem_of(campaign)
    records = tuple(record(*parse_effect(text, job)) for text in effects)
    return replace(campaign, robot=replace(campaign.robot, effects=records))


def of_joint(diagnosis: Diagnosis, cause: str):
    (finding,) = [one for one in diagnosis.causes if one.cause == cause]
    return finding


def test_a_cause_that_grew_is_told_from_the_nominal_robot_on():
    """Joint 2 was 20 % more compliant by the model, and is 80 % by now: its stiffness is 1/1.8."""
    campaign = measured(effects=("joint_compliance:joint=joint_2,relative=0.8",))
    diagnosis = found(extended(campaign, "joint_compliance:joint=joint_2,relative=0.2"))
    finding = of_joint(diagnosis, "joint_compliance")
    assert finding.parameters[0].value == pytest.approx(0.6, abs=0.1)
    less = float(finding.sentence.split("than the model: ")[1].split(" %")[0])
    assert less == pytest.approx(100 * (1 - 1 / 1.8), abs=3)
    assert "“joint_2 is softer than the model: 16.7 % less stiffness (" in finding.sentence
    assert not finding.taken_back
    assert diagnosis.headline.startswith("Found: ")
    assert "model as given" in short_verdict(diagnosis, None)
    assert "causes in it: joint compliance in joint_2;" in diagnosis.facts["Model"]
    assert content(diagnosis)["stages"][0]["name"] == "model as given"


def test_a_cause_that_has_gone_is_not_told_to_be_there():
    """The gear that the model has running out was replaced."""
    campaign = measured(loads=(), poses=80, targets=2)
    diagnosis = found(
        extended(campaign, "gear_kinematic_error:joint=joint_2,order=247,amplitude=2e-4,phase=0.4")
    )
    assert named(diagnosis)["gear_kinematic_error", "joint_2"] == "named"
    finding = of_joint(diagnosis, "gear_kinematic_error")
    assert finding.taken_back
    assert finding.sentence.startswith("No longer as the model has it (“The gear of joint_2 errs by 200 µrad")
    assert diagnosis.headline.startswith("No longer as the model has it: gear kinematic error in joint_2")


def test_a_nominal_robot_has_nothing_to_begin_with():
    diagnosis = found(measured(effects=("joint_compliance:joint=joint_2,relative=0.8",)))
    assert "Model" not in diagnosis.facts
    assert "model has a part" not in of_joint(diagnosis, "joint_compliance").sentence
    assert content(diagnosis)["start"] == "nominal model"


def with_loads(robot: Robot, mass: float, heavy: float) -> Campaign:
    """20 poses under a tool [kg], with and without a payload [kg] that every model calls heavy."""
    q = random_poses(robot, 20, np.random.default_rng(1))
    names = ["", "heavy"] * 10
    plan = planned(robot, q, payloads={"heavy": (heavy, COM)}, payload=names, tool=(mass, COM))
    return simulate(plan, Truth(sigma=3e-5))


def written(campaign: Campaign, path) -> Robot:
    job = problem_of(campaign)
    noise = Covariance(np.full(job.seen.shape, 3e-5), np.zeros(6), np.ones(20))
    write_fit(path, fit(Model(job, (), tuple(stated_effects(job))), start_state(job), noise))
    return load_robot(path)


@pytest.mark.parametrize(
    ("tool", "heavy", "kept"),
    [
        (60.0, 200.0, {"tool", "heavy", "light"}),
        (85.0, 200.0, {"heavy", "light"}),
        (60.0, 150.0, {"tool", "light"}),
    ],
)
def test_what_was_found_of_a_load_stays_with_that_load(tmp_path, tool, heavy, kept):
    """A second campaign under another tool, or another load of the same name: what the first found of its own
    is not told of these, and what it found of a load that is not there this time stays."""
    first = load_robot("kr500")
    tools = LoadData(mass_kg=60.0, com_mm=(100.0, 0.0, 50.0))
    loads = {
        "heavy": LoadData(mass_kg=200.0, com_mm=(100.0, 0.0, 50.0)),
        "light": LoadData(mass_kg=20.0, com_mm=(100.0, 0.0, 50.0)),
    }
    job = problem_of(planned(first, np.zeros((3, 6)), tool=(60.0, COM),
                             payloads={"heavy": (200.0, COM), "light": (20.0, COM)},
                             payload=["", "heavy", "light"]))  # fmt: skip
    effects = tuple(
        record(*parse_effect(f"payload:payload={name},variant=mass,mass=5", job))
        for name in ("tool", "heavy", "light")
    )
    model = replace(first, tool=tools, payloads=loads, effects=effects)
    second = written(with_loads(model, tool, heavy), tmp_path / "model.toml")
    assert {item.payload for item in second.effects} == kept
    assert second.tool is not None
    assert second.tool.mass_kg == tool
    assert {name: load.mass_kg for name, load in second.payloads.items()} == {"heavy": heavy, "light": 20.0}


def test_a_tool_among_others_is_carried_on_its_own_too(tmp_path):
    """What was found of one of several tools holds for a later campaign with that tool, and for a path."""
    arm, campaigns = load_robot("kr500"), []
    for name, mass in (("one", 60.0), ("two", 260.0)):
        plan = planned(arm, random_poses(arm, 20, np.random.default_rng(len(name))), tool=(mass, COM))
        seen = simulate(plan, Truth(sigma=3e-5))
        campaigns.append(replace(seen, path=tmp_path / name / "campaign.toml"))
    job = problem_of(join(campaigns))
    heavier = parse_effect("payload:payload=tool (two),variant=mass,mass=60", job)
    noise = Covariance(np.full(job.seen.shape, 3e-5), np.zeros(6), np.ones(40))
    write_fit(tmp_path / "model.toml", fit(Model(job, (), (heavier,)), start_state(job), noise))
    model = load_robot(tmp_path / "model.toml")
    known = [
        [effect.where.payload for effect, _ in prepare(replace(c, robot=model)).known_effects]
        for c in campaigns
    ]
    assert known == [[], ["tool (two)"]]
    told = conditions(str(tmp_path / "model.toml"), "", campaigns[1])
    assert (told.payload, told.payload_mass, told.tool_mass) == ("tool (two)", 260.0, 0.0)
    nothing = replace(campaigns[1], tool_mass=100.0)  # another tool
    told = conditions(str(tmp_path / "model.toml"), "", nothing)
    assert (told.payload, told.payload_mass, told.tool_mass) == ("", 0.0, 100.0)
