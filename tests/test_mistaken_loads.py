"""Wrenches and gravity that are stated otherwise than they acted are told as that, and not as causes."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import assert_slopes

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
from workbench.diagnosis.data_faults.other_wrenches import _slips
from workbench.diagnosis.prepared import prepare
from workbench.effects.unnamed.loads import StatedForces
from workbench.files.faults import InputError
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model

WEAK = "joint_compliance:joint=joint_3,relative=0.4"


SOFT = tuple(
    f"joint_compliance:joint={joint},compliance={value}"
    for joint, value in (
        ("shoulder_pan_joint", 1.6e-5),
        ("shoulder_lift_joint", 2e-5),
        ("elbow_joint", 3.3e-5),
        ("wrist_1_joint", 6e-5),
        ("wrist_2_joint", 8e-5),
        ("wrist_3_joint", 1e-4),
    )
)  # of an arm that states none
OTHERWISE = tuple(
    f"joint_compliance:joint=joint_{j},relative={value}"
    for j, value in enumerate((0.43, -0.29, 0.54, -0.23, 0.33, 0.67), 1)
)
ARMS = pytest.mark.parametrize(
    ("name", "hidden"), [("kr500", OTHERWISE), ("ur10", SOFT)], ids=["all six otherwise", "none stated"]
)


def pulled(
    *hidden: str, seed: int = 3, name: str = "kr500", at: tuple[float, ...] = (0, 0, 0), pull: float = 1.0
) -> Campaign:
    """Some poses of a robot, each free and under some pull, at a point in the flange's frame [m]."""
    robot, rng = load_robot(name), np.random.default_rng(seed)
    q = np.repeat(random_poses(robot, 25, rng), 2, axis=0)
    wrench = np.zeros((len(q), 6))
    wrench[1::2, :3] = rng.normal(size=(25, 3)) * pull * (900.0 if name == "kr500" else 60.0)
    lever = problem(planned(robot, q)).rigid.R[-1] @ np.array(at)
    wrench[:, 3:] = np.cross(lever, wrench[:, :3])
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


def refused(seen: Campaign, wrench: np.ndarray) -> str:
    """What is said of a campaign with these wrenches."""
    with pytest.raises(InputError) as caught:
        prepare(seen.with_poses(wrench=wrench))
    (fault,) = caught.value.faults
    return f"{fault.what}; {fault.mend}"


@ARMS
def test_wrenches_are_told_whatever_the_stiffness(name: str, hidden: tuple[str, ...]) -> None:
    """All links weigh minus once, or a tenth of, what the URDF says, for sure, was the verdict on an arm that
    states no stiffness; and joints 93 % softer than stated on one that does."""
    seen = pulled(*hidden, name=name)
    assert "the other way round" in refused(seen, reversed_(seen))
    assert "along the flange's axes" in refused(seen, of_the_flange(seen))
    said = refused(seen, seen.poses.wrench / 9.80665)
    assert "were kilograms for newtons written?" in said
    assert "the links' masses are 9.81 times too large" in said
    large = refused(seen, 9.80665 * seen.poses.wrench)
    assert "the links' masses are 9.81 times too small" in large


@ARMS
def test_wrenches_along_the_instruments_axes_are_told(name: str, hidden: tuple[str, ...]) -> None:
    seen = pulled(*hidden, name=name)
    R = start_state(problem(seen)).R[0]
    mixed = np.concatenate([part @ R.T for part in np.split(seen.poses.wrench, 2, axis=1)], axis=1)
    assert "along the instrument's axes, which" in refused(seen, mixed)


@ARMS
def test_forces_whose_moments_are_left_out_are_told_with_their_point(
    name: str, hidden: tuple[str, ...]
) -> None:
    """A cable at the tool's tip, of which its force alone is written: a soft wrist joint and a link that
    bends were the verdict."""
    seen = pulled(*hidden, name=name, at=(0.05, 0.1, 0.3), pull=2.0)
    alone = seen.poses.wrench.copy()
    alone[:, 3:] = 0.0
    said = refused(seen, alone)
    point = [float(value) for value in re.findall(r"at (-?\d+) (-?\d+) (-?\d+) mm", said)[0]]
    assert point == pytest.approx([50, 100, 300], abs=25)
    assert "lever × force" in said


def test_forces_that_hardly_show_where_they_act_are_remarked() -> None:
    seen = pulled(*OTHERWISE, at=(0.05, 0.1, 0.3))
    alone = seen.poses.wrench.copy()
    alone[:, 3:] = 0.0
    (said,) = [note for note in prepare(seen.with_poses(wrench=alone)).notes if "forces" in note]
    assert said.startswith("fx ... mz: ")  # columns, as they are called
    assert "lever × force" in said


def test_another_unit_is_remarked_where_no_weight_tells_it() -> None:
    """A robot that is stiffer than stated everywhere would look the same: nothing is refused."""
    weightless = replace(load_robot("kr500"), gravity=(0.0, 0.0, 0.0))
    seen = pulled()
    plan = planned(weightless, seen.poses.q, wrench=seen.poses.wrench)
    seen = simulate(plan, Truth(sigma=3e-5), seed=3)
    kilograms = prepare(seen.with_poses(wrench=seen.poses.wrench / 9.80665))
    (said,) = [note for note in kilograms.notes if "wrenches" in note]
    assert "9.81 times as large" in said
    assert "were kilograms for newtons written?" in said


@ARMS
def test_right_wrenches_at_their_point_are_no_mistake(name: str, hidden: tuple[str, ...]) -> None:
    assert not [
        note
        for note in prepare(pulled(*hidden, name=name, at=(0.05, 0.1, 0.3))).notes
        if "yields as under" in note
    ]


@pytest.mark.parametrize("hidden", [(), (WEAK,), ("joint_compliance:joint=joint_2,relative=2.0",)])
def test_right_wrenches_are_no_mistake(hidden: tuple[str, ...]) -> None:
    assert not [note for note in prepare(pulled(*hidden)).notes if "yields as under" in note]


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


@pytest.mark.parametrize(
    ("slip", "said"),
    [
        (lambda row: -row, "a wrench the other way round"),
        (lambda row: row * [10, 1, 1, 1, 1, 1], "a tenth of fx"),
        (lambda row: row * [1, 1, -1, 1, 1, 1], "fz the other way round"),
    ],
    ids=["reversed", "a decimal point", "a sign"],
)
def test_a_slip_of_the_pen_in_one_wrench_is_told_and_mended(
    slip: Callable[[np.ndarray], np.ndarray], said: str
) -> None:
    """All targets of the pose were outliers, and nothing said why."""
    seen = pulled(*OTHERWISE, pull=3.0)
    row = int(np.abs(seen.poses.wrench[:, [0, 2]]).min(axis=1).argmax())
    wrench = seen.poses.wrench.copy()
    wrench[row] = slip(wrench[row])
    found = prepare(seen.with_poses(wrench=wrench))
    (fault,) = found.faults
    assert (fault.kind, fault.pose_id) == ("wrong_wrench", seen.poses.ids[row])
    assert f"the points fit {said}, not as written" in fault.what
    assert np.allclose(found.problem.campaign.poses.wrench[row], seen.poses.wrench[row])


def test_a_joint_is_no_surer_than_the_load_cell() -> None:
    """Forces that are all a few hundredths off are nothing that is told: all that yields to them is as much
    softer."""
    seen = pulled(WEAK)
    outcome = diagnose(seen.with_poses(wrench=seen.poses.wrench / 1.04))
    (joint,) = [one for one in outcome.diagnosis.causes if one.cause == "joint_compliance"]
    (relative,) = joint.parameters
    effects = outcome.fit.model.effects
    (i,) = [i for i, e in enumerate(effects) if e.key == (joint.cause, joint.where)]
    alone = outcome.fit.effect_values(i)[1][0, 0]
    assert relative.std**2 - alone > (1.4 * 0.015) ** 2  # of 1.4, as a cell of 2 % leaves it beside gravity
    assert abs(relative.value - 0.4) < 2 * relative.std


def test_forces_a_little_larger_pull_as_these_forces_do() -> None:
    seen = problem(pulled(WEAK))
    result = fit(Model(seen))
    (forces,) = StatedForces.sites(seen)
    assert_slopes(result, forces, np.array([0.1]))
    _, loads = forces.apply(seen, seen.arm, seen.loads, np.array([0.1]))
    assert np.allclose(loads.wrench, 1.1 * seen.campaign.poses.wrench)


def test_the_first_pose_has_none_before_and_the_last_none_after():
    seen = pulled()
    wrench, meant = seen.poses.wrench, dict(_slips(seen))
    before, after = meant["the wrench of the pose before"], meant["the wrench of the next pose"]
    assert (before[1:] == wrench[:-1]).all()
    assert (after[:-1] == wrench[1:]).all()
    assert (before[0] == wrench[0]).all()
    assert (after[-1] == wrench[-1]).all()
