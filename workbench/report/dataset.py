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
    more = {name: value for name, value in diagnosis.facts.items() if name not in ("Poses", "Points")}
    ranges = [name for name in more if name.startswith(RANGE)]
    if ranges:  # in one row, where the first of them stands
        said = " · ".join(f"{name.removeprefix(RANGE)} {more[name]}" for name in ranges)
        more = {("Ranges" if name == ranges[0] else name): value for name, value in more.items()
                if name not in ranges[1:]} | {"Ranges": said}  # fmt: skip
    return [*facts, *more.items(), ("Intervals", SUPPORT)]
