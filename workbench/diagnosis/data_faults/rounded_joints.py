"""Joints written down with too few digits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ...identification.fit import Fit
from ..found import FaultFound, Noise
from ..weighing.remainder import Remainder, remainder
from ..weighing.screen import effective_dof, reduce_columns

DEGREES, RADIANS = (1.0, 0.5, 0.1, 0.05, 0.01, 0.005), (0.01, 0.001, 0.0001)
STEPS = {  # rad: as it is said
    **{float(np.radians(step)): f"{step:g}°" for step in DEGREES},
    **{step: f"{step:g} rad" for step in RADIANS},
}
EXACTLY = 1e-6  # of a step
CHANCE = 1e-3  # that rounding makes as much of what poses with one written value are off by together
SEEN = 1e-6  # of the largest: along other axes geometry takes all of it
MADE_BY_ROUNDING = (0.4, 2.5)  # times the scatter left over that rounding must make to be suspected of it
ALL_OF_IT = (0.7, 1.4)  # the same where that scatter is all that is known of the noise
SHARED = 3.0  # rows that have one value of a joint: from there on they have one error of rounding, too


def rounded_joints(final: Fit, geometry: Fit, noise: Noise, left: Remainder) -> tuple[FaultFound, ...]:
    """Joints that are multiples of a step which alone would make the scatter that is left; where nobody knows
    the noise, what `geometry` leaves.

    Commands are often round numbers and then exact; only unexplained scatter makes them suspect.
    """
    if noise.source == "residual":
        excess, (least, most) = _left(geometry), ALL_OF_IT
    elif left.scatter:
        excess, (least, most) = left.excess(noise.sigma_mm * 1e-3), MADE_BY_ROUNDING
    else:
        return ()
    found = _step(final)
    if found is None or not least * excess < found[1] < most * excess:
        return ()
    step, made = found
    what = f"all joints are multiples of {STEPS[step]}, which alone scatters {made * 1e3:.3f} mm per axis"
    return (FaultFound("rounded_joints", None, None, what, "kept: record the joints with more digits"),)


def shared_rounding(geometry: Fit) -> tuple[str, ...]:
    """Joints of which a function of the angle may be their rounding: many poses have one written value, and
    with it one error, of a size that what geometry leaves does not exclude."""
    return _suspected(geometry)[0]


def all_rounding(geometry: Fit) -> tuple[str, ...]:
    """Those of `shared_rounding` whose rounding may be all that they are off by."""
    names, step = _suspected(geometry)
    index = geometry.model.problem.arm.names.index
    return tuple(name for name in names if not _off_by_more(geometry, index(name), step))


def _suspected(geometry: Fit) -> tuple[tuple[str, ...], float]:
    """Joints that `shared_rounding` has, and to which step [rad] they are rounded."""
    found, names = _step(geometry), geometry.model.problem.arm.names
    if found is None or found[1] > MADE_BY_ROUNDING[1] * _left(geometry):
        return (), 0.0
    step, few = found[0], _few_values(geometry, found[0])
    return tuple(name for name, shared in zip(names, few, strict=True) if shared), step


def _off_by_more(geometry: Fit, j: int, step: float) -> bool:
    """Whether poses with one written value of a joint are off together by more than its rounding to a step
    [rad] makes: with an error of its own, of variance step²/12, for each value."""
    problem, r = geometry.model.problem, geometry.r.ravel()
    values, which = np.unique(np.round(problem.q[:, j] / step), return_inverse=True)
    motion = geometry.line.by_joint[:, :, j]
    own = np.einsum("ndr,nr->nd", geometry.whitener[:, :, : motion.shape[1]], motion)
    G = np.zeros((*own.shape, len(values)))
    G[np.arange(len(own)), :, which] = own
    S, u, _ = reduce_columns(geometry, G)
    size, axes = np.linalg.eigh(S)
    told = size > SEEN * size.max()
    size, along = size[told], (axes.T @ u)[told]
    others = max(effective_dof(geometry) - len(size), 1.0)
    scatter = max(float(r @ r - (along**2 / size).sum()), 0.0) / others
    chi2 = float((along**2 / (size * (scatter + step**2 / 12 * size))).sum())
    return bool(chdtrc(len(size), chi2) < CHANCE)


def _left(geometry: Fit) -> float:
    """[m] one sigma per axis of what geometry leaves."""
    return geometry.usual * remainder(geometry, known=False).inflation


def _few_values(geometry: Fit, step: float) -> NDArray[np.bool_]:
    """(n,) turning joints that move and have few values for their poses."""
    problem = geometry.model.problem
    counts = np.array([len(np.unique(turns)) for turns in np.round(problem.q / step).T])
    return (counts > 1) & (len(problem.q) >= SHARED * counts) & ~problem.arm.prismatic


def _step(result: Fit) -> tuple[float, float] | None:
    """The largest step [rad] of which all joints are multiples, and the scatter [m] per axis that rounding to
    it makes; None where there is none."""
    problem = result.model.problem
    turning = ~problem.arm.prismatic
    lever = np.sqrt(np.mean(result.line.by_joint**2, axis=(0, 1)))[turning]
    for step in sorted(STEPS, reverse=True) if turning.any() else ():
        turns = problem.q[:, turning] / step
        if np.all(np.abs(turns - np.round(turns)) < EXACTLY):
            return step, float(np.linalg.norm(lever)) * step / np.sqrt(12)
    return None
