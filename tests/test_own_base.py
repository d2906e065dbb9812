"""A model is kept in the base that the robot stands on, whatever a fit makes of its tilt against gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workbench.campaign import Target
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.correction.command import compensate
from workbench.correction.conditions import Conditions
from workbench.correction.paths import Path
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.telling.facts import geometry as geometry_of
from workbench.diagnosis.telling.facts import unidentifiable
from workbench.identification.fit import Fit, fit
from workbench.identification.model import Model
from workbench.identification.model_file import write_fit
from workbench.identification.noise import Covariance
from workbench.identification.own_base import own_base
from workbench.robot.description import load_robot
from workbench.robot.rigid_plant import arrays
from workbench.simulation.export import export
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate

SIGMA = 1e-4  # m
ON_BASE = tuple(
    Target(f"B{i}", place, on="base", fixed=True)
    for i, place in enumerate([(0.5, 0.4, 0.0), (-0.5, 0.4, 0.1), (0.0, -0.6, 0.0)])
)
LOAD = ("heavy", 250.0, (0.15, 0.0, 0.05))


@pytest.fixture(scope="module")
def truth() -> Truth:
    """Errors everywhere but in how axis 1 stands in the base."""
    robot = load_robot("kr500")
    plan = problem_of(planned(robot, random_poses(robot, 5, np.random.default_rng(0))))
    geometry = random_geometry(plan.arm, np.random.default_rng(3))
    geometry[1] = 0.0
    return Truth(geometry=geometry, sigma=SIGMA)


def fitted(truth: Truth, *targets: Target) -> Fit:
    robot = load_robot("kr500")
    q = random_poses(robot, 60, np.random.default_rng(1))
    plan = planned(
        robot, q, targets=(*TARGETS, *targets), payloads={LOAD[0]: LOAD[1:]}, payload=[LOAD[0]] * len(q)
    )
    problem = problem_of(simulate(plan, truth, seed=1))
    noise = Covariance(np.full(problem.seen.shape, SIGMA), np.zeros(problem.arm.n), np.ones(len(q)))
    return fit(Model(problem), noise=noise)


def test_a_corrected_path_lies_in_the_robots_own_base(truth, tmp_path):
    """Gravity says where axis 1 stands to milliradians: a program that takes that for an error of the robot
    is turned by as much, and was worse than without correction."""
    found = fitted(truth)
    tilt = np.linalg.norm(found.state.geometry[1, 3:5])
    assert tilt > 3e-4
    write_fit(tmp_path / "model.toml", found)
    model, robot = load_robot(tmp_path / "model.toml"), load_robot("kr500")
    q = np.linspace([0.1, -1.2, 1.5, 0.2, 0.9, 0.1], [0.5, -1.0, 1.3, 0.4, 0.7, -0.2], 40)
    done = compensate(model, Path(np.arange(40.0), q=q), Conditions(*LOAD))
    assert any("no target on the base was measured" in note for note in done.notes)
    assert any("calibrated" in note and "take the tool anew" in note for note in done.notes)

    def off(command: np.ndarray) -> np.ndarray:
        """(120, 3) [m] from where the true robot's targets should be, in its own base. What nothing can tell
        is taken out: how high axis 2 stands over the base, and where joint 1 has its zero."""
        plan = planned(
            robot, command, targets=TARGETS, payloads={LOAD[0]: LOAD[1:]}, payload=[LOAD[0]] * len(command)
        )
        still = replace(truth, sigma=0.0, repeatability=np.zeros(6))
        seen = simulate(plan, still, instrument=(np.eye(3)[None], np.zeros((1, 3)))).points
        X = done.X_desired
        away = seen - X[:, None, :3, 3] - np.einsum("nij,tj->nti", X[:, :3, :3], on_flange)
        up = np.broadcast_to([0.0, 0.0, 1.0], seen.shape)
        A = np.stack([up.ravel(), np.cross(up, seen).ravel()], axis=1)
        return (away.ravel() - A @ np.linalg.lstsq(A, away.ravel())[0]).reshape(-1, 3)

    assert model.uncertainty is not None
    on_flange = 1e-3 * np.array([point.xyz_mm for point in model.uncertainty.points])
    corrected, plain = (np.linalg.norm(off(command), axis=1).max() for command in (done.q_command, q))
    assert corrected < 2e-4
    assert plain > 1e-3


def test_gravity_turns_with_the_base_and_the_tool_stays_where_the_fit_has_it(truth):
    found = fitted(truth)
    problem, g = found.model.problem, found.state.geometry
    kept = own_base(problem, g)
    assert not kept.geometry[1].any()
    assert np.array_equal(kept.geometry[2:], g[2:])
    assert np.linalg.norm(kept.gravity) == pytest.approx(np.linalg.norm(problem.arm.gravity))
    was = replace(problem, arm=problem.arm.with_geometry(g)).nominal_load
    now = replace(problem, arm=kept.arm(problem.arm)).nominal_load
    assert now.local[:, 2:] == pytest.approx(was.local[:, 2:], rel=1e-9, abs=1e-9 * np.abs(was.local).max())


def test_a_base_that_was_measured_stays(truth):
    tilted = truth.geometry.copy()
    tilted[1, 3] = 2e-3
    found = fitted(replace(truth, geometry=tilted), *ON_BASE)
    problem = found.model.problem
    assert problem.base_measured
    kept = own_base(problem, found.state.geometry)
    assert kept.geometry[1, 3] == pytest.approx(2e-3, abs=3e-4)
    assert np.array_equal(kept.gravity, problem.arm.gravity)


BESIDE = Target("F", (0.0, 0.1, 0.05), fixed=True)
OPPOSITE = Target("G", (0.0, -0.1, 0.05), fixed=True)
ON_THE_AXIS = Target("F", (0.005, 0.0, 0.05), fixed=True)


@pytest.mark.parametrize(
    ("fixed", "told"), [((), False), ((ON_THE_AXIS,), False), ((BESIDE,), False), ((BESIDE, OPPOSITE), True)]
)
def test_fixed_targets_beside_the_last_axis_tell_how_the_flange_stands_on_it(fixed, told, tmp_path):
    """Targets that are fitted turn and shift with joint 6: a load beside its axis alone tells its zero from
    these, so faintly that it ran off by milliradians, and a corrected program turned the tool by as much."""
    geometry = np.zeros((8, 6))
    geometry[6, 5] = 1e-3
    robot, true = load_robot("kr500"), Truth(geometry=geometry, sigma=SIGMA)
    q = random_poses(robot, 60, np.random.default_rng(1))
    plan = planned(
        robot, q, targets=(*TARGETS, *ON_BASE, *fixed),
        payloads={LOAD[0]: LOAD[1:]}, payload=[LOAD[0]] * len(q),
    )  # fmt: skip
    problem = problem_of(simulate(plan, true, seed=1))
    assert problem.flange_measured == told
    noise = Covariance(np.full(problem.seen.shape, SIGMA), np.zeros(6), np.ones(len(q)))
    found = fit(Model(problem), noise=noise)
    assert found.state.geometry[6, 5] == pytest.approx(1e-3 if told else 0.0, abs=2e-4 if told else 1e-6)
    assert abs(found.state.geometry[6, 2]) < 1e-6 or fixed
    fitted = {parameter.name for parameter in geometry_of(found)}
    assert ({"joint_6/rz", "joint_6/tz"} <= fitted) == told  # else no number with an interval
    assert told or {"joint_6/rz"} <= set(unidentifiable(found))
    write_fit(tmp_path / "model.toml", found)
    model = load_robot(tmp_path / "model.toml")
    done = compensate(model, Path(np.arange(5.0), q=q[:5]), Conditions(*LOAD))
    header = export(model, "dh", tmp_path / "dh").header
    assert any("take the tool anew" in note for note in done.notes) != told
    assert any(line.startswith("flange: how it stands") for line in header) != told


@pytest.mark.parametrize(
    "off", [pytest.param((2e-4, 0.0, 0.0, 0.0), marks=pytest.mark.slow), (0.0, -1e-4, 0.0, 5e-4)]
)
def test_a_flange_that_stands_off_the_last_axis_is_geometry_and_goes_into_the_model(off, tmp_path):
    """Of targets whose places on it are known. Of a sound robot a `drift` had been named for it."""
    geometry = np.zeros((8, 6))
    geometry[7, [0, 1, 3, 4]] = off
    robot, rng = load_robot("ur5"), np.random.default_rng(3)
    known = tuple(replace(target, fixed=True) for target in TARGETS)
    q = random_poses(robot, 60, rng)
    plan = planned(robot, q, targets=known, time=60.0 * np.arange(60))
    outcome = diagnose(simulate(plan, Truth(geometry=geometry, sigma=SIGMA), seed=4))
    assert outcome.diagnosis.verdict == "nothing_missing"
    found = {parameter.name: parameter for parameter in outcome.diagnosis.geometry}
    for name, value in zip(("tx", "ty", "rx", "ry"), off, strict=True):
        one = found[f"flange/{name}"]
        assert abs(one.value - value) < 4 * one.std < 5e-4
    write_fit(tmp_path / "model.toml", outcome.fit)
    model = load_robot(tmp_path / "model.toml")
    assert arrays(model).geometry[7] == pytest.approx(outcome.fit.state.geometry[7], abs=1e-12)
    loose = fit(Model(problem_of(simulate(planned(robot, q), Truth(geometry=geometry, sigma=SIGMA), seed=4))))
    assert not any(parameter.name.startswith("flange") for parameter in geometry_of(loose))
    assert not any(name.startswith("flange") for name in unidentifiable(loose))
