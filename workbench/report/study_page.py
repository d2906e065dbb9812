"""A study's folder: page, PDF, scene and numbers; and the list of studies over all their folders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from .drawing import Figure
from .folder import json_bytes, write_together
from .markup import render
from .numbers import percent
from .pdf import typeset
from .scene import scene_of
from .study import BOX_TITLES, Study, Table
from .study_exports import exported

VERSION = version("robot-workbench")
TRUTH = "truth.json"


def write_study(study: Study, folder: Path) -> None:
    """Writes `result.json`, `index.html`, `report.pdf`, `scene.html`, each table and figure by itself, and
    what was hidden in the campaigns, after all of them are made."""
    said, drawn = said_of(study), numbered(study)
    made = {
        "result.json": json_bytes(study.to_json()),
        "index.html": page(study, said).encode(),
        "report.pdf": typeset("study.typ", said, drawn),
        "scene.html": scene_of(study.robot, study.shown, study.title).encode(),
        **{name: text.encode() for name, text in exported(study).items()},
    }
    if study.sealed:
        made[TRUTH] = json_bytes({"campaigns": study.sealed})
    write_together(folder, made)


def page(study: Study, said: Mapping[str, Any]) -> str:
    """The study's page: one self-contained HTML file."""
    beside = {link: name for name, link in study.files.items()}
    return render("study.html", **said, figures=numbered(study), files=beside)


def index(studies: Sequence[Study]) -> str:
    """The list of studies: one line and one picture each."""
    return render("studies.html", studies=studies, version=VERSION)


def said_of(study: Study) -> dict[str, Any]:
    """What the PDF's template reads, all of it ready text."""
    tables = {id(table): number for number, table in enumerate(study.tables, start=1)}
    return {
        "title": study.title,
        "source": study.source,
        "headline": study.headline,
        "summary": study.summary,
        "tiles": [vars(tile) for tile in study.tiles],
        "sections": [
            {"title": section.title, "content": [_item(item, tables) for item in section.content]}
            for section in study.sections
        ],
        "box": [{"title": name, "text": getattr(study.box, key)} for key, name in BOX_TITLES.items()],
        "claims": [
            [
                c.words,
                percent(c.share, 0),
                f"{c.draws} draws" if c.draws else "this run",
                "yes" if c.stands else "no",
            ]
            for c in study.claims.values()
        ],
        "references": [list(reference) for reference in study.references],
        "assumed": [list(row) for row in (*study.assumed, *_assumed_in_toml(study))],
        "version": VERSION,
    }


def numbered(study: Study) -> dict[str, Figure]:
    """The figures by name, each with its number in the title."""
    return {
        f.name: replace(f, title=f"Figure {number}. {f.title}")
        for number, f in enumerate(study.figures, start=1)
    }


def _item(item: Any, tables: Mapping[int, int]) -> dict[str, Any]:
    if isinstance(item, str):
        return {"text": item}
    if not isinstance(item, Table):
        return {"figure": item.name}
    return {
        "title": f"Table {tables[id(item)]}. {item.title}",
        "head": list(item.head),
        "rows": [list(row) for row in item.rows],
        "note": item.note,
        "right": list(item.right),
    }


def _assumed_in_toml(study: Study) -> list[tuple[str, str, str]]:
    """What the robot's own TOML marks as assumed."""
    source = study.robot.source
    return [
        (f"robot: {name.replace('_', ' ')}", "as in its TOML", why)
        for name, why in source.items()
        if "assumed" in why
    ]
