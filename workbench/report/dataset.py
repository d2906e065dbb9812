"""What was measured, as rows of a table."""

from __future__ import annotations

from ..diagnosis.result import Diagnosis
from .numbers import mm

SUPPORT = "95 %, plus and minus 1.96 standard deviations (normal)"
SOURCES = {
    "stated": "stated in the campaign",
    "repeats": "measured",
    "residual": "from the residual",
}
RANGE = "Range of "  # begins a fact of one joint


def facts(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """The dataset in figures; what the diagnosis says itself comes after the counts."""
    noise = diagnosis.noise
    facts = [
        ("Robot", f"{diagnosis.robot_title} ({diagnosis.robot})"),
        ("Campaign", diagnosis.campaign),
        ("Measured", f"{diagnosis.n_poses} poses, {diagnosis.n_points} points"),
        ("Noise, one sigma", noise.sentence or f"{mm(noise.sigma_mm)} mm per axis, {SOURCES[noise.source]}"),
    ]
    if noise.repeatability_mm is not None:
        facts.append(("Repeatability", f"{mm(noise.repeatability_mm)} mm per axis, one sigma"))
    ranges = [
        f"{name.removeprefix(RANGE)} {value}"
        for name, value in diagnosis.facts.items()
        if name.startswith(RANGE)
    ]
    one_row = ("Ranges", " · ".join(ranges))  # where the first of them stands
    more = dict(
        one_row if name.startswith(RANGE) else (name, value)
        for name, value in diagnosis.facts.items()
        if name not in ("Poses", "Points")
    )
    return [*facts, *more.items(), ("Intervals", SUPPORT)]
