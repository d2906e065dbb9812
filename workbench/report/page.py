"""The page: one self-contained HTML file, verdict first. It needs no network and no script."""

from __future__ import annotations

from .content import Material
from .markup import render


def page(material: Material) -> str:
    """The whole page as text."""
    return render("diagnosis.html", **material.said, figures=material.figures, equations=material.equations)
