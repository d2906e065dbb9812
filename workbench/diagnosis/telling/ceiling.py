"""What a smooth model could still reach: all our components at once, each as large as the data want it.

Automatic relevance determination (MacKay 1992): the prior variance of each component's weights maximises the
evidence, by its fixed-point iteration; what the data do not want goes to zero. Then every pose is predicted
from the others in closed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ...effects.base import Effect
from ...effects.unnamed import unnamed
from ...identification.fit import Fit
from ...identification.patterns import once, products_of
from ...robot.kinematics import Array
from ..weighing.by_itself import worth_offering
from ..weighing.chosen import Chosen
from ..weighing.components import Component, Form, cause_components, nameless_components, sized
from ..weighing.gram import Stored
from ..weighing.reduced import Reduced, explained, less, slices_of
from ..weighing.screen import effective_dof
from ..weighing.sets import Competition

ROUNDS = 25
FAINTEST = 1e-5  # squared scale, in usual sizes, at which a component is gone
SPEAKS = 1.0  # log Bayes factor, each alone, from which a component is tried
LEAST = 0.05  # effective number of weights below which it is gone
LEAST_NOISE = 1e-2  # of the variance that the noise says: what is left of exact data has no digits
MOST_ROWS = 9000


def ceiling_mm(final: Fit, candidates: Sequence[Effect]) -> float:
    """RMS length [mm] of the errors of poses predicted from the others, with everything in the model."""
    problem = final.model.problem
    every = len(final.r)
    step = max(1, int(np.ceil(every * final.r.shape[1] / MOST_ROWS)))
    some = np.arange(0, every, step)
    near = [e for e in candidates if e.key not in {own.key for own in final.model.effects}]
    nameless = worth_offering(final, nameless_components(final, unnamed(problem)), 0.0)
    components = [*cause_components(final, near), *nameless]
    blocks = [form.columns[some] * form.sizes for form in _worth_trying(final, components)]
    J = final.J[some] * final.columns.prior
    r = (final.r + explained(final))[some]
    own = J.shape[2]
    A = np.concatenate([J, *blocks], axis=2)
    ends = np.cumsum([own, *(block.shape[2] for block in blocks)])
    parts = [np.arange(a, b) for a, b in pairwise(ends)]
    flat = A.reshape(-1, A.shape[2])
    rows = int((np.abs(final.whitener[some]).sum(axis=2) > 0).sum())
    columns, precision = _relevant(flat.T @ flat, flat.T @ r.ravel(), float((r**2).sum()), own, parts, rows)
    left = _left_out(A[:, :, columns], r, precision, problem.positions[some])
    inverse = np.linalg.pinv(final.whitener[some])
    points = np.matmul(inverse, left[..., None])[..., 0][:, : 3 * problem.seen.shape[1]]
    length = np.linalg.norm(points.reshape(len(some), -1, 3), axis=2)[problem.seen[some]]
    return 1e3 * float(np.sqrt(np.mean(length**2)))


def _worth_trying(final: Fit, components: Sequence[Component]) -> list[Form]:
    """The likeliest form of each component that has any evidence."""
    forms = [form for component in components for form in component.forms]
    patterns, of, size = once(sized(forms))
    products = products_of(patterns, final.J * final.columns.prior, final.r, np.arange(len(final.r)))
    Z = solve_triangular(final.upper, products.JG, trans="T", check_finite=False)
    dof = effective_dof(final)
    S = Stored(less(products.GG, Z), of, size)
    reduced = Reduced(slices_of(components), S, products.Ge[of] * size, final.chi2, dof, 0.0)
    weights = Competition(reduced, components).beside(Chosen(reduced, []))
    return [
        components[k].forms[weight.form]
        for k, weight in weights.items()
        if weight.log_odds - components[k].log_odds > SPEAKS
    ]


def _relevant(
    normal: Array, right: Array, total: float, own: int, parts: list[NDArray[np.int64]], rows: int
) -> tuple[NDArray[np.int64], Array]:
    """Numbers of the columns that stay, and their prior precisions over the noise's."""
    scale = np.ones(len(parts))
    live, noise = list(range(len(parts))), 1.0

    def staying() -> tuple[NDArray[np.int64], Array]:
        columns = np.concatenate([np.arange(own), *(parts[k] for k in live)])
        return columns, np.concatenate([np.ones(own), *(np.full(len(parts[k]), 1 / scale[k]) for k in live)])

    for _ in range(ROUNDS):
        columns, precision = staying()
        M = normal[np.ix_(columns, columns)] / noise + np.diag(precision)
        half = solve_triangular(np.linalg.cholesky(M), np.eye(len(M)), lower=True, check_finite=False)
        weights = half.T @ (half @ (right[columns] / noise))
        variance = (half**2).sum(axis=0)
        at, kept = own, []
        for k in live:
            here = slice(at, at + len(parts[k]))
            at = here.stop
            effective = len(parts[k]) - float(variance[here].sum()) / scale[k]
            if effective > LEAST:
                scale[k] = float(weights[here] @ weights[here]) / effective
                if scale[k] > FAINTEST:
                    kept.append(k)
        used = len(columns) - float(variance @ precision)
        rest = total - weights @ (2 * right[columns] - normal[np.ix_(columns, columns)] @ weights)
        noise = max(float(rest), 1e-12 * total, LEAST_NOISE * rows) / max(rows - used, 1.0)
        live = kept
    columns, precision = staying()
    return columns, precision * noise


def _left_out(A: Array, r: Array, precision: Array, group: NDArray[np.int64]) -> Array:
    """(N, D) residuals of each pose by the fit to all others, (1 − H)⁻¹ times what the whole fit leaves."""
    flat = A.reshape(-1, A.shape[2])
    L = np.linalg.cholesky(flat.T @ flat + np.diag(precision))
    Z = solve_triangular(L, flat.T, lower=True, check_finite=False)
    rest = r.ravel() - Z.T @ (Z @ r.ravel())
    Z = Z.T.reshape(*r.shape, -1)
    rest, out = rest.reshape(r.shape), np.empty_like(r)
    order = np.argsort(group, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        z = Z[members].reshape(-1, Z.shape[2])
        out[members] = np.linalg.solve(np.eye(len(z)) - z @ z.T, rest[members].ravel()).reshape(
            len(members), -1
        )
    return out
