"""A table of a TOML file: its keys and no others, each of the kind that TOML itself tells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from .toml_place import kinds

PLAIN = {str, bool, int, float}


class Section(BaseModel):
    """Unknown keys are faults; so are texts and truth values in the place of numbers, as "0.03" or true,
    whatever Python could make of them."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @field_validator("*", mode="before")
    @classmethod
    def _of_its_kind(cls, value: Any, info: ValidationInfo) -> Any:
        may_be = {*_kinds(cls.model_fields[str(info.field_name)].annotation)} - {type(None)}
        if may_be <= PLAIN:  # no table with keys of its own
            wanted = "true or false" if may_be == {bool} else "a text" if may_be == {str} else "a number"
            for leaf in _leaves(value):
                wrong = isinstance(leaf, bool | str) and type(leaf) not in may_be
                if wrong or (may_be == {bool} and not isinstance(leaf, bool | None)):
                    said = {"leaf": _said(leaf), "wanted": wanted}
                    raise PydanticCustomError("wrong_kind", "is {leaf}, not {wanted}", said)
        return value


def _said(leaf: object) -> str:
    """A value as TOML has it."""
    return str(leaf).lower() if isinstance(leaf, bool) else repr(leaf)


def _kinds(annotation: Any) -> Iterator[type]:
    """Types of what may stand in a field, in its lists, and under the keys of its tables."""
    for one in kinds(annotation):
        inside = get_args(one)[-1:] if get_origin(one) is dict else get_args(one)
        for part in inside:
            yield from _kinds(part) if part is not Ellipsis else ()
        if not inside:
            yield one if isinstance(one, type) else type(one)  # of a Literal's values


def _leaves(value: Any) -> Iterator[Any]:
    """What stands in a value's lists and tables."""
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if isinstance(value, Sequence) and not isinstance(value, str):
        for part in value:
            yield from _leaves(part)
    else:
        yield value
