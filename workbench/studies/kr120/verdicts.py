"""Diagnoses side by side."""

from __future__ import annotations

from collections.abc import Mapping

from workbench import Outcome, Table, numbers

LEAKING = "gravity_compensator"


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


def tells_apart(found: Mapping[str, Outcome]) -> bool:
    """Whether a measurement finds nothing in the machine as modelled, a fault of joint 2 but none of the
    compensator in the soft gear, and the compensator in the leak without joint 2's gear as a rival."""
    gear, leak = _named(found["soft"]), _named(found["leak"])
    nothing = not found["gas"].diagnosis.causes
    soft = any(joint == "joint_2" for _, joint in gear) and all(cause != LEAKING for cause, _ in gear)
    return (
        nothing
        and soft
        and any(cause == LEAKING for cause, _ in leak)
        and all(joint != "joint_2" for _, joint in leak)
    )


def _named(outcome: Outcome) -> set[tuple[str, str | None]]:
    """Causes and their rivals, each with its joint."""
    causes = outcome.diagnosis.causes
    rivals = [rival for cause in causes for rival in cause.rivals]
    return {(c.cause, c.where.joint) for c in causes} | {(r.cause, r.where.joint) for r in rivals}


def deciding(outcomes: Mapping[str, Mapping[str, Outcome]]) -> dict[str, float]:
    """How many measurements were tried, and how many of them tell the machines apart."""
    apart = sum(tells_apart(found) for found in outcomes.values())
    return {"tried": float(len(outcomes)), "deciding": float(apart)}


def verdict_table(
    title: str, columns: Mapping[str, str], outcomes: Mapping[str, Mapping[str, Outcome]]
) -> Table:
    """Verdicts by measurement (rows) and hidden truth (columns: its key → its heading)."""
    rows = [
        [way, *(verdict(found[name]) for name in columns), "yes" if tells_apart(found) else "no"]
        for way, found in outcomes.items()
    ]
    return Table(title, ("Measurement", *columns.values(), "Tells them apart"), rows, numbers=())
