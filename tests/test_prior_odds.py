"""What is taken for granted of causes before the data speak."""

from collections import defaultdict
from itertools import product

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.priors import PRIORS
from workbench.diagnosis.weighing.components import cause_components
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.lost_motion import LostMotion


def components(name, load):
    geometry = prepare(measured(name, poses=30, loads=(load,))).geometry
    problem = geometry.model.problem
    return cause_components(geometry, [*JointCompliance.sites(problem), *LostMotion.sites(problem)])


def test_finer_settings_make_no_shape_likelier():
    """A soft zone is tried at 18 widths, hardening is one form: a third of the cause each, with play."""
    soft = next(one for one in components("kr500", 200.0) if one.key[0] == "lost_motion")
    shares = defaultdict(float)
    for form, share in zip(soft.forms, np.exp(soft.log_shares), strict=True):
        shares[form.effects[0].shape] += share
    assert shares == pytest.approx({"soft": 1 / 3, "play": 1 / 3, "cubic": 1 / 3})


@pytest.mark.parametrize(("name", "load", "stated"), [("kr500", 200.0, True), ("irb120", 3.0, False)])
def test_of_joints_that_no_model_has_as_soft_some_yield_out_of_proportion(name, load, stated):
    found = [one for one in components(name, load) if one.key[0] == "lost_motion"]
    expected = PRIORS.cause / len(found) if stated else PRIORS.rarer * PRIORS.unstated
    assert [1 / (1 + np.exp(-one.log_odds)) for one in found] == pytest.approx([expected] * len(found))


def test_an_error_of_any_shape_is_likelier_than_one_of_a_shape_of_its_own():
    found = components("kr500", 200.0)
    maps, run_outs = ([c for c in found if c.key[0] == one] for one in ("joint_map", "gear_eccentricity"))
    odds = [
        np.exp(one.log_odds - other.log_odds) * len(maps) / len(run_outs)
        for one, other in product(maps, run_outs)
    ]
    assert odds == pytest.approx([PRIORS.any_shape] * len(odds), rel=0.02)
