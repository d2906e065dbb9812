"""All components in small matrices: what geometry, frames and targets cannot explain of each column."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular

from ...identification.fit import Fit
from ...identification.patterns import Index, Products, once, products_of
from ...identification.rows import offset_of
from ...robot.kinematics import Array
from .components import Component, sized
from .gram import Gram, Stored

ROWS = 200  # of products of all columns that are worked out at once


@dataclass(frozen=True, eq=False)
class Reduced:
    """Columns of all forms in prior sizes. S: (g, g) = Gᵀ V⁻¹ G, u: (g,) = Gᵀ V⁻¹ e; parts[k][f]: columns of
    component k in form f; chi2, dof: of the background alone; noise_dof: of the noise."""

    parts: tuple[tuple[slice, ...], ...]
    S: Gram
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
    forms = [form for component in components for form in component.forms]
    some = np.arange(len(fit.r)) if poses is None else poses
    n = fit.columns.background
    J, e = fit.J[some, :, :n] * fit.columns.prior[:n], (fit.r + explained(fit))[some]
    offset = offset_of(fit.model, fit.columns, fit.state)[:n]
    rows = int((np.abs(fit.whitener[some]).sum(axis=2) > 0).sum())
    patterns, of, size = once(sized(forms))
    S, u, chi2, dof = without_background(
        J.reshape(-1, n), offset, e.ravel(), rows, products_of(patterns, J, e, some)
    )
    return Reduced(slices_of(components), Stored(S, of, size), u[of] * size, chi2, dof, noise_dof)


def slices_of(components: Sequence[Component]) -> tuple[tuple[slice, ...], ...]:
    """Where each component's forms stand among the columns of all."""
    return parts_of([len(form.sizes) for form in component.forms] for component in components)


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
    J: Array, offset: Array, e: Array, rows: int, of: Products
) -> tuple[Array, Array, float, float]:
    """S (g, g), u (g,), χ² and degrees of freedom that a background leaves of columns G, by their products
    (S stands in the place of theirs), and of data e (R,).

    J: (R, n) the background in its priors, offset: (n,) how far it is from their means; rows: with data."""
    n = J.shape[1]
    upper = _upper(J)
    Z = solve_triangular(upper, of.JG, trans="T", check_finite=False)
    z = solve_triangular(upper, J.T @ e - offset, trans="T", check_finite=False)
    inverse = solve_triangular(upper, np.eye(n), trans="T", check_finite=False)
    dof = rows - (n - float((inverse**2).sum()))
    return less(of.GG, Z), of.Ge - Z.T @ z, float(e @ e + offset @ offset - z @ z), dof


def less(GG: Array, Z: Array) -> Array:
    """GG (g, g) − ZᵀZ of Z (n, g), in the place of GG, some rows at a time: to be given room for a second of
    some thousand columns takes longer than to work it out."""
    for at in range(0, len(GG), ROWS):
        GG[at : at + ROWS] -= Z[:, at : at + ROWS].T @ Z
    return GG


def _upper(J: Array) -> Array:
    """(n, n) upper triangular U with UᵀU = JᵀJ + 1. Of columns that the data do not tell apart the squares
    lose the 1 by rounding: then by the columns themselves, which takes twice as long."""
    eye = np.eye(J.shape[1])
    try:
        return np.asarray(np.linalg.cholesky(J.T @ J + eye).T)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.qr(np.vstack([J, eye]), mode="r"))
