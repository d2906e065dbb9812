"""The printed report: Typst sets `report.typ` from the same text and figures as the page."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

from ..atomic import put
from ..diagnosis import Diagnosis
from .content import Material, gather


def write_pdf(diagnosis: Diagnosis, folder: Path) -> Path:
    """Write `report.pdf` into the folder; its path."""
    path = folder / "report.pdf"
    put(path, pdf(gather(diagnosis)))
    return path


def pdf(material: Material) -> bytes:
    """The report as a PDF; the same bytes for the same material."""
    import typst

    said = {
        **material.said,
        "maths": list(material.equations),
        "figures": {name: {"title": f.title, "alt": f.alt} for name, f in material.figures.items()},
    }
    with tempfile.TemporaryDirectory(prefix="report") as room:
        place = Path(room)
        (place / "data.json").write_text(json.dumps(said, ensure_ascii=False), encoding="utf-8")
        for name, figure in material.figures.items():
            (place / f"{name}.svg").write_text(figure.svg, encoding="utf-8")
        template = shutil.copy(Path(__file__).with_name("report.typ"), place / "report.typ")
        made, warnings = typst.compile_with_warnings(
            str(template), root=room, font_paths=[_figure_fonts()], ignore_system_fonts=True, timestamp=0
        )
    if warnings:
        raise RuntimeError("report.typ: " + "; ".join(warning.message for warning in warnings))
    assert isinstance(made, bytes)
    return made


def _figure_fonts() -> str:
    """Folder of the font that the figures were laid out with: it comes with matplotlib."""
    import matplotlib

    return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf")
