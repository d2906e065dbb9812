"""Causes that nothing in this model would show, in no pose, and rivals that no pose tells from a cause: to
settle these is no question."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.problem import Problem
from ...diagnosis.weighing.components import usual
from ...effects.base import Effect
from ...files.faults import Fault, InputError
from ...identification.fit import Fit
from ...robot.kinematics import Array
from .causes import label
from .discrimination_plan import MOST_MEASURED, TELLS
from .prior_information import PriorInformation
from .t_optimal import DesignSpace
from .ties import POWER, Settling, Tie

HOPELESS = 0.5  # probability below which a tie stays open, mostly, however many poses anyone measures


def is_shown(space: DesignSpace, effect: Effect, fit: Fit | None) -> bool:
    """Whether an effect of usual size, at a campaign's loads where there is one, moves anything: its λ, were
    nothing else fitted, in what was measured and in as many records as anyone measures."""
    own = space.columns(effect)
    times = np.ones(len(own)) if fit is None else usual(fit, effect) / [p.typical for p in effect.params]
    new = float(np.mean(np.sum((space.rows[:, :, own] * times) ** 2, axis=(1, 2))))
    before = float(np.diag(space.before)[own] @ times**2)
    return before + MOST_MEASURED * new > TELLS


def check_shown(space: DesignSpace, causes: Sequence[Sequence[Effect]], prior: PriorInformation) -> None:
    """causes: of each the places and forms that it may have. Raises InputError with each that has none which
    moves anything."""
    faults = [
        Fault(f"--tell {label(one)}", f"cannot show in this model: {_why(one, prior.problem)}", _mend(one))
        for one, *more in filter(None, causes)
        if not any(is_shown(space, effect, prior.fit) for effect in (one, *more))
    ]
    if faults:
        raise InputError(faults)


def with_shown(space: DesignSpace, tie: Tie, fit: Fit | None) -> Tie:
    """The tie without rivals that nothing would show."""
    gone = {rival for rival in tie.rivals if not is_shown(space, rival, fit)}
    return replace(
        tie,
        rivals=tuple(rival for rival in tie.rivals if rival not in gone),
        forms=tuple(form for form in tie.forms if form.first not in gone),
    )


def with_hope(space: DesignSpace, most: Array, tie: Tie) -> tuple[Tie, list[Effect]]:
    """The tie without the rivals that no records on offer tell from the cause, and these; without all, and
    the first, where the records do not settle the rest. most: information of all that anyone measures."""

    def power(one: Tie) -> float:
        return Settling(space, [one]).power(most)

    if power(tie) >= POWER:
        return tie, []
    rivals = {rival.key: rival for rival in reversed(tie.rivals)}
    gone = [rival for key, rival in reversed(rivals.items()) if power(tie.beside(key)) < HOPELESS]
    rest = tie.without([rival.key for rival in gone])
    if rest.rivals and power(rest) >= HOPELESS:
        return rest, gone
    return tie.without(list(rivals)), [tie.rivals[0]]


def _why(effect: Effect, problem: Problem) -> str:
    if effect.acts == "yielding":
        return "in no pose does a load of the model bend it"
    if effect.acts != "load":
        return f"of its usual size it moves no target in {MOST_MEASURED} poses"
    if not problem.arm.compliance.any():
        return "all joints and links of the model are rigid, so that no load moves a target"
    return "in no pose does its load bend what yields in the model, as that of a body that turns upright"


def _mend(effect: Effect) -> str:
    if effect.acts == "load":
        return "state the stiffness of what yields in the robot's TOML, or leave it out"
    return "leave it out"
