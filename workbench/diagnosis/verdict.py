"""What is left when the causes are in the model, and what may be called by its name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.linalg import qr, solve_triangular

from ..effects.base import Effect
from ..identification.fit import Fit
from .families import Family, FamilyTest, families, test_families
from .scan import scatter_of
from .screen import effective_dof, p_value

FAMILY_LEVEL = 0.004  # chance that clean data show a dependence on some variable
GLOBAL_LEVEL = 1e-3  # and that their residual exceeds the noise
INFLATED = 1.10  # residual over noise from which pure scatter counts as something left
STANDS_OUT = 0.01  # p-value, looks counted, that a cause keeps against the scatter along its own direction
SMOOTH_BELOW = 12.0  # cycles per joint turn up to which a gear line is a smooth function of the joint
DWARFS = 25.0  # times the structure left near it that a cause must explain to be sure at once
OVERSHADOWED = 0.5  # share of the unexplained excess that a cause must itself explain to be sure
EXPLAINS_MOST = (
    0.9  # share of the excess that a cause must explain to be named although its form is not exact
)


@dataclass(frozen=True)
class Remainder:
    """chi2, dof, p of the residual against the noise (p NaN where the noise is the residual's own).

    inflation: residual over noise. tests: families that still show something, strongest first, with
    p-values that count all families. structured: something is left that depends on a variable, or
    far more scatter than noise.
    """

    chi2: float
    dof: float
    p: float
    inflation: float
    tests: tuple[tuple[FamilyTest, float], ...]
    structured: bool
    scatter: bool


def remainder(result: Fit, known: bool) -> Remainder:
    """Global test and the families' tests at a fit."""
    dof = effective_dof(result)
    chi2 = result.chi2
    if not known:
        p = float("nan")
    elif np.isinf(result.noise.dof):
        p = float(stats.chi2.sf(chi2, dof))
    else:
        p = float(stats.f.sf(chi2 / dof, dof, result.noise.dof))
    tests = test_families(result)
    significant = []
    for test in tests:
        # structure stands out of what is left, too: noise larger than stated depends on nothing
        judged = {known, False}
        one = len(tests) * max(
            p_value(test.statistic, test.rank, chi2, dof, result.noise.dof, k) for k in judged
        )
        if one < FAMILY_LEVEL:
            significant.append((test, one))
    significant.sort(key=lambda pair: (pair[1], -pair[0].statistic / max(pair[0].rank, 1)))
    inflation = float(np.sqrt(chi2 / dof))
    scatter = bool(known and p < GLOBAL_LEVEL and inflation > INFLATED)
    return Remainder(chi2, dof, p, inflation, tuple(significant), bool(significant) or scatter, scatter)


def stands_alone(result: Fit, i: int, left: Remainder, threshold: float) -> bool:
    """Whether the model's i-th effect stays significant when all that is left is modelled freely too.

    It does when it dwarfs all that is left near it. Of the rest only a fast gear line can: slow functions
    of a joint, of load or of time may be pieces of the unknown. For it the families that still show
    something, and those of its own joint, go into the background: what then remains of the effect
    cannot be a piece of the unknown.
    """
    effect: Effect = result.model.effects[i]
    problem = result.model.problem
    own = None if effect.where.joint is None else problem.joint(effect.where.joint)
    excess = max((t.statistic - t.rank for t, _ in left.tests if _near(effect, own, t.family)), default=0.0)
    if result.wald(i) > DWARFS * excess:
        return True
    if (effect.where.order or 0.0) < SMOOTH_BELOW:
        return False
    blocks = [test.family.columns for test, _ in left.tests[:6]]
    blocks += [f.columns for f in families(result) if own is not None and f.joints == (own,)]
    F = np.concatenate(blocks, axis=2) if blocks else np.zeros((*result.r.shape, 0))
    flat = F.reshape(-1, F.shape[2])
    size = np.linalg.norm(flat, axis=0)
    flat = flat[:, size > 1e-9] / size[size > 1e-9]
    rows = int((np.abs(result.whitener).sum(axis=2) > 0).sum())
    P = result.J.shape[2]
    if P + flat.shape[1] > 0.6 * rows:
        return False
    J = result.J.reshape(-1, P) * result.columns.prior
    stacked = np.block(
        [
            [J, flat],
            [np.eye(P), np.zeros((P, flat.shape[1]))],
            [np.zeros((flat.shape[1], P)), 1e-3 * np.eye(flat.shape[1])],
        ]
    )
    right = np.concatenate([result.r.ravel(), np.zeros(len(stacked) - len(result.r.ravel()))])
    R = qr(np.column_stack([stacked, right]), mode="r", check_finite=False)[0]
    n = stacked.shape[1]
    upper = R[:n, :n]
    step = solve_triangular(upper, R[:n, n])
    inverse = solve_triangular(upper, np.eye(n))
    part = result.columns.effect[i]
    index = np.arange(part.start, part.stop)
    prior = result.columns.prior[index]
    value = result.state.values[i] + step[index] * prior
    covariance = (inverse[index] * prior[:, None]) @ (inverse[index] * prior[:, None]).T
    size = float(value @ np.linalg.solve(covariance, value))
    rss = float(R[n, n] ** 2)
    dof = max(rows - n, 1)
    # against what is left, not against the noise: something unknown is in it
    p = p_value(size, len(index), rss + size, dof + len(index), result.noise.dof, known=False)
    return bool(p < threshold)


def _near(effect: Effect, joint: int | None, family: Family) -> bool:
    """Whether a family is about what the effect (of that joint, if of one) depends on."""
    on = effect.uses
    if on and on <= {"time", "temperature"}:
        return family.kind == "clock"
    if "side" in on:
        return family.kind == "side" and joint in family.joints
    if joint is not None:
        return joint in family.joints
    return family.kind not in ("clock", "side")


def patchwork(effects: Sequence[Effect]) -> set[str]:
    """Joints whose error is a patchwork: a slow line of unknown order beside ratio or eccentricity.

    Such a set draws any smooth function of the joint; none of its members is the cause. A fast line of the
    same joint says that the slow one is a harmonic of a gear.
    """
    lines = [(e.where.joint, e.where.order or SMOOTH_BELOW) for e in effects if e.searched]
    slow = {joint for joint, order in lines if order < SMOOTH_BELOW}
    slow -= {joint for joint, order in lines if order >= SMOOTH_BELOW}
    smooth = {e.where.joint for e in effects if e.smooth}
    return {joint for joint in slow & smooth if joint is not None}


def stands_out(result: Fit, i: int) -> float:
    """p-value of the model's i-th effect against the scatter along its own direction.

    Where something else is going on in the same joint or link, the residual along the effect's direction
    scatters more than the noise from pose to pose, and the effect must stand out of that.
    """
    effect = result.model.effects[i]
    values = result.state.values[i]
    move = result.model.effect_jacobian(result.line, effect, values) @ values
    d = np.matmul(result.whitener, move[..., None])[..., 0]
    size = (d**2).sum(axis=1)
    if not size.any():
        return 1.0
    total, count = scatter_of(result, (d * result.r).sum(axis=1), size)
    scatter = total / count
    rows = result.point_rows
    scatter *= rows / max(effective_dof(result), 1.0)
    p = len(values)
    return float(stats.f.sf(result.wald(i) / p / max(1.0, scatter), p, max(count - p, 1)))


def explained_share(result: Fit, left: Remainder) -> float:
    """Share of what geometry leaves that the causes explain: their misfit against the strongest structure
    left (a sum over all rows would drown it in the noise's own scatter)."""
    explained = sum(result.wald(i) for i in range(len(result.model.effects)))
    excess = max((t.statistic - t.rank for t, _ in left.tests), default=0.0)
    if left.scatter:
        excess = max(excess, left.chi2 - left.dof)
    return explained / (explained + excess) if explained > 0 else 0.0


def describe_structure(left: Remainder, rms_mm: float) -> str:
    """What the unknown depends on, in words."""
    if not left.tests:
        return (
            f"the residual is {left.inflation:.2f} times the noise ({rms_mm:.4f} mm RMS) but depends on no "
            "recorded variable: repeat some poses, and record approach, time and temperature"
        )
    names = [test.family.variable for test, _ in left.tests[:3]]
    return "depends on " + names[0] + (f" (also seen against {', '.join(names[1:])})" if names[1:] else "")
