"""Experiment design: the exchange is exact, its plans are better than chance, and it says when none helps."""

import json
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np
import pytest

from workbench import Truth, load_campaign, load_robot, plan, planned, problem_of, random_poses, simulate
from workbench.cli.main import main
from workbench.diagnosis.weighing.components import usual
from workbench.diagnosis.weighing.screen import reduce_columns
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.records import parse_effect
from workbench.files.faults import InputError
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.noise import Covariance
from workbench.measurement.design import criterion, exchange
from workbench.measurement.design.candidates import Factors, candidates, take
from workbench.measurement.design.causes import factors, named_causes
from workbench.measurement.design.fedorov import gains, information
from workbench.measurement.design.prior_information import from_campaign, from_robot
from workbench.measurement.design.settle import found_by
from workbench.measurement.design.t_optimal import design_space

HEAVY = {"heavy": (250.0, (0.15, 0.0, 0.1))}


@pytest.fixture(scope="module")
def kr500():
    return from_robot(load_robot("kr500"))


@pytest.fixture(scope="module")
def campaign():
    """Ten poses with and without a load, narrow in joint 1, with noise."""
    robot = load_robot("kr500")
    q = random_poses(robot, 10, np.random.default_rng(3))
    q[:, 0] *= 0.2
    told = planned(robot, np.tile(q, (2, 1)), payloads=HEAVY, payload=[""] * 10 + ["heavy"] * 10)
    return simulate(told, Truth(sigma=3e-5), seed=1)


def small(seed, C=40, D=2, P=4):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(C, D, P)) * [1.0, 0.1, 3.0, 1e3], rng.normal(size=(7, P))


def direct(A, A0, prior=0.0):
    M = np.einsum("ndp,ndq->pq", A, A) + prior
    return np.sqrt(np.trace(A0 @ np.linalg.inv(M) @ A0.T))


# ---------------------------------------------------------------- the exchange


@pytest.mark.parametrize("prior", [None, np.diag([1.0, 2.0, 0.5, 4e5])])
def test_no_single_exchange_improves_the_result(prior):
    A, A0 = small(1)
    chosen, rho0 = exchange(A, A0, 6, prior=prior, seed=2)
    assert chosen.shape == (6,)
    assert len(set(chosen.tolist())) == 6
    assert rho0 == pytest.approx(direct(A[chosen], A0, 0.0 if prior is None else prior), rel=1e-9)
    assert rho0 == pytest.approx(criterion(A[chosen], A0, prior), rel=1e-12)
    others = [
        criterion(A[[*np.delete(chosen, k), x]], A0, prior)
        for k in range(6)
        for x in range(len(A))
        if x not in chosen
    ]
    assert rho0 <= min(others) * (1 + 1e-6)


def test_the_gain_is_exact():
    A, A0 = small(3)
    M = information(A[:5])
    V, Q = np.linalg.inv(M), A0.T
    gain = gains(A, V, Q)
    for x in (7, 20, 39):
        after = np.trace(A0 @ np.linalg.inv(M + A[x].T @ A[x]) @ A0.T)
        assert gain[x] == pytest.approx(np.trace(A0 @ V @ A0.T) - after, rel=1e-6)


def test_units_of_the_parameters_make_no_difference():
    A, A0 = small(4)
    unit = np.array([1.0, 1e-6, 1e5, 1e-3])
    one, two = exchange(A, A0, 5, seed=1), exchange(A * unit, A0 * unit, 5, seed=1)
    assert one[0].tolist() == two[0].tolist()
    assert one[1] == pytest.approx(two[1], rel=1e-6)


def test_what_cannot_be_identified_is_refused_where_it_counts():
    A, A0 = small(5, D=1)
    with pytest.raises(InputError, match="cannot identify"):
        exchange(A, A0, 3, seed=0)
    assert criterion(A[:3], A0) == np.inf
    blind = A * [1.0, 1.0, 1.0, 0.0]
    with pytest.raises(InputError, match="cannot identify"):
        exchange(blind, A0, 8, seed=0)
    # what nobody asks for need not be known, and a prior is knowledge
    rho0 = exchange(blind, A0 * [1, 1, 1, 0], 8, seed=0)[1]
    assert rho0 == pytest.approx(exchange(A[:, :, :3], A0[:, :3], 8, seed=0)[1], rel=1e-9)
    assert np.isfinite(exchange(blind, A0, 8, prior=np.eye(4), seed=0)[1])


@pytest.mark.parametrize("count", [0, 41])
def test_as_many_records_as_there_are(count):
    with pytest.raises(InputError, match="ask for 1 to 40"):
        exchange(*small(6), count)


@pytest.mark.parametrize("name", ["kr500", "kr120"])
def test_better_than_chance_on_a_robot(name):
    prior = from_robot(load_robot(name))
    rng = np.random.default_rng(8)
    effects = tuple((e, np.zeros(1)) for e in JointCompliance.sites(prior.problem))
    new = prior.of_records(candidates(prior, 300, Factors(), rng), effects)
    A0 = 1e3 * prior.of_predictions(candidates(prior, 100, Factors(), rng), effects) / 10
    held = np.eye(len(new.names))
    _, rho0 = exchange(new.values, A0, 15, prior=held, starts=1, seed=0)
    chance = [criterion(new.values[rng.choice(300, 15, replace=False)], A0, held) for _ in range(300)]
    assert 1.3 < np.median(chance) / rho0 < 3.0
    assert rho0 < min(chance)


# ---------------------------------------------------------------- accuracy


def test_a_plan_for_a_robot():
    robot = load_robot("kr500")
    made = plan(robot, 14, quick=True)
    assert made.records.poses.q.shape == (14, 6)
    assert made.now_mm is None
    assert 0.01 < made.plan_mm < 0.9 * made.random_mm < 0.1
    assert made.same > 14
    assert "after this plan" in made.text
    again = plan(robot, 14, quick=True)
    assert np.array_equal(made.records.poses.q, again.records.poses.q)
    assert not np.array_equal(made.records.poses.q, plan(robot, 14, quick=True, seed=1).records.poses.q)
    with pytest.raises(InputError, match="give a number of poses"):
        plan(robot, 0)


def test_the_expected_error_is_the_error(kr500):
    """What a plan promises is what fits to simulated noise reach, frame and targets fitted anew."""
    made = plan(kr500.robot, 14, quick=True)
    fresh = planned(kr500.robot, random_poses(kr500.robot, 60, np.random.default_rng(9)))
    exact = problem_of(simulate(fresh, Truth(repeatability=np.zeros(6)), seed=0))
    sharp = Covariance(np.full(exact.seen.shape, 1e-5), np.zeros(6), np.ones(60))
    errors = []
    for seed in range(6):
        job = problem_of(simulate(made.records, Truth(sigma=3e-5), seed=seed))
        effects = tuple(JointCompliance.sites(job))
        noise = Covariance(np.full(job.seen.shape, 3e-5), kr500.joint, np.ones(14))
        found = fit(Model(job, effects), start_state(job), noise)
        whole = replace(exact, arm=exact.arm.with_geometry(found.state.geometry))
        model = Model(whole, (), tuple(zip(effects, found.state.values, strict=True)))
        errors.append(fit(model, start_state(whole), sharp, geometry=False).residual)
    rms = 1e3 * np.sqrt(np.mean(np.sum(np.square(errors), axis=-1)))
    assert 0.7 < rms / made.plan_mm < 1.5


def test_what_was_measured_counts(campaign):
    made = plan(campaign, 8, quick=True)
    assert made.plan_mm < made.random_mm < made.now_mm
    assert set(made.to_json()["payloads"]) == {"", "heavy"}
    # measured in a narrow cone of joint 1: the plan turns it further
    assert np.ptp(made.records.poses.q[:, 0]) > 3 * np.ptp(campaign.poses.q[:, 0])


# ---------------------------------------------------------------- rivals


def space_of(prior, text, count, seed=0):
    offered = candidates(prior, count, Factors(), np.random.default_rng(seed))
    whole = replace(prior.problem, campaign=offered)
    pair = tuple(cause.effects(whole)[0] for cause in named_causes(text))
    at_zero = tuple((effect, np.zeros(len(effect.params))) for effect in pair)
    return design_space(prior.of_records(offered, at_zero), prior.of_campaign(at_zero)), pair, offered


def test_the_t_criterion_is_exact(campaign):
    space, pair, _ = space_of(
        from_campaign(campaign), "payload:variant=mass,joint_compliance:joint=joint_2", 60
    )
    rest = np.arange(10)
    (each,) = space.criterion_with_each(rest, [pair])
    for x in (20, 50, 70):
        (whole,) = space.criterion(space.measured(np.append(rest, x)), [pair])
        assert each[x] == pytest.approx(whole, rel=1e-6)


def test_lambda_is_that_of_the_diagnosis(kr500):
    """The same non-centrality as the screen of a campaign measured in these poses."""
    text = "gear_ratio:joint=joint_5,joint_compliance:joint=joint_2"
    space, pair, offered = space_of(kr500, text, 60)
    chosen = np.arange(40)
    job = problem_of(simulate(take(offered, chosen), Truth(sigma=3e-5), seed=2))
    noise = Covariance(np.full(job.seen.shape, 3e-5), kr500.joint, np.ones(40))
    at = fit(Model(job), start_state(job), noise)
    S = reduce_columns(at, np.concatenate([at.whitened(e) * usual(at, e) for e in pair], axis=2))[0]
    alone = [S[0, 0] - S[0, 1] ** 2 / S[1, 1], S[1, 1] - S[0, 1] ** 2 / S[0, 0]]
    assert space.criterion(space.measured(chosen), [pair, pair[::-1]]) == pytest.approx(alone, rel=0.02)


def test_a_plan_that_tells(kr500):
    made = plan(
        kr500.robot, 12, tell="backlash:joint=joint_3,lost_motion:joint=joint_3,variant=cubic", quick=True
    )
    assert made.least > 1.3 * min(pair.random for pair in made.hardest)
    assert np.ptp(made.records.poses.side[:, 2]) == 2
    assert {pair.effect.cause for pair in made.hardest} == {"backlash", "lost_motion"}


def test_cold_and_warm(kr500):
    made = plan(kr500.robot, 12, tell="thermal_growth,drift:variant=shift", quick=True)
    records = made.records
    assert np.all(np.diff(records.poses.time) > 0)
    assert np.ptp(records.poses.temperature) == 10
    assert records.poses.time.max() > 7200
    assert made.least > 80
    assert "This plan tells them apart." in made.text


def test_no_poses_tell_the_same_from_the_same(kr500):
    made = plan(kr500.robot, 20, tell="gear_ratio:joint=joint_4,hose_torque:joint=joint_4", quick=True)
    assert made.records is None
    assert made.to_json()["told_apart"] is False
    assert made.text.startswith("No poses tell gear_ratio(joint_4) from hose_torque(joint_4).")
    assert "hose pack taken off" in made.text


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        # a vertical axis carries no gravity torque
        ("kr500", "joint_compliance:joint=joint_1,foundation", "in no pose does a load of the model bend it"),
        (
            "kr500",
            "gear_ratio:joint=joint_2,link_mass:link=link_1",
            "link_1.*a body that turns upright",
        ),
        ("iiwa7", "gear_ratio:joint=joint_2,link_mass", "all joints and links of the model are rigid"),
    ],
)
def test_what_cannot_show_in_the_model_is_no_question(name, text, said):
    with pytest.raises(InputError, match=said):
        plan(load_robot(name), 10, tell=text, quick=True)


def test_every_two_causes_that_were_asked_for_are_told_and_none_worse_than_at_random():
    text = "backlash:joint=joint_3,lost_motion:joint=joint_3,variant=cubic,gear_ratio:joint=joint_3"
    made = plan(load_robot("kr500"), 12, tell=text, quick=True)
    two = {frozenset((pair.effect.cause, pair.rival.cause)) for pair in made.asked}
    names = ("backlash", "lost_motion", "gear_ratio")
    assert two == {frozenset(pair) for pair in combinations(names, 2)}
    assert len(made.to_json()["asked"]) == 3
    assert made.text.count("poses to tell") == 3
    assert made.worth[0] >= made.worth[1]


def test_causes_as_on_the_command_line():
    texts = ["gear_ratio:joint=joint_2", "payload:payload=heavy,variant=mass"]
    assert [cause.text for cause in named_causes(",".join(texts))] == texts
    assert [cause.text for cause in named_causes("gear_ratio,hose_torque")] == ["gear_ratio", "hose_torque"]


@pytest.mark.parametrize(
    ("text", "varied"),
    [
        ("gear_ratio,hose_torque", Factors()),
        ("backlash,lost_motion", Factors(approach=True)),
        ("thermal_growth,tracker_scale", Factors(warm=True)),
        ("drift,foundation", Factors(late=True)),
        ("drift,thermal_growth", Factors(warm=True, late=True)),
        ("gravity_compensator:variant=charge,joint_compliance", Factors()),
        ("gravity_compensator:variant=temperature,joint_compliance", Factors(warm=True)),
    ],
)
def test_a_plan_varies_what_its_causes_depend_on(kr500, text, varied):
    everything = candidates(kr500, 0, Factors(True, True, True), np.random.default_rng(1))
    assert factors(named_causes(text), replace(kr500.problem, campaign=everything)) == varied


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("drift", "names one cause, not two"),
        ("drifft", "no cause 'drifft'"),
        ("drifft,backlash", "no cause 'drifft'"),
        ("gear_ratio:joint_2,drift", "'joint_2' is no place or form"),
        ("gear_ratio:joint=joint_9,drift", "no joint 'joint_9'"),
        ("gear_ratio:joint=joint_2,relative=1,drift", "needs the campaign that was diagnosed"),
        ("payload:payload=heavy,joint_compliance", "no payload 'heavy'"),
        ("drift,drift", "names one cause at one place"),
    ],
)
def test_wrong_causes_are_refused(kr500, text, said):
    with pytest.raises(InputError, match=said):
        plan(kr500.robot, 5, tell=text, quick=True)


# ---------------------------------------------------------------- order and files


def test_the_command_writes_poses(tmp_path, capsys):
    out = tmp_path / "new" / "poses.csv"
    assert main(["plan", "kr500", "--poses", "7", "--quick", "--out", str(out), "--json"]) == 0
    said, told = capsys.readouterr()
    facts = json.loads(said)
    assert (facts["robot"], facts["kind"], facts["n_poses"]) == ("kr500", "accuracy", 7)
    assert facts["file"] == str(out)
    assert told.startswith("… ")
    assert [path.name for path in out.parent.iterdir()] == ["poses.csv"]
    assert main(["simulate", "kr500", "--poses", str(out), "--out", str(tmp_path / "measured")]) == 0
    returns = facts["drive"]["check_poses"]
    measured = load_campaign(tmp_path / "measured/campaign.toml")
    assert measured.n_poses == 7 + returns
    assert [name for name in measured.poses.ids if name.startswith("check_")] == ["check_1", "check_2"]
    source = str(tmp_path / "measured/campaign.toml")
    capsys.readouterr()
    assert main(["plan", source, "--poses", "7", "--quick", "--force", "--out", str(out)]) == 0
    assert f"{7 + returns} standstills written to {out}" in capsys.readouterr().out


def test_the_command_says_that_nothing_helps(tmp_path, capsys):
    out = tmp_path / "poses.csv"
    same = "gear_ratio:joint=joint_4,hose_torque:joint=joint_4"
    assert main(["plan", "kr500", "--tell", same, "--quick", "--out", str(out)]) == 0
    assert "Nothing was written." in capsys.readouterr().out
    assert not out.exists()


def test_the_command_refuses(tmp_path, capsys):
    (tmp_path / "broken.toml").write_text("schema = 1\nrobot =\n")
    for arguments, said in [
        (["kr5000"], "no such robot"),
        ([str(tmp_path / "no.toml")], "no such file"),
        ([str(tmp_path)], "neither a TOML file nor a robot"),
        ([str(tmp_path / "broken.toml")], "is not TOML"),
        (["kr500", "--out", str(tmp_path / "poses.src")], "ends in .src; CSV ends in .csv"),
        (["kr500", "--poses", "0"], "give a number of poses"),
        (["kr500", "--poses", "1000000000"], "asks for 1000000000 poses"),
        (["kr500", "--minutes", "1e6"], "10000 are the most"),
    ]:
        assert main(["plan", *arguments]) == 2
        shown, err = capsys.readouterr()
        assert shown == ""
        assert any(line.startswith("error: ") and said in line for line in err.splitlines()), err


def test_a_noise_that_nobody_knows_is_what_the_found_cause_leaves():
    """Not what geometry leaves, with the cause in it."""
    plan = planned(load_robot("kr500"), random_poses(load_robot("kr500"), 24, np.random.default_rng(3)))
    leak = "gravity_compensator:variant=charge,relative=-0.5"
    truth = Truth(sigma=3e-5, effects=(parse_effect(leak, problem_of(plan)),))
    campaign = replace(simulate(plan, truth, seed=3), noise_sigma=None)
    tell = f"{leak},probability=0.8,gear_ratio:joint=joint_2,probability=0.2"
    blind, told = (from_campaign(campaign, partial(found_by, text)) for text in (None, tell))
    assert told.sigma.mean() == pytest.approx(3e-5, rel=0.3)
    assert told.joint.max() < 0.4 * blind.joint.max()
    assert "what the model leaves" in told.noise
