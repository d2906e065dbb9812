"""Printed reports: Typst sets a template from the same text and figures as the page."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .content import Material
from .drawing import Figure
from .legible import legible
from .markup import TEMPLATES


def pdf(material: Material) -> bytes:
    """The report of a diagnosis; the same bytes for the same material."""
    said = {**material.said, "maths": list(material.equations)}
    return typeset("report.typ", said, material.figures)


def typeset(template: str, said: Mapping[str, Any], figures: Mapping[str, Figure]) -> bytes:
    """A PDF from a template of this folder, which finds its text in `data.json` and figures by name."""
    import typst

    shown = {name: {"title": f.title, "alt": f.alt, "note": f.note} for name, f in figures.items()}
    with tempfile.TemporaryDirectory(prefix="report") as room:
        place = Path(room)
        text = json.dumps(legible({**said, "figures": shown}), ensure_ascii=False)
        (place / "data.json").write_text(text, encoding="utf-8")
        for name, figure in figures.items():
            (place / f"{name}.svg").write_text(figure.svg, encoding="utf-8")
        for file in (template, "style.typ"):
            shutil.copy(TEMPLATES / file, place / file)
        made, warnings = typst.compile_with_warnings(
            str(place / template),
            root=room,
            font_paths=[_figure_fonts()],
            ignore_system_fonts=True,
            timestamp=0,
        )
    if warnings:
        raise RuntimeError(f"{template}: " + "; ".join(warning.message for warning in warnings))
    assert isinstance(made, bytes)
    return made


def _figure_fonts() -> str:
    """Folder of the font that the figures were laid out with: it comes with matplotlib."""
    import matplotlib

    return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf")
