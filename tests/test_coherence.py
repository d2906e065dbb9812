"""How much alike what a model leaves is in neighbouring postures."""

import numpy as np
from diagnosis_cases import measured

from workbench.campaign.problem import problem_of
from workbench.diagnosis.changes.coherence import coherence, neighbours
from workbench.identification.fit import fit
from workbench.identification.model import Model


def of(joints=None, poses=400):
    return coherence(fit(Model(problem_of(measured(poses=poses, loads=(), joints=joints)))))


def test_noise_is_alike_nowhere_and_an_error_by_postures_is():
    def slow(problem):
        out = np.zeros_like(problem.q)
        out[:, 1] = 4e-4 * np.sin(2 * problem.q[:, 0]) * np.cos(2 * problem.q[:, 1])
        return out

    assert of() < 0.1
    assert of(slow) > 3 * of()


def test_of_few_poses_it_may_be_all():
    assert of(poses=14) == 1.0


def test_neighbours_are_every_pose_once():
    q = np.random.default_rng(0).uniform(-1, 1, (90, 6))
    groups = list(neighbours(q, np.arange(90)))
    assert sorted(np.concatenate(groups)) == list(range(90))
    assert max(map(len, groups)) <= 16
