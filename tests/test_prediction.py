"""The error at the tool: bounds that hold on a robot simulated by Drake, and what is said of them."""

import base64
import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import chdtr

from workbench import (
    Covariance,
    InputError,
    Model,
    Truth,
    fit,
    load_robot,
    parse_effect,
    planned,
    predict,
    problem_of,
    random_geometry,
    random_poses,
    simulate,
    write_fit,
)
from workbench.campaign.flange_load import beyond_load
from workbench.cli.main import main
from workbench.effects.unnamed import unnamed
from workbench.identification.fit import refit
from workbench.identification.prediction import of_fit, uncertainty
from workbench.identification.prediction.bound import length_bound
from workbench.identification.prediction.left_out import LeftOut
from workbench.identification.prediction.tempering import Tempering, temper
from workbench.report.expectation import Expected
from workbench.robot.rotations import body_jacobian

SIGMA = 2e-5
WHEEL = "gear_eccentricity:joint=joint_1,variant=1,amplitude=3e-4,phase=0.4"
PLAY = "backlash:joint=joint_1,half_width=2e-4"
LIMITS = np.array([(-1.5, 1.5), (0.05, 0.5), (0.05, 0.5)])


def measured(robot, truth, count, seed):
    """Poses in half of the joints' ranges, seen from the base."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(*LIMITS.T, (count, 3))
    plan = planned(robot, q, direction=rng.choice([-1.0, 1.0], q.shape))
    return simulate(plan, truth, seed=seed, instrument=(np.eye(3)[None], np.zeros((1, 3))))


def fitted(campaign, *effects, sigma=SIGMA):
    problem = problem_of(campaign)
    model = Model(problem, tuple(parse_effect(text, problem)[0] for text in effects))
    noise = Covariance(np.full(problem.seen.shape, sigma), np.zeros(problem.arm.n), np.ones(len(problem.q)))
    return fit(model, noise=noise)


@pytest.fixture(scope="module")
def truth():
    robot = load_robot("cylindrical")
    plan = problem_of(
        planned(robot, random_poses(robot, 5, np.random.default_rng(0)), direction=np.ones((5, 3)))
    )
    effects = tuple(parse_effect(text, plan) for text in (WHEEL, PLAY))
    geometry = random_geometry(plan.arm, np.random.default_rng(3))
    return Truth(geometry=geometry, effects=effects, sigma=SIGMA, repeatability=np.array([1e-5, 5e-6, 5e-6]))


@pytest.fixture(scope="module")
def model(truth, tmp_path_factory):
    """The model.toml of a right fit."""
    path = tmp_path_factory.mktemp("right") / "model.toml"
    write_fit(path, fitted(measured(load_robot("cylindrical"), truth, 60, 1), WHEEL, PLAY))
    return path


@pytest.fixture(scope="module")
def lacking(truth, tmp_path_factory):
    """The model.toml of a fit that lacks a cause."""
    path = tmp_path_factory.mktemp("lacking") / "model.toml"
    write_fit(path, fitted(measured(load_robot("cylindrical"), truth, 60, 1), PLAY))
    return path


def missed(model, truth):
    """Other poses of the true robot without instrument noise: (N, T) distance to what is predicted, after the
    best rigid motion of the whole; and the prediction."""
    judge = measured(load_robot("cylindrical"), replace(truth, sigma=0.0), 150, 2)
    errors = predict(model, judge)
    every = np.ones(len(errors.outside), dtype=bool)
    return without_motion(errors.places + errors.error, judge.points, every), errors


def without_motion(said, true, here):
    """(N, T) distances after the best rigid motion of the poses `here` (N,)."""
    middle, true_middle = said[here].reshape(-1, 3).mean(axis=0), true[here].reshape(-1, 3).mean(axis=0)
    said, true = said - middle, true - true_middle
    turn, _ = Rotation.align_vectors(true[here].reshape(-1, 3), said[here].reshape(-1, 3))
    return np.linalg.norm(true - turn.apply(said.reshape(-1, 3)).reshape(true.shape), axis=2)


@pytest.mark.parametrize("which", ["model", "lacking"])
def test_bounds_hold_on_other_poses(which, truth, request):
    """Of a right fit, and of one that lacks a cause: there the bound is wider."""
    left, errors = missed(request.getfixturevalue(which), truth)
    inside = errors.measured
    assert inside.mean() > 0.8
    assert 0.9 <= (left <= errors.corrected)[inside].mean() <= 0.995
    assert np.median(errors.corrected) < 3 * np.sqrt(np.mean(left**2))
    assert (errors.length > left).mean() > 0.9  # correction is worth it


def test_what_is_left_unknown_widens_the_bound(model, lacking, truth):
    assert np.median(missed(lacking, truth)[1].corrected) > 2 * np.median(missed(model, truth)[1].corrected)


def test_outside_of_what_was_measured_it_grows_and_says_so(lacking):
    q = np.array([[0.0, 0.3, 0.3], [1.4, 0.3, 0.3], [2.0, 0.3, 0.3], [2.9, 0.3, 0.3]])
    errors = predict(lacking, q)
    assert errors.outside == ("", "", "joint_1", "joint_1")
    near, _, far, farther = errors.worst
    assert 1.1 * near < far < farther


def test_each_reason_to_be_outside_is_counted_by_itself(lacking):
    """Nobody reads 57 combinations; the joint that most poses are beyond is what to measure next."""
    errors = predict(lacking, np.tile([0.0, 0.3, 0.3], (4, 1)))
    beyond = replace(errors, outside=("joint_2", "joint_1; joint_2", "", "joint_2; temperature"))
    first, *counts = Expected(load_robot("cylindrical"), beyond).outside
    assert first.startswith("3 of 4 poses lie outside of what was measured")
    assert "one pose by several" in first
    assert counts == ["joint_2: 3 poses", "joint_1: 1 pose", "temperature: 1 pose"]
    alone = replace(errors, outside=("", "", "", "joint_2"))
    assert "several" not in Expected(load_robot("cylindrical"), alone).outside[0]


def test_a_load_that_was_not_measured_is_outside(model):
    """Measured with nothing on the flange: what hangs there may bend what nobody saw bend."""
    q, loads = (
        np.tile([0.0, 0.3, 0.3], (3, 1)),
        {"anvil": (40.0, (0.0, 0.0, 0.1)), "glove": (0.05, (0.0, 0.0, 0.1))},
    )
    plan = planned(load_robot("cylindrical"), q, payloads=loads, payload=["", "anvil", "glove"])
    assert predict(model, plan).outside == ("", "load on the flange", "")
    pushed = plan.with_poses(wrench=np.array([[0.0] * 6, [0.0] * 6, [0.0, 0.0, 300.0, 0.0, 0.0, 0.0]]))
    assert predict(model, pushed).outside[2] == "load on the flange"


@pytest.mark.parametrize(("moment", "outside"), [(0.35, False), (40.0, True)])
def test_a_load_that_hangs_straight_down_is_the_same_under_a_hand_a_little_askew(moment, outside):
    """Beneath a level hand a load has no moment, to rounding; a calibrated hand stands 0.1 degrees askew."""
    load = SimpleNamespace(force=np.array([[[0.0, 0.0, -392.0]]]), moment=np.array([[[moment, 0.0, 0.0]]]))
    problem: Any = SimpleNamespace(nominal_load=load)
    assert beyond_load(problem, (392.0, 392.0, 5e-4)).tolist() == [outside]


def test_a_corner_that_nobody_measured_is_outside_though_no_joint_is(truth, tmp_path):
    """Of a model that lacks a cause, measured everywhere but where joints 1 and 2 are both large."""
    low, high = LIMITS.T
    share = np.random.default_rng(8).uniform(size=(120, 3))
    corner = (share[:, :2] > 0.4).all(axis=1)
    plan = planned(load_robot("cylindrical"), low + share * (high - low), direction=np.ones(share.shape))
    place = (np.eye(3)[None], np.zeros((1, 3)))
    measured_plan = plan.some(np.flatnonzero(~corner))
    path = tmp_path / "model.toml"
    write_fit(path, fitted(simulate(measured_plan, truth, seed=1, instrument=place), PLAY))
    errors = predict(path, plan)
    true = simulate(plan, replace(truth, sigma=0.0), seed=2, instrument=place).points
    left = without_motion(errors.places + errors.error, true, ~corner)
    said = np.array(errors.outside)
    assert set(said[~corner]) == {""}
    assert set(said[corner]) == {"", "combination of joints"}
    assert np.median(errors.worst[corner]) > 1.15 * np.median(errors.worst[~corner])
    assert errors.worst[said != ""].min() > np.median(errors.worst[corner])
    assert (left <= errors.corrected)[corner].mean() > 0.85
    assert errors.corrected[corner].mean() < 2 * left[corner].mean()


def test_a_side_that_nobody_says_is_in_the_bound(model):
    q = np.random.default_rng(5).uniform(*LIMITS.T, (30, 3))
    robot = load_robot(model)
    said = predict(robot, planned(robot, q, direction=np.ones((30, 3))))
    unsaid = predict(robot, planned(robot, q))
    assert (unsaid.worst > said.worst).all()
    assert any("dir columns" in note for note in unsaid.notes)
    assert not said.notes


def test_bound_of_a_length_against_draws():
    rng = np.random.default_rng(0)
    for scale, mean in (((1, 1, 1), 0.0), ((1, 0.1, 0.1), 0.0), ((1, 2, 0.3), 0.0), ((1, 0.5, 0.2), 4.0)):
        offset = mean * np.ones(3)
        draws = np.linalg.norm(rng.normal(size=(200_000, 3)) * scale + offset, axis=1)
        bound = float(length_bound(np.diag(np.square(scale).astype(float)), offset))
        assert bound == pytest.approx(np.quantile(draws, 0.95), rel=0.03)


def test_command(model, tmp_path, capsys):
    """A file's poses by their names; the share inside a tolerance is that of the table."""
    rows = ["p1,0,200,200", "p2,30,300,100", "p3,170,300,100"]
    (tmp_path / "poses.csv").write_text("\n".join(["pose_id,q1_deg,q2_mm,q3_mm", *rows, ""]))
    out = tmp_path / "out"
    call = ["predict", str(model), "--poses", str(tmp_path / "poses.csv"), "--tolerance", "0.4", "--json"]
    assert main([*call, "--out", str(out)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert [pose["pose_id"] for pose in said["poses"]] == ["p1", "p2", "p3"]
    assert said["poses"][2]["outside"] == "joint_1"
    inside = [pose["corrected_bound_mm"] <= 0.4 for pose in said["poses"]]
    assert said["tolerance"]["corrected_share"] == pytest.approx(np.mean(inside))
    assert {path.name for path in out.iterdir()} == {"index.html", "scene.html", "errors.csv", "predict.json"}
    table = (out / "errors.csv").read_text().splitlines()
    assert len(table) == 1 + 3 * 3
    assert table[1].startswith("p1,T1,")


def test_a_campaigns_poses_with_their_columns_and_loads(model, tmp_path, capsys):
    (tmp_path / "read.txt").write_text("A;B;C;load\n0;200;200;\n30;300;100;heavy\n-20;300;100;\n")
    (tmp_path / "points.csv").write_text("x_mm,y_mm,z_mm\n" + "1,2,3\n" * 3)
    columns = 'columns = { q1_deg = "A", q2_mm = "B", q3_mm = "-C", payload = "load" }'
    path = tmp_path / "campaign.toml"
    path.write_text(
        f'schema = 1\nrobot = "cylindrical"\n[poses]\nfile = "read.txt"\nseparator = ";"\n{columns}\n'
        '[points]\nfile = "points.csv"\n[payloads.heavy]\nmass_kg = 20.0\n'
    )
    call = ["predict", str(model), "--out", str(tmp_path / "out"), "--json", "--poses"]
    assert main([*call, str(path)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"campaign.toml", "read.txt"} <= {Path(name).name for name in said["inputs"]}
    q = np.array([[0.0, 0.2, -0.2], [np.pi / 6, 0.3, -0.1], [-np.pi / 9, 0.3, -0.1]])
    there = [pose["corrected_bound_mm"] for pose in said["poses"]]
    assert there == pytest.approx(1e3 * predict(model, q).worst, rel=1e-3)  # no cause of it feels the load
    assert main([*call, str(path), "--payload", "heavy"]) == 2
    assert "the campaign says what the arm carries" in capsys.readouterr().err
    path.write_text(path.read_text().replace("cylindrical", "rx170"))
    assert main([*call, str(path)]) == 2
    assert main([*call, str(tmp_path / "read.txt")]) == 2
    assert "or name the campaign.toml that says its columns" in capsys.readouterr().err


@pytest.mark.parametrize("option", [("--tool", "-12,0,150"), ("--start", "0,300,300")])
def test_what_says_of_tool_poses_is_refused_where_there_are_none(model, tmp_path, capsys, option):
    assert main(["predict", str(model), "--volume", "5", "--out", str(tmp_path / "out"), *option]) == 2
    assert f"{option[0]}: goes with a path of tool poses" in capsys.readouterr().err


def test_volume(model, tmp_path, capsys):
    assert main(["predict", str(model), "--volume", "40", "--out", str(tmp_path), "--tolerance", "10"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("14 of 40 poses lie within what was measured")
    assert "mean of 14 poses" in said
    assert "Inside 10 mm with 95 %: at 100 % of these poses" in said
    told = json.loads((tmp_path / "predict.json").read_text())
    inside = [pose["corrected_bound_mm"] for pose in told["poses"] if not pose["outside"]]
    assert told["inside"]["n_poses"] == len(inside) == 14
    assert told["inside"]["corrected"]["bound_max_mm"] == pytest.approx(max(inside))


def test_where_nothing_was_measured_no_figure_is_said(model, tmp_path, capsys):
    """Nor is a pose that the robot cannot take passed over in silence."""
    rows = ["p1,170,300,200", "p2,400,300,100", "p3,-900,300,100"]
    (tmp_path / "poses.csv").write_text("\n".join(["pose_id,q1_deg,q2_mm,q3_mm", *rows, ""]))
    out = tmp_path / "out"
    assert main(["predict", str(model), "--poses", str(tmp_path / "poses.csv"), "--out", str(out)]) == 0
    said, warned = capsys.readouterr()
    assert said.startswith("None of 3 poses lies within what was measured: nothing can be said of them.")
    assert " mm" not in said
    assert "beyond the limits of joint_1: poses p2, p3" in warned
    told = json.loads((out / "predict.json").read_text())
    assert told["inside"] is None
    assert [pose["beyond_limits"] for pose in told["poses"]] == ["", "joint_1", "joint_1"]
    table = (out / "errors.csv").read_text().splitlines()
    assert table[0].endswith(",outside,beyond_limits")
    assert "What an uncorrected program misses" not in (out / "index.html").read_text()


def test_the_scene_shows_errors_and_measured_poses(model, tmp_path):
    """Its places, classes of colour and measured poses are those of the table and the model."""
    assert main(["predict", str(model), "--volume", "50", "--out", str(tmp_path), "--json"]) == 0
    scene = (tmp_path / "scene.html").read_text()
    data = json.loads(re.search(r"^  const data = (.*);$", scene, re.M).group(1))
    told = json.loads((tmp_path / "predict.json").read_text())["poses"]
    places, measured = (
        np.frombuffer(base64.b64decode(data[key]), "<f4").reshape(-1, 3) for key in ("places", "measured")
    )
    assert data["ids"] == [pose["pose_id"] for pose in told]
    assert data["outside"] == [pose["outside"] for pose in told]
    rows = [line.split(",") for line in (tmp_path / "errors.csv").read_text().splitlines()[1:]]
    table = np.array([[float(v) for v in row[2:5]] for row in rows]).reshape(50, -1, 3).mean(axis=1)
    np.testing.assert_allclose(1e3 * places, table, atol=1e-3)
    np.testing.assert_allclose(measured, load_robot(model).uncertainty.measured, atol=1e-5)
    left = data["stages"][1]
    bound = [pose["corrected_bound_mm"] for pose in told]
    assert left["mm"] == pytest.approx(bound, abs=1e-4)
    order = np.argsort(bound)
    assert (np.diff(np.array(left["level"])[order]) >= 0).all()
    assert set(left["level"]) == set(range(5))
    assert len(left["labels"]) == len(data["colours"]) == 5


def test_volume_as_it_was_measured(model, tmp_path, capsys):
    call = ["predict", str(model), "--volume", "60", "--out", str(tmp_path)]
    assert main([*call, "--measured"]) == 0
    assert "All poses lie inside of what was measured" in capsys.readouterr().out
    page = (tmp_path / "index.html").read_text()
    assert "What is left after correction (95 % bound)" in page
    assert "measured poses" in page
    assert "mathdefault" not in page
    assert main([*call[:2], "--poses", "poses.csv", "--measured"]) == 2
    assert "goes with --volume" in capsys.readouterr().err


def test_the_model_keeps_where_it_was_measured(model, truth):
    """Where the map of `predict` has the same poses: they lay 0.3 m off on an MA1400's, whose one target and
    one attitude leave open how base and tool share it."""
    kept = load_robot(model).uncertainty.measured
    campaign = measured(load_robot("cylindrical"), replace(truth, sigma=0.0), 60, 1)
    assert kept == pytest.approx(campaign.points.mean(axis=1), abs=1e-2)  # mm that geometry and base share
    errors = predict(model, campaign)
    assert kept == pytest.approx((errors.places + errors.error).mean(axis=1), abs=2e-4)


def test_what_passes_and_has_no_name_is_not_in_the_model(truth):
    """A function of bearing takes what a cause that is lacking makes: the model is fitted without it."""
    campaign = measured(load_robot("cylindrical"), truth, 60, 1)
    plain = fitted(campaign, PLAY)
    bearing = next(e for e in unnamed(plain.model.problem) if not e.lasting and "bearing" in e.variable)
    with_it = refit(plain, [*plain.model.effects, bearing.sized(10.0)])
    assert np.sum(with_it.r**2) < 0.7 * np.sum(plain.r**2)
    assert np.abs(with_it.state.geometry - plain.state.geometry).max() > 1e-5
    left = with_it.lasting
    assert left.model.effects == plain.model.effects
    off = (left.state.geometry - plain.state.geometry).ravel()[plain.columns.geometry]
    std = np.sqrt(np.diag(plain.covariance))[plain.columns.geometry_slice]
    assert (np.abs(off) < 0.02 * std).all()
    assert plain.lasting is plain


def test_parts_of_a_campaign_that_differ_widen_the_bound(truth):
    """A base that moved by 0.2 mm for a fifth of the poses: random groups of poses hardly see it."""
    campaign = measured(load_robot("cylindrical"), truth, 60, 1)
    points = campaign.points.copy()
    points[48:] += [2e-4, 0.0, 0.0]
    same, moved = (
        uncertainty(fitted(one, WHEEL, PLAY)) for one in (campaign, replace(campaign, points=points))
    )
    assert moved.tempering * moved.rest > 1.5 * same.tempering * max(same.rest, SIGMA)


class Drawn:
    """Stands for a `Leaver` of which nothing but poses in the midst of others is looked at: 100 with three
    points each, off by the fitted numbers, by what the model lacks, and by noise, `true` times as stated."""

    def __init__(self, seed, lacks, fitted=8e-6, noise=4e-5, true=1.0):
        rng = np.random.default_rng(seed)
        draw = rng.normal(size=(2, 300, 3))
        self.fitted = np.tile(fitted**2 * np.eye(3), (300, 1, 1))
        self.lacks, self.error = lacks, np.hypot(fitted, lacks) * draw[0] + true * noise * draw[1]
        seen = np.tile(noise**2 * np.eye(3), (300, 1, 1))
        self.pose = np.repeat(np.arange(100), 3)
        self.out = LeftOut(self.error, self.fitted, 0 * seen, seen, np.zeros(300), self.pose)

    def by_position(self, variance):
        return self.out

    by_part = by_position

    def by_region(self, variance):
        return [self.out]

    def by_end(self, variance):
        return []

    def held(self, known=True):
        """Share of errors without noise that the bound without noise holds."""
        bound = float(temper(self, known)[0].bound(self.fitted, 0.0, np.zeros(300))[0])
        return chdtr(3, (bound / np.hypot(np.sqrt(self.fitted[0, 0, 0]), self.lacks)) ** 2)


@pytest.mark.parametrize("lacks", [0.0, 8e-6, 1.6e-5, 6e-5])
def test_bounds_without_noise_hold_where_noise_hides_what_the_model_lacks(lacks):
    """Noise is five times what the fitted numbers err by. Cut at zero without a mean, what is lacking was
    found in so few campaigns that bounds held at 79 % in the mean, and at 50 in one of twenty."""
    held = np.array([Drawn(seed, lacks).held() for seed in range(100)])
    assert held.mean() > 0.92
    assert np.quantile(held, 0.05) > 0.78


def test_what_the_model_lacks_is_as_it_is_where_it_stands_out_of_the_noise():
    tempering, _ = temper(Drawn(0, 1.5e-4), instrument_known=True)
    assert tempering.rest == pytest.approx(1.5e-4, rel=0.06)


def test_points_of_a_pose_that_err_together_say_less_of_what_is_left():
    """Three of them are then one: a bound holds with as much more."""
    drawn = Drawn(3, 0.0)
    apart = temper(drawn, instrument_known=True)[0].rest
    out = replace(drawn.out, error=np.repeat(drawn.error[::3], 3, axis=0))
    drawn.out = replace(out, error=out.error * np.sqrt(np.mean(drawn.error**2) / np.mean(out.error**2)))
    assert temper(drawn, instrument_known=True)[0].rest > 1.2 * apart


def test_noise_that_is_less_than_stated_does_not_narrow_the_bound_of_what_has_none():
    """By 7 %: the bound with noise could be narrower, but nothing says so of the robot's part. Where nobody
    knows the noise, it is the robot's part, and the factor is kept."""
    drawn = Drawn(1, 0.0, true=0.93)
    ratio = Tempering(0.0, 1.0, 0.0).stretch(drawn.out, instrument_known=True)
    assert ratio < 0.97
    assert temper(drawn, instrument_known=True)[0].factor > 0.99
    uniform = np.random.default_rng(2).uniform(-7e-5, 7e-5, (300, 3))  # no tails
    drawn.out = replace(drawn.out, error=uniform)
    assert temper(drawn, instrument_known=False)[0].factor < 0.97


def test_a_model_that_does_not_say_how_sure_it_is_is_refused(tmp_path, capsys):
    assert main(["predict", "cylindrical", "--volume", "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert "has no [prediction]" in said
    assert "at least 20 points" in said  # fewer in a diagnosis give none
    assert not list(tmp_path.iterdir())


def test_a_damaged_factor_is_told(model, tmp_path):
    text = model.read_text().replace("factor = [\n", 'factor = [\n    "1.0 x",\n')
    path = model.parent / "damaged.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"prediction\.factor"):
        load_robot(path)


def test_an_unknown_payload_is_told(model):
    with pytest.raises(InputError, match="payload 'anvil': is not in the model"):
        predict(model, np.array([[0.0, 0.3, 0.3]]), "anvil")


def test_a_fit_that_stands_where_it_was_measured_alone_is_kept(tmp_path):
    """Folded, a soft shoulder bears the arm, stretched it does not: what is known is written all the same."""
    robot, rng = load_robot("ur5"), np.random.default_rng(2)
    q = np.array([0.0, -1.2, 2.6, 0.0, 0.0, 0.0]) + rng.uniform(-1, 1, (40, 6)) * [3, 0.2, 0.1, 2, 2, 2]
    problem = problem_of(planned(robot, q))
    effect, values = parse_effect("joint_compliance:joint=shoulder_lift_joint,compliance=0.02", problem)
    model = Model(problem, (effect,))
    points = model.predict(replace(model.in_base(), values=(values,)))
    points = points + rng.normal(0, SIGMA, points.shape)
    campaign = replace(problem.campaign, points=points, shots=np.ones(points.shape[:2], dtype=np.int64))
    soft = replace(problem, campaign=campaign)
    noise = Covariance(np.full(soft.seen.shape, SIGMA), np.zeros(6), np.ones(len(q)))
    found = fit(Model(soft, (effect,)), replace(model.in_base(), values=(values,)), noise)
    write_fit(tmp_path / "model.toml", found)
    errors = predict(tmp_path / "model.toml", q)
    assert errors.measured.all()
    with pytest.raises(InputError, match=r"no rest.*shoulder_lift_joint yields most"):
        predict(tmp_path / "model.toml", random_poses(robot, 100, rng, share=1.0))


def test_a_turn_about_sockets_is_not_in_the_bounds_and_said(truth, tmp_path, monkeypatch):
    """Points of a ball in two sockets say nothing of how the base stands turned about the line through
    these; bounds that had it were as wide as the arm is long."""
    plan = measured(load_robot("cylindrical"), truth, 60, 1)
    result = fitted(plan)
    told = uncertainty(result)
    assert told is not None
    assert told.turn_measured
    assert told.F.shape[1] > 1
    path = tmp_path / "model.toml"
    monkeypatch.setattr(of_fit, "_idle_turns", lambda points, error: np.eye(6)[:, 5:])
    write_fit(path, fitted(plan))
    turned = predict(path, LIMITS[None, :, 1])
    assert np.abs(load_robot(path).uncertainty.F[5]).max() < 1e-9  # type: ignore[union-attr]
    assert any("turned" in note for note in turned.notes)


@pytest.mark.parametrize(("sockets", "turns"), [(1, 3), (2, 1), (3, 0)])
@pytest.mark.parametrize("error", [2e-6, 1e-3])
def test_turns_that_sockets_do_not_show(sockets, turns, error):
    """However far the model is off: where its points lie in a socket is its error, and shows no turn."""
    where = np.array([(0.4, 0.1, 0.5), (0.45, 0.1, 0.5), (0.4, 0.15, 0.5)])[np.arange(60) % sockets]
    seen = where + np.random.default_rng(0).normal(scale=error, size=where.shape)
    idle = of_fit._idle_turns(seen, of_fit.ITS_ERROR * 3**0.5 * error)
    assert idle.shape == (6, turns)
    assert np.abs(body_jacobian(where) @ idle).max(initial=0.0) < 5 * error
    assert np.linalg.norm(idle[3:], axis=0) == pytest.approx(1.0)
