"""How likely a scatter is, by the variances of what adds up to it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..robot.kinematics import Array


def cost_of(
    variances: Array, d: Array, fixed: Array, parts: Sequence[Array], lost: float
) -> tuple[float, Array]:
    """Twice the negative log likelihood of d (N, D), and its gradient (k,) by the variances (k,).

    fixed: (D, D) or (N, D, D) covariance beside that of the k parts (N, D, D); lost: by how much a fit made
    the squares of d smaller. Raises LinAlgError where the covariance is singular."""
    C = fixed + sum(v * part for v, part in zip(variances, parts, strict=True))
    inverse = np.linalg.inv(C)
    w = np.einsum("nij,nj->ni", inverse, d)
    slope = [
        np.sum(inverse * part) - lost * float(np.einsum("ni,nij,nj->", w, part, w, optimize=True))
        for part in parts
    ]
    return float(np.linalg.slogdet(C)[1].sum() + lost * np.sum(w * d)), np.array(slope)
