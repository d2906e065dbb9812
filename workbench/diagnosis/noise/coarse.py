"""How coarse a machine is: what is usual of an industrial arm says nothing of one that cables drive.

Whatever such a machine has wrong with it is tens to hundreds of times as large as in an industrial arm, and
by those sizes nothing could be what it is. So all usual sizes grow together: by what the geometry and the
joints' compliance, which every arm has, leave over the arm's lever. A noise as large hides what is smaller in
any case.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ...effects.base import Effect
from ...identification.fit import ROUGH, Fit, refit
from ..candidates import testable

INDUSTRIAL = 2e-4  # rad, that an industrial arm has left over its lever: 0.1 to 0.7 mrad measured
COARSE = 1.5e-3  # rad, from which it is none: machines driven by cables or belts have 4 to 11 mrad


def coarseness(geometry: Fit) -> float:
    """How many times as large as in an industrial arm a machine's errors are, from a fit of its geometry; 1
    of all that are not coarse."""
    off = _left(geometry)
    if off < COARSE:
        return 1.0
    with suppress(ArithmeticError):
        off = _left(refit(geometry, _yields(geometry), ROUGH))
    return off / INDUSTRIAL if off >= COARSE else 1.0


def _yields(geometry: Fit) -> list[Effect]:
    """The compliance of every joint, in one form."""
    found = [e for e in testable(geometry.model.problem)[0] if e.always and e.axial and e.in_proportion]
    return list({effect.key: effect for effect in found}.values())


def _left(fit: Fit) -> float:
    """[rad] How far the middle point is off, over how far a turn of one joint by 1 rad moves points."""
    problem, arm = fit.model.problem, fit.model.problem.arm
    off = np.linalg.norm(problem.campaign.points - fit.model.predict(fit.state), axis=2)[problem.seen]
    moved = fit.line.by_joint[:, :, ~arm.prismatic].reshape(*problem.seen.shape, 3, -1)[problem.seen]
    lever = np.sqrt((moved**2).sum(axis=1).mean()) if moved.size else np.inf
    return float(np.median(off) / max(lever, 1e-9))
