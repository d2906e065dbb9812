"""Diagnoses side by side."""

from __future__ import annotations

from collections.abc import Mapping

from workbench import Outcome, Table, numbers


def verdict(outcome: Outcome) -> str:
    """Verdict, causes and their rivals in one line."""
    said = []
    for cause in outcome.diagnosis.causes:
        others = ", ".join(f"{r.cause} {r.where}".strip() for r in cause.rivals)
        rivals = f", or {others}" if others else ""
        said.append(
            f"{cause.cause} {cause.where}".strip() + f" ({numbers.percent(cause.probability)}{rivals})"
        )
    found = outcome.diagnosis.verdict
    return (f"{found}: {'; '.join(said)}" if said else found).replace("_", " ")


def verdict_table(
    title: str, columns: Mapping[str, str], outcomes: Mapping[str, Mapping[str, Outcome]]
) -> Table:
    """Verdicts by measurement (rows) and hidden truth (columns: its key → its heading)."""
    rows = [[way, *(verdict(found[name]) for name in columns)] for way, found in outcomes.items()]
    return Table(title, ("Measurement", *columns.values()), rows, numbers=())
