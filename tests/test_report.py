"""The report: every diagnosis renders, the numbers are in it, nothing comes from outside or breaks."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import diagnosis_example as example
import numpy as np
import pytest
from html_check import parse

from workbench.diagnosis.found import Finding, NotTestable
from workbench.diagnosis.result import Diagnosis
from workbench.effects import catalogue
from workbench.effects.place import Parameter, Where
from workbench.report import figures, write_all
from workbench.report.content import content, gather
from workbench.report.equation import typeset
from workbench.report.numbers import mm, p_value, quantity, significant, size
from workbench.report.page import page
from workbench.report.pdf import pdf
from workbench.report.scene import scene
from workbench.robot.description import Robot, load_robot

VARIANTS = [example.diagnosis, example.nothing_missing, example.unknown, example.bare]
FILES = ("result.json", "index.html", "report.pdf", "scene.html", "residuals.csv")
HOME = np.zeros(6)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("kr500")


@pytest.mark.parametrize("make", VARIANTS)
def test_everything_is_written(make: Callable[[], Diagnosis], robot: Robot, tmp_path: Path) -> None:
    diagnosis = make()
    written = write_all(diagnosis, robot, tmp_path / "out", HOME)
    files = FILES if diagnosis.errors is not None else FILES[:-1]
    assert [path.name for path in written] == list(files)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(files)
    assert json.loads(written[0].read_text(encoding="utf-8"))["verdict"] == diagnosis.verdict
    assert written[2].read_bytes().startswith(b"%PDF")
    assert written[3].stat().st_size < 5e6


@pytest.mark.parametrize("make", VARIANTS)
def test_page_stands_alone(make: Callable[[], Diagnosis]) -> None:
    html = page(gather(make()))
    parse(html)
    without_namespaces = re.sub(r'xmlns(:\w+)?="[^"]*"', "", html)
    assert "://" not in without_namespaces
    assert not re.findall(
        r"""(?:src|href)=["'](?!#|scene\.html|report\.pdf|result\.json|residuals\.csv|model\.toml)""", html
    )
    assert html.count("<svg") == html.count('role="img"')
    assert html.count("<th") > html.count("<thead>")


def test_page_says_the_numbers() -> None:
    diagnosis = example.diagnosis()
    text = " ".join("".join(parse(page(gather(diagnosis))).text).split())
    last = diagnosis.stages[-1]
    assert diagnosis.headline in text
    for number in (last.heldout_mean_mm, last.heldout_rms_mm, last.heldout_max_mm):
        assert mm(number) in text
    for said in ("210 µrad (43.3 arcsec)", "204 … 216 µrad", "−11.8 %", "probability 99.9 %", "0.042 mm",
                 "joint_5 ",
                 "Fits as well: joint compliance (joint_2); link bending (link_2)", "pose 117, T2",
                 "no column t_s in poses.csv", "2.47 to 0.071 mm", "joint_2 6.0 µrad"):  # fmt: skip
        assert said in text, said
    for name, digest in diagnosis.inputs.items():
        assert name in text
        assert digest in text


def test_page_and_pdf_come_out_the_same_twice() -> None:
    first, second = gather(example.diagnosis()), gather(example.diagnosis())
    assert page(first) == page(second)
    assert pdf(first) == pdf(second)


def test_a_table_with_many_places_keeps_room_for_its_other_columns() -> None:
    """Else each word of a reason stands on a line of its own, over pages."""

    def pages(diagnosis: Diagnosis) -> int:
        found = re.search(rb"/Count (\d+)", pdf(gather(diagnosis)))
        assert found is not None
        return int(found[1])

    plain = example.diagnosis()
    pairs = [
        Where(joint=f"joint_{a}", other=f"joint_{b}") for a in range(3, 7) for b in range(3, 7) if a != b
    ]
    why = "no column temp_degC (or t_s): record the temperature of the arm with each pose, or its time. "
    untested = tuple(NotTestable("wrist_coupling", 12 * why, where) for where in pairs)
    assert pages(replace(plain, not_testable=(*plain.not_testable, *untested))) <= pages(plain) + 1


def test_failure_leaves_the_folder_as_it_was(
    robot: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_all(example.bare(), robot, tmp_path, HOME)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def broken(*_: object) -> bytes:
        raise RuntimeError("no PDF today")

    monkeypatch.setattr("workbench.report.pdf.pdf", broken)
    with pytest.raises(RuntimeError, match="no PDF today"):
        write_all(example.diagnosis(20), robot, tmp_path, HOME)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_file_that_cannot_be_moved_leaves_no_rest(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "index.html").mkdir()
    with pytest.raises(OSError, match=r"index\.html"):
        write_all(example.bare(), robot, tmp_path, HOME)
    assert [path.name for path in tmp_path.iterdir()] == ["index.html"]


def test_scene_carries_robot_points_and_both_poses(robot: Robot) -> None:
    diagnosis, q = example.diagnosis(), np.full(6, 0.3)
    alone = scene(diagnosis, robot, q)
    both = scene(diagnosis, robot, q, q + 0.02, "under load, × 100")
    assert "under load, \\u00d7 100" in both
    assert len(both) > len(alone)
    data = json.loads(re.search(r"const data = (\{.*\});", alone)[1])  # type: ignore[index]
    assert [stage["name"] for stage in data["stages"]] == [
        "Nominal model", "Geometry calibrated", "Causes in the model",
    ]  # fmt: skip
    assert len(data["pose"]) == diagnosis.n_points
    assert data["ghost"] == ""


def test_report_of_a_large_campaign_stays_small(robot: Robot, tmp_path: Path) -> None:
    """Twenty times the poses: more dots, each of a few bytes; that is what makes a page quick as well."""
    sizes = [
        [
            path.stat().st_size
            for path in write_all(example.diagnosis(n, 1), robot, tmp_path / str(n), HOME)
            if path.suffix != ".csv"  # a row per point
        ]
        for n in (20, 400)
    ]
    assert all(large < 2 * small for small, large in zip(*sizes, strict=True))


def test_same_stage_names_as_the_result() -> None:
    names = figures.stage_names(example.diagnosis())
    assert names == [
        "nominal",
        "geometry",
        "+ gear kinematic error (joint_4)",
        "+ gravity compensator",
        "+ backlash (joint_5)",
    ]


def test_report_names_no_cause() -> None:
    folder = Path(figures.__file__).parent
    texts = [file for file in folder.rglob("*") if file.suffix in (".py", ".html", ".typ")]
    named = re.compile("|".join(rf"[\"'`]{cause}[\"'`]" for cause in catalogue()))
    assert [file.name for file in texts if named.search(file.read_text(encoding="utf-8"))] == []


def test_every_equation_of_the_catalogue_is_set() -> None:
    equations = {cause: effect.equation for cause, effect in catalogue().items()}
    drawn = typeset(list(equations.values()))
    assert [cause for cause, equation in equations.items() if equation not in drawn] == []


def test_summary_of_noise_from_the_residual_judges_nothing() -> None:
    said = content(example.bare())
    assert "cannot be judged" in said["remainder"]
    assert said["stages"][-1]["numbers"][2] == "–"


def test_unknown_cause_shows_its_structure() -> None:
    said = content(example.unknown())
    left: dict[str, str] = said["causes"][-1]
    assert left["status_label"] == "Unexplained"
    assert left["structure"] == "Depends on joint_3."
    assert left["gain"] == ""
    assert "More is left than the noise explains" in said["remainder"]


@pytest.mark.parametrize(
    ("parameter", "value", "interval"),
    [
        (Parameter("amplitude", 2.1e-4, 3e-6, "rad"), "210 µrad", "204 … 216 µrad"),
        (Parameter("phase", -0.72, 0.014, "rad"), "−41.3°", "−42.8 … −39.7°"),
        (Parameter("relative", -0.118, 0.006, "1"), "−11.8 %", "−13.0 … −10.6 %"),
        (Parameter("compliance", 3.2e-9, 2e-10, "rad/(N·m)"), "3.2 nrad/(N·m)", "2.8 … 3.6 nrad/(N·m)"),
        (Parameter("com_x", 0.152, 0.001, "m"), "152.0 mm", "150.0 … 154.0 mm"),
        (Parameter("mass", 252.1, 1.1, "kg"), "252.1 kg", "249.9 … 254.3 kg"),
        (Parameter("coefficient", 1.15e-5, 1e-7, "1/K"), "11.50 µm/(m·K)", "11.30 … 11.70 µm/(m·K)"),
        (
            Parameter("compliance", 2.1e-8, 1e-9, "1/(N·m²)"),
            "21.0·10⁻⁹/(N·m²)",
            "19.0 … 23.0·10⁻⁹/(N·m²)",
        ),
        (Parameter("half_width", 0.0, float("nan"), "rad"), "0 µrad", ""),
        (
            Parameter("amplitude", 6.44e-4, 1.833e-3, "rad", least=0.0),
            "600 µrad",
            "0 … 4\N{NARROW NO-BREAK SPACE}200 µrad",
        ),
    ],
)
def test_numbers_of_parameters(parameter: Parameter, value: str, interval: str) -> None:
    shown = quantity(parameter)
    assert (str(shown), shown.interval) == (value, interval)


def test_numbers_are_written_for_people() -> None:
    assert [mm(x) for x in (2.934, 0.0621, 0.00034, 123.4, float("nan"))] == [
        "2.93",
        "0.062",
        "0.0003",
        "123.4",
        "–",
    ]
    assert [p_value(x) for x in (0.0, 3e-7, 0.0042, 0.26)] == [
        "p < 10⁻¹²",
        "p ≈ 10⁻⁷",
        "p = 0.004",
        "p = 0.26",
    ]
    assert size(6e-6, "rad") == "6.0 µrad"
    assert [size(x, "1") for x in (1.1e-5, 0.012, 7.0)] == ["11 ppm", "1.2 %", "7.0"]
    assert size(1.1e-5, "1", "coupling") == "11 µrad/rad"
    assert size(0.5, "1", "weight") == "0.50"
    assert significant(3.1e-10) == "3.10·10⁻¹⁰"


def test_figures_of_odd_data_are_drawn() -> None:
    full = example.diagnosis(3, 1)
    assert full.errors is not None
    flat = replace(
        full.errors, error_geometry=full.errors.error_geometry * 0, error_final=full.errors.error_final * 0
    )
    assert gather(replace(full, errors=flat)).figures
    one = np.array([0.1])
    seen = full.causes[0].evidence
    assert seen is not None
    single = replace(seen, x=one, before=one, after=one * 0, curve_x=one[:0], curve_y=one[:0])
    finding: Finding = replace(full.causes[0], evidence=single)
    assert figures.evidence(finding, 0) is not None
