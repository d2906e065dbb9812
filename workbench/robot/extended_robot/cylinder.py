"""A gas cylinder between two bodies: its force, and the pair of forces with which it pulls its pivots."""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import Context

ATMOSPHERE = 101325.0  # Pa
_NO_TORQUE: Any = np.zeros(3)
Length = TypeVar("Length", float, Any)


def gas_force(
    s: Length, area: float, pressure: float, length: float, reference: float, exponent: float
) -> tuple[Length, Length, float]:
    """Force [N] that a polytropic gas adds to its rod, its slope by s [N/m], and what the air outside takes.

    s: [m] between the pivots; area: [m²]; pressure: [Pa] where s is `reference` [m] and the gas column
    `length` [m].
    """
    column = length - (s - reference)
    gas = area * pressure * (length / column) ** exponent
    return gas, gas * exponent / column, -area * ATMOSPHERE


def between(poses: Any, pivots: Any) -> Any:
    """(3,) [m] from the first to the second of two pivots (3,), each in its body, bodies at `poses`."""
    return poses[1] @ pivots[1] - poses[0] @ pivots[0]


def pulled(bodies: Any, pivots: Any, way: Any, pull: float) -> list[ExternallyAppliedSpatialForce]:
    """Two bodies (by index) that a force of `pull` [N] draws together at their pivots, `way` (3,) apart."""
    force = pull / math.sqrt(way @ way) * way
    out = []
    for body, pivot, one in zip(bodies, pivots, (force, -force), strict=True):
        applied: Any = ExternallyAppliedSpatialForce()
        applied.body_index, applied.p_BoBq_B = body, pivot
        applied.F_Bq_W = SpatialForce(_NO_TORQUE, one)
        out.append(applied)
    return out


def add_pull(
    context: Context, forces: MultibodyForces, bodies: Any, poses: Any, pivots: Any, way: Any, pull: float
) -> None:
    """The same as `pulled`, added to forces of the plant."""
    force, world = pull / math.sqrt(way @ way) * way, bodies[0].GetParentPlant().world_frame()
    for body, X, pivot, one in zip(bodies, poses, pivots, (force, -force), strict=True):
        body.AddInForce(context, X.rotation() @ pivot, SpatialForce(_NO_TORQUE, one), world, forces)


def add_applied(plant: MultibodyPlant, context: Context, forces: MultibodyForces, applied: Any) -> None:
    """Adds forces on bodies as the plant's port takes them."""
    for one in applied:
        body = plant.get_body(one.body_index)
        lever = body.EvalPoseInWorld(context).rotation() @ one.p_BoBq_B
        body.AddInForce(context, lever, one.F_Bq_W, plant.world_frame(), forces)
