"""A study's words, from a Markdown file beside its script: the script computes, the story tells.

    # Title: headline in one sentence
    Source of the paper, one line.

    Summary, with numbers as {noise_needed_mm:mm}.

    - Label of a tile | before | after | unit | note

    ## A section
    Paragraphs, and lines like [[stiffness]] where a table or figure of that name stands, a figure with how
    it was made: [[stiffness: KUKA KR 500, {draws:.0} draws.]] Or a table:

    **Its title**
    | Joint | Printed | Ours |
    |---|---:|---:|
    | joint 1 | 780 000 | {stiffness_1:4} |
    *Its note.*

    ## Box
    ### What the paper concludes ... ### What its numbers support ... ### What we would measure next

    ## Assumed
    - what | value | why

    ## References
    - authors | title | where and when | DOI, or another number

What may be said depends on what was found: `[if NAME] sentence [else] other sentence [end]`, anywhere, also
in a heading or a cell ([else] may be left out), with NAME one of `claims`; `[if not NAME]` the other way
round. `{share_NAME:%0}` is the share of draws it holds in. A paragraph that comes out empty is not there.

Numbers come by name from the script, `{name:form}` with form: mm (a length in mm), % or %2 (a share in
per cent, with so many decimals), .1 (decimals), 3 (significant digits), p (`p = 0.03`), P (a probability in
per cent, never 0 or 100).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..robot.description import Robot
from .drawing import Figure
from .numbers import decimals, mm, p_value, percent, probability, significant
from .scene import Shown
from .study import BOX_TITLES, Box, Section, Stand, Study, Table, Tile

Item = Table | Figure
LISTS = ("Box", "Assumed", "References")
ITEM = re.compile(r"\[\[([^:\]]+)(?::\s*(.+))?\]\]")
CHOICE = re.compile(r"\[if (not )?(\w+)\](.*?)(?:\[else\](.*?))?\[end\]", re.DOTALL)


class _Number(float):
    """A number that knows how to be written."""

    def __format__(self, form: str) -> str:
        value = float(self)
        if form == "mm":
            return mm(value)
        if form == "p":
            return p_value(value)
        if form == "P":
            return probability(value)
        if form.startswith("%"):
            return percent(value, int(form[1:] or 1))
        if form.startswith("."):
            return decimals(value, int(form[1:]))
        return significant(value, int(form or 3))


@dataclass
class _Part:
    """What stands under one heading: paragraphs, items, and the cells of lines that begin with a dash."""

    title: str
    content: list[str | Item] = field(default_factory=list)
    lines: list[list[str]] = field(default_factory=list)

    @property
    def words(self) -> list[str]:
        return [piece for piece in self.content if isinstance(piece, str)]


def tell(
    story: Path,
    robot: Robot,
    numbers: Mapping[str, float],
    items: Mapping[str, Item],
    shown: Shown,
    picture: str,
    files: Mapping[str, str] | None = None,
    claims: Mapping[str, Stand] | None = None,
) -> Study:
    """The study that `story` (a Markdown file as above) tells with these numbers, tables and figures.

    picture: the item that stands for the study in the list of studies; claims: what the story may say (it has
    to ask for each). Raises ValueError where the story asks for what is not there, or leaves out a table,
    figure or claim that is.
    """
    said = claims or {}
    shares = {f"share_{name}": stand.share for name, stand in said.items()}
    parts = _parts(story, _chosen(story, _filled(story, {**numbers, **shares}), said), items)
    first, *others = parts
    title, _, headline = first.title.partition(": ")
    source, *summary = first.words
    by_title = {part.title: part for part in others}
    box = {key: by_title[name] for key, name in BOX_TITLES.items()}
    plain = [part for part in others if part not in box.values() and part.title not in LISTS]
    chosen = items[picture]
    if not isinstance(chosen, Figure):
        raise ValueError(f"{picture} is no figure")
    return Study(
        name=story.resolve().parent.name,
        robot=robot,
        title=title,
        source=source,
        headline=headline,
        summary=" ".join(summary),
        tiles=[Tile(*(cells + [""] * (5 - len(cells)))) for cells in first.lines],
        sections=[Section(part.title, part.content) for part in plain],
        box=Box(**{key: " ".join(part.words) for key, part in box.items()}),
        assumed=[(what, value, why) for what, value, why in _lines(by_title, "Assumed")],
        numbers=numbers,
        shown=shown,
        picture=chosen,
        files=files or {},
        claims=said,
        references=[(who, title, where, doi) for who, title, where, doi in _lines(by_title, "References")],
    )


def _lines(parts: Mapping[str, _Part], title: str) -> list[list[str]]:
    return parts[title].lines if title in parts else []


def _filled(story: Path, numbers: Mapping[str, float]) -> str:
    """The story's text with its numbers in place."""
    try:
        return story.read_text(encoding="utf-8").format_map({k: _Number(v) for k, v in numbers.items()})
    except KeyError as error:
        raise ValueError(f"{story.name}: there is no number {error}") from None


def _chosen(story: Path, text: str, claims: Mapping[str, Stand]) -> str:
    """The text with what each claim allows to be said."""

    def said(found: re.Match[str]) -> str:
        if found[2] not in claims:
            raise ValueError(f"{story.name}: there is no claim {found[2]!r}")
        asked.add(found[2])
        holds = claims[found[2]].stands is not bool(found[1])
        return (found[3] if holds else found[4] or "").strip()

    asked: set[str] = set()
    text = CHOICE.sub(said, text)
    if left := re.search(r"\[(if|else|end)\b[^]]*\]", text):
        raise ValueError(
            f"{story.name}: {left[0]} has no beginning or no end, or stands within another choice"
        )
    if missing := [name for name in claims if name not in asked]:
        raise ValueError(f"{story.name} does not ask for {', '.join(missing)}")
    return text


def _parts(story: Path, text: str, items: Mapping[str, Item]) -> list[_Part]:
    """The story by its headings, of any level."""
    parts: list[_Part] = []
    told: list[str] = []
    for block in filter(str.strip, re.split(r"\n\s*\n", text)):
        for piece in _pieces(block):
            if piece.startswith("#"):
                parts.append(_Part(piece.lstrip("# ")))
            elif found := ITEM.fullmatch(piece):
                told.append(found[1])
                parts[-1].content.append(_item(story, found[1], found[2] or "", items))
            elif piece.startswith("- "):
                parts[-1].lines.append([cell.strip() for cell in piece[2:].split("|")])
            elif "\n|" in piece:
                parts[-1].content.append(_table(piece))
            else:
                parts[-1].content.append(re.sub(r"[ \n]+", " ", piece).strip())
    if missing := [name for name in items if name not in told]:
        raise ValueError(f"{story.name} leaves out {', '.join(missing)}")
    return parts


def _item(story: Path, name: str, made: str, items: Mapping[str, Item]) -> Item:
    """A table or figure by name, the figure with how it was made."""
    if name not in items:
        raise ValueError(f"{story.name}: there is no table or figure {name!r}")
    item = items[name]
    if not made:
        return item
    if isinstance(item, Table):
        raise ValueError(f"{story.name}: {name} is a table, which has its own note")
    return replace(item, note=made)


def _pieces(block: str) -> list[str]:
    """A block's headings, items and dashed lines one by one; the rest of it together."""
    pieces: list[str] = []
    together = False
    for line in block.strip().splitlines():
        alone = line.startswith(("#", "- ")) or ITEM.fullmatch(line.strip()) is not None
        if together and not alone:
            pieces[-1] += f"\n{line}"
        else:
            pieces.append(line.strip() if alone else line)
        together = not alone
    return pieces


def _table(piece: str) -> Table:
    """A table from its title, rows and note."""
    lines = piece.splitlines()
    cells = [
        [cell.strip() for cell in line.strip()[1:-1].split("|")] for line in lines if line.startswith("|")
    ]
    title = " ".join(line.strip("*") for line in lines if line.startswith("**"))
    after = lines[max(i for i, line in enumerate(lines) if line.startswith("|")) + 1 :]
    head, rule, *body = cells
    right = [i for i, mark in enumerate(rule) if mark.endswith(":")]
    return Table(title, head, body, " ".join(after).strip("* "), right)
