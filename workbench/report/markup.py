"""Pages from the templates beside this file. Every text is escaped there; what is not, is made here and is
markup of our own: drawn figures and equations."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from . import drawing
from .drawing import Figure
from .legible import legible

TEMPLATES = Path(__file__).with_name("templates")
VARIABLES = {
    drawing.INK: "--ink",
    drawing.MUTED: "--muted",
    drawing.GRID: "--line",
    drawing.BEFORE: "--before",
    drawing.MIDDLE: "--middle",
    drawing.AFTER: "--after",
    drawing.MODEL: "--curve",
    drawing.NOISE: "--noise",
}


def render(template: str, **said: Any) -> str:
    """A template of `templates/` with what it says. A name that it asks for and that is missing raises."""
    return _environment().get_template(template).render(said)


@cache
def _environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=lambda value: legible(value) if type(value) is str else value,
    )
    made.filters |= {"svg": in_page, "labelled": labelled, "used_columns": used_columns, "cells": cells}
    return made


def in_page(drawn: Figure) -> Markup:
    """A figure's SVG in line, in the page's colours, its ids made its own."""
    svg = drawn.svg[drawn.svg.index("<svg") :]
    svg = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' id="[^"#]*_\d+"', "", svg)
    svg = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{drawn.name}-", svg)
    svg = re.sub(r' (width|height)="[\d.]+pt"', "", svg, count=2)
    for colour, variable in VARIABLES.items():
        svg = svg.replace(colour, f"var({variable})")
    return labelled(svg, drawn.alt)


def labelled(svg: str, label: str) -> Markup:
    """An SVG that was drawn here, as an image that says what it shows."""
    opened = Markup('<svg role="img" aria-label="{}" ').format(legible(label))
    return opened + Markup(svg.removeprefix("<svg "))


def used_columns(rows: Sequence[Sequence[str]], head: Sequence[str]) -> list[int]:
    """Columns of a table that are not empty throughout; the first one always."""
    return [i for i in range(len(head)) if i == 0 or any(row[i] for row in rows)]


def cells(records: Sequence[Mapping[str, str]], *names: str) -> list[list[str]]:
    """Records as the rows of a table."""
    return [[record[name] for name in names] for record in records]
