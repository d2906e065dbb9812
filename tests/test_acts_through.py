"""A load that shows only through what yields in the fit is no rival of that yield; a base tilts unevenly."""

import numpy as np
from diagnosis_cases import measured

from workbench.campaign.problem import problem
from workbench.diagnosis.acts_through import needs_of
from workbench.diagnosis.components import cause_components
from workbench.diagnosis.prepared import prepare
from workbench.effects.foundation import Foundation
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.payload import Payload
from workbench.effects.unnamed.loads import UnevenTilt
from workbench.identification.fit import refit


def test_a_payload_needs_the_one_joint_that_yields_to_it():
    campaign = measured("cylindrical", poses=30, loads=(40.0,))
    geometry = prepare(campaign).geometry
    read = geometry.model.problem
    loads, joints = list(Payload.sites(read)), list(JointCompliance.sites(read))
    components = cause_components(geometry, [*loads, *joints])
    assert needs_of(geometry, components) == {}
    soft = next(one for one in joints if one.where.joint == "joint_2")
    fitted = refit(geometry, [soft])
    at = cause_components(fitted, [*loads, *joints])
    by_key = {component.key: k for k, component in enumerate(at)}
    found = needs_of(fitted, at)
    assert set().union(*found.values()) <= {by_key[soft.key]}


def test_an_uneven_base_is_a_share_of_its_tilt():
    read = problem(measured("kr120", (), poses=12))
    ((share, uneven),) = Foundation().companions(read)
    assert isinstance(uneven, UnevenTilt)
    assert 0 < share < 1
    motion = uneven.motion(read)
    moment = uneven.moment(read) / uneven.largest
    assert np.abs(moment).max() <= 1 + 1e-12
    for weights, matrix in (((1, 0, 0), [[1, 0], [0, -1]]), ((0, 1, 0), [[0, 1], [1, 0]])):
        turned = np.column_stack([motion[column] @ weights for column in sorted(motion)])
        np.testing.assert_allclose(turned, moment @ np.array(matrix), atol=1e-12)
