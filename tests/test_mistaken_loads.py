"""Wrenches and gravity that are stated otherwise than they acted are told as that, and not as causes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from workbench import (
    Campaign,
    Truth,
    diagnose,
    load_robot,
    parse_effect,
    planned,
    problem,
    random_poses,
    simulate,
)
from workbench.diagnosis.prepared import prepare
from workbench.files.faults import InputError

WEAK = "joint_compliance:joint=joint_3,relative=0.4"


def pulled(*hidden: str, seed: int = 3) -> Campaign:
    """Each of some poses of a KR 500 free and under a pull to somewhere."""
    robot, rng = load_robot("kr500"), np.random.default_rng(seed)
    q = np.repeat(random_poses(robot, 25, rng), 2, axis=0)
    wrench = np.zeros((len(q), 6))
    wrench[1::2, :3] = rng.normal(size=(25, 3)) * 900.0
    plan = planned(robot, q, wrench=wrench)
    effects = tuple(parse_effect(text, problem(plan)) for text in hidden)
    return simulate(plan, Truth(effects=effects, sigma=3e-5), seed=seed)


def reversed_(seen: Campaign) -> np.ndarray:
    return -seen.poses.wrench


def of_the_flange(seen: Campaign) -> np.ndarray:
    turn = problem(seen).rigid.R[-1]
    return np.concatenate(
        [np.einsum("nji,nj->ni", turn, part) for part in np.split(seen.poses.wrench, 2, 1)], 1
    )


@pytest.mark.parametrize("hidden", [(), (WEAK,)], ids=["sound", "weak"])
@pytest.mark.parametrize(
    ("mistake", "said", "mend"),
    [
        (reversed_, "wrenches the other way round", "turn their signs"),
        (of_the_flange, "wrenches along the flange's axes, which", "along the axes of its base"),
        (lambda seen: -of_the_flange(seen), "flange's axes the other way round", "what acts on the robot"),
    ],
    ids=["reversed", "flange", "both"],
)
def test_wrenches_that_act_otherwise_are_refused_with_the_mend(
    hidden: tuple[str, ...], mistake: Callable[[Campaign], np.ndarray], said: str, mend: str
) -> None:
    seen = pulled(*hidden)
    with pytest.raises(InputError) as caught:
        diagnose(seen.with_poses(wrench=mistake(seen)))
    (fault,) = caught.value.faults
    assert said in fault.what
    assert mend in fault.mend


def test_another_unit_is_remarked() -> None:
    """A robot that is stiffer than stated everywhere would look the same: nothing is refused."""
    seen = pulled()
    kilograms = prepare(seen.with_poses(wrench=seen.poses.wrench / 9.80665))
    (said,) = [note for note in kilograms.notes if "wrenches" in note]
    assert "9.81 times as large" in said
    assert "were kilograms for newtons written?" in said


@pytest.mark.parametrize("hidden", [(), (WEAK,), ("joint_compliance:joint=joint_2,relative=2.0",)])
def test_right_wrenches_are_no_mistake(hidden: tuple[str, ...]) -> None:
    assert not [note for note in prepare(pulled(*hidden)).notes if "wrenches" in note]


def stands(gravity: tuple[float, float, float], *hidden: str, name: str = "rx170") -> Campaign:
    """Poses of an arm that stands elsewhere than on a floor, with a robot's TOML that says nothing of it."""
    robot = load_robot(name)
    plan = planned(replace(robot, gravity=gravity), random_poses(robot, 60, np.random.default_rng(1)))
    effects = tuple(parse_effect(text, problem(plan)) for text in hidden)
    return replace(simulate(plan, Truth(effects=effects, sigma=3e-5), seed=2), robot=robot)


@pytest.mark.parametrize("name", ["rx170", "kr500"])
@pytest.mark.parametrize("hidden", [(), (WEAK,)], ids=["sound", "weak"])
def test_an_arm_that_hangs_is_no_arm_of_negative_masses(name: str, hidden: tuple[str, ...]) -> None:
    """Its links weigh minus once what the URDF says, for sure, was the verdict."""
    with pytest.raises(InputError) as caught:
        prepare(stands((0.0, 0.0, 9.80665), *hidden, name=name))
    (fault,) = caught.value.faults
    assert "as under 0.00 0.00 9.81 m/s² on the base's axes, not 0.00 0.00 -9.81" in fault.what
    assert "`gravity`" in fault.mend


def test_an_arm_on_a_wall_is_told_to_say_so() -> None:
    """The geometry turns its base by nearly a right angle."""
    with pytest.raises(InputError) as caught:
        prepare(stands((9.80665, 0.0, 0.0)))
    (fault,) = caught.value.faults
    assert fault.what.startswith("ry of joint_1 would have to be ")
    assert "`gravity` in the robot's TOML" in fault.mend


@pytest.mark.parametrize(
    "hidden", [(), (WEAK,), ("link_mass:link=link_3,mass=-20",), ("foundation:compliance=2e-6",)]
)
def test_gravity_as_stated_is_no_mistake(hidden: tuple[str, ...]) -> None:
    prepare(stands((0.0, 0.0, -9.80665), *hidden))
