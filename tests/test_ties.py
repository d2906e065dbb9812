"""What settles a tie: λ beside a rival, or beside one that contains the cause what else would have shown."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, load_robot, parse_effect, planned, random_poses, simulate
from workbench.campaign.problem import problem_of
from workbench.diagnosis.priors import varied
from workbench.diagnosis.weighing.components import cause_components
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.joint_map import JointMap
from workbench.effects.place import Where
from workbench.measurement.design import decide
from workbench.measurement.design.candidates import Factors, candidates, random_draws
from workbench.measurement.design.expected_odds import Outlook
from workbench.measurement.design.fedorov import Search
from workbench.measurement.design.prior_information import from_campaign
from workbench.measurement.design.t_optimal import design_space
from workbench.measurement.design.ties import (
    POWER,
    Attempts,
    Settling,
    as_found,
    at_zero,
    best_records,
    contains,
    fewest,
    imitation,
    least,
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
    size = np.array([p.typical for p in whole.params])
    both = [
        tie_between(prior.fit, sine, values, (whole,), {}),
        tie_between(prior.fit, whole, size, (sine,), {}),
    ]
    valued = at_zero(both)
    offered = candidates(prior, POOL, Factors(), np.random.default_rng(0))
    space = design_space(prior.of_records(offered, valued), prior.of_campaign(valued))
    return prior.fit, sine, values, whole, space


def test_a_map_contains_a_sine(tied):
    fit, sine, values, whole, space = tied
    assert contains(space, whole, sine)
    assert not contains(space, sine, whole)
    assert tie_between(fit, sine, values, (whole,), {}).pairs(space) == [(whole, sine)]


def test_poses_refute_what_contains_the_cause(tied):
    """By what else it would show: more poses make it surer; odds that are known already spare some."""
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {sine.key: 0.6, whole.key: 0.4})
    powers = [Settling(space, [tie]).power(space.measured(np.arange(n))) for n in (0, 10, 40, POOL)]
    assert powers[0] == 0
    assert powers == sorted(powers)
    assert powers[-1] > 0.4
    sure = replace(tie, chances={sine.key: 0.94, whole.key: 0.06})
    assert Settling(space, [sure]).power(space.measured(np.arange(40))) > powers[2] + 0.2


def test_a_cause_that_only_its_prior_odds_name_is_not_settled(tied):
    """A rival that was as unlikely before the data as it is now has to be refuted by further data."""
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {sine.key: 0.99, whole.key: 0.01})
    before, after = (space.measured(np.arange(n)) for n in (0, POOL))
    unlikely = replace(tie, log_odds={sine.key: 0.0, whole.key: -5.0})
    alike = replace(tie, log_odds={sine.key: 0.0, whole.key: 0.0})
    assert Settling(space, [alike]).power(before) > POWER
    assert Settling(space, [unlikely]).power(before) < 0.1
    assert Settling(space, [unlikely]).power(after) < Settling(space, [alike]).power(after)


def test_prior_odds_are_those_of_a_diagnosis(tied):
    """Which has a cause at all its places; but of lines in a gear: theirs are also those of their order."""
    fit, sine, values, whole, _ = tied
    line, soft = (
        parse_effect(text, fit.model.problem)[0]
        for text in (
            "gear_kinematic_error:joint=joint_4,order=70,amplitude=1e-4,phase=0",
            "joint_compliance:joint=joint_4,relative=0.1",
        )
    )
    tie = tie_between(fit, sine, values, (whole, line, soft), {})
    every = [one for kind in (JointMap, JointCompliance, type(sine)) for one in kind.sites(fit.model.problem)]
    odds = {one.key: one.log_odds for one in cause_components(fit, every)}
    assert tie.log_odds == pytest.approx({key: odds[key] for key in (sine.key, whole.key, soft.key)})


def test_what_is_promised_is_what_comes_of_it(tied):
    """Of ties whose truth is drawn anew, as many are settled as is said, reckoned with other draws."""
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {sine.key: 0.85, whole.key: 0.15})
    now, own = space.left(space.before), space.columns(sine) - space.background
    outlook = Outlook(now, now[:, own] @ tie.size, tie.hypotheses(space))
    then = space.left(space.measured(np.arange(40)))
    promised = outlook.after(then)
    again = [Outlook(outlook.now, outlook.u, outlook.hypotheses, seed).after(then).named for seed in range(5)]
    assert promised.named == pytest.approx(np.mean(again), abs=0.05)
    assert promised.named <= promised.believed


def test_a_map_that_was_found_is_settled_beside_the_sine_in_it(tied):
    """The sine beside the map shows nothing, and is not asked for; but odds between the two grow slowly."""
    fit, sine, _, whole, space = tied
    size = np.zeros(len(whole.params))
    size[[1, 4]] = 1.5
    chances = {whole.key: 0.9, sine.key: 0.1}
    tie = tie_between(fit, whole, size * [p.typical for p in whole.params], (sine,), chances)
    search, attempts = Search(POOL, 1, 0), Attempts(24, 6, 60, 4, 1.1)
    with varied(kin=1.0):
        chosen, power = fewest(space, [tie], search, attempts)
    assert power > 0.4
    assert least(space, space.measured(chosen), tie) >= 40
    assert Settling(space, [tie]).power(space.measured(chosen)) < power


def test_so_many_poses_as_are_needed_settle_it(tied):
    """In the proportions of these: one less does not."""
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {sine.key: 0.94, whole.key: 0.06})
    settling, few = Settling(space, [tie]), np.arange(20)
    needed = settling.needed(few)
    assert needed is not None
    assert (
        settling.power(space.measured(few, needed)) >= POWER > settling.power(space.measured(few, needed - 1))
    )
    twins = replace(tie, chances={sine.key: 0.5, whole.key: 0.5})
    assert (Settling(space, [twins]).needed(few) or np.inf) > needed


def test_no_chosen_records_settle_less_than_random_ones(tied):
    fit, sine, values, whole, space = tied
    tie = tie_between(fit, sine, values, (whole,), {})
    settling = Settling(space, [tie])
    chosen = best_records(settling, as_found(space, [tie]), 15, Search(POOL, 1, 0))
    draws = random_draws(len(space.rows), 15, 0)
    beliefs = [settling.believed(space.measured(rows)) for rows in (chosen, *draws)]
    assert max(beliefs) == beliefs[0]


def test_a_stiffness_of_a_rigid_joint_is_read_near_what_was_found():
    """At the model's own value, no yield, it would be infinite, and any spread of it would do."""
    job = problem_of(
        planned(load_robot("ur5"), random_poses(load_robot("ur5"), 12, np.random.default_rng(0)))
    )
    soft = JointCompliance(Where(joint="elbow_joint"))
    assert decide._slope(job, soft, "stiffness", 2e-6) == pytest.approx(4e-12, rel=1e-3)


def test_a_reading_of_a_rival_tells_a_joint_as_soft_as_it_would_have_to_be():
    """Near the usual size it would be a thousand times what such a joint has; and what the model carries of
    it is read as well."""
    robot = load_robot("ur5")
    campaign = simulate(planned(robot, random_poses(robot, 20, np.random.default_rng(3))), Truth(sigma=3e-5))
    prior = from_campaign(replace(campaign, noise_sigma=3e-5))
    about = "joint=shoulder_lift_joint,variant=1,amplitude=2e-3,phase=1.57"
    wave, values = parse_effect(f"gear_eccentricity:{about}", prior.problem)
    soft = JointCompliance(Where(joint="shoulder_lift_joint"))
    tie = tie_between(prior.fit, wave, values, (soft, JointCompliance(Where(joint="elbow_joint"))), {})
    valued = at_zero([tie])
    offers = decide.Offers(prior, valued, prior.of_campaign(valued))
    i, j = (offers.space.columns(e) - offers.space.background for e in (wave, soft))
    imitated = imitation(offers.space.left(offers.space.before), i, j, tie.size)[0] * soft.params[0].typical
    for carried in (0.0, 5e-5):
        held = replace(offers, carried={soft.key: carried})
        said = [one for one in decide._readings(prior.problem, tie, held, 20.0) if "lift" in one.words]
        std = float(said[0].command.partition("std=")[2])
        off = std * (carried + imitated) ** 2  # so far the compliance would be
        assert 0 < off < abs(imitated)
    stand_in = replace(offers, unsettled=frozenset({soft.key}))
    assert not [one for one in decide._readings(prior.problem, tie, stand_in, 20.0) if "lift" in one.words]
