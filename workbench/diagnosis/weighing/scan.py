"""Search for gear lines of unknown order: every joint, every number of cycles per joint turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ...identification.fit import Fit
from ...robot.kinematics import Array

LOWEST, HIGHEST, FINENESS = 3.0, 700.0, 0.25  # cycles per joint turn, of a sliding joint per 2π m
PEAK = np.pi  # rad over a joint's travel from which two orders differ: half a cycle
LEAST_CYCLES = 2.0  # over a joint's travel: of fewer nothing shows that they repeat, and any map has them


@dataclass(frozen=True)
class Line:
    """A peak of the scan: statistic χ²(2) at `order` of a joint."""

    joint: int
    order: float
    statistic: float


@dataclass(frozen=True)
class _Background:
    """What a joint's scan needs at any order: the joint's motion with the residual, its length² (N,), and its
    part (P, N) that the fit's columns take."""

    a: Array
    own: Array
    Z: Array


def scan(fit: Fit, per_joint: int = 2) -> list[Line]:
    """The highest peaks of each joint, highest first; none where its rounding makes peaks as well."""
    problem = fit.model.problem
    lines = []
    for j in range(problem.arm.n):
        q = problem.q[:, j]
        if np.ptp(q) <= 0.1 or problem.arm.names[j] in problem.rounded:
            continue
        lowest = max(LOWEST, LEAST_CYCLES * 2 * np.pi / float(np.ptp(q)))
        step = min(FINENESS, PEAK / float(np.ptp(q)))
        orders = np.arange(lowest, HIGHEST, step)
        behind = _behind(fit, j)
        statistic = _statistic(q, orders, behind)
        before, here, after = statistic[:-2], statistic[1:-1], statistic[2:]
        inner = 1 + np.flatnonzero((here > before) & (here >= after))
        for i in inner[np.argsort(-statistic[inner])][:per_joint]:
            fine = orders[i] + np.linspace(-step, step, 41)
            T = _statistic(q, fine, behind)
            best = int(np.argmax(T))
            lines.append(Line(j, float(fine[best]), float(T[best])))
    return sorted(lines, key=lambda line: -line.statistic)


def spectrum(fit: Fit, joint: int, orders: Array) -> Array:
    """Statistic T(order) of a sine of that order in a joint, the fit's columns projected out."""
    return _statistic(fit.model.problem.q[:, joint], orders, _behind(fit, joint))


def _behind(fit: Fit, joint: int) -> _Background:
    g = fit.axial[:, :, joint]
    back = np.einsum("ndp,nd->np", fit.J, g) * fit.columns.prior
    Z = solve_triangular(fit.upper, back.T, trans="T", check_finite=False)
    return _Background((g * fit.r).sum(axis=1), (g**2).sum(axis=1), Z)


def _statistic(q: Array, orders: Array, behind: _Background) -> Array:
    """T(order) for orders on an even grid; the background's share exactly only where a peak may be."""
    us, uc = _waves(q, orders, behind.a)
    double_s, double_c = _waves(q, 2 * orders, behind.own)
    total = behind.own.sum()
    ss, cc, sc = 0.5 * (total - double_c), 0.5 * (total + double_c), 0.5 * double_s
    T = _quotient(us, uc, ss, cc, sc, total)
    exact = (T > 6.0) | (orders < 12.0)
    if exact.any():
        angle = np.outer(q, orders[exact])
        zs, zc = behind.Z @ np.sin(angle), behind.Z @ np.cos(angle)
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
