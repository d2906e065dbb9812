"""Equations (Typst mathematics) as pictures for the page, and which of them are mathematics at all."""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path

SIZE = 12  # points
TEMPLATE = """#set page(width: auto, height: auto, margin: 1pt, fill: none)
#set text(size: 12pt)
#let lines = json("lines.json")
#for (number, line) in lines.enumerate() {
  if number > 0 { pagebreak() }
  math.equation(block: true, eval(line, mode: "math", scope: (sgn: math.op("sgn"), sign: math.op("sign"))))
}
"""


def typeset(equations: Sequence[str]) -> dict[str, str]:
    """Equation → SVG, in the colour of the text around it. What is not Typst maths is left out."""
    lines = [line for line in dict.fromkeys(equations) if line.strip()]
    if not lines:
        return {}
    drawn = _compile(lines)
    if drawn is not None:
        return dict(zip(lines, drawn, strict=True))
    singly = ((line, _compile([line])) for line in lines)
    return {line: svg[0] for line, svg in singly if svg}


def _compile(lines: Sequence[str]) -> list[str] | None:
    """One SVG per line; None when one of them does not compile."""
    import typst

    with tempfile.TemporaryDirectory(prefix="equations") as room:
        source = Path(room) / "equations.typ"
        source.write_text(TEMPLATE, encoding="utf-8")
        (Path(room) / "lines.json").write_text(json.dumps(list(lines)), encoding="utf-8")
        try:
            made = typst.compile(str(source), root=room, format="svg", ignore_system_fonts=True, timestamp=0)
        except typst.TypstError:
            return None
    pages = [page.decode() for page in (made if isinstance(made, list) else [made]) if page is not None]
    if len(pages) != len(lines):
        return None
    return [_in_line(page) for page in pages]


def _in_line(svg: str) -> str:
    """The SVG without its header, in the colour and size of the text around it, ids of its own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r' xmlns:h5="[^"]*"', "", svg)
    svg = svg.replace('fill="#000000"', 'fill="currentColor"')
    svg = re.sub(
        r'(width|height)="([\d.]+)pt"', lambda m: f'{m[1]}="{float(m[2]) / SIZE:.3f}em"', svg, count=2
    )
    own = hashlib.sha256(svg.encode()).hexdigest()[:8]
    return re.sub(r'(id="|href="#)', rf"\g<1>e{own}-", svg)
