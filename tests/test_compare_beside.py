"""What a part of the poses does not show, and what changes along with something else at its joint."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_compare import JOINT_3_ZERO, JOINT_4, SIGMA, before, measured, only, robot

from workbench import (
    Truth,
    compare,
    parse_effect,
    planned,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
)
from workbench.campaign import Campaign
from workbench.diagnosis.changes import decision
from workbench.diagnosis.changes.beside import how_sure
from workbench.diagnosis.changes.candidates import Shape
from workbench.diagnosis.changes.coherence import neighbours
from workbench.diagnosis.changes.decision import Instead, _told
from workbench.diagnosis.changes.found import BACK, CREEP, Change
from workbench.diagnosis.changes.steadiness import GROUP, unsteady
from workbench.diagnosis.changes.system import solve
from workbench.diagnosis.changes.words import headline
from workbench.diagnosis.weighing.chosen import Member
from workbench.effects.base import UNKNOWN
from workbench.effects.place import Parameter, Where


def test_whether_there_is_something_is_told_by_what_says_least_and_what_it_is_by_all():
    together = {None: 0.0, 1: 0.9, 2: 0.1}
    assert _told(together, {None: 0.75, 2: 0.25}) == pytest.approx({None: 0.75, 1: 0.225, 2: 0.025})
    surer = {None: 0.1, 1: 0.5, 2: 0.4}
    assert _told(together, surer) == surer
    nothing = {None: 0.5, 1: 0.5}
    assert _told(nothing, {None: 0.9, 1: 0.1}) == {None: 0.9, 1: 0.1}


@pytest.mark.parametrize(("cause", "together", "least", "there"), [
    ("foundation", 0.01, 0.9, True), ("foundation", 0.1, 0.9, False), ("foundation", 0.1, 0.15, True),
    (UNKNOWN, 0.01, 0.9, False), (UNKNOWN, 0.01, 0.15, True),
])  # fmt: skip
def test_what_is_not_steady_stays_where_all_poses_are_sure_of_it_and_it_has_a_name(
    cause, together, least, there
):
    candidate: Any = SimpleNamespace(cause=cause)
    assert decision._is_there(candidate, {None: together}, {None: least}) is there


def test_what_all_poses_show_and_is_not_steady_is_possible_and_never_listed_as_unchanged(monkeypatch):
    """A zero at seven standard deviations stood among what did not change."""

    monkeypatch.setattr(decision, "unsteady", lambda system, shapes, *_: [8.0] * len(shapes))
    silent = [replace(c, noise_sigma=None) for c in (before(), measured(2, {JOINT_3_ZERO: 6e-4}))]
    comparison = compare(silent)
    (change,) = comparison.changes
    assert (change.label, change.status) == ("joint_3 zero", "possible")
    assert (comparison.changed, comparison.exit_status) == (False, 0)
    assert comparison.headline.startswith("Perhaps joint_3 zero changed by ")
    assert "; everything else unchanged within" in comparison.headline
    assert all(abs(one.number.value) < 5 * one.number.std for one in comparison.unchanged)
    assert "joint_3 zero" not in {one.label for one in comparison.unchanged}


def factor_of(alike: float, draw: int) -> float:
    """Of a shift between two campaigns of 128 poses, of which each group of neighbours shares `alike` of the
    variance of its noise."""
    rng = np.random.default_rng(draw)
    occasions, noise = [], []
    for _ in range(2):
        q = rng.uniform(-1, 1, (128, 6))
        own = rng.normal(size=128) * np.sqrt(1 - alike)
        for group in neighbours(q, np.arange(128), GROUP):
            own[group] += rng.normal() * np.sqrt(alike)
        occasions.append(SimpleNamespace(problem=SimpleNamespace(q=q)))
        noise.append(own)
    pose = np.arange(256)
    system: Any = SimpleNamespace(
        occasions=occasions, J=np.ones((256, 1)), e=np.concatenate(noise), own=pose // 128, pose=pose,
        count=2, used=np.ones(256, dtype=bool),
    )  # fmt: skip
    shape = Shape((pose[:, None] >= 128) * 1.0, system.own, np.ones(1), np.ones((2, 1)))
    (factor,) = unsteady(system, [shape], [1.0], solve(system, [shape], [1.0]))
    return factor


def test_a_change_is_as_unsure_as_it_scatters_from_posture_to_posture():
    """By 1 + (n - 1) ρ, where n neighbours share ρ of their noise (design effect: Kish 1965)."""
    assert np.median([factor_of(0.0, draw) for draw in range(12)]) < 1.15
    seen = [factor_of(0.6, draw) for draw in range(12)]
    assert np.median(seen) == pytest.approx(np.sqrt(1 + 7 * 0.6), rel=0.2)


def turning_little(seed: int, zero: float = 0.0, wheel: float = 0.0) -> Campaign:
    """Joint 4 turns by little: there the cosine of its angle is nearly a zero."""
    q = random_poses(robot(), 40, np.random.default_rng(seed))
    q[:, JOINT_4 - 1] = np.random.default_rng(seed).uniform(-0.5, 0.5, len(q))
    plan = planned(robot(), q)
    job = problem_of(plan)
    geometry = random_geometry(job.arm, np.random.default_rng(0))
    geometry[JOINT_4, 5] += zero
    text = f"gear_eccentricity:joint=joint_4,variant=1,amplitude={wheel},phase={np.pi / 2}"
    effects = (parse_effect(text, job),) if wheel else ()
    return simulate(plan, Truth(geometry=geometry, effects=effects, sigma=SIGMA), seed=seed)


def test_a_zero_is_as_sure_as_a_run_out_that_changed_along_with_it_leaves_it():
    comparison = compare([turning_little(1), turning_little(2, zero=6e-4, wheel=1e-4)])
    change = only(comparison)
    assert change.label == "joint_4 zero"
    (zero,) = change.parameters
    assert abs(zero.value - 6e-4) > 5e-5  # the wheel is in it
    assert abs(zero.value - 6e-4) < 2 * zero.std < 1.5e-4


def test_a_number_is_as_sure_as_what_may_stand_in_the_place_of_what_else_was_found():
    """Three times as likely as the second member is another, beside which the first is 2 more."""
    shape = SimpleNamespace(columns=np.zeros((4, 1)), pattern=np.ones((2, 1)))
    instead = [
        Instead(1, 3.0, np.array([3.0, 0.0]), np.diag([0.2, 0.0])),
        Instead(0, 9.0, np.array([0.0, 99.0]), np.diag([0.0, 9.0])),
    ]
    decided: Any = SimpleNamespace(
        instead=instead,
        members=[Member(0, 0, 1.0), Member(1, 0, 1.0)],
        candidates=[SimpleNamespace(where=Where(link="link_1"), quantity=k) for k in range(2)],
        shape=lambda member: shape,
        system=SimpleNamespace(J=np.zeros((4, 0))),
        solved=SimpleNamespace(values=np.array([1.0, 5.0]), half=np.diag([0.1, 0.3]), factor=2.0),
    )
    sure = decided.solved.factor * how_sure(decided, [0])
    own, other, off = 0.25 * 0.2**2, 0.75 * 0.4**2, 0.75 * 2.0**2
    assert float(sure[0] @ sure[0]) == pytest.approx(own + other + off)


@pytest.mark.parametrize(("course", "said"), [
    (CREEP, "something crept evenly since june, by 0.04 mm RMS at the targets, not decided: "),
    (BACK, "something was off by 0.04 mm RMS at the targets in june, not decided: "),
])  # fmt: skip
def test_what_is_not_decided_has_its_course_in_the_headline(course, said):
    size = (Parameter("compliance", 2e-9, 1e-10, "rad/(N·m)"),)
    change = Change(
        "foundation", "foundation", Where(), "robot", "ambiguous", "june", False, 0.5, 1.0, size, 0.04, (),
        None, (), course, (("june", size),),
    )  # fmt: skip
    assert said.lower() in headline([change], 0.02, [], True).lower()
