"""Campaigns of more poses than a fit needs, in two parts: one to fit, one to try the fit on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .data import Campaign, IntArray

FEW = 0.1  # share of a part that the loads and repeats of one position may take to stay together
GOLDEN = (5**0.5 - 1) / 2  # its multiples fill the unit interval evenly


def parted(campaign: Campaign, most: int) -> tuple[Campaign, Campaign | None]:
    """Poses drawn at random, at most so many, in their order; and as many of the others, or None where that
    is all. The loads and repeats of a joint position stay together; a pose more or less leaves nearly all
    others in their parts."""
    poses = campaign.poses
    if len(poses) <= most:
        return campaign, None
    positions, drawn = poses.positions, poses.drawn(0)
    if np.bincount(positions).max() > FEW * most:
        drawn = np.mod(drawn + GOLDEN * _repeat(positions), 1.0)
        positions = np.arange(len(positions))
    _, first, count = np.unique(positions, return_index=True, return_counts=True)
    order = np.argsort(drawn[first], kind="stable")
    until = np.empty(len(count), np.int64)
    until[order] = np.cumsum(count[order])  # poses up to and with each position, in the order drawn
    part = np.ceil(until[positions] / most)
    own, other = np.flatnonzero(part == 1), np.flatnonzero(part == 2)
    rest = replace(campaign.some(other), title=f"{campaign.title} (poses that nothing was fitted on)")
    return campaign.some(own), rest


def _repeat(positions: IntArray) -> IntArray:
    """(N,) how many poses before it have the position of each."""
    order = np.argsort(positions, kind="stable")
    count = np.bincount(positions)
    before = np.empty(len(positions), np.int64)
    before[order] = np.arange(len(positions)) - np.repeat(np.cumsum(count) - count, count)
    return before
