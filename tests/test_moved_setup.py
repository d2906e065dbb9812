"""What is smooth in time is no step of the instrument or the tool."""

import numpy as np
from diagnosis_cases import measured

from workbench.diagnosis.prepared import prepare


def test_an_arm_that_warms_up_has_no_tool_that_was_mounted_anew():
    time = 60.0 * np.arange(90)
    warm = f"thermal_growth:variant=warmup,coefficient=2.5e-4,constant={0.2 * time[-1]:.0f},start=0"
    campaign = measured("iiwa7", (warm,), poses=90, seed=4, loads=(), time=time, sigma=2e-5)
    assert prepare(campaign).faults == ()


def test_a_slide_that_is_not_straight_has_no_instrument_that_moved():
    """Chance orders some of its errors like a step; they are alike in the points of a pose."""

    def crooked(problem):
        travel = 2 * np.pi * problem.q[:, 1] / 0.35
        return {6 * 2 + 3: 1e-3 * np.sin(travel + 1), 6 * 2 + 4: 1e-3 * np.cos(1.7 * travel)}

    assert (
        prepare(measured("cylindrical", poses=60, loads=(), seed=6, sigma=2e-5, motion=crooked)).faults == ()
    )
