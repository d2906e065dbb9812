"""A robot and its campaign together: what every effect is evaluated on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .arm import Arm, Array, Frames, frames
from .campaign import Campaign
from .robot import Robot
from .statics import CompensatorLaw, Loads


@dataclass(frozen=True)
class Problem:
    """Robot, arm and campaign. N poses, n joints, T targets; `compensator` as the robot's TOML has it."""

    robot: Robot
    arm: Arm
    campaign: Campaign
    compensator: CompensatorLaw | None = None

    @property
    def q(self) -> Array:
        """Commanded joints (N, n) [rad or m]."""
        return self.campaign.q

    @cached_property
    def on(self) -> list[int]:
        """Slot behind which each target sits (T)."""
        return [self.arm.slot_of_link(target.on) for target in self.campaign.targets]

    @cached_property
    def seen(self) -> np.ndarray:
        """(N, T) bool: the target was measured in that pose."""
        return np.isfinite(self.campaign.points).all(axis=2)

    @cached_property
    def loads(self) -> Loads:
        """Loads as the campaign states them."""
        c = self.campaign
        mass = c.tool_mass + c.load_mass[c.payload]
        moment = c.tool_mass * c.tool_com + (c.load_mass[:, None] * c.load_com)[c.payload]
        return Loads(mass, moment, c.wrench, np.zeros_like(c.q), self.compensator)

    @cached_property
    def stated_targets(self) -> Array:
        """Stated places of the targets (T, 3) [m] in the frames behind their slots; NaN = unknown."""
        places = [target.xyz or (np.nan,) * 3 for target in self.campaign.targets]
        return np.array([self.arm.R_link[k] @ place for k, place in zip(self.on, np.array(places), strict=True)])

    @cached_property
    def rigid(self) -> Frames:
        """Frames of the rigid arm at the commanded joints."""
        return frames(self.arm, self.q)

    def joint(self, name: str | None) -> int:
        """Number of a joint, from 0."""
        return self.arm.names.index(str(name))


def problem(campaign: Campaign) -> Problem:
    """The campaign with its robot's arrays (reads Drake once)."""
    from .plant import arrays, compensator_law

    arm = arrays(campaign.robot)
    return Problem(campaign.robot, arm, campaign, compensator_law(campaign.robot, arm))
