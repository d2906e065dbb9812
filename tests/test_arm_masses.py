"""Masses that the URDF has all wrong by one factor, or not at all, and a tool that nobody stated: what the
points then say."""

import re
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import SIGMA, measured

from workbench.campaign.problem import problem_of
from workbench.diagnosis.candidates import untold
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.weighing.components import Component, Form
from workbench.diagnosis.weighing.gram import Stored
from workbench.diagnosis.weighing.reduced import Reduced
from workbench.diagnosis.weighing.sets import Competition
from workbench.effects import catalogue
from workbench.effects.place import Where
from workbench.effects.records import from_record, record
from workbench.effects.unnamed.loads import OwnWeights, ToolsWeight
from workbench.files.faults import InputError
from workbench.measurement.design.causes import named_causes
from workbench.report.content import content
from workbench.robot.loads import wrenches

SOFT = {"joint_2": 2e-5, "joint_3": 2e-5}  # rad/(N·m)
YIELDS = tuple(f"joint_compliance:joint={joint},compliance={c}" for joint, c in SOFT.items())


def with_masses(campaign, folder, factors):
    """The campaign with a URDF whose masses are off by factors, one for each of its bodies in turn."""
    urdf = folder / "other.urdf"
    factors = iter(factors)
    text = re.sub(
        r'<mass value="([^"]*)"',
        lambda found: f'<mass value="{next(factors) * float(found[1])}"',
        campaign.robot.urdf.read_text(encoding="utf-8"),
    )
    urdf.write_text(text, encoding="utf-8")
    return replace(campaign, robot=replace(campaign.robot, urdf=urdf))


def test_masses_that_are_all_wrong_are_not_told_as_a_payload_and_do_not_spoil_stiffnesses(tmp_path):
    """The URDF has about three times the arm's masses, each another: the payload was weighed."""
    campaign = measured("irb120", YIELDS, poses=40, loads=(2.0,))
    off = 3.0 * np.random.default_rng(3).uniform(0.95, 1.05, 20)
    found = diagnose(with_masses(campaign, tmp_path, off)).diagnosis
    by_key = {(one.cause, str(one.where)): one for one in found.causes}
    assert ("payload", "load_1") not in by_key
    masses = by_key["link_mass", ""]
    (r,) = masses.parameters
    assert (1 + r.value) * 3 == pytest.approx(1.0, abs=0.1)
    for joint, true in SOFT.items():
        c = by_key["joint_compliance", joint].parameters[0]
        assert c.value == pytest.approx(true, rel=0.1)


def test_a_payload_a_little_off_may_be_the_arms_masses_instead(tmp_path):
    """One of the two is off by a tenth: the points tell only their ratio, so neither is named for sure."""
    campaign = measured("irb120", YIELDS, poses=40, loads=(2.0,))
    payload = replace(campaign, load_mass=1.15 * campaign.load_mass)
    found = diagnose(payload).diagnosis
    (one,) = (f for f in found.causes if f.cause in ("payload", "link_mass"))
    assert one.status == "ambiguous"
    assert {one.cause, *(r.cause for r in one.rivals)} >= {"payload", "link_mass"}


def test_an_arm_without_masses_that_yields_under_loads_too_has_no_gear_that_errs(tmp_path):
    campaign = measured("irb120", YIELDS, poses=40, loads=(2.0,))
    found = diagnose(with_masses(campaign, tmp_path, np.zeros(20))).diagnosis
    told = {one.cause for one in found.causes} | {r.cause for one in found.causes for r in one.rivals}
    assert told <= {"joint_compliance", "link_bending", "lost_motion", "unknown"}
    (rest,) = (one for one in found.causes if one.cause == "unknown")
    assert rest.structure.startswith("depends on weights beyond joint_2, which the model lacks")
    assert rest.separate_by == "state the links' masses in the URDF"
    assert content(found)["next"] == f"What has no name may get one: {rest.separate_by}."


def test_a_tool_that_is_always_there_is_not_told_from_masses_that_the_model_lacks(tmp_path):
    """Nor is how much an arm gives: its torques are those of the masses."""
    campaign = measured("irb120", YIELDS, poses=40, loads=(), tool=(1.5, (0.0, 0.0, 0.1)))
    light = with_masses(campaign, tmp_path, np.zeros(20))
    found = diagnose(light).diagnosis
    (rest,) = found.causes
    assert rest.structure.startswith("depends on weights beyond joint_2, which the model lacks")
    assert (
        found.stages[-1].heldout_rms_mm
        < 1.3 * np.sqrt(3) * 1e3 * SIGMA
        < 0.3 * found.stages[1].heldout_rms_mm
    )
    told = {item.cause: item.why for item in found.not_testable}
    yields = {cause for cause, kind in catalogue().items() if kind.acts == "yielding"}
    assert told.keys() >= {"payload", *yields}
    assert all("state the masses, or measure with two loads" in told[cause] for cause in yields)
    assert not any(catalogue()[cause].needs(problem_of(light)) for cause in ("payload", *yields))  # they act
    for cause in named_causes("joint_compliance:joint=joint_2,payload"):
        with pytest.raises(InputError, match="state the masses, or measure with two loads"):
            cause.effects(problem_of(light))
    two = problem_of(with_masses(measured("irb120", poses=4, loads=(2.0,)), tmp_path, np.zeros(20)))
    assert not any(untold(catalogue()[cause], two) for cause in ("payload", *yields))


def test_nothing_takes_the_place_of_what_is_certain(tmp_path):
    """Three columns of weights, one of a gear that does as well by itself: the gear must stand out."""
    light = problem_of(with_masses(measured("irb120", poses=12, loads=()), tmp_path, np.zeros(20)))
    weights = OwnWeights.sites(light)[0]
    gear = next(e for e in catalogue()["gear_eccentricity"].sites(light) if e.where == weights.where)

    def component(effect, columns, log_odds):
        form = Form((), np.ones(columns), (effect,))
        return Component(effect.key, (form,), log_odds)

    every = [component(gear, 1, -5.0), component(weights, 3, -1.6)]
    own = 100.0 * np.eye(3)
    S = np.block([[own[:1, :1], own[:1]], [own[:, :1], own]])  # the gear is the first of the weights
    u = np.array([300.0, 300.0, 0.0, 0.0])
    reduced = Reduced(
        ((slice(0, 1),), (slice(1, 4),)), Stored(S, np.arange(4), np.ones(4)), u, 1200.0, 300.0, 300.0
    )
    competition = Competition(reduced, every)
    (member,) = competition.best()
    assert member.component == 1
    (share,) = competition.shares([member])
    assert share.keys() == {1, None}
    assert share[1] > 0.99
    silent = replace(reduced, u=np.zeros(4), chi2=300.0)
    assert Competition(silent, every).best() == []


def test_the_arms_mass_can_be_stated():
    problem = problem_of(measured("kr500", poses=12, loads=()))
    (whole,) = (e for e in catalogue()["link_mass"].sites(problem) if e.where == Where())
    total = float(problem.arm.mass[1:].sum())
    assert whole.of_whole(problem, "mass_kg", 0.4 * total, 0.0) == pytest.approx(-0.6)
    arm, _ = whole.apply(problem, problem.arm, problem.loads, np.array([-0.6]))
    np.testing.assert_allclose(arm.mass[1:], 0.4 * problem.arm.mass[1:])
    np.testing.assert_allclose(arm.moment[1:], 0.4 * problem.arm.moment[1:])


TOOL = (0.6, (0.05, 0.03, 0.1))


def without_tool(campaign):
    return replace(campaign, tool_mass=0.0, tool_com=np.zeros(3))


def giving(joint):
    """A joint that gives in proportion to its torque, and a little more under a large one."""

    def error(problem):
        torque = problem.arm.own(wrenches(problem.arm, problem.rigid, problem.loads).local)[:, joint]
        share = torque / np.abs(torque).max()
        out = np.zeros_like(problem.q)
        out[:, joint] = 5e-4 * share * (1 + 0.05 * np.abs(share))
        return out

    return error


@pytest.mark.parametrize(("joint", "seed"), [(5, 31), pytest.param(4, 32, marks=pytest.mark.slow)])
def test_a_wrist_that_yields_under_a_tool_that_nobody_stated_is_no_lost_motion(joint, seed):
    campaign = measured("irb120", joints=giving(joint - 1), loads=(), tool=TOOL, sigma=2e-5, seed=seed)
    found = diagnose(without_tool(campaign)).diagnosis
    said = "Something is left that looks like a wrist that yields under a tool that nobody stated."
    assert found.headline.startswith(said)
    (rest,) = found.causes
    assert rest.cause == "unknown"
    assert rest.structure == f"depends on the weight of a tool that nobody stated, on joint_{joint}"
    assert rest.separate_by == "state the tool's mass and centre of mass (`[tool]` in campaign.toml)"
    stated = diagnose(campaign).diagnosis
    assert [(one.label, one.status) for one in stated.causes] == [
        (f"joint_compliance(joint_{joint})", "named")
    ]


def test_the_torque_of_any_tool_is_a_sum_of_the_functions_for_one_that_nobody_stated():
    campaign = measured("irb120", poses=40, loads=(), tool=TOOL)
    heavy, light = problem_of(campaign), problem_of(without_tool(campaign))
    torques = (p.arm.own(wrenches(p.arm, p.rigid, p.loads).local) for p in (heavy, light))
    more = np.subtract(*torques)
    sites = ToolsWeight.sites(light)
    assert [str(one.where.joint) for one in sites] == ["joint_4", "joint_5", "joint_6"]
    for one in sites:
        (basis,) = one.motion(light).values()
        own = more[:, light.joint(one.where.joint)]
        left = own - basis @ np.linalg.lstsq(basis, own, rcond=None)[0]
        assert np.abs(left).max() < 1e-9 * np.abs(own).max()
        weights = one.given({p.name: p.typical for p in one.params})
        again, numbers = from_record(record(one, weights), light)
        assert again == one
        assert np.array_equal(numbers, weights)
    assert not ToolsWeight.sites(heavy)
    assert not ToolsWeight.sites(problem_of(measured("kr500", poses=12, loads=())))  # has stiffnesses
