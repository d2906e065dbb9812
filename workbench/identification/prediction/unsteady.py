"""What moved for a time while a robot was measured: it comes again elsewhere, and no model foretells it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.stepped import together
from ...effects.base import UNKNOWN, Effect
from ..fit import Fit
from ..model import Model
from ..set_up import fit_set_up

EVENT = 3.0  # times what a fit leaves: what strays by more is no habit, as an instrument that was pushed


def unsteady(result: Fit, targets: NDArray[np.bool_]) -> float:
    """[m] one sigma per axis by which points of some targets (T,) stray where base and tool are where they
    are for a whole set-up: steps in time, and what creeps, slips or remembers without a name.

    What a fit leaves without these, base and tool placed again, beyond what it leaves with them. Drifts that
    have a name are told as such, a step that stands out far is an event of that campaign, and what the
    instrument does is no error of the robot.
    """
    campaign = result.model.problem.campaign
    left = np.sqrt(_squared(result, targets))
    strays = _strays(result, targets, together(campaign))
    return strays if strays <= EVENT * left else _strays(result, targets, campaign)


def _strays(result: Fit, targets: NDArray[np.bool_], campaign: Campaign) -> float:
    """As `unsteady`, in the set-ups that the campaign has here."""
    problem, state = result.model.problem, result.state
    passing = [effect for effect in result.model.effects if _passes(effect)]
    if campaign is problem.campaign and not passing:
        return 0.0
    rest = result.model.acting(state).those(lambda effect: effect not in passing)
    names = problem.campaign.setup_names
    kept = [names.index(name) for name in campaign.setup_names]
    at = replace(state, R=state.R[kept], t=state.t[kept], targets=state.targets[kept], values=())
    model = Model(replace(problem, campaign=campaign), (), tuple(rest))
    without = fit_set_up(model, replace(at, given=np.zeros(0)), result.noise)
    return float(np.sqrt(max(_squared(without, targets) - _squared(result, targets), 0.0)))


def _squared(fit: Fit, targets: NDArray[np.bool_]) -> float:
    """[m²] mean square per axis of what is left of points of some targets (T,)."""
    return float((fit.residual[fit.model.problem.seen & targets] ** 2).sum(axis=-1).mean() / 3)


def _passes(effect: Effect) -> bool:
    return effect.cause == UNKNOWN and effect.acts != "instrument" and not (effect.lasting or effect.dated)
