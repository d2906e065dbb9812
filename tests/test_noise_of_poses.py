"""Noise of 6-D measurements: shifts of the point that is measured, turns, of which nobody states any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import measured
from scipy.spatial.transform import Rotation

from workbench.campaign import Target
from workbench.campaign.problem import problem_of
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose
from workbench.identification.fit import start_state
from workbench.identification.model import Model
from workbench.identification.noise import Covariance, log_precision
from workbench.identification.rows import whitening

ARM = 0.1  # m, of the frame that stands for a pose


def poses_of(shift, turn, count=60, times=1, seed=3, sigma=None):
    """A UR5 under a 6-D probe of noise shift [m] per axis of its origin and turn [rad] about each axis."""
    rng = np.random.default_rng(seed)
    plan = measured("ur5", poses=count, loads=(), targets=1, seed=seed)
    order = np.tile(np.arange(count), times)
    plan = plan.some(order).with_poses(ids=tuple(str(i + 1) for i in range(len(order))))
    place = problem_of(plan).rigid
    R = Rotation.from_rotvec(rng.normal(0, turn, (len(order), 3))).as_matrix() @ place.R[-1]
    p = place.p[-1] + place.R[-1] @ [0.02, 0.03, 0.1] + rng.normal(0, shift, (len(order), 3))
    points = np.stack([p, p + ARM * R[:, :, 0], p + ARM * R[:, :, 1]], axis=1)
    shots = np.repeat(plan.shots[:, :1], 3, axis=1)
    targets = (Target("P", (0.02, 0.03, 0.1)), Target("P_x"), Target("P_y"))
    six = replace(plan, points=points, shots=shots, targets=targets, sigma=None, six_dof=True)
    return replace(six, noise_sigma=sigma)


def test_turns_noisier_than_their_points_are_no_structure():
    """What is stated is said of the point that is measured; its turns move the middle of the three more."""
    found = diagnose(poses_of(2e-5, 1e-3, sigma=2e-5))
    assert found.diagnosis.verdict == "nothing_missing"
    assert found.diagnosis.remainder_p > 1e-3
    (said,) = (note for note in found.diagnosis.notes if "mrad about each axis" in note)
    assert float(said.split("scatter by ")[1].split()[0]) == pytest.approx(1.0, rel=0.15)


def test_a_stated_noise_that_is_too_small_is_told():
    (cause,) = diagnose(poses_of(2e-4, 1e-3, sigma=5e-5)).diagnosis.causes
    assert cause.cause == "unknown"
    assert "as of a noise stated too small" in cause.structure


@pytest.mark.parametrize("stated", [None, 1e-4, 1e-5])
def test_repeats_show_shifts_and_turns(stated):
    ready = prepare(poses_of(1e-4, 4e-4, count=30, times=3, sigma=stated))
    shift = np.hypot(1e-4, 4e-4 * ARM * np.sqrt(2) / 3 * np.sqrt(2 / 3))  # of the middle
    turn = 4e-4 / np.sqrt(3 * 3 / (2 * 4 / 3 * ARM**2))  # as points of such noise would turn it
    assert ready.noise.source == ("stated" if stated == 1e-4 else "repeats")
    assert ready.covariance.usual == pytest.approx(stated if stated == 1e-4 else shift, rel=0.15)
    assert ready.covariance.turn_ratio * ready.covariance.usual == pytest.approx(turn, rel=0.15)


@pytest.mark.parametrize("about", [-1, 0])
def test_whitened_poses_hold_what_joints_and_body_scatter(about):
    problem = problem_of(poses_of(0.0, 0.0, count=20))
    line = Model(problem, ()).linearise(start_state(problem))
    joint = 1e-4 * np.arange(1, 7)
    noise = Covariance(np.full(problem.seen.shape, 3e-5), joint, np.ones(20), turn_ratio=2.0, about=about)
    alone = whitening(problem, line, replace(noise, joint=0 * joint))
    whole = whitening(problem, line, noise)
    J = line.by_joint * joint
    half = np.linalg.pinv(alone)
    C = half @ half.transpose(0, 2, 1) + J @ J.transpose(0, 2, 1)
    assert np.allclose(whole @ C @ whole.transpose(0, 2, 1), np.eye(6), atol=1e-6)
    assert log_precision(whole) < log_precision(alone)
