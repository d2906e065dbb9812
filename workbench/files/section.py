"""A table of a TOML file: its keys and no others, each of the kind that TOML itself tells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

PLAIN = {str, bool, int, float}


class Section(BaseModel):
    """Unknown keys are faults; so are texts and truth values in the place of numbers, as "0.03" or true,
    whatever Python could make of them."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @field_validator("*", mode="before")
    @classmethod
    def _of_its_kind(cls, value: Any, info: ValidationInfo) -> Any:
        kinds = {*_kinds(cls.model_fields[str(info.field_name)].annotation)} - {type(None)}
        if kinds <= PLAIN:  # no table with keys of its own
            wanted = "true or false" if kinds == {bool} else "a text" if kinds == {str} else "a number"
            for leaf in _leaves(value):
                wrong = isinstance(leaf, bool | str) and type(leaf) not in kinds
                if wrong or (kinds == {bool} and not isinstance(leaf, bool | None)):
                    said = {"leaf": _said(leaf), "wanted": wanted}
                    raise PydanticCustomError("wrong_kind", "is {leaf}, not {wanted}", said)
        return value


def _said(leaf: object) -> str:
    """A value as TOML has it."""
    return str(leaf).lower() if isinstance(leaf, bool) else repr(leaf)


def _kinds(annotation: Any) -> Iterator[Any]:
    """Types of what may stand in a field, in its lists, and under the keys of its tables."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        yield from map(type, parts)
    elif origin is Annotated:
        yield from _kinds(parts[0])
    elif parts:
        for part in parts[-1:] if origin is dict else parts:
            yield from _kinds(part) if part is not Ellipsis else ()
    else:
        yield annotation


def _leaves(value: Any) -> Iterator[Any]:
    """What stands in a value's lists and tables."""
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if isinstance(value, Sequence) and not isinstance(value, str):
        for part in value:
            yield from _leaves(part)
    else:
        yield value
