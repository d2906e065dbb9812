"""Stages: how far off each model is, on its own poses and on held-out ones; and the errors point by point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...effects.base import Effect
from ...identification.fit import Fit, fit, refit
from ...identification.heldout import heldout
from ...robot.kinematics import Array
from ..found import GIVEN, NAMELESS, PoseErrors, Stage
from ..prepared import Prepared

Group = tuple[Effect, list[int]]  # an accepted cause, and which of the fit's effects are its parts

NEAR_STATED = (
    "The poses cannot tell the instrument's frame from the targets: the targets stay near the stated places."
)


def geometry_alone(prepared: Prepared) -> Fit:
    """Geometry without what was given."""
    fitted = prepared.geometry
    if not fitted.model.given:
        return fitted
    start = replace(fitted.state, given=np.zeros(0))
    return fit(replace(fitted.model, given=()), start, prepared.covariance)


def stages_of(prepared: Prepared, alone: Fit, final: Fit, groups: Sequence[Group], seed: int) -> list[Stage]:
    """Nominal, geometry, one stage for what was given, one per cause, and one for what has no name. alone:
    geometry without what was given."""
    fits = [("nominal", prepared.nominal), ("geometry", alone)]
    members: list[int] = []
    name = "geometry"
    if alone is not prepared.geometry:
        name += f" + {GIVEN}"
        fits.append((name, prepared.geometry))
    for effect, own in groups:
        members += own
        name += f" + {effect.label}"
        whole = len(members) == len(final.model.effects)
        fits.append((name, final if whole else refit(final, [final.model.effects[m] for m in members])))
    if len(members) < len(final.model.effects):
        fits.append((f"{name} + {NAMELESS}", final))
    stages = []
    for name, result in fits:
        out = heldout(result, seed=seed)
        added = 0 if result is prepared.nominal else result.rank - prepared.nominal.rank
        undecided = result is prepared.nominal and result.rank < len(result.columns.names)
        stages.append(_stage(name, added, result, out, NEAR_STATED if undecided else ""))
    return stages


def _stage(name: str, parameters: int, result: Fit, out: Array, note: str) -> Stage:
    length = np.linalg.norm(out, axis=2)
    mean, largest = float(np.nanmean(length)), float(np.nanmax(length))
    fitted = rms_mm(result.residual)
    return Stage(name, parameters, rms_mm(out), 1e3 * mean, 1e3 * largest, fitted, note)


def rms_mm(residual: Array) -> float:
    """RMS length [mm] of residuals (N, T, 3) [m], NaN where not seen."""
    return 1e3 * float(np.sqrt(np.nanmean(np.linalg.norm(residual, axis=2) ** 2)))


def without(final: Fit, own: Sequence[int], seed: int) -> float:
    """Held-out RMS [mm] of the final model without some of its effects."""
    return rms_mm(heldout(final, seed=seed, without=own))


def pose_errors(prepared: Prepared, geometry: Fit, final: Fit) -> PoseErrors:
    """Errors per point, turned into the base frame."""
    c = prepared.problem.campaign
    R = final.state.R[c.poses.setup]
    base = np.einsum("nij,nti->ntj", R, c.points - final.state.t[c.poses.setup][:, None])
    seen = prepared.problem.seen
    n, t = np.nonzero(seen)

    def turned(result: Fit) -> Array:
        return np.einsum("nij,nti->ntj", result.state.R[c.poses.setup], result.residual)[seen]

    return PoseErrors(
        base[seen],
        turned(prepared.nominal),
        turned(geometry),
        turned(final),
        n.astype(np.int64),
        t.astype(np.int64),
        tuple(c.poses.ids),
        tuple(target.name for target in c.targets),
    )
