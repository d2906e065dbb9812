"""A robot and its campaign together: what every effect is evaluated on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..robot.compensator import CompensatorLaw
from ..robot.description import Robot
from ..robot.hidden_geometry import hidden_corrections
from ..robot.kinematics import RZ, TZ, Arm, Array, Frames, frames
from ..robot.loads import Loads, Wrenches, wrenches
from . import Campaign, drive_torque

REFERENCE_TEMPERATURE = 20.0  # °C, at which the nominal robot holds
ON_BASE = 3  # fixed targets on the base that say where it is
BESIDE = 0.01  # m from the last axis: a target that is nearer shows no turn about it


@dataclass(frozen=True)
class Problem:
    """Robot, arm and campaign. N poses, n joints, T targets; `compensator` as the robot's TOML has it;
    `coarse`: how many times as large as in an industrial arm this machine's errors are; `rounded`: joints of
    which many poses have one value, written down so coarsely that they show no function of the angle."""

    robot: Robot
    arm: Arm
    campaign: Campaign
    compensator: CompensatorLaw | None = None
    coarse: float = 1.0
    rounded: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Problem: {self.campaign!r}"

    @property
    def q(self) -> Array:
        """Commanded joints (N, n) [rad or m]."""
        return self.campaign.poses.q

    @cached_property
    def on(self) -> list[int]:
        """Slot behind which each target sits (T)."""
        return [self.arm.slot_of_link(target.on) for target in self.campaign.targets]

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(N, T) bool: the target was measured in that pose."""
        return np.asarray(np.isfinite(self.campaign.points).all(axis=2))

    @cached_property
    def loads(self) -> Loads:
        """Loads as the campaign states them."""
        c = self.campaign
        mass = c.tool_mass + c.load_mass[c.poses.payload]
        moment = c.tool_mass * c.tool_com + (c.load_mass[:, None] * c.load_com)[c.poses.payload]
        return Loads(mass, moment, c.poses.wrench, np.zeros_like(c.poses.q), self.compensator)

    @cached_property
    def stated_targets(self) -> Array:
        """Stated places of the targets (T, 3) [m] in the frames behind their slots; NaN = unknown."""
        places = [target.xyz or (np.nan,) * 3 for target in self.campaign.targets]
        return np.array(
            [self.arm.R_link[k] @ place for k, place in zip(self.on, np.array(places), strict=True)]
        )

    @property
    def drives(self) -> int:
        """Rows of drive torque beside a pose's points: n where they were recorded, else 0."""
        return 0 if self.campaign.poses.torque is None else self.arm.n

    @cached_property
    def positions(self) -> NDArray[np.int64]:
        """(N,) number of the joint position within its set-up: equal for its loads and repeats."""
        return self.campaign.poses.positions

    @cached_property
    def rigid(self) -> Frames:
        """Frames of the rigid arm at the commanded joints."""
        return frames(self.arm, self.q)

    @cached_property
    def nominal_load(self) -> Wrenches:
        """Wrenches at the slots of the rigid arm under the stated loads."""
        return wrenches(self.arm, self.rigid, self.loads)

    @cached_property
    def own_of_drives(self) -> list[drive_torque.Drive]:
        """What the joints' drives make of their own of the recorded torques."""
        return drive_torque.drives(self)

    @cached_property
    def hidden_corrections(self) -> frozenset[int]:
        """Columns of corrections that no measured point can show."""
        return hidden_corrections(self.arm)

    @cached_property
    def base_measured(self) -> bool:
        """Whether fixed targets on the base say where it is."""
        on_base = np.array([target.fixed for target in self.campaign.targets]) & (np.array(self.on) == 0)
        return int((self.seen.any(axis=0) & on_base).sum()) >= ON_BASE

    @cached_property
    def flange_stays(self) -> frozenset[int]:
        """Columns of corrections that turn the flange about the last axis or shift it along that, unless it
        was measured. Loads alone tell them from how the targets sit on it, so faintly that a fit would move
        the flange at random."""
        last = 6 * self.arm.n
        return frozenset() if self.flange_measured else frozenset({last + TZ, last + RZ})

    @cached_property
    def flange_measured(self) -> bool:
        """Whether a fixed target beside the last axis says how the flange stands about and along it."""
        arm, last = self.arm, self.arm.n
        for i, (target, on) in enumerate(zip(self.campaign.targets, self.on, strict=True)):
            if target.fixed and on >= last and self.seen[:, i].any():
                place = arm.R_link[on] @ np.array(target.xyz)
                x, y, _ = place if on == last else arm.R[-1] @ place + arm.p[-1]
                if np.hypot(x, y) > BESIDE:
                    return True
        return False

    @cached_property
    def warmth(self) -> Array | None:
        """Temperature (N,) [K] over 20 °C, empty cells at the mean; None without the column."""
        return filled(self.campaign.poses.temperature, REFERENCE_TEMPERATURE)

    @cached_property
    def time(self) -> Array | None:
        """Time (N,) [s], empty cells at the mean; None without the column."""
        return filled(self.campaign.poses.time, 0.0)

    @property
    def time_passes(self) -> bool:
        """Whether times were recorded that tell its poses apart."""
        return self.time is not None and bool(np.ptp(self.time) > 0)

    def joint(self, name: str | None) -> int:
        """Number of a joint, from 0."""
        return self.arm.names.index(str(name))


def filled(column: Array | None, reference: float) -> Array | None:
    """A column (N,) from its reference, NaN replaced by the mean; None where all are NaN."""
    if column is None or not np.isfinite(column).any():
        return None
    return np.where(np.isfinite(column), column, np.nanmean(column)) - reference


def problem_of(campaign: Campaign) -> Problem:
    """The campaign with its robot's arrays (reads Drake once)."""
    from ..robot.compensator import compensator_law
    from ..robot.rigid_plant import arrays

    arm = arrays(campaign.robot)
    return Problem(campaign.robot, arm, campaign, compensator_law(campaign.robot, arm))


problem = problem_of  # the shorter name, for scripts without a variable of that name
