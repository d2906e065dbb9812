"""The studies as a user runs them: by name, all together, in full."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import workbench
from workbench.cli.main import main
from workbench.studies import PUBLISHED, seeds
from workbench.studies.running import run_published
from workbench.studies.study_run import StudyRun

STUDIES = Path(__file__).resolve().parents[1] / "workbench" / "studies"


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "out").write_text("mine")
    assert main(["study", "kr120", "--quick", "--out", str(tmp_path / "out")]) == 2
    assert "is a file, not a folder" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["study", "kr5000"])


@pytest.mark.parametrize(
    ("there", "said"), [("rx170", "holds the study rx170"), ("", "holds another result")]
)
def test_two_results_are_not_mixed_in_one_folder(
    there: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "result.json").write_text(json.dumps({"schema": 1} | ({"study": there} if there else {})))
    assert main(["study", "kr120", "--quick", "--out", str(tmp_path)]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_study_is_a_folder_to_read(name: str) -> None:
    """Short files and functions, with the words beside them."""
    folder = STUDIES / name
    assert {"study.py", "story.md", "printed.py"} <= {path.name for path in folder.iterdir()}
    for path, tree in trees(folder):
        assert len(path.read_text(encoding="utf-8").splitlines()) <= 250, path
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                assert (node.end_lineno or 0) - node.lineno < 60, f"{path}: {node.name}"
    story = (folder / "story.md").read_text(encoding="utf-8")
    for heading in ("## Box", "### What the paper concludes", "### What its numbers support",
                    "### What we would measure next", "## Assumed"):  # fmt: skip
        assert heading in story


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_study_needs_the_public_names_alone(name: str) -> None:
    """Of the workbench only what `workbench` itself offers, and chapters of its own folder."""
    for path, tree in trees(STUDIES / name):
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                assert not [a.name for a in node.names if a.name.startswith("workbench")], path
            elif isinstance(node, ast.ImportFrom) and node.level:
                own = [node.module] if node.module else [alias.name for alias in node.names]
                assert node.level == 1, path
                assert all((path.parent / f"{chapter}.py").is_file() for chapter in own), (path, own)
            elif isinstance(node, ast.ImportFrom) and str(node.module).startswith("workbench"):
                assert node.module == "workbench", (path, node.module)
                assert {alias.name for alias in node.names} <= set(workbench.__all__), path


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_printed_value_says_where_it_is_printed(name: str) -> None:
    """Below each value of printed.py stand its unit and its place in the paper."""
    body = ast.parse((STUDIES / name / "printed.py").read_text(encoding="utf-8")).body
    for node, below in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign) or ast.unparse(node.targets[0]) == "NUMBERS":
            continue
        assert isinstance(below, ast.Expr), ast.unparse(node)
        said = ast.literal_eval(below.value)
        assert re.match(
            r"\[.+\] .*([Tt]able|[Ss]ection|[Ee]quation|Fig\.|Measurements|Compensation)", said
        ), said


@pytest.mark.parametrize("name", PUBLISHED)
def test_printed_values_stand_in_one_place(name: str) -> None:
    """What is distinctive in printed.py stands in no other file of the study."""
    folder = STUDIES / name
    source = (folder / "printed.py").read_text(encoding="utf-8")
    found = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant)]
    written = [ast.get_source_segment(source, node) for node in found if isinstance(node.value, int | float)]
    printed = {v for v in values(" ".join(map(str, written))) if distinctive(v)}
    assert len(printed) > 0 or name == "cylindrical"  # there all have two digits
    for path in (*folder.glob("*.py"), *folder.glob("*.md")):
        if path.name == "printed.py":
            continue
        text = re.sub(r"\{[^{}]*\}", "", path.read_text(encoding="utf-8"))
        again = {v for v in values(text) if distinctive(v) and any(same(v, p) for p in printed)}
        assert not again, f"{path} repeats {sorted(again)}"


def values(text: str) -> set[str]:
    """All numbers of a text, as digits, without sign and power of ten."""
    return set(re.findall(r"(?<![\w.])\d+(?:\.\d+)?", text))


def distinctive(value: str) -> bool:
    """Whether a number can hardly stand somewhere by chance: three digits of a fraction, or four."""
    digits = value.replace(".", "").strip("0") if "." in value else value.strip("0")
    return len(digits) >= (3 if "." in value else 4)


def same(value: str, printed: str) -> bool:
    """Whether a number is a printed one, rounded as it is: also as a share in per cent, or in mm for m."""
    places = len(value.partition(".")[2])
    return any(round(float(printed) * unit, places) == float(value) for unit in (1.0, 1e3, 1e-3, 100.0))


def trees(folder: Path) -> list[tuple[Path, ast.Module]]:
    return [(path, ast.parse(path.read_text(encoding="utf-8"))) for path in sorted(folder.glob("*.py"))]


@pytest.mark.slow
def test_a_copied_study_runs_with_its_own_chapters(tmp_path: Path) -> None:
    """A folder that lies anywhere, under any name, run as a script: what is changed in it counts."""
    copied = tmp_path / "my-robot"
    shutil.copytree(STUDIES / "cylindrical", copied, ignore=shutil.ignore_patterns("__pycache__"))
    text = (copied / "printed.py").read_text(encoding="utf-8")
    (copied / "printed.py").write_text(text.replace("POSES = 50", "POSES = 40"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(copied / "study.py"), "--quick", "--json"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(STUDIES.parents[1])},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert (result["study"], result["numbers"]["poses"]) == ("my-robot", 40)
    for file in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (tmp_path / "reports" / "my-robot" / file).is_file()


@pytest.mark.slow
def test_all_studies_in_full(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "all", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    listed = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert listed.count("<svg") == len(PUBLISHED)
    for name in PUBLISHED:
        assert f'href="{name}/index.html"' in listed
        result = json.loads((tmp_path / name / "result.json").read_text(encoding="utf-8"))
        assert result["headline"] in said
        for file in ("index.html", "report.pdf", "scene.html"):
            assert (tmp_path / name / file).is_file()


def test_pages_of_several_seeds_beside_each_other() -> None:
    """A page that stays though its claim turned, one that says it too often, a number written out."""
    story = (
        "# A: [if high]High.[else]High.[end]\n\nIt is 1.234 mm, {error_mm:mm}.\n\n## Assumed\n- x | 5.678 | y"
    )

    def page(seed: int, stands: bool, error: float, text: str, share: float) -> seeds.Page:
        claim = {"words": "high", "share": share, "draws": 100, "here": stands, "stands": stands}
        return seeds.Page({"claims": {"high": claim}, "numbers": {"error_mm": error}}, [text])

    pages = [page(0, True, 1.234, "High.", 0.95), page(1, False, 2.0, "High.", 0.5)]
    found = "\n".join(seeds.faults(story, pages))
    assert len(found.splitlines()) == 4
    for said in ("both sentences", "the page stays", "holds in 72% of all draws", "1.234 is written out"):
        assert said in found
    assert seeds.claims_of(pages)["high"]["holds"] == seeds.claims_of(pages)["high"]["said"] == 1
    sound = [
        page(0, True, 1.0, "It is high by 1.0 mm.", 0.95),
        page(1, True, 2.0, "It is high by 2.0 mm.", 0.93),
    ]
    assert seeds.faults("[if high]It is high by {error_mm:mm} mm.[else]It is not.[end]", sound) == []
    assert seeds.to_read(
        [page(0, True, 1.0, "It falls by 1.0 mm.", 1.0), page(1, True, 2.0, "It falls by 2.0 mm.", 1.0)]
    )


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_choice_of_a_story_has_two_sentences(name: str) -> None:
    story = (STUDIES / name / "story.md").read_text(encoding="utf-8")
    assert not [fault for fault in seeds.faults(story, []) if "both sentences" in fault]


@pytest.mark.slow
@pytest.mark.parametrize("name", PUBLISHED)
def test_no_sentence_is_false_under_three_seeds(name: str, tmp_path: Path) -> None:
    """Whole quick runs: `benchmarks/claims.py` does it for ten."""
    pages = []
    for seed in (1, 2, 3):
        where = tmp_path / str(seed)
        run_published((name,), StudyRun(where, seed=seed, quick=True, workers=1))
        pages.append(seeds.read_page(where, seed))
    assert seeds.faults((STUDIES / name / "story.md").read_text(encoding="utf-8"), pages) == []
