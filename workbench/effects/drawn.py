"""An effect as a curve: what its evidence is drawn against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..robot.kinematics import Array


@dataclass(frozen=True, eq=False)
class Drawn:
    """An effect over what it depends on, in N poses.

    x: (N,) that variable; size: (N,) what the effect makes of each pose, signed, in `unit`; curve: the same
    on a grid, x (K,) and size (K,); None: through the poses themselves.
    """

    x: Array
    x_name: str
    x_unit: str
    size: Array
    name: str
    unit: str
    curve: tuple[Array, Array] | None = None

    @property
    def line(self) -> tuple[Array, Array]:
        """The curve to draw: x ascending."""
        if self.curve is not None:
            return self.curve
        order = np.argsort(self.x, kind="stable")
        return self.x[order], self.size[order]
