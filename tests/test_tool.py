"""A tool that is not what was stated, or that nobody stated: named as what the flange always carries."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_cases import found, measured, named

from workbench.campaign import Campaign
from workbench.campaign.problem import Problem, problem_of
from workbench.diagnosis.result import Diagnosis
from workbench.effects.link_mass import LinkMass
from workbench.effects.payload import Payload
from workbench.effects.records import parse_effect, record, stated_effects
from workbench.identification.model import Model
from workbench.robot.schema import LoadData

COM = (0.15, 0.0, 0.10)  # m
TOOL = ("payload", "tool")
LINK_5 = "link_mass:link=link_5,mass_kg={:g},std=0"


def wave(problem: Problem) -> np.ndarray:
    """(N, n) [rad] what no form of the catalogue has: every joint errs a little, as a cube of a sine."""
    return 1.5e-5 * np.sin(problem.q + 0.3) ** 3


@cache
def mounted(mass: float, stated: float, name: str = "kr500", seed: int = 1) -> Campaign:
    """80 poses under a tool of `mass` [kg], of which the campaign says that it is `stated`."""
    campaign = measured(name, poses=80, loads=(), targets=2, seed=seed, joints=wave, tool=(mass, COM))
    return replace(campaign, tool_mass=stated, tool_com=np.array(COM if stated else (0.0, 0.0, 0.0)))


@cache
def of_tool(mass: float, stated: float, name: str = "kr500", seed: int = 1) -> Diagnosis:
    return found(mounted(mass, stated, name, seed))


def numbers(diagnosis: Diagnosis) -> dict[str, float]:
    """The parameters of what is said of the tool."""
    (finding,) = [one for one in diagnosis.causes if (one.cause, str(one.where)) == TOOL]
    return {p.name: p.value for p in finding.parameters}


def suspects(diagnosis: Diagnosis) -> set[tuple[str, str]]:
    """Causes and their rivals."""
    every = [*diagnosis.causes, *(rival for one in diagnosis.causes for rival in one.rivals)]
    return {(one.cause, str(one.where)) for one in every}


@pytest.mark.parametrize(("mass", "stated"), [(90.0, 60.0), (35.0, 60.0)])
def test_a_wrong_mass_of_the_tool_is_the_tool_s(mass, stated):
    diagnosis = of_tool(mass, stated)
    assert named(diagnosis) == {TOOL: "named"}
    assert numbers(diagnosis)["mass"] == pytest.approx(mass - stated, abs=6)
    word = "heavier" if mass > stated else "lighter"
    assert diagnosis.causes[0].sentence.startswith("The tool ")
    assert word in diagnosis.causes[0].sentence


def test_a_tool_that_nobody_stated_is_found_with_its_place():
    diagnosis = of_tool(120.0, 0.0)
    assert TOOL in suspects(diagnosis)
    assert suspects(diagnosis) <= {TOOL, ("link_mass", "link_6")}  # which moves with it
    finding = diagnosis.causes[0]
    assert numbers(diagnosis)["mass"] == pytest.approx(120, abs=15)
    shift = [numbers(diagnosis)[f"com_{axis}"] for axis in "xyz"]
    assert shift == pytest.approx(COM, abs=0.05)  # of all that is mounted, not of some of it
    assert "kg that nobody stated are mounted at the flange" in finding.sentence


@pytest.mark.parametrize(("wrong", "by"), [("tool", 30.0), ("load_1", 40.0)])
def test_of_tool_and_payload_that_are_always_mounted_together_either_may_be_wrong(wrong, by):
    """The heavier alone had been asked: a payload got the name for a tool, with certainty."""
    both = measured(poses=80, loads=(120.0,), targets=2, joints=wave, tool=(60.0, (-0.2, 0.1, 0.0)))
    loaded = both.some(np.flatnonzero(both.poses.payload == 1))
    if wrong == "tool":
        stated = replace(loaded, tool_mass=loaded.tool_mass - by)
    else:
        stated = replace(loaded, load_mass=loaded.load_mass - [0.0, by])
    said = suspects(found(stated))
    assert ("payload", wrong) in said
    assert said <= {TOOL, ("payload", "load_1"), ("link_mass", "link_6")}


def test_a_last_link_that_is_heavier_is_not_taken_for_another_link():
    case = measured(poses=80, loads=(), targets=2, effects=("link_mass:link=link_6,variant=mass,mass=40",))
    said = suspects(found(case))
    assert ("link_mass", "link_6") in said
    assert said <= {TOOL, ("link_mass", "link_6")}


@pytest.mark.parametrize(("mass", "name"), [(60.0, "kr500"), (0.0, "kr500"), (0.0, "6R")])
def test_a_tool_that_was_stated_rightly_is_not_suspected(mass, name):
    case = measured(name, poses=60, loads=(), targets=2, seed=2, tool=(mass, COM if mass else (0.0,) * 3))
    assert found(case).verdict == "nothing_missing"


def test_an_exact_mass_of_another_link_is_kept_to():
    case = mounted(90.0, 60.0)
    arm = problem_of(case).arm
    known = case.with_known([LINK_5.format(arm.mass[arm.slot_of_link("link_5")])])
    diagnosis = found(known)
    assert [fact.obeyed for fact in diagnosis.given] == [True]
    assert named(diagnosis) == {TOOL: "named"}


def test_a_weighed_tool_explains_what_the_wrong_one_did():
    said = found(mounted(90.0, 60.0).with_known(["payload:payload=tool,mass_kg=90,std=0.5"]))
    assert [fact.obeyed for fact in said.given] == [True]
    assert said.verdict == "nothing_missing"


def test_a_payload_in_all_poses_is_what_is_mounted():
    """One payload in all poses is what is mounted; so is what a campaign calls by the tool's name."""
    plain = mounted(90.0, 0.0)
    carrying = replace(
        plain.with_poses(payload=np.ones(plain.n_poses, dtype=np.int64)),
        payload_names=("", "tool"),
        load_mass=np.array([0.0, 60.0]),
        load_com=np.array([[0.0, 0.0, 0.0], COM]),
    )
    sites = Payload.sites(problem_of(carrying))
    assert {(str(one.where), one.always_there) for one in sites} == {("tool", False)}
    for mass in (10.0, 100.0):  # a tool that is stated as well may be another, lighter or heavier
        both = Payload.sites(problem_of(replace(carrying, tool_mass=mass)))
        assert {str(one.where) for one in both if one.always_there} == {"tool (always mounted)"}


def test_what_was_found_of_a_tool_holds_for_this_one_alone():
    """A model.toml says what its tool is off; who states the right one since must not get it twice."""
    case = mounted(90.0, 60.0)
    item = record(*parse_effect("payload:payload=tool,variant=mass,mass=30", problem_of(case)))
    model = replace(case.robot, effects=(item,), tool=LoadData(mass_kg=60.0, com_mm=(150.0, 0.0, 100.0)))
    corrected = replace(case, robot=model)
    ((effect, values),) = stated_effects(problem_of(corrected))
    assert (effect.cause, str(effect.where), values.tolist()) == (*TOOL, [30.0])
    assert stated_effects(problem_of(replace(corrected, tool_mass=90.0))) == []
    by_effect = Model(problem_of(case), (), ((effect, values),))
    by_statement = Model(problem_of(replace(case, tool_mass=90.0)))
    same = by_effect.predict(by_effect.in_base()) - by_statement.predict(by_statement.in_base())
    assert np.abs(same).max() < 1e-9


def test_a_centre_of_mass_moves_by_the_first_moment_over_all_that_is_there():
    job = problem_of(measured(poses=12, loads=()))
    mass, com = (one for one in LinkMass.sites(job) if one.where.link == "link_5")
    old, more = mass.mass, 25.0
    added = np.array([0.2, 0.0, 0.1])  # m, from the centre of mass, where those 25 kg sit
    moment = more * added
    beside = com.beside([(mass, np.array([more])), (com, moment)])
    shift = [p.value for p in beside.report(moment, np.eye(3))]
    assert shift == pytest.approx(more * added / (old + more))
    assert f"{1e3 * np.linalg.norm(shift):.0f} mm off" in beside.sentence(moment)
    alone = com.beside([(com, moment)])
    assert [p.value for p in alone.report(moment, np.eye(3))] == pytest.approx(moment / old)
    assert com.mass == old


def test_a_robot_without_masses_says_nothing_of_what_nobody_stated():
    job = problem_of(measured(poses=12, loads=()))
    light = replace(job, arm=replace(job.arm, mass=0 * job.arm.mass, moment=0 * job.arm.moment))
    assert Payload.sites(job)
    assert not Payload.sites(light)
    assert "no payload or tool stated" in str(Payload.needs(light))
