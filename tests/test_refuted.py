"""A cause that its own numbers refute leaves its place to the likeliest that is none such, or to no name."""

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.campaign.problem import Problem
from workbench.diagnosis.run import diagnose
from workbench.robot.loads import wrenches


def hardening(problem: Problem) -> np.ndarray:
    """(N, n) joint_3 gives less than its model says under small loads, by 0.4 mrad under large ones."""
    torque = problem.arm.own(wrenches(problem.arm, problem.rigid, problem.loads).local)[:, 2]
    share = torque / np.abs(torque).max()
    out = np.zeros_like(problem.q)
    out[:, 2] = -4e-4 * np.sign(share) * (1 - np.exp(-3 * np.abs(share)))
    return out


def test_a_joint_that_is_stiffer_than_stated_has_that_name_and_no_other():
    """A soft zone that pushes back has its shape, a stiffness only roughly."""
    (cause,) = diagnose(measured("kr500", joints=hardening, seed=2, sigma=2e-5)).diagnosis.causes
    assert (cause.label, cause.parameters[0].value < 0) == ("joint_compliance(joint_3)", True)


@pytest.mark.slow
def test_what_pushes_back_where_nothing_gives_has_no_name():
    """Its model has no stiffness: nothing that yields does this."""
    (cause,) = diagnose(measured("irb120", joints=hardening, seed=2, sigma=2e-5)).diagnosis.causes
    assert cause.label == "unknown(joint_3)"
