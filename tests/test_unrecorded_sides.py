"""Play of joints that came from either side, which nobody recorded: scatter between poses, and no gear."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, diagnose, load_robot, planned, random_poses, simulate
from workbench.campaign.planned import TARGETS
from workbench.campaign.problem import problem_of
from workbench.diagnosis.noise.scatter import with_scatter
from workbench.diagnosis.prepared import prepare
from workbench.effects.base import UNKNOWN
from workbench.identification.fit import refit
from workbench.simulation.virtual_campaign import random_geometry

SIGMA = 3e-5


def measured(name, seed, joints, *, play=50e-6, wheel=0.0, poses=40, targets=3, recorded=False):
    """`poses` random poses, each come to from some side. joints: numbers of those with a play, not the same
    all around, or with a wheel out of centre, not quite round (`wheel` [rad])."""
    robot = load_robot(name)
    rng = np.random.default_rng(seed)
    q = random_poses(robot, poses, rng)
    side = rng.choice([-1.0, 1.0], size=q.shape)
    plan = planned(robot, q, targets=TARGETS[:targets], direction=side if recorded else None)
    mine = np.isin(np.arange(q.shape[1]), joints)
    off = -play * side * (1 + 0.2 * np.sin(q + 1.0))
    off = off + wheel * (np.sin(q + 0.4) + 0.15 * np.sin(2 * q + 2.0) + 0.05 * np.sin(3 * q))
    truth = Truth(
        geometry=random_geometry(problem_of(plan).arm, rng),
        joints=lambda job: np.where(mine, off, 0.0),
        sigma=SIGMA,
        repeatability=np.zeros(len(robot.joints)),
    )
    return simulate(plan, truth, seed=seed)


def named(campaign):
    found = diagnose(campaign).diagnosis
    return [finding.label for finding in found.causes if finding.cause != UNKNOWN]


@pytest.mark.parametrize(
    ("name", "joints", "play", "poses", "targets", "seed"),
    [
        ("kr120", [0], 50e-6, 40, 3, 5),
        pytest.param("kr500", [0], 50e-6, 50, 3, 9, marks=pytest.mark.slow),
        pytest.param("ur10", [1], 50e-6, 60, 3, 28, marks=pytest.mark.slow),
        ("iiwa7", [0], 250e-6, 30, 1, 33),
        pytest.param("ur5", [1, 2], 250e-6, 45, 3, 7, marks=pytest.mark.slow),
        ("kr500", [0, 1], 250e-6, 30, 3, 18),
    ],
)
def test_play_on_sides_that_nobody_recorded_is_no_gear(name, joints, play, poses, targets, seed):
    assert named(measured(name, seed, joints, play=play, poses=poses, targets=targets)) == []


@pytest.mark.parametrize("poses", [30, 60, 150])
def test_the_joint_that_scatters_is_found_however_few_the_poses(poses):
    geometry = prepare(measured("ur10", 3, [1], poses=poses)).geometry
    noise = with_scatter(geometry, geometry.noise)
    fitted = refit(replace(geometry, noise=noise), ())  # under the scatter that was found
    again = with_scatter(fitted, geometry.noise)
    for one in (noise, again):
        assert np.flatnonzero(one.joint).tolist() == [1]
        assert one.joint[1] == pytest.approx(50e-6, rel=0.25)
        assert one.body == (0.0, 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_clean_poses_scatter_in_no_joint(seed):
    geometry = prepare(measured("ur10", seed, [], poses=30)).geometry
    noise = with_scatter(geometry, geometry.noise)
    assert not noise.joint.any()
    assert noise.body == (0.0, 0.0)


@pytest.mark.parametrize("seed", [1, 4, 10])
def test_play_on_recorded_sides_does_not_hide_in_the_scatter_that_it_makes(seed):
    found = named(measured("rx170", seed, range(6), poses=30, targets=1, recorded=True))
    assert sorted(found) == ["backlash(joint_1)", "backlash(joint_2)", "backlash(joint_3)"]


@pytest.mark.parametrize("name", ["ur10", "ur5"])
def test_a_wheel_out_of_centre_is_found_without_sides(name):
    campaign = measured(name, 1, [1], play=0.0, wheel=2.5e-4)
    joint = load_robot(name).joint_names[1]
    assert named(campaign) == [f"gear_eccentricity({joint})"]
