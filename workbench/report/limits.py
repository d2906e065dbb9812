"""What a campaign cannot say: causes not tested, sizes too small to show, geometry not told apart."""

from __future__ import annotations

import math

from ..diagnosis.found import Finding
from ..diagnosis.result import Diagnosis
from ..effects.place import Where
from .numbers import size, words

IMPOSSIBLE = {"rad": 0.1, "m": 0.1, "1": 1.0, "": 1.0, "rad/(N·m)": 1e-3, "1/(N·m²)": 1e-2}


def place(where: Where, slides: bool = False) -> str:
    """Where a cause sits, in words: `joint_6 with joint_5`, `joint_4 at 200 cycles per turn`, or where that
    slides `rail every 209 mm`."""
    parts = [where.joint or where.link or where.payload or ""]
    if where.other:
        parts.append(f"with {where.other}")
    if where.order is not None:
        turns = f"at {where.order:.6g} cycles per turn"
        parts.append(f"every {2e3 * math.pi / where.order:.4g} mm" if slides else turns)
    return " ".join(part for part in parts if part)


def place_of(finding: Finding) -> str:
    """Where a finding sits, in words; it slides where its first number is in m."""
    return place(finding.where, any(one.unit == "m" for one in finding.parameters[:1]))


def not_testable(diagnosis: Diagnosis) -> list[list[str]]:
    """One row per cause and reason; the places that share them stand together."""
    places: dict[tuple[str, str], list[str]] = {}
    for item in diagnosis.not_testable:
        places.setdefault((words(item.cause), item.why), []).append(place(item.where))
    return [[cause, ", ".join(filter(None, where)), why] for (cause, why), where in places.items()]


def detectable(diagnosis: Diagnosis) -> list[list[str]]:
    """One row per cause: the smallest size at each place, and where no possible size would show."""
    seen: dict[str, list[str]] = {}
    unseen: dict[str, list[str]] = {}
    placed = {item.cause for item in diagnosis.detectable if place(item.where)}
    for item in diagnosis.detectable:
        cause = words(item.cause)
        where = place(item.where.any_order) or ("all alike" if item.cause in placed else "")
        seen.setdefault(cause, [])
        if not item.size < IMPOSSIBLE.get(item.unit, math.inf):
            unseen.setdefault(cause, []).append(where)
            continue
        whole = size(item.size, item.unit, item.name).replace(" ", "\u00a0")  # on one line
        seen[cause].append(f"{where} {whole}".strip())
    for cause, places in unseen.items():
        seen[cause].append("at no size: " + ", ".join(filter(None, places)) if any(places) else "at no size")
    return [[cause, " · ".join(sizes)] for cause, sizes in seen.items()]


def unidentifiable(diagnosis: Diagnosis) -> list[str]:
    """As said; `frame/parameter` grouped by frame, the frames in one line."""
    frames: dict[str, list[str]] = {}
    for item in diagnosis.unidentifiable:
        frame, slash, name = item.removeprefix("geometry/").partition("/")
        plain = slash and " " not in item
        frames.setdefault(frame if plain else item, []).extend([name] if plain else [])
    grouped = " · ".join(f"{frame} {', '.join(names)}" for frame, names in frames.items() if names)
    return ([grouped] if grouped else []) + [said for said, names in frames.items() if not names]
