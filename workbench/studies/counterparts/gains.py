"""What cells gain over one model, and what a model that lacks less gains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...identification.cells import cells
from ...identification.fit import Fit
from ...report.numbers import mm, percent
from ...report.study import Table
from .measured import Measured, held_out
from .words import TITLE

SEEN = 0.02  # of the error: a gain that counts
CUTS = (1, 2, 1), (2, 4, 2), (4, 8, 4)


def gain_of_cells(robots: Sequence[Measured]) -> Table:
    """Do cells gain, and more than functions of the joints' angles?"""
    rows, best, functions = [], [], []
    for robot in robots:
        one = robot.fitted(robot.yields)
        alone = held_out(robot.halves(one))
        cut = [_in_cells(robot, one, counts) for counts in CUTS]
        whole = held_out(robot.halves(robot.fitted([*robot.yields, *robot.functions()])))
        best.append(1 - min(cut) / alone)
        functions.append(1 - whole / alone)
        number = str(len(robot.problem.q))
        gain = percent(best[-1], 0), percent(functions[-1], 0)
        rows.append([robot.known.words, number, mm(alone), *map(mm, cut), mm(whole), *gain])
    note = (
        "RMS error of poses that were not fitted, mm: every other block of poses is fitted, the others "
        "judge, and the reverse. One set: geometry and compliances of the joints that carry the arm’s "
        "weight. Cells: beside it an offset of its own in each. Functions: beside it one of each joint’s own "
        "angle, the same in the whole space."
    )
    less = [f > cell for cell, f in zip(best, functions, strict=True) if cell > SEEN]
    if less:
        more = sum(less)
        note += f" Cells gain more than {percent(SEEN, 0)} in {len(less)} of {len(robots)} campaigns,"
        note += f" in {more} of them less than functions that know no cell"
        note += ": a gain by cells is no proof that parameters vary." if more else "."
    else:
        note += f" Cells gain no more than {percent(SEEN, 0)} anywhere."
    sizes = (f"{int(np.prod(cut))} cells" for cut in CUTS)
    head = ("Robot", "Poses", "One set", *sizes, "Functions", "Gain by cells", "Gain by functions")
    return Table(TITLE, head, rows, note)


def _in_cells(robot: Measured, one: Fit, counts: tuple[int, int, int]) -> float:
    """RMS error [mm] of the poses that each half leaves out, with an offset in each cell."""
    place = robot.problem.rigid.p[-1]
    of = cells(np.array([place.min(axis=0) - 1e-6, place.max(axis=0) + 1e-6]), counts).of(place)
    halves = []
    for half in robot.halves(one):
        left = robot.problem.campaign.points - one.model.predict(half.state)
        offset = np.zeros((int(np.prod(counts)), *left.shape[1:]))
        for k in set(of[~half.out].tolist()):
            offset[k] = np.nanmean(left[~half.out & (of == k)], axis=0)
        halves.append(replace(half, residual=half.residual - offset[of[half.out]]))
    return held_out(halves)
