"""Search for gear lines of unknown order: every joint, every number of cycles per joint turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ..arm import Array
from ..fit import Fit

LOWEST, HIGHEST, STEP = 3.0, 700.0, 0.25  # cycles per joint turn


@dataclass(frozen=True)
class Line:
    """A peak of the scan: statistic χ²(2) at `order` of a joint; `tries` independent looks were taken.

    aliases: other orders of the same joint that these poses cannot tell from it.
    """

    joint: int
    order: float
    statistic: float
    tries: int
    aliases: tuple[float, ...] = ()


def scan(fit: Fit, per_joint: int = 2) -> list[Line]:
    """The highest peaks of each revolute joint, highest first.

    A joint that spans s radians tells orders apart that differ by 2π/s; the number of tries counts
    the grid, which is finer, so a p-value times tries is on the safe side.
    """
    problem = fit.model.problem
    lines = []
    orders = np.arange(LOWEST, HIGHEST, STEP)
    searched = [j for j in range(problem.arm.n) if not problem.arm.prismatic[j] and np.ptp(problem.q[:, j]) > 0.1]
    for j in searched:
        statistic = spectrum(fit, j, orders)
        tries = len(orders) * len(searched)
        lines += _peaks(fit, j, orders, statistic, per_joint, tries)
    return sorted(lines, key=lambda line: -line.statistic)


def spectrum(fit: Fit, joint: int, orders: Array) -> Array:
    """Statistic T(order) of a sine of that order in a joint, the fit's columns projected out."""
    problem = fit.model.problem
    column = int(problem.arm.axial[joint])
    g = np.matmul(fit.whitener, fit.line.direct[:, :, column, None])[..., 0]
    back = np.einsum("ndp,nd->np", fit.J, g) * fit.columns.prior
    Z = solve_triangular(fit.upper, back.T, trans="T", check_finite=False)
    a, own = (g * fit.r).sum(axis=1), (g**2).sum(axis=1)
    return _statistic(problem.q[:, joint], orders, a, own, Z)


def _statistic(q: Array, orders: Array, a: Array, own: Array, Z: Array) -> Array:
    out = np.empty(len(orders))
    for start in range(0, len(orders), 512):
        block = orders[start : start + 512]
        angle = np.outer(q, block)
        s, c = np.sin(angle), np.cos(angle)
        us, uc = a @ s, a @ c
        zs, zc = Z @ s, Z @ c
        ss = own @ s**2 - (zs**2).sum(axis=0)
        cc = own @ c**2 - (zc**2).sum(axis=0)
        sc = own @ (s * c) - (zs * zc).sum(axis=0)
        det = ss * cc - sc**2
        total = own.sum()
        T = (us**2 * cc - 2 * us * uc * sc + uc**2 * ss) / np.maximum(det, 1e-12 * total**2)
        out[start : start + 512] = np.where(det > 1e-6 * total**2, T, 0.0)
    return out


def _peaks(fit: Fit, joint: int, orders: Array, statistic: Array, count: int, tries: int) -> list[Line]:
    """Highest local maxima, refined between the grid's points."""
    inner = np.flatnonzero((statistic[1:-1] >= statistic[:-2]) & (statistic[1:-1] >= statistic[2:])) + 1
    inner = inner[np.argsort(-statistic[inner])]
    lines = []
    for i in inner[:count]:
        fine = orders[i] + np.linspace(-STEP, STEP, 41)
        T = spectrum(fit, joint, fine)
        best = int(np.argmax(T))
        others = inner[(np.abs(orders[inner] - orders[i]) > 2 * STEP) & (statistic[inner] > T[best] - 10.0)]
        aliases = tuple(float(orders[k]) for k in others) if T[best] > 30 else ()
        lines.append(Line(joint, float(fine[best]), float(T[best]), tries, aliases))
    return lines
