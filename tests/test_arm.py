"""NumPy equals Drake; Jacobians equal finite differences."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.robot.beam import bending_compliance
from workbench.robot.compensator import compensator_law
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.robot.equilibrium import NoRest, equilibrium
from workbench.robot.kinematics import frames, point_jacobian
from workbench.robot.loads import Loads, wrenches
from workbench.robot.rigid_plant import arrays, rigid_twin
from workbench.robot.wrench_jacobian import wrench_jacobian
from workbench.simulation.random_robot import write_random_robot

KINDS = ["6R", "7R", "PRRR"]


def some_arm(folder: Path, kind: str):
    robot = load_robot(write_random_robot(folder, 3, kind))
    return robot, arrays(robot)


def some_loads(rng, n_poses, n, compensator=None):
    return Loads(
        rng.uniform(0, 100, n_poses),
        rng.normal(0, 10, (n_poses, 3)),
        rng.normal(0, 200, (n_poses, 6)),
        rng.normal(0, 50, (n_poses, n)),
        compensator,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_frames_equal_drake(tmp_path, kind):
    robot, arm = some_arm(tmp_path, kind)
    twin = rigid_twin(robot)
    rng = np.random.default_rng(0)
    q = rng.uniform(-2, 2, (20, arm.n))
    where = frames(arm, q)
    for i in range(20):
        twin.set_positions(q[i])
        X = twin.plant.GetFrameByName(robot.flange).CalcPoseInWorld(twin.context)
        assert np.abs(X.translation() - where.p[-1, i]).max() < 1e-12
        assert np.abs(X.rotation().matrix() - where.R[-1, i]).max() < 1e-12


@pytest.mark.parametrize("kind", [*KINDS, "kr500"])
def test_loaded_equilibrium_equals_drake(tmp_path, kind):
    robot = load_robot("kr500" if kind == "kr500" else write_random_robot(tmp_path, 3, kind))
    rng = np.random.default_rng(1)
    arm = arrays(robot)
    arm = arm.with_geometry(
        1e-3 * rng.normal(size=(arm.slots, 6)) * (np.arange(arm.slots)[:, None] % (arm.n + 1) > 0)
    )
    compliance = arm.compliance.copy()
    for slot in range(arm.slots):
        compliance[slot, [3, 4], [3, 4]] += 3e-8
        compliance[slot] += 2e-8 * bending_compliance(arm.p[slot])
    arm = replace(arm, compliance=compliance)
    n_poses = 6
    q = rng.uniform(-1, 1, (n_poses, arm.n))
    loads = some_loads(rng, n_poses, arm.n, compensator_law(robot, arm))
    direct = 1e-3 * rng.normal(size=(n_poses, arm.slots, 6))

    def law(local):
        return np.einsum("sij,nsj->nsi", arm.compliance, local)

    motion, where, _ = equilibrium(arm, q, direct, loads, law)
    every = [(slot, c) for slot in range(arm.slots) for c in range(6)]
    twin = elastic_twin(arm, robot, None, every, loads.compensator)
    for i in range(n_poses):
        one = Loads(
            *(x[i : i + 1] for x in (loads.mass, loads.moment, loads.wrench, loads.torque)), loads.compensator
        )
        there = twin.equilibrium(q[i], direct[i], one)
        assert np.abs(there - motion[i]).max() < 1e-11
        tip = twin.points(np.array([[0.1, 0.2, 0.3]]), [arm.n + 1])
        assert np.abs(tip - where.points(np.array([[0.1, 0.2, 0.3]]), [arm.n + 1])[i]).max() < 1e-10


@pytest.mark.parametrize("before", [True, False], ids=["geometry", "motion"])
@pytest.mark.parametrize("kind", [*KINDS, "kr500"])
def test_jacobians_equal_finite_differences(tmp_path, kind, before):
    robot = load_robot("kr500" if kind == "kr500" else write_random_robot(tmp_path, 3, kind))
    arm = arrays(robot)
    rng = np.random.default_rng(2)
    n_poses = 3
    q = rng.uniform(-1, 1, (n_poses, arm.n))
    loads = some_loads(rng, n_poses, arm.n, compensator_law(robot, arm))
    base = 1e-2 * rng.normal(size=(arm.slots, 6))
    arm = arm.with_geometry(base)
    motion = 1e-2 * rng.normal(size=(n_poses, arm.slots, 6))
    targets, on = rng.normal(size=(3, 3)), [arm.n + 1, 0, 2]
    where = frames(arm, q, motion)
    rows = np.arange(6 * arm.slots)
    axes, origin = (where.geometry_axes, where.geometry_origin) if before else (where.axes, where.origin)
    J = point_jacobian(axes, origin, where.points(targets, on), on)
    load = wrenches(arm, where, loads)
    H = wrench_jacobian(arm, where, loads, load, rows, axes, origin, before)

    def shifted(slot, c, h):
        if before:
            g = base.copy()
            g[slot, c] += h
            there = frames(arm.with_geometry(g), q, motion)
            return there, wrenches(arm.with_geometry(g), there, loads)
        m = motion.copy()
        m[:, slot, c] += h
        there = frames(arm, q, m)
        return there, wrenches(arm, there, loads)

    for slot in range(1 if before else 0, arm.slots - (1 if before else 0)):
        for c in range(6):
            (a, wa), (b, wb) = shifted(slot, c, 1e-5), shifted(slot, c, -1e-5)
            fd = (a.points(targets, on) - b.points(targets, on)) / 2e-5
            assert np.abs(fd - J[..., 6 * slot + c]).max() < 1e-8
            fd = (wa.local - wb.local).reshape(n_poses, -1) / 2e-5
            scale = 1e-7 * np.abs(load.local).max() + 1e-7 * np.abs(fd).max()
            assert np.abs(fd - H[:, :, 6 * slot + c]).max() < scale


def test_an_arm_that_runs_away_finds_no_rest_and_nothing_overflows(tmp_path):
    """A frame shifts with the square of the moment on it, which grows with that; warnings are errors here."""
    _, arm = some_arm(tmp_path, "6R")
    q = np.zeros((3, arm.n))
    still = np.zeros((3, arm.slots, 6))
    loads = some_loads(np.random.default_rng(1), 3, arm.n)
    with pytest.raises(NoRest, match="finds no rest"):
        equilibrium(arm, q, still, loads, lambda wrench: wrench[..., ::-1] ** 2)


def test_what_never_settles_is_named_without_poses(tmp_path):
    _, arm = some_arm(tmp_path, "6R")
    rounds = iter(range(1000))

    def to_and_fro(wrench):
        motion = np.zeros_like(wrench)
        motion[:, 2] = 1e-4 * (-1.0) ** next(rounds)
        return motion

    loads, still = some_loads(np.random.default_rng(1), 3, arm.n), np.zeros((3, arm.slots, 6))
    with pytest.raises(NoRest, match=rf"\({arm.names[1]} yields most; little, but without end\)"):
        equilibrium(arm, np.zeros((3, arm.n)), still, loads, to_and_fro)


def test_what_runs_away_is_named_with_its_poses(tmp_path):
    """Only the second pose bears a load that the soft joint does not."""
    _, arm = some_arm(tmp_path, "6R")
    loads = some_loads(np.random.default_rng(1), 3, arm.n)
    still = np.zeros((3, arm.slots, 6))

    def soft(wrench):
        motion = np.zeros_like(wrench)
        motion[1, 2] = 1e3 * wrench[1, 2]
        return motion

    with pytest.raises(NoRest, match=rf"\({arm.names[1]} yields most; in at least 1 pose\)"):
        equilibrium(arm, np.zeros((3, arm.n)), still, loads, soft)
