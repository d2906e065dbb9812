"""Does a table of geometry hold sag?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...identification.model import Model
from ...report.numbers import mm
from ...report.study import Table
from .measured import Half, Measured, held_out, rms
from .words import TITLE, within

MORE = 0.5  # of the square: a table that takes up so much holds sag


def geometry_or_sag(robots: Sequence[Measured]) -> Table:
    """How much of what compliances move a table of geometry alone takes up."""
    rows, shares = [], []
    for robot in robots:
        whole = robot.fitted(robot.yields)
        alone, both = robot.halves(robot.fitted()), robot.halves(whole)
        moved, kept = np.array([_taken(whole.model, *pair) for pair in zip(alone, both, strict=True)]).T
        taken = [float(share) for share in 1 - (kept / moved) ** 2]
        shares += [min(taken)]
        mean = (float(np.sqrt((part**2).mean())) for part in (moved, kept))
        errors = mm(held_out(alone)), mm(held_out(both))
        each = f"{within([100 * share for share in taken], 1)} %"
        rows.append([robot.known.words, *errors, *map(mm, mean), each])
    holding = sum(share > MORE for share in shares)
    note = (
        "RMS, mm, of poses that were not fitted: every other block of poses is fitted, the others judge, and "
        "the reverse. Taken up: share of the square of what the compliances move the points by that is in a "
        "table of geometry alone, for the two halves. It is more than half in both in "
        f"{holding} of {len(robots)} campaigns"
    )
    note += ": such a table holds sag." if holding else "."
    head = (
        "Robot",
        "Geometry alone",
        "… and compliances",
        "Compliances move by",
        "Not in the table",
        "Taken up",
    )
    return Table(TITLE, head, rows, note)


def _taken(model: Model, alone: Half, both: Half) -> tuple[float, float]:
    """What compliances move the poses by that a half leaves out, and what of it is not in a table of geometry
    alone [mm]. model: that with the compliances."""
    stiff = replace(both.state, values=tuple(np.zeros_like(value) for value in both.state.values))
    sag = model.predict(both.state) - model.predict(stiff)
    return rms(sag[both.out]), rms(alone.residual - both.residual)
