"""Numbers as studies tell them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def by_joint(name: str, values: ArrayLike, what: str = "") -> dict[str, float]:
    """Numbers of the joints, values: (n,), by name as a story takes them: `name_1what`, `name_2what`, ..."""
    return {f"{name}_{j}{what}": float(value) for j, value in enumerate(np.asarray(values), start=1)}
