"""The error at the tool where nobody measured it: beyond a joint's map, warmer than it was, along a path."""

import re
from dataclasses import replace

import numpy as np
import pytest

from workbench import (
    Conditions,
    Covariance,
    InputError,
    Model,
    Path,
    Truth,
    compensate,
    fit,
    load_robot,
    parse_effect,
    planned,
    predict,
    problem_of,
    simulate,
    write_fit,
)
from workbench.effects.joint_map import JointMap
from workbench.effects.place import Where
from workbench.effects.records import record
from workbench.identification.prediction import posed

SIGMA = 2e-5
NAMES = ("joint_1", "joint_2", "joint_3")
LIMITS = np.array([(-1.5, 0.0), (0.05, 0.5), (0.05, 0.5)])
MAP = JointMap(Where(joint="joint_1"), "smooth", -1.5, 1.5, 0.3, 2e-4)


def measured(warmth=None):
    """Poses in which joint 1 stands on one side, its gear off by a wave."""
    robot, rng = load_robot("cylindrical"), np.random.default_rng(1)
    plan = planned(robot, rng.uniform(*LIMITS.T, (60, 3)))
    if warmth is not None:
        plan = plan.with_poses(temperature=np.linspace(*warmth, 60))
    gear = parse_effect(
        "gear_eccentricity:joint=joint_1,variant=2,amplitude=3e-4,phase=0.4", problem_of(plan)
    )
    place = (np.eye(3)[None], np.zeros((1, 3)))
    return simulate(plan, Truth(effects=(gear,), sigma=SIGMA), seed=1, instrument=place)


def written(path, campaign):
    problem = problem_of(campaign)
    noise = Covariance(np.full(problem.seen.shape, SIGMA), np.zeros(3), np.ones(len(problem.q)))
    write_fit(path, fit(Model(problem, (JointMap.over(problem, 0),)), noise=noise))
    return path


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    return written(tmp_path_factory.mktemp("warm") / "model.toml", measured((21.0, 25.0)))


def at(q1):
    return np.column_stack([q1, np.full(len(q1), 0.3), np.full(len(q1), 0.3)])


def test_a_map_forgets_its_edge_over_its_length():
    """In the mean it is none then, and as unsure as it is large; at the edge it goes on smoothly."""
    values = 1e-4 * np.arange(1, 1 + len(MAP.params))
    q = at(np.array([-0.3, 0.0, 1e-4, 0.3, 1.5]))
    off = MAP.basis(q, None, NAMES) @ values
    assert off[2] == pytest.approx(off[1], rel=1e-6)
    assert off[3] == pytest.approx(off[1] * np.exp(-0.5))
    assert abs(off[4]) < 1e-4 * abs(off[1])
    narrower = replace(MAP, room=0.3)
    assert narrower.basis(q, None, NAMES)[1] == pytest.approx(np.exp(-0.5) * MAP.basis(q, None, NAMES)[1])
    assert narrower.beyond(q, NAMES)[0] == 0.0
    assert MAP.beyond(q, NAMES) == pytest.approx(2e-4 * np.sqrt([0, 0, 0, 1 - np.exp(-1), 1]), abs=1e-6)


def test_beyond_a_map_its_prior_is_in_the_bound(model):
    """On the other side of the workspace what the map took of joint 1 is anybody's guess."""
    robot = load_robot(model)
    near, far = predict(robot, at(np.linspace(-1.4, -0.1, 20))), predict(robot, at(np.linspace(2.0, 3.0, 20)))
    assert near.measured.all()
    assert set(far.outside) == {"joint_1"}
    (size,) = (item.values["size"] for item in robot.effects)
    lever = np.linalg.norm((far.places + far.error)[..., :2], axis=2).min()
    assert far.worst.min() > 1.9 * size * lever > 2 * near.worst.max()


def test_warmer_than_it_was_measured_is_outside_and_less_sure(model):
    """By what links of one metal or another grow by, which no thermometer says."""
    robot = load_robot(model)
    assert robot.uncertainty.temperature_degC == (21.0, 25.0)
    plan = posed(robot, at(np.full(6, -0.7)))
    errors = predict(robot, plan.with_poses(temperature=np.array([23.0, 25.0, 25.3, 31.0, 34.0, 12.0])))
    assert errors.outside == ("", "", "", "temperature", "temperature", "temperature")
    inside, edge, little, *off = errors.worst
    assert inside == pytest.approx(edge)
    assert edge <= little < 1.05 * edge
    arm = np.linalg.norm(errors.places + errors.error, axis=2).min()
    grown = np.array([6.0, 9.0, 9.0]) * 1.15e-5 * arm  # steel
    assert (np.array(off) > grown).all()
    assert off[1] == pytest.approx(off[2])
    assert not errors.notes
    (note,) = predict(robot, plan).notes
    assert "for 21 to 25 °C" in note


def test_a_model_that_does_not_say_how_warm_it_was_is_read_and_says_so(model, tmp_path):
    text = re.sub(r"temperature_degC = \[[^]]*\]\n", "", model.read_text())
    (model.parent / "older.toml").write_text(text)
    older = load_robot(model.parent / "older.toml")
    assert older.uncertainty.temperature_degC == ()
    plan = posed(older, at(np.full(2, -0.7))).with_poses(temperature=np.array([23.0, 40.0]))
    errors = predict(older, plan)
    assert errors.outside == ("", "")
    (note,) = errors.notes
    assert note.startswith("no temperature was recorded")
    for wrong in ("[25.0, 21.0]", "[21.0]"):
        (model.parent / "older.toml").write_text(f"{text}".replace("time_s = []", f"time_s = {wrong}"))
        with pytest.raises(InputError, match=r"prediction\.time_s.*a least and a largest"):
            load_robot(model.parent / "older.toml")


def test_a_correction_beyond_what_was_measured_says_so(model):
    robot = load_robot(model)
    inside, out = at(np.linspace(-1.2, -0.2, 30)), at(np.linspace(-0.2, 0.8, 30))
    time = np.linspace(0.0, 3.0, 30)
    notes = compensate(robot, Path(time, q=inside), Conditions(temperature=24.0)).notes
    assert not any("not measured" in note or "warmer" in note for note in notes)
    notes = compensate(robot, Path(time, q=out), Conditions(temperature=30.0)).notes
    assert any("of 30 samples joints stand where they were not measured (joint_1)" in note for note in notes)
    assert any("at 30 of 30 samples the arm is up to 5 K warmer" in note for note in notes)


def test_time_counts_where_something_hangs_on_it(model, tmp_path):
    """A day later a joint's map is what it was; what warms up since a start is asked beyond its data."""
    robot = load_robot(model)
    timed = replace(robot, uncertainty=robot.uncertainty.model_copy(update={"time_s": (0.0, 3600.0)}))
    plan = posed(timed, at(np.full(2, -0.7))).with_poses(time=np.array([1800.0, 9e4]))
    assert predict(timed, plan).outside == ("", "")
    growing = parse_effect("thermal_growth:variant=warmup 0.4,coefficient=1e-5", problem_of(plan))
    warming = replace(timed, effects=(*timed.effects, record(*growing)))
    assert predict(warming, plan).outside == ("", "time")
