"""The cylindrical study: its deflections against Drake, its accounts, its claims on three seeds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from study_checks import captions_stand_alone, poses_are_counted

from workbench import Truth, load_robot, path_shapes, planned, simulate
from workbench.cli.main import main
from workbench.report.study import Study
from workbench.studies.cylindrical import study as cylindrical
from workbench.studies.cylindrical.accounts import accounts, moved_out
from workbench.studies.cylindrical.deflections import CIRCLE_RADIUS, HAND_TARGETS, LENGTH, STROKE, pool
from workbench.studies.cylindrical.headline import OF_DRAWS, draws
from workbench.studies.cylindrical.printed import FORCE, TABLE_1
from workbench.studies.cylindrical.study import CENTRE, IN_BASE
from workbench.studies.running import run_published
from workbench.studies.study_run import StudyRun


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cylindrical")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    """With a tenth of the circle's samples."""
    coarse = path_shapes.circle(CIRCLE_RADIUS, path_shapes.Run(path_shapes.work_frame(CENTRE), period=0.4))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cylindrical, "CIRCLE", coarse)
        (study,) = run_published(("cylindrical",), StudyRun(folder, quick=True, workers=1))
    return study


def test_pool_moves_as_drake_does() -> None:
    """Linear rows beside Drake's nonlinear equilibrium, also of a link 2 longer than the program's."""
    arm, rng = pool(), np.random.default_rng(1)
    which = arm.random(rng, 8, LENGTH)
    rows = arm.rows(which, FORCE)
    longer = arm.rows(moved_out(which, 0.1), FORCE)
    for made, shift in ((rows, 0.0), (longer, 0.1)):
        geometry = np.zeros((5, 6))
        geometry[3, 2] = shift  # joint 3 slides along its z
        q = np.column_stack([arm.angle[which], np.full(8, 0.2), arm.reach[which] - LENGTH])
        wrench = np.zeros((16, 6))
        wrench[8:, :3] = FORCE
        plan = planned(load_robot("cylindrical"), np.tile(q, (2, 1)), targets=HAND_TARGETS, wrench=wrench)
        p = simulate(plan, Truth(geometry=geometry), instrument=IN_BASE).points[:, 0]
        size = np.linalg.norm(p[8:] - p[:8], axis=1)
        missed = np.linalg.norm(made.sum(axis=2) - (p[8:] - p[:8]), axis=1)
        assert (
            missed < (0.005 if shift == 0 else 0.1) * size
        ).all()  # the pool's nearest pose is some cm away


def test_a_random_pose_lies_within_the_strokes() -> None:
    arm = pool()
    reach = arm.reach[arm.random(np.random.default_rng(0), 200, 0.7)]
    assert 0.7 <= reach.min() < reach.max() <= 0.7 + STROKE


def test_accounts_without_a_fault_give_table_1_back_without_noise() -> None:
    for account in accounts():
        values = {name: prior.at(0.7) for name, prior in account.priors.items()}
        made = np.asarray(account.predict(values, np.random.default_rng(2))["same"]) / TABLE_1
        sound = account.name not in ("fault", "damped")
        assert (np.abs(made - 1) < 1e-9).all() == sound


def test_odds_go_to_the_stated_noise_under_a_lighter_load(found: Study) -> None:
    n = found.numbers
    assert sum(n[f"p_{a.name}"] for a in accounts()) == pytest.approx(1)
    assert n["p_stated"] < 1e-6
    assert n["p_fault"] < 1e-3  # it would show without noise
    assert n["p_light"] + n["p_random"] > 0.9
    assert n["light_load_low"] < 1 / n["lighter_mid"] < n["light_load_high"]


def test_stiffness_is_found_within_what_the_noise_allows(found: Study) -> None:
    for name in ("full", "light"):
        for j in (1, 2, 3):
            off, std = found.numbers[f"{name}_{j}_off"], found.numbers[f"{name}_{j}_half"] / 1.96
            assert abs(off) < 4 * std / (1 - std)
            assert std < (8e-3 if name == "full" else 0.4)
    assert found.numbers["without"] < 1e-3


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_claims_hold_for_other_seeds(found: Study, tmp_path: Path, seed: int) -> None:
    """What the page says of draws it says for other draws too."""
    others = draws(StudyRun(tmp_path, seed=seed, quick=True, workers=1))
    for claim in OF_DRAWS:
        held = np.mean([claim.holds({**found.numbers, **one}) for one in others.each()])
        assert found.claims[claim.name].stands == (held >= 0.9 and found.claims[claim.name].here), claim.name


def test_compensation_brings_a_millimetre_down(found: Study) -> None:
    n = found.numbers
    assert 0.8 < n["uncompensated_mean_mm"] < 1.3  # the paper: about 1 mm
    assert n["bare_uncompensated_mean_mm"] > n["uncompensated_mean_mm"]  # the links weigh against the load
    assert n["exact_mean_mm"] < n["ours_mean_mm"] < n["printed_mean_mm"] < 0.2


def test_files_are_complete(found: Study, folder: Path) -> None:
    for name in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (folder / name).stat().st_size > 500, name
    finite = {key: value for key, value in found.numbers.items() if np.isfinite(value)}
    assert json.loads((folder / "result.json").read_text())["numbers"] == pytest.approx(finite)
    for link in (*found.files.values(), *found.sealed):
        assert (folder / link).exists()


def test_a_study_by_name_gives_its_result_alone(
    found: Study, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def ran(names: tuple[str, ...], run: StudyRun) -> list[Study]:
        asked.append((names, run.folder, run.seed, run.quick, run.workers, run.resume))
        return [found]

    monkeypatch.setattr("workbench.studies.running.run_published", ran)
    call = ["study", "cylindrical", "--quick", "--json", "--workers", "1", "--resume", "--out", str(folder)]
    assert main(call) == 0
    assert asked == [(("cylindrical",), folder, 0, True, 1, True)]
    result = json.loads(capsys.readouterr().out)
    assert (result["study"], result["robot"], result["schema"]) == ("cylindrical", "cylindrical", 1)
    assert all(result["box"].values())


def test_captions_stand_alone(found: Study) -> None:
    captions_stand_alone(found, "Cylindrical robot")


def test_poses_are_counted_that_the_robot_could_stand_in(found: Study) -> None:
    poses_are_counted(found, 1.0)
