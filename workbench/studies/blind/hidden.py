"""What is hidden in a robot: a cause of the catalogue in a form of its own, or something unknown."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...effects.base import Effect
from ...robot.kinematics import Array
from ...simulation.virtual_campaign import Truth


@dataclass(frozen=True)
class Hidden:
    """Something hidden, of any size.

    name: the cause, or the kind of the unknown. effect: the library's effect at this place and unit: (p,)
    its parameters at size 1; None and empty for an unknown. form: size → what it does to the robot.
    largest: beyond this size no robot would have it. plan: what it changes in the columns of a campaign.
    more: further parts of the same cause that the catalogue can add. fixed: the parameters do not grow
    with the size.
    """

    name: str
    effect: Effect | None
    unit: Array
    form: Callable[[float], Truth]
    largest: float
    plan: Callable[[Campaign, float], Campaign] | None = None
    more: tuple[Effect, ...] = ()
    fixed: bool = False

    @property
    def label(self) -> str:
        return self.effect.label if self.effect is not None else self.name

    def values(self, size: float) -> Array:
        """The library's parameters (p,) at a size, where its form were the true one."""
        return self.unit if self.fixed else size * self.unit

    def planned(self, campaign: Campaign, size: float) -> Campaign:
        return self.plan(campaign, size) if self.plan is not None else campaign


def together(*truths: Truth) -> Truth:
    """All that the truths do, at once; geometry, targets and noise of the first."""
    first = truths[0]
    return Truth(
        geometry=first.geometry,
        effects=tuple(effect for truth in truths for effect in truth.effects),
        joints=_sum([t.joints for t in truths if t.joints is not None]),
        motion=_sum_columns([t.motion for t in truths if t.motion is not None]),
        torque=_sum([t.torque for t in truths if t.torque is not None]),
        yields=_yields([t.yields for t in truths]),
        seen=_chain([t.seen for t in truths if t.seen is not None]),
        targets=first.targets,
        sigma=first.sigma,
        repeatability=first.repeatability,
    )


def _sum(hooks: list[Callable[[Problem], Array]]) -> Callable[[Problem], Array] | None:
    return (lambda problem: np.sum([hook(problem) for hook in hooks], axis=0)) if hooks else None


def _sum_columns(hooks: list[Any]) -> Callable[[Problem], Mapping[int, Array]] | None:
    def columns(problem: Problem) -> Mapping[int, Array]:
        out: dict[int, Array] = {}
        for hook in hooks:
            for column, motion in hook(problem).items():
                out[column] = out.get(column, 0.0) + motion
        return out

    return columns if hooks else None


def _yields(each: list[Mapping[int, Callable[[Array], Array]]]) -> dict[int, Callable[[Array], Array]]:
    out: dict[int, Callable[[Array], Array]] = {}
    for yields in each:
        for slot, law in yields.items():
            out[slot] = _both(out[slot], law) if slot in out else law
    return out


def _both(a: Callable[[Array], Array], b: Callable[[Array], Array]) -> Callable[[Array], Array]:
    return lambda wrench: a(wrench) + b(wrench)


def _chain(hooks: list[Any]) -> Callable[[Problem, Array], Array] | None:
    def seen(problem: Problem, points: Array) -> Array:
        for hook in hooks:
            points = hook(problem, points)
        return points

    return seen if hooks else None


def joint_error(joint: int, error: Callable[[Problem], Array]) -> Callable[[float], Truth]:
    """A form that errs in one joint: error(problem) → (N,) [rad, m] at size 1."""

    def form(size: float) -> Truth:
        def joints(problem: Problem) -> Array:
            out = np.zeros_like(problem.q)
            out[:, joint] = size * error(problem)
            return out

        return Truth(joints=joints)

    return form


def slot_yield(slot: int, law: Callable[[Array], Array]) -> Callable[[float], Truth]:
    """A form that yields at one slot: wrench (6,) → motion (6,) at size 1."""
    return lambda size: Truth(yields={slot: lambda wrench: size * law(wrench)})


def largest_torque(problem: Problem, joint: int) -> float:
    """Largest torque [N·m, N] of a joint in the campaign; of one that carries none, a thousandth of all."""
    torque = np.abs(axial_torque(problem)).max(axis=0)
    return float(max(torque[joint], 1e-3 * torque.max(), 1e-6))


def axial_torque(problem: Problem) -> Array:
    """(N, n) torques [N·m, N] of the joints, arm and loads as stated."""
    return problem.nominal_torque
