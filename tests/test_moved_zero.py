"""A robot that was mastered anew between campaigns that are fitted as one, or a scale that is another: told,
with its size, taken out, no cause."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
from diagnosis_cases import measured, named, robot

from workbench.campaign import join, load_campaign, write_campaign
from workbench.campaign.planned import random_poses
from workbench.campaign.problem import problem_of
from workbench.diagnosis.found import FaultFound
from workbench.diagnosis.run import diagnose
from workbench.effects.unnamed.anew import GeometryAnew, ZeroAnew
from workbench.identification.model import Model
from workbench.report.terminal import fault_lines

RUN_OUT = "gear_eccentricity:joint=elbow_joint,variant=1,amplitude=3e-4,phase=0.4"


def of_one_robot(tmp_path, zero, name="ur5", effects=(RUN_OUT,), q=None, poses=40):
    """Two campaigns of one robot, whose zeros (n,) were off by so much in the first; and a third as the
    second."""
    arm = robot(name)
    rng = np.random.default_rng(5)
    each = [random_poses(arm, poses, rng) for _ in range(3)] if q is None else q
    paths = []
    for k, angles in enumerate(each):
        off = np.tile(np.array(zero) * (k == 0), (len(angles), 1))
        campaign = measured(name, effects, q=angles, loads=(), targets=3, joints=lambda _, off=off: off)
        campaign = replace(
            campaign, title=f"c{k + 1}", points=campaign.points + np.array([1.0, -2.0, 0.5]) * k
        )
        paths.append(write_campaign(tmp_path / f"c{k + 1}", campaign))
    return paths


@cache
def last_alone(poses):
    """What the second campaign of one robot says by itself: its zeros are those of any first."""
    _, second, other = of_one_robot(Path(mkdtemp()), [0.0] * 6, poses=poses)
    return diagnose(second, test=other).diagnosis


def test_a_zero_that_moved_is_told_with_its_size_and_hides_no_cause(tmp_path):
    """The corrected robot is the one of the last campaign."""
    zero = [0.0, 0.0, 0.0, 1.5e-3, 0.0, 0.0]
    first, second, other = of_one_robot(tmp_path, zero, poses=25)
    alone = last_alone(25)
    found = diagnose([first, second], test=other).diagnosis
    (fault,) = [one for one in found.faults if one.kind == "moved_zero"]
    size, error = (
        float(v) for v in re.findall(r"(-?\d+(?:\.\d+)?) µrad", fault.what.replace("\N{MINUS SIGN}", "-"))
    )
    assert "wrist_1_joint" in fault.what
    assert size == pytest.approx(1500, abs=4 * error)
    assert error < 30
    assert fault.what in found.headline
    assert set(named(found)) == set(named(alone)) == {("gear_eccentricity", "elbow_joint")}
    assert found.test.after_rms_mm < 1.05 * alone.test.after_rms_mm


def scaled(path, folder, times):
    """The campaign with all points that many times as far from the instrument."""
    campaign = load_campaign(path)
    return write_campaign(folder, replace(campaign, points=times * campaign.points))


@pytest.mark.parametrize(("ppm", "poses"), [(150, 25), pytest.param(-60, 40, marks=pytest.mark.slow)])
def test_a_scale_that_is_another_is_told_with_its_size_and_hides_no_cause(tmp_path, ppm, poses):
    first, second, other = of_one_robot(tmp_path, [0.0] * 6, poses=poses)
    found = diagnose([scaled(first, tmp_path / "scaled", 1 + 1e-6 * ppm), second], test=other).diagnosis
    (fault,) = found.faults
    assert fault.kind == "changed_scale"
    size, error = (float(v) for v in re.findall(r"(\d+(?:\.\d+)?) ppm", fault.what))
    assert size == pytest.approx(abs(ppm), abs=3 * error)
    assert error < 15
    assert ("longer" if ppm > 0 else "shorter") in fault.what
    assert fault.what in found.headline
    assert set(named(found)) == {("gear_eccentricity", "elbow_joint")}
    assert found.test.after_rms_mm < 1.05 * last_alone(poses).test.after_rms_mm


def test_of_many_small_campaigns_those_before_the_crash_are_told(tmp_path):
    rng = np.random.default_rng(21)
    q = [random_poses(robot("ur5"), 15, rng) for _ in range(5)]
    zero = [0.0, 0.0, -2e-3, 0.0, 0.0, 0.0]
    found = diagnose(of_one_robot(tmp_path, zero, effects=(), q=q)).diagnosis
    (fault,) = found.faults
    assert (fault.kind, fault.pose_id) == ("moved_zero", "c1/1")
    assert found.verdict == "nothing_missing"


def test_campaigns_of_one_robot_have_no_zero_that_moved(tmp_path):
    paths = of_one_robot(tmp_path, [0.0] * 6, effects=())
    found = diagnose(paths[:2]).diagnosis
    assert found.faults == ()
    assert found.verdict == "nothing_missing"
    assert not any("`workbench compare`" in note for note in found.notes)


def test_a_wrong_ratio_seen_over_half_the_range_in_each_campaign_is_no_zero_that_moved(tmp_path):
    """Each half of a straight line stands elsewhere."""
    rng = np.random.default_rng(8)
    q = random_poses(robot("ur5"), 200, rng)
    halves = [q[q[:, 2] < 0][:45], q[q[:, 2] > 0][:45]]
    paths = of_one_robot(
        tmp_path, [0.0] * 6, effects=("gear_ratio:joint=elbow_joint,relative=4e-4",), q=halves
    )
    found = diagnose(paths).diagnosis
    assert found.faults == ()
    assert ("gear_ratio", "elbow_joint") in named(found)


@pytest.mark.parametrize("name", ["ur5", "cylindrical"])
def test_joints_counted_as_in_the_last_campaign_are_where_the_effect_has_them(tmp_path, name):
    zero = [0.0] * len(robot(name).joint_names)
    paths = of_one_robot(tmp_path, zero, name, effects=(), poses=12)
    whole = problem_of(join([load_campaign(path) for path in paths]))
    places = ZeroAnew.sites(whole)
    assert [one.where.joint for one in places] == list(whole.arm.names)
    for effect in places:
        values = np.array([1.5e-3, -4e-4])
        model = Model(whole, (effect,))
        there = model.predict(replace(model.in_base(), values=(values,)))
        counted = replace(whole, campaign=effect.as_it_was(whole, values, np.full(2, 1e-5)).campaign)
        assert np.abs(Model(counted).predict(Model(counted).in_base()) - there).max() < 1e-9
        last = whole.campaign.poses.setup == 2
        assert np.array_equal(counted.q[last], whole.q[last])


def test_set_ups_of_a_single_campaign_are_of_one_robot():
    campaign = measured("ur5", poses=20, loads=(), targets=2)
    setups = replace(campaign.with_poses(setup=np.repeat([0, 1], 10)), setup_names=("a", "b"))
    whole = problem_of(setups)
    assert not ZeroAnew.sites(whole)
    assert not GeometryAnew.sites(whole)


def test_two_zeros_that_moved_are_two_lines():
    said = ["the zero of a", "the zero of b"]
    lines = fault_lines([FaultFound("moved_zero", "1", None, what, "counted") for what in said], "fault")
    assert lines == [f"fault: moved_zero at pose 1: {what} (counted)" for what in said]
