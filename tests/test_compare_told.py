"""What a comparison is told besides the points, and what it tells of targets, loads and few poses."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_compare import JOINT_3_ZERO, POSES, SIGMA, before, measured, nothing, only, robot, within

from workbench import (
    Truth,
    compare,
    planned,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
    write_campaign,
)
from workbench.campaign import Campaign
from workbench.campaign.data import Target
from workbench.campaign.other_tools import with_tools_as_loads
from workbench.cli.main import main
from workbench.diagnosis.changes.elsewhere import _elsewhere
from workbench.diagnosis.changes.findings import of_robot, stood_still
from workbench.diagnosis.changes.found import TargetMoved, TargetsMoved
from workbench.diagnosis.changes.result import Comparison
from workbench.diagnosis.changes.targets import _may_be_warm
from workbench.diagnosis.changes.words import headline
from workbench.effects.place import Where
from workbench.effects.records import parse_effect
from workbench.report.comparison import said_of

LEAK = ("gravity_compensator:relative=-0.1",)
ON_FLANGE = (
    Target("T1", (0.1, 0.05, 0.08)),
    Target("T2", (-0.08, 0.06, 0.06)),
    Target("T3", (0.0, -0.09, 0.12)),
)
ON_BASE = (
    Target("B1", (0.9, 0.3, 0.1), "base"),
    Target("B2", (-0.8, 0.5, 0.08), "base"),
    Target("B3", (0.1, -0.9, 0.2), "base"),
)
TURN = 5e-4  # rad


def seen(seed: int, targets: tuple[Target, ...] = ON_FLANGE, n: int = POSES, **truth: Any) -> Campaign:
    """The robot of `measured` with targets of one's own; truth: as of `Truth`, zero: of joints [rad]."""
    plan = planned(robot(), random_poses(robot(), n, np.random.default_rng(seed)), targets=targets)
    geometry = random_geometry(problem_of(plan).arm, np.random.default_rng(0))
    for joint, value in truth.pop("zero", {}).items():
        geometry[joint, 5] += value
    return simulate(plan, Truth(geometry=geometry, **{"sigma": SIGMA, **truth}), seed=seed)


@cache
def shifted() -> Comparison:
    return compare([before(), measured(2, {JOINT_3_ZERO: 1.2e-3})])


@cache
def again(shift: float = 1.2e-3, n: int | None = None) -> Campaign:
    """The poses that `shifted` names, measured anew, with other targets."""
    (change,) = shifted().changes
    first = random_poses(robot(), POSES, np.random.default_rng(2))
    poses = [int(name.rsplit("/", 1)[-1]) - 1 for name in change.recheck_ids]
    plan = planned(robot(), first[poses[:n]], targets=[replace(t, name=f"A{t.name}") for t in ON_FLANGE])
    geometry = random_geometry(problem_of(plan).arm, np.random.default_rng(0))
    geometry[JOINT_3_ZERO] += shift
    return simulate(plan, Truth(geometry=geometry, sigma=SIGMA), seed=7)


def test_the_shortest_recheck_shows_the_change_again():
    """Of poses that do not identify the geometry by themselves: they need not."""
    (change,) = shifted().changes
    assert change.recheck_poses is not None
    assert change.recheck_poses <= 4
    comparison = compare([before(), again()])
    assert comparison.exit_status == 3
    (found,) = comparison.changes
    assert "joint_3 zero" in (found.label, *(rival.label for rival in found.rivals))
    (note,) = [note for note in comparison.notes if "other campaigns" in note]
    assert "numbers show whether it changed" in note


def test_few_poses_of_a_robot_as_it_was_do_not_say_that_it_is_unchanged():
    comparison = compare([before(), again(0.0)])
    assert (comparison.changes, comparison.exit_status) == ((), 0)
    assert comparison.headline.startswith("No change of the robot is seen; changes as large as the nominal")
    assert "unchanged within" not in comparison.headline
    assert said_of(comparison)["within"].endswith("could not have been seen.")
    assert not any(cell.startswith(("=", "seen")) for row in said_of(comparison)["unchanged"] for cell in row)
    assert comparison.apart[1].scatter.p_value > 1e-3


def test_a_recheck_beside_several_campaigns_sharpens_what_they_said():
    change = only(compare([before(), measured(2, {JOINT_3_ZERO: 1.2e-3}), again()]))
    assert change.label == "joint_3 zero"
    assert within(change.parameters[0], 1.2e-3)
    assert len(change.levels) == 2


def test_too_few_for_the_frame_are_refused(tmp_path, capsys):
    paths = [str(write_campaign(tmp_path / f"{n}", c)) for n, c in enumerate((before(), again(n=1)))]
    assert main(["compare", *paths]) == 2
    told = capsys.readouterr().err
    assert "1 different poses give 6 numbers, where instrument and targets are has 12" in told
    assert "measure 3 poses or more" in told


def test_few_poses_of_every_campaign_are_refused_where_they_do_not_identify_the_robot():
    few = [seen(seed, n=3) for seed in (1, 2)]
    with pytest.raises(
        Exception, match=r"6 different poses of all campaigns give 36 numbers.* do not identify it"
    ):
        compare(few)


@cache
def leaked() -> tuple[list[Campaign], Comparison]:
    """A compensator that lost a tenth of its charge: both campaigns, and what they say by themselves."""
    pair = [before(True), measured(2, loaded=True, effects=LEAK)]
    return pair, compare(pair)


def test_what_is_known_not_to_be_there_is_no_change_and_no_rival():
    pair, plain = leaked()
    (open_,) = plain.changes
    masses = {"link_mass(link_2)", "link_mass(link_3)"}
    assert masses & {open_.label, *(rival.label for rival in open_.rivals)}
    told = compare(pair, known=["no link_mass"])
    change = only(told)
    assert change.cause == "gravity_compensator"
    assert not [r for r in change.rivals if r.cause == "link_mass"]
    assert not [u for u in told.unchanged if u.cause == "link_mass"]
    assert all("no link_mass" in note for note in told.notes if "given and kept to" in note)
    assert sum("given and kept to" in note for note in told.notes) == 2


def test_a_mass_that_was_read_is_kept_to_where_it_is_said_of_every_campaign():
    pair, _ = leaked()
    facts = ["link_mass:link=link_2,mass=0,std=0", "link_mass:link=link_3,mass=0,std=0"]
    change = only(compare(pair, known=facts))
    assert change.cause == "gravity_compensator"
    assert change.probability > max((r.probability for r in change.rivals), default=0.0) + 0.9


def test_what_is_said_of_one_campaign_alone_is_not_used(tmp_path, capsys):
    paths = [str(write_campaign(tmp_path / f"{n}", c)) for n, c in enumerate((before(), measured(2)))]
    with open(paths[1], "a", encoding="utf-8") as after:
        after.write('[known]\nexclude = ["link_mass"]\n')
    main(["compare", *paths])
    assert "given and not used: no link_mass (a comparison uses what is said of every campaign" in (
        capsys.readouterr().out
    )


def test_a_fact_that_the_data_of_a_campaign_refute_is_told_and_not_kept_to():
    pair, plain = [before(), measured(2)], nothing()
    fact = "joint_compliance:joint=joint_3,relative={},std=0"
    kept, refuted = (compare(pair, known=[fact.format(relative)]) for relative in (0, 0.2))
    assert all("given and kept to" in note for note in kept.notes)
    assert len(refuted.notes) == 2  # and none that the noise does not explain what the model leaves
    assert all("the data contradict it" in note and "was not kept to" in note for note in refuted.notes)
    assert refuted.headline == plain.headline


def held() -> list[Campaign]:
    """Two plans, half of the poses of each with a load."""
    load = {"heavy": (100.0, [0.15, 0.0, 0.0])}
    poses = [random_poses(robot(), POSES, np.random.default_rng(seed)) for seed in (1, 2)]
    which = ["heavy", ""] * (POSES // 2)
    return [planned(robot(), q, targets=ON_FLANGE, payload=which, payloads=load) for q in poses]


def test_another_tool_is_a_load_of_its_own():
    """What each campaign states to be mounted weighs on the arm as before, alone and beside a payload."""
    gripper, gun = (
        replace(one, tool_mass=mass, tool_com=np.array([0.1, 0.0, 0.1]))
        for one, mass in zip(held(), (40.0, 150.0), strict=True)
    )
    assert with_tools_as_loads([gripper, gripper])[1] == ()
    (first, second), (said,) = with_tools_as_loads([gripper, gun])
    assert "40, 150 kg" in said
    assert second.payload_names == ("", "tool", *gun.payload_names[1:])
    for own, of in ((first, gripper), (second, gun)):
        carried = own.load_mass[own.poses.payload]
        assert carried == pytest.approx(of.tool_mass + of.load_mass[of.poses.payload])
        moment = (own.load_mass[:, None] * own.load_com)[own.poses.payload]
        stated = (of.load_mass[:, None] * of.load_com)[of.poses.payload]
        assert moment == pytest.approx(stated + of.tool_mass * of.tool_com)
    truth = Truth(sigma=SIGMA, geometry=random_geometry(problem_of(gun).arm, np.random.default_rng(0)))
    comparison = compare([simulate(c, truth, seed=seed) for seed, c in enumerate((gripper, gun))])
    assert not comparison.changed
    assert said in comparison.notes


def test_tools_that_are_both_stated_too_light_are_compared():
    """Each campaign shows it of its own tool by itself; together these have names of their own."""
    campaigns = []
    for seed, (one, mass) in enumerate(zip(held(), (60.0, 260.0), strict=True)):
        plan = replace(one, tool_mass=mass, tool_com=np.array([0.1, 0.0, 0.2]))
        effect = parse_effect("payload:payload=tool,variant=mass,mass=60", problem_of(plan))
        campaigns.append(simulate(plan, Truth(sigma=SIGMA, effects=(effect,)), seed=seed))
    assert "robot is unchanged" in compare(campaigns).headline


def test_one_nest_that_moved_is_told_by_its_name():
    first = ON_FLANGE[0]
    assert first.xyz is not None
    moved = replace(first, xyz=(first.xyz[0], first.xyz[1], first.xyz[2] + 5e-4))
    unsaid = seen(2, (moved, *ON_FLANGE[1:]))
    comparison = compare([seen(1), replace(unsaid, targets=seen(1).targets)])
    said = comparison.headline.split("; ")[-1]
    assert said.startswith("T1 sits elsewhere by 0.5")
    assert said.endswith("(not T2 and T3): its reflector or nest was mounted anew.")


def test_targets_that_moved_as_stated_are_told_as_that():
    moved = tuple(
        replace(t, xyz=(t.xyz[0], t.xyz[1], t.xyz[2] + by))
        for t, by in zip(ON_FLANGE, (5e-4, 0, 0), strict=True)
    )
    comparison = compare([seen(1), seen(2, moved)])
    assert "T1 sits elsewhere by 0.5" in comparison.headline
    assert comparison.headline.endswith("mm (not T2 and T3), as stated.")
    assert "targets moved, as stated: T1 0." in said_of(comparison)["apart_lines"][1]
    told = comparison.to_json()["apart"][1]
    assert told["targets_moved"]
    assert told["targets"][0]["stated_mm"] == pytest.approx([0.0, 0.0, 0.5])
    silent = seen(2, targets=ON_FLANGE)
    restated = replace(silent, targets=moved)
    assert (
        "targets where they were, though stated elsewhere"
        in (said_of(compare([seen(1), restated]))["apart_lines"][1])
    )


def test_another_tool_is_told_as_stated_to_what_it_is_stated_to():
    """Its places are stated to a millimetre, which the instrument sees: they are no warmer for that."""
    moved = tuple(replace(t, xyz=tuple(v + 0.0306 for v in t.xyz or ())) for t in ON_FLANGE)
    stated = tuple(replace(t, xyz=tuple(v + 0.030 for v in t.xyz or ())) for t in ON_FLANGE)
    comparison = compare([seen(1), replace(seen(2, moved), targets=stated)])
    said = comparison.headline.split("; ")[-1]
    assert said.startswith("the targets sit elsewhere by 5")
    assert said.endswith(" mm, as stated to 1.1 mm.")
    assert ", as stated to 1.1 mm: " in said_of(comparison)["apart_lines"][1]
    (first, *_) = comparison.to_json()["apart"][1]["targets"]
    assert not first["as_stated"]
    assert first["off_stated_mm"] == pytest.approx(1.04, abs=0.1)


@pytest.mark.parametrize(("mm", "warm"), [(0.08, True), (0.5, False)])
def test_targets_are_warmer_by_no_more_than_what_carries_them_grows(mm, warm):
    place = np.array([0.1, 0.05, 0.08])
    assert _may_be_warm(place, np.array([0.0, 0.0, 1e-3 * mm]), 1e-6 * np.eye(3)) is warm
    each = tuple(
        TargetMoved(f"T{k}", (0.0, 0.0, mm), (0.01,) * 3, True, None, False, "flange", warm) for k in (1, 2)
    )
    (said,) = _elsewhere(TargetsMoved(each, ()))
    assert said.endswith("mounted anew, or are warmer") is warm


def test_no_target_in_common_is_told():
    others = tuple(replace(t, name=f"A{t.name}") for t in ON_FLANGE)
    comparison = compare([seen(1), seen(2, others)])
    assert "no target in common with the first" in said_of(comparison)["apart_lines"][1]
    assert not comparison.to_json()["apart"][1]["targets_moved"]


def test_targets_on_the_base_that_turn_together_may_be_the_first_joint():
    loose = (*ON_FLANGE, *ON_BASE)
    comparison = compare([seen(1, loose), seen(2, loose, zero={1: TURN})])
    assert comparison.exit_status == 0
    (together,) = comparison.apart[1].moves.together
    assert (together.link, together.targets, together.joint) == ("base", ("B1", "B2", "B3"), "joint_1")
    assert abs(together.turn_mrad - 1e3 * TURN) < 4 * together.turn_std_mrad < 0.1
    assert "the targets on the base turned together about joint_1 by 0." in comparison.headline
    assert "(not T1, T2 and T3): its zero moved, or what carries them" in comparison.headline
    fixed = (*ON_FLANGE, *(replace(t, fixed=True) for t in ON_BASE))
    change = only(compare([seen(1, fixed), seen(2, fixed, zero={1: TURN})]))
    assert change.label == "joint_1 zero"
    assert within(change.parameters[0], TURN)


def test_a_payload_that_a_later_campaign_misstates_is_named_and_is_not_the_robot():
    truth = measured(2, loaded=True)
    lies = replace(truth, load_mass=np.where(truth.load_mass > 0, truth.load_mass - 30.0, 0.0))
    comparison = compare([before(True), lies])
    (change,) = comparison.changes
    assert (change.cause, change.side, change.status, comparison.exit_status) == (
        "payload",
        "load",
        "named",
        0,
    )
    assert within(change.parameters[0], 30.0)
    assert " is off by " in comparison.headline
    other_way = compare([lies, before(True)])
    assert not other_way.changes
    assert any("not as stated" in note for note in other_way.notes)


def test_a_bound_that_says_nothing_is_not_said():
    assert "the robot is unchanged within 0.1 mm" in headline([], 0.1, [], False, (), 1.5).lower()
    assert headline([], 8.5, [], False, ("joint_1",), 1.5, "june").startswith(
        "No change of the robot is seen; changes as large as the nominal robot's error (1.5 mm) could not "
        "have been seen in june (nor the zero of joint_1"
    )


@pytest.mark.parametrize(("misfit", "where", "still"), [
    (True, Where(joint="joint_2"), True),
    (True, Where(link="link_2"), True),
    (True, Where(link="link_1"), False),
    (True, Where(joint="joint_1"), False),
    (False, Where(joint="joint_2"), False),
])  # fmt: skip
def test_what_sits_at_a_joint_that_stood_still_is_no_change_where_the_model_does_not_fit(
    misfit, where, still
):
    """Other poses show another part of what the model lacks: a measured robot was told to have changed."""
    arm = SimpleNamespace(names=("joint_1", "joint_2"), links=("base_link", "link_1", "link_2"))
    moved, stood = np.array([[0.0, 0.0], [2.0, 2.0]]), np.array([[0.0, 0.0], [2.0, 1e-3]])
    occasions = [SimpleNamespace(problem=SimpleNamespace(q=q, arm=arm)) for q in (stood, moved)]
    decided = SimpleNamespace(
        candidates=[SimpleNamespace(where=where, cause="joint_compliance", side="robot")],
        system=SimpleNamespace(misfit=misfit, occasions=occasions),
    )
    assert stood_still(decided, 0) is still
    assert of_robot(decided, 0) is not still


def test_the_noise_is_said_once():
    (line, _) = said_of(shifted())["apart_lines"]
    assert line.count("noise") <= 1
    assert "the points scatter 0.0" in line
    assert "mm per axis about the model (stated is 0.030 mm)" in line
    assert (
        "nobody stated a noise"
        in said_of(compare([replace(c, noise_sigma=None) for c in (before(), measured(2))]))["apart_lines"][0]
    )
