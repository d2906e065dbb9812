"""Sources are named by author and year, and docs/references.md says what each one is."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
REFERENCES = (ROOT / "docs/references.md").read_text(encoding="utf-8")
HEADS = {*re.findall(r"^\*\*([^*]+?)\.?\*\*", REFERENCES, flags=re.MULTILINE)}
INNER = r"\b(source \d{3}|catalogue no|contract\b|contract's|house plan)"  # our own numbers and papers
MENTION = re.compile(r"([A-Z]\w+) (et al\.|(?:&|and) (?:O')?[A-Z]\w+),?\s*\(?(\d{4})?")
ALONE = re.compile(r"[(,;:] ?((?:De )?[A-Z][a-z][a-zA-Z]*) ((?:19|20)\d{2})\b[):,;]")  # in a bracket
TEXTS = {".py", ".md", ".toml", ".html", ".typ", ".css"}
PLACES = (
    "workbench",
    "docs",
    "models",
    "tests",
    "benchmarks",
    "README.md",
    "CHANGELOG.md",
    "reports/README.md",
)


def texts():
    for place in PLACES:
        path = ROOT / place
        found = [path] if path.is_file() else sorted(path.rglob("*"))
        yield from (file for file in found if file.suffix in TEXTS and file != Path(__file__).resolve())


def mentions():
    """Every author-year in code and pages."""
    found = {}
    for path in texts():
        for name, others, year in MENTION.findall(path.read_text(encoding="utf-8")):
            others = others.replace("and", "&")
            if others == "et al." or year:
                key = f"{name} {others} {year}".strip()
                found.setdefault(key, path.relative_to(ROOT).as_posix())
    return found


def test_no_source_has_a_number_of_our_own():
    named = []
    for path in texts():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if re.search(INNER, line, flags=re.IGNORECASE):
                named.append(f"{path.relative_to(ROOT)}:{number}")
    assert not named


@pytest.mark.parametrize("source", sorted(mentions()))
def test_every_author_and_year_is_a_reference(source):
    known = {head.rstrip(".") for head in HEADS} | {"Landgraf et al"}
    assert source.rstrip(".") in known, mentions()[source]


def test_authors_alone_are_references():
    """(Dahl 1968) and the like, in code; a place or a month before a year is in no bracket there."""
    named = [
        (name, year, path.name)
        for path in sorted((ROOT / "workbench").rglob("*.py"))
        for name, year in ALONE.findall(path.read_text(encoding="utf-8"))
    ]
    assert named
    heads = " ".join(HEADS)
    assert not [item for item in named if f"{item[0]} {item[1]}" not in heads]


@pytest.mark.parametrize("room", ["effects", "measurement", "identification", "correction"])
def test_docstrings_name_sources_that_resolve(room):
    """As above, over docstrings alone, and with the authors whose year stands elsewhere."""
    for path in (ROOT / "workbench" / room).rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                said = ast.get_docstring(node) or ""
                for author in re.findall(r"\b([A-Z]\w+) et al\.|\b(?:(Fedorov)|(ISO \d+))\b", said):
                    assert f"**{''.join(author)}" in REFERENCES, (path, author)


def test_every_robot_s_sources_are_explained():
    """What a robot's file takes from a paper is a reference; the rest stands in the table of numbers."""
    for path in (ROOT / "models").glob("*/*.toml"):
        said = path.read_text(encoding="utf-8").split("[source]")[1]
        assert path.stem in REFERENCES, path.stem
        for words in ("robot kinematics catalogue", "MATLAB model of the KR 500", "ROS-Industrial"):
            assert words not in said or words in REFERENCES


@pytest.mark.parametrize("link", re.findall(r"\]\(([^)#:]+)\)", REFERENCES))
def test_links_lead_somewhere(link):
    assert (ROOT / "docs" / link).exists()
