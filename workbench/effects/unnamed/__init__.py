"""Functions without a name: what a robot does that no cause of the catalogue explains.

They compete with the causes (Kennedy & O'Hagan 2001: a discrepancy belongs into the fit), say what the rest
depends on, and correct it. Each is a form (`variant`) of the one cause `unknown`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...campaign.problem import Problem
from .anew import CarriedAnew, GeometryAnew, ScaleAnew, ZeroAnew
from .at_once import AtOnce, Stepping, ZeroAtOnce
from .base import Unnamed
from .campaign import Along, Attitude, Clock, Creeping, PerPayload, Warmth, ZeroInTime, Zeros
from .carriage import UnevenCarriage
from .curved_yield import CurvedYield
from .foot import Foot
from .instrument import Bearing, Head, Ranging, Reflectors, Views
from .joints import Pair, Product, Side, SideBands, Tilt
from .link_ends import OwnWeight, PivotForce, UnevenBending
from .loads import Load, OwnWeights, StatedForces, TippingTilt, ToolsWeight, Torque, UnevenTilt
from .past import Past

KINDS: tuple[type[Unnamed], ...] = (
    Tilt, Pair, Torque, Load, OwnWeights, ToolsWeight, Foot, Side, Past, Clock, Creeping, Along, ZeroInTime,
    Zeros, Warmth, PerPayload, Attitude, Bearing, Head, Ranging, Reflectors, Views, ZeroAnew, CarriedAnew,
    ScaleAnew, GeometryAnew, Product, AtOnce, ZeroAtOnce,
)  # fmt: skip
# what stands beside causes, and for nothing by itself
BESIDE: tuple[type[Unnamed], ...] = (
    CurvedYield, OwnWeight, PivotForce, SideBands, StatedForces, TippingTilt, UnevenBending, UnevenCarriage,
    UnevenTilt,
)  # fmt: skip


def unnamed(problem: Problem) -> Iterator[Unnamed]:
    """Every function without a name that a campaign allows, but those that a search proposes: see `products`
    and `steps`."""
    for kind in KINDS:
        if kind is not Product and not issubclass(kind, Stepping):
            yield from kind.sites(problem)  # type: ignore[misc]


def kind_of(variant: str) -> type[Unnamed] | None:
    """The kind of function that a variant, with a number behind it or without, is a form of."""
    kinds = {kind.variant: kind for kind in (*KINDS, *BESIDE)}
    return kinds.get(variant) or kinds.get(variant.rpartition(" ")[0])


def products(problem: Problem, joint: int) -> Iterator[Unnamed]:
    """Functions of two other joints, of one joint's error."""
    name = problem.arm.names[joint]
    yield from (one for one in Product.sites(problem) if one.where.joint == name)


def steps(problem: Problem) -> Sequence[Stepping]:
    """A step of the base or the instrument, one of the tool, and of each joint's zero; where, is for a search
    to say."""
    return [*AtOnce.sites(problem), *ZeroAtOnce.sites(problem)]
