"""What the diagnosis must know of single effects: gear lines of any order, and how a joint yields.

Everything here follows from what effects say of themselves; where they come to say it outright, the
function here goes and its one import with it.
"""

from __future__ import annotations

from ..effects import catalogue
from ..effects.base import Effect, LinearYield
from ..effects.place import Where
from ..robot.kinematics import Arm


def line(joint: str, order: float) -> Effect:
    """The effect that carries a gear line of an order that no ratio states. Goes for `effects.line`."""
    (kind,) = (kind for kind in catalogue().values() if kind.ordered)
    return kind(Where(joint=joint, order=order))


def searched(effect: Effect) -> bool:
    """Whether a scan found the effect's order. Goes for `effect.searched`."""
    return bool(getattr(effect, "searched", False))


def joint_yields(effect: Effect) -> bool:
    """A joint that yields in proportion to its load: along its own axis or across it."""
    return isinstance(effect, LinearYield) and effect.where.joint is not None


def axial_yield(effect: Effect, arm: Arm) -> bool:
    """A joint that yields along its own axis in proportion to its load."""
    if not isinstance(effect, LinearYield) or effect.where.joint is None:
        return False
    slot, along = divmod(int(arm.axial[arm.names.index(effect.where.joint)]), 6)
    return effect.slot(arm) == slot and bool(effect.compliance(arm)[along, along] > 0)
