"""An arm that yields in several places: the others stand in its model too, and sizes allow for them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from diagnosis_cases import measured

from workbench.diagnosis.run import diagnose
from workbench.diagnosis.search.competition import Selection
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.place import Where

SOFT = tuple(f"joint_compliance:joint=joint_{j},relative=0.8" for j in (2, 3, 4))
EVERYWHERE = (
    *SOFT,
    "foundation:compliance=4e-9",
    *(f"bearing_tilt:joint=joint_{j},compliance=1.5e-8" for j in (2, 3)),
    *(f"link_bending:link=link_{j},compliance=1.5e-8" for j in (2, 3)),
)


def held(outcome):
    return [i for i, effect in enumerate(outcome.fit.model.effects) if effect.is_held]


def test_a_single_soft_joint_is_all_that_yields():
    outcome = diagnose(measured("kr500", effects=SOFT[:1]))
    assert [cause.cause for cause in outcome.diagnosis.causes] == ["joint_compliance"]
    assert not held(outcome)


def test_sizes_of_an_arm_that_yields_everywhere_are_those_of_its_places():
    outcome = diagnose(measured("kr500", effects=EVERYWHERE, poses=40))
    found = [cause for cause in outcome.diagnosis.causes if cause.cause == "joint_compliance"]
    assert {cause.where.joint for cause in found} >= {"joint_2", "joint_3"}
    for cause in found:
        (relative,) = cause.parameters
        assert abs(relative.value - 0.8) < 3 * relative.std
    assert any("elsewhere too" in note for note in outcome.diagnosis.notes)
    assert len(held(outcome)) >= 3
    for i in held(outcome):  # none gives against its load, each has a size
        assert outcome.fit.effect_values(i)[0][0] >= outcome.fit.model.effects[i].params[0].lower
        assert np.isfinite(outcome.fit.columns.prior[outcome.fit.columns.effect[i]]).all()


def test_what_is_held_has_no_name_though_the_search_had_one_for_its_place():
    """A member that brought nothing leaves the fit, and its place may come back as one that also yields."""
    soft = JointCompliance(Where(joint="joint_6"))
    member = SimpleNamespace(component=0)
    found = SimpleNamespace(components=[SimpleNamespace(key=soft.key)], members=[member], faint=frozenset())
    assert Selection.named(found, soft)
    assert not Selection.named(found, replace(soft, held=1e-6))
