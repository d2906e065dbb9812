"""Large sizes in the sentences of effects are written out: 290 µrad, not 2.9e+02."""

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.campaign.problem import problem_of
from workbench.effects.bearing_tilt import BearingTilt
from workbench.effects.foundation import Foundation
from workbench.effects.unnamed.curved_yield import CurvedYield


@pytest.mark.parametrize("kind", [BearingTilt, Foundation, CurvedYield])
def test_large_sizes_are_written_out(kind):
    effect = kind.sites(problem_of(measured("6R")))[0]
    values = np.array([2.9e-7 if kind is not CurvedYield else 2.9e-4] + [0.0] * (len(effect.params) - 1))
    said = effect.sentence(values)
    assert "290 µrad" in said
    assert "e+" not in said
