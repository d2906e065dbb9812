"""No form is quite true: what a strong effect's form misses is no cause, and decides between no two."""

import numpy as np
import pytest
from diagnosis_cases import found, measured, named, with_points

from workbench import Truth, diagnose, load_robot, planned, random_poses, simulate
from workbench.campaign.problem import problem_of
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.priors import PRIORS, varied
from workbench.diagnosis.search.worth import _beyond
from workbench.diagnosis.weighing.chosen import Chosen, Member
from workbench.diagnosis.weighing.components import Component, Form, bare
from workbench.diagnosis.weighing.forms import Forms
from workbench.diagnosis.weighing.gram import Stored
from workbench.diagnosis.weighing.reduced import Reduced
from workbench.diagnosis.weighing.remainder import beyond_forms, remainder
from workbench.diagnosis.weighing.sets import Competition
from workbench.diagnosis.weighing.stand_ins import StandIns, times_too_sure
from workbench.diagnosis.weighing.weight import SCALES, WEIGHTS, Weight, likelihood, table_of
from workbench.effects.gear_eccentricity import GearEccentricity
from workbench.effects.joint_map import JointMap
from workbench.effects.link_bending import LinkBending
from workbench.effects.link_mass import LinkMass
from workbench.effects.place import Where
from workbench.effects.records import parse_effect
from workbench.identification.fit import refit
from workbench.identification.patterns import Pattern

CREEP = 0.27  # of the campaign: a time constant that is none of those tried


def competition_of(*columns: np.ndarray, data: np.ndarray, keys: list[tuple[str, Where]]) -> Competition:
    """Components of one column each, nothing fitted before them."""
    G = np.stack(columns, axis=1)
    parts = tuple((slice(i, i + 1),) for i in range(G.shape[1]))
    reduced = Reduced(parts, Stored(G.T @ G), G.T @ data, float(data @ data), float(len(data)), 1e9)
    form = Form((Pattern.__new__(Pattern),), np.ones(1), ())
    return Competition(reduced, [Component(key, (form,), float(np.log(0.01))) for key in keys])


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forms count as main columns without effects behind them."""
    monkeypatch.setattr(Form, "main", property(lambda form: 1))


def twins(chi2: float, off: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Data, a cause that makes them but for `off` of itself, and one that misses twice as much."""
    rng = np.random.default_rng(1)
    basis, _ = np.linalg.qr(rng.normal(size=(300, 3)))
    truth = np.sqrt(chi2) * basis[:, 0]
    one, two = basis[:, 0] + off * basis[:, 1], basis[:, 0] + 2 * off * basis[:, 2]
    noise = rng.normal(size=300)
    return truth + noise - basis @ (basis.T @ noise), *(np.sqrt(chi2) * x for x in (one, two))


def share_of_second(chi2: float, off: float, keys: list[tuple[str, Where]]) -> float:
    data, one, two = twins(chi2, off)
    competition = competition_of(one, two, data=data, keys=keys)
    (share,) = competition.shares([Member(0, 0, 1.0)])
    return share.get(1, 0.0)


@pytest.mark.usefixtures("plain")
def test_a_form_that_is_a_little_off_is_no_proof_against_a_rival_that_is_a_little_more() -> None:
    keys = [("link_bending", Where(link="link_1")), ("bearing_tilt", Where(joint="joint_2"))]
    small, large = (share_of_second(chi2, 0.03, keys) for chi2 in (40.0, 8000.0))
    # one misses 0.03 of itself, the other 0.06: 21 of χ² at 8000, as many as chance makes once in 30,000
    more = 8000 * (0.06**2 - 0.03**2)
    believed = 0.5 * PRIORS.directions * np.log(1 + more / PRIORS.directions)
    assert believed > 0.5 * more / (1 + PRIORS.form**2 * 8000)  # were the usual miss all that is known
    assert large == pytest.approx(1 / (1 + np.exp(believed)), rel=0.05)
    assert small == pytest.approx(0.5, abs=0.05)
    assert share_of_second(8000.0, 0.3, keys) < 1e-6  # another form altogether


@pytest.mark.usefixtures("plain")
def test_two_orders_of_one_gear_are_one_form() -> None:
    keys = [("gear_kinematic_error", Where(joint="joint_1", order=order)) for order in (20.0, 21.0)]
    assert bare(keys[0]) == bare(keys[1])
    assert share_of_second(8000.0, 0.03, keys) < 1e-4


def test_what_is_beyond_a_share_of_another_effect() -> None:
    strong = np.array([[100.0, 0.0], [0.0, 100.0], [0.0, 0.0]])
    its = np.array([[2.0, 0.0], [5.0, 7.0], [0.0, 4.0]])
    # within the share along the strong one nothing is left of it; else what exceeds it, and all across it
    most = 100.0 * PRIORS.form
    expected = max(2.0 - most, 0.0) ** 2 + 5.0**2 + (7.0 - most) ** 2 + 4.0**2
    assert _beyond(its, strong) == pytest.approx(expected)
    assert _beyond(its, 0 * strong) == pytest.approx((its**2).sum())


@pytest.mark.parametrize(("by", "said"), [("joint", []), ("time", ["drift"])])
def test_what_goes_with_a_joint_that_went_along_with_time_is_no_drift(by: str, said: list[str]) -> None:
    """Poses in the order of joint_1, roughly: correlation 0.98 with time."""
    robot, rng = load_robot("kr500"), np.random.default_rng(1)
    q = random_poses(robot, 60, rng)
    q = q[np.argsort(q[:, 0] + 0.15 * q[:, 0].std() * rng.standard_normal(len(q)))]
    time = 60.0 * np.arange(len(q))
    way = (q[:, 0] - q[:, 0].mean()) / np.abs(q[:, 0] - q[:, 0].mean()).max()
    gone = time / time.max() if by == "time" else 0.7 * way + 0.3 * way**2
    truth = Truth(sigma=3e-5, motion=lambda _: {0: 2e-4 * gone, 2: 1e-4 * gone})
    diagnosis = diagnose(simulate(planned(robot, q, time=time), truth, seed=1)).diagnosis
    assert [one.cause for one in diagnosis.causes if one.status == "named"] == said


def test_a_base_that_creeps_to_rest_drifts() -> None:
    time = np.arange(60) * 40.0
    campaign = measured("ur5", poses=60, loads=(), time=time)
    gone = 1 - np.exp(-time / (CREEP * time[-1]))
    moved = campaign.points + 3e-4 * gone[:, None, None] * np.array([0.6, -0.5, 0.62])
    diagnosis = found(with_points(campaign, moved))
    assert named(diagnosis) == {("drift", ""): "named"}
    (rate,) = (p for p in diagnosis.causes[0].parameters if p.name == "rate")
    assert rate.value == pytest.approx(3e-4 / (CREEP * time[-1]), rel=0.4)
    assert "comes to rest" in diagnosis.causes[0].sentence


def test_a_wheel_that_runs_out_once_and_twice_a_turn_is_one_cause_with_both_numbers():
    wheel = "gear_eccentricity:joint=joint_4"
    once, twice = (
        f"{wheel},variant=1,amplitude=3e-4,phase=0.4",
        f"{wheel},variant=2,amplitude=2.1e-4,phase=1.1",
    )
    result = found(measured("lrmate200id", (once, twice), poses=160))
    (cause,) = result.causes
    assert (cause.cause, cause.status) == ("gear_eccentricity", "named")
    said = {p.name: p for p in cause.parameters}
    for name, true in {"amplitude": 3e-4, "amplitude (2)": 2.1e-4, "phase (2)": 1.1}.items():
        assert abs(said[name].value - true) < 3.5 * said[name].std


def of_joint_1(size, curve):
    """An error of the first joint by its angle q, (N,)."""

    def joints(read):
        out = np.zeros_like(read.q)
        out[:, 0] = size * curve(read.q[:, 0])
        return out

    return joints


def test_what_a_cause_is_off_its_form_is_nothing_unknown():
    """A run-out with five per cent of three cycles a turn, which no run-out of the catalogue has."""
    wheel = of_joint_1(6e-4, lambda q: np.sin(q + 0.3) + 0.2 * np.sin(2 * q) + 0.05 * np.sin(3 * q + 1))
    diagnosis = found(measured(joints=wheel, loads=()))
    (cause,) = diagnosis.causes
    assert (cause.cause, str(cause.where.joint)) == ("gear_eccentricity", "joint_1")
    assert {rival.cause for rival in cause.rivals} <= {"joint_map"}
    assert diagnosis.verdict in ("named", "ambiguous")
    assert not diagnosis.notes
    assert diagnosis.stages[-1].heldout_rms_mm < 0.06  # of noise 0.054; 0.069 without what stands beside


def test_a_broad_map_is_not_taken_for_a_run_out_for_sure():
    bell = of_joint_1(4e-4, lambda q: np.exp(-0.5 * ((q - q.mean() - 0.3) / 1.2) ** 2))
    (cause,) = found(measured(joints=bell, loads=())).causes
    assert "joint_map" in {cause.cause, *(rival.cause for rival in cause.rivals)}


def test_what_kin_win_by_their_companions_counts_a_third():
    """A pure run-out is one for sure; one that takes companions to be one is not."""
    sure, by_companions = (
        found(measured(joints=of_joint_1(6e-4, curve), loads=())).causes[0]
        for curve in (
            lambda q: np.sin(q + 0.3),
            lambda q: np.sin(q + 0.3) + 0.2 * np.sin(2 * q) + 0.08 * np.sin(3 * q + 1) + 0.05 * np.cos(4 * q),
        )
    )
    assert (sure.cause, sure.status) == ("gear_eccentricity", "named")
    assert "gear_eccentricity" in {by_companions.cause, *(rival.cause for rival in by_companions.rivals)}
    assert by_companions.probability < sure.probability
    odds, run_out, joint_map = 9.0, {0: 9.0, 1: 0.0}, {0: 0.0, 1: 9.0}
    least = odds / PRIORS.kin
    for by, expected in ((0.0, odds), (4.0, odds - 4.0), (odds, least), (np.inf, least)):
        assert kin_odds(run_out, by) == pytest.approx(expected)
        assert kin_odds(joint_map, by) == pytest.approx(-least)  # a map's win is none of a pure form


def test_a_run_out_twice_a_turn_brings_its_own_harmonic():
    """It took a map of the joint to hold four cycles a turn, which was named at 1.0 in its place."""
    robot = load_robot("ur10")
    plan = planned(robot, random_poses(robot, 80, np.random.default_rng(3)))
    problem = problem_of(plan)
    about = "joint=shoulder_pan_joint"
    hidden = [
        f"gear_eccentricity:{about},variant=2,amplitude=6e-4,phase=0.9",
        f"gear_eccentricity:{about},variant=4,amplitude=1.3e-4,phase=2",
        f"gear_kinematic_error:{about},order=6,amplitude=1.5e-5,phase=0.3",
    ]
    truth = Truth(effects=tuple(parse_effect(one, problem) for one in hidden), sigma=2e-5)
    outcome = diagnose(simulate(plan, truth, seed=5))
    first = outcome.diagnosis.causes[0]
    assert (first.cause, first.where.joint) == ("gear_eccentricity", "shoulder_pan_joint")
    sizes = {
        effect.cycles: np.hypot(*values)
        for effect, values in zip(outcome.fit.model.effects, outcome.fit.state.values, strict=True)
        if isinstance(effect, GearEccentricity)
    }
    assert sizes[2] == pytest.approx(6e-4, rel=0.03)
    assert sizes[4] == pytest.approx(1.3e-4, rel=0.15)


def kin_odds(logs, by_companions):
    """log odds of a run-out over a map that are believed."""
    effects = GearEccentricity(Where(joint="joint_1"), "1"), JointMap(Where(joint="joint_1"), "smooth")
    S, u = np.diag([100.0, 100.0]), np.array([50.0, 50.0])
    parts = ((slice(0, 1),), (slice(1, 2),))
    components = [Component((e.cause, e.where), (Form((), np.ones(1), (e,)),), -3.0) for e in effects]
    reduced = Reduced(parts, Stored(S), u, 1000.0, 900.0, 300.0)
    weights = {0: Weight(logs[0], 0, 1.0, by_companions), 1: Weight(logs[1], 0, 1.0)}
    believed = StandIns(Forms(reduced, components), components).believed(
        Chosen(reduced, [Member(0, 0, 1.0)]), 0, weights, logs
    )
    return believed[0] - believed[1]


def test_what_explains_by_its_companions_alone_stands_in_for_nothing(plain):
    """Large both, and of opposite signs: by itself the effect explains nothing, and may not have been."""
    S = np.array([[100.0, 99.0, 0.0], [99.0, 100.0, 0.0], [0.0, 0.0, 100.0]])
    parts = ((slice(0, 2),), (slice(2, 3),))
    forms = [Form((Pattern.__new__(Pattern),), np.ones(width), ()) for width in (2, 1)]
    keys = ("hose_torque", Where(joint="joint_1")), ("joint_map", Where(joint="joint_1"))
    components = [Component(key, (form,), -3.0) for key, form in zip(keys, forms, strict=True)]
    weights = {0: Weight(5.0, 0, 3.0), 1: Weight(4.0, 0, 3.0)}

    def of_them(own, companion):
        reduced = Reduced(parts, Stored(S), S @ [own, companion, 0.3], 1000.0, 900.0, 300.0)
        chosen = Chosen(reduced, [Member(1, 0, 3.0)])
        return StandIns(Forms(reduced, components), components).believed(chosen, 0, weights, {0: 5.0, 1: 4.0})

    assert set(of_them(3.0, -3.05)) == {1}
    assert set(of_them(3.0, -1.0)) == {0, 1}
    with varied(itself=0.0):
        assert set(of_them(3.0, -3.05)) == {0, 1}


def test_of_a_large_cause_companions_cost_no_more_than_their_gain_is_believed():
    """A mass, and a bending link that moves all alike and has a companion that shows at eight sigma: 32 log
    odds, of which forms that are not quite true leave six; the companion's price shrinks with it."""
    S = np.diag([1e4, 1.0, 1e4])
    S[0, 2] = S[2, 0] = 1e4
    effects = LinkBending(Where(link="link_1")), LinkMass(Where(link="link_2"), "mass", 1.0, 1.0)
    forms = [Form((), np.ones(width), (e,)) for width, e in zip((2, 1), effects, strict=True)]
    keys = [(e.cause, e.where) for e in effects]
    components = [Component(key, (form,), -3.0) for key, form in zip(keys, forms, strict=True)]
    reduced = Reduced(
        ((slice(0, 2),), (slice(2, 3),)), Stored(S), np.array([17e3, 8.0, 17e3]), 3e4, 900.0, 300.0
    )
    own = Chosen(reduced, [Member(0, 0, 3.0)])
    every = Forms(reduced, components)
    weights = dict(enumerate(every.weigh(own, [0, 1], np.array([0, 0]))))
    logs = {k: weight.log_odds for k, weight in weights.items()}
    believed = StandIns(every, components).believed(own, 0, weights, logs)
    gain = 0.5 * PRIORS.directions * np.log1p(8.0**2 / PRIORS.directions)
    assert 10 < logs[0] - logs[1] < 0.5 * 8.0**2
    assert 0.5 * gain < believed[0] - believed[1] < gain


def test_companions_take_their_share_of_what_is_left():
    """As a fit with them in would, each held by its prior size."""
    wheel = of_joint_1(6e-4, lambda q: np.sin(q) + 0.1 * np.sin(2 * q + 1))
    geometry = prepare(measured(joints=wheel, loads=())).geometry
    one, two = (GearEccentricity(Where(joint="joint_1"), cycles) for cycles in "12")
    fitted = refit(geometry, [one])
    alone = remainder(fitted, known=True)
    wide, held, never = (beyond_forms(fitted, True, [(two, np.full(2, s))]) for s in (1e-2, 1e-6, 1e-12))
    both = remainder(refit(fitted, [one, two]), known=True)
    assert both.chi2 < 0.8 * alone.chi2
    assert wide.chi2 == pytest.approx(both.chi2, rel=0.01)
    assert wide.dof == pytest.approx(both.dof, abs=0.1)
    assert both.chi2 < held.chi2 < never.chi2 == pytest.approx(alone.chi2)
    assert alone.scatter
    assert not wide.scatter


@pytest.mark.parametrize(
    ("one", "other", "times"),
    [
        ("joint_compliance:joint=joint_2", "link_bending:link=link_2", PRIORS.yields),
        ("joint_compliance:joint=joint_2", "joint_compliance:joint=joint_3", 1),
        ("joint_compliance:joint=joint_2", "lost_motion:joint=joint_2", 1),
        ("joint_compliance:joint=joint_2", "lost_motion:joint=joint_3", PRIORS.yields),
        ("joint_compliance:joint=joint_2", "link_mass:link=link_2", 1),
        ("gear_eccentricity:joint=joint_2", "joint_map:joint=joint_2", PRIORS.kin),
        ("gear_eccentricity:joint=joint_2", "joint_map:joint=joint_3", 1),
    ],
)
def test_odds_are_too_large_between_causes_of_one_kind_in_other_forms(one, other, times):
    problem = problem_of(measured())
    effects = [parse_effect(text, problem)[0] for text in (one, other)]
    assert times_too_sure(*effects) == times_too_sure(*reversed(effects)) == times


def test_a_form_weighs_what_its_equations_say():
    rng = np.random.default_rng(3)
    G, data = rng.normal(size=(3, 40, 4)), 3 * rng.normal(size=40)
    S, u = np.einsum("fnp,fnq->fpq", G, G), np.einsum("fnp,n->fp", G, data)
    left = Reduced((), Stored(np.zeros((0, 0))), np.zeros(0), float(data @ data), 40.0, 300.0)
    table = table_of(left, S, u, np.zeros(3), np.full(3, 0.5), np.zeros(3, int))
    for f, k in np.ndindex(table.shape):
        normal = S[f] + np.eye(4) / SCALES[k] ** 2
        gained = likelihood(left, 0.0, u[f] @ np.linalg.solve(normal, u[f]))
        freedom = 0.5 * np.linalg.slogdet(np.eye(4) + SCALES[k] ** 2 * S[f])[1]
        assert table[f, k] == pytest.approx(gained - freedom + WEIGHTS[k], abs=1e-9)


@pytest.mark.usefixtures("plain")
def test_a_set_in_another_order_is_not_weighed_again(monkeypatch):
    data, one, two = twins(400.0, 0.3)
    keys = [("backlash", Where(joint=f"joint_{k}")) for k in range(3)]
    competition = competition_of(one, two, one + two, data=data, keys=keys)
    members = [Member(0, 0, 1.0), Member(1, 0, 3.0)]
    weights, most = (
        lambda some: competition.forms.weigh(Chosen(competition.reduced, some), [2]),
        lambda some, i: competition.forms.most(Chosen(competition.reduced, some), [2], [i]),
    )
    first, limit = weights(members), most(members, 0)
    assert most(members, 1) != limit
    assert weights(members[:1]) != first
    monkeypatch.setattr("workbench.diagnosis.weighing.forms.table_of", None)
    monkeypatch.setattr("workbench.diagnosis.weighing.forms.most_of", None)
    assert weights(members[::-1]) == first
    assert most(members[::-1], 1) == limit
