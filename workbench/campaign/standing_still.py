"""Targets that stand still while the arm moves, though nobody said that they are on the base."""

from __future__ import annotations

import numpy as np

from ..files.toml import toml_key
from .data import Campaign

STILL = 0.01  # of what another target moves by


def stands_still(campaign: Campaign, target: int) -> str:
    """How to mend it where a target that is not said to be on the base keeps its place from wherever the
    instrument sees it, and others do not; else nothing."""
    c = campaign
    points = np.ma.masked_invalid(c.points)
    spreads = [points[c.poses.setup == one].std(axis=0) for one in range(len(c.setup_names))]
    moved = np.max([np.linalg.norm(spread.filled(0.0), axis=1) for spread in spreads], axis=0)
    if c.targets[target].on == "base" or moved[target] >= STILL * moved.max():
        return ""
    name = c.targets[target].name
    return f'say on = "base" under [targets.{toml_key(name)}], or leave {name} out'
