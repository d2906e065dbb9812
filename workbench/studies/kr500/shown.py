"""Accounts at their best: the draw that comes nearest the print, run in Drake, beside the print."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from workbench import Array, Figure, InputError, Judged, Table, charts, numbers

from . import in_drake
from .accounts import KINDS, solver
from .odds import SHORT
from .printed import CUBICS, EQUATIONS, ERRORS, TABLE_1
from .tried import Tried, tried
from .worlds import World, both, world

MEGA = 1e-6
MODELS = {
    "raw": "none",
    "theory": "constant, nominal kinematics",
    "constant": "constant",
    "2": "2 cells",
    "16": "16 cells",
    "128": "128 cells",
    "same": "constant, points of all 128 cells",
}
CELL = {"(18)": ("theory", 0), "(19)": ("constant", 0), "(20)": ("2", 0), "(21)": ("2", 1)}


@dataclass(frozen=True, eq=False)
class Best:
    """An account's best draw in Drake. difference: [m] the most by which the batch model differs from
    Drake."""

    words: str
    world: World
    tried: Tried
    moved: Array
    difference: float


def nearest_world(judged: Judged, name: str, seed: int) -> tuple[World, np.random.Generator]:
    """Of the draw of an account that comes nearest the print, with a box and points of this seed; and what
    drew them."""
    priors = next(account.priors for account in judged.accounts if account.name == name)
    for draw in nearest(judged, name):
        shares = judged.last[name].shares[draw]
        values = {key: p.at(float(u)) for (key, p), u in zip(priors.items(), shares, strict=True)}
        rng = np.random.default_rng([seed, 2])
        try:
            return world(values, rng), rng
        except InputError:
            continue
    raise ValueError(f"no draw of {name} reaches its box")


def best(judged: Judged, name: str, seed: int) -> Best:
    """The account at its best, in Drake, with noise of this seed."""
    _, _, law, moment = KINDS[name]
    w, rng = nearest_world(judged, name, seed)
    first = both(w, law, moment)
    moved = [in_drake.moved(w, problem, law) for problem in (w.grid, w.check)]
    grid, check = (replace(one, moved=m) for one, m in zip(first, moved, strict=True))
    off = max(float(np.abs(one.moved - m).max()) for one, m in zip(first, moved, strict=True))
    return Best(SHORT[name], w, tried(w, (grid, check), rng, solver(name)), moved[1], off)


def nearest(judged: Judged, name: str) -> NDArray[np.int64]:
    """(D,) the last draws of an account, nearest to the print first: in scales of the first draws of all
    accounts, or the print's own uncertainty where that is larger."""
    every = np.vstack([made.predicted for made in judged.first.values()])
    low, high = np.nanquantile(every, [0.16, 0.84], axis=0)
    value, sd = judged.target
    far = (judged.last[name].predicted - value) / np.maximum((high - low) / 2, sd)
    return np.argsort(np.nan_to_num((far**2).sum(axis=1), nan=np.inf), kind="stable")


def stood_in(some: Sequence[Best]) -> dict[str, Array]:
    """What poses are for → their joints (N, n) [rad], of accounts at their best."""
    found = {}
    for one in some:
        for words, problem in (("identification", one.world.grid), ("verification", one.world.check)):
            found[f"{one.words}, {words}"] = problem.q[: len(problem.q) // 2]
    return found


def hidden(w: World) -> dict[str, object]:
    """What the robot of a soft zone has that its file does not say."""
    values = w.values
    return {
        "soft_zone": {
            "joint": "joint_2" if values["soft_joint"] < 0.5 else "joint_3",
            "to_either_side_rad": values["soft_size"],
            "torque_Nm": values["soft_width"],
        },
        "kinematics": w.geometry.tolist(),
        "noise_m": values["sigma"],
        "repeatability_over_stated": values["scatter"],
    }


def points_figure(one: Best) -> Figure:
    """Their figure 7: the error at each verification point, by model."""
    order = np.arange(1, len(one.moved) + 1)
    keys = {"raw": charts.NOISE, "constant": charts.MIDDLE, "16": charts.MODEL, "128": charts.OURS}
    series = {
        (MODELS[key] if key != "raw" else "no model"): charts.Series(one.tried.errors[key], colour=colour)
        for key, colour in keys.items()
    }
    series |= {
        f"printed mean, {MODELS[key]}": charts.Series(
            np.full(len(order), ERRORS[key][0]), colour=colour, style="--"
        )
        for key, colour in keys.items()
        if key in ("constant", "128")
    }
    title = f"“{one.words}” at its best: error at each verification point, as in the paper’s figure 7"
    return charts.curves(
        "points", title, order, series, "verification point", "error that the load causes, mm"
    )


def errors_table(some: Sequence[Best]) -> Table:
    rows = []
    for key, words in MODELS.items():
        given = ERRORS.get(key)
        printed = (
            "not made"
            if given is None
            else f"{given[0]:.4f}" + (f" ({given[1]:.4f})" if len(given) > 1 else "")
        )
        ours = [
            f"{numbers.mm(e.mean())} ({numbers.mm(e.max())})" for e in (one.tried.errors[key] for one in some)
        ]
        rows.append([words, printed, *ours])
    note = (
        "Equation (22), mm: mean (largest) of 128 points. Each account at the draw that comes nearest the "
        "print, in Drake."
    )
    return Table(
        "Error that the load causes, by model", ("Model", "Printed", *(one.words for one in some)), rows, note
    )


def equations_table(some: Sequence[Best]) -> Table:
    """The paper's equations beside those of the accounts at their best."""
    rows = []
    for name, (cut, cell) in CELL.items():
        rows.append([f"{name}, printed", *map(_text, EQUATIONS[name])])
        rows += [[f"{name}, {one.words}", *map(_text, one.tried.K[cut][cell])] for one in some]
    return Table("Equations (18) to (21)", ("", *(f"K{j}" for j in range(1, 7))), rows, "In 10⁶ N·m/rad.")


def cells_table(one: Best) -> Table:
    """Table 1 beside the 16 cells of an account at its best."""
    rows = [
        [name, *(f"{_text(p)} · {_text(k)}" for p, k in zip(*both, strict=True))]
        for name, *both in zip(CUBICS, TABLE_1, one.tried.K["16"], strict=True)
    ]
    note = "In 10⁶ N·m/rad. Which cell of ours is which of the paper's is not known: they stand in our order."
    return Table(
        f"Table 1, 16 cells: printed · {one.words}", ("Cell", *(f"K{j}" for j in range(1, 7))), rows, note
    )


def scatter_table(some: Sequence[Best]) -> Table:
    """How far the stiffnesses of 16 cells scatter."""
    tables: Mapping[str, Array] = {"Printed": TABLE_1} | {one.words: one.tried.K["16"] for one in some}
    rows = [
        [
            f"K{j + 1}",
            *(numbers.decimals(float(np.log(np.abs(K[:, j])).std(ddof=1)), 2) for K in tables.values()),
        ]
        for j in range(6)
    ]
    return Table("How far the stiffnesses of 16 cells scatter: σ of ln K", ("", *tables), rows)


def _text(k: float) -> str:
    return numbers.significant(MEGA * k)
