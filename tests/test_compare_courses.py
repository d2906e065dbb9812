"""The course of a number over many campaigns: it holds and then creeps, it wanders, it steps twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_compare import JOINT_4, before, measured, nothing, only, rival, unplaced, within

from workbench import compare
from workbench.diagnosis.changes.candidates import Shape
from workbench.diagnosis.changes.courses import any_course
from workbench.diagnosis.changes.result import Comparison
from workbench.report.comparison import said_of

JOINT_2_ZERO = (2, 5)


def joint_2_over_time(*levels: float) -> Comparison:
    """Its zero [rad] at each of the campaigns behind the first."""
    later = [measured(k, {JOINT_2_ZERO: level}) for k, level in enumerate(levels, 2)]
    return compare([before(), *later])


def levels_of(comparison: Comparison) -> dict[str, float]:
    """Of the only change, at each campaign that has it; the chart says the same."""
    change = only(comparison)
    said = {label: numbers[0] for label, numbers in change.levels}
    (track,) = [t for t in comparison.chart if t.label == change.label]
    for label, value, std in zip(comparison.campaigns, track.values, track.stds, strict=True):
        if label in said:
            assert abs(said[label].value - value) < 3.5 * np.hypot(said[label].std, std)
        else:
            assert abs(value) <= 3.5 * std
    return {label: number.value for label, number in said.items()}


def test_a_zero_that_held_and_then_crept_has_its_levels_and_nothing_stands_in_for_it():
    """Evenly over all campaigns was the only creeping there was: it was found first, and a gear's error and
    a step stood for the difference."""
    course = (0, 4e-5, 1.1e-4, 1.5e-4)
    comparison = joint_2_over_time(*course)
    found = levels_of(comparison)
    assert only(comparison).label == "joint_2 zero"
    true = dict(zip(comparison.campaigns[1:], course, strict=True))
    assert {*found} == {*comparison.campaigns[2:]}
    assert all(abs(found[label] - true[label]) < 1.5e-5 for label in found)


def test_a_zero_that_wanders_is_one_change_with_a_level_at_each_campaign():
    course = (1e-4, -5e-5, 1.2e-4, 5e-5)
    comparison = joint_2_over_time(*course)
    change = only(comparison)
    assert (change.label, change.course) == ("joint_2 zero", "levels")
    (largest,) = change.parameters
    assert largest.value == max(numbers[0].value for _, numbers in change.levels)
    assert "joint_2 zero moved more than once, against the first by 0." in comparison.headline
    found = levels_of(comparison)
    assert np.allclose([found[label] for label in comparison.campaigns[1:]], course, atol=2e-5)


def test_creeping_is_told_with_its_first_campaign():
    comparison = compare(
        [before(), measured(2), measured(3, {(JOINT_4, 5): 4e-4}), measured(4, {(JOINT_4, 5): 8e-4})]
    )
    change = only(comparison)
    assert (change.label, change.course, change.since) == ("joint_4 zero", "creep", comparison.campaigns[2])
    assert within(change.parameters[0], 8e-4)
    since, last = comparison.campaigns[2:]
    assert comparison.headline.startswith(f"joint_4 zero crept evenly since {since}, by 0.")
    assert f" mrad up to {last}; everything else" in comparison.headline
    assert said_of(comparison)["changes"][0]["when"].startswith("evenly since")


def test_columns_of_any_course_make_a_level_at_each_occasion():
    rng = np.random.default_rng(0)
    own = np.repeat(np.arange(3), 4)
    shape = Shape(rng.normal(size=(12, 2)), own, np.ones(2), np.ones((3, 1))).at(any_course(3))
    values = rng.normal(size=shape.width)
    levels = shape.levels(values)
    assert levels.shape == (3, 2)
    assert not levels[0].any()
    assert shape.columns @ values == pytest.approx((shape.base * levels[own]).sum(axis=1))


def test_no_change_is_its_own_rival_on_the_page():
    """One that another is likelier than, but not far likelier."""
    rivals = (rival("gear_ratio", 0.568), rival("link_1", 0.069))
    change = replace(unplaced(), probability=0.352, rivals=rivals)
    comparison = replace(nothing(), changes=(change,))
    (line,) = [text for text in said_of(comparison)["changes"][0]["lines"] if text.startswith("or instead")]
    assert line == "or instead: gear ratio (57 %), link_1 (7 %)"
