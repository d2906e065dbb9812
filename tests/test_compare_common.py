"""What all campaigns have, beside what changed between them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from workbench import Truth, load_robot, parse_effect, planned, problem_of, random_poses, simulate
from workbench.campaign import Campaign
from workbench.diagnosis.candidates import testable as candidates_of
from workbench.diagnosis.changes import decision
from workbench.diagnosis.changes.decision import decide
from workbench.diagnosis.changes.occasions import occasions_of

BEFORE, AFTER = 1.2e-5, 2.0e-5  # rad/(N·m)


def soft(seed: int, compliance: float) -> Campaign:
    """A robot without stiffness in its model."""
    robot = load_robot("lrmate200id")
    plan = planned(robot, random_poses(robot, 30, np.random.default_rng(seed)))
    texts = [
        f"joint_compliance:joint=joint_2,compliance={compliance}",
        "joint_compliance:joint=joint_3,compliance=1.5e-5",
    ]
    hidden = tuple(parse_effect(text, problem_of(plan)) for text in texts)
    return simulate(plan, Truth(effects=hidden, sigma=2e-5), seed=seed)


@cache
def both():
    """The campaigns as occasions, and all their poses as one problem."""
    return occasions_of([soft(1, BEFORE), soft(2, AFTER)], lambda _: None)


def test_links_that_are_heavier_in_all_campaigns_are_no_joint_that_became_softer():
    """They do more where a joint is softer: at each campaign's own compliance the masses of all links, at a
    hundred percent more, stood in for its change, and the joint of both was stiff."""
    occasions, whole = both()
    decided = decide(occasions, whole, candidates_of(whole)[0])
    members = [(decided.candidates[m.component], decided.shape(m)) for m in decided.members]
    changed = [(candidate.cause, candidate.where.joint) for candidate, _ in members if candidate.change]
    assert changed == [("joint_compliance", "joint_2")]
    for one, true in zip(decided.system.occasions, (BEFORE, AFTER), strict=True):
        (value,) = one.fit.state.values[0]
        assert abs(value - true) < 1e-6


def test_until_something_is_found_all_campaigns_have_the_same_effects(monkeypatch):
    """At each campaign's own, what is common to them would explain that they differ."""
    occasions, whole = both()
    assert abs(occasions[0].fit.state.values[0][0] - occasions[1].fit.state.values[0][0]) > 5e-6
    began = []

    def begun(some):
        began.extend(some)
        raise StopIteration  # what is decided then is the test's above

    monkeypatch.setattr(decision, "system_of", begun)
    with pytest.raises(StopIteration):
        decide(occasions, whole, candidates_of(whole)[0])
    first, second = (one.fit.state.values for one in began)
    assert [v.tolist() for v in first] == [v.tolist() for v in second]
