"""Columns of effects along one motion, and their products, equal those of the whole columns."""

import numpy as np
import pytest

from workbench import Truth, load_robot, planned, random_poses, simulate
from workbench.diagnosis.candidates import testable as all_that_may_be
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.weighing.components import cause_components, nameless_components, sized
from workbench.effects.unnamed import unnamed
from workbench.identification.fit import ROUGH, refit
from workbench.identification.patterns import BLOCK, once, products_of


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
    along = [fit.pattern(effect) for effect in effects]
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


def test_the_derivatives_of_a_fit_are_what_it_is_solved_by(prepared):
    """Those of effects of all kinds, and of some poses alone."""
    effects = [effect for effect in all_that_may_be(prepared.problem)[0] if effect.whole][::3]
    fit = refit(prepared.geometry, effects, ROUGH)
    change, some = np.random.default_rng(0).normal(size=len(fit.columns.names)), np.arange(50, 10, -3)
    for effect, part, values in zip(effects, fit.columns.effect, fit.state.values, strict=True):
        whole = np.matmul(fit.whitener, fit.model.effect_jacobian(fit.line, effect, values))
        np.testing.assert_allclose(fit.J[:, :, part], whole, rtol=1e-9, atol=1e-12 * np.abs(whole).max())
    for J, poses in ((fit.normal.J, np.arange(60)), (fit.normal.J.some(some), some)):
        r, rows = fit.r[poses], fit.J[poses].reshape(-1, len(change))
        A, g = J.squares(r)
        scale = np.linalg.norm(rows, axis=0)
        assert (np.abs(A - rows.T @ rows) <= 1e-12 * np.outer(scale, scale)).all()
        assert (np.abs(g - rows.T @ r.ravel()) <= 1e-12 * scale * np.linalg.norm(r)).all()
        np.testing.assert_allclose(J.onto(r), g, rtol=1e-9, atol=1e-12 * np.abs(g).max())
        np.testing.assert_allclose(J.times(change).ravel(), rows @ change, rtol=1e-9, atol=1e-9)


def test_nothing_has_no_products(prepared):
    fit = prepared.geometry
    found = products_of([], fit.J, fit.r, np.arange(60))
    assert found.GG.shape == (0, 0)
    assert found.Ge.shape == (0,)
