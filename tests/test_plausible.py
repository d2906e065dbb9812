"""Joints, points and robot that do not belong together are named, and an honest robot never is."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.campaign import Campaign, Target, write_campaign
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.cli.main import main
from workbench.files.faults import InputError
from workbench.identification.plausible import check_plausible, judge
from workbench.robot.description import load_robot
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate

ROBOTS = ("ur5", "kr500", "6R")


@cache
def honest(name="ur5", count=3) -> Campaign:
    return measured(name, poses=40, loads=(), targets=count)


def joints(campaign, change):
    q = campaign.poses.q.copy()
    change(q)
    return campaign.with_poses(q=q)


def points(campaign, change):
    return replace(campaign, points=change(campaign.points.copy()))


def flip(j):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), -q[:, j]))


def turn(j, degrees):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), q[:, j] + np.radians(degrees)))


def swap(i, j):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), [i, j]), q[:, [j, i]]))


def couple(j, i, sign):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), q[:, j] + sign * q[:, i]))


def column(j, factor):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), q[:, j] * factor))


BLUNDERS = {
    **{f"joint {j + 1} flipped": (flip(j), f"sign of q{j + 1}") for j in (1, 2, 4)},
    "joints 2 and 3 exchanged": (swap(1, 2), "columns q2 and q3"),
    "zero of joint 2 by 90": (turn(1, 90), "add -90° to q2"),
    "zero of joint 5 by 180": (turn(4, 180), "add +180° to q5"),
    "zero of joint 6 by 90": (turn(5, 90), "add -90° to q6"),
    "joint 3 coupled": (couple(2, 1, 1.0), "write q3 minus q2 into the column q3"),
    "joint 5 coupled to 6": (couple(4, 5, 1.0), "write q5 minus q6 into the column q5"),
    "left-handed": (lambda c: points(c, lambda z: z * [1, -1, 1]), "left-handed"),
    "y and z exchanged": (lambda c: points(c, lambda z: z[..., [0, 2, 1]]), "left-handed"),
    "inches as mm": (lambda c: points(c, lambda z: z / 25.4), "points fit the robot only if they are inches"),
    "cm as mm": (lambda c: points(c, lambda z: z / 10), "points fit the robot only if they are centimetres"),
    "x in metres": (lambda c: points(c, lambda z: z * [1e-3, 1, 1]), "x fit the robot only if they are m"),
    "a row too many": (lambda c: points(c, lambda z: np.roll(z, 1, axis=0)), "every point belongs to the"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("blunder", "name"), [(blunder, ROBOTS[i % len(ROBOTS)]) for i, blunder in enumerate(BLUNDERS)]
)
def test_a_mistake_is_named_with_its_mend(blunder, name):
    spoil, said = BLUNDERS[blunder]
    with pytest.raises(InputError) as caught:
        check_plausible(problem_of(spoil(honest(name))))
    assert said in str(caught.value)


@pytest.mark.parametrize("blunder", ["joint 3 flipped", "inches as mm"])
def test_a_mistake_is_named_without_stated_targets(blunder):
    spoil, said = BLUNDERS[blunder]
    blind = replace(honest(count=1), targets=(Target("T1"),))
    with pytest.raises(InputError) as caught:
        check_plausible(problem_of(spoil(blind)))
    assert said in str(caught.value)


def test_two_mistakes_at_once_are_both_named():
    spoilt = points(flip(2)(honest()), lambda z: z / 25.4)
    with pytest.raises(InputError) as caught:
        check_plausible(problem_of(spoilt))
    assert {fault.place for fault in caught.value.faults} == {"campaign.toml: poses", "campaign.toml: points"}
    assert "turns the other way" in str(caught.value)
    assert "inches" in str(caught.value)


def test_the_right_robot_is_named():
    other = load_robot("ur10")
    with pytest.raises(InputError, match='say robot = "ur5"'):
        check_plausible(problem_of(replace(honest(), robot=other)))


def shuffled(z):
    return z[np.random.default_rng(0).permutation(len(z))]


@pytest.mark.parametrize(
    "spoil",
    [
        shuffled,
        lambda z: np.broadcast_to(z[:1], z.shape).copy(),
        lambda z: np.random.default_rng(1).normal(size=z.shape),
        lambda z: 0.87 * z,
    ],
    ids=["shuffled", "all equal", "random", "a smaller robot"],
)
def test_what_fits_nothing_is_refused(spoil):
    with pytest.raises(InputError) as caught:
        check_plausible(problem_of(points(honest(), spoil)))
    assert any(word in str(caught.value) for word in ("none of the usual mistakes", "0.87 times"))


def test_targets_stated_for_one_another_are_only_remarked():
    one, two, three = honest().targets
    renamed = replace(honest(), targets=(replace(one, xyz=two.xyz), replace(two, xyz=one.xyz), three))
    (said,) = check_plausible(problem_of(renamed))
    assert "targets T1, T2 are stated for one another" in said
    fixed = replace(renamed, targets=tuple(replace(target, fixed=True) for target in renamed.targets))
    with pytest.raises(InputError, match="stated for one another"):
        check_plausible(problem_of(fixed))


@pytest.mark.parametrize("kind", ["6R", "7R"])
@pytest.mark.parametrize("seed", range(4))
def test_an_inaccurate_robot_is_no_mistake(tmp_path, kind, seed):
    robot = load_robot(write_random_robot(tmp_path, seed, kind))
    rng = np.random.default_rng(seed)
    targets = TARGETS[: 1 + 2 * (seed % 2)]
    plan = planned(robot, random_poses(robot, 40, rng), targets=targets)
    job = problem_of(plan)
    truth = Truth(geometry=random_geometry(job.arm, rng, 2e-3, 2e-3), sigma=1e-4)
    found = judge(problem_of(simulate(plan, truth, seed=seed)))
    assert not found.refused
    assert found.misfit.total < 0.01


def test_the_command_line_refuses_and_writes_nothing(tmp_path, capsys):
    path = str(write_campaign(tmp_path / "c", flip(2)(honest())))
    out = tmp_path / "out"
    assert main(["diagnose", path, "--out", str(out)]) == 2
    assert "turn the sign of q3" in capsys.readouterr().err
    assert not out.exists()
    assert main(["plan", path, "--quick", "--out", str(tmp_path / "p.csv")]) == 2
    assert "turn the sign of q3" in capsys.readouterr().err
