"""The study's page: rates, figures, and every case that went wrong, with the key that repeats it."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ...report.drawing import Figure
from .score import Record

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b2430; max-width: 62rem; margin: 2rem auto;
  padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.1rem; margin: 2rem 0 .3rem }
pre, td { font-size: 12px } pre { background: #f5f6f8; padding: .8rem; overflow-x: auto }
svg { max-width: 100%; height: auto }
table { border-collapse: collapse } td { padding: .1rem .8rem .1rem 0; vertical-align: top }
"""


def page(title: str, text: str, figures: Sequence[Figure], misses: Sequence[Record]) -> str:
    """The whole page."""
    parts = [f"<h1>{escape(title)}</h1>", f"<pre>{escape(text)}</pre>"]
    for figure in figures:
        svg = figure.svg[figure.svg.index("<svg") :]
        parts.append(
            f'<h2>{escape(figure.title)}</h2><div role="img" aria-label="{escape(figure.alt)}">{svg}</div>'
        )
    rows = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in miss_cells(m))}</tr>" for m in misses
    )
    parts.append(f"<h2>Cases that are not as they should be: {len(misses)}</h2><table>{rows}</table>")
    head = f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
    return f"{head}<style>{STYLE}</style></head><body>\n" + "\n".join(parts) + "\n</body></html>\n"


def miss_cells(case: Record) -> tuple[str, str, str, str]:
    """Key, set-up, truth and what was said. [λ x]: of the truth, that a cause alone would leave."""
    setup = (
        f"{case['robot']} {case['records']}×{case['targets']} {case['noise']} "
        f"{1e3 * case['sigma_mm']:.0f} µm{', two loads' if case['loads'] > 1 else ''}"
    )
    truth = " + ".join(f"{t['label']} λ {t['strength']:.0f}" for t in case["truths"]) or "nothing"
    if case["form_left"] is not None and case["unknown_mm"] is None:
        truth += f" (form leaves {case['form_left']:.1f})"
    said = "; ".join(_said(f) for f in case["found"]) or "nothing"
    faults = f" FAULTS {', '.join(case['faults'])}" if case["faults"] else ""
    return str(case["key"]), setup, truth, f"{case['verdict']}: {said}{faults}"


def _said(finding: Record) -> str:
    text = f"{finding['label']} {finding['status']}"
    if "left" in finding:
        text += f" [{finding['left']:.1f}]"
    if finding["rivals"]:
        text += f" or {', '.join(finding['rivals'])}"
    return text
