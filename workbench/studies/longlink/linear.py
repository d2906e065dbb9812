"""The arm near Table II, linear in all that may be wrong with it: quick enough for thousands of draws.

Poses of a pool, with the motion of the tip by each entry of the table, by each reduction ratio, and by what
yields under the arm's own weight; and what the same sag does to lengths and twists from circle points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from workbench import Array, Robot, deflection, deflection_budget, load_robot, planned, sweeps
from workbench import denavit_hartenberg as dh

from .arm import ARM, BALL, STATION
from .calibration import HOME, MARK, SPANS, STOPS, from_circles
from .printed import TABLE_2

POOL = 300  # poses
RANGES = (30, 45, 60, 90, 120)  # ± °
FLOOR = -0.9  # m: lowest z of hand and wrist above the floor, axis 2 being at 0
STEP = 1e-6  # rad, m: of the derivatives
THETA, ALPHA, A, D = range(4)


@dataclass(frozen=True, eq=False)
class Pool:
    """N poses: entries (N, 3, 7, 4) [m/rad, m/m] of the tip by θ, α, a, d; ratios: (N, 3, 7) [m] by travel
    over commanded travel; parts: kind → (N, 7, 3) [m] motion by what yields, as assumed."""

    entries: Array
    ratios: Array
    parts: dict[str, Array]


@cache
def assumed() -> Robot:
    """The arm with the stiffness of its TOML."""
    return load_robot("longlink")


@cache
def pool(limit: int, above: bool) -> Pool:
    """Poses within ±limit [°], with hand and wrist above the floor where `above` says so."""
    q = poses(POOL, [0, limit, int(above)], limit, FLOOR if above else None)
    budget = deflection_budget(planned(assumed(), q, targets=ARM.targets[:1]))
    entries = np.empty((len(q), 3, 7, 4))
    for i, j in np.ndindex(7, 4):
        more, less = TABLE_2.copy(), TABLE_2.copy()
        more[i, j] += STEP
        less[i, j] -= STEP
        entries[:, :, i, j] = (tip(more, q) - tip(less, q)) / (2 * STEP)
    return Pool(entries, entries[:, :, :, THETA] * q[:, None, :], dict(budget.parts))


def poses(count: int, seed: list[int], limit: float, floor: float | None = None) -> Array:
    """(count, 7) random joints within ±limit [°]; floor: lowest z [m] of what lies beyond joint 3."""
    if floor is None:
        return ARM.poses(count, seed, limit)
    q = ARM.poses(40 * count, seed, limit)
    above = dh.chain(TABLE_2, q)[:, 3:, 2, 3].min(axis=1) > floor
    return np.asarray(q[above][:count])


def tip(table: Array, q: Array) -> Array:
    """(N, 3) [m] the last frame's origin by a table."""
    return np.asarray(dh.chain(table, q)[:, -1, :3, 3])


@cache
def circle_bias() -> dict[str, Array]:
    """What sag as assumed does to circle points, by kind: (19,) shift of a₁ … a₆ [m], α₁ … α₆ [rad] and the
    ratios."""
    q = sweeps(HOME, SPANS, STOPS)
    still = from_circles(_sweep(q, _only(None))).values[:, 0]
    return {
        kind: (from_circles(_sweep(q, _only(kind))).values[:, 0] - still)[:19] * UNITS
        for kind in ("torsion", "overturning")
    }


UNITS = np.array([1e-3] * 6 + [np.pi / 180] * 6 + [1e-6] * 7)
"""[m, rad, 1] of the circles' values: mm, °, ppm."""


def _sweep(q: Array, robot: Robot) -> Array:
    """(N, 2, 3) [m] ball and mark in the instrument's frame."""
    plan = planned(robot, q, targets=(BALL, MARK))
    where = dh.chain(TABLE_2, q)[:, -1]
    places = np.stack([where[:, :3, 3] + where[:, :3, :3] @ np.array(t.xyz) for t in (BALL, MARK)], axis=1)
    return (places + deflection(plan)) @ STATION[0][0].T + STATION[1][0]


def _only(kind: str | None) -> Robot:
    """The arm that yields in one way, or not at all."""
    keep = {"torsion": "stiffness", "overturning": "tilt_stiffness"}.get(kind or "")
    joints = []
    for joint in assumed().joints:
        new = {key: None for key in ("stiffness", "tilt_stiffness") if key != keep}
        joints.append(replace(joint, data=joint.data.model_copy(update=new)))
    return replace(assumed(), joints=tuple(joints), bending_stiffness={})


@dataclass(frozen=True, eq=False)
class Wrong:
    """What is wrong with an arm. table: (7, 4) [rad, m] true minus designed; torsion, tilt, link: (7,) over
    what is assumed (links: over Table I); ratio: (7,); circle: (7, 4) errors of the lengths and twists from
    circles; compensated: share of the sag that the calibration takes out; noise: [m] per axis."""

    table: Array
    torsion: Array
    tilt: Array
    link: Array
    ratio: Array
    circle: Array
    compensated: float
    noise: float


@dataclass(frozen=True, eq=False)
class Calibrated:
    """before, after: (J, 3) [m] errors of the points that judge; table: (7, 4) calibrated minus designed;
    geometry: (J, 3) [m] what the calibrated table moves the tip by against the designed one."""

    before: Array
    after: Array
    table: Array
    geometry: Array


RIDGE = np.array([5e-3, 5e-3])  # rad, m: how far zeros and offsets may go where no point decides


def calibrated(
    where: Pool, wrong: Wrong, fitted: int, judged: int, rng: np.random.Generator, rigid: bool = False
) -> Calibrated:
    """Two-step calibration: lengths and twists from circles, then zeros and offsets from `fitted` points;
    `judged` others judge. rigid: all entries are fitted to the points instead, and no circle is used."""
    take = rng.choice(len(where.entries), fitted + judged, replace=False)
    J = where.entries[take]
    sag = sum(
        np.einsum("njc,j->nc", where.parts[kind][take], scale)
        for kind, scale in (("torsion", wrong.torsion), ("overturning", wrong.tilt), ("link", wrong.link))
    )
    geometry = np.einsum("ncij,ij->nc", J, wrong.table)
    noise = wrong.noise * rng.normal(size=geometry.shape)
    seen = geometry + sag + np.einsum("ncj,j->nc", where.ratios[take], wrong.ratio) + noise
    taken = seen - wrong.compensated * np.asarray(sag)
    table = np.zeros((7, 4))
    if not rigid:
        table[:, [ALPHA, A]] = (wrong.table + wrong.circle)[:, [ALPHA, A]]
        bias = circle_bias()
        left = 1 - wrong.compensated
        shift = left * (bias["torsion"] * wrong.torsion.mean() + bias["overturning"] * wrong.tilt.mean())
        table[:6, A] += shift[:6]
        table[:6, ALPHA] += shift[6:12]
    free = [THETA, ALPHA, A, D] if rigid else [THETA, D]
    columns = J[:fitted][:, :, :, free].reshape(3 * fitted, -1)
    spread = np.tile([RIDGE[0] if j in (THETA, ALPHA) else RIDGE[1] for j in free], 7)
    y = (taken[:fitted] - np.einsum("ncij,ij->nc", J[:fitted], table)).ravel()
    rows = np.vstack([columns * spread, 1e-4 * np.eye(len(spread))])
    x = np.linalg.lstsq(rows, np.concatenate([y, np.zeros(len(spread))]), rcond=None)[0] * spread
    table[:, free] += x.reshape(7, -1)
    made = np.einsum("ncij,ij->nc", J, table)
    return Calibrated(seen[fitted:], (taken - made)[fitted:], table, made[fitted:])
