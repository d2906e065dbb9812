"""Set-ups that are fitted as one robot: what that leaves of each, and what geometry of its own would."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ...campaign.problem import Problem
from ...identification.fit import Fit, fit, refit
from ...identification.model import Model, State
from ...identification.plausible import too_few_alone
from ...robot.kinematics import Array

MOST = 6  # set-ups that a remark lists


@dataclass(frozen=True)
class Apart:
    """One set-up: RMS error [mm] of its points by the model of all, and with the geometry fitted to it alone,
    effects as they are."""

    name: str
    together_mm: float
    alone_mm: float

    def __str__(self) -> str:
        return f"{self.name or 'the one without a name'} {self.together_mm:.3f} mm ({self.alone_mm:.3f} mm)"


def set_ups_apart(final: Fit) -> list[Apart]:
    """Every set-up of several with poses enough to be fitted alone, first what gains most by that."""
    names = final.model.problem.campaign.setup_names
    if len(names) == 1:
        return []
    of_all = [effect for effect in final.model.effects if not effect.dated]
    if len(of_all) < len(final.model.effects):
        final = refit(final, of_all)
    return sorted(_each(final, names), key=lambda one: one.alone_mm - one.together_mm)


def _each(final: Fit, names: tuple[str, ...]) -> Iterator[Apart]:
    """What effects do to the points stays what it is in the whole: some count over all poses, or joints'
    ranges, or time."""
    whole, state = final.model.problem, final.state
    start = State(state.geometry, state.R, state.t, state.targets)
    moved = whole.campaign.points - final.residual - Model(whole).predict(start)
    for k, name in enumerate(names):
        poses = np.flatnonzero(whole.campaign.poses.setup == k)
        some = whole.campaign.some(poses)
        part = replace(whole, campaign=replace(some, points=some.points - moved[poses]))
        if not len(poses) or too_few_alone(part):
            continue
        with suppress(ArithmeticError):  # a few poses may pull a geometry out of all bounds
            alone = fit(Model(part), start, final.noise.some(poses))
            yield Apart(name, _rms_mm(final.residual[poses]), _rms_mm(alone.residual))


def _rms_mm(residual: Array) -> float:
    """Of points (N, T, 3) [m], NaN where not seen."""
    return 1e3 * float(np.sqrt(np.nanmean(np.sum(residual**2, axis=-1))))


def perhaps_changed(final: Fit) -> list[str]:
    """A remark on what has no name where several set-ups are fitted as one robot."""
    if len(final.model.problem.campaign.setup_names) == 1:
        return []
    found, left = set_ups_apart(final), ""
    if found:
        which = f"the {MOST} that gain most" if len(found) > MOST else "each that is fitted by itself as well"
        left = f" Of {which} is left, RMS (with geometry of its own): {', '.join(map(str, found[:MOST]))}."
    return [
        f"Several set-ups are fitted as one robot that stays what it is.{left} `workbench compare` of their "
        "campaigns says whether it changed between them: then what has no name may be no more than that."
    ]


def by_comparing(problem: Problem) -> str:
    """What would say whether the robot changed between several campaigns, or is not one; nothing of a single
    one."""
    campaign = problem.campaign
    if not campaign.beside:
        return ""
    what = "compare the campaigns, whether the robot changed between them"
    return f"{what}: workbench compare {campaign.arguments}"
