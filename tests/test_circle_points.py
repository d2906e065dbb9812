"""Circles in space, axes, Denavit–Hartenberg rows, and the deflection that bends them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.campaign import Target
from workbench.campaign.planned import planned
from workbench.campaign.problem import problem_of
from workbench.files.faults import InputError
from workbench.identification.deflection import deflection, deflection_budget, with_compliance
from workbench.identification.denavit_hartenberg import (
    axial_columns,
    chain,
    corrections,
    fitted_rows,
    with_rows,
)
from workbench.identification.fit import fit
from workbench.identification.model import Model
from workbench.measurement.circle_points import distance_from, fit_circle, link_between, sweeps, turning_ratio
from workbench.measurement.zeros_and_offsets import identified
from workbench.robot.description import load_robot
from workbench.robot.kinematics import Array, frames
from workbench.robot.rigid_plant import arrays
from workbench.simulation.virtual_campaign import Truth, simulate
from workbench.studies.longlink.printed import TABLE_2, TABLE_3

ANGLES = np.linspace(-1.2, 1.2, 15)


def circle(angles: Array, centre: Array, turn: Rotation, radius: float) -> Array:
    """(N, 3) points on a circle about the turned z axis."""
    flat = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    return np.asarray(centre + turn.apply(radius * flat))


def test_circle_has_its_centre_axis_and_sense() -> None:
    turn = Rotation.from_rotvec([0.3, -0.8, 1.1])
    for sense in (1, -1):
        found = fit_circle(circle(sense * ANGLES, np.array([1.0, 2.0, -3.0]), turn, 0.7))
        np.testing.assert_allclose(found.centre, [1.0, 2.0, -3.0], atol=1e-9)
        np.testing.assert_allclose(found.direction, sense * turn.apply([0, 0, 1]), atol=1e-9)
        np.testing.assert_allclose(found.turned, ANGLES - ANGLES[0], atol=1e-9)
        assert found.radius == pytest.approx(0.7)


def test_links_and_ratio_are_found_within_their_intervals() -> None:
    """Two axes 0.4 m apart, twisted by 1.5 rad; joint 2 turns 0.1 % too far."""
    rng, sigma, hits = np.random.default_rng(0), 5e-5, []
    second = Rotation.from_euler("x", 1.5)
    for _ in range(60):
        noise = sigma * rng.normal(size=(2, len(ANGLES), 3))
        one = fit_circle(circle(ANGLES, np.zeros(3), Rotation.identity(), 1.3) + noise[0])
        points = circle(1.001 * ANGLES, np.array([0.4, 0.2, 0.1]), second, 0.9)
        two = fit_circle(points + noise[1])
        link = link_between(one, two, np.array([0.9, 0.3, 0.0]))
        ratio, std = turning_ratio(two, ANGLES)
        pulls = (link.a - 0.4) / link.a_std, (link.alpha - 1.5) / link.alpha_std, (ratio - 1.001) / std
        hits.append(np.abs(pulls) < 1.96)
        assert two.sigma == pytest.approx(sigma, rel=0.6)
    share = np.mean(hits, axis=0)
    assert (share > 0.85).all()  # 95 % intervals, 60 draws
    assert share.mean() < 1.0


def test_parallel_axes_keep_length_twist_and_spread() -> None:
    tilted = Rotation.from_rotvec([3e-3, 5e-4, 0.0])
    one = fit_circle(circle(ANGLES, np.zeros(3), Rotation.identity(), 1.0))
    two = fit_circle(circle(ANGLES, np.array([1.2, 0.0, 0.0]), tilted, 1.0))
    link = link_between(one, two, np.array([1.0, 0.1, 0.0]))
    assert link.a == pytest.approx(1.2, abs=1e-6)
    assert link.alpha == pytest.approx(3e-3, abs=1e-7)
    assert link.spread == pytest.approx(5e-4, abs=1e-7)


def test_ball_near_the_axis_keeps_its_distance() -> None:
    rng = np.random.default_rng(1)
    turn = Rotation.from_rotvec([0.0, 1.5, 0.4])
    far, near = (circle(ANGLES, np.ones(3), turn, radius) for radius in (0.2, 1.5e-4))
    axis = fit_circle(far + 2e-5 * rng.normal(size=far.shape))
    distance, std = distance_from(axis, near + 2e-5 * rng.normal(size=near.shape), ANGLES)
    assert distance == pytest.approx(1.5e-4, abs=4 * std)
    assert std < 2e-5


def test_what_makes_no_circle_is_refused() -> None:
    with pytest.raises(ValueError, match="four points"):
        fit_circle(np.eye(3))
    with pytest.raises(ValueError, match="line"):
        fit_circle(np.outer(np.arange(6.0), [1.0, 2.0, 3.0]))


def test_sweeps_turn_one_joint_at_a_time() -> None:
    q = sweeps(np.array([0.1, 0.2]), np.array([1.0, 0.5]), 3)
    np.testing.assert_allclose(q, [[-0.9, 0.2], [0.1, 0.2], [1.1, 0.2], [0.1, -0.3], [0.1, 0.2], [0.1, 0.7]])


def test_corrected_arm_is_the_practical_table() -> None:
    """Forward kinematics of Table III by its rows, and by the arm with corrections."""
    robot = load_robot("longlink")
    q = np.random.default_rng(0).uniform(-2, 2, (50, 7))
    geometry, behind = corrections(arrays(robot), TABLE_2, TABLE_3)
    where = frames(arrays(with_rows(robot, TABLE_2, TABLE_3)), q)
    hand = where.p[-1] + where.R[-1] @ behind[:3, 3]
    wanted = chain(TABLE_3, q)[:, -1]
    np.testing.assert_allclose(hand, wanted[:, :3, 3], atol=1e-12)
    np.testing.assert_allclose(where.R[-1] @ behind[:3, :3], wanted[:, :3, :3], atol=1e-12)
    assert not geometry[[0, -1]].any()


def test_rows_of_another_arm_are_refused() -> None:
    other = TABLE_2.copy()
    other[1, 1] = 0.5
    with pytest.raises(ValueError, match="joint_3"):
        corrections(arrays(load_robot("longlink")), other, TABLE_3)


def test_zeros_and_offsets_want_a_stated_noise() -> None:
    robot = load_robot("longlink")
    with pytest.raises(InputError, match="states no noise"):
        identified(planned(robot, np.zeros((3, 7))), robot)


def test_fit_gives_the_rows_back() -> None:
    """d and θ of an arm whose a and α are known, from points without noise to speak of."""
    robot = with_compliance(load_robot("longlink"), 0.0)
    practical = TABLE_2.copy()
    practical[[0, 3, 4], 0] += [2e-3, -1e-3, 5e-4]
    practical[[3, 5], 3] += [4e-4, -3e-4]
    base = [Target(f"B{i}", tuple(np.eye(3)[i]), "base", fixed=True) for i in range(3)]
    hand = [Target(f"T{i}", tuple(0.2 * np.eye(3)[i]), fixed=True) for i in range(3)]
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (20, 7))
    plan = planned(with_rows(robot, TABLE_2, practical), q, targets=[*hand, *base])
    campaign = simulate(plan, Truth(sigma=1e-6, repeatability=np.zeros(7)), seed=1)
    start = problem_of(replace(campaign, robot=with_rows(robot, TABLE_2, TABLE_2)))
    found, covariance = fitted_rows(fit(Model(start), geometry=axial_columns(robot)), TABLE_2)
    np.testing.assert_allclose(found[:, 0], practical[:, 0], atol=2e-5)
    np.testing.assert_allclose(found[[0, 3, 4, 5, 6], 3], practical[[0, 3, 4, 5, 6], 3], atol=2e-5)
    assert found[1:3, 3].sum() == pytest.approx(practical[1:3, 3].sum(), abs=2e-5)
    std = np.sqrt(np.diag(covariance)).reshape(7, 2)
    assert (std[1:3, 0] > 1e-3).all()  # parallel axes: d₂ and d₃ one by one are not decided
    assert (std[[0, 3, 4, 5, 6], 0] < 1e-5).all()


def test_deflection_is_what_drake_says() -> None:
    robot = load_robot("longlink")
    q = np.random.default_rng(3).uniform(-1.5, 1.5, (4, 7))
    plan = planned(robot, q, targets=[Target("ball", (0.0, 0.0, 0.0))])
    here = np.eye(3)[None], np.zeros((1, 3))
    quiet = Truth(repeatability=np.zeros(7))
    rigid = replace(plan, robot=with_compliance(robot, 0.0))
    moved = simulate(plan, quiet, instrument=here).points - simulate(rigid, quiet, instrument=here).points
    np.testing.assert_allclose(deflection(plan), moved, atol=1e-8)


def test_budget_adds_up_to_the_deflection() -> None:
    robot = with_compliance(load_robot("longlink"), 0.01)
    q = np.random.default_rng(4).uniform(-1.5, 1.5, (20, 7))
    budget = deflection_budget(planned(robot, q, targets=[Target("ball", (0.0, 0.0, 0.0))]))
    total = sum(part.sum(axis=1) for part in budget.parts.values())
    np.testing.assert_allclose(total, budget.whole, atol=2e-6)  # of 0.1 mm: second order is left
    assert np.linalg.norm(budget.whole, axis=1).mean() > 5e-5


def test_share_of_compliance_scales_joints_and_bearings() -> None:
    robot = load_robot("longlink")
    half, rigid = (arrays(with_compliance(robot, share)).compliance for share in (0.5, 0.0))
    full = arrays(robot).compliance
    links = full - arrays(replace(robot, bending_stiffness={})).compliance
    assert not rigid.any()
    assert links.any()
    np.testing.assert_allclose(half - links, 0.5 * (full - links), atol=1e-20)  # links keep their EI
