"""Names that parts of the data do not share, or that bring held-out poses nothing, are not sure."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, Where, load_robot, parse_effect, planned, problem, random_poses, simulate
from workbench.diagnosis.competition import compete
from workbench.diagnosis.components import Component, bare
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.replication import replicated
from workbench.diagnosis.run import testable as all_that_may_be
from workbench.diagnosis.sets import Member
from workbench.diagnosis.worth import as_sure_as_its_gain
from workbench.effects.base import UNKNOWN
from workbench.identification.fit import refit

RATIO, MASS, NAMELESS = ("gear_ratio", Where(joint="joint_1")), ("link_mass", Where()), (UNKNOWN, Where())


def component(key):
    return Component(key, (), 0.0)


@pytest.fixture(scope="module")
def wheel():
    """A run-out of joint 1 in a campaign that states no noise."""
    robot = load_robot("cylindrical")
    plan = planned(robot, random_poses(robot, 60, np.random.default_rng(1)))
    hidden = parse_effect("gear_eccentricity:joint=joint_1,variant=1,amplitude=5e-4,phase=0.4", problem(plan))
    measured = simulate(plan, Truth(effects=(hidden,), sigma=2e-5), seed=1)
    return prepare(replace(measured, noise_sigma=None, sigma=None))


def test_a_name_is_as_sure_as_the_parts_say_on_average(wheel):
    """However they number what they compete with; what they do not find there is nothing."""
    every = [component(RATIO), component(NAMELESS), component(MASS)]
    theirs = [component(MASS), component(RATIO)]
    said = iter([[{1: 0.9, 0: 0.1}], [{1: 1.0}], [], [{0: 0.7, 1: 0.3}]])
    members = [Member(0, 0, 1.0), Member(1, 0, 1.0)]
    shares = [{0: 0.99, 2: 0.01}, {1: 1.0}]
    parts = []

    def search(poses):
        parts.append(poses)
        return theirs, next(said)

    ratio, nameless = replicated(wheel.problem, every, members, shares, search)
    assert ratio[0] == pytest.approx((0.9 + 1.0 + 0.0 + 0.3) / 4)
    assert ratio[2] == pytest.approx((0.1 + 0.7) / 4)
    assert ratio[None] == pytest.approx(1 / 4)
    assert nameless == {1: 1.0}
    assert [len(part) for part in parts] == [30, 30, 30, 30]
    assert not set(parts[0]) & set(parts[1])
    assert not set(parts[2]) & set(parts[3])


def test_parts_make_no_name_surer(wheel):
    every, members = [component(RATIO)], [Member(0, 0, 1.0)]
    (share,) = replicated(wheel.problem, every, members, [{0: 0.6, None: 0.4}], lambda _: (every, [{0: 1.0}]))
    assert share == {0: 0.6, None: 0.4}


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
    held = as_sure_as_its_gain(claimed, seed=0)
    share = dict(zip((m.component for m in held.members), held.shares, strict=True))
    assert share[own.component][own.component] > 0.95
    assert share[k][k] < 0.5
    assert share[k][None] == pytest.approx(1 - share[k][k])
    assert claimed.shares[-1] == {k: 1.0, None: 0.0}
