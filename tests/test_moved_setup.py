"""What is smooth in time is no step of the instrument or the tool."""

import numpy as np
from diagnosis_cases import measured

from workbench.diagnosis.prepared import prepare


def test_an_arm_that_warms_up_has_no_tool_that_was_mounted_anew():
    time = 60.0 * np.arange(90)
    warm = f"thermal_growth:variant=warmup,coefficient=2.5e-4,constant={0.2 * time[-1]:.0f},start=0"
    campaign = measured("iiwa7", (warm,), poses=90, seed=4, loads=(), time=time, sigma=2e-5)
    assert prepare(campaign).faults == ()
