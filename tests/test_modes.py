"""Modes of the simulated robot, and what an assumed inertia of a drive has in them."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from workbench.correction.conditions import Conditions
from workbench.correction.paths import Path
from workbench.robot.description import load_robot
from workbench.robot.loop import Loop
from workbench.simulation.closed_loop.drives import drives
from workbench.simulation.closed_loop.machine import machine, mass_matrix
from workbench.simulation.closed_loop.mechanics import mechanics
from workbench.simulation.closed_loop.modes import frequencies, modes


def short(name):
    """A robot that stands near the middle of its ranges, and its joints (2, n)."""
    robot = load_robot(name)
    low = np.array([max(j.lower, -1.5) for j in robot.joints])
    high = np.array([min(j.upper, 1.5) for j in robot.joints])
    q = np.tile(low + 0.45 * (high - low), (2, 1))
    return mechanics(robot, Path(np.array([0.0, 1.0]), q=q), q, Conditions()), q


@pytest.mark.parametrize("name", ["kr500", "rx170", "cylindrical"])
def test_modes_are_those_of_drakes_mass_matrix(name):
    """Drives free: all of motors and springs at once, but for what turns without a spring."""
    truth, q = short(name)
    built = machine(truth, drives(truth, q[0], Loop()))
    stiffness = np.zeros(built.plant.num_velocities())
    stiffness[built.springs] = built.stiffness
    squared = scipy.linalg.eigh(np.diag(stiffness), mass_matrix(built, q[0]), eigvals_only=True)
    n = truth.arm.n
    assert np.abs(squared[:n]).max() < 1e-6 * squared[n]
    assert frequencies(built, q[0], free=True) == pytest.approx(np.sqrt(squared[n:]), rel=1e-6)
    locked = frequencies(built, q[0], free=False)
    assert (locked <= frequencies(built, q[0], free=True) + 1e-9).all()


def test_an_assumed_inertia_is_weighed_by_the_modes():
    """Half of it is what a robot has whose TOML states that half; locked drives do not feel it."""
    truth, q = short("longlink")  # no drive's inertia is stated
    drive = drives(truth, q[0], Loop())
    found = modes(truth, drive, q[0])
    assert found.guessed == truth.arm.names
    assert found.halved[0] > 1.02 * found.free[0] > 1.02**2 * found.doubled[0] > 1.02**2 * found.locked[0]
    stated = tuple(
        replace(
            joint, data=joint.data.model_copy(update={"gear_ratio": 100.0, "rotor_inertia": 0.5e-4 * inertia})
        )
        for joint, inertia in zip(truth.robot.joints, drive.rotor.tolist(), strict=True)
    )
    told = replace(truth, robot=replace(truth.robot, joints=stated))
    again = modes(told, drives(told, q[0], Loop()), q[0])
    assert again.free == pytest.approx(found.halved, rel=1e-9)
    assert again.locked == pytest.approx(found.locked, rel=1e-9)
    assert (again.guessed, again.halved) == ((), ())
    assert any("doubled" in said for _, said in found.facts())
    assert not any("doubled" in said for _, said in again.facts())
