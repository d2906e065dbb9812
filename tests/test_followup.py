"""What stays open is settled by the poses that are offered for it: the demo's own tie, and the study."""

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from workbench import (
    Truth,
    Where,
    diagnose,
    follow_up,
    load_robot,
    plan,
    planned,
    random_poses,
    simulate,
    what_decides,
)
from workbench.campaign.joined import join
from workbench.campaign.payloads import with_payloads
from workbench.campaign.problem import problem_of
from workbench.cli.main import main
from workbench.diagnosis.found import Decision, Finding, Rival
from workbench.effects.records import parse_effect
from workbench.effects.unnamed import unnamed
from workbench.files.faults import InputError
from workbench.measurement.design import decide, shown
from workbench.measurement.design.decide import command_text
from workbench.measurement.design.prior_information import from_prepared
from workbench.measurement.design.settle import tie_said
from workbench.measurement.design.t_optimal import design_space
from workbench.measurement.design.ties import (
    at_zero,
    least,
    settled_at,
    sites_of,
    tie_between,
    tie_of,
    told_apart,
)
from workbench.report.content import content
from workbench.report.deciding import decision
from workbench.studies import demo
from workbench.studies.followup import case_keys, followup
from workbench.studies.followup.case import judged

JOINT_3 = ("joint_compliance", "joint_3")


def statuses(outcome):
    return {(f.cause, str(f.where)): f.status for f in outcome.diagnosis.causes}


@pytest.fixture(scope="module")
def open_tie(tmp_path_factory):
    plan, rig = demo.prepared(3, 100)
    campaign = demo._measured(tmp_path_factory.mktemp("demo") / "campaign", rig, plan, 0)
    return rig, campaign, what_decides(diagnose(campaign))


def test_the_demos_tie_is_settled_by_the_poses_that_it_asks_for(open_tie, tmp_path):
    rig, campaign, first = open_tie
    assert statuses(first)[JOINT_3] == "ambiguous"
    said = first.diagnosis.headline
    assert "not decided: joint compliance in joint_3 or" in said
    assert "joint_3" not in said.partition(";")[0]  # nothing open is found
    words, command, outcome = demo._settled(tmp_path, rig, campaign, first, 3, lambda _: None)
    assert "--tell" in command
    assert set(statuses(outcome).values()) == {"named"}
    assert set(statuses(outcome)) == {
        (e.cause, str(replace(e.where, order=None))) for e, _ in rig.truth.effects
    }
    (finding,) = (f for f in first.diagnosis.causes if f.status == "ambiguous")
    (way,) = (d for d in finding.decide if d.kind == "poses")
    tie = tie_of(first, finding)
    assert tie is not None
    reached = told_apart(outcome, tie, first)
    assert reached >= settled_at(way.lambda_before)
    (promised,) = follow_up(campaign, way, quick=True).hardest
    assert promised.plan == pytest.approx(
        reached, rel=0.2
    )  # λ of these poses, before and after they are measured
    told = demo._revealed(rig.truth, first.diagnosis, outcome.diagnosis, (words, command))
    assert len(told.rows) == 4  # nothing was named that is not there
    (row,) = (row for row in told.rows if row[0].startswith("joint_3 is softer"))
    assert row[1].startswith("Open: ")
    assert row[2].startswith("joint_3 is softer")


def test_the_demo_measures_what_is_asked_for_until_nothing_is(open_tie, tmp_path, monkeypatch):
    """With torques where the command has them, and again what stays open, all campaigns together: twice."""
    rig, campaign, first = open_tie
    told = []

    def diagnosed(campaigns, *_):
        told.append(list(campaigns))
        return first

    def with_torques(way):
        return replace(way, kind="drive_torque", command=f"{way.command} --torque")

    (finding,) = (f for f in first.diagnosis.causes if f.decide)
    asked = replace(finding, decide=tuple(with_torques(way) for way in finding.decide if way.kind == "poses"))
    asking = replace(first, diagnosis=replace(first.diagnosis, causes=(asked,)))
    monkeypatch.setattr(demo, "diagnose", diagnosed)
    monkeypatch.setattr(demo, "what_decides", lambda outcome: outcome)
    folder = tmp_path / "follow-up"
    words, command, outcome = demo._settled(folder, rig, campaign, asking, 3, lambda _: None)
    assert [len(campaigns) for campaigns in told] == [2, 3]
    assert outcome is first
    _, second, third = told[-1]
    assert np.isfinite(second.poses.torque).all()
    assert third.poses.torque is None
    assert (tmp_path / "follow-up-2" / "campaign.toml").is_file()
    assert [line.endswith("--torque") for line in command.splitlines()] == [True, False]
    assert "with the torques of the drives were planned" in words
    assert "To decide what both left open" in words


def test_a_tie_with_what_is_hidden_is_no_cause_that_is_not_there():
    """Whichever of its two comes first: the row of what is hidden says it. A wrong name has a row."""
    _, rig = demo.prepared(0, 30)
    effect = next(e for e, _ in rig.truth.effects if (e.cause, str(e.where)) == JOINT_3)
    other = Where(link="link_3")
    rival = Rival("joint_compliance", effect.where, 0.4)
    tie = Finding("link_bending", "", other, "ambiguous", 0.0, 0.6, rivals=(rival,))
    wrong = replace(tie, status="named", rivals=(), sentence="link_3 bends.")

    def rows(*found):
        diagnosis = SimpleNamespace(causes=found)
        return demo._revealed(rig.truth, diagnosis, diagnosis, ("", "")).rows

    assert all(hidden != "Nothing of this" for hidden, _, _ in rows(tie))
    assert ("Nothing of this", "link_3 bends.", "link_3 bends.") in rows(wrong)


def test_one_tie_has_one_lambda(open_tie, tmp_path):
    """In the diagnosis, in a plan by its command, and in one by its result.json."""
    _, campaign, outcome = open_tie
    (finding,) = (f for f in outcome.diagnosis.causes if f.decide)
    (way,) = (d for d in finding.decide if d.kind == "poses")
    told = tmp_path / "result.json"
    written = outcome.diagnosis.to_json()
    told.write_text(json.dumps(written))
    (cause,) = (one for one in written["causes"] if one["status"] == "ambiguous")
    offered = next(one for one in cause["decide"] if one["command"])
    advice = finding.separate_by or offered["words"]  # words and command are of one
    assert cause["separate_by"] == {**offered, "advice": advice}
    assert all(one["separate_by"] is None for one in written["causes"] if one["status"] == "named")
    tell = shlex.split(way.command)[shlex.split(way.command).index("--tell") + 1]
    for text in (tell, str(told)):
        made = plan(campaign, way.poses, tell=text, quick=True)
        assert made.hardest[0].now == pytest.approx(way.lambda_before, rel=1e-6)
        assert made.settles
        assert "This plan is expected to settle it." in made.text
    said = content(outcome.diagnosis)
    assert "λ is how far apart two explanations are" in said["of_lambda"]
    after = replace(way, lambda_after=184.3, lambda_before=12.9)
    assert decision(after).endswith("(λ 13 → 180)")


def test_a_weight_that_can_be_mounted_is_planned_with(tmp_path):
    robot = load_robot("kr500")
    bare = planned(robot, random_poses(robot, 30, np.random.default_rng(27)))
    campaign = simulate(bare, Truth(sigma=3e-5), seed=1)
    weight = {"load": (200.0, (0.0, 0.0, 0.15))}
    made = plan(
        campaign, 12, tell="joint_compliance:joint=joint_3,link_mass:link=link_3", quick=True, payloads=weight
    )
    records = made.drive.records
    assert records.payload_names == ("", "load")
    assert set(records.poses.payload) == {0, 1}  # one load alone tells a stiffness from no mass
    with pytest.raises(InputError, match="another payload 'load', of 200 kg"):
        with_payloads(records, {"load": (100.0, (0.0, 0.0, 0.15))})


@pytest.fixture(scope="module")
def hosed():
    """A hose pack on a wrist joint: on poses alone it and a wrong ratio are the same."""
    robot = load_robot("kr500")
    bare = planned(robot, random_poses(robot, 24, np.random.default_rng(5)))
    hose = parse_effect("hose_torque:joint=joint_5,rate=40", problem_of(bare))
    campaign = replace(simulate(bare, Truth(sigma=3e-5, effects=(hose,)), seed=2), noise_sigma=3e-5)
    return campaign, diagnose(campaign)


def test_torques_are_planned_for_the_tie(hosed):
    """The command names the tie, and its plan counts on the torques, without which no poses tell."""
    campaign, outcome = hosed
    prior = from_prepared(outcome.prepared)
    hose, values = parse_effect("hose_torque:joint=joint_5,rate=40", prior.problem)
    (ratio,) = (e for e in sites_of([("gear_ratio", hose.where)], prior.fit))
    tie = tie_between(prior.fit, hose, values, (ratio,), {hose.key: 0.6, ratio.key: 0.4})
    valued = at_zero([tie])
    found = decide._decisions(tie, tie, decide.Offers(prior, valued, prior.of_campaign(valued)))
    (way,) = (d for d in found if d.kind == "drive_torque")
    asked = shlex.split(way.command)
    tell = asked[asked.index("--tell") + 1]
    assert tell.startswith("hose_torque:joint=joint_5,rate=40")
    made = follow_up(campaign, way, quick=True)
    assert made.drive.torque
    assert made.settles
    blind = plan(campaign, way.poses, tell=tell, quick=True)
    assert blind.drive is None


def test_ties_that_are_open_at_once_are_settled_in_one_visit(hosed):
    """With torques, for one asks for them; in fewer poses than one tie after the other takes, and its command
    plans for both."""
    campaign, outcome = hosed
    prior = from_prepared(outcome.prepared)

    def tie(first, rival):
        effect, values = parse_effect(first, prior.problem)
        other = parse_effect(rival, prior.problem)[0]
        return tie_between(prior.fit, effect, values, (other,), {effect.key: 0.6, other.key: 0.4})

    hose = tie("hose_torque:joint=joint_5,rate=40", "gear_ratio:joint=joint_5,relative=1e-4")
    soft = tie("joint_compliance:joint=joint_2,relative=0.3", "link_bending:link=link_2,compliance=1e-8")
    ties, valued = (hose, soft), at_zero([hose, soft])
    offers = decide.Offers(prior, valued, prior.of_campaign(valued))
    alone = [decide._decisions(one, one, offers) for one in ties]
    assert [ways[0].kind for ways in alone] == ["drive_torque", "poses"]
    (ours,), (theirs,) = decide._at_once(ties, alone, offers)
    assert ours.kind == "drive_torque"
    assert ours.command == theirs.command
    assert ours.words.endswith("chosen for it and for joint compliance in joint_2")
    assert ours.poses < sum(ways[0].poses for ways in alone)
    made = follow_up(campaign, ours, quick=True)
    assert made.drive.torque
    assert made.settles
    assert {one.effect for one in made.asked} == {hose.effect, soft.effect}
    assert decide._at_once(ties, [alone[0], ()], offers) == [(), ()]


def test_what_torques_tell_of_a_tie_that_they_do_not_settle_is_counted(hosed):
    """Two causes without a torque stay two: the torques tell the hose pack from both, in so many poses."""
    _, outcome = hosed
    prior = from_prepared(outcome.prepared)
    hose, values = parse_effect("hose_torque:joint=joint_5,rate=40", prior.problem)
    rivals = tuple(
        parse_effect(f"{cause}:joint=joint_5,{size}", prior.problem)[0]
        for cause, size in (("gear_ratio", "relative=1e-4"), ("joint_map", "amplitude=1e-4"))
    )
    chances = {hose.key: 0.4, **{rival.key: 0.3 for rival in rivals}}
    tie = tie_between(prior.fit, hose, values, rivals, chances)
    valued = at_zero([tie])
    offers = decide.Offers(prior, valued, prior.of_campaign(valued))
    (words,) = decide._told_by_torque(offers, tie, "tau1_Nm")
    assert re.search(r"at \d+ more poses: they tell hose torque in joint_5 from gear ratio in joint_5", words)


def test_poses_are_offered_that_tell_some_of_the_rivals(hosed):
    """No pose tells a hose pack from a ratio of its joint, but from a heavier link: the words say which, and
    the command plans for that one."""
    campaign, outcome = hosed
    prior = from_prepared(outcome.prepared)
    hose, values = parse_effect("hose_torque:joint=joint_5,rate=40", prior.problem)
    rivals = tuple(
        parse_effect(text, prior.problem)[0]
        for text in ("gear_ratio:joint=joint_5,relative=1e-4", "link_mass:link=link_5,mass=2")
    )
    chances = {hose.key: 0.4, **{rival.key: 0.3 for rival in rivals}}
    tie = tie_between(prior.fit, hose, values, rivals, chances)
    valued = at_zero([tie])
    offers = decide.Offers(prior, valued, prior.of_campaign(valued))
    tell = shlex.quote(command_text(tie))
    (way,) = decide._told_by_poses(offers, tie, tie, tell)
    assert way.words.endswith(
        "they tell hose torque in joint_5 from link mass in link_5, but not from gear ratio in joint_5"
    )
    made = follow_up(campaign, way, quick=True)
    assert len(made.records.poses) == way.poses
    assert [rival.cause for _, rival in made.hopeless] == ["gear_ratio"]
    assert decide._told_by_poses(offers, tie.beside(rivals[0].key), tie, tell) == []


def test_a_scale_is_asked_for_where_a_mass_is_a_rival(open_tie):
    """How exactly: a fifth of what would have to be wrong with it; the command says what was read."""
    _, campaign, outcome = open_tie
    prior = from_prepared(outcome.prepared)
    soft, values = parse_effect("joint_compliance:joint=joint_3,relative=0.5", prior.problem)
    rivals = (
        parse_effect("link_mass:link=link_3,mass=10", prior.problem)[0],
        parse_effect("link_bending:link=link_3,compliance=1e-8", prior.problem)[0],
    )
    chances = {soft.key: 0.5, **{rival.key: 0.25 for rival in rivals}}
    tie = tie_between(prior.fit, soft, values, rivals, chances)
    space = design_space(prior.of_records(campaign, at_zero([tie])), prior.of_campaign(at_zero([tie])))
    offers = SimpleNamespace(space=space, carried={}, unsettled=frozenset())
    ways = decide._readings(prior.problem, tie, offers, least(space, space.before, tie))
    (scale,) = (way for way in ways if "mass_kg" in way.words)
    assert scale.words.endswith("kg: whether it is link mass in link_3")
    assert "--known link_mass:link=link_3,mass_kg=VALUE,std=" in scale.command


def test_rivals_have_the_forms_that_a_diagnosis_gives_them(open_tie):
    """A joint's yield may curve with the load, a link may be heavier and hang elsewhere at once: such rivals
    imitate what neither number does, and a tie that they hold open is not said to be settled."""
    _, _, outcome = open_tie
    prior = from_prepared(outcome.prepared)
    soft, values = parse_effect("lost_motion:joint=joint_3,variant=cubic,amplitude=2e-4", prior.problem)
    yields = parse_effect("joint_compliance:joint=joint_3,relative=0.5", prior.problem)[0]
    mass, com = sites_of([("link_mass", Where(link="link_3"))], prior.fit)
    tie = tie_between(prior.fit, soft, values, (yields, mass, com), {})
    (rarer,) = {companion for _, companion in yields.rarer(prior.problem)}
    assert any(form.first == yields and rarer.key in {e.key for e, _ in form} for form in tie.forms)
    (both,) = (form for form in tie.forms if [effect for effect, _ in form] == [mass, com])
    assert both.own == 2
    space = design_space(prior.of_records(outcome.problem.campaign, at_zero([tie])), None)
    owns = [one.own for one in tie.hypotheses(space).patterns]
    assert owns[tie.forms.index(both)] == 1 + 3


def test_a_command_with_a_rival_that_hardly_shows_is_no_fault(open_tie):
    """A diagnosis says all that competed; of what a person asks for each has to show."""
    _, campaign, _ = open_tie
    tie = "gear_ratio:joint=joint_2,relative=3e-4,probability=0.6"
    tie += ",joint_compliance:joint=joint_2,probability=0.3"
    made = plan(campaign, 10, tell=f"{tie},link_mass:link=link_1,probability=0.001", quick=True)
    assert made.drive is not None
    with pytest.raises(InputError, match=r"link_1.*cannot show in this model"):
        plan(campaign, 10, tell=f"{tie},link_mass:link=link_1", quick=True)


def test_a_long_question_is_no_file(open_tie, tmp_path, monkeypatch, capsys):
    _, campaign, first = open_tie
    (finding,) = (f for f in first.diagnosis.causes if f.decide)
    (way,) = (d for d in finding.decide if d.kind == "poses")
    monkeypatch.chdir(tmp_path)
    words = [word if word != "follow-up" else str(tmp_path / "out") for word in shlex.split(way.command)]
    at = words.index("--tell") + 1
    words[at] += "".join(f",link_bending:link=link_{k},probability=0.001" for k in (1, 2, 5))
    words[at] += ",bearing_tilt:joint=joint_1,probability=0.001"
    assert len(words[at]) > 255
    main([*words[1:], "--quick"])
    assert (tmp_path / "out" / "poses.csv").is_file()
    assert campaign.n_poses == 100


def test_commands_name_all_that_was_diagnosed(open_tie, tmp_path):
    """Both campaigns of a joint diagnosis, and the facts that were said beside their files."""
    _, campaign, _ = open_tie
    first, second = (replace(campaign, path=Path(name)) for name in ("my first.toml", "second.toml"))
    whole = join([first.with_known(["no drift"]), second])
    assert shlex.split(whole.arguments) == ["my first.toml", "second.toml", "--known", "no drift"]


def test_the_command_says_all_that_the_tie_is(open_tie):
    """Its plan is that of the tie: the same rivals, as likely as the diagnosis has them."""
    _, _, first = open_tie
    (finding,) = (f for f in first.diagnosis.causes if f.status == "ambiguous")
    tie = tie_of(first, finding)
    assert tie is not None
    nameless = next(iter(unnamed(first.problem))).key
    tie = tie_between(
        first.prepared.geometry,
        tie.effect,
        tie.size * [p.typical for p in tie.effect.params],
        tie.rivals,
        {tie.effect.key: 0.6, **{r.key: 0.3 for r in tie.rivals}, nameless: 0.1},
    )
    told = tie_said(command_text(tie), first.prepared.geometry)
    assert told.chances == tie.chances
    assert (told.effect, set(told.rivals)) == (tie.effect, set(tie.rivals))
    assert told.size == pytest.approx(tie.size, rel=1e-2)
    assert [[e.key for e, _ in form] for form in told.forms] == [[e.key for e, _ in f] for f in tie.forms]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("gear_ratio:joint=joint_2,relative=1e-4,probability=2,hose_torque", "probability is '2'"),
        ("gear_ratio:joint=joint_2,relative=1e-4,probability=x,hose_torque", "probability is 'x'"),
        ("gear_ratio:joint=joint_2,relative=1e-4,unknown:link=link_9", "nothing without a name sits there"),
        ("gear_ratio:joint=joint_2,relative=1e-4,unknown:joint=joint_3", "no rival with a name"),
    ],
)
def test_a_tie_that_is_said_wrongly_is_refused(open_tie, text, said):
    with pytest.raises(InputError, match=said):
        tie_said(text, open_tie[2].prepared.geometry)


def test_what_no_poses_decide_is_no_plan(open_tie):
    _, campaign, _ = open_tie
    with pytest.raises(ValueError, match="no poses decide it"):
        follow_up(campaign, Decision("other", "weigh the link", None, None, 0.0, None))


def test_a_name_that_is_not_true_is_wrong_however_it_came(open_tie):
    *_, first = open_tie
    gas, gear, play = (
        ("gravity_compensator", Where()),
        ("gear_kinematic_error", Where(joint="joint_4")),
        ("backlash", Where(joint="joint_5")),
    )
    truths = [gas, gear, play]
    assert judged(first, truths, {gas}) == "right"
    assert judged(first, truths[:2], {gas}) == "wrong"
    missing = ("joint_compliance", Where(joint="joint_3"))
    assert judged(first, [*truths, missing], {missing}) == "open"


def test_the_study_counts_and_resumes(tmp_path):
    keys = case_keys(1)[:2]
    study = followup(tmp_path, workers=1, keys=keys)
    assert not study.failed
    assert [case["key"] for case in study.cases] == keys
    again = followup(tmp_path, workers=1, keys=keys, resume=True)
    assert again.to_json() == json.loads(json.dumps(study.to_json()))
    assert (tmp_path / "index.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert json.loads((tmp_path / "results.json").read_text())["cases"] == 2


def test_a_rival_that_no_poses_tell_leaves_the_others_to_be_told(open_tie, monkeypatch):
    _, _, first = open_tie
    said = ",".join(
        f"{cause}:joint=joint_4,{size}probability=0.3"
        for cause, size in (("gear_ratio", "relative=2e-4,"), ("hose_torque", ""), ("gear_eccentricity", ""))
    )
    tie = tie_said(said, first.prepared.geometry)

    def power(settling, _):
        return 0.9 - 0.8 * any(rival.cause == "hose_torque" for rival in settling.ties[0].rivals)

    monkeypatch.setattr(shown.Settling, "power", power)
    rest, gone = shown.with_hope(None, None, tie)
    assert [rival.cause for rival in gone] == ["hose_torque"]
    assert {rival.cause for rival in rest.rivals} == {"gear_eccentricity"}
    assert {form.first.cause for form in rest.forms} == {"gear_ratio", "gear_eccentricity"}
    monkeypatch.setattr(shown.Settling, "power", lambda *_: 0.1)
    rest, gone = shown.with_hope(None, None, tie)
    assert not rest.rivals
    assert gone == [tie.rivals[0]]
