"""A target that does not sit as the others do: on a burr, in a worn nest; or whose reflector errs."""

from __future__ import annotations

import numpy as np

from ...campaign.problem import Problem
from ...identification.noise import Covariance, stated_noise
from ..noise.distances import LOOSE
from ..result import FaultFound


def loose_targets(problem: Problem, noise: Covariance) -> tuple[FaultFound, ...]:
    """Targets that have been given so much more noise than the campaign states than others have."""
    said = stated_noise(problem)
    if said is None:
        return ()
    times = np.median(noise.sigma / said.sigma, axis=0)
    found = []
    for t in np.flatnonzero(times > LOOSE * times.min()):
        name, size = problem.campaign.targets[t].name, 1e3 * np.median(noise.sigma[:, t])
        what = (
            f"target {name} scatters by {size:.3f} mm per axis against the others, which do so by no more "
            "than stated: look at its nest and its reflector"
        )
        found.append(FaultFound("loose_target", None, name, what, "its points count for as much less"))
    return tuple(found)
