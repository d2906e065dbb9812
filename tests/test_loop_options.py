"""What `verify` says of drives that lead, of a sweep of speeds, and of models that no spring follows."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from workbench import Path, compensate, load_robot, parse_effect, path_shapes, planned, problem_of, record
from workbench.correction.conditions import Conditions
from workbench.correction.path_shapes import work_frame
from workbench.files.faults import InputError
from workbench.robot.description import Robot
from workbench.robot.loop import Loop
from workbench.simulation.closed_loop.drives import drives
from workbench.simulation.closed_loop.lag import OF_LOWEST_MODE, lead_hz
from workbench.simulation.closed_loop.measures import figures
from workbench.simulation.closed_loop.mechanics import mechanics
from workbench.simulation.closed_loop.modes import modes
from workbench.simulation.closed_loop.runs import Task, World, simulate
from workbench.simulation.closed_loop.springs import tabulated
from workbench.simulation.closed_loop.sweep import _rms
from workbench.simulation.closed_loop.verification import Series, Sweep, sweep_said

Q = np.array([0.3, -1.0, 1.2, 0.4, 0.7, 0.2])


def with_effects(name: str, *texts: str) -> Robot:
    robot = load_robot(name)
    job = problem_of(planned(robot, np.zeros((1, len(robot.joints)))))
    return replace(robot, effects=tuple(record(*parse_effect(text, job)) for text in texts))


def held(robot: Robot) -> Any:
    """The simulated robot on a path that stands still."""
    return mechanics(
        robot, Path(np.array([0.0, 1.0]), q=np.tile(Q, (2, 1))), np.tile(Q, (2, 1)), Conditions()
    )


def test_a_lead_that_would_excite_the_arm_is_slower_than_its_lowest_mode():
    arm = held(load_robot("kr500"))
    slow, fast = Loop(feed_forward_hz=1.0), Loop(feed_forward_hz=500.0)
    lowest = modes(arm, drives(arm, Q, fast), Q).locked[0]
    assert lowest > 2
    assert lead_hz(arm, slow, Q) == 1.0
    assert lead_hz(arm, fast, Q) == pytest.approx(OF_LOWEST_MODE * lowest)
    rigid = held(with_effects("ur5"))
    assert lead_hz(rigid, fast, Q) == 500.0  # nothing yields


def test_the_lag_that_is_led_is_that_of_the_controller_that_the_model_states():
    """The true one has other gains: what the model does not know is not taken off."""
    robot = load_robot("kr500")
    run = path_shapes.Run(work_frame((1.7, 0.2, 0.9)), speed=0.3, acceleration=2.0, period=0.01)
    path = path_shapes.line(0.1, run)
    command = compensate(robot, path, Conditions())
    other = robot.loop.model_copy(update={"gain_factor": 0.5})
    task = Task("led", path, command.q_command, command.X_desired, ahead="loop")

    def left(known: Loop) -> float:
        done = simulate(World(robot, robot, Conditions(), None, other, known=known), task)
        return float(np.linalg.norm(done.tool[:, :3, 3] - command.X_desired[:, :3, 3], axis=1).max())

    assert left(robot.loop) > 1.5 * left(other)


def test_what_leaves_least_is_what_is_told():
    def trial(rms: float) -> Any:
        return SimpleNamespace(figures=SimpleNamespace(rms_mm=rms))

    runs = {"uncorrected": 2.0, "corrected": 0.2, "elastic": 0.03, "loop": 0.11, "perfect": 0.01}
    series: Any = SimpleNamespace(trials={name: trial(rms) for name, rms in runs.items()})
    assert Series.best.fget(series) == "elastic"  # type: ignore[attr-defined]


def test_a_sweep_counts_points_by_their_time_and_says_between_which_speeds():
    time = np.array([0.0, 1.0, 1.01, 1.02, 2.0])
    error = np.array([[1, 0, 0], [1, 0, 0], [9, 0, 0], [1, 0, 0], [1, 0, 0]]) * 1e-3
    X = np.tile(np.eye(4), (5, 1, 1))
    drawn = X.copy()
    drawn[:, :3, 3] += error
    task: Any = SimpleNamespace(X=X, path=SimpleNamespace(time=time))
    found: Any = SimpleNamespace(tool=drawn)
    table = figures(error, error, error[:, 2], time)
    assert _rms(found, task) == pytest.approx(table.rms_mm)
    assert table.rms_mm < 1.3  # the corner's points are close together
    rms = {"corrected": np.array([0.08, 0.09, 0.3]), "elastic": np.array([0.08, 0.08, 0.1])}
    said = sweep_said(Sweep(np.array([0.01, 0.1, 0.3]), rms, 30.0))
    assert said.startswith("between 0.1 and 0.3 m/s the static correction comes to leave twice")
    assert "0.300 mm at 0.3 m/s, 0.100 mm with elastic feed-forward" in said
    assert said.endswith("(at most 30 s of the path at each speed)")
    steady = replace(Sweep(np.array([0.01, 0.1]), {"corrected": np.array([0.1, 0.1])}))
    assert sweep_said(steady) == "the static correction holds up to 0.1 m/s"


@pytest.mark.parametrize("torque", [0.15, 20.0, 4000.0])
def test_a_law_that_bends_at_a_small_torque_is_tabulated_as_finely(torque: float):
    text = f"lost_motion:joint=joint_5,variant=play,torque={torque},amplitude=2e-4"
    law = held(with_effects("kr500", text)).axial[4]
    loads = np.concatenate([-np.geomspace(1e-2, 3e4, 60), np.geomspace(1e-2, 3e4, 60)])
    motion = law.compliance * loads + 2e-4 * np.tanh(loads / torque)
    read = np.array([tabulated(law.motion, law.torque)(x)[0] for x in motion])
    assert np.abs(read / loads - 1).max() < 1e-4


def test_springs_that_are_none_are_told():
    none = held(load_robot("kr500"))
    soft = held(with_effects("kr500", "lost_motion:joint=joint_2,variant=cubic,torque=2000,amplitude=5e-5"))
    pushes = held(with_effects("kr500", "foundation:compliance=4e-9"))
    assert none.notes == soft.notes == pushes.notes
    hard = "lost_motion:joint=joint_2,variant=cubic,torque=400,amplitude=-5e-4"
    told = [note for note in held(with_effects("kr500", hard)).notes if note not in none.notes]
    assert [note.startswith("joint_2: beyond ") and "turns back" in note for note in told] == [True]
    robot = with_effects("kr500", "foundation:compliance=4e-9")
    (item,) = robot.effects
    against = replace(robot, effects=(item.model_copy(update={"values": {"compliance": -4e-9}}),))
    (note,) = (note for note in held(against).notes if note not in none.notes)
    assert note.startswith("base_link: the model has a compliance below zero")


@pytest.mark.parametrize("torque", [0.0, -10.0])
def test_a_law_without_a_torque_is_refused(torque: float):
    with pytest.raises(InputError, match=r"torque = .* cannot be"):
        with_effects("kr500", f"lost_motion:joint=joint_2,variant=play,torque={torque},amplitude=1e-4")


def test_a_correction_says_what_wind_up_leaves_behind_its_reversals():
    """As far as the half width is friction's, both sides of it are left on a lever of 2 to 3 m."""
    robot = with_effects("kr500", "backlash:joint=joint_1,half_width=1e-4")
    q = np.tile(Q, (41, 1))
    q[:, 0] += 0.05 * np.sin(np.linspace(0, 3 * np.pi, 41))
    (note,) = (
        note for note in compensate(robot, Path(np.linspace(0, 4, 41), q=q)).notes if "reversal" in note
    )
    assert note.startswith("joint_1: 3 reversals along the path")
    size = float(note.split("up to ")[1].split(" mm")[0])
    assert 0.3 < size < 0.6
    onward = q.copy()
    onward[:, 0] = np.linspace(0.3, 0.5, 41)
    assert not any(
        "reversal" in note for note in compensate(robot, Path(np.linspace(0, 4, 41), q=onward)).notes
    )
