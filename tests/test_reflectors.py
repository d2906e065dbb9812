"""Reflectors on the arm or its base: offered where they settle what those on the flange leave open."""

from __future__ import annotations

import re

import numpy as np
import pytest

from workbench import InputError, Truth, load_robot, planned, random_poses, simulate
from workbench.campaign.problem import problem_of
from workbench.campaign.reflectors import place_of, with_reflectors
from workbench.effects import shown_on, without_reflectors
from workbench.effects.records import parse_effect
from workbench.measurement.design import decide, follow_up
from workbench.measurement.design.decide import command_text
from workbench.measurement.design.prior_information import from_campaign
from workbench.measurement.design.ties import at_zero, tie_between


@pytest.fixture(scope="module")
def campaign():
    robot = load_robot("kr500")
    bare = planned(robot, random_poses(robot, 24, np.random.default_rng(8)))
    return simulate(bare, Truth(sigma=3e-5), seed=3)


def test_a_target_more_is_unknown_and_unseen(campaign):
    more = with_reflectors(campaign, ["link_2", "base"])
    assert [(t.name, t.on, t.xyz) for t in more.targets[-2:]] == [
        ("on_link_2", "link_2", None),
        ("on_base", "base", None),
    ]
    assert more.points.shape == (24, len(campaign.targets) + 2, 3)
    assert np.isnan(more.points[:, -2:]).all()
    again = with_reflectors(more, ["base"])
    assert again.targets[-1].name == "on_base_new"


def test_a_link_that_is_not_there_is_told_with_the_one_that_was_meant(campaign):
    with pytest.raises(InputError, match=r"kr500 has no such link.*link_2"):
        with_reflectors(campaign, ["lnk_2"])


def test_a_reflector_sits_near_its_joint_beside_the_arm(campaign):
    """A fifth of the way to the next joint, and about where a link's surface is."""
    arm = problem_of(campaign).arm
    for link in ("base", "link_2"):
        way = arm.p[arm.slot_of_link(link) + 1]
        place = place_of(arm, link)
        along = float(place @ way) / float(way @ way)
        assert along == pytest.approx(0.2)
        assert float(np.linalg.norm(place - along * way)) == pytest.approx(0.1)


def test_each_cause_has_the_link_on_which_it_shows(campaign):
    problem = problem_of(campaign)
    said = {
        "joint_compliance:joint=joint_3,relative=0.1": "link_3",
        "link_bending:link=link_2,compliance=1e-8": "link_2",
        "foundation:compliance=1e-8": "base",
        "gravity_compensator:relative=0.1": None,
    }
    assert {text: shown_on(parse_effect(text, problem)[0], problem.arm) for text in said} == said


def test_advice_goes_without_what_is_worked_out():
    both = "the motor torque of joint 2, or a target on the link near its joint; targets on the base casting"
    assert without_reflectors(both) == "the motor torque of joint 2"
    assert without_reflectors("targets on the base casting") == ""


def test_a_reflector_is_offered_and_planned_for(campaign):
    """From the flange a floor that yields and a tilting joint 1 look alike, near them less; the
    command plans with that target."""
    prior = from_campaign(campaign)
    floor, values = parse_effect("foundation:compliance=8e-9", prior.problem)
    tilt = parse_effect("bearing_tilt:joint=joint_1,compliance=8e-9", prior.problem)[0]
    tie = tie_between(prior.fit, floor, values, (tilt,), {floor.key: 0.6, tilt.key: 0.4})
    valued = at_zero([tie])
    offers = decide.Offers(prior, valued, prior.of_campaign(valued))
    (way,) = decide._by_reflectors(offers, tie, tie, command_text(tie), None)
    assert re.match(r"a reflector on (the base|link_1 near its joint), measured beside the others", way.words)
    made = follow_up(campaign, way, quick=True)
    assert made.drive.records.targets[-1].on in ("base", "link_1")
    assert made.settles
    without = decide.settled(offers.space, [tie], prior.fit)
    assert without is None or without.count > 1.5 * way.poses
