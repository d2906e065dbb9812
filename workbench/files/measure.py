"""Numbers beyond all measure: no robot has them and no instrument shows them, and their squares overflow."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

LARGEST = 1e15  # in any unit
SMALLEST = 1e-9  # in SI units, of what has to be above zero

AboveZero = Annotated[float, Field(ge=SMALLEST, le=LARGEST, allow_inf_nan=False)]


def beyond(value: float) -> bool:
    """Whether a number is not finite or too large for anything that is measured or built."""
    return not abs(value) <= LARGEST
