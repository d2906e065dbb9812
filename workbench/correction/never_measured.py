"""What a correction stands on that nobody measured, in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..campaign.flange_load import beyond_load
from ..campaign.measured_when import beyond_temperature, kelvin_beyond
from ..robot.ranges import beyond_range
from ..robot.uncertainty import Uncertainty
from .trajectory import Trajectory


def never_measured(trajectory: Trajectory) -> Iterator[str]:
    """Notes where the correction stands on no measurement: of this robot at all, or of it so."""
    robot = trajectory.robot
    if not robot.geometry and not robot.effects:
        yield "nothing in this model was identified: it corrects what its stated numbers say, and no more"
    data = robot.uncertainty
    if data is None:
        return
    if not data.base_measured:
        yield (
            "no target on the base was measured: the path is right in itself, but all of it may be shifted, "
            "as far as axis 1 stands otherwise in the base: take base or work object anew with this model"
        )
    if not data.flange_measured:
        yield (
            "no two targets on the flange are stated as calibrated (fixed = true): the tool may be turned "
            f"about and shifted along the axis of {trajectory.nominal.names[-1]}, everywhere alike: take the "
            "tool anew with this model"
        )
    yield from _elsewhere(trajectory, data)
    other = beyond_load(trajectory.extended.problem, data.flange_load)
    if other.any():
        yield (
            f"at {other.sum()} of {len(other)} samples the flange is loaded otherwise than it was when the "
            "robot was measured: how it yields to that is extrapolated; measure it under such loads as well"
        )
    yield from _warmer(trajectory, data)


def _elsewhere(trajectory: Trajectory, data: Uncertainty) -> Iterator[str]:
    off = beyond_range(trajectory.q, np.array(data.lower), np.array(data.upper))
    if off.any():
        joints = ", ".join(trajectory.nominal.names[j] for j in np.flatnonzero(off.any(axis=0)))
        yield (
            f"at {off.any(axis=1).sum()} of {len(off)} samples joints stand where they were not measured "
            f"({joints}): what is corrected there is extrapolated; workbench predict has the bounds"
        )


def _warmer(trajectory: Trajectory, data: Uncertainty) -> Iterator[str]:
    by_warmth = "temperature" in trajectory.extended.acting.uses
    kelvin = kelvin_beyond(trajectory.extended.problem, data.temperature_degC, by_warmth)
    off = beyond_temperature(kelvin, data.temperature_degC)
    if off.any():
        yield (
            f"at {off.sum()} of {len(off)} samples the arm is up to {np.abs(kelvin).max():.2g} K warmer or "
            "colder than it was when the robot was measured: how it grows by that is extrapolated"
        )
