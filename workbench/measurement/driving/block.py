"""A drive in its blocks: stops with one load, one pull, the arm as warm; and what is done before each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.cell import DrivingData
from ...campaign.problem import REFERENCE_TEMPERATURE
from ...robot.description import Robot
from ...robot.kinematics import Array

Work = Literal["mounting", "rigging", "warming", "cooling", "waiting"]
WORDS: dict[Work, str] = {
    "mounting": "changing the load",
    "rigging": "rigging the pull",
    "warming": "working the arm warm",
    "cooling": "letting the arm cool",
    "waiting": "waiting for the next session",
}


@dataclass(frozen=True)
class State:
    """What a stop is measured with. payload: its name ("": none); wrench: (fx, fy, fz, mx, my, mz) [N, N·m]
    on the flange, in the base frame; temperature: [°C] of the arm, None where it does not matter."""

    payload: str
    wrench: tuple[float, ...]
    temperature: float | None

    @property
    def load(self) -> str:
        return self.payload or "none"

    @property
    def pull(self) -> str:
        """How hard, and where to; empty where nothing pulls."""
        force, moment = np.array(self.wrench[:3]), np.array(self.wrench[3:])
        parts = []
        for values, unit in ((force, "N"), (moment, "Nm")):
            if values.any():
                parts.append(f"{np.linalg.norm(values):.4g} {unit} {_along(values)}")
        return ", ".join(parts)

    @property
    def warmth(self) -> str:
        """How warm the arm is to be; empty where it does not matter."""
        if self.temperature is None:
            return ""
        word = "warm" if self.temperature > REFERENCE_TEMPERATURE else "cold"
        return f"{word}, about {self.temperature:g} °C"

    @property
    def lines(self) -> list[str]:
        """For the comments of a program, short as a controller's remarks are, without special signs."""
        parts = [("load", self.load), ("pull", self.pull), ("arm", self.warmth)]
        return [f"{name}: {words.replace('°C', 'degC')}" for name, words in parts if words]


@dataclass(frozen=True)
class Block:
    """Stops start..stop − 1 of one session and in one state; name: for files; before: what takes how long [s]
    before it."""

    name: str
    state: State
    start: int
    stop: int
    before: tuple[tuple[Work, float], ...] = ()

    @property
    def preparing(self) -> str:
        """What has to be done before it."""
        return ", ".join(f"{seconds / 60:.0f} min {WORDS[work]}" for work, seconds in self.before)

    def to_json(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "standstills": self.stop - self.start,
            "payload": self.state.payload,
            "wrench": list(self.state.wrench),
            "temp_degC": self.state.temperature,
            "before_minutes": {work: seconds / 60 for work, seconds in self.before},
        }


@dataclass(frozen=True, eq=False)
class Drive:
    """What is driven, in order. M standstills, those of the plan and returns to the check pose.

    plan: (N) the plan's own records in the order of the drive, at the times that the plan said; records: (M)
    those and the returns, with their sides and the times of the drive; check: (M,) which are returns; via:
    for each the poses (n,) on the way to it, before its approach; seconds: of motion and standstills, in all;
    still_s: of one standstill, in which all targets of the plan are measured; detours: how
    many ways were gone round; torque, warmth: the torques of the drives, or how warm the arm is, are to be
    recorded too.
    """

    plan: Campaign
    records: Campaign
    check: NDArray[np.bool_]
    via: tuple[tuple[Array, ...], ...]
    blocks: tuple[Block, ...]
    moving_s: float
    standing_s: float
    still_s: float
    detours: int
    torque: bool = False
    warmth: bool = False

    @property
    def own(self) -> Campaign:
        """(N) the plan's own records at the times of the drive."""
        return self.records.some(np.flatnonzero(~self.check))

    @property
    def between_s(self) -> dict[Work, float]:
        """[s] of each kind of work between the blocks."""
        out: dict[Work, float] = {}
        for work, seconds in (one for block in self.blocks for one in block.before):
            out[work] = out.get(work, 0.0) + seconds
        return out

    @property
    def pauses_s(self) -> float:
        """[s] between the blocks, in all."""
        return sum(self.between_s.values())

    @property
    def total_s(self) -> float:
        return self.moving_s + self.standing_s + self.pauses_s

    def to_json(self) -> dict[str, Any]:
        return {
            "minutes": self.total_s / 60,
            "moving_minutes": self.moving_s / 60,
            "standing_minutes": self.standing_s / 60,
            **{f"{work}_minutes": self.between_s.get(work, 0.0) / 60 for work in WORDS},
            "standstill_s": self.still_s,
            "targets": self.targets,
            "record_torque": self.torque,
            "record_temperature": self.warmth,
            "check_poses": int(self.check.sum()),
            "detours": self.detours,
            "blocks": [
                block.to_json() | {"begins_minute": self.begins_s(block) / 60} for block in self.blocks
            ],
        }

    def begins_s(self, block: Block) -> float:
        """[s] from the start of the drive to a block's first standstill."""
        assert self.records.poses.time is not None
        return float(self.records.poses.time[block.start])

    @property
    def targets(self) -> list[str]:
        """Names of what is measured at every standstill."""
        return [target.name for target in self.plan.targets]

    @property
    def measured(self) -> str:
        """What is measured at every standstill, in words."""
        also = [f"the torque of each drive ({torque_columns(self.plan.robot)})"] if self.torque else []
        also += ["how warm the arm is (temp_degC)"] if self.warmth else []
        said = f"At every standstill, {self.still_s:g} s, measure {', '.join(self.targets)}"
        return f"{said} and record {' and '.join(also)} in poses.csv." if also else f"{said}."

    @property
    def spent(self) -> str:
        """On what the time goes."""
        parts = [f"{self.moving_s / 60:.0f} min moving", f"{self.standing_s / 60:.0f} min standing still"]
        parts += [f"{seconds / 60:.0f} min {WORDS[work]}" for work, seconds in self.between_s.items()]
        return ", ".join(parts)

    @property
    def plainly(self) -> bool:
        """Whether there is one block, with nothing that has to be mounted or waited for."""
        return len(self.blocks) == 1 and self.blocks[0].state.lines == ["load: none"]

    @property
    def lines(self) -> list[str]:
        """How long it takes, and what is done at every stop."""
        lines = [f"About {self.total_s / 60:.0f} min: {self.spent}.", self.measured]
        if self.check.any():
            lines.append(
                f"It returns {int(self.check.sum())} times to a check pose, which shows warming up and drift."
            )
        if self.detours:
            lines.append(f"{self.detours} of {len(self.check)} ways go round what is in the way.")
        return lines

    @property
    def block_lines(self) -> list[str]:
        """What is mounted, rigged and waited for, block by block; nothing where that is nothing."""
        if self.plainly:
            return []
        out = []
        for number, block in enumerate(self.blocks, 1):
            first = f"first {block.preparing}; " if block.before else ""
            out.append(
                f"Block {number}, from minute {self.begins_s(block) / 60:.0f}: {first}"
                f"{block.stop - block.start} standstills; {'; '.join(block.state.lines)}."
            )
        return out

    @property
    def text(self) -> str:
        """How it is driven."""
        return "\n".join([*self.lines, *self.block_lines])


def torque_columns(robot: Robot) -> str:
    """The columns of `poses.csv` that take the torques of the drives."""
    return ", ".join(
        f"tau{index}_{'N' if joint.kind == 'prismatic' else 'Nm'}"
        for index, joint in enumerate(robot.joints, 1)
    )


def state_of(records: Campaign, row: int) -> State:
    """That of one record."""
    poses = records.poses
    warmth = None if poses.temperature is None else float(poses.temperature[row])
    return State(
        records.payload_names[poses.payload[row]], tuple(float(v) for v in poses.wrench[row]), warmth
    )


def work_between(
    now: State, then: State, driving: DrivingData, until_session: float
) -> tuple[tuple[Work, float], ...]:
    """What is done between two blocks, and how long each takes [s]. until_session: [s] until the session of
    the second begins; what is mounted meanwhile takes no time of its own."""
    found: dict[Work, float] = {
        "mounting": 60 * driving.load_change_min if now.payload != then.payload else 0.0,
        "rigging": 60 * driving.pull_min if now.wrench != then.wrench else 0.0,
    }
    rise = (then.temperature or 0.0) - (now.temperature or 0.0)
    work: Work = "warming" if rise > 0 else "cooling" if rise < 0 else "waiting"
    found[work] = max(0.0, until_session - sum(found.values()))
    return tuple((work, seconds) for work, seconds in found.items() if seconds)


def _along(values: Array) -> str:
    """The direction of a force or moment: the base's axis, or its parts."""
    axes = np.flatnonzero(values)
    if len(axes) == 1:
        return f"along {'+' if values[axes[0]] > 0 else '-'}{'xyz'[axes[0]]} of base"
    return f"({', '.join(f'{v:.4g}' for v in values)}) in base"
