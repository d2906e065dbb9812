"""A scale that is not the same in all campaigns that are fitted as one: told with its size, taken out."""

import re
from dataclasses import replace

import pytest
from diagnosis_cases import named
from test_moved_zero import of_one_robot

from workbench.campaign import load_campaign, write_campaign
from workbench.diagnosis.run import diagnose


def scaled(path, folder, times):
    """The campaign with all points that many times as far from the instrument."""
    campaign = load_campaign(path)
    return write_campaign(folder, replace(campaign, points=times * campaign.points))


@pytest.mark.parametrize(("ppm", "poses"), [pytest.param(150, 25, marks=pytest.mark.slow), (-60, 40)])
def test_a_scale_that_is_another_is_told_with_its_size_and_hides_no_cause(tmp_path, ppm, poses):
    first, second, other = of_one_robot(tmp_path, [0.0] * 6, poses=poses)
    found = diagnose([scaled(first, tmp_path / "scaled", 1 + 1e-6 * ppm), second], test=other).diagnosis
    (fault,) = found.faults
    assert fault.kind == "changed_scale"
    size, error = (float(v) for v in re.findall(r"(\d+(?:\.\d+)?) ppm", fault.what))
    assert size == pytest.approx(abs(ppm), abs=3 * error)
    assert error < 15
    assert ("longer" if ppm > 0 else "shorter") in fault.what
    assert fault.what in found.headline
    assert set(named(found)) == {("gear_eccentricity", "elbow_joint")}
    alone = diagnose(second, test=other).diagnosis
    assert found.test.after_rms_mm < 1.05 * alone.test.after_rms_mm
