"""A study's folder: page, PDF, scene and numbers; and the list of studies over all their folders."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ..files.whole import put
from .parts import document, figure, table, tiles
from .pdf import typeset
from .scene import scene_of
from .study import Section, Study, Table

FILES = {"report.pdf": "PDF", "scene.html": "3-D scene", "result.json": "Numbers"}
BOX = {
    "concludes": "What the paper concludes",
    "supports": "What its numbers support",
    "next": "What we would measure next",
}
MADE = f"Robot workbench {version('robot-workbench')}"


def write_study(study: Study, folder: Path) -> None:
    """Writes `result.json`, `index.html`, `report.pdf` and `scene.html`, after all of them are made."""
    said = _said(study)
    made = {
        "result.json": (json.dumps(study.to_json(), indent=2, ensure_ascii=False) + "\n").encode(),
        "index.html": page(study, said).encode(),
        "report.pdf": typeset("study.typ", said, {f.name: f for f in study.figures}),
        "scene.html": scene_of(study.robot, study.shown, study.title).encode(),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in made.items():
        put(folder / name, data)


def page(study: Study, said: Mapping[str, Any]) -> str:
    """The study's page: one self-contained HTML file."""
    links = {**FILES, **{link: name for name, link in study.files.items()}}
    shown = "".join(f'<a href="{escape(link)}">{escape(name)}</a>' for link, name in links.items())
    box = "".join(
        f"<h4>{title}</h4><p>{escape(said['box'][key])}</p>" for key, title in BOX.items()
    )  # fmt: skip
    head = (
        f'<header><div><div class="origin"><span>{escape(study.source)}</span>'
        f'<nav aria-label="Files">{shown}</nav></div><h1>{escape(study.headline)}</h1>'
        f'<p class="lead">{escape(study.summary)}</p>{tiles(said["tiles"])}</div></header>'
    )
    scene = (
        '<section id="scene"><h2>In space</h2><p class="quiet">Points with their errors, enlarged. Drag to '
        'turn, scroll to zoom; <a href="scene.html">open it alone</a>.</p><iframe src="scene.html" '
        'loading="lazy" title="3-D scene of the robot, the points and their errors"></iframe></section>'
    )
    assumed = table(
        "What the paper does not give, and what was taken instead.", ("What", "Value", "Why"), said["assumed"]
    )
    body = [head, "<main>", *(_section(section) for section in study.sections)]
    body += [f'<section id="box"><div class="box">{box}</div></section>', scene]
    body += [f'<section id="assumed"><h2>Assumed</h2>{assumed}</section>', "</main>"]
    body.append(f"<footer><div><p>{escape(MADE)}</p></div></footer>")
    return document(f"{study.title}: {study.headline}", "\n".join(body))


def index(studies: Sequence[Study]) -> str:
    """The list of studies: one line and one picture each."""
    cards = "".join(
        f'<article class="card"><header><h3><a href="{study.name}/index.html">{escape(study.title)}</a></h3>'
        f'</header><p class="quiet">{escape(study.source)}</p><p class="lead">{escape(study.headline)}</p>'
        f"{figure(study.picture)}</article>"
        for study in studies
    )
    head = (
        '<header><div><div class="origin"><span>Robot workbench</span></div><h1>Five published studies, '
        'reproduced and questioned</h1><p class="lead">Each robot, protocol and table of the paper, measured '
        "again in simulation, our numbers beside the printed ones: what do they support?</p></div></header>"
    )
    foot = f"<footer><div><p>{escape(MADE)}</p></div></footer>"
    return document("Published studies", f"{head}\n<main>{cards}</main>\n{foot}")


def _section(section: Section) -> str:
    parts = [f"<section><h2>{escape(section.title)}</h2>"]
    for item in section.content:
        if isinstance(item, str):
            parts.append(f"<p>{escape(item)}</p>")
        elif isinstance(item, Table):
            parts.append(f"<h4>{escape(item.title)}</h4>")
            parts.append(table("", item.head, item.rows, numbers=item.right))
            parts.append(f'<p class="quiet">{escape(item.note)}</p>' if item.note else "")
        else:
            parts.append(figure(item))
    return "".join(parts) + "</section>"


def _said(study: Study) -> dict[str, Any]:
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
        "box": vars(study.box),
        "assumed": [list(row) for row in (*study.assumed, *_assumed_in_toml(study))],
        "version": version("robot-workbench"),
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
