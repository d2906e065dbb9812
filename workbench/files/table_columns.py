"""Which column of a text table is which: names with units, mappings, and what to do about typing errors."""

from __future__ import annotations

import codecs
import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from .faults import Fault
from .section import Section
from .table_units import NO_UNIT, UNITS, USUAL, Unit


def _known_encoding(name: str) -> str:
    try:
        codecs.lookup(name)
    except LookupError:
        raise ValueError("is no encoding that is known; latin-1, cp1252 or utf-16, say") from None
    return name


def _not_zero(place: int | str) -> int | str:
    if place == 0:
        raise ValueError("columns count from 1")
    return place


ColumnPlace = Annotated[int | str, AfterValidator(_not_zero)]


class Layout(Section):
    """How a text table is laid out; the defaults are our own layout."""

    separator: Annotated[str, Field(pattern=r"^[^\w.+\-\"\r\n]$")] = ","
    """between columns; a blank means any run of blanks and tabs"""
    decimal: Literal[".", ","] = "."
    """point or comma"""
    skip: Annotated[int, Field(ge=0)] = 0
    """lines above the table, titles and settings of the instrument, that are passed over"""
    header: bool = True
    """the first line (behind those) names the columns; where it stands again between rows, it is no row"""
    comment: str = ""
    """what comment lines begin with"""
    encoding: Annotated[str, AfterValidator(_known_encoding)] = "utf-8"
    """of the text; a byte order mark says it itself"""
    columns: dict[str, ColumnPlace] = Field(default_factory=dict)
    """our name → the file's: a number (1 = first) or a name, with a minus where the sign is turned"""
    units: dict[str, str] = Field(default_factory=dict)
    """our name → the unit in the file, where it is another than the name says"""


@dataclass(frozen=True)
class Column:
    """A column that a table may have.

    `name` is without the unit ("q1"); `dimensions` are those that its unit may have, none for a
    plain number or a text. `blank`: empty cells are legal. `wild`: numbers beyond all
    measure are, too: who reads the column judges them row by row. `subject` and `mend` go into messages:
    what the column is of ("joint_1 turns"), and what to do about a bad cell.
    """

    name: str
    dimensions: tuple[str, ...] = ()
    text: bool = False
    required: bool = False
    blank: bool = False
    wild: bool = False
    subject: str = ""
    mend: str = ""

    def spellings(self, units: Mapping[str, Unit] = UNITS) -> dict[str, Unit]:
        """The names that the column may have in a file, with the unit that each states."""
        if not self.dimensions:
            return {self.name: NO_UNIT}
        return {
            f"{self.name}_{key}": unit for key, unit in units.items() if unit.dimension in self.dimensions
        }

    @property
    def usual(self) -> str:
        """The usual names, for messages: "q1_deg or q1_rad"."""
        if not self.dimensions:
            return self.name
        return " or ".join(f"{self.name}_{unit}" for dim in self.dimensions for unit in USUAL[dim])

    @property
    def written(self) -> tuple[str, Unit]:
        """The name that we write, and the unit that it states: q1_deg, degrees."""
        return next(
            iter(
                self.spellings({unit: UNITS[unit] for dim in self.dimensions for unit in USUAL[dim]}).items()
            )
        )


@dataclass(frozen=True)
class Found:
    """A wanted column, found: where in the file, our name for it, its unit, and what messages call it;
    sign −1 where the file counts the other way."""

    column: Column
    index: int
    name: str
    unit: Unit
    label: str
    sign: float = 1.0


@dataclass
class Finding:
    """What `find_columns` found, by column name, and what is wrong or worth a word."""

    found: dict[str, Found] = field(default_factory=dict)
    unused: list[str] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)
    missing: bool = False


def suggest(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """ "did you mean 'x_mm'?" when a known name is close, else an empty text."""
    lower = {item.lower(): item for item in known}
    close = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=cutoff)
    return f"did you mean {lower[close[0]]!r}?" if close else ""


def find_columns(
    header: Sequence[str] | None, width: int, layout: Layout, wanted: Sequence[Column], file: str, place: str
) -> Finding:
    """Find the wanted columns by the mapping in `layout` and by the names in the `header`.

    `file` is where the header stands ("points.csv line 1"), `place` where the layout stands
    ("campaign.toml: points"); both go into the faults. `header` None: the file has none.
    """
    result = Finding()
    names = {name: (column, unit) for column in wanted for name, unit in column.spellings().items()}
    _by_mapping(result, header, width, layout, names, place)
    if header is not None:
        _by_header(result, header, layout, names, file)
    for column in wanted:
        if column.required and column.name not in result.found:
            result.missing = True
            result.faults.append(_missing(column, header, result, file))
    _override_units(result, layout, names, place)
    return result


_Names = Mapping[str, tuple[Column, Unit]]


def _by_mapping(
    result: Finding, header: Sequence[str] | None, width: int, layout: Layout, names: _Names, place: str
) -> None:
    for name, where in layout.columns.items():
        key = f"{place}.columns.{name}"
        if name not in names:
            base = {column.name: column for column, _ in names.values()}
            mend = (
                f"say {base[name].usual}"
                if name in base
                else suggest(name, names) or f"one of {_list(names)}"
            )
            result.faults.append(Fault(key, "no such column of this table", mend))
            continue
        column, unit = names[name]
        at, sign = _signed(where, header)
        if column.name in result.found:
            result.faults.append(Fault(key, f"{column.name} is mapped twice", "keep one of them"))
        elif sign < 0 and column.text:
            result.faults.append(Fault(key, "is a text, which has no sign", "take the minus away"))
        elif isinstance(at, int) and at <= width:
            label = f"{name} (column {at})"
            result.found[column.name] = Found(column, at - 1, name, unit, label, sign)
        elif isinstance(at, int):
            result.missing = True
            result.faults.append(Fault(key, f"no column {at}", f"the file has {width} columns"))
        elif header is None:
            result.faults.append(Fault(key, f"no header to look for {at!r} in", "give the column's number"))
        elif at not in header:
            result.missing = True
            mend = suggest(at, header) or f"the file has: {_list(header)}"
            result.faults.append(Fault(key, f"no column {at!r} in the header", mend))
        else:
            index = list(header).index(at)
            result.found[column.name] = Found(column, index, name, unit, f"{name} ({where!r})", sign)


def _signed(where: int | str, header: Sequence[str] | None) -> tuple[int | str, float]:
    """Number or name of a column, and its sign."""
    if isinstance(where, int):
        return abs(where), 1.0 if where > 0 else -1.0
    bare = where[1:].strip()
    turned = where.startswith("-") and header is not None and where not in header
    return (bare, -1.0) if turned else (where, 1.0)


def _by_header(result: Finding, header: Sequence[str], layout: Layout, names: _Names, file: str) -> None:
    mapped = {_signed(where, header)[0] for where in layout.columns.values()}
    by_hand = {found.column.name for found in result.found.values()}
    taken = {found.index for found in result.found.values()}
    for index, name in enumerate(header):
        if list(header).index(name) < index and (name in names or name in mapped):
            first = list(header).index(name) + 1
            mend = "take one out, or say which by its number in `columns`"
            result.faults.append(Fault(file, f"column {name!r} twice, columns {first} and {index + 1}", mend))
        elif index in taken:
            continue
        elif name in names:
            column, unit = names[name]
            if column.name in by_hand:
                continue
            if column.name in result.found:
                other = result.found[column.name].label
                result.faults.append(Fault(file, f"both {other} and {name}", "keep one of them"))
            else:
                result.found[column.name] = Found(column, index, name, unit, name)
        elif name:
            result.unused.append(name)
    if not layout.columns:
        result.faults += [fault for name in result.unused if (fault := _misspelt(name, result, names, file))]


def _misspelt(name: str, result: Finding, names: _Names, file: str) -> Fault | None:
    """A column that we do not know but that looks like one of ours: left out, it would be lost unseen."""
    open_names = {key: column for key, (column, _) in names.items() if column.name not in result.found}
    base = {column.name: column for column in open_names.values()}
    stem, _, suffix = name.rpartition("_")
    if name in base and base[name].dimensions:
        return Fault(file, f"column {name!r} does not say its unit", f"name it {base[name].usual}")
    known = UNITS.get(suffix)
    if stem in base and base[stem].dimensions and (known or len(suffix) < 3 or suggest(suffix, UNITS)):
        column = base[stem]
        why = f"{column.subject}, which {suffix!r} does not fit" if known and column.subject else ""
        what = f"column {name!r}: {why or f'{suffix!r} is not a unit of it'}"
        return Fault(file, what, f"name it {column.usual}")
    digits = re.findall(r"\d+", name)
    usual = {key for column in base.values() for key in column.usual.split(" or ")}
    close = suggest(name, [key for key in usual if re.findall(r"\d+", key) == digits], cutoff=0.8)
    return (
        Fault(file, f"column {name!r} is not known", f"{close} rename it or take it out") if close else None
    )


def _missing(column: Column, header: Sequence[str] | None, result: Finding, file: str) -> Fault:
    name = column.usual.split(" or ")[0]
    what = f"no column {column.usual}"
    if header is None:
        return Fault(file, what, f"say which it is: columns = {{ {name} = 1, ... }} (1 = first)")
    close = suggest(name, [item for item in result.unused if item])
    how = f"add it, or say which it is: columns = {{ {name} = ... }}"
    return Fault(file, what, f"{close} {how}" if close else how)


def _override_units(result: Finding, layout: Layout, names: _Names, place: str) -> None:
    for name, text in layout.units.items():
        key = f"{place}.units.{name}"
        column, _ = names.get(name, (None, None))
        unit = UNITS.get(text)
        if column is None or column.name not in result.found:
            present = [found.name for found in result.found.values() if found.column.dimensions]
            mend = suggest(name, present) or "name a column as it is named in `columns` or in the header"
            result.faults.append(Fault(key, "no such column", mend))
        elif unit is None or unit.dimension not in column.dimensions:
            known = [item for item, one in UNITS.items() if one.dimension in column.dimensions]
            result.faults.append(Fault(key, f"{text!r} is not a unit of {name}", f"one of {_list(known)}"))
        else:
            result.found[column.name] = replace(result.found[column.name], unit=unit)


def _list(names: Iterable[str]) -> str:
    items = [repr(name) for name in names]
    return ", ".join(items[:12]) + (", ..." if len(items) > 12 else "")
