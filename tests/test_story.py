"""Stories: words with numbers, tables and items from a Markdown file; the list of studies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from workbench.report.charts import Series, Trace, curves, histogram, plane, rows
from workbench.report.scene import Shown
from workbench.report.story import tell
from workbench.report.study import Stand, Study, Table
from workbench.report.study_page import index, write_study
from workbench.robot.description import load_robot

CLAIMED = "[if high]High.[else]Low: {error_mm:mm}.[end]\n[if not high]In {share_high:%0} of draws.[end]"
STORY = """# A robot: It is {error_mm:mm} mm off
A paper, 2020

First line
and {share:%} more.

- Error | {error_mm:mm} | {zero:3} | mm | a note
- Alone | | {count:.0} | poses

## What was done
A paragraph <b> & "more".

**Ours beside theirs**
| Joint | Printed | Ours |
|---|---:|---|
| 1 | 7.8 | {stiffness:4} |
| 2 | | |
*A note.*

[[curve]]
And {p:p} after it.
[[list]]

## Box
### What the paper concludes
CLAIMED
### What its numbers support
That.
### What we would measure next
More.

## Assumed
- length | 0.5 m | not given
""".replace("CLAIMED", CLAIMED)
NUMBERS = {"error_mm": 1.2345, "share": -0.22, "zero": 0.0, "count": 31.4, "stiffness": 1002082.0, "p": 1e-7}


def told(folder: Path, text: str = STORY, high: float = 0.96) -> Study:
    (folder / "case").mkdir(exist_ok=True)
    (folder / "case" / "story.md").write_text(text, encoding="utf-8")
    line = Series([1.0, 2.0, 3.0], [0.5, 1.5, 2.5], [1.5, 2.5, 3.5])
    items = {
        "curve": curves("curve", "It grows", [0, 1, 2], {"ours": line}, "x", "y"),
        "list": Table("A list", ("Name", "Value"), [["a", "1"]]),
    }
    shown = Shown(np.zeros(6), np.ones((3, 3)), {"before": np.full((3, 3), 1e-3), "after": np.zeros((3, 3))})
    claims = {"high": Stand("it is high", high, 50, True)}
    story = folder / "case" / "story.md"
    return tell(story, load_robot("kr500"), NUMBERS, items, shown, "curve", claims=claims)


def test_a_figure_says_how_it_was_made(tmp_path: Path) -> None:
    study = told(tmp_path, STORY.replace("[[curve]]", "[[curve: A KR 500, {count:.0} draws: in mm.]]"))
    (drawn,) = study.figures
    assert drawn.note == "A KR 500, 31 draws: in mm."
    assert study.picture.note == ""
    write_study(study, tmp_path / "out")
    page = (tmp_path / "out/index.html").read_text(encoding="utf-8")
    assert '<span class="made">A KR 500, 31 draws: in mm.</span>' in page
    with pytest.raises(ValueError, match="list is a table"):
        told(tmp_path, STORY.replace("[[list]]", "[[list: how]]"))


def test_words_get_their_numbers(tmp_path: Path) -> None:
    study = told(tmp_path)
    assert (study.name, study.title, study.headline) == ("case", "A robot", "It is 1.23 mm off")
    assert study.summary == "First line and −22.0 % more."
    assert [(t.before, t.after, t.unit, t.note) for t in study.tiles] == [
        ("1.23", "0", "mm", "a note"),
        ("", "31", "poses", ""),
    ]
    (section,) = study.sections
    text, table, curve, after, listed = section.content
    assert isinstance(table, Table)
    assert table.title == "Ours beside theirs"
    assert table.rows == [["1", "7.8", "1\u202f002\u202f082"], ["2", "", ""]]
    assert (table.note, table.right) == ("A note.", (1,))
    assert after == "And p ≈ 10⁻⁷ after it."
    assert listed.title == "A list"
    assert (study.box.concludes, study.box.next) == ("High.", "More.")
    assert study.assumed == [("length", "0.5 m", "not given")]
    assert curve is study.picture
    assert text == 'A paragraph <b> & "more".'
    said = study.text.splitlines()
    assert said[0] == "A robot: It is 1.23 mm off"
    assert said[-2:] == ["  Error   1.23 → 0 mm   (a note)", "  Alone   31 poses"]


def test_a_sentence_whose_claim_fails_is_not_said(tmp_path: Path) -> None:
    assert told(tmp_path, high=0.9).box.concludes == "High."
    study = told(tmp_path, high=0.88)
    assert study.box.concludes == "Low: 1.23. In 88 % of draws."
    assert study.to_json()["claims"]["high"] == {
        "words": "it is high", "share": 0.88, "draws": 50, "here": True, "stands": False,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("{share:%}", "{shore:%}", "no number 'shore'"),
        ("[[list]]", "[[lost]]", "no table or figure 'lost'"),
        ("[[list]]", "", "leaves out list"),
        ("| 2 | | |", "| 2 | |", "not as many cells"),
        ("First line", "[if sure]a[end]", "no claim 'sure'"),
        (CLAIMED, "", "does not ask for high"),
        ("[else]Low", "[if high]no[end]Low", "stands within another choice"),
    ],
)
def test_a_story_that_does_not_fit_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        told(tmp_path, STORY.replace(old, new))


def test_page_report_scene_and_list_are_written(tmp_path: Path) -> None:
    study = told(tmp_path)
    write_study(study, tmp_path / "out")
    page = (tmp_path / "out/index.html").read_text(encoding="utf-8")
    for said in ("It is 1.23 mm off", "&lt;b&gt; &amp;", "Ours beside theirs", "It grows", "That.", "0.5 m"):
        assert said in page
    assert (tmp_path / "out/report.pdf").read_bytes().startswith(b"%PDF")
    assert "before" in (tmp_path / "out/scene.html").read_text(encoding="utf-8")
    listed = index([study, study])
    assert listed.count('href="case/index.html"') == 2
    assert listed.count("<svg") == 2


def test_charts_say_what_they_show() -> None:
    x = np.linspace(0, 1, 5)
    drawn = [
        rows("a", "t", ["one", "two"], {"ours": Series([1.0, 2.0], [0.5, 1.0], [2.0, 3.0])}, "mm", log=True),
        curves("b", "t", x, {"o": Series(x, x - 1, x + 1, style="o"), "l": Series(x)}, "x", "y"),
        histogram("c", "t", x, "mm", {"ours": 0.4}),
        plane("d", "t", {"wanted": Trace(x, x)}, "x", "y"),
    ]
    assert drawn[0].alt == "mm. one: ours 1; two: ours 2"
    assert "ours: 0.4" in drawn[2].alt
    assert all(figure.svg.startswith("<?xml") for figure in drawn)
