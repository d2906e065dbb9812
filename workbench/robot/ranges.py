"""Whether joints are within what was measured of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .kinematics import Array

MARGIN = 0.02  # of a joint's measured range, or of the largest spread: nearer than this is inside


def beyond_range(q: Array, lower: Array, upper: Array) -> NDArray[np.bool_]:
    """(N, n) which joints of poses q (N, n) are outside of what was measured of them, lower to upper (n,)
    [rad, m]."""
    margin = MARGIN * (upper - lower) + 1e-6
    return np.asarray((q < lower - margin) | (q > upper + margin))
