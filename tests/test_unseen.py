"""Numbers of causes are as sure as all else that may be there beside them leaves them."""

from __future__ import annotations

import numpy as np
from diagnosis_cases import measured

from workbench.diagnosis.run import diagnose

TOOL = 35.0  # kg that nobody stated
MASSES = (80.0, -38.0, 14.0, -10.0)  # kg, of links 2 to 5: a tenth or two of what they weigh


def of_tool(masses):
    """The kr120 with a tool that nobody stated, and links heavier and lighter than stated, of which none
    shows by itself."""
    links = [f"link_mass:link=link_{k},mass={mass}" for k, mass in enumerate(masses, 2) if mass]
    return diagnose(
        measured("kr120", effects=(f"payload:payload=tool,mass={TOOL}", *links), loads=(), seed=3)
    )


def mass_of(outcome):
    """Its mass as the diagnosis has it, and the standard deviation that the fit alone says."""
    (tool,) = [one for one in outcome.diagnosis.causes if one.cause == "payload"]
    effects = outcome.fit.model.effects
    (i,) = [i for i, e in enumerate(effects) if e.cause == "payload" and e.variant == "mass"]
    alone = float(np.sqrt(outcome.fit.effect_values(i)[1][0, 0]))
    return next(p for p in tool.parameters if p.name == "mass"), alone


def test_a_mass_is_as_sure_as_the_masses_beside_it_leave_it():
    mass, alone = mass_of(of_tool(MASSES))
    assert abs(mass.value - TOOL) > 10 * alone
    assert abs(mass.value - TOOL) < 3 * mass.std < 0.5 * TOOL


def test_of_an_arm_whose_masses_are_true_nobody_knows_that_they_are():
    mass, alone = mass_of(of_tool((0, 0, 0, 0)))
    assert abs(mass.value - TOOL) < 2 * alone < 2 * mass.std < 0.2 * TOOL
