"""What would decide a cause that is open, as page and terminal say it."""

from __future__ import annotations

from ..diagnosis.found import Decision, Finding
from .numbers import significant

LONG = 200  # characters of a command, from which it is folded away


def ways(finding: Finding) -> list[tuple[str, str, bool]]:
    """What would decide, its command, and whether that is folded away: all but the first, and a long one."""
    found = []
    for one in to_decide(finding):
        command = one.command or ""
        folded = bool(command) and (one is not finding.ready or len(command) > LONG)
        found.append((decision(one), command, folded))
    return found


def to_decide(finding: Finding) -> list[Decision]:
    """What would decide, beyond what the advice says in the same words."""
    return [one for one in finding.decide if one.command or decision(one) not in (finding.separate_by or "")]


def decision(one: Decision) -> str:
    """What would decide, with λ before and after, where that is another."""
    if one.lambda_after is None:
        return one.words
    before, after = (significant(float(f"{value:.2g}"), 2) for value in (one.lambda_before, one.lambda_after))
    return one.words if before == after else f"{one.words} (λ {before} → {after})"
