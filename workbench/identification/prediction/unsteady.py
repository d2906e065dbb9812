"""What moved for a time while a robot was measured: it comes again elsewhere, and no model foretells it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...campaign.stepped import before_steps, together
from ...effects.base import UNKNOWN, Effect
from ..fit import Fit
from ..model import Model
from ..set_up import fit_set_up


def unsteady(result: Fit, targets: NDArray[np.bool_]) -> float:
    """[m] one sigma per axis by which points of some targets (T,) stray where base and tool are where they
    are for a whole set-up: steps in time, and what creeps, slips or remembers without a name.

    What a fit leaves without these, base and tool placed again, beyond what it leaves with them. Drifts that
    have a name are told as such, and what the instrument does is no error of the robot.
    """
    problem, state = result.model.problem, result.state
    passing = [effect for effect in result.model.effects if _passes(effect)]
    campaign = together(problem.campaign)
    if campaign is problem.campaign and not passing:
        return 0.0
    rest = result.model.acting(state).those(lambda effect: effect not in passing)
    kept = np.unique(before_steps(problem.campaign.setup_names))
    at = replace(state, R=state.R[kept], t=state.t[kept], targets=state.targets[kept], values=())
    whole = Model(replace(problem, campaign=campaign), (), tuple(rest))
    without = fit_set_up(whole, replace(at, given=np.zeros(0)), result.noise)
    seen = problem.seen & targets
    left, steady = ((fit.residual[seen] ** 2).sum(axis=-1).mean() / 3 for fit in (without, result))
    return float(np.sqrt(max(left - steady, 0.0)))


def _passes(effect: Effect) -> bool:
    return effect.cause == UNKNOWN and effect.acts != "instrument" and not (effect.lasting or effect.dated)
