"""Which columns of somebody else's table are the joints of a robot: by their names, by the names of joints in
the cells beside them, or by the joints' limits."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..robot.chain import MovingJoint
from .guess_text import Array, Text, angle_unit, counts, is_numbers, odd_cell, plain, stated, unit_of

ENDLESS = 4 * np.pi  # rad, that a joint without limits turns at most
BESIDE = 0.02  # of a joint's range: as near to a limit as it is within
SAID = r"(?:actual|act|ist|target|soll|command|cmd|meas|position|pos|angle|winkel|value|wert)*"
JOINT = re.compile(rf"{SAID}(?:a|j|q|ax|axis|achse?|gelenk|joint|jt|theta|angle)+{SAID}0?(\d\d?){SAID}")
NUMBERED = re.compile(r"\bpositions?\[\d+\]$", re.I)  # by the message's own order of joints
LETTERS = ("s", "l", "u", "r", "b", "t")  # as Yaskawa calls six axes
COMMANDED = re.compile("target|command|cmd|soll|aspos")
POSITION, NO_POSITION = re.compile("pos|ang"), re.compile(r"err|dev(?!ice)|[ck]orr")
OTHER = re.compile("vel|speed|geschw|acc|torq|tau|moment|effort|force|temp|cur")  # quantities of a joint


def joint_unit(text: Text, joint: MovingJoint, index: int, all_joints: Sequence[int]) -> str:
    """The unit of a joint's column, as its name says it or as large as its numbers are."""
    slides = ("mm" if text.largest(index) > 5 else "m") if joint.kind == "prismatic" else None
    return unit_of(text, index) or slides or angle_unit(text, all_joints)


def joint_columns(text: Text, joints: Sequence[MovingJoint]) -> dict[int, int]:
    """Joint (from 1) → column: behind the robot's own names in the cells, or named by these, or with a
    number; without a header columns side by side that vary and lie within the limits, the last of them."""
    numbers = [i for i, column in enumerate(text.columns) if is_numbers(column)]
    names = [joint.name for joint in joints]
    if behind := _behind_names(text, names, numbers):
        return behind
    if not text.header:
        side_by_side = windows(text, joints)
        return dict(enumerate(side_by_side[-1], 1)) if side_by_side else {}
    groups = _groups(text, names, numbers)
    ranked = {stem: _rank(text, stem, one) for stem, one in groups.items() if one}
    able = [stem for stem, rank in ranked.items() if rank[0] < 3]
    whole = [stem for stem in able if len(groups[stem]) == len(joints)]
    if whole:
        return groups[min(whole, key=lambda stem: ranked[stem])]
    return max((groups[stem] for stem in able), key=len, default={})


def _behind_names(text: Text, names: Sequence[str], numbers: Sequence[int]) -> dict[int, int]:
    """The columns behind those that hold the names of the joints in every row, in their order: so a message
    of joint states is written, which has its joints in the order of the alphabet."""
    fixed = {i: column[0] for i, column in enumerate(text.columns) if len(set(column)) == 1}
    named = [i for i, cell in fixed.items() if cell in names]
    if len({fixed[i] for i in named}) < len(names):
        return {}
    first = min(named)
    while "joint" in fixed.get(first - 1, "").lower():  # of a gripper, say
        first -= 1
    behind = next((i for i in numbers if i > first), len(text.columns))
    found = {names.index(fixed[i]) + 1: behind + i - first for i in named}
    return found if set(found.values()) <= set(numbers) else {}


def odd_joint(text: Text, joints: Sequence[MovingJoint]) -> str:
    """Why columns that are named as joints are none; nothing where there are no such columns."""
    if not text.header:
        return ""
    groups = _groups(text, [joint.name for joint in joints], range(len(text.columns)))
    if any(NUMBERED.search(name) for name in text.header):
        return "position[0] ... stand in the order of the message's names, often the alphabet's: say it"
    named = max(groups.values(), key=len, default={})
    return odd_cell(text, named.values()) if len(named) == len(joints) else ""


def _groups(text: Text, names: Sequence[str], numbers: Sequence[int]) -> dict[str, dict[int, int]]:
    """Joint (from 1) → column, of the columns that are named alike but for the joint: by the rest of the
    name."""
    own = {plain(name): j for j, name in enumerate(names, 1)}
    own |= {name.removesuffix("joint"): j for name, j in own.items()}
    if len(names) == len(LETTERS) and set(LETTERS) <= {plain(text.header[i]) for i in numbers}:
        own |= {letter: j for j, letter in enumerate(LETTERS, 1)}
    groups: dict[str, dict[int, int]] = {}
    for i in numbers:
        name = text.header[i].lower().replace("θ", "theta")
        name = re.sub(r"\[(\d+)\]", r"\1", name)  # [0] is the first, and no unit
        bare = plain(name)
        other = "" if unit_of(text, i) or stated(text, i).isdigit() else stated(text, i)
        parts = re.split(r"[/.:,$\s]+", name)
        said = {j: part for part in parts for j, one in enumerate(names, 1) if part == one.lower()}
        numbered = {int(m[1]): part for part in parts if (m := JOINT.fullmatch(plain(part)))}
        if bare in own:
            groups.setdefault(other, {}).setdefault(own[bare], i)
        elif match := None if said else JOINT.fullmatch(bare):
            stem = f"{re.sub('[0-9]', '', bare)} {other}"
            groups.setdefault(stem, {}).setdefault(int(match[1]), i)
        elif said or numbered:
            j, part = next(iter((said or numbered).items()))
            stem = f"{plain(''.join(name.rsplit(part, 1)))} {other}"
            groups.setdefault(stem, {}).setdefault(j, i)
    return {stem: _from_one(columns, len(names)) for stem, columns in groups.items()}


def _from_one(columns: Mapping[int, int], n: int) -> dict[int, int]:
    """The columns of n joints at most; some count from 0."""
    first = min(1, *columns)
    return {j + 1 - first: i for j, i in columns.items() if j + 1 - first <= n}


def _rank(text: Text, stem: str, columns: Mapping[int, int]) -> tuple[int, bool, bool]:
    """0: their unit is that of a joint; 1: they state none; 2: one that is not known; 3: they are another
    quantity. What was commanded comes before what was read back."""
    unit, other = unit_of(text, columns[1]), stem.rpartition(" ")[2]
    no_position = NO_POSITION.search(stem) or (OTHER.search(stem) and not POSITION.search(stem))
    worth = 3 if no_position else 0 if unit else 2 if other else 1
    return worth, not COMMANDED.search(stem), "pos" not in stem


def windows(text: Text, joints: Sequence[MovingJoint]) -> list[range]:
    """Columns side by side that may be the joints of a table without a header: those of which most vary and
    lie within the limits."""
    n = len(joints)
    numbers = {i for i, column in enumerate(text.columns) if is_numbers(column) and not counts(column)}
    able = [range(i, i + n) for i in sorted(numbers) if numbers.issuperset(range(i, i + n))]
    varies = {i: text.varies(i) for i in numbers}
    worth = [
        sum(varies[i] and within for i, within in zip(one, _within_limits(text, joints, one), strict=True))
        for one in able
    ]
    return [one for one, value in zip(able, worth, strict=True) if value == max(worth)]


def joints_of(text: Text, joints: Sequence[MovingJoint], window: range) -> Array:
    """(rows, n) [rad, m] of columns that may be the joints."""
    factor = {"deg": np.pi / 180, "rad": 1.0, "mm": 1e-3, "m": 1.0}
    return np.stack(
        [
            factor[joint_unit(text, joint, index, window)] * text.numbers(index)
            for joint, index in zip(joints, window, strict=True)
        ],
        axis=1,
    )


def _within_limits(text: Text, joints: Sequence[MovingJoint], window: range) -> NDArray[np.bool_]:
    """(n,) whether a joint would keep to its limits, or next to them."""
    q = joints_of(text, joints, window)
    lower, upper = (np.array([getattr(joint, name) for joint in joints]) for name in ("lower", "upper"))
    endless = ~np.isfinite(upper - lower)
    lower, upper = np.where(endless, -ENDLESS, lower), np.where(endless, ENDLESS, upper)
    slack = BESIDE * (upper - lower)
    return np.asarray((np.nanmin(q, axis=0) >= lower - slack) & (np.nanmax(q, axis=0) <= upper + slack))
