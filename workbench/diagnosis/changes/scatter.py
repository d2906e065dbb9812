"""How much the points scatter at each occasion: by what the model leaves, not by what anybody stated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import t as student

from .candidates import Shape
from .found import Scatter
from .system import Solved, System


def scatters(system: System, shapes: Sequence[Shape], solved: Solved) -> list[Scatter]:
    """Of each occasion. A pose is one draw, its targets are none each: they share the robot's own scatter."""
    X = np.concatenate([system.J, *(shape.columns for shape in shapes)], axis=1)
    freedom = ((X @ solved.half) ** 2).sum(axis=1)  # of each row, taken by what was fitted
    found = list[Scatter]()
    first = (0.0, 0.0, 1)
    for k, one in enumerate(system.occasions):
        here = (system.own == k) & system.used
        share = max(1.0 - float(freedom[here].mean()), 1.0 / here.sum())
        seen = one.problem.seen
        squares = np.zeros(seen.shape)
        squares[seen] = system.lengths(k, solved.left[system.own == k]) ** 2
        each = squares.sum(axis=1)[seen.any(axis=1)] / seen.sum(axis=1)[seen.any(axis=1)]
        sigma = float(np.sqrt(each.mean() / (3 * share)))
        shown = 0.5 * float(each.std(ddof=1) / (each.mean() * np.sqrt(len(each))))
        relative = max(shown, float((2 * share * here.sum()) ** -0.5))  # no less than of independent errors
        if k == 0:
            first = sigma, relative, len(each)
        z = np.log(sigma / first[0]) / np.hypot(relative, first[1])
        # of few poses the standard error is rough itself (Welch 1947)
        dof = (relative**2 + first[1] ** 2) ** 2 / (
            relative**4 / (len(each) - 1) + first[1] ** 4 / (first[2] - 1)
        )
        p = 1.0 if k == 0 else 2 * float(student.sf(abs(z), dof))
        rms = float(np.sqrt(np.mean(squares[seen])))
        found.append(Scatter(1e3 * sigma, 1e3 * sigma * relative, sigma / first[0], p, 1e3 * rms))
    return found
