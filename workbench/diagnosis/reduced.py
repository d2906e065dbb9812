"""All components in small matrices: what geometry, frames and targets cannot explain of each column."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ..identification.fit import Fit
from ..identification.rows import offset_of
from ..robot.kinematics import Array
from .components import Component

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Reduced:
    """Columns of all forms in prior sizes. S: (g, g) = Gᵀ V⁻¹ G, u: (g,) = Gᵀ V⁻¹ e; parts[k][f]: columns of
    component k in form f; chi2, dof: of the background alone; noise_dof: of the noise."""

    parts: tuple[tuple[slice, ...], ...]
    S: Array
    u: Array
    chi2: float
    dof: float
    noise_dof: float


def reduce(
    fit: Fit, components: Sequence[Component], noise_dof: float, poses: Index | None = None
) -> Reduced:
    """Reduced form at a fit, what the effects in its model explain given back to the data.

    The fit stops within a hundredth of a standard deviation: one exact linear step is taken here, or columns
    that the background nearly swallows get a false score. poses: only these count.
    """
    blocks, parts = columns_of(components)
    some = slice(None) if poses is None else poses
    G = np.concatenate(blocks, axis=2)[some]
    e = (fit.r + explained(fit))[some].ravel()
    n = fit.columns.background
    J = fit.J[some, :, :n].reshape(-1, n) * fit.columns.prior[:n]
    offset = offset_of(fit.model, fit.columns, fit.state)[:n]
    rows = int((np.abs(fit.whitener[some]).sum(axis=2) > 0).sum())
    return Reduced(parts, *without_background(J, offset, G.reshape(-1, G.shape[2]), e, rows), noise_dof)


def columns_of(components: Sequence[Component]) -> tuple[list[Array], tuple[tuple[slice, ...], ...]]:
    """Columns (N, D, p) of every form in prior sizes, and each component's slices of them side by side."""
    blocks = [form.columns * form.sizes for component in components for form in component.forms]
    return blocks, parts_of([len(form.sizes) for form in component.forms] for component in components)


def parts_of(widths: Iterable[Iterable[int]]) -> tuple[tuple[slice, ...], ...]:
    """Slices of columns that stand side by side, from the numbers of each component's forms' columns."""
    at, parts = 0, []
    for own in widths:
        ends = np.cumsum([at, *own]).tolist()
        parts.append(tuple(slice(a, b) for a, b in pairwise(ends)))
        at = ends[-1]
    return tuple(parts)


def explained(fit: Fit) -> Array:
    """(N, D) what the fit's effects explain of the whitened data, to first order."""
    out = np.zeros_like(fit.r)
    for part, values in zip(fit.columns.effect, fit.state.values, strict=True):
        out += fit.J[:, :, part] @ values
    return out


def without_background(
    J: Array, offset: Array, G: Array, e: Array, rows: int
) -> tuple[Array, Array, float, float]:
    """S (g, g), u (g,), χ² and degrees of freedom that a background leaves of columns G (R, g) and data e
    (R,).

    J: (R, n) the background in its priors, offset: (n,) how far it is from their means; rows: with data."""
    n = J.shape[1]
    upper = np.linalg.cholesky(J.T @ J + np.eye(n)).T
    Z = solve_triangular(upper, J.T @ G, trans="T", check_finite=False)
    z = solve_triangular(upper, J.T @ e - offset, trans="T", check_finite=False)
    inverse = solve_triangular(upper, np.eye(n), trans="T", check_finite=False)
    dof = rows - (n - float((inverse**2).sum()))
    return G.T @ G - Z.T @ Z, G.T @ e - Z.T @ z, float(e @ e + offset @ offset - z @ z), dof
