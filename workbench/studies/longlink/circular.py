"""Can the difference of Tables II and III tell geometry from sag? Arms that only sag, arms that do not, and
both."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array, Draws, Prior, StudyRun, Table, draw_many, numbers

from .linear import ALPHA, RANGES, Calibrated, Wrong, calibrated, pool
from .printed import FITTED, JUDGED, TABLE_2, TABLE_3
from .stories import COMMON, MM, YIELDING, mean_mm

PRIORS: dict[str, Prior] = {
    "range": COMMON["range"],
    "floor": COMMON["floor"],
    "noise": COMMON["noise"],
    **YIELDING,
    "unequal": Prior("scatter of the joints' compliance", 0, 0.6, why="no data"),
}
NONE, ZERO = np.zeros(7), np.zeros((7, 4))
HALF_ALPHA = abs(float(np.degrees(TABLE_3[0, ALPHA] - TABLE_2[0, ALPHA]))) / 2  # ° of α₁


def arms(values: Mapping[str, float], seed: int) -> dict[str, float]:
    """One draw of three arms, fitted rigidly as in the paper: `sag`, which has Table II's geometry and
    only yields; `geometry`, Table III's and stiff; `both`. `before`, `after` and `table` [mm]: mean
    error before and after, and of the fitted table against Table II; `share`: of `before` that `table`
    makes; `alpha_1` [°], `alpha_1_free` [°]: of the first with all entries fitted to the points; `z`: 1
    where the mean |z| of the errors before is the largest of the three."""
    rng = np.random.default_rng(seed)
    where = pool(RANGES[int(values["range"])], values["floor"] < 0.5)
    each = values["compliance"] * np.exp(values["unequal"] * rng.normal(size=7))
    found: dict[str, float] = {}

    def arm(table: Array, yields: Array) -> Wrong:
        return Wrong(table, yields, yields * values["bearing"], NONE, NONE, ZERO, 0.0, values["noise"] * MM)

    made = {
        "sag": arm(ZERO, each),
        "geometry": arm(TABLE_3 - TABLE_2, NONE),
        "both": arm(TABLE_3 - TABLE_2, each),
    }
    for name, one in made.items():
        numbers_of_one = _numbers(calibrated(where, one, FITTED, JUDGED, rng))
        found |= {f"{key}_{name}": value for key, value in numbers_of_one.items()}
    free = calibrated(
        where, made["sag"], FITTED, JUDGED, rng, rigid=True
    )  # no circles: all entries from the points
    return found | {"alpha_1_free": float(np.degrees(free.table[0, ALPHA]))}


def _numbers(made: Calibrated) -> dict[str, float]:
    before, table = mean_mm(made.before), mean_mm(made.geometry)
    return {
        "before": before,
        "after": mean_mm(made.after),
        "table": table,
        "share": table / before,
        "alpha_1": float(np.degrees(made.table[0, ALPHA])),
        "z": float(np.abs(made.before).mean(axis=0).argmax() == 2),
    }


def arm_draws(count: int, run: StudyRun) -> Draws:
    """`arms` for so many draws of range, stiffness and noise."""
    return draw_many(arms, PRIORS, count, run, "arms")


def arm_numbers(draws: Draws) -> dict[str, float]:
    """Medians and 5 to 95 % over all draws, and the shares in which z is the largest."""
    found = draws.by_name()
    found["arms"] = found.pop("draws")
    z = {f"z_{name}": float(draws.numbers[f"z_{name}"].mean()) for name in ("sag", "geometry", "both")}
    found["alpha_1_free_p95"] = float(np.quantile(np.abs(draws.numbers["alpha_1_free"]), 0.95))
    return found | z | {"z_odds": z["z_both"] / max(z["z_geometry"], 1 / draws.count)}


def arms_table(draws: Draws) -> Table:
    """By range of the joints and floor: what each arm shows."""
    limit, floor = draws.values["range"].astype(int), draws.values["floor"] < 0.5
    rows = []
    for at, degrees in enumerate(RANGES):
        for above in (False, True):
            here = (limit == at) & (floor == above)
            if not here.any():
                continue
            n = {key: column[here] for key, column in draws.numbers.items()}
            where = f"±{degrees}°" + (", above the floor" if above else "")
            sag = [_middle(n[f"{key}_sag"]) for key in ("before", "table", "after")]
            rows.append([
                where, str(int(here.sum())), *sag, numbers.percent(float(np.median(n["share_sag"])), 0),
                _middle(n["table_geometry"]),
                *(numbers.percent(float(n[f"z_{name}"].mean()), 0) for name in ("geometry", "sag", "both")),
            ])  # fmt: skip
    head = (
        "Joints within",
        "Draws",
        "Before",
        "Table",
        "After",
        "Table makes",
        "III, stiff",
        "z: stiff",
        "z: sags",
        "z: both",
    )
    note = (
        "Before, table, after: mean error of an arm of Table II that only sags, what its fitted table moves "
        "the tip by, and what is left, mm; III, stiff: the table of an arm of Table III that does not yield, "
        "mm. "
        f"Medians over draws of compliance, bearings and noise; {FITTED} points fitted, {JUDGED} judge. z: "
        "share of draws in which the mean |z| of the errors before is the largest of the three; both: Table "
        "III's arm that yields."
    )
    return Table(
        "An arm that only sags: its tables tell of geometry that it does not have",
        head,
        rows,
        note,
    )


def _middle(values: Array) -> str:
    return numbers.mm(float(np.median(values)))
