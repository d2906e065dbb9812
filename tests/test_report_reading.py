"""What a reader looks for first: no number twice, the next command, the worst poses, a row for a thing."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import diagnosis_example as example
import numpy as np
import pytest

from workbench.campaign.guess import guess_points, guess_poses
from workbench.campaign.template import template_files
from workbench.diagnosis.found import Decision, FaultFound, Rival
from workbench.diagnosis.telling.findings import said_together
from workbench.diagnosis.telling.headline import in_order
from workbench.diagnosis.telling.standing import Standing, why_open
from workbench.effects.place import Where
from workbench.report.content import content, gather
from workbench.report.deciding import LONG, ways
from workbench.report.first_look import _along
from workbench.report.numbers import mm
from workbench.report.page import page
from workbench.report.residuals import residuals
from workbench.report.terminal import short_verdict
from workbench.robot.new_robot import new_robot

URDF = Path(__file__).parents[1] / "models" / "kr500" / "kr500.urdf"


def test_the_worst_poses_stand_by_name() -> None:
    """Each once, with its worst target, the worst first."""
    plain = example.diagnosis(n_poses=60)
    assert plain.errors is not None
    ids = tuple(f"P{i:03d}" for i in range(plain.n_poses))
    named = replace(plain.errors, pose_ids=ids, target_names=("A", "B", "C"))
    said = content(replace(plain, errors=named))
    length = 1e3 * np.linalg.norm(named.error_final, axis=1)
    worst = int(np.argmax(length))
    assert said["worst"][0][0] == ids[named.pose[worst]]
    assert said["worst"][0][1] == "ABC"[named.target[worst]]
    assert said["worst"][0][3] == mm(float(length[worst]))
    assert len({row[0] for row in said["worst"]}) == len(said["worst"]) == 5
    by_pose = np.array([length[named.pose == i].max() for i in range(plain.n_poses)])
    assert [row[3] for row in said["worst"]] == [mm(float(value)) for value in np.sort(by_pose)[::-1][:5]]
    assert said["worst"][0][0] in page(gather(replace(plain, errors=named)))
    assert content(replace(plain, errors=None))["worst"] == []


def test_every_residual_is_in_the_table() -> None:
    """As the figures have it: its length is that of its parts, and the RMS that of the stage."""
    made = example.diagnosis(n_poses=40)
    assert made.errors is not None
    table = residuals(made)["residuals.csv"].decode()
    head, *rows = csv.reader(io.StringIO(table))
    assert len(rows) == len(made.errors.points)
    numbers = {name: np.array([float(row[k]) for row in rows]) for k, name in enumerate(head) if k > 1}
    parts = np.column_stack([numbers[f"d{axis}_mm"] for axis in "xyz"])
    np.testing.assert_allclose(np.linalg.norm(parts, axis=1), numbers["error_mm"], atol=2e-4)
    np.testing.assert_allclose(1e3 * made.errors.error_final, parts, atol=1e-4)
    geometry = 1e3 * np.linalg.norm(made.errors.error_geometry, axis=1)
    np.testing.assert_allclose(geometry, numbers["geometry_mm"], atol=1e-4)
    assert 'href="residuals.csv"' in page(gather(made))
    nothing = replace(made, errors=None)
    assert residuals(nothing) == {}
    assert "residuals.csv" not in page(gather(nothing))


@pytest.mark.parametrize(
    ("behind", "left"),
    [
        ("Held-out error 2.282 → 0.056 mm RMS, 0.139 mm with geometry alone.", ""),
        (
            "Held-out error 2.282 → 0.056 mm RMS; the causes bring 0.1 of 0.2 mm. In these data it moved.",
            "In these data it moved.",
        ),
        ("Held-out error 2 → 1.5 mm RMS (1.9 mm without what only this campaign has), 3.1 mm.", None),
    ],
)
def test_the_head_says_no_number_twice(behind: str, left: str | None) -> None:
    """What the tiles say does not stand above them as well, but for what only the sentence says."""
    said = content(replace(example.diagnosis(), headline=f"Found: a fault. {behind}"))["verdict"]
    assert said["headline"] == "Found: a fault"
    assert said["more"] == (behind if left is None else left)


def test_a_command_can_be_copied() -> None:
    """It stands by itself, without a full stop, and in the terminal with its folder."""
    made = example.diagnosis()
    causes = [replace(one, status="named", rivals=(), separate_by=None, decide=()) for one in made.causes]
    named = replace(made, causes=tuple(causes), verdict="named", proof=None)
    assert "<code>workbench compensate PATH.csv --model model.toml</code>" in page(gather(named))
    lines = short_verdict(named, Path("found")).splitlines()
    (step,) = [line for line in lines if line.startswith("  next: ")]
    assert step.endswith("workbench compensate PATH.csv --model found/model.toml")
    assert "  next: " not in short_verdict(made, Path("found"))
    (step,) = [line for line in short_verdict(named, Path("cell 1")).splitlines() if "  next: " in line]
    assert step.endswith("compensate PATH.csv --model 'cell 1/model.toml'")


def test_rows_of_the_geometry_are_set_off_from_its_independent_parameters() -> None:
    """The stages count these, the table has those."""
    made = example.diagnosis()
    said = str(content(made)["geometry_said"])
    assert f"The {len(made.geometry)} rows are {made.stages[1].parameters} independent parameters" in said


def test_of_many_commands_the_first_stands_and_a_long_one_reads_the_result() -> None:
    made = example.diagnosis()
    tell = f"gear_ratio:joint=joint_2,relative=1e-4,{'x' * LONG}"
    plan, read = (
        f"workbench plan c.toml --tell {tell} --poses 30 --out f",
        "workbench diagnose c.toml --known A",
    )
    decide = (
        Decision("poses", "30 more poses", plan, 30, 1.0, 40.0),
        Decision("reading", "read mass_kg of link_2", read, None, 1.0, None),
    )
    open_ = replace(made.causes[0], status="ambiguous", separate_by="weigh it", decide=decide)
    made = replace(made, causes=(open_,))
    assert [folded for _, _, folded in ways(open_)] == [True, True]
    told = short_verdict(made, Path("cell 1"))
    assert "workbench plan c.toml --tell 'cell 1/result.json' --poses 30 --out f" in told
    assert read not in told
    assert "(the command of the other: on the page, and in cell 1/result.json)" in told
    assert page(gather(made)).count("<summary>its command</summary>") == 2
    assert plan in short_verdict(made, None)  # no result was written
    two = replace(made, causes=(open_, replace(open_, decide=())))
    assert "--tell 'cell 1/result.json' --out f" in short_verdict(two, Path("cell 1"))
    assert [f for _, _, f in ways(replace(open_, decide=decide[1:]))] == [False]


def test_robot_and_campaign_of_one_name_stand_once() -> None:
    made = example.diagnosis()
    assert content(replace(made, campaign=made.robot_title))["origin"] == made.robot_title
    assert content(made)["origin"] == f"{made.robot_title} · {made.campaign}"


def test_the_ranges_of_all_joints_stand_in_one_row() -> None:
    facts = {
        "Targets": "T1",
        "Range of a": "−1.0 … 2.0°",
        "Range of b": "3 … 4 mm",
        "Recorded besides": "time",
    }
    said = content(replace(example.diagnosis(), facts=facts))["facts"]
    assert [row for row in said if row[0] in ("Targets", "Ranges", "Recorded besides")] == [
        ["Targets", "T1"],
        ["Ranges", "a −1.0 … 2.0° · b 3 … 4 mm"],
        ["Recorded besides", "time"],
    ]
    assert not any(name.startswith("Range of") for name, _ in said)


def test_lines_of_one_gear_are_one_sentence() -> None:
    first, second = (f"The gear of A errs by {n} µrad in {n} cycles." for n in (9, 4))
    assert (
        said_together([first, second]) == "The gear of A errs by 9 µrad in 9 cycles; by 4 µrad in 4 cycles."
    )
    other = "The gear of B errs by 4 µrad in 4 cycles."
    assert said_together([first, other]) == f"{first} {other}"


def test_the_arm_is_seen_from_its_side() -> None:
    """Its reach shows in full, wherever it points, and heights stay."""
    flat = np.array([[0, 0, 0], [0, 0, 0.7], [0, -1.5, 1.2]])
    np.testing.assert_allclose(flat @ _along(flat), np.column_stack([flat, [0, 0, 1.5]]))
    upright = np.array([[0, 0, 0], [0, 0, 1.0]])
    np.testing.assert_allclose((upright @ _along(upright))[:, 2], [0, 1])


def test_init_reads_the_temperature_and_names_the_targets(tmp_path: Path) -> None:
    made = new_robot(URDF)
    joints = made.chain.joints
    q = "\n".join(f"P{i};" + ";".join(f"{7 * i + j},5" for j in range(6)) + f";2{i},5" for i in range(1, 9))
    poses, points = tmp_path / "q.csv", tmp_path / "p.csv"
    head = ";".join(f"A{i} [Grad]" for i in range(1, 7))
    poses.write_text(f"Nr;{head};Temp [C]\n{q}\n")
    assert guess_poses(poses, joints).keys["columns"]["temp_degC"] == "Temp [C]"
    poses.write_text(f"Nr;{head};Temp [F]\n{q}\n")
    assert "temp_degC" not in guess_poses(poses, joints).keys["columns"]
    rows = [
        f"P{i};{t};{100 * i},5;{20 * i * i},25;{900 - 30 * i},125"
        for i in range(1, 9)
        for t in ("SMR1", "T 2")
    ]
    points.write_text("Gruppe;Punkt;X [mm];Y [mm];Z [mm]\n" + "\n".join(rows) + "\n")
    assert guess_points(points).targets == ["SMR1", "T 2"]
    told = template_files(made, tmp_path / "out", poses, points)[Path("campaign.toml")]
    assert "# [targets.SMR1]\n" in told
    assert '# [targets."T 2"]\n' in told
    assert "[targets.T1]" not in told


def test_steps_stand_in_the_order_of_the_poses() -> None:
    """Where other faults stand among them, these keep their places."""

    def fault(kind, pose):
        return FaultFound(kind, pose, None, f"{pose} steps by 1 mm before this pose", "")

    found = [fault("moved_instrument", "c"), fault("outlier", "b"), fault("changed_setup", "a")]
    ordered = in_order(found, ["a", "b", "c"])
    assert [one.pose_id for one in ordered] == ["a", "b", "c"]


@pytest.mark.parametrize(
    ("rivals", "nameless", "said"),
    [
        ((), ("a step of the base",), ["A step of the base fits as well, which has no name."]),
        ((), ("one", "another"), ["One and another fit as well, which have no name."]),
        ((Rival("foundation", Where(), 0.2),), (), []),
        ((), (), ["No other that was tried fits as well, but a name needs 95 %: it has 93 %."]),
    ],
)
def test_what_is_open_says_why(rivals, nameless, said) -> None:
    """A cause that is "ambiguous" without a rival would else be so for no reason that a reader sees."""
    assert why_open(Standing(0.93, rivals, nameless, (), 0.9)) == said
