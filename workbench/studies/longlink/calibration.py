"""Two-step calibration: circle points give a, α and the ratios, points of a ball then d and θ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Axes,
    Campaign,
    Fit,
    Robot,
    Target,
    axes_of,
    by_joint,
    deflection,
    sweeps,
    with_compliance,
    write_campaign,
    zeros_and_offsets,
)
from workbench import denavit_hartenberg as dh

from .arm import ARM, BALL, RING, SIGMA, STATION
from .printed import FITTED, JUDGED, TABLE_2, TABLE_3, UNIT

# assumed, for the paper does not give them
FORTY = 40  # points, where thirteen are too few
RATIO = np.array([3e-4, -2e-4, 5e-4, 1e-4, -4e-4, 8e-4, -3e-4])  # true travel over commanded, minus one
HOME, SPANS = np.radians([0, -70, 70, 0, 0, 0, 0]), np.radians([100, 50, 50, 100, 100, 100, 100])
STOPS = 21
ANY = 300  # of the random poses, looked at for collisions
MARK = Target("mark", (0.15, 0.0, 0.05), fixed=True)
AXIAL = [3, 0]  # columns d, θ


@dataclass(frozen=True, eq=False)
class Measured:
    """Sweeps of one joint at a time; points of the ball: thirteen or forty to fit, and those that judge."""

    circles: Campaign
    thirteen: Campaign
    forty: Campaign
    judged: Campaign


@dataclass(frozen=True, eq=False)
class Identified:
    """axes: of the circles; circled: the robot as the circles have it; fit: of its d and θ; table: (7, 4)
    θ, α, a, d [rad, m]; covariance: (14, 14) of d and θ of each joint, with what the circles' noise adds."""

    axes: Axes
    circled: Robot
    fit: Fit
    table: Array
    covariance: Array


def measured(folder: Path, robot: Robot, seed: int) -> Measured:
    """All campaigns of the true robot; circles and thirteen points are written into the folder."""
    q, turned = ARM.poses(FORTY + JUDGED, [seed, 5]), sweeps(HOME, SPANS, STOPS)
    circles = ARM.measured(robot, turned, [seed, 11], [BALL, MARK, *RING], ratio=RATIO)
    thirteen, forty, judged = (
        ARM.measured(robot, part, [seed, 12 + k], ratio=RATIO)
        for k, part in enumerate((q[:FITTED], q[:FORTY], q[FORTY:]))
    )
    circles, thirteen = (
        replace(c, path=write_campaign(folder / name, c, comments=["simulated in Drake"]))
        for name, c in {"circles": circles, "thirteen": thirteen}.items()
    )
    return Measured(circles, thirteen, forty, judged)


def stood_in(data: Measured, seed: int) -> dict[str, Array]:
    """What poses are for → their joints (N, 7) [rad]."""
    return {
        "one joint at a time": data.circles.poses.q,
        "13 points": data.thirteen.poses.q,
        "40 points": data.forty.poses.q,
        "12 points that judge": data.judged.poses.q,
        "difference of the tables, the first": ARM.poses(ANY, seed),
    }


def identified(data: Measured, robot: Robot, seed: int, shakes: int) -> Identified:
    """The robot that circles and thirteen points give, its deflection known; shakes: draws of noise."""
    circles, model = data.circles, robot
    for _ in range(3):  # the deflection comes from the geometry that it helps to find
        sag = deflection(replace(circles, robot=model)) @ STATION[0][0].T
        axes = from_circles(circles.points - sag)
        circled, found = two_steps(data.thirteen, robot, axes)
        table, covariance = dh.fitted_rows(found, axes.rows(TABLE_2))
        model = zeros_and_offsets.with_rows_and_ratios(robot, TABLE_2, table, axes.ratio[:, 0])
    rng, shaken = np.random.default_rng([seed, 20]), []
    for _ in range(shakes):  # what the noise of the circles adds to the intervals of d and θ
        other = from_circles(circles.points - sag + rng.normal(scale=SIGMA, size=circles.points.shape))
        again = two_steps(data.thirteen, robot, other)[1]
        shaken.append(dh.fitted_rows(again, other.rows(TABLE_2))[0][:, AXIAL].ravel())
    return Identified(axes, circled, found, table, covariance + np.cov(np.array(shaken).T))


def from_circles(points: Array) -> Axes:
    """Axes from the sweeps' points (7 · STOPS, T, 3) [m]: ball, mark, ..."""
    along = dh.chain(TABLE_2, HOME[None])[0, 1:-1, :3, 0] @ STATION[0][0].T
    commanded = np.outer(SPANS, np.linspace(-1, 1, STOPS))
    return axes_of(points.reshape(7, STOPS, -1, 3), commanded, along)


def two_steps(points: Campaign, robot: Robot, axes: Axes) -> tuple[Robot, Fit]:
    """The robot as the circles have it, and the fit of its d and θ to the points of the ball."""
    circled = zeros_and_offsets.with_rows_and_ratios(robot, TABLE_2, axes.rows(TABLE_2), axes.ratio[:, 0])
    return circled, zeros_and_offsets.identified(zeros_and_offsets.with_ball(points, axes.ball[0]), circled)


def stages(data: Measured, robot: Robot, found: Identified) -> dict[str, Fit]:
    """Fits of less and of more than d and θ, by name."""
    designed = with_compliance(robot, 0.0)
    seen = zeros_and_offsets.with_ball(data.thirteen, found.axes.ball[0])
    rigid = with_compliance(found.circled, 0.0)
    return {
        "designed": zeros_and_offsets.identified(data.thirteen, designed, []),
        "circles": zeros_and_offsets.identified(seen, rigid, []),
        "rigid": zeros_and_offsets.identified(seen, rigid),
        "known": found.fit,
        "together": zeros_and_offsets.fit_at_once([data.circles, data.thirteen], robot, compliance=False),
        "all_13": zeros_and_offsets.fit_at_once([data.thirteen], robot),
        "all_40": zeros_and_offsets.fit_at_once([data.forty], robot),
    }


def circle_numbers(data: Measured, found: Identified) -> dict[str, float]:
    """Values of the circles with their intervals, and their shift when deflection stays in the points."""
    value, std = found.axes.values.T
    shift, half = from_circles(data.circles.points).values[:, 0] - value, 1.96 * std
    true = np.array([*1e3 * TABLE_3[:6, 2], *np.degrees(TABLE_3[:6, 1]), *1e6 * RATIO, 1e3 * TABLE_3[6, 2]])
    out = {"a_7": value[19], "a_half_7": half[19]}
    for name, part in {"a": slice(0, 6), "alpha": slice(6, 12), "ratio": slice(12, 19)}.items():
        out |= by_joint(name, value[part]) | by_joint(f"{name}_half", half[part])
        out |= by_joint(f"{name}_bent", shift[part]) | by_joint(f"{name}_true", true[part])
    worst = int(np.abs(shift[12:19]).argmax())
    return out | {
        "circle_hits": float((np.abs(value - true) < half).sum()),
        "circle_intervals": float(len(half)),
        "bias_a_mm": float(np.abs(shift[:6]).max()),
        "half_a_mm": float(half[:6].mean()),
        "bias_ratio_ppm": float(abs(shift[12 + worst])),
        "bias_ratio_joint": worst + 1.0,
    }


def axial_numbers(found: Identified, rigid: Fit) -> dict[str, float]:
    """d [mm] and θ [°] with their intervals; rigid: the fit of joints that are taken as rigid."""
    unit = UNIT[AXIAL]
    value, true = found.table[:, AXIAL] / unit, TABLE_3[:, AXIAL] / unit
    half = 1.96 * np.sqrt(np.diag(found.covariance)).reshape(7, 2) / unit
    decided = half < 1.96 * np.array([1.0, 0.1])  # mm, °: what the prior leaves is more
    d, d_true = float(value[1:3, 0].sum()), float(true[1:3, 0].sum())  # axes 2 and 3 are parallel
    d_half = 1.96 / unit[0] * float(np.sqrt(found.covariance[np.ix_([2, 4], [2, 4])].sum()))
    hits = [*(np.abs(value - true) < half)[decided], abs(d - d_true) < d_half]
    sagging = dh.fitted_rows(rigid, found.axes.rows(TABLE_2))[0] - found.table
    return {
        **by_joint("d", value[:, 0]),
        **by_joint("d_half", half[:, 0]),
        "d_sum": d,
        "d_sum_half": d_half,
        **by_joint("theta", value[:, 1]),
        **by_joint("theta_half", half[:, 1]),
        **by_joint("sag", np.degrees(sagging)[:, 0], "_deg"),
        "d_theta_hits": float(sum(hits)),
        "d_theta_intervals": float(len(hits)),
        "rank": float(found.fit.rank),
        "columns": float(len(found.fit.columns.names)),
    }


def miss_numbers(miss: Mapping[str, Array]) -> dict[str, float]:
    """Errors on the points that judge by model, and the mean length of the noise alone [mm]."""
    out = {f"{name}_mean_mm": float(m.mean()) for name, m in miss.items()}
    out |= {f"{name}_largest_mm": float(m.max()) for name, m in miss.items()}
    return out | {"noise_mean_mm": 1e3 * SIGMA * np.sqrt(8 / np.pi)}
