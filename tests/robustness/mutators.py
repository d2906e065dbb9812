# ruff: noqa: E501  # lists of data
"""Ways to spoil a text: any, a table, a TOML, a URDF, a command line. Each from one random generator."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

Mutate = Callable[[random.Random, str], str]

VALUES = [
    "", " ", "nan", "NaN", "inf", "-inf", "1e400", "1e308", "-1e308", "1e-320", "0", "-0", "-1", "1", "0.5", "2",
    "1e3", "1e5", "1e12", "360", "1,5", "1.5.2", "0x10", "１２", "٣", "1_000", "--1", "+-2", "1e", "e1", "=1+1", "'",
    '"', "\\", "\x00", "\x1b[31m", "\u202e", "NULL", "N/A", "true", "9" * 400, "x" * 10_000, "<script>alert(1)</script>",
    "../../../etc/passwd", "ü", "a", "b", "T1", "flange", "world", "heavy", "joint_1", "link_1", "{{ 7 }}", "%s%n",
    "$(id)", "#[set page()]", "\ud7ff", "\U0001f916",
]  # fmt: skip
TOML_VALUES = [
    '""', '"x"', "0", "-1", "1", "2", "0.0", "-0.0", "1e308", "-1e308", "1e-320", "inf", "-inf", "nan", "1e6", "1e12",
    "9223372036854775807", "-9223372036854775808", "true", "false", "[]", "{}", "[[]]", "[1, 2, 3]", "[nan, 0, 0]",
    "[0, 0, 0]", "[1e300, 1e300, 1e300]", "[1, 2]", '["a"]', "1979-05-27", "{ a = 1 }", '"/dev/zero"', '"/dev/null"',
    '"/"', '"."', '".."', '"campaign.toml"', '"no such"', '"\\u0000"', '"\\u001b[31m"', '"' + "n" * 10_000 + '"',
    '"flange"', '"base"', '"link_1"', '"joint_1"', '"tool0"', '"\\t"', '";"', '" "', '"#"', "[" * 2000,
]  # fmt: skip
ATTRIBUTES = [
    "0 0 0", "1 0", "1 2 3 4", "nan nan nan", "0 0 1e308", "1e-9 0 0", "a b c", "revolute", "prismatic", "fixed",
    "floating", "planar", "continuous", "mimic", "${pi}", "package://nowhere/mesh.stl", "file:///dev/zero",
    "link_1", "link_2", "link_3", "tool0", "world", "world_mount", "joint_1", "rail",
]  # fmt: skip
ELEMENTS = [
    '<mimic joint="joint_1" multiplier="2"/>', "<dynamics damping='-1' friction='x'/>", "<transmission/>", "<!-- -->",
    "<gazebo><plugin/></gazebo>", "<visual><geometry><mesh filename='no.obj'/></geometry></visual>",
    "<collision><geometry><sphere radius='-1'/></geometry></collision>", "<limit/>", "<axis/>", "<origin/>",
    "<safety_controller k_velocity='1'/>", "<inertial/>", "<inertial><mass value='-1'/></inertial>",
    "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='9' ixy='0' ixz='0' iyz='0'/></inertial>",
    "<inertial><mass value='1e300'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>",
    "<link name='link_1'/>", "<link/>", "<joint/>", "<joint name='j' type='fixed'><parent link='tool0'/>"
    "<child link='world_mount'/></joint>", "&bomb;", "<a>" * 3000, "<drake:joint/>", "<material name='m'/>",
]  # fmt: skip


# ------------------------------------------------------------------ any text


def cut(rng: random.Random, text: str) -> str:
    return text[: rng.randrange(len(text) + 1)]


def emptied(rng: random.Random, text: str) -> str:
    return rng.choice(
        ["", "\n", " \t\n", "\ufeff", "\ufeff" + text, text.replace("\n", "\r\n"), text.replace("\n", "\r")]
    )


def a_character(rng: random.Random, text: str) -> str:
    at = rng.randrange(len(text) + 1)
    put = rng.choice([*"'\"[]{}<>=,;.#&\\/\n\t\r\x00\x07\x1b\x7f", "é", "\u2028", "\U0001f600", "ﬁ"])
    return text[:at] + put + text[at + rng.randrange(2) :]


def lines(rng: random.Random, text: str) -> str:
    rows = text.splitlines(keepends=True)
    i, j = rng.randrange(len(rows)), rng.randrange(len(rows))
    how = rng.randrange(6)
    if how == 0:
        del rows[i]
    elif how == 1:
        rows.insert(j, rows[i])
    elif how == 2:
        rows[i], rows[j] = rows[j], rows[i]
    elif how == 3:
        rows = rows[:i] + rows[j:]
    elif how == 4:
        rows = rows * rng.choice([2, 50])
    else:
        rng.shuffle(rows)
    return "".join(rows)


def a_word(rng: random.Random, text: str) -> str:
    words = list(re.finditer(r"\w+", text))
    if not words:
        return text
    word = rng.choice(words)
    other = rng.choice(
        [rng.choice(words)[0], word[0].upper(), word[0][::-1], word[0] + "s", rng.choice(VALUES)]
    )
    return text[: word.start()] + other + text[word.end() :]


ANY: list[Mutate] = [cut, emptied, a_character, lines, a_word]


# ------------------------------------------------------------------ tables


def _table(text: str) -> list[list[str]]:
    return [line.split(",") for line in text.splitlines()]


def _joined(rows: list[list[str]]) -> str:
    return "".join(",".join(row) + "\n" for row in rows)


def a_cell(rng: random.Random, text: str) -> str:
    rows = _table(text)
    row = rng.choice(rows)
    row[rng.randrange(len(row))] = rng.choice(VALUES)
    return _joined(rows)


def a_row(rng: random.Random, text: str) -> str:
    rows = _table(text)
    row = rng.choice(rows)
    if rng.random() < 0.5:
        row.pop(rng.randrange(len(row)))
    else:
        row.insert(rng.randrange(len(row)), rng.choice(VALUES))
    return _joined(rows)


def a_column(rng: random.Random, text: str) -> str:
    rows = _table(text)
    i, j = rng.randrange(len(rows[0])), rng.randrange(len(rows[0]))
    how, value = rng.randrange(5), rng.choice(VALUES)
    for number, row in enumerate(rows[:-1]):
        if max(i, j) >= min(len(row), len(rows[-1])):
            continue
        if how == 0:
            row.pop(i)
        elif how == 1:
            row.insert(j, row[i])
        elif how == 2:
            row[i], row[j] = row[j], row[i]
        elif how == 3 and number:
            row[i] = value
        elif how == 4 and number:
            row[i] = rows[-1][i]
    return _joined(rows)


def a_unit(rng: random.Random, text: str) -> str:
    units = [
        "mm",
        "m",
        "um",
        "in",
        "deg",
        "rad",
        "mrad",
        "N",
        "s",
        "ms",
        "h",
        "degC",
        "K",
        "kg",
        "",
        "furlong",
    ]
    names = list(re.finditer(r"_([a-zA-Z]+)(?=[,\n])", text.split("\n", 1)[0] + "\n"))
    if not names:
        return text
    name = rng.choice(names)
    return text[: name.start(1)] + rng.choice(units) + text[name.end(1) :]


def a_separator(rng: random.Random, text: str) -> str:
    changed = text.replace(",", rng.choice([";", "\t", " ", "|", ", ", ",,"]))
    return changed.replace(".", ",") if rng.random() < 0.3 else changed


TABLE: list[Mutate] = [*ANY, a_cell, a_cell, a_cell, a_row, a_column, a_column, a_unit, a_separator]


# ------------------------------------------------------------------ TOML


def a_value(rng: random.Random, text: str) -> str:
    pairs = list(re.finditer(r"=[^=\n]*$", text, re.MULTILINE))
    if not pairs:
        return text
    pair = rng.choice(pairs)
    return text[: pair.start()] + "= " + rng.choice(TOML_VALUES) + text[pair.end() :]


def a_key(rng: random.Random, text: str) -> str:
    keys = list(re.finditer(r"^[\w.]+(?= *=)|(?<=\[)[\w.]+(?=\])", text, re.MULTILINE))
    if not keys:
        return text
    key = rng.choice(keys)
    new = rng.choice(
        [rng.choice(keys)[0], key[0] + "x", '""', '"\\u0000"', "a.b.c", "x" * 10_000, '"' + key[0] + ' "']
    )
    return text[: key.start()] + new + text[key.end() :]


def a_section(rng: random.Random, text: str) -> str:
    sections = re.split(r"(?m)^(?=\[)", text)
    section = rng.choice(sections)
    how = rng.randrange(3)
    if how == 0:
        return text.replace(section, "")
    return text + (
        "\n" + section if how == 1 else rng.choice(["\n[tool]\n", "\n[x.y]\nz = 1\n", "\n[[targets]]\n"])
    )


TOML: list[Mutate] = [*ANY, a_value, a_value, a_value, a_value, a_key, a_section]


# ------------------------------------------------------------------ URDF


def an_attribute(rng: random.Random, text: str) -> str:
    found = list(re.finditer(r'="([^"]*)"', text))
    if not found:
        return text
    attribute = rng.choice(found)
    value = rng.choice([*VALUES, *ATTRIBUTES, *ATTRIBUTES])
    return text[: attribute.start(1)] + value + text[attribute.end(1) :]


def an_element(rng: random.Random, text: str) -> str:
    tags = list(re.finditer(r"<[^<>]*>", text))
    if not tags:
        return text
    tag = rng.choice(tags)
    new = rng.choice(["", tag[0] * 2, tag[0] + rng.choice(ELEMENTS), rng.choice(tags)[0]])
    return text[: tag.start()] + new + text[tag.end() :]


def a_bomb(rng: random.Random, text: str) -> str:
    parts = "".join(f'<!ENTITY b{i} "{f"&b{i - 1};" * 10}">' for i in range(1, 9))
    bomb = f'<!DOCTYPE robot [<!ENTITY b0 "boom">{parts}<!ENTITY bomb "&b8;"><!ENTITY x SYSTEM "file:///etc/passwd">]>'
    where = rng.choice(["&bomb;", "&x;", ""])
    return bomb + text.replace("</robot>", f"{where}</robot>")


URDF: list[Mutate] = [
    *ANY,
    an_attribute,
    an_attribute,
    an_attribute,
    an_attribute,
    an_element,
    an_element,
    a_bomb,
]


def spoilt(rng: random.Random, text: str, ways: list[Mutate]) -> tuple[str, str]:
    """The text after one or a few of the ways, and which."""
    said = []
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        way = rng.choice(ways)
        if text or way in (emptied, a_character):
            text, said = way(rng, text), [*said, way.__name__]
    return text, "+".join(said)
