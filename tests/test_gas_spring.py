"""Gas spring between two links: torque and stiffness of one energy, the fit of (12), charge and length."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workbench.campaign import Campaign
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import Problem, problem_of
from workbench.effects.joint_compliance import JointCompliance
from workbench.files.faults import InputError
from workbench.identification.gravity_compensator.charge import EFFECTS, identify_charge
from workbench.identification.gravity_compensator.gas_spring import Linkage, added_stiffness, bias, linkage
from workbench.identification.gravity_compensator.pressure import fit_coil, fit_gas, odds, told_apart
from workbench.identification.gravity_compensator.spring_fit import fit_spring
from workbench.measurement.load_pairs import (
    compliances,
    difference_rows,
    fit_pairs,
    measure_pairs,
    pairs,
)
from workbench.robot.description import load_robot
from workbench.robot.kinematics import frames
from workbench.simulation.virtual_campaign import Truth, simulate

ANGLES = np.radians(np.linspace(-140, -5, 6))
GAS, LENGTH = EFFECTS


@pytest.fixture(scope="module")
def job() -> Problem:
    q = np.zeros((6, 6))
    q[:, 1] = ANGLES
    return problem_of(planned(load_robot("kr120"), q))


def triangle_of(job: Problem) -> Linkage:
    assert job.compensator is not None
    return linkage(job.arm, job.compensator)


def test_triangle_is_that_of_the_pivots(job: Problem) -> None:
    triangle = triangle_of(job)
    assert job.compensator is not None
    np.testing.assert_allclose(
        triangle.stretch(ANGLES)[0], job.compensator.ends(frames(job.arm, job.q))[2], atol=1e-12
    )
    # physics: from the public pivots
    assert triangle.a == pytest.approx(0.8028, abs=1e-4)
    assert pytest.approx(0.2002, abs=1e-4) == triangle.L
    assert np.degrees(triangle.alpha) == pytest.approx(88.09, abs=0.03)


def test_torque_is_the_statics_own(job: Problem) -> None:
    assert job.compensator is not None
    without = replace(job, compensator=None)
    pulled = job.nominal_load.local[:, 2, 5] - without.nominal_load.local[:, 2, 5]
    np.testing.assert_allclose(bias(triangle_of(job), job.compensator, ANGLES), pulled, rtol=1e-9)


def test_stiffness_is_the_slope_of_the_torque(job: Problem) -> None:
    triangle, law, h = triangle_of(job), job.compensator, 1e-5
    assert law is not None
    slope = (bias(triangle, law, ANGLES + h) - bias(triangle, law, ANGLES - h)) / (2 * h)
    np.testing.assert_allclose(added_stiffness(triangle, law, ANGLES), -slope, rtol=1e-6)


def test_a_spring_that_made_the_compliances_is_found_again(job: Problem) -> None:
    triangle, law = triangle_of(job), job.compensator
    assert law is not None
    gas = replace(law, data=law.data.model_copy(update={"precharge": 8e8, "gas_length": 0.6}))
    area = law.data.piston_area or 0.0
    k = 1 / (3e6 + added_stiffness(triangle, gas, ANGLES))
    found = fit_spring(triangle, area, ANGLES, k, 1e-3 * k)
    assert found.chi2 < 0.1
    assert found.stiffness == pytest.approx(3e6, rel=0.01)
    force = gas.force(triangle.stretch(ANGLES)[0])[0]
    np.testing.assert_allclose(found.force, force, rtol=0.05)
    np.testing.assert_allclose(found.torque, bias(triangle, gas, ANGLES), rtol=0.05)
    # the source's parameters say the same: F = P0 A (s − s0)/(s0 + sV − s)
    s = triangle.stretch(ANGLES)[0]
    theirs = 101325.0 * area * (s - found.s0) / (found.s0 + found.sV - s)
    np.testing.assert_allclose(theirs, found.force, rtol=1e-6)


def test_gas_length_moves_the_torque_as_its_derivative_says(job: Problem) -> None:
    def local(x: float) -> np.ndarray:
        arm, loads = LENGTH.apply(job, job.arm, job.loads, np.array([x]))
        from workbench.robot.loads import wrenches

        return wrenches(arm, job.rigid, loads).local

    h = 1e-6
    difference = (local(0.1 + h) - local(0.1 - h)) / (2 * h)
    _, loads = LENGTH.apply(job, job.arm, job.loads, np.array([0.1]))
    np.testing.assert_allclose(LENGTH.wrench(job, job.rigid, loads)[..., 0], difference, rtol=1e-6, atol=1e-5)


def test_the_exponent_is_that_of_the_polytrope(job: Problem) -> None:
    """Its force from pressure times volume to the exponent; its derivative from differences of that."""
    law = job.compensator
    assert law is not None
    s = triangle_of(job).stretch(ANGLES)[0]
    gas = law.data
    assert gas.piston_area
    assert gas.precharge
    assert gas.gas_length
    assert gas.reference
    area, least = gas.piston_area, gas.gas_length + gas.reference

    def force(exponent: float) -> np.ndarray:
        constant = gas.precharge * (area * gas.gas_length) ** exponent  # p Vⁿ
        return np.asarray(area * (constant / (area * (least - s)) ** exponent - 101325.0))

    changed = law.of_exponent(1.23)
    np.testing.assert_allclose(changed.force(s)[0], force(1.23), rtol=1e-12)
    slope = (force(1.23 + 1e-6) - force(1.23 - 1e-6)) / 2e-6
    np.testing.assert_allclose(changed.by_exponent(s), slope, rtol=1e-6, atol=1e-3)


def test_a_coil_has_no_exponent() -> None:
    coil = problem_of(planned(load_robot("rx170"), np.zeros((1, 6)))).compensator
    assert coil is not None
    with pytest.raises(ValueError, match="no polytropic exponent"):
        coil.by_exponent(np.ones(3))


@pytest.fixture(scope="module")
def measured() -> Campaign:
    robot = load_robot("kr120")
    q = random_poses(robot, 40, np.random.default_rng(4))
    plan = planned(robot, q, targets=[replace(target, fixed=True) for target in TARGETS])
    truth = Truth(effects=((GAS, np.array([-0.1])), (LENGTH, np.array([0.1]))), sigma=3e-5)
    return simulate(plan, truth, seed=1, torque_sigma=0.02)


@pytest.mark.parametrize("witness", ["points", "torque", "both"])
def test_charge_and_length_lie_in_their_intervals(measured: Campaign, witness: str) -> None:
    found = identify_charge(measured, witness, 0.02)  # type: ignore[arg-type]
    # torques alone: an error of the column that goes with the joint's angle looks like a little charge
    assert abs(found.charge + 0.1) < 3.5 * found.charge_std < (0.04 if witness == "torque" else 0.03)
    assert abs(found.length - 0.1) < 3.5 * found.length_std < 0.25


def test_charge_without_torque_or_compensator_is_refused(measured: Campaign) -> None:
    with pytest.raises(InputError, match="no torques"):
        identify_charge(measured.with_poses(torque=None), "torque")
    bare = replace(measured, robot=replace(measured.robot, compensator=None))
    with pytest.raises(InputError, match="no gas compensator"):
        identify_charge(bare, "points")


def test_compliances_come_out_of_loaded_minus_unloaded() -> None:
    robot = load_robot("kr120")
    q = random_poses(robot, 12, np.random.default_rng(6))
    pull = np.zeros((12, 3))
    pull[:4, 1] = 500.0
    plan = pairs(robot, q, (120.0, (0.2, 0.0, 0.1)), pull, TARGETS, (20.0, (0.0, 0.0, 0.1)))
    assert difference_rows(plan).shape == (12, 9, 6)
    fixed = replace(plan, targets=tuple(replace(target, fixed=True) for target in plan.targets))
    still = measure_pairs(fixed, Truth(sigma=1e-5), 2, (np.eye(3), np.zeros(3)))
    found = fit_pairs(still, JointCompliance.each, 1e-5)
    values, std = compliances(found)
    k = [1 / (joint.data.stiffness or np.inf) for joint in robot.joints]
    np.testing.assert_array_less(abs(values - k), 4 * std)


# KUKA KR 300, Robot_Identification (Weigand, public): the gauge at nine angles of joint 2, and its geometry
KR300_ANGLES = np.radians(np.arange(-120.0, -39.0, 10.0))
KR300_PRESSURES = 1e5 * np.array([170.0, 167, 164, 162, 164, 170, 180, 190, 200])
KR300 = Linkage(0.8, 0.2, np.radians(85.0))
KR300_AREA = np.pi / 4 * (0.055**2 - 0.030**2)  # m², piston less rod


def test_nine_measured_pressures_give_charge_and_length_and_no_kind() -> None:
    gas = fit_gas(KR300, KR300_ANGLES, KR300_PRESSURES)
    assert gas.values == pytest.approx([163.0e5, 0.547], rel=2e-3)
    assert gas.std == pytest.approx([0.66e5, 0.0196], rel=0.02)
    known = fit_gas(KR300, KR300_ANGLES, KR300_PRESSURES, length=2 * 0.48e-3 / KR300_AREA)
    assert known.values[1] == pytest.approx(1.059, abs=2e-3)
    assert known.std[1] == pytest.approx(0.042, abs=1e-3)
    coil = fit_coil(KR300, KR300_ANGLES, KR300_PRESSURES)
    assert (gas.rms, coil.rms) == pytest.approx((1.34e5, 1.11e5), rel=0.01)
    assert not told_apart(gas, coil)
    assert 0.1 < odds(gas, coil) < 1.0


def test_a_longer_stroke_tells_gas_from_coil() -> None:
    """The same gas with the same scatter, over the whole range of the joint."""
    q = np.radians(np.arange(-140.0, 21.0, 10.0))
    rng = np.random.default_rng(3)
    s = KR300.stretch(q)[0] - 0.6
    for kind, pressure in (("gas", 163e5 * 0.547 / (0.547 - s)), ("coil", 163e5 + 4e7 * s)):
        seen = pressure + 1.3e5 * rng.normal(size=len(q))
        gas, coil = fit_gas(KR300, q, seen), fit_coil(KR300, q, seen)
        assert told_apart(gas, coil)
        assert (odds(gas, coil) > 1) == (kind == "gas")
        if kind == "gas":
            assert (np.abs(gas.values - [163e5, 0.547]) < 4 * gas.std).all()
