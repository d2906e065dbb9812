"""Columns of effects along one motion, and their products, equal those of the whole columns."""

import numpy as np
import pytest

from workbench import Truth, load_robot, planned, random_poses, simulate
from workbench.diagnosis.candidates import testable as all_that_may_be
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.weighing.components import cause_components, nameless_components, sized
from workbench.diagnosis.weighing.patterns import BLOCK, once, pattern_of, products_of
from workbench.effects.unnamed import unnamed


@pytest.fixture(scope="module", params=["cylindrical", "ur5"])
def prepared(request):
    robot = load_robot(request.param)
    rng = np.random.default_rng(4)
    q = random_poses(robot, 60, rng)
    plan = planned(robot, q, direction=rng.choice([-1.0, 1.0], q.shape), time=np.arange(60.0))
    return prepare(simulate(plan, Truth(sigma=2e-5), seed=1))


@pytest.fixture(scope="module")
def patterns(prepared):
    """Of everything that competes, in their sizes."""
    fit, (candidates, _) = prepared.geometry, all_that_may_be(prepared.problem)
    components = [*cause_components(fit, candidates), *nameless_components(fit, unnamed(prepared.problem))]
    return sized(form for component in components for form in component.forms)


def test_a_pattern_has_the_columns_of_its_effect(prepared):
    fit, (candidates, _) = prepared.geometry, all_that_may_be(prepared.problem)
    effects = [*candidates, *unnamed(prepared.problem)]
    along = [pattern_of(fit, effect) for effect in effects]
    assert 0 < sum(pattern.motion is None for pattern in along) < len(along)
    for effect, pattern in zip(effects, along, strict=True):
        whole = fit.whitened(effect)
        np.testing.assert_allclose(pattern.columns, whole, rtol=1e-12, atol=1e-12 * np.abs(whole).max())
        assert pattern.most(np.ones(whole.shape[2])) >= (1 - 1e-12) * np.abs(whole).max()


def test_products_are_those_of_the_whole_columns(prepared, patterns):
    """Of poses in any order, more than fit into one block."""
    fit, rng = prepared.geometry, np.random.default_rng(0)
    poses = rng.integers(60, size=BLOCK + 50)
    J, e = fit.J[poses], rng.normal(size=fit.r[poses].shape)
    some, of, size = once(patterns)
    assert len(some) < len(patterns)
    found = products_of(some, J, e, poses)
    G = np.concatenate([pattern.columns[poses] * sizes for pattern, sizes in patterns], axis=2)
    G, J, e = G.reshape(e.size, -1), J.reshape(e.size, -1), e.ravel()
    scale, own = np.linalg.norm(G, axis=0), np.linalg.norm(J, axis=0)
    GG = size[:, None] * found.GG[np.ix_(of, of)] * size
    assert (np.abs(GG - G.T @ G) <= 1e-12 * np.outer(scale, scale)).all()
    assert (np.abs(found.JG[:, of] * size - J.T @ G) <= 1e-12 * np.outer(own, scale)).all()
    assert (np.abs(found.Ge[of] * size - G.T @ e) <= 1e-12 * scale * np.linalg.norm(e)).all()


def test_nothing_has_no_products(prepared):
    fit = prepared.geometry
    found = products_of([], fit.J, fit.r, np.arange(60))
    assert found.GG.shape == (0, 0)
    assert found.Ge.shape == (0,)
