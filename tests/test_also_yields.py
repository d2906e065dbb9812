"""An arm that yields in several places: the others stand in its model too, and sizes allow for them."""

from __future__ import annotations

import numpy as np
from diagnosis_cases import measured

from workbench.diagnosis.also_yields import is_held
from workbench.diagnosis.run import diagnose

SOFT = tuple(f"joint_compliance:joint=joint_{j},relative=0.8" for j in (2, 3, 4))
EVERYWHERE = (
    *SOFT,
    "foundation:compliance=4e-9",
    *(f"bearing_tilt:joint=joint_{j},compliance=1.5e-8" for j in (2, 3)),
    *(f"link_bending:link=link_{j},compliance=1.5e-8" for j in (2, 3)),
)


def held(outcome):
    return [i for i, effect in enumerate(outcome.fit.model.effects) if is_held(effect)]


def test_a_single_soft_joint_is_all_that_yields():
    outcome = diagnose(measured("kr500", effects=SOFT[:1]))
    assert [cause.cause for cause in outcome.diagnosis.causes] == ["joint_compliance"]
    assert not held(outcome)


def test_sizes_of_an_arm_that_yields_everywhere_are_those_of_its_places():
    outcome = diagnose(measured("kr500", effects=EVERYWHERE))
    found = [cause for cause in outcome.diagnosis.causes if cause.cause == "joint_compliance"]
    assert {cause.where.joint for cause in found} >= {"joint_2", "joint_3"}
    for cause in found:
        (relative,) = cause.parameters
        assert abs(relative.value - 0.8) < 3 * relative.std
    assert any("elsewhere too" in note for note in outcome.diagnosis.notes)
    for i in held(outcome):  # none gives against its load
        assert outcome.fit.effect_values(i)[0][0] >= outcome.fit.model.effects[i].params[0].lower


def test_what_is_held_has_the_size_of_what_was_found():
    outcome = diagnose(measured("kr500", effects=EVERYWHERE))
    fit = outcome.fit
    sizes = [fit.columns.prior[fit.columns.effect[i]] for i in held(outcome)]
    assert len(sizes) >= 3
    assert np.isfinite(sizes).all()
