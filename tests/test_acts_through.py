"""A load that shows only through what yields in the fit is no rival of that yield; a base tilts unevenly."""

import numpy as np
from diagnosis_cases import found, measured, named

from workbench import Truth, load_robot, planned, random_poses, simulate
from workbench.campaign.problem import problem
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.weighing.acts_through import needs_of
from workbench.diagnosis.weighing.components import cause_components
from workbench.effects.foundation import Foundation
from workbench.effects.hose_torque import HoseTorque
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.payload import Payload
from workbench.effects.place import Where
from workbench.effects.unnamed.loads import UnevenTilt
from workbench.identification.fit import refit
from workbench.robot.kinematics import RX, TX


def needs(name, load, *joints):
    """Of the payload: joints whose fitted compliances it needs, in a robot of that name."""
    geometry = prepare(measured(name, poses=30, loads=(load,))).geometry
    read = geometry.model.problem
    sites = {one.where.joint: one for one in JointCompliance.sites(read)}
    fitted = refit(geometry, [sites[joint] for joint in joints])
    components = cause_components(fitted, [*Payload.sites(read), *sites.values()])
    assert any(component.key[0] == "payload" for component in components)
    return {
        components[k].label: {components[i].key[1].joint for i in needed}
        for k, needed in needs_of(fitted, components).items()
    }


def test_a_payload_needs_the_one_joint_that_yields_to_it():
    for joint in ("joint_2", "joint_5"):
        # nothing else of it yields
        assert needs("irb120", 3.0, joint) == {"payload(load_1)": {joint}, "payload(tool)": {joint}}
    assert needs("cylindrical", 40.0, "joint_2") == {}  # its stated joints yield in any case


def test_a_joint_yields_to_the_hose_alone_that_turns_it():
    """No gravity turns the last joint, and that of a heavy arm turns the third."""
    hose = "hose_torque:joint=joint_6,rate=60"
    geometry = prepare(measured("kr500", (hose,), poses=30, loads=())).geometry
    read = geometry.model.problem
    fitted = refit(geometry, [HoseTorque(Where(joint="joint_6"))])
    components = cause_components(fitted, [*HoseTorque.sites(read), *JointCompliance.sites(read)])
    label = {k: component.label for k, component in enumerate(components)}
    found = {label[k]: {label[i] for i in needed} for k, needed in needs_of(fitted, components).items()}
    assert found == {"joint_compliance(joint_6)": {"hose_torque(joint_6)"}}


def test_a_tilt_is_not_taken_for_the_load_that_shows_by_it():
    tilt = "bearing_tilt:joint=joint_5,compliance=1.5e-4"
    campaign = measured("irb120", (tilt,), poses=40, loads=(3.0,), sigma=1e-5)
    assert named(found(campaign)) == {("bearing_tilt", "joint_5"): "named"}


def test_a_bearing_that_tilts_unevenly_is_no_foundation():
    """A foundation may be softer about one axis than about the other, and so may a bearing."""
    robot = load_robot("kr500")
    plan = planned(robot, random_poses(robot, 60, np.random.default_rng(4)))
    C = 1e-7 * np.array([[1.2, 0.1], [0.1, 0.8]])

    def stiffens(wrench):
        moment = wrench[RX : RX + 2]
        tilt = C @ moment * np.hypot(np.linalg.norm(moment) / 1e4, 0.05) ** -0.1
        return np.array([0, 0, 0, *tilt, 0])

    told = found(simulate(plan, Truth(yields={1: stiffens}, sigma=3e-5), seed=4))
    assert named(told) == {("bearing_tilt", "joint_1"): "named"}


def test_an_uneven_base_is_a_share_of_its_tilt():
    read = problem(measured("kr120", (), poses=12))
    ((share, uneven),) = Foundation().companions(read)
    assert isinstance(uneven, UnevenTilt)
    assert 0 < share < 1
    motion = uneven.motion(read)
    moment = uneven.moment(read) / uneven.largest
    assert np.abs(moment).max() <= 1 + 1e-12
    for weights, matrix in (((1, 0, 0, 0), [[1, 0], [0, -1]]), ((0, 1, 0, 0), [[0, 1], [1, 0]])):
        turned = np.column_stack([motion[column] @ weights for column in (RX, RX + 1)])
        np.testing.assert_allclose(turned, moment @ np.array(matrix), atol=1e-12)
    shifted = np.column_stack([motion[column] @ (0, 0, 0, 1) for column in (TX, TX + 1)])
    turned = np.column_stack([motion[column] @ (0, 0, 0, 1) for column in (RX, RX + 1)])
    assert not turned.any()
    height = 1.5  # of the base over where it turns, for a tilt of its moment
    np.testing.assert_allclose(shifted, height * moment[:, ::-1] * (1, -1), atol=1e-12)


def test_a_load_to_which_a_joint_was_found_to_yield_could_be_seen():
    """Beside geometry alone, of a model without stiffness, no mass moves anything."""
    soft = "joint_compliance:joint=joint_2,compliance=2e-5"
    diagnosis = diagnose(measured("irb120", (soft,), poses=40, loads=(3.0,), sigma=1e-5)).diagnosis
    assert ("joint_compliance", "joint_2") in {(f.cause, f.where.joint) for f in diagnosis.causes}
    untested = {(item.cause, str(item.where)) for item in diagnosis.not_testable}
    assert ("joint_compliance", "joint_1") in untested  # it is upright: no load turns it
    assert ("payload", "load_1") not in untested
    assert ("link_mass", "link_3") not in untested
