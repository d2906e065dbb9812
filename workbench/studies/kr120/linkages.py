"""What gas springs on any plausible linkage do to joint 2's stiffness, and what fits Table I on each of
them."""

from __future__ import annotations

import numpy as np
from scipy import stats

from workbench import Array, Draws, Figure, Prior, charts, fit_spring, gas_spring, numbers

from .plans import ANGLES
from .printed import ATMOSPHERE, HALF_1, SIX, TABLE_1

MOST_TORQUE = 20e3  # N·m: above what a drive of this class and a gravity torque of 10 kN·m can balance
CHANGE_1 = float(np.ptp(1 / TABLE_1[SIX]))  # N·m/rad, of Table I

PRIORS = {
    "a": Prior("a, pivot on the column to joint 2", 0.4, 1.2, "m", why="the size of the column"),
    "L": Prior("L, pivot on the arm to joint 2", 0.1, 0.4, "m", why="the size of the arm's root"),
    "alpha": Prior("α", 0, 180, "°", why="any"),
    "pressure": Prior("charge", 50, 250, "bar", why="a KR 300's is 163"),
    "area": Prior("piston", 5, 30, "cm²", why="a KR 300's is 17"),
    "length": Prior("gas length over its stroke", 1.2, 5, "", True, "a KR 300's is 1.9"),
    "exponent": Prior("polytropic exponent", 1, 1.4, "", why="at rest 1, in fast moves up to 1.4"),
    "low": Prior("lowest angle", -150, -110, "°", why="within joint 2's limits"),
    "high": Prior("highest angle", -40, 20, "°", why="within joint 2's limits"),
}


def linkages(count: int, fits: int, seed: int) -> Draws:
    """`count` linkages that the arm can hold: `change` [N·m/rad] of joint 2's stiffness over its six angles,
    and its share of Table I's; of the first `fits`: p of the best gas spring of any strength by eq. (12),
    with CI as one sigma, and the largest force [N] that it would need."""
    rng = np.random.default_rng([seed, 9])
    kept: list[dict[str, float]] = []
    found: list[tuple[float, ...]] = []
    while len(kept) < count:
        v = {name: prior.at(float(rng.random())) for name, prior in PRIORS.items()}
        triangle = gas_spring.Linkage(v["a"], v["L"], float(np.radians(v["alpha"])))
        q = np.radians(np.linspace(v["low"], v["high"], ANGLES))
        torque, added = _spring(triangle, v, q)
        if np.abs(torque).max() > MOST_TORQUE:
            continue
        kept.append(v)
        fit = _fitted(triangle, q, rng) if len(kept) <= fits else (np.nan, np.nan)
        found.append((float(np.ptp(added)), float(np.ptp(added)) / CHANGE_1, *fit))
    names = ("change", "share_of_table", "fit_p", "fit_force")
    columns = dict(zip(names, np.array(found).T, strict=True))
    return Draws(PRIORS, {name: np.array([v[name] for v in kept]) for name in PRIORS}, columns)


def _spring(triangle: gas_spring.Linkage, v: dict[str, float], q: Array) -> tuple[Array, Array]:
    """Torque [N·m] and added stiffness [N·m/rad] at angles q, eqs. (5) to (7) with an exponent."""
    s, slope, bend = triangle.stretch(q)
    ds, n, area = s - s.min(), v["exponent"], 1e-4 * v["area"]
    length = v["length"] * float(ds.max())
    gas = area * 1e5 * v["pressure"] * (length / (length - ds)) ** n
    force = gas - area * ATMOSPHERE
    return -force * slope, n * gas / (length - ds) * slope**2 + force * bend


def _fitted(triangle: gas_spring.Linkage, q: Array, rng: np.random.Generator) -> tuple[float, float]:
    """p and largest force of eq. (12) with the angles in a rising, a falling or any order."""
    at = (q, q[::-1], rng.permutation(q))[int(rng.integers(3))]
    spring = fit_spring(triangle, 1e-3, at, TABLE_1[SIX], HALF_1[SIX])
    return float(stats.chi2.sf(spring.chi2, spring.dof)), float(np.abs(spring.force).max())


def linkage_numbers(draws: Draws) -> dict[str, float]:
    """For the story."""
    made = np.isfinite(draws.numbers["fit_p"])
    p, force = draws.numbers["fit_p"][made], draws.numbers["fit_force"][made]
    low, middle, high = draws.range("change")
    return {
        "linkages": float(draws.count),
        "printed_change_kNm": 1e-3 * CHANGE_1,
        "linkage_change_kNm_p05": 1e-3 * low,
        "linkage_change_kNm_mid": 1e-3 * middle,
        "linkage_change_kNm_p95": 1e-3 * high,
        "linkage_change_kNm_most": 1e-3 * float(draws.numbers["change"].max()),
        "linkage_share_most": float(draws.numbers["share_of_table"].max()),
        "most_torque_kNm": 1e-3 * MOST_TORQUE,
        "linkage_fits": float(made.sum()),
        "linkage_fit_rejected": float((p < 0.01).mean()),
        "linkage_fit_p_most": float(p.max()),
        "linkage_force_MN_p05": 1e-6 * float(np.quantile(force, 0.05)),
        "linkage_force_MN_mid": 1e-6 * float(np.median(force)),
    }


def linkage_figure(draws: Draws) -> Figure:
    """How far gas springs change joint 2's stiffness, against Table I."""
    change = 1e-3 * draws.numbers["change"]
    most, needed = numbers.significant(float(change.max()), 2), numbers.significant(1e-3 * CHANGE_1, 3)
    title = (
        f"None of {numbers.decimals(len(change), 0)} gas springs within "
        f"{numbers.decimals(1e-3 * MOST_TORQUE, 0)} kN·m changes joint 2's stiffness "
        "by more "
        f"than {most} kN·m/rad; Table I needs {needed}"
    )
    marks = {"Table I": 1e-3 * CHANGE_1, "median": float(np.median(change))}
    label = "change of joint 2's stiffness over the six angles, kN·m/rad"
    return charts.histogram("linkages", title, change, label, marks, log=True)
