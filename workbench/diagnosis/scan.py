"""Search for gear lines of unknown order: every joint, every number of cycles per joint turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.linalg import solve_triangular
from scipy.signal import find_peaks

from ..identification.fit import Fit
from ..robot.kinematics import Array

LOWEST, HIGHEST, FINENESS = 3.0, 700.0, 0.25  # cycles per joint turn


@dataclass(frozen=True)
class Line:
    """A peak of the scan: statistic χ²(2) at `order` of a joint; `tries` independent looks were taken.

    scatter: variance of the joint's own error from pose to pose, over the noise's, without the line; a
    line must stand out of that, not of the noise alone. poses: number of poses that show the joint.
    aliases: other orders of the same joint that these poses cannot tell from it.
    """

    joint: int
    order: float
    statistic: float
    tries: int
    scatter: float
    poses: int
    aliases: tuple[float, ...] = ()

    @property
    def p_value(self) -> float:
        """Tail probability of one look: F against the joint's own scatter, never below the noise."""
        F = self.statistic / 2 / max(1.0, self.scatter)
        return float(stats.f.sf(F, 2, max(self.poses - 2, 1)))


def scan(fit: Fit, per_joint: int = 2) -> list[Line]:
    """The highest peaks of each revolute joint, highest first.

    A joint that spans s radians tells orders apart that differ by 2π/s; the number of tries counts
    the grid, which is finer, so a p-value times tries is on the safe side.
    """
    problem = fit.model.problem
    lines = []
    orders = np.arange(LOWEST, HIGHEST, FINENESS)
    searched = [
        j for j in range(problem.arm.n) if not problem.arm.prismatic[j] and np.ptp(problem.q[:, j]) > 0.1
    ]
    for j in searched:
        statistic = spectrum(fit, j, orders)
        tries = len(orders) * len(searched)
        lines += _peaks(fit, j, orders, statistic, per_joint, tries)
    return sorted(lines, key=lambda line: -line.statistic)


def spectrum(fit: Fit, joint: int, orders: Array) -> Array:
    """Statistic T(order) of a sine of that order in a joint, the fit's columns projected out."""
    g, a, own = _axial(fit, joint)
    back = np.einsum("ndp,nd->np", fit.J, g) * fit.columns.prior
    Z = solve_triangular(fit.upper, back.T, trans="T", check_finite=False)
    return _statistic(fit.model.problem.q[:, joint], orders, a, own, Z)


def _axial(fit: Fit, joint: int) -> tuple[Array, Array, Array]:
    """Whitened motion of the points by the joint (N, D), its product with the residual, its length²: (N,)."""
    column = int(fit.model.problem.arm.axial[joint])
    g = np.matmul(fit.whitener, fit.line.direct[:, :, column, None])[..., 0]
    return g, (g * fit.r).sum(axis=1), (g**2).sum(axis=1)


def scatter_of(fit: Fit, a: Array, own: Array) -> tuple[float, int]:
    """Sum over joint positions of the squared, standardised error along a direction, and their number.

    a: (N,) product of the residual with the direction, own: (N,) its length². Poses with equal joints
    (their loads, their repeats) share what depends on the joints, so they count as one.
    """
    block = fit.model.problem.positions
    a = np.asarray(np.bincount(block, a), dtype=np.float64)
    own = np.asarray(np.bincount(block, own), dtype=np.float64)
    shown = own > 1e-3 * own.max()
    return float(np.sum(a[shown] ** 2 / own[shown])), int(shown.sum())


def _statistic(q: Array, orders: Array, a: Array, own: Array, Z: Array) -> Array:
    """T(order) for orders on an even grid; the background's share exactly only where a peak may be."""
    us, uc = _waves(q, orders, a)
    double_s, double_c = _waves(q, 2 * orders, own)
    total = own.sum()
    ss, cc, sc = 0.5 * (total - double_c), 0.5 * (total + double_c), 0.5 * double_s
    T = _quotient(us, uc, ss, cc, sc, total)
    exact = (T > 6.0) | (orders < 12.0)
    if exact.any():
        angle = np.outer(q, orders[exact])
        zs, zc = Z @ np.sin(angle), Z @ np.cos(angle)
        ss, cc, sc = ss[exact], cc[exact], sc[exact]
        ss, cc, sc = ss - (zs**2).sum(axis=0), cc - (zc**2).sum(axis=0), sc - (zs * zc).sum(axis=0)
        T[exact] = _quotient(us[exact], uc[exact], ss, cc, sc, total)
    return T


def _quotient(us: Array, uc: Array, ss: Array, cc: Array, sc: Array, total: float) -> Array:
    det = ss * cc - sc**2
    T = (us**2 * cc - 2 * us * uc * sc + uc**2 * ss) / np.maximum(det, 1e-12 * total**2)
    return np.asarray(np.where(det > 1e-6 * total**2, T, 0.0))


def _waves(q: Array, orders: Array, weight: Array) -> tuple[Array, Array]:
    """Σ weight sin(order q) and Σ weight cos(order q) for orders on an even grid.

    e^{i(o + kδ)q} = e^{ioq} e^{ikδq}: blocks of 64 orders share one matrix product.
    """
    block = 64
    step = orders[1] - orders[0] if len(orders) > 1 else 0.0
    starts = orders[::block]
    inner = np.exp(1j * np.outer(q, step * np.arange(block)))
    outer = np.exp(1j * np.outer(starts, q)) * weight
    wave = (outer @ inner).ravel()[: len(orders)]
    return wave.imag, wave.real


def _peaks(fit: Fit, joint: int, orders: Array, statistic: Array, count: int, tries: int) -> list[Line]:
    """Highest local maxima, refined between the grid's points."""
    inner, _ = find_peaks(statistic)
    inner = inner[np.argsort(-statistic[inner])]
    lines = []
    _, a, own = _axial(fit, joint)
    total, poses = scatter_of(fit, a, own)
    for i in inner[:count]:
        fine = orders[i] + np.linspace(-FINENESS, FINENESS, 41)
        T = spectrum(fit, joint, fine)
        best = int(np.argmax(T))
        others = inner[
            (np.abs(orders[inner] - orders[i]) > 2 * FINENESS) & (statistic[inner] > T[best] - 10.0)
        ]
        aliases = tuple(float(orders[k]) for k in others) if T[best] > 30 else ()
        scatter = (total - T[best]) / max(poses - 2, 1)
        lines.append(Line(joint, float(fine[best]), float(T[best]), tries, float(scatter), poses, aliases))
    return lines
