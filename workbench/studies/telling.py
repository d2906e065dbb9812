"""Numbers as studies tell them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def each(name: str, values: ArrayLike, what: str = "") -> dict[str, float]:
    """Numbers of the joints by name: `name_1what`, `name_2what`, ..."""
    return {f"{name}_{j}{what}": float(value) for j, value in enumerate(np.asarray(values), start=1)}
