"""Then and now: what changed between campaigns that Drake measured, and what did not."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from workbench import (
    Truth,
    compare,
    diagnose,
    load_campaign,
    load_robot,
    parse_effect,
    planned,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
    write_campaign,
)
from workbench.campaign import Campaign
from workbench.cli.main import main
from workbench.diagnosis import changes
from workbench.diagnosis.changes import _apart_in_posture
from workbench.diagnosis.changes.courses import courses
from workbench.diagnosis.changes.covered import carried, carried_change, covered
from workbench.diagnosis.changes.decision import Decided, _able, decide
from workbench.diagnosis.changes.findings import _rivals, of_robot
from workbench.diagnosis.changes.found import Change, Rival, TargetMoved, TargetsMoved
from workbench.diagnosis.changes.occasions import occasions_of
from workbench.diagnosis.changes.result import Comparison
from workbench.diagnosis.changes.system import (
    PARTS,
    System,
    moved_without_parts,
    parts_in_order,
    solve,
    system_of,
)
from workbench.diagnosis.changes.words import headline, moved_by
from workbench.diagnosis.priors import PRIORS
from workbench.diagnosis.weighing.chosen import Member
from workbench.diagnosis.weighing.reduced import without_background
from workbench.effects.place import Parameter, Where
from workbench.effects.unnamed import unnamed
from workbench.files.faults import InputError
from workbench.identification.patterns import Products
from workbench.report.comparison import _places, said_of

DATA = Path(__file__).parents[1].parent / "shared" / "data"
SIGMA = 3e-5
POSES = 22
JOINT_3_ZERO, JOINT_4 = (3, 5), 4  # slot and component; slot
WHEEL = "gear_eccentricity:joint=joint_3,variant=1,amplitude=3e-4,phase=0.4"


@cache
def robot():
    return load_robot("kr120")


def measured(
    seed: int,
    bent: dict[tuple[int, int], float] | None = None,
    effects: tuple[str, ...] = (),
    loaded: bool = False,
    warm: float | None = None,
    **truth: Any,
) -> Campaign:
    """Poses of their own, from an instrument that stands somewhere else each time."""
    q = random_poses(robot(), POSES, np.random.default_rng(seed))
    told: dict[str, Any] = {}
    if loaded:
        q = np.tile(q, (2, 1))
        told = {
            "payloads": {"heavy": (90.0, (0.05, 0.0, 0.15))},
            "payload": [""] * POSES + ["heavy"] * POSES,
        }
    if warm is not None:
        told["temperature"] = np.full(len(q), warm)
    plan = planned(robot(), q, **told)
    job = problem_of(plan)
    geometry = random_geometry(job.arm, np.random.default_rng(0))
    for (slot, component), value in (bent or {}).items():
        geometry[slot, component] += value
    hidden = tuple(parse_effect(text, job) for text in effects)
    return simulate(plan, Truth(geometry=geometry, effects=hidden, **{"sigma": SIGMA, **truth}), seed=seed)


@cache
def before(loaded: bool = False) -> Campaign:
    return measured(1, loaded=loaded)


@cache
def nothing() -> Comparison:
    return compare([before(), measured(2)])


@cache
def slipped() -> Comparison:
    """A geared joint that slipped, its gear's own error unchanged; against two campaigns before."""
    return compare(
        [measured(1, effects=(WHEEL,)), measured(3, effects=(WHEEL,)),
         measured(2, {JOINT_3_ZERO: 1.5e-3}, effects=(WHEEL,))]
    )  # fmt: skip


def only(comparison: Comparison):
    assert comparison.changed
    assert comparison.exit_status == 3
    (change,) = comparison.changes
    assert change.status == "named"
    assert change.side == "robot"
    return change


def within(parameter, true: float) -> bool:
    return abs(parameter.value - true) < 3.5 * parameter.std


def test_a_shifted_zero_is_named_with_its_size_and_nothing_else():
    comparison = compare([before(), measured(2, {(JOINT_4, 5): 3.1e-4})])
    change = only(comparison)
    (zero,) = change.parameters
    assert (change.label, zero.name, zero.unit) == ("joint_4 zero", "zero", "rad")
    assert within(zero, 3.1e-4)
    assert zero.std < 4e-5
    assert comparison.headline.startswith(
        f"joint_4 zero moved by {1e3 * zero.value:.3f} ± {1e3 * zero.std:.3f} mrad"
    )
    assert "everything else unchanged within 0.0" in comparison.headline
    assert change.recheck_poses is not None
    assert change.recheck_poses < 12
    assert len(change.recheck_ids) == change.recheck_poses


def test_a_gear_that_slipped_is_a_zero_and_its_map_the_witness():
    change = only(slipped())
    assert change.label == "joint_3 zero"
    assert within(change.parameters[0], 1.5e-3)
    assert (change.since, change.alone) == (slipped().campaigns[2], False)
    assert [item.status for item in slipped().repeats if item.label == "gear_eccentricity(joint_3)"] == [
        "repeats"
    ]


def test_the_control_chart_has_every_campaign():
    tracks = {track.label: track for track in slipped().chart}
    zero = tracks["joint_3 zero"]
    assert len(zero.values) == 3
    assert abs(zero.values[1]) < 4 * zero.stds[1]
    assert abs(zero.values[2] - 1.5e-3) < 4 * zero.stds[2]
    assert zero.values[2] > zero.limit
    other = tracks["joint_2 zero"]
    assert all(abs(v) < 4.5 * s + 1e-12 for v, s in zip(other.values, other.stds, strict=True))


def test_a_zero_that_was_off_and_is_back_is_told_as_that_and_as_nothing_else():
    """A step back needs a second event of the same number: a gear's error or a link stood in for it."""
    later = [measured(k, {(JOINT_4, 5): level}) for k, level in ((2, 6e-4), (3, 6e-4), (4, 0.0))]
    comparison = compare([before(), *later])
    change = only(comparison)
    second, third = comparison.campaigns[1:3]
    assert (change.label, change.course) == ("joint_4 zero", "back")
    assert (change.since, [label for label, _ in change.levels]) == (second, [second, third])
    assert within(change.parameters[0], 6e-4)
    assert comparison.headline.startswith("joint_4 zero was off by 0.")
    assert f" mrad in {second} and {third}; everything else" in comparison.headline
    (track,) = [t for t in comparison.chart if t.label == "joint_4 zero"]
    assert np.allclose(track.values, [0.0, 6e-4, 6e-4, 0.0], atol=1.5e-4)
    (told,) = comparison.to_json()["changes"]
    assert [level["campaign"] for level in told["levels"]] == [second, third]
    shown = said_of(comparison)["changes"][0]
    assert shown["when"] == f"in {second} and {third} only"
    assert [row[0] for row in shown["parameters"]] == [f"zero in {second}", f"zero in {third}"]


def test_every_event_of_a_number_competes_and_of_two_campaigns_there_is_one():
    assert [course.tolist() for course in courses(1, 2, 1)] == [[0, 1]]
    assert [course.tolist() for course in courses(1, 4, 1)] == [
        [0, 1, 1, 1], [0, 1, 0, 0], [0, 1, 1, 0], [0, 1 / 3, 2 / 3, 1]
    ]  # fmt: skip
    assert [course.tolist() for course in courses(2, 4, 1)] == [[0, 0, 1, 1], [0, 0, 1, 0], [0, 0, 1 / 2, 1]]
    assert [course.tolist() for course in courses(3, 4, 1)] == [[0, 0, 0, 1]]
    assert [course.tolist() for course in courses(1, 4, 11)][1:] == [[0, 1, 0, 0], [0, 1 / 3, 2 / 3, 1]]
    assert [course.tolist() for course in courses(2, 4, 47, free=True)] == [[0, 0, 1, 1]]


def test_rivals_come_by_their_probability():
    def zero(joint: int) -> SimpleNamespace:
        form = SimpleNamespace(geometry=(0,), zero=True)
        where = Where(joint=f"joint_{joint}")
        return SimpleNamespace(cause="geometry", where=where, change=True, side="robot", shapes=(form,))

    decided = SimpleNamespace(
        candidates=[zero(1), zero(2), zero(3), zero(4)],
        members=[SimpleNamespace(component=0)],
        shares=[{0: 0.6, 1: 0.165, 2: 0.2, None: 0.03, 3: 0.005}],
    )
    found = [(rival.label, rival.probability) for rival in _rivals(decided, 0)]
    assert found == [("joint_3 zero", 0.2), ("joint_2 zero", 0.165)]


def test_a_bent_link_is_that_link():
    change = only(compare([before(), measured(2, {(4, 3): 3e-4, (4, 0): 4e-4, (4, 1): 1e-4})]))
    assert (change.cause, change.where.link, change.where.joint) == ("geometry", "link_3", "joint_4")


def test_a_compensator_that_leaked():
    """By less, it is not told from a mass of link_2 that changed."""
    leaked = measured(2, loaded=True, effects=("gravity_compensator:relative=-0.15",))
    change = only(compare([before(True), leaked]))
    assert change.cause == "gravity_compensator"
    assert within(change.parameters[0], -0.15)


def test_a_tool_mounted_anew_is_not_the_robot():
    places = problem_of(before()).stated_targets + np.array([1e-3, 5e-4, 0.0])
    comparison = compare([before(), measured(2, targets=places)])
    assert not comparison.changes
    assert comparison.exit_status == 0
    assert "tool or reflectors were mounted anew" in comparison.headline
    after = comparison.apart[1]
    assert after.targets_moved
    for target in after.targets:
        assert np.allclose(target.by_mm, [1.0, 0.5, 0.0], atol=4 * max(target.std_mm))


def test_a_moved_base_is_a_frame_and_another_instrument_a_noise():
    R, t = np.eye(3)[None], np.zeros((1, 3))
    t_moved = np.array([[3e-3, 0.0, 0.0]])
    plans = [planned(robot(), random_poses(robot(), POSES, np.random.default_rng(k))) for k in (1, 2)]
    truth = Truth(geometry=random_geometry(problem_of(plans[0]).arm, np.random.default_rng(0)), sigma=SIGMA)
    first = simulate(plans[0], truth, seed=1, instrument=(R, t))
    moved = simulate(plans[1], replace(truth, sigma=2 * SIGMA), seed=2, instrument=(R, t_moved))
    comparison = compare([first, moved])
    assert not comparison.changes
    assert comparison.exit_status == 0
    after = comparison.apart[1]
    assert abs(after.frame_mm - 3.0) < 4 * after.frame_std_mm < 0.3
    assert after.frame_mrad < 4 * after.frame_std_mrad
    assert not after.targets_moved
    assert "the points scatter 0.06" in comparison.headline
    assert "mm per axis, as the instrument's noise says" in comparison.headline


def test_points_that_scatter_more_than_anybody_stated_are_told():
    """By what is left of them: the stated noise is the same. Of two alike nothing is said."""
    worse = replace(measured(2, sigma=2 * SIGMA), noise_sigma=before().noise_sigma)
    comparison = compare([before(), worse])
    assert "; the points scatter 0.0" in comparison.headline
    assert "mm per axis, as repeats or distances between targets show" in comparison.headline
    first, after = (one.scatter for one in comparison.apart)
    assert abs(first.sigma_mm - 0.03) < 4 * first.std_mm < 0.02
    assert abs(after.sigma_mm - 0.06) < 4 * after.std_mm < 0.04
    told = comparison.to_json()["apart"][1]["scatter"]
    assert told["p_value"] < 1e-4
    assert told["times_first"] == pytest.approx(2.0, rel=0.25)
    assert "scatter" not in nothing().headline
    assert nothing().apart[1].scatter.p_value > 1e-3


def test_another_temperature_is_not_the_robot_written_down_or_not():
    growth = ("thermal_growth:coefficient=1.15e-5",)
    cold, warm = measured(1, warm=20.0), measured(2, warm=32.0, effects=growth)
    told = compare([cold, warm])
    assert told.exit_status == 0
    assert [c for c in told.changes if c.side == "robot"] == []
    assert told.apart[1].temperature == 32.0
    silent = compare([cold.with_poses(temperature=None), warm.with_poses(temperature=None)])
    assert silent.exit_status == 0
    (change,) = silent.changes
    assert {change.cause, *(r.cause for r in change.rivals)} == {"thermal_growth", "tracker_scale"}
    assert change.side != "robot"
    assert within(change.parameters[0], 12 * 1.15e-5)
    points = warm.points.reshape(-1, 3)
    radius = float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))
    moved = 1e3 * radius * change.parameters[0].value  # about their middle, wherever the instrument stands
    assert change.moves_mm == pytest.approx(moved, rel=0.1)
    for first, second in (
        (cold.with_poses(temperature=None), warm),
        (cold, warm.with_poses(temperature=None)),
    ):
        (change,) = compare([first, second]).changes  # nor can one thermometer tell
        assert {change.cause, *(r.cause for r in change.rivals)} == {"thermal_growth", "tracker_scale"}


def test_a_set_up_without_temperatures_beside_one_with_them_is_told():
    cold, silent = measured(1, warm=22.0), replace(measured(2), path=Path("tuesday/campaign.toml"))
    (said,) = (note for note in diagnose([cold, silent]).diagnosis.notes if "temp_degC" in note)
    assert said.startswith("tuesday: no temperature")
    assert "22.0 °C" in said


def test_what_a_cause_brings_with_it_does_not_hide_how_large_it_is():
    wheel = "gear_eccentricity:joint=joint_4,variant=1,amplitude=4e-4,phase=0.4"
    (change,) = compare([before(), measured(2, effects=(wheel,))]).changes
    assert change.cause == "gear_eccentricity"
    amplitude = change.parameters[0]
    assert within(amplitude, 4e-4)
    assert amplitude.std < 0.15 * amplitude.value


def test_a_phase_that_turned_is_told_from_what_to_what():
    """Of the difference, amplitude and phase are neither's."""
    wheel = "gear_kinematic_error:joint=joint_4,order=20,amplitude=4e-4,phase="
    comparison = compare([measured(k, effects=(f"{wheel}{phase}",)) for k, phase in ((1, 0.6), (2, 2.6))])
    (change,) = comparison.changes
    assert change.cause == "gear_kinematic_error"
    for numbers, phase in ((change.before, 0.6), (change.after, 2.6)):
        assert [p.name for p in numbers] == ["amplitude", "phase"]
        assert within(numbers[0], 4e-4)
        assert within(numbers[1], phase)
    assert within(change.parameters[0], 0.0)
    assert within(change.parameters[1], 2.0)
    assert "at the targets (phase from " in comparison.headline
    (told,) = comparison.to_json()["changes"]
    assert [p["name"] for p in told["after"]] == ["amplitude", "phase"]
    lines = said_of(comparison)["changes"][0]["lines"]
    assert lines[0].endswith("probability > 99.9 %")
    assert lines[1].startswith("before: amplitude ")


def line_at(seed: int, low: float, high: float) -> Campaign:
    """A line in the gear of joint_4 of an order that nobody states, with the joint from low to high [rad]."""
    q = random_poses(robot(), 50, np.random.default_rng(seed))
    q[:, JOINT_4 - 1] = np.random.default_rng(seed).uniform(low, high, len(q))
    plan = planned(robot(), q)
    job = problem_of(plan)
    geometry = random_geometry(job.arm, np.random.default_rng(0))
    line = parse_effect("gear_kinematic_error:joint=joint_4,order=37.7,amplitude=4e-4,phase=0.6", job)
    return simulate(plan, Truth(geometry=geometry, effects=(line,), sigma=SIGMA), seed=seed)


def test_a_line_of_an_estimated_order_says_nothing_where_its_joint_was_not():
    """An order that is off by 0.1 turns the phase by a radian where the joint was three others away."""
    comparison = compare([line_at(1, -2.4, -1.2), line_at(2, 1.2, 2.4)])
    assert not comparison.changed
    assert not comparison.changes
    assert [(one.status) for one in comparison.repeats if "joint_4" in one.label] == ["not decided"]


def test_the_poses_that_can_speak_of_a_change_are_those_that_either_side_covered():
    arm = SimpleNamespace(names=("joint_1", "joint_2"))
    q = [np.array([[0.0, 0.0], [1.0, 1.0]]), np.array([[0.5, 0.5], [0.5, 3.0]]), np.array([[9.0, 0.1]] * 2)]
    occasions = [SimpleNamespace(problem=SimpleNamespace(q=each, arm=arm)) for each in q]
    system: Any = SimpleNamespace(occasions=occasions, pose=np.repeat(np.arange(6), 2))
    last, middle = np.array([[0.0], [0.0], [1.0]]), np.array([[0.0], [1.0], [0.0]])
    assert not covered(system, last, "joint_1").any()
    assert covered(system, last, "joint_2")[::2].tolist() == [False, False, False, False, True, True]
    assert covered(system, middle, "joint_1")[::2].tolist() == [False, False, True, True, False, False]


def test_a_number_that_adds_up_changed_by_its_difference():
    play = "lost_motion:joint=joint_2,variant=play,amplitude=3e-4"
    change = only(compare([before(), measured(2, effects=(play,))]))
    assert change.cause == "lost_motion"
    assert change.before == ()
    assert within(change.parameters[0], 3e-4)
    assert moved_by(change).startswith("lost motion in joint_2 changed by ")


def test_forms_of_one_cause_are_told_apart_in_what_did_not_change():
    labels = [item.label for item in nothing().unchanged]
    assert {
        "gear_eccentricity(joint_3), 1 cycle per turn",
        "gear_eccentricity(joint_3), 2 cycles per turn",
    } < {*labels}
    assert len(set(labels)) == len(labels)


def test_nothing_changed_and_what_would_have_been_seen():
    comparison = nothing()
    assert (comparison.changes, comparison.changed, comparison.exit_status) == ((), False, 0)
    assert comparison.headline.startswith("The robot is unchanged within 0.")  # few postures in common
    assert "but for the zeros of joint_1 and joint_6: to these data a move of " in comparison.headline
    assert comparison.within_mm < 0.06
    seen = {item.label: item for item in comparison.unchanged}
    zero = seen["joint_4 zero"]
    assert 4 * zero.number.std < zero.detectable < 8 * zero.number.std
    assert abs(zero.number.value) < 4 * zero.number.std
    same = {item.label: item.same_as for item in comparison.unseen}
    assert same["joint_1 zero"] == same["joint_6 zero"] == "the instrument's frame or the targets"


def test_what_geometry_shows_by_its_loads_alone_is_no_change_that_can_be_seen(monkeypatch):
    """A base that tilts looks like a move of the instrument, but for where gravity pulls: an IRB 120's would
    have had to tilt by 12 mrad for what its model lacks of loads."""
    told: list[Decided] = []
    monkeypatch.setattr(changes, "decide", lambda *given: told.append(decide(*given)) or told[0])
    comparison = compare([before(loaded=True), measured(2, loaded=True)])
    tilts = {f"base_link (tilt about {axis} of joint_1)" for axis in "xy"}
    assert tilts <= {item.label for item in comparison.unseen}
    assert not tilts & {item.label for item in comparison.unchanged}
    tried = {(one.cause, one.where) for one in told[0].candidates if one.change}
    assert ("geometry", Where(joint="joint_1", link="base_link")) not in tried


def test_the_size_called_detectable_is_found():
    size = {item.label: item.detectable for item in nothing().unchanged}["joint_3 zero"]
    comparison = compare([before(), measured(2, {JOINT_3_ZERO: 1.5 * size})])
    (change,) = comparison.changes
    assert comparison.changed
    assert "joint_3 zero" in (change.label, *(rival.label for rival in change.rivals))


def test_a_change_that_may_be_none_is_told_as_such():
    comparison = compare([before(), measured(2, {(JOINT_4, 5): 1.5e-4})])
    (change,) = comparison.changes
    assert (change.label, change.status) == ("joint_4 zero", "possible")
    assert PRIORS.absent <= change.any < PRIORS.named
    assert (comparison.changed, comparison.exit_status) == (False, 0)
    said = (
        comparison.headline,
        *(
            headline([replace(change, rivals=rivals)], 0.01, [], False)
            for rivals in ((), (rival("joint_5 zero", 0.1),))
        ),
    )
    assert said[1].startswith("Perhaps joint_4 zero changed by 0.03 mm")
    assert said[2].startswith("Not decided: joint_4 zero changed by 0.03 mm")
    assert said[0][:40] in (said[1][:40], said[2][:40])  # a rival of a percent may be listed or not
    assert "the robot is unchanged" not in comparison.headline.lower()


def rival(label: str, probability: float, change: bool = True) -> Rival:
    return Rival(label, "foundation", Where(), change, "robot", probability)


def unplaced() -> Change:
    """A function of 36 weights in the place of much that is likelier."""
    rivals = tuple(rival(f"link_{k}", 0.3 - k / 100, k % 2 > 0) for k in range(1, 4))
    size = (Parameter("size", 2e-4, 1e-5, "rad"),)
    where, label = Where(), "a dependence on the order of measurement"
    return Change(
        label, "unknown", where, "surroundings", "possible", "june", False, 0.011, 0.5, size, 0.04, rivals
    )


def test_a_robot_that_may_have_changed_is_not_called_unchanged():
    """What leads is the surroundings', and what may stand in its place the robot's."""
    size = (Parameter("coefficient", 2e-6, 1e-6, "1/K"),)
    warmer = Change(
        "thermal_growth", "thermal_growth", Where(), "surroundings", "ambiguous", "june", False, 0.5, 0.4,
        size, 0.04, (rival("foundation", 0.3),),
    )  # fmt: skip
    assert "everything else unchanged within 0.02 mm" in headline([warmer], 0.02, [], False)
    common = replace(warmer, rivals=(rival("foundation", 0.3, change=False),))
    assert "the robot is unchanged within 0.02 mm" in headline([common], 0.02, [], False)


def test_what_cannot_be_placed_takes_one_clause_and_its_candidates_come_by_probability():
    change = unplaced()
    assert headline([change], 0.026, [], False) == (
        "The robot is unchanged within 0.026 mm; something of 0.04 mm RMS at the targets cannot be placed."
    )
    shown = said_of(replace(nothing(), changes=(change,)))["changes"][0]
    assert (shown["what"], shown["parameters"]) == ("something that cannot be placed", [])
    assert shown["lines"][1] == (
        "it may be: link_1 (29 %), link_2 in all campaigns (28 %), link_3 (27 %), "
        "a dependence on the order of measurement (1 %)"
    )
    (told,) = replace(nothing(), changes=(change,)).to_json()["changes"]
    assert not told["placed"]
    likelier = replace(change, rivals=(rival("link_2", 0.015),))
    assert (
        "not decided: a dependence on the order of measurement changed by"
        in headline([likelier], 0.026, [], False).lower()
    )


def test_something_that_changed_is_not_decided_between_its_likeliest_ways():
    many = tuple(rival(f"link_{k}", 0.3 - k / 20) for k in range(1, 6))
    change = replace(unplaced(), status="ambiguous", rivals=many)
    assert "not decided: link_1 or link_2 or link_3 or link_4 or something less likely;" in headline(
        [change], 0.026, [], True
    )


def test_a_function_without_a_name_has_a_size_and_no_weights():
    (effect, *_) = unnamed(problem_of(before()))
    weights = np.linspace(1e-5, 3e-5, len(effect.params))
    (size,) = effect.report(weights, np.diag(np.full(len(weights), 1e-12)))
    assert (size.name, size.unit) == ("size", "rad")
    assert size.value == pytest.approx(np.sqrt((weights**2).sum()))
    assert size.std == pytest.approx(1e-6)


def test_a_link_that_a_gear_could_mimic_is_not_named():
    """Gravity on link 2 goes with the sine of joint 2, as an eccentric wheel's error does."""
    first = ("gear_eccentricity:joint=joint_2,variant=1,amplitude=2e-4,phase=0.4",)
    later = ("gear_eccentricity:joint=joint_2,variant=1,amplitude=2e-4,phase=2.4",)
    comparison = compare([measured(1, effects=first), measured(2, effects=later)])
    (change,) = comparison.changes
    labels = {change.label, *(rival.label for rival in change.rivals)}
    assert comparison.changed
    assert change.status == "ambiguous"
    assert "gear_eccentricity(joint_2)" in labels
    assert "not decided" in comparison.headline


def test_the_command_writes_its_page_and_is_done_whatever_it_found(tmp_path, capsys, monkeypatch):
    paths = [
        str(write_campaign(tmp_path / name, campaign))
        for name, campaign in (("may", before()), ("june", measured(2, {(2, 5): 3e-4})))
    ]
    assert main(["compare", *paths, "--json", "--out", str(tmp_path / "out")]) == 0
    said = json.loads(capsys.readouterr().out)
    monkeypatch.setattr(changes, "compare", lambda *_: slipped())
    assert main(["compare", *paths, "--exit-code"]) == 3
    assert said == json.loads((tmp_path / "out/comparison.json").read_text(encoding="utf-8"))
    assert said["verdict"] == "changed"
    assert [c["label"] for c in said["campaigns"]] == ["may", "june"]
    (change,) = said["changes"]
    assert (change["what"], change["since"]) == ("joint_2 zero", "june")
    page = (tmp_path / "out/index.html").read_text(encoding="utf-8")
    assert said["headline"] in page
    assert "<svg" in page
    assert (tmp_path / "out/report.pdf").read_bytes().startswith(b"%PDF")


def test_what_cannot_be_compared_is_refused(tmp_path, capsys):
    path = str(write_campaign(tmp_path / "may", before()))
    assert main(["compare", path]) == 2
    assert main(["compare", path, path]) == 2
    assert "the same campaign twice" in capsys.readouterr().err
    other = planned(load_robot("kr500"), random_poses(load_robot("kr500"), 12, np.random.default_rng(0)))
    with pytest.raises(InputError, match="robot 'kr500'"):
        compare([before(), simulate(other, Truth(sigma=SIGMA), seed=1)])


def test_another_version_of_the_robot_is_refused_with_what_differs():
    first, *others = robot().joints
    softer = replace(first, data=first.data.model_copy(update={"stiffness": 1e5, "damping": 1.0}))
    version = replace(robot(), joints=(softer, *others), path=Path("older.toml"))
    with pytest.raises(
        InputError, match=r"'kr120', but another version of it \(older.toml is not as"
    ) as told:
        compare([before(), replace(measured(2), robot=version)])
    assert "joint_1 damping, joint_1 stiffness)" in str(told.value)
    assert "let both name one TOML" in str(told.value)


@pytest.mark.skipif(not DATA.is_dir(), reason="no measured campaigns here")
def test_halves_of_a_measured_campaign_have_not_changed():
    whole = load_campaign(DATA / "ma1400-left/campaign.toml")
    order = np.arange(whole.n_poses)
    comparison = compare([whole.some(order[::2]), whole.some(order[1::2])])
    assert (comparison.changes, comparison.exit_status) == ((), 0)


@pytest.mark.skipif(not DATA.is_dir(), reason="no measured campaigns here")
def test_a_half_after_the_other_of_a_measured_campaign_is_unchanged():
    whole = load_campaign(DATA / "ma1400-left/campaign.toml")
    order = np.arange(whole.n_poses)
    comparison = compare([whole.some(order[: len(order) // 2]), whole.some(order[len(order) // 2 :])])
    assert comparison.exit_status == 0
    assert comparison.headline.startswith("The robot is unchanged within 0.")  # few postures in common
    assert not comparison.changes
    assert "weight_" not in str(comparison.to_json())


def test_numbers_without_a_part_are_those_of_a_fit_without_it():
    """The jackknife's step, against all equations solved anew without these rows."""
    occasions, _ = occasions_of([before(), measured(2)], lambda _: None)
    system = system_of(occasions)
    moved = moved_without_parts(system, [], [], solve(system, [], []), parts_in_order(system))[1]
    poses = np.unique(system.pose[system.own == 1])
    for part in (0, PARTS - 1):
        gone = np.isin(system.pose, poses[np.arange(len(poses)) * PARTS // len(poses) == part])
        J, e = system.J[~gone], system.e[~gone]
        again = np.linalg.solve(J.T @ J + np.eye(J.shape[1]), J.T @ e)
        assert moved[part] == pytest.approx(again - solve(system, [], []).values, rel=1e-4, abs=1e-7)
        assert np.abs(moved[part]).max() > 1e-4
    assert len(moved) == PARTS


def test_numbers_that_the_data_do_not_tell_apart_are_no_fault():
    """The place of an instrument and of a target that goes along with it, in campaigns that hardly turn: of
    their squares the computer knows no difference."""
    J = np.tile([[1e9, 1e9]], (20, 1))
    pose = np.arange(20)
    system: Any = SimpleNamespace(
        J=J, e=np.cos(pose), own=pose // 10, pose=pose, count=2, used=np.ones(20, dtype=bool)
    )
    solved = solve(system, [], [])
    moves = moved_without_parts(system, [], [], solved, parts_in_order(system))
    assert [each.shape for each in moves] == [(PARTS, 2)] * 2
    assert np.isfinite(moves).all()
    assert np.abs(moves).max() < 1e-3  # of a prior: what the data do not tell stays there
    G, offset = np.ones((20, 1)), np.zeros(2)
    left = without_background(J, offset, system.e, 20, Products.of(J, G, system.e))
    assert np.isfinite(left[0]).all()


@pytest.mark.parametrize(("misfit", "cause", "side", "changed"), [
    (False, "unknown", "robot", True),
    (True, "unknown", "robot", False),
    (True, "gear_eccentricity", "robot", True),
    (False, "drift", "surroundings", False),
])  # fmt: skip
def test_what_has_no_name_changes_no_robot_where_the_model_does_not_fit(misfit, cause, side, changed):
    """Other poses show another part of what the model lacks: a measured robot was told to have changed within
    one campaign."""
    arm = SimpleNamespace(names=("joint_1",), links=("base_link", "link_1"))
    problem = SimpleNamespace(q=np.array([[0.0], [1.0]]), arm=arm)
    decided = SimpleNamespace(
        candidates=[SimpleNamespace(cause=cause, side=side, where=Where())],
        system=SimpleNamespace(misfit=misfit, occasions=[SimpleNamespace(problem=problem)] * 2),
    )
    assert of_robot(decided, 0) is changed


def postures(misfit: bool, apart: bool) -> Any:
    """Two campaigns of 100 poses drawn over one range, or over others."""
    rng = np.random.default_rng(0)
    drawn = [rng.uniform(-1, 1, (100, 6)) for _ in range(2)]
    occasions = [
        SimpleNamespace(problem=SimpleNamespace(q=q, positions=np.arange(100)), label=f"c{k}", coherence=1.0)
        for k, q in enumerate((drawn[0], drawn[1] + 3 * apart))
    ]
    system = SimpleNamespace(occasions=occasions, misfit=misfit, count=2, pose=np.arange(200))
    system.within = System.within.func(system)
    return system


@pytest.mark.parametrize(("misfit", "apart", "factor"), [
    (False, True, 1.0), (True, False, 1.0), (True, True, 10.0),
])  # fmt: skip
def test_poses_that_no_other_campaign_covered_are_one_draw_where_the_model_does_not_fit(
    misfit, apart, factor
):
    system = postures(misfit, apart)
    assert carried(system, 1, [0]) == pytest.approx(factor)
    assert carried_change(system, np.array([[0.0], [1.0]])) == pytest.approx(factor)
    candidate: Any = SimpleNamespace(
        change=True, shapes=(SimpleNamespace(effects=(), pattern=np.array([[0.0], [1.0]])),), where=Where()
    )
    asked = list(_able(system, [candidate], [Member(0, 0, 1.0)]))
    assert [rows.mean() for rows, _, _ in asked] == [1.0] * (factor > 1.0)
    assert max([1.0, *(each for _, each, _ in asked)]) == pytest.approx(factor)


def test_what_could_have_been_seen_is_as_little_as_the_postures_have_in_common():
    """A zero that moves between postures apart, beside an error without a name, may not be seen; but then
    nothing is said to be unchanged within less than it makes."""

    def nameless(problem: Any) -> np.ndarray:
        out, q = np.zeros_like(problem.q), problem.q
        out[:, 2] = 4e-4 * np.sin(5 * q[:, 1]) * np.cos(4 * q[:, 2]) * np.sin(3 * q[:, 4])
        return out

    def at(seed: int, low: float, high: float, moved: float = 0.0) -> Campaign:
        q = random_poses(robot(), 60, np.random.default_rng(seed))
        q[:, 1] = np.random.default_rng(seed).uniform(low, high, len(q))
        plan = planned(robot(), q)
        zeros = np.zeros_like(problem_of(plan).arm.geometry)
        zeros[2, 5] = moved
        return simulate(plan, Truth(sigma=SIGMA, geometry=zeros, joints=nameless), seed=seed)

    far = compare([at(1, -1.9, -1.3), at(2, -0.9, -0.3, 1e-3)])
    moved = only(far)
    assert (moved.label, moved.status) == ("joint_2 zero", "named")
    near = compare([at(1, -1.9, -1.3), at(2, -0.9, -0.3, 1e-4)])
    assert not near.changed
    assert near.within_mm > 0.1 * moved.moves_mm


def test_campaigns_whose_postures_hardly_overlap_are_told():
    assert _apart_in_posture(postures(True, apart=False)) == ""
    said = _apart_in_posture(postures(True, apart=True))
    assert said.startswith("Only 0 of the 100 poses of c0 and 0 of the 100 poses of c1 lie within")
    assert _apart_in_posture(postures(False, apart=True)) == ""


@pytest.mark.parametrize(("mm", "std", "said"), [
    (1306.0, 949.0, "cannot be told"), (671.4, 20.0, "671 ± 20 mm"), (0.3, 0.4, "0.3 ± 0.4 mm"),
])  # fmt: skip
def test_where_an_instrument_stands_is_said_where_that_is_known(mm, std, said):
    """Not in metres of uncertainty, beside a robot that is off by 10 mm."""
    moves = TargetsMoved(
        (TargetMoved("T1", (mm, 0.0, 0.0), (std, 0.0, 0.0), False, None, False, "flange"),), ()
    )
    there: Any = SimpleNamespace(
        frame_mm=mm, frame_std_mm=std, frame_mrad=1.0, frame_std_mrad=0.1, moves=moves
    )
    instrument, targets = _places(there, 10.0)
    assert said in instrument
    assert ("cannot be told" in targets) == (std > 10.0)


def test_a_diagnosis_of_a_robot_that_changed_points_here():
    """Both campaigns are fitted as one robot, which none of its causes makes of two."""

    after = replace(measured(2, effects=(WHEEL,)), path=Path("after/campaign.toml"))
    changed = diagnose([before(), after]).diagnosis
    assert changed.verdict == "unknown"
    assert any("`workbench compare`" in note for note in changed.notes)
