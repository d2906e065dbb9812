"""The verdict in words: its headline, and remarks on what is left and on the noise."""

from __future__ import annotations

from collections.abc import Sequence

from .prepared import Prepared
from .remainder import GLOBAL_LEVEL, Remainder
from .result import Finding, Stage, Verdict

SMALL_REST = 0.1  # of what the causes brought: a smaller rest without a name does not decide the verdict


def verdict_of(findings: Sequence[Finding], nameless: Sequence[Finding], stages: Sequence[Stage]) -> Verdict:
    """The one word for all findings: unknown where what has no name is worth more than a share of what the
    causes brought."""
    brought = stages[1].heldout_rms_mm - stages[-1].heldout_rms_mm
    if nameless and (not findings or nameless[0].gain_mm > SMALL_REST * max(brought, 0.0)):
        return "unknown"
    if not findings:
        return "nothing_missing"
    return "named" if all(f.status == "named" for f in findings) else "ambiguous"


def headline(verdict: Verdict, findings: Sequence[Finding], stages: Sequence[Stage]) -> str:
    """The verdict in one line; the numbers follow after the first full stop."""
    found = [f for f in findings if f.cause != "unknown"]
    named = [
        f"{f.cause.replace('_', ' ')} in {f.where}" if str(f.where) else f.cause.replace("_", " ")
        for f in found
    ]
    listed = ", ".join(named[:4]) + (f" and {len(named) - 4} more" if len(named) > 4 else "")
    gain = (
        f"Held-out error {stages[0].heldout_rms_mm:.3f} → {stages[-1].heldout_rms_mm:.3f} mm RMS, "
        f"{stages[1].heldout_rms_mm:.3f} mm with geometry alone."
    )
    if verdict == "nothing_missing" and stages[1].heldout_rms_mm > stages[0].heldout_rms_mm:
        return f"Too few poses to say: fitted to them, the robot is worse at others. {gain}"
    if verdict == "nothing_missing":
        return f"Nothing is missing: geometry explains these data. {gain}"
    if verdict == "unknown":
        also = f" Found on the way: {listed}." if named else ""
        return f"Something is left that no known cause explains.{also} {gain}"
    if verdict == "ambiguous":
        return f"Found: {listed}; for some of it other explanations fit as well. {gain}"
    return f"Found: {listed}. {gain}"


def remarks(prepared: Prepared, left: Remainder, structured: bool) -> list[str]:
    """What a reader should know of the noise besides."""
    notes = []
    if prepared.noise_known and not structured and left.p < GLOBAL_LEVEL:
        word = "larger" if left.inflation > 1 else "smaller"
        notes.append(
            f"The residual is {abs(left.inflation - 1):.0%} {word} than the noise says, without any "
            "structure: check the stated noise, or repeat ten poses five times."
        )
    if not prepared.noise_known:
        notes.append(prepared.noise.sentence)
    return notes
