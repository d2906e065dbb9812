"""The gas spring that a joint's apparent compliances would need: Klimchik et al. 2017, eq. (12)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy.special import chdtrc

from ...robot.extended_robot.cylinder import ATMOSPHERE
from ...robot.kinematics import Array
from .gas_spring import Linkage


@dataclass(frozen=True)
class FittedSpring:
    """A gear and a gas spring fitted to a joint's apparent compliances, eq. (12), at M angles.

    stiffness: K_q of the gear [N·m/rad]; length: l = V/A of the gas at the shortest s [m]; force: (M,) of
    the cylinder [N]; torque: (M,) on the moving link [N·m]; compliance: (M,) [rad/(N·m)]; s0, sV: the spring
    in the source's parameters [m].
    """

    stiffness: float
    length: float
    force: Array
    torque: Array
    compliance: Array
    chi2: float
    dof: int
    s0: float
    sV: float

    @property
    def p_value(self) -> float:
        """How often noise alone leaves more."""
        return float(chdtrc(self.dof, self.chi2))


def fit_spring(triangle: Linkage, area: float, q: Array, compliance: Array, sigma: Array) -> FittedSpring:
    """The gear K_q and the isothermal gas spring nearest to compliances (M,) ± sigma at angles q (M,) [rad].

    K_q and the spring's strength A·p are linear, so only the gas length is searched, over all that leaves
    the piston room. Neither may be negative. area: of the piston [m²]; it counts for the air outside only.
    """
    weight = compliance**2 / sigma  # one over the standard deviation of K
    s, slope, bend = triangle.stretch(q)
    shortest = abs(triangle.a - triangle.L)
    ds = s - shortest
    length = ds.max() * (1 + np.geomspace(1e-3, 1e3, 600))
    gas = length[:, None] / (length[:, None] - ds)
    shape = gas / (length[:, None] - ds) * slope**2 + gas * bend
    air = area * ATMOSPHERE * bend  # the air outside pushes with a constant force
    gear, strength, chi2 = _two(weight, shape * weight, (1 / compliance + air) * weight)
    at = int(np.argmin(chi2))
    fitted = gear[at] + strength[at] * shape[at] - air
    force = strength[at] * gas[at] - area * ATMOSPHERE
    sV = strength[at] * length[at] / (area * ATMOSPHERE)
    return FittedSpring(
        float(gear[at]),
        float(length[at]),
        force,
        -force * slope,
        1 / fitted,
        float(chi2[at]),
        len(q) - 3,
        float(shortest + length[at] - sV),
        float(sV),
    )


def fit_any_order(triangle: Linkage, area: float, q: Array, compliance: Array, sigma: Array) -> FittedSpring:
    """`fit_spring` where it is not known which of the angles q (M,) [rad] each compliance belongs to.

    compliance, sigma: (M,) [rad/(N·m)]. The best of the fits to all orders of them.
    """
    orders = (list(order) for order in permutations(range(len(q))))
    fits = (fit_spring(triangle, area, q, compliance[order], sigma[order]) for order in orders)
    return min(fits, key=lambda spring: spring.chi2)


def _two(a: Array, b: Array, y: Array) -> tuple[Array, Array, Array]:
    """x, z ≥ 0 (G,) with the least |a x + b z − y|² (G,), for a, y (M,) and b (G, M)."""
    aa, bb, ab, ay, by = a @ a, (b * b).sum(axis=1), b @ a, a @ y, b @ y
    none = np.zeros_like(bb)
    determinant = aa * bb - ab**2
    both = (bb * ay - ab * by) / determinant, (aa * by - ab * ay) / determinant
    options = [both, (none + max(ay / aa, 0.0), none), (none, np.maximum(by / bb, 0.0))]
    left = np.array(
        [
            np.where((x >= 0) & (z >= 0), ((a * x[:, None] + b * z[:, None] - y) ** 2).sum(axis=1), np.inf)
            for x, z in options
        ]
    )
    best, every = left.argmin(axis=0), np.arange(len(bb))
    x, z = (np.array(part)[best, every] for part in zip(*options, strict=True))
    return x, z, left[best, every]
