"""A load that was changed between campaigns that are fitted as one robot, and not stated: told, taken out."""

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
from workbench.diagnosis.run import diagnose
from workbench.effects.unnamed.anew import CarriedAnew
from workbench.identification.model import Model
from workbench.measurement.design.prior_information import from_prepared

RATIO = "gear_ratio:joint=joint_3,relative=3e-4"
STATED = 250.0  # kg


@cache
def carried(*kg, name="kr500", effects=()):
    """Campaigns of one robot, of each half the poses without load and half with so much, `STATED` in all."""
    rng = np.random.default_rng(31)
    folder, paths = Path(mkdtemp()), []
    for k, mass in enumerate(kg):
        q = random_poses(robot(name), 25, rng)
        campaign = measured(name, effects, q=q, loads=(mass,), targets=3)
        stated = np.where(campaign.load_mass > 0, STATED, 0.0)
        points = campaign.points + np.array([1.0, -2.0, 0.5]) * k
        campaign = replace(campaign, title=f"c{k + 1}", load_mass=stated, points=points)
        paths.append(write_campaign(folder / f"c{k + 1}", campaign.some(np.arange(25, 50))))
    return paths


def test_a_load_that_was_changed_is_told_with_its_size_and_hides_no_cause():
    """Not as a zero that moved, nor as a payload that is not as stated in all."""
    first, second, other = carried(STATED, 330.0, STATED, effects=(RATIO,))
    found = diagnose([first, second], test=other).diagnosis
    (fault,) = found.faults
    assert (fault.kind, fault.pose_id) == ("changed_load", "c2/26")
    kg, error = (float(v) for v in re.findall(r"(\d+(?:\.\d+)?) kg", fault.what)[:2])
    assert kg == pytest.approx(330, abs=3 * error)
    assert error < 5
    assert "in c2, where 250 kg are stated" in fault.what
    assert fault.what in found.headline
    assert set(named(found)) == {("gear_ratio", "joint_3")}
    assert found.test.after_rms_mm == pytest.approx(3**0.5 * 0.03, rel=0.15)


def test_poses_of_a_campaign_with_another_load_are_no_outliers():
    paths = carried(STATED, 380.0, STATED)
    found = diagnose(paths).diagnosis
    assert [fault.kind for fault in found.faults] == ["changed_load"]
    assert found.verdict == "nothing_missing"


def test_a_load_that_is_otherwise_than_stated_in_all_campaigns_was_not_changed():
    found = diagnose(carried(330.0, 330.0)).diagnosis
    assert found.faults == ()


def test_a_load_of_one_campaign_alone_is_the_payload():
    """That is the cause with its name: there is nothing that it changed from."""
    bare, loaded = carried(STATED, 330.0)
    without = load_campaign(bare)
    none = without.with_poses(payload=np.zeros(len(without.poses), dtype=np.int64))
    whole = problem_of(join([none, load_campaign(loaded)]))
    assert [one.where.payload for one in CarriedAnew.sites(whole)] == ["c1"]


@pytest.mark.parametrize("values", [[90.0, 10.0, -5.0, 20.0], [-100.0, 2.0, 0.0, -10.0]])
def test_a_load_as_carried_moves_the_arm_as_the_effect_has_it(values):
    whole = problem_of(join([load_campaign(path) for path in carried(STATED, STATED)]))
    for effect in CarriedAnew.sites(whole):
        model = Model(whole, (effect,))
        there = model.predict(replace(model.in_base(), values=(np.array(values),)))
        was = effect.as_it_was(whole, np.array(values), np.full(4, 1e-7))
        assert was is not None
        known = problem_of(was.campaign)
        assert np.abs(Model(known).predict(Model(known).in_base()) - there).max() < 1e-9
        other = whole.campaign.poses.setup != whole.campaign.setup_names.index(effect.where.payload)
        assert np.array_equal(known.campaign.poses.payload[other], whole.campaign.poses.payload[other])


@pytest.mark.parametrize(("kg", "told"), [(-260.0, False), (-251.0, True), (-240.0, True)])
def test_no_arm_carries_less_than_nothing(kg, told):
    whole = problem_of(join([load_campaign(path) for path in carried(STATED, STATED)]))
    moved = np.array([kg, *(kg * whole.campaign.load_com[1])])
    was = CarriedAnew.sites(whole)[0].as_it_was(whole, moved, np.ones(4))
    assert (was is not None) == told


@pytest.mark.parametrize(("kg", "moment", "std"), [(-240.0, 0.0, 1.0), (30.0, 400.0, 2.0)])
def test_no_load_is_mounted_metres_away(kg, moment, std):
    """A first moment that only such a load would have is something else."""
    whole = problem_of(join([load_campaign(path) for path in carried(STATED, STATED)]))
    values = np.array([kg, moment, 0.0, 0.0])
    assert CarriedAnew.sites(whole)[0].as_it_was(whole, values, np.full(4, std)) is None


@pytest.mark.parametrize(("std", "said"), [(2.0, True), (300.0, False)])
def test_a_centre_that_the_data_do_not_show_stays_where_it_is_stated(std, said):
    whole = problem_of(join([load_campaign(path) for path in carried(STATED, STATED)]))
    stated = whole.campaign.load_com[1]
    kg = 60.0
    moved = np.array([kg, *(kg * stated + [90.0, -60.0, 30.0])])  # 0.29, 0.19, 0.1 m away
    was = CarriedAnew.sites(whole)[0].as_it_was(whole, moved, np.array([5.0, std, std, std]))
    ((_, what),) = was.said
    assert what.startswith("the arm carries 310 kg (± 5 kg)")
    assert ("centred" in what) == said
    away = was.campaign.load_com[-1] - stated
    if said:
        assert away == pytest.approx([90 / 310, -60 / 310, 30 / 310], rel=0.01)
    else:
        assert np.linalg.norm(away) < 0.01


def test_an_arm_that_carries_nothing_as_stated_is_as_stated():
    loaded = [load_campaign(path) for path in carried(STATED, STATED)]
    bare = loaded[0].with_poses(payload=np.zeros(len(loaded[0].poses), dtype=np.int64))
    whole = problem_of(join([bare, loaded[1]]))
    (effect,) = CarriedAnew.sites(whole)
    assert effect.as_it_was(whole, np.array([-0.5, 1.0, 0.0, -1.0]), np.ones(4)) is None
    assert effect.as_it_was(whole, np.array([5.0, 1.0, 0.0, -1.0]), np.ones(4)) is not None


def test_set_ups_of_a_single_campaign_are_one_load():
    campaign = measured("kr500", poses=20, targets=2)
    setups = replace(campaign.with_poses(setup=np.repeat([0, 1], 20)), setup_names=("a", "b"))
    assert not CarriedAnew.sites(problem_of(setups))


def test_what_is_of_one_campaign_alone_is_told_by_its_name():
    """Poses, noise and what is left by set-up; a plan measures the targets that are mounted now."""
    first, second = (load_campaign(path) for path in carried(STATED, STATED))
    moved = tuple(replace(t, xyz=tuple(np.add(t.xyz, 0.03))) for t in second.targets)
    rng = np.random.default_rng(4)
    points = second.points + 9e-5 * rng.normal(size=second.points.shape)
    second = replace(second, targets=moved, points=points, noise_sigma=1e-4)
    outcome = diagnose([first, second])
    said = outcome.diagnosis.facts["Set-ups"]
    each = re.findall(r"(c\d): (\d+) poses, (0\.\d+) mm RMS left, noise (0\.\d+) mm", said)
    assert [(name, poses, noise) for name, poses, _, noise in each] == [
        ("c1", "25", "0.030"),
        ("c2", "25", "0.100"),
    ]
    assert float(each[1][2]) > 2 * float(each[0][2])
    prior = from_prepared(outcome.prepared)
    names = [target.name for target in outcome.problem.campaign.targets]
    assert {name for name, shown in zip(names, prior.shown, strict=True) if shown} == {
        f"{target.name} (c2)" for target in second.targets
    }
