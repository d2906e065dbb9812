"""Steps of base or tool while a robot was measured: they come again, and no model foretells them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...campaign.stepped import together
from ..fit import Fit
from ..model import Model
from ..set_up import fit_set_up

EVENT = 3.0  # times what a fit leaves: what strays by more is no habit, as an instrument that was pushed


def unsteady(result: Fit, targets: NDArray[np.bool_]) -> float:
    """[m] one sigma per axis by which points of some targets (T,) stray from one place of base and tool,
    where their set-up was split at steps in time: what is left with its parts in one again, beyond what the
    fit leaves. What creeps is in that already, as a model is written without it (`Fit.lasting`); a step that
    stands out far is an event of that campaign.
    """
    problem, state = result.model.problem, result.state
    campaign = together(problem.campaign)
    if campaign is problem.campaign:
        return 0.0
    kept = [problem.campaign.setup_names.index(name) for name in campaign.setup_names]
    model = Model(replace(problem, campaign=campaign), (), tuple(result.model.acting(state)))
    places = {"R": state.R[kept], "t": state.t[kept], "targets": state.targets[kept]}
    start = replace(state, **places, values=(), given=np.zeros(0))
    left = _squared(result, targets)
    strays = _squared(fit_set_up(model, start, result.noise), targets) - left
    return float(np.sqrt(strays)) if 0 < strays <= EVENT**2 * left else 0.0


def _squared(fit: Fit, targets: NDArray[np.bool_]) -> float:
    """[m²] mean square per axis of what is left of points of some targets (T,)."""
    return float((fit.residual[fit.model.problem.seen & targets] ** 2).sum(axis=-1).mean() / 3)
