"""Names that parts of the data do not share, or that bring held-out poses nothing, are not sure."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from diagnosis_cases import found, measured

from workbench import Truth, Where, load_robot, parse_effect, planned, problem, random_poses, simulate
from workbench.diagnosis.candidates import testable as all_that_may_be
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.priors import PRIORS
from workbench.diagnosis.search import competition as competing
from workbench.diagnosis.search import worth
from workbench.diagnosis.search.competition import _likeliest, _renamed_at_no_loss, compete
from workbench.diagnosis.search.worth import VOUCHED, _chance, as_sure_as_its_gain
from workbench.diagnosis.telling.nameless import _as_one, _plain
from workbench.diagnosis.weighing.chosen import Chosen, Member
from workbench.diagnosis.weighing.components import Component, Form, bare, cause_components
from workbench.diagnosis.weighing.gram import Stored
from workbench.diagnosis.weighing.reduced import Reduced, reduce
from workbench.diagnosis.weighing.replication import (
    Part,
    agreed,
    exceeds,
    joined,
    power,
    renamed,
    replicated,
    searched_in_parts,
)
from workbench.diagnosis.weighing.sets import Competition
from workbench.diagnosis.weighing.weight import prior_weight
from workbench.effects.base import UNKNOWN
from workbench.effects.place import NOWHERE
from workbench.effects.unnamed import unnamed
from workbench.effects.unnamed.joints import Product
from workbench.identification.fit import refit

RUN_OUT = ("gear_eccentricity", Where(joint="joint_1"))
RATIO, MASS, NAMELESS = ("gear_ratio", Where(joint="joint_1")), ("link_mass", Where()), (UNKNOWN, Where())


def component(key):
    return Component(key, (), 0.0)


def certain(poses):
    """What is there is seen in every part, and none shows it by itself."""
    return [(1.0, 0.0)] * 9


@pytest.fixture(scope="module")
def competition(wheel):
    fit, (candidates, _) = wheel.geometry, all_that_may_be(wheel.problem)
    components = cause_components(fit, candidates)
    return Competition(reduce(fit, components, 300.0), components)


@pytest.fixture(scope="module")
def wheel():
    """A run-out of joint 1 in a campaign that states no noise."""
    robot = load_robot("cylindrical")
    plan = planned(robot, random_poses(robot, 60, np.random.default_rng(1)))
    hidden = parse_effect("gear_eccentricity:joint=joint_1,variant=1,amplitude=5e-4,phase=0.4", problem(plan))
    measured = simulate(plan, Truth(effects=(hidden,), sigma=2e-5), seed=1)
    return prepare(replace(measured, noise_sigma=None, sigma=None))


def test_parts_are_searched_by_themselves(wheel):
    """However they number what they compete with; what the whole does not have counts as nothing."""
    every = [component(RATIO), component(NAMELESS), component(MASS)]
    theirs = [component(MASS), component(RATIO), component(("link_mass", Where(link="link_2")))]
    said = iter([[{1: 0.9, 0: 0.1}], [{1: 1.0}], [], [{0: 0.7, 2: 0.1, 1: 0.2}]])
    with searched_in_parts(wheel.problem, lambda poses: (theirs, next(said))) as found:
        parts = found().told(every)
    assert [part.shares for part in parts] == [
        [{None: 0.0, 0: 0.9, 2: 0.1}], [{None: 0.0, 0: 1.0}], [], [{None: 0.1, 2: 0.7, 0: 0.2}]
    ]  # fmt: skip
    assert [len(part.poses) for part in parts] == [30, 30, 30, 30]
    assert not set(parts[0].poses) & set(parts[1].poses)
    assert not set(parts[2].poses) & set(parts[3].poses)


def said_by_parts(*shares):
    return [Part(np.arange(30), each) for each in shares]


def test_a_name_is_as_sure_as_the_parts_say_on_average():
    """What one of them does not find there is nothing."""
    every = [component(RATIO), component(NAMELESS), component(MASS)]
    members = [Member(0, 0, 1.0), Member(1, 0, 1.0)]
    shares = [{0: 0.99, 2: 0.01}, {1: 1.0}]
    parts = said_by_parts([{0: 0.9, 2: 0.1}], [{0: 1.0}], [], [{2: 0.7, 0: 0.3}])
    ratio, nameless = replicated(parts, every, members, shares, certain)
    assert ratio[0] == pytest.approx((0.9 + 1.0 + 0.0 + 0.3) / 4)
    assert ratio[2] == pytest.approx((0.1 + 0.7) / 4)
    assert ratio[None] == pytest.approx(1 / 4)
    assert nameless == {1: 1.0}


def test_parts_make_no_name_surer():
    every, members = [component(RATIO)], [Member(0, 0, 1.0)]
    (share,) = replicated(said_by_parts([{0: 1.0}]), every, members, [{0: 0.6, None: 0.4}], certain)
    assert share == {0: 0.6, None: 0.4}


def test_a_part_does_not_deny_what_it_could_not_show():
    """Two of four parts find nothing: one would hardly have, one surely."""
    every, members = [component(RATIO)], [Member(0, 0, 1.0)]
    could = iter([[(1.0, 0.0)], [(0.1, 0.0)], [(0.9, 0.0)], [(1.0, 0.0)]])
    parts = said_by_parts([{0: 1.0}], [], [], [{0: 1.0}])
    (share,) = replicated(parts, every, members, [{0: 1.0}], lambda _: next(could))
    assert share[0] == pytest.approx((1.0 + 0.9 + 0.1 + 1.0) / 4)
    assert share[None] == pytest.approx((0.1 + 0.9) / 4)


def test_a_line_that_a_part_shows_is_not_denied_by_a_search_that_lost_its_way():
    """Two parts have something else for it, or nothing; beside all others the line is as plain there. A cause
    that is like others has no such witness."""
    line = ("gear_kinematic_error", Where(joint="joint_1", order=200.0))
    every, members = [component(line), component(RATIO)], [Member(0, 0, 1.0), Member(1, 0, 1.0)]
    parts = said_by_parts([{0: 1.0}, {1: 1.0}], [], [{1: 0.9, 0: 0.1}], [{0: 1.0}, {1: 1.0}])
    plain = lambda _: [(1.0, 0.98), (1.0, 0.98)]  # noqa: E731
    whole = [{0: 1.0}, {1: 1.0}]
    found, other = replicated(parts, every, members, whole, plain)
    assert found[0] == pytest.approx((1.0 + 0.98 + 0.98 + 1.0) / 4)
    assert other[1] == pytest.approx((1.0 + 0.0 + 0.9 + 1.0) / 4)


def test_what_all_parts_find_joins_the_set(competition):
    """What most of them find does not; nor what is there."""
    known, all_find, most_find = 3, 5, 8
    members, shares = [Member(known, 0, 1.0)], [{known: 1.0}]
    every = [{known: 1.0}, {all_find: 0.97, None: 0.03}, {most_find: 0.99, None: 0.01}]
    certain = agreed(said_by_parts(every, every, every[:2]), competition.components)
    now, theirs = joined(competition, certain, members, shares)
    assert list(certain) == [known, all_find]
    assert [m.component for m in now] == [known, all_find]
    assert now[0] is members[0]
    assert now[1].scale in PRIORS.scales
    assert theirs == [{known: 1.0}, pytest.approx({all_find: 0.97, None: 0.03})]


def test_power_is_how_often_an_effect_of_that_size_wins():
    """One number, against draws of its estimate."""
    score, size, odds = 25.0, 1.0, np.log(0.01)
    S, slices = np.array([[score]]), ((slice(0, 1),),)
    whole, part = (
        Reduced(slices, Stored(S), S[0] * size, 900.0, 900.0, 1e9),
        Reduced(slices, Stored(S), 0 * S[0], 1.0, 1.0, 1.0),
    )
    one = Component(RATIO, (Form((), np.ones(1), ()),), float(odds))
    (found,) = power(whole, part, [Member(0, 0, 1.0)], [one])
    beta = float(Chosen(whole, [Member(0, 0, 1.0)]).beta[0])
    u = score * beta + np.sqrt(score) * np.random.default_rng(0).normal(size=200_000)
    cost = 0.5 * np.log(1 + score) - prior_weight(one, 0, 1.0)
    assert found == pytest.approx(np.mean(0.5 * u**2 / (score + 1) > cost), abs=0.005)
    assert 0.3 < found < 0.99


@pytest.mark.parametrize("hardly_seen", [0, 37])
def test_what_a_part_hardly_shows_gives_an_effect_no_power(hardly_seen):
    """Companions that the prior holds take nothing by chance: a late half was taken to show a warm-up that
    had gone by, for its thirty-nine columns."""
    score = np.concatenate([[30.0, 12.0], np.full(hardly_seen, 0.02)])
    shift = np.concatenate([[5.0, 1.0], np.full(hardly_seen, 0.01)])
    weight, limit = score / (1 + score), 15.0
    drawn = np.random.default_rng(1).normal(size=(200_000, len(score))) + np.sqrt(shift)
    assert exceeds(weight, shift, limit) == pytest.approx(np.mean(drawn**2 @ weight > limit), abs=0.004)
    assert exceeds(weight, shift, limit) < 0.2


def test_what_the_parts_name_instead_takes_the_place(competition):
    """Of two members that the parts take for the same, one stays; what they do not find keeps its name."""
    # but those that cannot stand beside each other
    some = [k for k, one in enumerate(competition.components) if one.key[0] != "joint_compliance"]
    first, second, other, third = (some[i] for i in (3, 5, 8, 11))
    members = [Member(k, 0, 1.0) for k in (first, second, third)]
    shares = [{other: 0.9, first: 0.1}, {other: 0.6, second: 0.3, None: 0.1}, {None: 0.7, third: 0.3}]
    now, theirs = renamed(competition, members, shares)
    assert [m.component for m in now] == [other, third]
    assert theirs == [shares[0], shares[2]]
    assert now[1] is members[2]
    assert now[0].scale in PRIORS.scales


def test_a_name_whose_need_is_not_there_is_not_taken_over(competition):
    """Half of a measured robot ended in a KeyError: the parts had what nothing else was fitted for."""
    own, theirs, needed = 3, 5, 8
    bound = Competition(competition.reduced, competition.components, {theirs: frozenset({needed})})
    member = Member(own, 0, 1.0)
    share = {theirs: 0.9, own: 0.1, None: 0.0}
    assert renamed(bound, [member], [share]) == ([member], [share])
    now, _ = renamed(bound, [member, Member(needed, 0, 1.0)], [share, {needed: 1.0}])
    assert [m.component for m in now] == [theirs, needed]
    assert joined(bound, {theirs: {theirs: 1.0}}, [member], [{own: 1.0}]) == ([member], [{own: 1.0}])


def test_a_name_of_the_parts_that_predicts_worse_is_not_taken_over(wheel, monkeypatch):
    """The last link's mass in the place of the run-out loses it; a map of the joint is 2 % worse."""
    candidates, _ = all_that_may_be(wheel.problem)
    best, members, shares = _likeliest(wheel, candidates)
    every = {component.key: k for k, component in enumerate(best.competition.components)}
    (i,) = (i for i, m in enumerate(members) if m.component == every[RUN_OUT])

    def taken(other):
        k = every[other]
        told = [*shares[:i], {k: 0.9, members[i].component: 0.1, None: 0.0}, *shares[i + 1 :]]
        now, theirs = _renamed_at_no_loss(best, members, told)
        assert theirs[i] is told[i]
        return k in {m.component for m in now}

    mass, joint_map = ("link_mass", Where(link="link_3")), ("joint_map", Where(joint="joint_1"))
    assert not taken(mass)
    assert not taken(joint_map)
    monkeypatch.setattr(competing, "BETTER", 0.9)  # 2 % is no loss then
    assert not taken(mass)
    assert taken(joint_map)


def test_some_poses_alone_have_their_own_noise(wheel):
    half = wheel.some(np.arange(0, 60, 2))
    assert len(half.problem.q) == 30
    assert half.geometry.noise.sigma.shape == (30, 3)
    assert half.noise.source == "residual"
    assert half.noise.sigma_mm != wheel.noise.sigma_mm


def test_what_brings_nothing_is_not_sure_whatever_its_likelihood(wheel):
    """The run-out stays; a mass that is not wrong does not, though it came with every certainty."""
    candidates, _ = all_that_may_be(wheel.problem)
    found = compete(wheel, candidates)
    assert found.misfit
    (own,) = (m for m in found.members if found.components[m.component].key[0] == "gear_eccentricity")
    k = next(
        k for k, one in enumerate(found.components) if one.key[0] == "drift" or one.key[0] == "link_mass"
    )
    extra = next(e for e in candidates if e.key == bare(found.components[k].key))
    claimed = replace(
        found,
        fit=refit(found.fit, [*found.fit.model.effects, extra]),
        members=(*found.members, Member(k, 0, 1.0)),
        shares=(*found.shares, {k: 1.0, None: 0.0}),
    )
    found_by_parts = replace(claimed, agreed=frozenset([extra.key]))
    assert as_sure_as_its_gain(found_by_parts, seed=0).shares[-1][k] == 1.0
    held = as_sure_as_its_gain(claimed, seed=0)
    share = dict(zip((m.component for m in held.members), held.shares, strict=True))
    assert share[own.component][own.component] > 0.95
    assert share[k][k] < 0.5
    assert share[k][None] == pytest.approx(1 - share[k][k])
    assert claimed.shares[-1] == {k: 1.0, None: 0.0}


@pytest.mark.parametrize("more_than_noise", [False, True])
def test_what_is_left_once_an_effect_brings_nothing_has_no_name(wheel, monkeypatch, more_than_noise):
    """Beside it a cause keeps its name that brings a tenth of it, however sure the likelihood was that the
    effect explained it."""
    found = replace(compete(wheel, all_that_may_be(wheel.problem)[0]), misfit=False)
    function = next(iter(unnamed(wheel.problem)))
    claimed = replace(found, fit=refit(found.fit, [*found.fit.model.effects, function]))
    monkeypatch.setattr(worth, "remainder", lambda *_: SimpleNamespace(scatter=more_than_noise))
    monkeypatch.setattr(worth, "FAINT", 10.0)
    kept = worth.worth_it(claimed, True, seed=0)
    assert function not in kept.fit.model.effects
    assert kept.misfit == more_than_noise
    assert [effect.cause for effect, _ in kept.groups] == ([] if more_than_noise else ["gear_eccentricity"])
    monkeypatch.setattr(worth, "FAINT", 0.1)
    kept = worth.worth_it(claimed, True, seed=0)
    assert [effect.cause for effect, _ in kept.groups] == ["gear_eccentricity"]


def test_what_brings_nothing_without_what_has_no_name_is_not_sure(wheel, monkeypatch):
    """All names together, as a mass that acts through joints of which nobody knows that they yield."""
    found = compete(wheel, all_that_may_be(wheel.problem)[0])
    function = next(iter(unnamed(wheel.problem)))
    beside = replace(found, fit=refit(found.fit, [*found.fit.model.effects, function]))
    ((effect, _),) = beside.groups
    (own,) = (k for k, one in enumerate(found.components) if bare(one.key) == effect.key)

    def share(selection):
        return next(s[own] for s in worth._that_stand_alone(selection, seed=0).shares if own in s)

    assert share(beside) > 0.95
    monkeypatch.setattr(worth, "rms_mm", lambda _: 1.0)
    assert share(beside) == pytest.approx(VOUCHED)
    assert share(found) > 0.95  # nothing without a name is there


def test_two_that_bring_something_beside_each_other_alone_are_not_sure(monkeypatch):
    """The first of four stands by itself, the last as well; the two between only prop each other up."""
    chances = {(0, 1, 2, 3): 1.0, (1, 2, 3): 0.6, (2, 3): 0.99, (3,): 0.98}
    groups = [(SimpleNamespace(key=name), [i]) for i, name in enumerate("abcd")]
    selection: Any = SimpleNamespace(fit=None, groups=groups, nameless=[], agreed={"d"})
    monkeypatch.setattr(worth, "_chance", lambda fit, beside, own, seed: chances[tuple(own)])
    monkeypatch.setattr(worth, "no_surer", lambda selection, surest: surest)
    assert worth._sure_together(selection, seed=0) == {"a": 1.0, "b": 0.6, "c": 0.6}


@pytest.mark.parametrize("uneven", [0.0, 1.5])
def test_an_effect_may_do_more_at_one_position_than_at_another(monkeypatch, uneven):
    """What brings all positions nearer is sure, whether it does as much everywhere or not; what does nothing
    is not, nor what a single position says."""
    rng, noise = np.random.default_rng(5), np.random.default_rng(6).normal(size=(45, 3, 3))
    made = rng.normal(size=noise.shape) * np.exp(uneven * rng.normal(size=(45, 1, 1)))
    fit: Any = SimpleNamespace(model=SimpleNamespace(problem=SimpleNamespace(positions=np.arange(45))))

    def chance(without_it, with_it):
        monkeypatch.setattr(worth, "heldout", lambda fit, seed, without: without_it if without else with_it)
        return _chance(fit, [], [0], seed=0)

    assert chance(noise + made, noise) ** 200 > 0.99
    assert chance(noise, noise - made) < 0.01
    alone = np.zeros_like(made)
    alone[7] = 30.0
    assert chance(noise + alone, noise) < 0.9


def test_what_the_parts_agree_on_is_as_sure_as_they_are(competition):
    """Also where the whole has it as a doubtful name for something else."""
    doubtful, sure = 3, 5
    members, shares = (
        [Member(doubtful, 0, 1.0), Member(sure, 0, 1.0)],
        [{doubtful: 0.4, 8: 0.6}, {sure: 0.999}],
    )
    every = [{doubtful: 0.98, None: 0.02}, {sure: 0.97, 8: 0.03}]
    certain = agreed(said_by_parts(every, every), competition.components)
    now, theirs = joined(competition, certain, members, shares)
    assert now == members
    assert theirs == [pytest.approx({doubtful: 0.98, None: 0.02}), {sure: 0.999}]


def test_no_cause_by_loads_is_sure_beside_larger_bending_without_a_name(monkeypatch):
    """An error that goes with two joints leaves a compliance its name; the same taken for one by loads may be
    what the compliance is a part of."""

    def joints(problem):
        out, q = np.zeros_like(problem.q), problem.q
        out[:, 3] = 1e-3 * np.sin(1.3 * q[:, 1] + 0.4) * np.cos(q[:, 2] - 0.3)
        return out

    campaign = measured(effects=("joint_compliance:joint=joint_3,relative=0.5",), joints=joints, poses=45)
    said = []
    for by_loads in (False, True):
        monkeypatch.setattr(Product, "by_loads", by_loads)
        (cause,) = (f for f in found(campaign).causes if f.cause != UNKNOWN)
        assert cause.label == "joint_compliance(joint_3)"
        said.append((cause.status, [rival.cause for rival in cause.rivals]))
        if by_loads:
            assert cause.probability == pytest.approx(VOUCHED)
    assert said == [("named", []), ("ambiguous", [UNKNOWN])]


def test_what_has_no_name_says_each_structure_once():
    """Two functions of the order of measurement, a long and a short one, are one thing to a reader."""
    parts = [
        _plain(f"depends on {what}", "", NOWHERE, 0.1)
        for what in ("the hand", "time", "time", "the hand", "load")
    ]
    assert _as_one(parts, 0.2).structure == "depends on the hand (besides: depends on time; depends on load)"
