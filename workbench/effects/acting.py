"""Effects at work: the one place where effects with their values are applied to a robot.

Prediction, virtual campaigns, correction and the closed loop all ask here what moves, what pulls, what
yields and what the instrument makes of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array
from ..robot.loads import Loads
from ..robot.yielding import Law, Yielding
from .base import NOTHING, Depends, Effect
from .kinds import LinearYield, SlotYield, TransmissionEffect, YieldEffect

Shares = Mapping[int, Array]
WHOLE: Shares = {}
NUDGE = 1e-6  # rad, m: step of a slope along the joints


@dataclass(frozen=True, eq=False)
class Acting:
    """Effects, each with its values (p,), in N poses of a robot with n joints and S slots."""

    items: tuple[tuple[Effect, Array], ...] = ()

    def __iter__(self) -> Iterator[tuple[Effect, Array]]:
        return iter(self.items)

    def __len__(self) -> int:
        return len(self.items)

    @property
    def uses(self) -> Depends:
        """What any of the effects depends on."""
        return NOTHING.union(*(effect.uses for effect, _ in self.items))

    def those(self, keep: Callable[[Effect], bool]) -> Acting:
        """Only some of the effects."""
        return Acting(tuple((effect, values) for effect, values in self.items if keep(effect)))

    def direct(self, problem: Problem, shares: Shares = WHOLE) -> Array:
        """(N, S, 6) motions that do not depend on load; `shares` (N,) of some effects, by their number."""
        out = np.zeros((len(problem.q), 6 * problem.arm.slots))
        for i, (effect, values) in enumerate(self.items):
            for column, basis in effect.motion(problem).items():
                moved = basis @ values
                out[:, column] += shares[i] * moved if i in shares else moved
        return out.reshape(len(out), -1, 6)

    def loads(self, problem: Problem, arm: Arm) -> tuple[Arm, Loads]:
        """Arm and loads with the effects that change what pulls."""
        loads = problem.loads
        for effect, values in self.items:
            arm, loads = effect.apply(problem, arm, loads, values)
        return arm, loads

    def yielding(self, arm: Arm) -> Yielding:
        """What yields, the arm's own compliance included."""
        linear, bent = arm.compliance.copy(), []
        for effect, values in self.items:
            for part in effect.parts if isinstance(effect, YieldEffect) else ():
                if isinstance(part, LinearYield):
                    linear[part.slot(arm)] += values[0] * part.compliance(arm)
                else:
                    bent.append((part.slot(arm), part.components(arm), _law(part, arm, values)))
        return Yielding(linear, tuple(bent))

    def seen(self, problem: Problem, points: Array) -> Array:
        """The points (N, T, 3) [m] as the instrument shows them."""
        change = np.zeros_like(points)
        for effect, values in self.items:
            if effect.acts == "instrument":
                change += effect.seen(problem, points) @ values
        return points + change

    def sight(self, problem: Problem) -> Array | None:
        """(N, T, 3, 3) how shown points move with the true ones; None where the instrument shows these."""
        if all(effect.acts != "instrument" for effect, _ in self.items):
            return None
        axes = np.broadcast_to(np.eye(3)[:, None, None], (3, *problem.campaign.points.shape))
        still = self.seen(problem, np.zeros_like(axes[0]))
        return np.stack([self.seen(problem, axis) - still for axis in axes], axis=-1)

    def gear_error(self, q: Array, side: Array | None, joints: tuple[str, ...]) -> Array:
        """(K, n) motion of each joint beyond its drive's, at joints q (K, n) reached from `side` (K, n)."""
        out = np.zeros_like(q)
        for effect, values in self.items:
            if isinstance(effect, TransmissionEffect):
                out[:, joints.index(str(effect.where.joint))] += effect.basis(q, side, joints) @ values
        return out

    def beyond(self, problem: Problem) -> Array:
        """(N, 6 S) one sigma of each motion [m, rad] that functions do not have where they end."""
        out = np.zeros((len(problem.q), 6 * problem.arm.slots))
        for effect, _ in self.items:
            for column, size in effect.ends(problem).items():
                out[:, column] += size**2
        return np.sqrt(out)

    def ripple_slope(self, problem: Problem, shares: Shares) -> Array:
        """(N, n) further motion of each joint per commanded motion, of the effects with an order."""
        ripple = [(i, *item) for i, item in enumerate(self.items) if item[0].where.order is not None]
        slope, joints = np.zeros(problem.q.shape), problem.arm.names
        side = problem.campaign.poses.side
        for i, effect, values in ripple:
            one = Acting(((effect, values),))
            ahead = one.gear_error(problem.q + NUDGE, side, joints)
            change = (ahead - one.gear_error(problem.q, side, joints)) / NUDGE
            slope += shares[i][:, None] * change if i in shares else change
        return slope


def _law(effect: SlotYield, arm: Arm, values: Array) -> Law:
    return lambda wrench: effect.law(arm, wrench, values)[:2]
