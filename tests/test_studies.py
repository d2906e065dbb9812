"""The studies as a user runs them: by name, all together, in full."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from workbench.cli.main import main
from workbench.studies import PUBLISHED

STUDIES = Path(__file__).resolve().parents[1] / "workbench" / "studies"


def test_a_study_by_name_gives_its_result_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "cylindrical", "--quick", "--json", "--out", str(tmp_path)]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["study"], result["robot"], result["schema"]) == ("cylindrical", "cylindrical", 1)
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8")) == result
    assert all(result["box"].values())


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "out").write_text("mine")
    assert main(["study", "kr120", "--quick", "--out", str(tmp_path / "out")]) == 2
    assert "is a file, not a folder" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["study", "kr5000"])


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_study_is_a_script_to_copy(name: str) -> None:
    """Short, with its words beside it, and without imports that work in this package only."""
    text = (STUDIES / name / "study.py").read_text(encoding="utf-8")
    assert 80 <= len(text.splitlines()) <= 200
    assert not re.search(r"^\s*from \.", text, flags=re.MULTILINE)
    assert "main(study)" in text
    story = (STUDIES / name / "story.md").read_text(encoding="utf-8")
    for heading in ("## Box", "### What the paper concludes", "### What its numbers support",
                    "### What we would measure next", "## Assumed"):  # fmt: skip
        assert heading in story


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
