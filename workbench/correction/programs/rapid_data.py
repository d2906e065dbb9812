"""The data that a RAPID module declares: targets, tools, work objects and loads by their names, and which of
them the program sets, so that their numbers are not those that count."""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence

from .format import NUMBER
from .text import arguments, place_in_array

TARGETS = ("robtarget", "jointtarget")
KINDS = (*TARGETS, "tooldata", "wobjdata", "loaddata", "speeddata", "zonedata")
DECLARED = re.compile(
    rf"\b(?:CONST|VAR|PERS)\s+({'|'.join(KINDS)})\s+(\w+)\s*(\{{[^}}]*\}})?\s*:=\s*(.*\S)", re.I | re.S
)
GIVEN = re.compile(r"\b(?:CONST|VAR|PERS)\s+\w+\s+\w+\s*(?:\{[^}]*\}\s*)?:=", re.I)
EMPTY = re.compile(r"\b(?:VAR|PERS)\s+\w+\s+(\w+)\s*(?:\{[^}]*\}\s*)?$", re.I)  # declared without a value
SET = re.compile(r"(?<![\w\\.])(\w+)\s*(?:\{[^}]*\})?(?:\.\w+)*\s*:=")  # no option
TAKES = re.compile(r"\b(?:PROC|FUNC\s+\w+)\s+(\w+)\s*\(([^)]*)\)", re.I)
TAKEN = re.compile(r"(\w+)\s*(?:\{[^}]*\})?\s*(?:[,|]|$)")  # the name of an argument
CHANGES = re.compile(rf"\b(?:INOUT|VAR|PERS)\s+(?:{'|'.join(KINDS)}|pose)\b", re.I)
FOUND = re.compile(r"(?<![\w\\.])Search[LCJ]\w*(?=[\s\\])", re.I)  # sets its second argument

Text = tuple[int, str]  # where the text begins in the file, the text
Key = tuple[int, str]  # routine and name
NOTHING = (0, "")


class Data:
    """Data by routine and name. bounds: where routines begin and end in the code, in turn: data of the module
    stand between them. routine: the number of the one in which names are looked up."""

    def __init__(self, code: str, statements: Sequence[Text], bounds: Sequence[int]) -> None:
        self.bounds = bounds
        self.routine = 0
        self.index: Mapping[str, int] = {}  # loop variables
        self.declared: dict[Key, Text] = {}
        self.shared: dict[str, Key] = {}  # those of the module by their name
        self.targets: set[Key] = set()
        self.computed: set[Key] = set()  # data that the program sets
        for start, statement in statements:
            if match := DECLARED.search(statement):
                self._declare_all(start, match)
            elif match := EMPTY.search(statement):
                self._declare(bisect(bounds, start + match.start()), match[1], NOTHING)
        changing = set[str]()
        for match in TAKES.finditer(code):
            for name in TAKEN.findall(match[2]):
                self._declare(bisect(bounds, match.start()), name, NOTHING)
            if CHANGES.search(match[2]):
                changing.add(match[1])
        for start, statement in statements:
            if not GIVEN.search(statement):
                self._find_computed(start, statement, calls(changing))

    def _declare_all(self, start: int, match: re.Match[str]) -> None:
        """What a statement declares: one, or the entries of an array."""
        kind, name, many, value = match.groups()
        at = start + match.start(4)
        routine = bisect(self.bounds, start + match.start())
        entries = {name: (at, value)} if not many else dict(_entries(name, (at, value), many.count(",") + 1))
        for key, text in {name: NOTHING, **entries}.items():
            # a value that is computed, or another's, is none
            self._declare(routine, key, text if text[1].startswith("[") else NOTHING)
            if kind.lower() in TARGETS:
                self.targets.add((routine, _plain(key)))

    def _declare(self, routine: int, name: str, text: Text) -> None:
        key = routine, _plain(name)
        self.declared[key] = text
        if routine % 2 == 0:
            self.shared.setdefault(key[1], key)

    def _find_computed(self, start: int, statement: str, changing: re.Pattern[str] | None) -> None:
        """What a statement sets: by :=, by a call that takes it to change it, or by what a search finds."""
        names = [match[1] for match in SET.finditer(statement)]
        if changing and (match := changing.search(statement)):
            names += [part.split("\\")[0] for _, part in arguments(statement[match.end() :])]
        if match := FOUND.search(statement):
            parts = [part for _, part in arguments(statement[match.end() :]) if not part.startswith("\\")]
            names += parts[1:2]
        self.routine = bisect(self.bounds, start + len(statement) - 1)
        self.computed |= {self.key(name.split("{")[0]) for name in names}

    def key(self, name: str) -> Key:
        """Of the data that a name means in the routine: its own, or the module's."""
        key = self.routine, _plain(name)
        return key if key in self.declared else self.shared.get(key[1], (0, key[1]))

    def text(self, start: int, text: str) -> Text:
        """What stands for a target, tool or work object: itself, or its declaration."""
        text = self._name(text)
        return (start, text) if text.startswith("[") else self.declared.get(self.key(text), NOTHING)

    def _name(self, text: str) -> str:
        """Without options, and with the numbers of an array's entry."""
        name, brace, index = text.split("\\")[0].strip().partition("{")
        if not brace or "[" in name:
            return name + brace + index
        said = index.rstrip("} \t\r\n").lower().split(",")
        places = [place_in_array(part, self.index) for part in said]
        texts = [part if place is None else str(place) for part, place in zip(said, places, strict=True)]
        return f"{name}{{{','.join(texts)}}}"

    def is_set(self, text: str) -> bool:
        """Whether the program sets the data of a name."""
        return self.key(self._name(text).partition("{")[0]) in self.computed

    def is_computed(self, text: str) -> bool:
        """Whether the program sets the data of a name, or which of an array's entries it is."""
        index = self._name(text).partition("{")[2]
        return self.is_set(text) or bool(re.search(r"[^\d,}\s]", index))

    def is_target(self, text: str) -> bool:
        """Whether the text is the name of a declared target."""
        return self.key(self._name(text)) in self.targets

    def numbers(self, start: int, text: str) -> tuple[list[float], list[tuple[int, int]]] | None:
        """The numbers of a declaration and where they stand; None where it is not there, or computed."""
        start, text = self.text(start, text)
        plain = re.sub(r"\b(?:TRUE|FALSE)\b", "", re.sub(NUMBER, "0", text), flags=re.I)
        if not text or re.search(r"[^][,\s0]|0\s*0", plain):
            return None
        found = list(re.finditer(NUMBER, text))
        spans = [(start + match.start(), start + match.end()) for match in found]
        return [float(match[0]) for match in found], spans

    def flags(self, name: str) -> list[str]:
        """What is TRUE and FALSE in the data of a tool or work object."""
        return re.findall(r"\b(?:TRUE|FALSE)\b", self.text(0, name)[1].upper())


def calls(names: set[str]) -> re.Pattern[str] | None:
    """Finds the statements that call one of these routines."""
    if not names:
        return None
    return re.compile(rf"(?<![\w\\.])({'|'.join(sorted(names))})\b(?!\s*(?:\(|:=))", re.I)


def _plain(name: str) -> str:
    return "".join(name.split()).lower()


def _entries(name: str, text: Text, depth: int, index: tuple[int, ...] = ()) -> Iterator[tuple[str, Text]]:
    """The entries of an array of so many dimensions, by their names."""
    start, value = text
    if len(index) == depth:
        yield f"{name}{{{','.join(map(str, index))}}}", text
    elif value.startswith("["):
        for i, (at, part) in enumerate(arguments(value[1:]), 1):
            yield from _entries(name, (start + 1 + at, part), depth, (*index, i))
