"""A robot and its campaign together: what every effect is evaluated on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..robot.compensator import CompensatorLaw
from ..robot.description import Robot
from ..robot.hidden_geometry import hidden_corrections
from ..robot.kinematics import RX, RY, RZ, TX, TY, TZ, Arm, Array, Frames, frames
from ..robot.loads import Loads, Wrenches, wrenches
from . import Campaign
from .drives import Drive, drives_of

REFERENCE_TEMPERATURE = 20.0  # °C, at which the nominal robot holds
ON_BASE = 3  # fixed targets on the base that say where it is
BESIDE = 0.01  # m from the last axis, or from each other: targets that are nearer show no turn
ACROSS = (TX, TY, RX, RY)  # an axis


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
    def weights_known(self) -> bool:
        """Whether anything known bends the arm: the weights of its links, or loads that are not the same in
        all poses. One load that is always there looks like the weights that an arm without masses has too."""
        differ = (self.loads.mass[:, None], self.loads.moment, self.campaign.poses.wrench)
        return bool(
            self.arm.weighed
            or not self.arm.gravity.any()
            or any(np.ptp(each, axis=0).any() for each in differ if len(each))
        )

    @cached_property
    def stated_targets(self) -> Array:
        """Stated places of the targets (T, 3) [m] in the frames behind their slots; NaN = unknown."""
        places = [target.xyz or (np.nan,) * 3 for target in self.campaign.targets]
        return np.array(
            [self.arm.R_link[k] @ place for k, place in zip(self.on, np.array(places), strict=True)]
        )

    def stating(self, places: Mapping[int, Array]) -> Problem:
        """The same with other stated places (3,) [m] of some targets, by their numbers, in the frames behind
        their slots; NaN = unknown."""
        targets = list(self.campaign.targets)
        for i, place in places.items():
            x, y, z = (self.arm.R_link[self.on[i]].T @ place).tolist()
            targets[i] = replace(targets[i], xyz=(x, y, z) if np.isfinite(place).all() else None)
        return replace(self, campaign=replace(self.campaign, targets=tuple(targets)))

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
    def nominal_torque(self) -> Array:
        """(N, n) [N·m, N] what the drives of the rigid arm hold under the stated loads."""
        return self.arm.own(self.nominal_load.local)

    @cached_property
    def own_of_drives(self) -> list[Drive]:
        """What the joints' drives make of their own of the recorded torques."""
        return drives_of(self.campaign.poses, self.nominal_torque)

    @cached_property
    def hidden_corrections(self) -> frozenset[int]:
        """Columns of corrections that no measured point can show."""
        return hidden_corrections(self.arm)

    @cached_property
    def base_measured(self) -> bool:
        """Whether fixed targets on the base say where it is."""
        on_base = np.array([target.fixed for target in self.campaign.targets]) & (np.array(self.on) == 0)
        return int((self.seen.any(axis=0) & on_base).sum()) >= ON_BASE

    @property
    def corrections(self) -> tuple[int, ...]:
        """Columns 6 · slot + component of all corrections of the geometry: of the joints, then of the flange
        behind the last joint, across its axis; along and about that they are the joint's own."""
        flange = 6 * (self.arm.slots - 1)
        return (*range(6, flange), *(flange + component for component in ACROSS))

    @cached_property
    def flange_stays(self) -> frozenset[int]:
        """Columns of corrections by which the flange would stand otherwise on the last joint, unless fixed
        targets show it: others sit on it themselves wherever they are, and loads alone tell the two so
        faintly that a fit would move the flange at random. One place shows shifts, and none about an axis."""
        arm, last = self.arm, 6 * self.arm.n
        on_link, on_flange = self._fixed(arm.n), self._fixed(arm.slots - 1)
        stays = set[int]()
        if not len(on_link) + len(on_flange):
            stays.add(last + TZ)
        if not self.flange_measured:
            stays.add(last + RZ)
        across = self.corrections[-len(ACROSS) :]
        stays.update(across[4 if _apart(on_flange) > BESIDE else 2 if len(on_flange) else 0 :])
        return frozenset(stays)

    @cached_property
    def flange_measured(self) -> bool:
        """Whether fixed targets say how the flange stands about the last axis: one beside it on the last
        link, or two on the flange, which may itself stand beside the axis."""
        on_link, on_flange = self._fixed(self.arm.n), self._fixed(self.arm.slots - 1)
        beside = np.linalg.norm(on_link[:, :2], axis=1).max(initial=0.0)
        return bool(max(beside, _apart(on_flange[:, :2])) > BESIDE)

    def _fixed(self, slot: int) -> Array:
        """(F, 3) [m] nominal places on the last joint's axes of the fixed targets behind a slot that were
        seen; z along the axis."""
        arm = self.arm
        places = [
            arm.R_link[slot] @ np.array(target.xyz)
            for i, target in enumerate(self.campaign.targets)
            if target.fixed and self.on[i] == slot and self.seen[:, i].any()
        ]
        own = np.array(places).reshape(-1, 3)
        return own if slot == arm.n else own @ arm.R[-1].T + arm.p[-1]

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


def _apart(places: Array) -> float:
    """[m] how far the farthest of places (F, k) is from the first."""
    return float(np.linalg.norm(places - places[:1], axis=1).max(initial=0.0))


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
