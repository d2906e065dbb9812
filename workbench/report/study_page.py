"""A study's folder: page, PDF, scene and numbers; and the list of studies over all their folders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from .folder import json_bytes, write_together
from .markup import render
from .pdf import typeset
from .scene import scene_of
from .study import BOX_TITLES, Study, Table

VERSION = version("robot-workbench")


def write_study(study: Study, folder: Path) -> None:
    """Writes `result.json`, `index.html`, `report.pdf` and `scene.html`, after all of them are made."""
    said = said_of(study)
    made = {
        "result.json": json_bytes(study.to_json()),
        "index.html": page(study, said).encode(),
        "report.pdf": typeset("study.typ", said, {f.name: f for f in study.figures}),
        "scene.html": scene_of(study.robot, study.shown, study.title).encode(),
    }
    write_together({folder / name: data for name, data in made.items()})


def page(study: Study, said: Mapping[str, Any]) -> str:
    """The study's page: one self-contained HTML file."""
    beside = {link: name for name, link in study.files.items()}
    return render("study.html", **said, figures={f.name: f for f in study.figures}, files=beside)


def index(studies: Sequence[Study]) -> str:
    """The list of studies: one line and one picture each."""
    return render("studies.html", studies=studies, version=VERSION)


def said_of(study: Study) -> dict[str, Any]:
    """What the PDF's template reads, all of it ready text."""
    return {
        "title": study.title,
        "source": study.source,
        "headline": study.headline,
        "summary": study.summary,
        "tiles": [vars(tile) for tile in study.tiles],
        "sections": [
            {"title": section.title, "content": [_item(item) for item in section.content]}
            for section in study.sections
        ],
        "box": [{"title": name, "text": getattr(study.box, key)} for key, name in BOX_TITLES.items()],
        "assumed": [list(row) for row in (*study.assumed, *_assumed_in_toml(study))],
        "version": VERSION,
    }


def _item(item: Any) -> dict[str, Any]:
    if isinstance(item, str):
        return {"text": item}
    if not isinstance(item, Table):
        return {"figure": item.name}
    return {
        "title": item.title,
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
