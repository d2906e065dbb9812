"""What is known by other means: read, looked up, counted in, and told where the data contradict it."""

from __future__ import annotations

import shlex
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from diagnosis_cases import measured, named

from workbench import diagnose, load_robot, plan, planned, what_decides
from workbench.campaign import Campaign, load_campaign, write_campaign
from workbench.campaign.known import KnownData, parse_known
from workbench.campaign.problem import problem_of
from workbench.diagnosis import given
from workbench.effects.given import given_facts
from workbench.files.faults import InputError
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.model_file import fit_files
from workbench.identification.noise import required_noise
from workbench.measurement.design import offers
from workbench.measurement.design.discrimination_plan import LEVELS
from workbench.report.content import _given as content_row
from workbench.report.content import content
from workbench.report.numbers import mm
from workbench.report.terminal import short_verdict
from workbench.robot.equilibrium import NoRest

CHARGE = "gravity_compensator:variant=charge,relative=-0.07"
SLACK = "backlash:joint=joint_5,half_width=2.5e-4"
BAR = 163.0  # of the KR 500's compensator, as its TOML has it


def too_soft(*_: object) -> None:
    raise NoRest


@cache
def weak() -> Campaign:
    """A KR 500 that has lost a fourteenth of its charge, without payload: a link's mass would do the same."""
    return measured("kr500", (CHARGE, SLACK), poses=40, loads=())


def test_facts_are_read_from_text_and_toml_alike(tmp_path):
    texts = ["link_mass:link=link_2,mass_kg=311,std=2,note=weighed", "no hose_torque", "no backlash(joint_5)"]
    campaign = weak().with_known(texts)
    assert campaign.known.exclude == ("hose_torque", "backlash(joint_5)")
    (fact,) = campaign.known.facts
    assert (fact.link, fact.parameter, fact.value, fact.std) == ("link_2", "mass_kg", 311.0, 2.0)
    again = load_campaign(write_campaign(tmp_path, campaign))
    assert again.known == campaign.known
    assert "[[known.facts]]" in (tmp_path / "campaign.toml").read_text()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("link_mass:link=link_2,mass_kg=311", "std"),
        ("link_mass:link=link_2,std=2", "says 0 numbers"),
        ("link_mass:link=link_2,mass_kg=heavy,std=2", "number"),
        ("link_mass:link=link_9,mass_kg=311,std=2", "no link 'link_9'"),
        ("link_mass:link=link_2,variant=com,mass_kg=3,std=2", "has 3 numbers"),
        ("gear_rato:joint=joint_4,ratio=120,std=0", "no cause"),
        ("gravity_compensator:precharge_bar=-3,std=1", "is no gravity_compensator"),
        ("gravity_compensator:rate=3,std=1", "no rate to differ from"),
        ("joint_compliance:joint=joint_2,stiffness=-3,std=1", "-3 is no stiffness"),
        ("no backlsh", "no cause 'backlsh'"),
        ("no changed_setup", "is a fault of the data, no cause"),
        ("no backlash(joint_9)", "cannot sit there"),
        ("no payload(heavy)", "cannot sit there"),
        ("gear_ratio:joint=joint_4,ratio=120,std=0", "would be -0.166667, since the model has ratio 100"),
    ],
)
def test_a_fact_that_cannot_be_is_an_error_of_the_input(text, said):
    with pytest.raises(InputError) as error:
        diagnose(weak(), known=(text,))
    assert said in str(error.value)


def test_whole_quantities_become_differences_from_the_model():
    robot = weak().robot
    mass = float(problem_of(weak()).arm.mass[problem_of(weak()).arm.slot_of_link("link_2")])
    said = KnownData()
    for text in (
        f"link_mass:link=link_2,mass_kg={mass + 7},std=2",
        "gravity_compensator:gauge_bar=90,std=1,temp_degC=30",
        f"joint_compliance:joint=joint_2,stiffness={robot.joints[1].data.stiffness},std=0",
        f"gear_ratio:joint=joint_4,ratio={robot.joints[3].data.gear_ratio},std=0",
    ):
        said = said.and_more(parse_known(text))
    mass_, charge, stiffness, ratio = given_facts(problem_of(replace(weak(), known=said)))
    assert (mass_.value, mass_.std) == pytest.approx((7.0, 2.0))
    # a sealed gas: p/T constant; the gauge shows what is above the atmosphere
    assert charge.value == pytest.approx(91.01325 * 293.15 / 303.15 / BAR - 1)
    assert charge.std == pytest.approx(293.15 / 303.15 / BAR)
    assert (stiffness.value, ratio.value) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert 0 < ratio.std < 1e-9


def test_a_springs_free_length_becomes_a_preload():
    """Longer by 10 mm pulls less, by its rate."""
    robot = load_robot("rx170")
    spring = robot.compensator
    told = f"gravity_compensator:variant=preload,free_length={spring.free_length + 0.01},std=0.002"
    campaign = planned(robot, np.zeros((1, 6))).with_known([told])
    (fact,) = given_facts(problem_of(campaign))
    assert (fact.value, fact.std) == pytest.approx((-0.01 * spring.rate, 0.002 * spring.rate))


def test_a_given_number_is_weighed_against_the_data():
    """Bayes: the fit with a fact is the fit without it and the fact, weighed by their variances."""
    campaign = weak().with_known(["gravity_compensator:precharge_bar=93,std=0.6"])
    job = problem_of(campaign)
    (fact,) = given_facts(job)
    noise = required_noise(job)
    free = fit(Model(job, (fact.effect,)), start_state(job), noise, tolerance=1e-4)
    both = fit(Model(job, (), (), (fact,)), start_state(job), noise, tolerance=1e-4)
    (value,), ((variance,),) = free.effect_values(0)
    weight = np.array([1 / variance, fact.std**-2])
    std = weight.sum() ** -0.5
    # 65 standard deviations lie between the two: so far the arm is not quite linear
    assert both.given_estimate(0)[0] == pytest.approx(
        weight @ [value, fact.value] / weight.sum(), abs=0.2 * std
    )
    assert both.given_estimate(0)[1] == pytest.approx(std, rel=0.02)


def test_a_number_may_be_known_worse_than_its_size():
    known = (f"joint_compliance:joint=joint_2,stiffness=2e6,std={std}" for std in ("2e4", "4e6"))
    little, much = (given_facts(problem_of(weak().with_known([text])))[0] for text in known)
    assert little.value == much.value
    assert much.std == pytest.approx(200 * little.std, rel=0.02)


def test_a_fact_of_which_the_data_say_nothing_says_so():
    (fact,) = diagnose(measured("cylindrical", poses=20, loads=()), known=["no drift"]).diagnosis.given
    assert fact.obeyed
    assert "say nothing of it: no column t_s" in fact.sentence


def test_a_reading_of_the_gauge_decides(tmp_path):
    before = diagnose(replace(weak(), path=Path("my dir/campaign.toml")))
    assert named(before.diagnosis) == {
        ("gravity_compensator", ""): "ambiguous",
        ("backlash", "joint_5"): "named",
    }
    outcome = diagnose(weak(), known=[f"gravity_compensator:precharge_bar={0.93 * BAR},std=1"])
    after = outcome.diagnosis
    assert named(after) == {("backlash", "joint_5"): "named"}
    (fact,) = after.given
    assert fact.obeyed
    assert fact.fitted.value == pytest.approx(-0.07, abs=3 * fact.fitted.std)
    assert fact.fitted.std < fact.given.std
    # the same error is left as when the compensator was found
    assert after.stages[-1].heldout_rms_mm == pytest.approx(
        before.diagnosis.stages[-1].heldout_rms_mm, rel=0.03
    )
    assert (
        'cause = "gravity_compensator"'
        in fit_files(tmp_path / "model.toml", outcome.fit)[tmp_path / "model.toml"]
    )
    # what cannot be worked out does not lose the diagnosis
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(offers, "reach_of", too_soft)
        kept = what_decides(before)
    assert kept.diagnosis.causes == before.diagnosis.causes
    for notes in (kept.diagnosis.notes, kept.prepared.notes):
        assert "could not be worked out: robot: the loaded arm finds no rest" in notes[-1]
    # and that reading had been asked for
    (open_,) = (one for one in what_decides(before).diagnosis.causes if one.status == "ambiguous")
    offered = {one.kind: one for one in open_.decide}
    (gauge,) = (one for one in open_.decide if "precharge_bar to ± 2 bar" in one.words)
    command, verb, path, option, fact = shlex.split(gauge.command)
    assert (command, verb, path, option) == ("workbench", "diagnose", "my dir/campaign.toml", "--known")
    assert fact == "gravity_compensator:precharge_bar=VALUE,std=2"
    assert gauge.lambda_before < LEVELS.least < LEVELS.mostly <= gauge.lambda_after
    assert offered["other"].words in open_.separate_by


def test_what_was_given_and_is_confirmed_is_a_finding():
    """Told in the headline; geometry alone does not explain the data, and does not have the credit."""
    heavy = "link_mass:link=link_2,variant=mass,mass=150"
    campaign = measured("kr500", (heavy,), poses=60)
    found = diagnose(campaign, known=["link_mass:link=link_2,mass_kg=635,std=30"]).diagnosis
    assert found.verdict == "nothing_missing"
    assert found.headline.startswith("Given and confirmed: link_2 is 1")
    assert "beyond that nothing is missing: geometry and what was given explain" in found.headline
    nominal, geometry, with_given = found.stages
    assert (geometry.name, with_given.name) == ("geometry", "geometry + what was given")
    assert with_given.heldout_rms_mm < 0.8 * geometry.heldout_rms_mm < nominal.heldout_rms_mm
    (fact,) = found.to_json()["given"]
    assert fact["confirmed"]
    assert fact["seen"]["value"] == pytest.approx(150, abs=4 * fact["seen"]["std"])
    said = content(found)
    assert said["verdict"]["label"] == "Given and confirmed"
    assert "beyond what was given" in said["no_cause"]
    assert "With what was given in it as well" in said["summary"]
    assert f"and what was given {mm(with_given.heldout_rms_mm)}" in short_verdict(found, None)


def test_a_reading_that_was_given_is_not_asked_for_again():
    """A preload is not the charge: with the gauge read, the link is left to weigh."""
    pull = "gravity_compensator:variant=preload,preload=-1500"
    campaign = measured("kr500", (pull,), poses=40, loads=())
    outcome = what_decides(diagnose(campaign, known=[f"gravity_compensator:precharge_bar={BAR},std=1"]))
    (open_,) = (one for one in outcome.diagnosis.causes if one.status == "ambiguous")
    said = [open_.separate_by or "", *(one.words for one in open_.decide)]
    assert not any("gauge" in text or "precharge" in text for text in said)
    assert any("mass_kg of link_2" in text or "weigh the link" in text for text in said)
    commands = [one.command for one in open_.decide if one.command]
    assert all(f"precharge_bar={BAR},std=1" in one for one in commands)  # what was said stays said


def test_exact_facts_are_said_as_people_say_them():
    """The model's own number, exactly: no 1e-16 of it, no interval, and a spread only where there is one."""
    facts = ["gear_ratio:joint=joint_4,ratio=100,std=0", f"gravity_compensator:precharge_bar={BAR},std=1"]
    known = weak().with_known(facts)
    assert [fact.value for fact in given_facts(problem_of(known))] == [0.0, 0.0]
    ratio, charge = (item for item in diagnose(known).diagnosis.given)
    assert "relative" not in ratio.sentence
    assert content_row(ratio)[3] == "as given"
    assert charge.given.value == 0
    assert given._plain(charge.given) == "relative 0 ± 0.61 %"
    assert given._plain(ratio.given, exact=True) == "relative 0 ppm exactly"
    text = "gear_ratio:joint=joint_4,ratio=50,std=0"
    with pytest.raises(InputError, match=r"between -?\d[\d.]* and \d[\d.]*$") as told:
        given_facts(problem_of(weak().with_known([text])))
    assert not str(told.value).endswith(" 1")


def test_what_was_given_and_is_as_in_the_model_is_no_finding():
    found = diagnose(weak(), known=["joint_compliance:joint=joint_3,relative=0,std=0.01"]).diagnosis
    assert not any(fact["confirmed"] for fact in found.to_json()["given"])
    assert "onfirmed" not in found.headline


def test_a_fact_that_the_data_contradict_is_told_and_not_obeyed():
    known = ["backlash:joint=joint_5,half_width=2e-5,std=5e-6", "no backlash(joint_5)", "no hose_torque"]
    found = diagnose(weak(), known=known).diagnosis
    assert named(found)["backlash", "joint_5"] == "named"
    number, excluded, other = found.given
    assert [fact.obeyed for fact in found.given] == [False, False, True]
    assert number.seen.value == pytest.approx(2.5e-4, abs=3 * number.seen.std)
    assert {number.sentence, excluded.sentence} <= set(found.notes)
    assert other.sentence not in found.notes
    assert ("hose_torque", "given: it is not there") in {(n.cause, n.why) for n in found.not_testable}
    assert [fact["obeyed"] for fact in found.to_json()["given"]] == [False, False, True]
    assert "(half_width 20 ± 5 µrad to the model); the data alone say half_width 2" in number.sentence


def test_plans_count_in_what_is_known_and_tell_several_causes():
    link = "link_mass:link=link_2,variant=mass"
    causes = f"{link},gravity_compensator:variant=charge,link_mass:link=link_3,variant=mass"
    three = plan(weak(), 8, tell=causes, quick=True)
    known = plan(
        weak(), 8, tell=causes, quick=True, known=["joint_compliance:joint=joint_2,relative=0,std=0.01"]
    )
    assert {pair.effect.cause for pair in three.hardest} <= {"link_mass", "gravity_compensator"}
    assert known.least == pytest.approx(three.least, rel=0.5)
    with pytest.raises(InputError, match="is known"):
        plan(weak(), 8, tell=causes, quick=True, known=["link_mass:link=link_2,mass=0,std=1"])
