"""A study's result: what page, PDF, scene and list of studies are set from.

A study tells a published paper again: sections with text, tables and figures in the paper's order, our
numbers beside the printed ones, and a box with what its numbers support. Its script
(`studies/NAME/study.py`) gives numbers, tables and figures; its words stand beside it in `story.md`: see
`story.tell`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any

from ..robot.description import Robot
from .drawing import Figure
from .scene import Shown as Shown


@dataclass(frozen=True)
class Table:
    """Rows of ready text under `head`; the first column names the row. title: what the table is; note:
    how it was measured. Columns in `numbers` are set to the right (None: all but the first)."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    numbers: Sequence[int] | None = None

    def __post_init__(self) -> None:
        if any(len(row) != len(self.head) for row in self.rows):
            raise ValueError(f"{self.title}: a row has not as many cells as the head")

    @property
    def right(self) -> tuple[int, ...]:
        """Columns that are set to the right."""
        return tuple(range(1, len(self.head)) if self.numbers is None else self.numbers)


@dataclass(frozen=True)
class Section:
    """One step of the study: paragraphs, tables and figures in their order."""

    title: str
    content: Sequence[str | Table | Figure]


@dataclass(frozen=True)
class Tile:
    """A big figure: from `before` to `after` (or `before` empty: one number)."""

    label: str
    before: str
    after: str
    unit: str
    note: str = ""


LEAST = 0.9  # of the draws a sentence has to hold in
FEWEST = 5  # draws that a sentence about draws is said from


@dataclass(frozen=True)
class Stand:
    """How a claim stands. words: the claim in short; share: of the draws it holds in (of the run itself,
    without draws); draws: how many; here: whether it holds in the run that the page shows."""

    words: str
    share: float
    draws: int
    here: bool

    @property
    def stands(self) -> bool:
        """May be said: it holds here, and in nine of ten draws, which are not too few to say so."""
        return self.here and self.share >= LEAST and not 0 < self.draws < FEWEST


BOX_TITLES = {
    "concludes": "What the paper concludes",
    "supports": "What its numbers support",
    "next": "What we would measure next",
}


@dataclass(frozen=True)
class Box:
    """The end of a study, a paragraph each."""

    concludes: str
    supports: str
    next: str


@dataclass(frozen=True)
class Study:
    """What a study found.

    name: of its folder and command; source: the paper in one line; headline: the verdict in one sentence;
    summary: a short paragraph. assumed: (what, value, why) that the paper does not give, beyond what the
    robot's TOML marks. numbers: the headline figures by name, SI or with the unit in the name. picture:
    the figure that stands for it in the list of studies. files: name → link of what else the study wrote
    into its folder. claims: what its sentences hang on.
    references: (authors, title, where and when, DOI or number). sealed: campaign → what was hidden in it.
    """

    name: str
    robot: Robot
    title: str
    source: str
    headline: str
    summary: str
    tiles: Sequence[Tile]
    sections: Sequence[Section]
    box: Box
    assumed: Sequence[tuple[str, str, str]]
    numbers: Mapping[str, float]
    shown: Shown
    picture: Figure
    files: Mapping[str, str] = field(default_factory=dict)
    claims: Mapping[str, Stand] = field(default_factory=dict)
    references: Sequence[tuple[str, str, str, str]] = ()
    sealed: Mapping[str, Any] = field(default_factory=dict)

    @property
    def tables(self) -> list[Table]:
        """All tables, in order."""
        return [item for section in self.sections for item in section.content if isinstance(item, Table)]

    @property
    def figures(self) -> list[Figure]:
        """All figures, in order."""
        return [item for section in self.sections for item in section.content if isinstance(item, Figure)]

    def to_json(self) -> dict[str, Any]:
        """Numbers (those that are finite), tables, claims and box."""
        return {
            "schema": 1,
            "study": self.name,
            "robot": self.robot.name,
            "source": self.source,
            "headline": self.headline,
            "numbers": {key: float(v) for key, v in self.numbers.items() if math.isfinite(v)},
            "tables": [
                {"title": t.title, "head": list(t.head), "rows": [list(row) for row in t.rows]}
                for t in self.tables
            ],
            "claims": {key: {**vars(c), "stands": c.stands} for key, c in self.claims.items()},
            "box": vars(self.box),
        }

    @property
    def text(self) -> str:
        """The result for a terminal; all numbers stand in result.json."""
        lines = [
            f"{self.title}: {self.headline}",
            "",
            *wrap(self.summary, 100, initial_indent="  ", subsequent_indent="  "),
            "",
        ]
        width = max((len(tile.label) for tile in self.tiles), default=0)
        for tile in self.tiles:
            change = f"{tile.before} → {tile.after}" if tile.before else tile.after
            note = f"   ({tile.note})" if tile.note else ""
            lines.append(f"  {tile.label:<{width}}   {change} {tile.unit}".rstrip() + note)
        return "\n".join(lines)
