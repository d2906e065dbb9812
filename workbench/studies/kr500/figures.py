"""The KR 500 study's figures, its tables of stiffness, and comparisons by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from workbench import Array, Campaign, CellModel, Figure, Table, charts, numbers, problem_of

from .count import Trade
from .loads import Case
from .printed import CUBICS, EQUATIONS, ERRORS, TABLE_1

MEGA = 1e-6
NOTE = "In 10⁶ N·m/rad. In brackets: not decided, the compliance is uncertain by more than its nominal value."
Models = Mapping[str, Mapping[str, CellModel]]  # by true robot, then by cut
CELL = {"(18)": ("theory", 0), "(19)": ("constant", 0), "(20)": ("2", 0), "(21)": ("2", 1)}  # cut, cell
MODEL_NAMES = {
    "raw": "no model",
    "theory": "constant, nominal kinematics",
    "constant": "constant",
    "2": "2 cells",
    "16": "16 cells",
    "128": "128 cells",
    "same": "constant, all points",
    "named": "soft zone named",
}


def equations_table(models: Models) -> Table:
    """The paper's equations beside ours: constant without and with calibrated kinematics, and two cells."""
    lines = []
    for name, (cut, cell) in CELL.items():
        lines.append([f"{name} printed", *(_text(k, 0) for k in EQUATIONS[name])])
        for case, model in models.items():
            k, std = model[cut].stiffness
            lines.append([f"{name} ours ({case})", *map(_text, k[cell], std[cell])])
    return Table("Equations (18) to (21)", _head("", lines), lines, NOTE)


def cells_table(model: CellModel) -> Table:
    """Printed stiffnesses beside those of a model."""
    lines = [
        [name, *(f"{_text(p, 0)} · {_text(*own)}" for p, *own in zip(*row, strict=True))]
        for name, *row in zip(CUBICS, TABLE_1, *model.stiffness, strict=True)
    ]
    return Table("Table 1, 16 cells: printed · ours (a)", _head("Cell", lines), lines, NOTE)


def scatter_table(models: Models) -> Table:
    """How the stiffnesses of 16 cells differ: as printed, and in both cases."""
    found = {case: model["16"].stiffness for case, model in models.items()}
    k_a, std_a = found["a"]
    lines = []
    for j in range(TABLE_1.shape[1]):
        every = [TABLE_1, *(k for k, _ in found.values())]
        spread = [numbers.decimals(float(np.log(np.abs(k[:, j])).std(ddof=1)), 2) for k in every]
        ratio = numbers.decimals(TABLE_1[:, j].max() / TABLE_1[:, j].min(), 1)
        noise = numbers.significant(float(np.median(std_a[:, j])), 2)
        lines.append([f"K{j + 1}", ratio, *spread, str(int((k_a[:, j] < 0).sum())), noise])
    ours = (f"Ours ({case})" for case in found)
    head = ("", "Printed, max/min", "Printed, σ of ln K", *ours, "(a): negative", "By noise alone, σ/K")
    return Table("How far the stiffnesses of 16 cells scatter", head, lines)


def compared(
    n: Mapping[str, float], case: Case, trades: Mapping[str, Trade], models: Models
) -> dict[str, float]:
    """What the errors by model amount to beside each other, and beside the noise of measuring in `case`."""
    missing = trades["b"]
    theory, calibrated = (models["a"][key].stiffness[0][0, 1:5] for key in ("theory", "constant"))
    floor = float(1e3 * np.linalg.norm(case.seen - case.true, axis=1).mean())
    return {
        "a_by_kinematics": float(np.abs(calibrated / theory - 1).max()),
        "printed_missing_mm": float(np.sqrt(ERRORS["constant"][0] ** 2 - floor**2)),
        "cells_over_named": n["b_128_true_mm"] / n["b_named_true_mm"],
        "a_cells_over_same": n["a_128_true_mm"] / n["a_same_true_mm"],
        "b_gain": 1 - n["b_128_mm"] / n["b_constant_mm"],
        "b_kinematics_mm": abs(n["b_constant_mm"] - n["b_theory_mm"]),
        **{f"{name}_allowed": one.best for name, one in trades.items()},
        "b_pays": missing.pays,
        "b_pays_mm": missing.pays * n["b_same_true_mm"],
        "floor_mm": floor,
    }


def errors_figure(n: Mapping[str, float]) -> Figure:
    """Mean errors by model."""
    printed = [ERRORS.get(key, (np.nan,))[0] for key in MODEL_NAMES]
    series = {"printed": charts.Series(printed, colour=charts.PRINTED)}
    for case, colour in (("a", charts.NOISE), ("b", charts.OURS)):
        mean, true = (
            [n.get(f"{case}_{key}_{what}", np.nan) for key in MODEL_NAMES] for what in ("mm", "true_mm")
        )
        series[f"({case}), line: without noise"] = charts.Series(mean, true, mean, colour)
    title = "Cells remove error in (b), where an effect is missing; in (a) they have none to remove"
    return charts.rows(
        "errors", title, list(MODEL_NAMES.values()), series, "mean error at the 128 verification points, mm"
    )


def torque_figure(centres: Campaign, model: CellModel, law: Callable[[Array], Array]) -> Figure:
    """Joint 2's compliance in the cells over its torque; centres: a plan at the cells' centres, without load
    and then with it; law: the true motion (6,) beside its spring under a wrench (6,)."""
    torque = problem_of(centres).nominal_load.local[:, 2, 5].reshape(2, -1)
    low, high = torque[:, np.argsort(torque.mean(axis=0))]
    soft = [np.array([law(np.array([0, 0, 0, 0, 0, t]))[5] for t in ends]) for ends in (low, high)]
    nominal = 1e6 / (centres.robot.joints[1].data.stiffness or np.inf)
    order, truth = np.argsort(torque.mean(axis=0)), nominal + 1e6 * (soft[1] - soft[0]) / (high - low)
    series = {
        "128 cells": charts.Series(1e6 / model.stiffness[0][order, 1], colour=charts.PRINTED, style="o"),
        "truth: spring and soft zone": charts.Series(truth, colour=charts.OURS),
        "equation (19)": charts.Series(np.full(len(low), nominal), colour=charts.MIDDLE, style="--"),
    }
    title = "“Stiffness that varies in space” is one curve over the torque of joint 2"
    x, y = "net torque of joint 2, N·m", "compliance, 10⁻⁶ rad/(N·m)"
    return charts.curves("torque", title, (low + high) / 2, series, x, y)


def _text(k: float, std: float) -> str:
    """A stiffness [N·m/rad] in 10⁶ N·m/rad, in brackets where it is not decided."""
    return numbers.significant(MEGA * k) if std < 1 else f"({numbers.significant(MEGA * k, 2)})"


def _head(first: str, lines: Sequence[Sequence[str]]) -> tuple[str, ...]:
    return (first, *(f"K{j}" for j in range(1, len(lines[0]))))
