"""Parts of a page: the document with its style, figures in the page's colours, tables, lists."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from . import drawing
from .drawing import Figure

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
TOP = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
"""


def document(title: str, body: str) -> str:
    """The whole page as text: one self-contained file."""
    style = (Path(__file__).parent / "templates" / "page.css").read_text(encoding="utf-8")
    head = f"{TOP}<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
    return head + body + "\n</body>\n</html>\n"


def tiles(given: Sequence[Mapping[str, str]]) -> str:
    """Big figures side by side: label, before (or ""), after, unit, note."""
    shown = ""
    for tile in given:
        was = (
            f'<span class="was">{escape(tile["before"])}</span><span class="to"> → </span>'
            if tile["before"]
            else ""
        )
        note = f'<dd class="quiet">{escape(tile["note"])}</dd>' if tile["note"] else ""
        shown += (
            f'<dl class="tile"><dt>{escape(tile["label"])}</dt><dd class="big">{was}'
            f'<span class="now">{escape(tile["after"])}</span> <small>{escape(tile["unit"])}</small></dd>'
            f"{note}</dl>"
        )
    return f'<div class="tiles">{shown}</div>'


def bullets(lines: Sequence[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in lines) + "</ul>"


def table(
    caption: str,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    numbers: Sequence[int] = (),
    values: Sequence[int] = (),
    heads: bool = True,
) -> str:
    """A table with its first column as row headers; columns left empty throughout are dropped."""
    used = [i for i in range(len(head)) if i == 0 or any(row[i] for row in rows)]
    kinds = {**dict.fromkeys(numbers, ' class="number"'), **dict.fromkeys(values, ' class="value"')}
    top = "".join(f'<th scope="col"{kinds.get(i, "")}>{escape(head[i])}</th>' for i in used)
    body = ""
    for row in rows:
        cells = "".join(f"<td{kinds.get(i, '')}>{escape(row[i])}</td>" for i in used[1:])
        body += f'<tr><th scope="row">{escape(row[0])}</th>{cells}</tr>'
    said = f"<caption>{escape(caption)}</caption>" if caption else ""
    thead = f"<thead><tr>{top}</tr></thead>" if heads else ""
    return f'<div class="scroll"><table>{said}{thead}<tbody>{body}</tbody></table></div>'


def figure(drawn: Figure | None) -> str:
    """The SVG in line, in the page's colours, its ids made its own."""
    if drawn is None:
        return ""
    svg = drawn.svg[drawn.svg.index("<svg") :]
    svg = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' id="[^"#]*_\d+"', "", svg)
    svg = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{drawn.name}-", svg)
    svg = re.sub(r' (width|height)="[\d.]+pt"', "", svg, count=2)
    for colour, variable in VARIABLES.items():
        svg = svg.replace(colour, f"var({variable})")
    label = f'<svg role="img" aria-label="{escape(drawn.alt)}" '
    svg = svg.replace("<svg ", label, 1)
    caption = f"<figcaption>{escape(drawn.title)}</figcaption>"
    return f'<figure>{caption}<div class="scroll" tabindex="0">{svg}</div></figure>'
