"""What settles a tie: λ beside a rival, or beside one that contains the cause what else would have shown."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, load_robot, parse_effect, planned, random_poses, simulate
from workbench.campaign.problem import problem_of
from workbench.diagnosis.priors import varied
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.joint_map import JointMap
from workbench.effects.place import Where
from workbench.measurement.design import decide
from workbench.measurement.design.accuracy import DRAWS
from workbench.measurement.design.candidates import Factors, candidates, random_rows
from workbench.measurement.design.fedorov import Search
from workbench.measurement.design.prior_information import from_campaign
from workbench.measurement.design.t_optimal import design_space
from workbench.measurement.design.ties import (
    Attempts,
    at_zero,
    contains,
    fewest,
    least,
    records_needed,
    share_of,
    tie_between,
)

POOL = 100


@pytest.fixture(scope="module")
def tied():
    """A sine of joint 4 beside a map of it, on 15 poses; the sine, the map, and a space of further poses."""
    robot = load_robot("kr500")
    plan = planned(robot, random_poses(robot, 15, np.random.default_rng(3)))
    campaign = replace(simulate(plan, Truth(sigma=3e-5), seed=1), noise_sigma=3e-5)
    prior = from_campaign(campaign)
    sine, values = parse_effect(
        "gear_eccentricity:joint=joint_4,variant=2,amplitude=3e-4,phase=1", prior.problem
    )
    whole = next(e for e in JointMap.sites(prior.problem) if e.where == sine.where and e.variant == "smooth")
    valued = at_zero([tie_between(prior.fit, sine, values, (whole,), {})])
    offered = candidates(prior, POOL, Factors(), np.random.default_rng(0))
    space = design_space(prior.of_records(offered, valued), prior.of_campaign(valued))
    return prior.fit, sine, values, whole, space


def test_a_map_contains_a_sine(tied):
    fit, sine, values, whole, space = tied
    assert contains(space, whole, sine)
    assert not contains(space, sine, whole)
    assert tie_between(fit, sine, values, (whole,), {}).pairs(space) == [(whole, sine)]


def test_poses_refute_what_contains_the_cause(tied):
    """By what else it would show: all poses make it surest; odds that are known already spare some."""
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {})
    shares = [share_of(space, space.measured(np.arange(n)), tie) for n in (0, 10, 40, POOL)]
    assert shares[0] == pytest.approx(0.0, abs=1e-9)
    assert 0 < min(shares[1:]) <= max(shares) == shares[-1]
    assert shares[-1] > 0.2
    sure = replace(tie, chances={sine.key: 0.96, whole.key: 0.04})
    assert share_of(space, space.everything, sure) > shares[-1]


def test_a_map_that_was_found_is_settled_beside_the_sine_in_it(tied):
    """The sine beside the map shows nothing, and is not asked for; but odds between the two grow slowly."""
    fit, sine, _, whole, space = tied
    size = np.zeros(len(whole.params))
    size[[1, 4]] = 1.5
    tie = tie_between(fit, whole, size * [p.typical for p in whole.params], (sine,), {})
    search, attempts = Search(POOL, 1, 0), Attempts(24, 6, 60, 4, 1.1)
    with varied(kin=1.0):
        chosen, share = fewest(space, [tie], search, attempts)
    assert share >= 1
    assert least(space, space.measured(chosen), tie) >= 40
    assert 0 < share_of(space, space.measured(chosen), tie) < share / 2


def test_what_is_needed_is_not_drawn_out_in_a_line(tied):
    """Odds beside a map that contains the sine grow slower than poses: so many of them do settle it."""
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {sine.key: 0.94, whole.key: 0.06})
    few = np.arange(20)
    share = share_of(space, space.measured(few), tie)
    needed = records_needed(space, few, [tie])
    assert share_of(space, space.measured(few, 20 / share), tie) < 1  # in a line it would be settled
    assert needed is None or needed > 20 / share
    every = np.arange(POOL)
    assert records_needed(space, every, [replace(tie, chances={sine.key: 0.97, whole.key: 0.03})]) is not None


def test_no_chosen_records_settle_less_than_random_ones(tied):
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {})
    _, share = fewest(space, [tie], Search(POOL, 1, 0), Attempts(15, 15, 15, 1, 1.0))
    draws = [random_rows(len(space.rows), 15, 0, draw) for draw in range(DRAWS)]
    assert share >= max(share_of(space, space.measured(draw), tie) for draw in draws) - 1e-9


def test_a_stiffness_of_a_rigid_joint_is_read_near_what_was_found():
    """At the model's own value, no yield, it would be infinite, and any spread of it would do."""
    job = problem_of(
        planned(load_robot("ur5"), random_poses(load_robot("ur5"), 12, np.random.default_rng(0)))
    )
    soft = JointCompliance(Where(joint="elbow_joint"))
    assert decide._slope(job, soft, "stiffness", 2e-6) == pytest.approx(4e-12, rel=1e-3)
