"""A whole table of stiffnesses that is off, as data sheets are; and an arm for which none is stated."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis_cases import TARGETS, measured

from workbench import Truth, load_robot, planned, random_poses, simulate
from workbench.campaign.problem import problem_of
from workbench.diagnosis import candidates
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.search.also_yields import _others
from workbench.effects import catalogue
from workbench.effects.place import NOWHERE
from workbench.effects.records import parse_effect
from workbench.measurement.design.decide import command_text
from workbench.measurement.design.settle import tie_said
from workbench.measurement.design.ties import tie_of

SHARES = (-0.19, -0.22, -0.2, -0.18, -0.21, -0.2)  # nearly alike


@pytest.mark.parametrize("loads", [(250.0,), pytest.param((), marks=pytest.mark.slow)])
def test_stiffnesses_that_are_all_off_by_a_factor_are_no_loads(loads):
    every = tuple(f"joint_compliance:joint=joint_{j},relative={r}" for j, r in enumerate(SHARES, 1))
    found = diagnose(measured("kr500", every, loads=loads)).diagnosis
    (cause,) = found.causes
    assert (cause.cause, cause.where, cause.status) == ("joint_compliance", NOWHERE, "named")
    (relative,) = cause.parameters
    assert relative.value == pytest.approx(-0.2, abs=0.03)
    assert relative.std < 0.02
    assert "compliance of all joints alike" in found.headline
    assert cause.sentence.startswith("All joints are 1.2")


def test_what_was_found_without_forces_acts_under_forces_as_well():
    """There it is no candidate: a load cell is off by as much."""
    robot = load_robot("kr500")
    q = random_poses(robot, 6, np.random.default_rng(1))
    plan = planned(robot, q, targets=TARGETS[:1], wrench=np.tile([500.0, 0, -800, 0, 0, 0], (6, 1)))
    problem, kind = problem_of(plan), catalogue()["joint_compliance"]
    assert {one.where for one in kind.places(problem)} - {one.where for one in kind.sites(problem)} == {
        NOWHERE
    }
    softer = parse_effect("joint_compliance:relative=0.2", problem)
    each = [simulate(plan, Truth(effects=some, sigma=0.0)).points for some in ((), (softer,))]
    assert np.linalg.norm(each[1] - each[0], axis=2).min() > 5e-5


def test_of_an_arm_with_one_load_they_may_be_its_weights_as_well():
    every = tuple(f"joint_compliance:joint=joint_{j},relative={r}" for j, r in enumerate(SHARES, 1))
    outcome = diagnose(measured("6R", every, loads=()))
    (cause,) = outcome.diagnosis.causes
    assert cause.status == "ambiguous"
    both = {(cause.cause, cause.where), *((one.cause, one.where) for one in cause.rivals)}
    assert {("joint_compliance", NOWHERE), ("link_mass", NOWHERE)} <= both
    assert cause.separate_by == "measure with two payloads: a stiffness acts on both, a link mass on neither"
    tie = tie_of(outcome, cause)
    assert tie is not None
    said = tie_said(command_text(tie), outcome.prepared.geometry)  # not every joint, not every link
    assert (said.effect, said.rivals) == (tie.effect, tie.rivals)


def test_a_joint_that_no_load_turns_is_as_stiff_as_what_it_carries_asks():
    """Gravity does not turn joint 1: a force from the side would find in the model what the prior allows."""
    soft = {"shoulder_lift_joint": 2e-5, "elbow_joint": 2e-5}
    every = tuple(f"joint_compliance:joint={joint},compliance={c}" for joint, c in soft.items())
    fit = diagnose(measured("ur10", every, poses=40, loads=())).fit
    found = [i for i, effect in enumerate(fit.model.effects) if effect.where.joint in soft]
    others = _others(fit, found, candidates.testable(fit.model.problem)[0])
    held = {e.where.joint: e.held for e in others if e.cause == "joint_compliance"}
    assert 2e-6 < held["shoulder_pan_joint"] < 1e-4
