"""What is wrong with the data themselves: a campaign that was written down otherwise than it was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ..campaign import Campaign

DataFault = Literal[  # what a diagnosis finds wrong with the data themselves
    "changed_load", "changed_scale", "changed_setup", "copied_pose", "frozen_target", "moved_instrument",
    "moved_zero", "outlier", "rare_setup", "rare_target", "rounded_joints", "shifted_pose", "swapped_target",
    "wrong_payload", "wrong_wrench",
]  # fmt: skip


@dataclass(frozen=True)
class Recorded:
    """A campaign as it was. said: of set-ups that were written down otherwise, by their numbers, what is
    otherwise there; done: what was done about it."""

    kind: DataFault
    campaign: Campaign
    said: Sequence[tuple[int, str]]
    done: str
