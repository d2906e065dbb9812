"""What these data could have shown: smallest detectable sizes, and what they cannot show at all."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cache

import numpy as np
from scipy.special import chdtri, chndtrinc

from ...campaign.problem import Problem
from ...effects.base import Effect
from ...effects.place import Where
from ...identification.fit import Fit
from ...robot.kinematics import RZ, Array
from ..candidates import ways_to_wander
from ..found import Detectable, NotTestable
from ..weighing.screen import FAINT, SURVIVES, effective_dof, shown

POWER = 0.8
FALSE_ALARM = 0.004  # chance that clean data show some cause of the catalogue
MANY = 12  # numbers of an effect from which it is no one size


@cache
def needed(rank: int, alpha: float) -> float:
    """Non-centrality at which a χ² test of level alpha finds with the power wanted."""
    return float(chndtrinc(chdtri(rank, alpha), rank, 1 - POWER))


def detectable(candidates: Sequence[Effect], final: Fit, known: bool) -> Iterator[Detectable]:
    """Smallest size of every cause that would have been found with 80 % power, whatever its phase."""
    candidates = [e for e in candidates if e.whole and e not in final.model.effects and len(e.params) < MANY]
    scale = 1.0 if known else float(np.sqrt(final.chi2 / max(effective_dof(final, drives=True), 1.0)))
    best: dict[tuple[str, Where], Detectable] = {}
    for effect in candidates:
        left = shown(final, effect)
        if left.own.min() <= FAINT:
            continue
        length = np.sqrt(left.own)
        values = np.linalg.eigvalsh(left.S / np.outer(length, length))
        if values[0] <= SURVIVES:
            continue
        info = left.S / np.outer(left.scale, left.scale)
        weakest = float(np.linalg.eigvalsh(info)[0])
        size = scale * float(np.sqrt(needed(len(values), FALSE_ALARM / len(candidates)) / weakest))
        size, unit = effect.reported_size(size)
        found = Detectable(effect.cause, effect.where, size, unit, effect.params[0].name)
        if effect.key not in best or size < best[effect.key].size:
            best[effect.key] = found
    yield from best.values()


def visible_mm(final: Fit, candidates: Sequence[Effect], numbers: int = 2) -> float:
    """RMS length [mm], beyond what geometry can explain, of an effect with so many numbers that moves a
    pose's points together, which would have been found with 80 % power beside the noise and the robot's
    scatter."""
    alpha = FALSE_ALARM / max(len(candidates), 1)
    targets = final.model.problem.seen.shape[1]
    shift = np.matmul(final.whitener[:, :, : 3 * targets], np.tile(np.eye(3), (targets, 1)))
    return 1e3 * float(np.sqrt(3 * needed(numbers, alpha) / max(float((shift**2).sum()), 1e-30)))


def wandering_mm(final: Fit, candidates: Sequence[Effect]) -> float:
    """The same [mm] of what wanders in time, which has many numbers; 0 where nothing could show that."""
    ways = ways_to_wander(final.model.problem, candidates)
    return visible_mm(final, candidates, len(ways[0].params)) if ways else 0.0


def swallowed(
    candidates: Sequence[Effect], geometry: Fit, final: Fit, told: Collection[tuple[str, Where]]
) -> list[NotTestable]:
    """Candidates without any pattern of their own in these data: loads neither beside geometry nor at the
    final fit, in which joints may yield to them. told: what is among the causes or their rivals."""
    hidden = _hidden(candidates, geometry)
    loads = [effect for effect in candidates if effect.acts == "load" and effect.key in hidden]
    visible = {effect.key for effect in loads}.difference(_hidden(loads, final) if loads else ())
    gone = visible.union(told)
    return [NotTestable(key[0], why, key[1]) for key, why in hidden.items() if key not in gone]


def _hidden(candidates: Sequence[Effect], at: Fit) -> dict[tuple[str, Where], str]:
    """Those without a pattern of their own beside what a fit has, and why."""
    visible, hidden = set[tuple[str, Where]](), dict[tuple[str, Where], str]()
    for effect in candidates:
        if effect.key in visible:
            continue
        left = shown(at, effect)
        if left.rank:
            visible.add(effect.key)
        elif effect.key not in hidden:
            hidden[effect.key] = _why(effect, left.own, at.model.problem, at)
    return {key: why for key, why in hidden.items() if key not in visible}


def _why(effect: Effect, own: Array, problem: Problem, final: Fit) -> str:
    if own.max() < 1e-6:
        if effect.acts == "yielding" and effect.where.joint:
            j = problem.joint(effect.where.joint)
            up = final.line.prediction.where.axes[0, j + 1, RZ]
            g = problem.arm.gravity / max(float(np.linalg.norm(problem.arm.gravity)), 1e-12)
            if abs(float(up @ g)) > 0.999:
                return "gravity makes no torque about a vertical axis: pull sideways"
            return "no load turns this joint in these poses: add a payload with its mass off the axis"
        if effect.acts == "load":
            return (
                "the model has no joint that yields to this load: state stiffness, or measure with two loads"
            )
        return "it moves no target in these poses"
    if own.max() <= FAINT:
        return "as large as it usually is, it moves the targets by far less than these data show"
    return "in these poses it looks exactly like a change of geometry, frame or targets"
