"""How a tool that was measured as a pose is turned: bounds that hold, and where they are said."""

import json

import numpy as np
import pytest
from diagnosis_cases import measured as points_of
from scipy.spatial.transform import Rotation
from test_noise_of_poses import poses_of

from workbench import fit, load_robot, predict, problem_of, write_fit
from workbench.cli.main import main
from workbench.diagnosis.noise.noise_choice import from_residual, provisional
from workbench.identification.model import Model
from workbench.identification.prediction.tool import turns_of

TURN = 3e-4  # rad about each axis
NAMES = ["turn_error_mrad", "turn_nominal_bound_mrad", "turn_corrected_bound_mrad"]


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """A model.toml of half of a campaign whose noise nobody knows, and the other half."""
    whole = poses_of(5e-5, TURN, count=300)
    problem = problem_of(whole.some(np.arange(120)))
    result = fit(Model(problem, ()), noise=provisional(problem))
    result = fit(result.model, result.state, from_residual(result)[0])
    path = tmp_path_factory.mktemp("pose") / "model.toml"
    write_fit(path, result)
    return path, whole.some(np.arange(120, 300))


def test_bounds_of_turns_hold_on_other_poses(measured):
    """The noise, which nobody knows, is in them: turns are as far off as it is seen."""
    path, judge = measured
    errors = predict(path, judge)
    said = errors.places + errors.error
    middle = said.mean(axis=1, keepdims=True), judge.points.mean(axis=1, keepdims=True)
    arms = said - middle[0], judge.points - middle[1]
    base, _ = Rotation.align_vectors(arms[1].reshape(-1, 3), arms[0].reshape(-1, 3))
    off = np.array(
        [Rotation.align_vectors(b, base.apply(a))[0].magnitude() for a, b in zip(*arms, strict=True)]
    )
    inside = errors.measured
    assert inside.mean() > 0.8
    assert 0.88 <= (off <= errors.turns.corrected)[inside].mean() <= 0.99
    assert np.median(errors.turns.corrected) == pytest.approx(2.8 * TURN, rel=0.15)  # 95 % of three axes
    assert np.all(errors.turns.nominal >= 0.99 * errors.turns.corrected)


def test_a_turn_of_all_points_is_told():
    rng = np.random.default_rng(0)
    points, turn = rng.normal(size=(5, 4, 3)), rng.normal(size=(5, 3))
    moved = np.cross(turn[:, None], points) + rng.normal(size=(5, 1, 3))
    seen = np.ones((5, 4), bool)
    seen[0, 2], moved[0, 2] = False, 9.0
    assert np.allclose((turns_of(points, seen) @ moved.reshape(5, 12, 1))[..., 0], turn)


def test_table_and_text_have_them(measured, tmp_path, capsys):
    path, _ = measured
    (tmp_path / "poses.csv").write_text("q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n10,-80,60,-70,-90,20\n")
    call = ["predict", str(path), "--poses", str(tmp_path / "poses.csv"), "--out", str(tmp_path / "out")]
    assert main([*call, "--json"]) == 0
    (pose,) = json.loads(capsys.readouterr().out)["poses"]
    head, *rows = (line.split(",") for line in (tmp_path / "out/errors.csv").read_text().splitlines())
    assert head[-3:] == NAMES
    for row in rows:  # the tool is one
        assert [float(value) for value in row[-3:]] == pytest.approx([pose[name] for name in NAMES], abs=1e-4)
    assert main(call) == 0
    bound = pose["turn_corrected_bound_mrad"]
    assert f"keeps its orientation within {bound:.2g} mrad" in capsys.readouterr().out


def test_a_model_of_single_points_has_none(tmp_path):
    problem = problem_of(points_of("ur5", poses=40, loads=()))
    write_fit(tmp_path / "model.toml", fit(Model(problem, ())))
    robot = load_robot(tmp_path / "model.toml")
    assert robot.uncertainty.turning is None
    assert predict(robot, problem.q[:2]).turns is None
