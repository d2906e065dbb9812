"""Poses that follow a path without a word of the sides of approach: these are read from their order."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench import (
    Campaign,
    Truth,
    diagnose,
    load_campaign,
    load_robot,
    planned,
    random_poses,
    simulate,
    write_campaign,
)
from workbench.campaign.path_sides import sides_along
from workbench.diagnosis.prepared import prepare

POSES = 160
SETUP = np.zeros(POSES, dtype=np.int64)


def path(seed: int = 0) -> np.ndarray:
    """(N, 6) joints that swing to and fro [rad], each in its time."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, POSES)[:, None]
    return np.array([0.0, -1.2, 1.2, 0.3, 0.8, 0.2]) + 0.5 * np.sin(
        2 * np.pi * (rng.uniform(2, 4, 6) * t + rng.uniform(0, 1, 6))
    )


def measured(folder: Path, joints, seed: int = 1) -> Campaign:
    """What `joints` [rad], of joints and sides, do to a KR 500 on its path, as read from files without a word
    of the sides."""
    q = path()
    side = sides_along(q, SETUP, None)
    assert side is not None
    plan = planned(load_robot("kr500"), q, direction=side)
    seen = simulate(plan, Truth(joints=lambda job: joints(q, side), sigma=3e-5), seed=seed)
    return load_campaign(write_campaign(folder, replace(seen, poses=replace(seen.poses, side=None))))


def test_sides_are_those_of_the_last_motion() -> None:
    q = np.zeros((POSES, 2))
    q[:, 0] = np.r_[np.linspace(0, 1, 80), np.linspace(1, 0.2, 80)]
    q[:, 1] = np.r_[np.zeros(40), np.linspace(0, -1, 120)]
    q[20:30, 0] = q[19, 0] + 1e-7  # stands still
    side = sides_along(q, SETUP, None)
    assert side is not None
    assert side[0].tolist() == [0.0, 0.0]
    assert (side[1:80, 0] == 1).all()
    assert (side[82:, 0] == -1).all()
    assert (side[:40, 1] == 0).all()
    assert (side[42:, 1] == -1).all()


def test_each_set_up_begins_anew_and_time_orders() -> None:
    setup = (np.arange(POSES) >= 100).astype(np.int64)
    side = sides_along(path(), setup, None)
    assert side is not None
    assert (side[100] == 0).all()
    order = np.random.default_rng(3).permutation(POSES)
    shuffled = sides_along(path()[order], SETUP, order.astype(float))
    np.testing.assert_array_equal(shuffled, sides_along(path(), SETUP, None)[order])


def test_poses_in_any_order_say_nothing_of_sides() -> None:
    q = path()[np.random.default_rng(2).permutation(POSES)]
    assert sides_along(q, SETUP, None) is None
    robot = load_robot("kr500")
    assert sides_along(random_poses(robot, 60, np.random.default_rng(1)), SETUP[:60], None) is None
    assert sides_along(np.tile(q[:1], (9, 1)), SETUP[:9], None) is None


def test_a_play_is_found_on_a_path(tmp_path: Path) -> None:
    seen = measured(tmp_path, lambda q, side: -2e-4 * side * np.array([0, 1.0, 0, 0, 0, 0]))
    assert any("the sides of approach are taken from that" in warning for warning in seen.warnings)
    found = diagnose(seen).diagnosis
    assert [(cause.label, cause.status) for cause in found.causes] == [("backlash(joint_2)", "named")]
    (width,) = found.causes[0].parameters
    assert width.value == pytest.approx(2e-4, rel=0.1)


def with_a_wave(folder: Path, seed: int) -> Campaign:
    """Errors by products of joints, which no function in the model has, swing slowly in their order."""

    def joints(q, side):
        wave = np.cos(1.7 * q[:, 0] + 2.3 * q[:, 1] - 1.9 * q[:, 2] + seed) * np.sin(
            2.1 * q[:, 3] + 0.7 * q[:, 4]
        )
        return 4e-4 * wave[:, None] * np.array([1.0, 1.0, 0, 0, 0, 0])

    return measured(folder, joints, seed)


@pytest.mark.parametrize(
    ("seed", "faults"),
    [
        pytest.param(
            3, lambda seen: diagnose(seen).diagnosis.faults, id="beside causes", marks=pytest.mark.slow
        ),
        pytest.param(5, lambda seen: prepare(seen).faults, id="before any"),
    ],
)
def test_what_hangs_together_along_a_path_is_no_step(tmp_path: Path, seed: int, faults) -> None:
    found = faults(with_a_wave(tmp_path, seed))
    assert not [fault for fault in found if fault.kind in ("changed_setup", "moved_instrument")]


def test_an_instrument_that_moved_along_a_path_is_told(tmp_path: Path) -> None:
    seen = measured(tmp_path, lambda q, side: 0.0 * q)
    points = seen.points.copy()
    points[90:] += [3e-4, -2e-4, 1e-4]
    (fault,) = diagnose(replace(seen, points=points)).diagnosis.faults
    assert (fault.kind, fault.pose_id) == ("moved_instrument", "91")
