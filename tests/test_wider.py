"""Where a robot yields in many places, sizes of those found are less sure than their fit says."""

from __future__ import annotations

import numpy as np
from diagnosis_cases import measured

from workbench.diagnosis.run import diagnose


def spreads(effects):
    """Standard deviations of the causes' first numbers, over those of the fit."""
    outcome = diagnose(measured("kr500", effects=effects))
    fit = outcome.fit
    of_fit = {
        effect.key: float(np.sqrt(np.diag(fit.effect_values(i)[1])[0]))
        for i, effect in enumerate(fit.model.effects)
    }
    causes = [cause for cause in outcome.diagnosis.causes if cause.cause == "joint_compliance"]
    return [cause.parameters[0].std / of_fit[cause.cause, cause.where] for cause in causes]


def soft(*joints):
    return tuple(f"joint_compliance:joint=joint_{j},relative=0.8" for j in joints)


def test_a_single_soft_joint_is_as_sure_as_its_fit():
    (spread,) = spreads(soft(3))
    assert np.isclose(spread, 1.0)


def test_sizes_of_a_robot_that_yields_everywhere_allow_for_what_was_not_found():
    found = spreads(soft(2, 3, 4))
    assert len(found) == 3
    assert min(found) >= 1.0
    assert max(found) > 1.2
