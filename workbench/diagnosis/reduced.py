"""All components in small matrices: what geometry, frames and targets cannot explain of each column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from ..identification.fit import Fit
from ..identification.rows import equations
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

    def explained(self, chosen: Index, precision: Array) -> float:
        """What columns take off χ², held by their priors."""
        block = self.S[np.ix_(chosen, chosen)] + np.diag(precision)
        return float(self.u[chosen] @ cho_solve(cho_factor(block), self.u[chosen]))


def reduce(
    fit: Fit,
    components: Sequence[Component],
    members: Array | None,
    noise_dof: float,
    poses: Index | None = None,
) -> Reduced:
    """Reduced form at a fit; members: (N, D) what effects in the fit's model explain, given back to the data.

    The fit stops within a hundredth of a standard deviation: one exact linear step is taken here, or columns
    that the background nearly swallows get a false score. poses: only these count.
    """
    parts, blocks, at = [], [], 0
    for component in components:
        own = []
        for form in component.forms:
            blocks.append(form.columns * form.sizes)
            own.append(slice(at, at + len(form.sizes)))
            at += len(form.sizes)
        parts.append(tuple(own))
    some = slice(None) if poses is None else poses
    G = np.concatenate(blocks, axis=2)[some].reshape(-1, at)
    e = (fit.r if members is None else fit.r + members)[some].ravel()
    n = fit.columns.background
    J = fit.J[some, :, :n].reshape(-1, n) * fit.columns.prior[:n]
    rows = int((np.abs(fit.whitener[some]).sum(axis=2) > 0).sum())
    return Reduced(tuple(parts), *without_background(J, background_offset(fit), G, e, rows), noise_dof)


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


def background_offset(fit: Fit) -> Array:
    """How far the background's numbers are from their priors' means, in their priors."""
    at = equations(fit.model, fit.line, fit.columns, fit.state, fit.whitener)
    return at.offset[: fit.columns.background]
