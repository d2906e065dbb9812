"""How far the exported plant is from the model because its slots give way one hinge after the other.

In the model a slot shifts and turns at once, by C · wrench; in a file it slides and turns about lines, each
by a spring of its own (`closed_loop/mechanics.py`). Both have the same compliance at zero. A hinge that lies
off its slot, as that of a bending link in the middle of its length, moves the slot on an arc instead of a
straight line: ½ φ² times that lever, and as much by what the loads then do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from pydrake.multibody.tree import MultibodyForces

from ...robot.equilibrium import NoRest, equilibrium
from ...robot.kinematics import Array
from .coil import nearest_coil
from .content import Content
from .simulated import simulated

LEVER = 1e-9  # m


def off_by_hinges(content: Content) -> Array | None:
    """(N, 3) [m] flange of the plant at rest minus the model's, in the poses, for what yields in proportion
    to its load; None where all hinges lie in their slots. Raises NoRest where the arm finds no rest."""
    made = simulated(content, nearest_coil(content))
    if not any(give.turns and np.linalg.norm(give.point) > LEVER for give in made.gives):
        return None
    arm, loads = content.loaded
    loads = replace(loads, compensator=nearest_coil(content))
    arm, q, still = replace(arm, compliance=content.compliance), content.problem.q, (arm.slots, 6)
    law = content.acting(frozenset({"spring"})).yielding(content.problem.arm)
    model = equilibrium(arm, q, np.zeros((len(q), *still)), loads, law.motion)[1].p[-1]
    built = made.machine
    plant, context = built.plant, built.plant.CreateDefaultContext()
    forces = MultibodyForces(plant)
    place: Any = np.zeros(plant.num_positions())
    flange = np.empty_like(model)
    for i, joints in enumerate(q):
        place[built.motors] = joints
        for _ in range(60):
            plant.SetPositions(context, place)
            plant.CalcForceElementsContribution(context, forces)
            step = plant.CalcGeneralizedForces(context, forces)[built.springs] / built.stiffness
            place[built.springs] += step
            if np.abs(step).max() < 1e-12:
                break
        else:
            raise NoRest
        flange[i] = built.flange.CalcPoseInWorld(context).translation()
    return flange - model
