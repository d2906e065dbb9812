"""Figures of ISO 9283 that repeated poses show by themselves: nothing is fitted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .repeats import repeat_groups

FEWEST = 5  # repeats of a position from which its spread is told; the standard asks for 30


@dataclass(frozen=True)
class Repeatability:
    """Positions that were measured `FEWEST` times or more from one side (ISO 9283:1998).

    rp: (G,) [m] pose repeatability l̄ + 3 S_l of each, its largest target's, l being distances from the mean;
    repeats: (G,) how often; sides: (P,) [m] multi-directional variation vAP of the positions that were
    approached from several: the farthest that their means are apart.
    """

    rp: Array
    repeats: NDArray[np.int64]
    sides: Array

    @property
    def sentence(self) -> str:
        """For people."""
        low, high = int(self.repeats.min()), int(self.repeats.max())
        often = f"{low} times" if low == high else f"{low} to {high} times"
        said = (
            f"{len(self.rp)} positions measured {often} from one side: pose repeatability RP (ISO 9283) "
            f"{1e3 * self.rp.mean():.3f} mm in the mean, {1e3 * self.rp.max():.3f} mm at most"
        )
        if not self.sides.size:
            return said
        vap = f"{1e3 * self.sides.mean():.3f} mm in the mean, {1e3 * self.sides.max():.3f} mm at most"
        return f"{said}; between sides of approach (vAP) {vap}"


def repeatability(problem: Problem) -> Repeatability | None:
    """Of a campaign, the instrument's noise and all drift included; None where no position has repeats
    enough."""
    group, position = repeat_groups(problem), repeat_groups(problem, sides=False)
    points = problem.campaign.points
    if problem.campaign.six_dof:  # its points stand for one frame
        points = points.mean(axis=1, keepdims=True)
    rp, repeats = dict[int, float](), dict[int, int]()
    means = dict[tuple[int, int], list[Array]]()
    for g in np.flatnonzero(np.bincount(group) >= FEWEST).tolist():
        here = np.flatnonzero(group == g)
        for t in range(points.shape[1]):
            own = points[here, t][np.isfinite(points[here, t]).all(axis=1)]
            if len(own) < FEWEST:
                continue
            off = np.linalg.norm(own - own.mean(axis=0), axis=1)
            rp[g] = max(rp.get(g, 0.0), float(off.mean() + 3 * off.std(ddof=1)))
            repeats[g] = max(repeats.get(g, 0), len(own))
            means.setdefault((int(position[here[0]]), t), []).append(own.mean(axis=0))
    if not rp:
        return None
    sides = dict[int, float]()
    for (place, _), each in means.items():
        for one, other in combinations(each, 2):
            sides[place] = max(sides.get(place, 0.0), float(np.linalg.norm(one - other)))
    return Repeatability(np.array([*rp.values()]), np.array([*repeats.values()]), np.array([*sides.values()]))
