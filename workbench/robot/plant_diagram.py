"""A plant in a Diagram with the force laws at its ports, and what they apply to its bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    ExternallyAppliedSpatialForce,
    ExternallyAppliedSpatialForceMultiplexer,
    MultibodyPlant,
)
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder

from .compensator import CompensatorLaw
from .force_systems import Cylinder, SlotSprings
from .kinematics import Arm, Array
from .plant_parts import pivots
from .plants import ArmPlant


def cylinder_of(built: ArmPlant, arm: Arm, law: CompensatorLaw | None) -> Cylinder | None:
    """The compensator as a system; None where there is none, or the plant has it as its coil spring."""
    if law is None or law.coil is not None:
        return None
    return Cylinder(law, (built.bodies[law.body], built.bodies[law.arm]), pivots(arm, law))


def plant_diagram(plant: MultibodyPlant, laws: SlotSprings | None, cylinder: Cylinder | None) -> Diagram:
    """Plant and force laws; inputs `joint_force` (V,) and `wrench`, ExternallyAppliedSpatialForces."""
    builder = DiagramBuilder()
    builder.AddSystem(plant)
    summed = builder.AddSystem(Adder(1 if laws is None else 2, plant.num_velocities()))
    builder.ExportInput(summed.get_input_port(0), "joint_force")
    builder.Connect(summed.get_output_port(), plant.get_applied_generalized_force_input_port())
    if laws is not None:
        builder.AddSystem(laws)
        builder.Connect(plant.get_state_output_port(), laws.get_input_port())
        builder.Connect(laws.get_output_port(), summed.get_input_port(1))
    joined = builder.AddSystem(ExternallyAppliedSpatialForceMultiplexer(1 if cylinder is None else 2))
    builder.ExportInput(joined.get_input_port(0), "wrench")
    builder.Connect(joined.get_output_port(), plant.get_applied_spatial_force_input_port())
    if cylinder is not None:
        builder.AddSystem(cylinder)
        builder.Connect(plant.get_body_poses_output_port(), cylinder.get_input_port())
        builder.Connect(cylinder.get_output_port(), joined.get_input_port(1))
    return builder.Build()


def applied_wrench(body: RigidBody, wrench: Array) -> ExternallyAppliedSpatialForce:
    """Force and moment (6,) [N, N·m] at a body's origin, on the world's axes."""
    out: Any = ExternallyAppliedSpatialForce()
    pushed: Any = wrench
    out.body_index, out.p_BoBq_B = body.index(), np.zeros(3)
    out.F_Bq_W = SpatialForce(pushed[3:], pushed[:3])
    return out
