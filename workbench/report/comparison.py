"""The page, the report and the terminal's lines of a comparison of campaigns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ..diagnosis.changes.elsewhere import as_stated
from ..diagnosis.changes.found import BACK, CREEP, STEP, Apart, Change, TargetMoved, Track, Unchanged
from ..diagnosis.changes.result import Comparison
from ..diagnosis.changes.words import hidden_size, tells, with_std
from ..diagnosis.telling.headline import listed
from ..effects import catalogue
from ..effects.place import Parameter
from . import charts
from .drawing import Figure
from .folder import json_bytes, write_together
from .markup import render
from .numbers import axis_scale, mm, percent, probability, quantity, size, words
from .numbers import scale as unit_scale

LISTED = 12  # of what did not change, on the terminal
TRACKS = 4  # curves of one chart
UNSURE = "its uncertainty is more than the nominal robot's error"
NOT_TOLD = "looks exactly like a change of"


def write_comparison(comparison: Comparison, folder: Path) -> None:
    """Writes `index.html`, `report.pdf` and `comparison.json`, after all of them are made."""
    from .pdf import typeset

    said, figures = said_of(comparison), {f.name: f for f in chart(comparison.chart, comparison.campaigns)}
    made = {
        "index.html": render("comparison.html", **said, figures=figures).encode(),
        "report.pdf": typeset("comparison.typ", said, figures),
        "comparison.json": json_bytes(comparison.to_json()),
    }
    write_together(folder, made)


def short_comparison(comparison: Comparison, folder: Path | None) -> str:
    """For a terminal: verdict, changes, what is not the robot."""
    labels = ", ".join(
        f"{label} ({n} poses)" for label, n in zip(comparison.campaigns, comparison.n_poses, strict=True)
    )
    said = said_of(comparison)
    lines = [f"{comparison.title}: {labels}", "", comparison.headline]
    for change in said["changes"]:
        lines += ["", f"  {change['status'].upper():<10}{change['what']}   {change['when']}"]
        lines += [f"            {row[0]} {row[1]} ({row[2]})" for row in change["parameters"]]
        lines += [f"            {line}" for line in change["lines"]]
    lines += ["", "  not the robot:"]
    lines += [f"            {line}" for line in said["apart_lines"]]
    seen = _geometry(comparison)
    lines += ["", "  did not change, and what would have been seen (80 % power):"]
    rows = (_row(u) for u in seen[:LISTED])
    lines += [f"            {what} {by} seen from {least} = {moved}" for what, by, least, moved in rows]
    lines += [f"            and {len(seen) - LISTED} more numbers"] if len(seen) > LISTED else []
    lines += [f"  note: {note}" for note in comparison.notes]
    if folder is not None:
        lines += ["", f"  page: {folder}/index.html   report: {folder}/report.pdf"]
    return "\n".join(lines)


def said_of(comparison: Comparison) -> dict[str, Any]:
    """What the templates read, all of it ready text."""
    apart = _apart(comparison)
    return {
        "title": comparison.title,
        "headline": comparison.headline,
        "clauses": comparison.said.removesuffix(".").split("; "),
        "elsewhere": comparison.elsewhere,
        "verdict": "changed" if comparison.changed else "unchanged",
        "campaigns": [[c, str(n)] for c, n in zip(comparison.campaigns, comparison.n_poses, strict=True)],
        "changes": [_change(change) for change in comparison.changes],
        "within": _within(comparison),
        "unchanged": [_row(u) for u in _geometry(comparison)],
        "causes": [_row(u) for u in comparison.unchanged if u.cause != "geometry"],
        "unseen": [[_in_words(u.label), f"{NOT_TOLD} {_in_words(u.same_as)}"] for u in comparison.unseen],
        "repeats": [
            [_in_words(r.label), r.status, f"within {percent(r.share, 0)} of its size"]
            for r in comparison.repeats
        ],
        "apart": apart,
        "apart_lines": [" · ".join(filter(None, row)) for row in apart],
        "notes": list(comparison.notes),
        "inputs": [list(item) for item in comparison.inputs.items()],
        "version": version("robot-workbench"),
    }


def _within(comparison: Comparison) -> str:
    """What else may have changed of the geometry, in a sentence."""
    where = "in the poses of all campaigns, frame and targets fitted anew"
    if comparison.bounded:
        return (
            "All other changes of geometry together move the targets by less than "
            f"{mm(comparison.within_mm)} mm RMS (95 %) {where}."
        )
    size = hidden_size(comparison.within_mm, comparison.nominal_mm)
    return f"Other changes of geometry {size}, {where}, could not have been seen."


def _geometry(comparison: Comparison) -> list[Unchanged]:
    """The robot's numbers of geometry that did not change."""
    return [u for u in comparison.unchanged if u.side == "robot" and u.cause == "geometry"]


def _change(change: Change) -> dict[str, Any]:
    lines = [f"moves the targets by {mm(change.moves_mm)} mm RMS, the instrument's frame fitted anew"]
    if change.placed:
        lines[0] += f"; probability {probability(change.probability)}"
    if change.before:
        lines += [
            f"{when}: {_each(one)}" for when, one in (("before", change.before), ("after", change.after))
        ]
    ways = [
        f"{_in_words(way.label)}{'' if way.change else ' in all campaigns'} ({probability(way.probability)})"
        for way in change.ways
        if not (change.placed and way is change)
    ]
    if ways:
        lines.append(f"{'or instead' if change.placed else 'it may be'}: {', '.join(ways)}")
    if change.side != "robot" and change.placed:
        lines.append(f"not the robot: {change.side}")
    if change.recheck_poses is not None:
        poses = ", ".join(change.recheck_ids)
        lines.append(f"{change.recheck_poses} poses would show such a change again (80 % power): {poses}")
    else:
        lines.append("no thirty of these poses would show such a change again: measure more targets or loads")
    return {
        "what": _in_words(change.label) if change.placed else "something that cannot be placed",
        "status": change.status,
        "when": _when(change),
        "parameters": [
            [f"{p.name}{at}", str(quantity(p)), quantity(p).interval] for at, p in _numbers(change)
        ],
        "lines": lines,
    }


def _in_words(label: str) -> str:
    """`gear_ratio(joint_2)` as `gear ratio (joint_2)`; another label as it is."""
    cause, bracket, where = label.partition("(")
    if cause not in catalogue():
        return label
    return f"{words(cause)} ({where}" if bracket else words(cause)


def _each(numbers: Sequence[Parameter]) -> str:
    return ", ".join(f"{p.name} {quantity(p)} ({quantity(p).interval})" for p in numbers)


def _when(change: Change) -> str:
    if change.course == BACK:
        return f"in {listed([label for label, _ in change.levels])} only"
    return f"{'evenly ' if change.course == CREEP else ''}since {change.since}"


def _numbers(change: Change) -> Iterator[tuple[str, Parameter]]:
    """Each number that changed, and at which campaign where it is not the same at all since then."""
    if not change.placed:
        return
    if change.course == STEP:
        yield from (("", p) for p in change.parameters)
    else:
        yield from ((f" in {label}", p) for label, numbers in change.levels for p in numbers)


def _row(item: Unchanged) -> list[str]:
    """Number, difference, the least that would have been seen, and how far that moves the targets."""
    unit = item.number.unit
    return [
        _in_words(item.label),
        quantity(item.number).interval,
        size(item.detectable, unit, item.number.name),
        f"{mm(item.detectable_mm)} mm",
    ]


def _apart(comparison: Comparison) -> list[list[str]]:
    """Label, instrument, targets (both against the first campaign), noise and temperature of each."""
    return [
        [
            one.label,
            *(("", "") if one is comparison.apart[0] else _places(one, comparison.nominal_mm)),
            _noise(one),
            "" if one.temperature is None else f"{one.temperature:.1f} °C",
        ]
        for one in comparison.apart
    ]


def _noise(one: Apart) -> str:
    """How much the points scatter, beside what they should where somebody stated or repeats show that."""
    known = {
        "stated": f"stated is {mm(one.sigma_mm)} mm",
        "repeats": f"measured alone is {mm(one.sigma_mm)} mm",
        "residual": "nobody stated a noise",
    }
    scatter = with_std(one.scatter.sigma_mm, one.scatter.std_mm)
    return (
        f"the points scatter {scatter} mm per axis about the model ({known[one.source]}), "
        f"{mm(one.scatter.rms_mm)} mm RMS left"
    )


def _places(one: Apart, nominal_mm: float) -> tuple[str, str]:
    """Where instrument and targets are against the first campaign. nominal_mm: what the nominal robot is
    off."""
    return _instrument(one, nominal_mm), _targets(one, nominal_mm)


def _instrument(one: Apart, nominal_mm: float) -> str:
    if not tells(one.frame_mm, one.frame_std_mm, nominal_mm):
        return f"instrument from base: cannot be told ({UNSURE})"
    return (
        f"instrument from base: {with_std(one.frame_mm, one.frame_std_mm)} mm and "
        f"{with_std(one.frame_mrad, one.frame_std_mrad)} mrad from the first"
    )


def _targets(one: Apart, nominal_mm: float) -> str:
    targets = one.moves
    if not targets.each:
        return "no target in common with the first"
    if not targets.moved:
        widest = max(math.hypot(*t.std_mm) for t in targets.each)
        if not widest < nominal_mm:
            return f"whether the targets moved cannot be told ({UNSURE})"
        stated = any(t.stated_mm is not None for t in targets.each)
        return f"targets where they were{', though stated elsewhere' if stated else ''}"
    said = f", {as_stated(targets.restated)}" if len(targets.restated) == len(targets.moved) else ""
    return f"targets moved{said}: {', '.join(f'{t.target} {_length(t)} mm' for t in targets.each)}"


def _length(target: TargetMoved) -> str:
    """By how much a target moved [mm], with one sigma of that."""
    length = math.hypot(*target.by_mm)
    along = [v / length for v in target.by_mm] if length else (1.0, 0.0, 0.0)
    return with_std(length, math.hypot(*(a * s for a, s in zip(along, target.std_mm, strict=True))))


def chart(tracks: Sequence[Track], labels: Sequence[str]) -> list[Figure]:
    """Control charts: each number against the first campaign, with 95 % intervals."""
    figures = list[Figure]()
    for unit in dict.fromkeys(track.unit for track in tracks):
        own = [track for track in tracks if track.unit == unit]
        for first in range(0, len(own), TRACKS):
            some = own[first : first + TRACKS]
            shown = [v for t in some for v in (*t.values, t.limit)]
            scale = unit_scale(max(map(abs, shown)), unit) if unit == "1" else axis_scale(shown, unit)
            series: Mapping[str, charts.Series] = {
                _in_words(t.label): charts.Series(
                    [scale.factor * v for v in t.values],
                    [scale.factor * (v - 1.96 * s) for v, s in zip(t.values, t.stds, strict=True)],
                    [scale.factor * (v + 1.96 * s) for v, s in zip(t.values, t.stds, strict=True)],
                    style="o-" if len(labels) > 2 else "o",
                )
                for t in some
            }
            names = ", ".join(f"{i}: {label}" for i, label in enumerate(labels, 1))
            figures.append(
                charts.curves(
                    f"chart{len(figures) + 1}",
                    f"{listed(list(series))} against the first campaign, with 95 % intervals",
                    range(1, len(labels) + 1),
                    series,
                    f"campaign ({names})",
                    f"change, {scale.unit}",
                )
            )
    return figures
