"""A joint's zero that steps in the course of a campaign: told with its pose and its size, beside causes."""

import re

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.diagnosis.run import diagnose

FIRST, STEP = 22, 4e-4
POSES = 40


def stepped(problem):
    """The zero of the elbow from one pose on."""
    off = np.zeros_like(problem.q)
    off[FIRST:, 2] = STEP
    return off


@pytest.mark.parametrize(
    "effects",
    [
        pytest.param((), marks=pytest.mark.slow),
        ("gear_eccentricity:joint=wrist_1_joint,variant=1,amplitude=4e-4,phase=1",),
    ],
)
def test_a_zero_that_steps_is_told_with_its_pose_and_size(effects):
    campaign = measured("ur5", effects, poses=POSES, loads=(), targets=3, joints=stepped)
    found = diagnose(campaign).diagnosis
    pose = campaign.poses.ids[FIRST]
    (what,) = [cause for cause in found.causes if cause.cause == "unknown"]
    assert "the zero of elbow_joint steps by" in what.structure
    assert f"before pose {pose})" in what.structure
    size = float(re.search(r"steps by (\d+(?:\.\d+)?) µrad", what.structure)[1])
    assert size == pytest.approx(1e6 * STEP, rel=0.1)
    assert f"a step of the zero of elbow_joint before pose {pose}" in found.headline
    assert [c.cause for c in found.causes if c.status == "named"] == ["gear_eccentricity"] * len(effects)


def test_each_step_of_a_zero_is_told_with_its_own_size():
    """As where an encoder slips, and is set anew later."""

    def twice(problem):
        off = stepped(problem)
        off[FIRST + 10 :] *= 1.75
        return off

    campaign = measured("ur5", (), poses=POSES, loads=(), targets=3, joints=twice)
    (what,) = diagnose(campaign).diagnosis.causes
    told = re.findall(r"elbow_joint steps by (\d+) µrad before pose (\w+)\)", what.structure)
    sizes = {pose: float(size) for size, pose in told}
    ids = campaign.poses.ids
    assert sizes == {
        ids[FIRST]: pytest.approx(1e6 * STEP, rel=0.1),
        ids[FIRST + 10]: pytest.approx(0.75e6 * STEP, rel=0.1),
    }


def test_a_sound_robot_has_no_such_step():
    found = diagnose(measured("ur5", (), poses=POSES, loads=(), targets=3)).diagnosis
    assert found.verdict == "nothing_missing"
