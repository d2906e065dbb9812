"""A study's tables as CSV and LaTeX and its figures as SVG, one file each, by their numbers on the page."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from .study import Study, Table

PLAIN = str.maketrans({"−": "-", "\u202f": "", "–": "", "µ": "u"})
LATEX = {
    **{mark: f"\\{mark}" for mark in "&%$#_{}"},
    **{"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"},
    **{"−": "$-$", "±": r"$\pm$", "·": r"$\cdot$", "→": r"$\to$", "×": r"$\times$", "…": r"\ldots{}"},
    **{
        "∞": r"$\infty$",
        "χ": r"$\chi$",
        "σ": r"$\sigma$",
        "θ": r"$\theta$",
        "µ": r"\textmu{}",
        "°": r"\textdegree{}",
    },
    **{"≥": r"$\ge$", "≤": r"$\le$", "≈": r"$\approx$", "√": r"$\surd$", "\u202f": r"\,", "–": "--"},
    **{mark: f"$^{digit}$" for mark, digit in zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True)},
    **{mark: f"$_{digit}$" for mark, digit in zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True)},
}


def exported(study: Study) -> dict[str, str]:
    """File name → text: `tables/table_1.csv` and `.tex`, `figures/figure_1.svg`, and so on."""
    files = {}
    for number, table in enumerate(study.tables, start=1):
        files[f"tables/table_{number}.csv"] = csv_text(table)
        files[f"tables/table_{number}.tex"] = latex_text(table)
    for number, figure in enumerate(study.figures, start=1):
        files[f"figures/figure_{number}.svg"] = figure.svg
    return files


def csv_text(table: Table) -> str:
    """Head and rows as shown, with plain signs and without spaces between thousands."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerows([cell.translate(PLAIN) for cell in row] for row in (table.head, *table.rows))
    return text.getvalue()


def latex_text(table: Table) -> str:
    """A floating table with caption and note; needs the packages booktabs and textcomp."""
    columns = "".join("r" if i in table.right else "l" for i in range(len(table.head)))
    lines = [
        r"\begin{table}",
        rf"\caption{{{_latex(table.title)}}}",
        rf"\begin{{tabular}}{{{columns}}}",
        r"\toprule",
        _row(table.head),
        r"\midrule",
        *(_row(row) for row in table.rows),
        r"\bottomrule",
        r"\end{tabular}",
        *([rf"\par\smallskip {_latex(table.note)}"] if table.note else []),
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _row(cells: Sequence[str]) -> str:
    return " & ".join(map(_latex, cells)) + r" \\"


def _latex(text: str) -> str:
    return "".join(LATEX.get(letter, letter) for letter in text)
