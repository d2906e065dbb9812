"""Campaigns of more poses than a fit needs, in two parts: one to fit, one to try the fit on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .data import Campaign

FEW = 0.1  # share of a part that the loads and repeats of one position may take to stay together


def parted(campaign: Campaign, most: int, seed: int = 0) -> tuple[Campaign, Campaign | None]:
    """Poses drawn at random, at most so many, in their order; and as many of the others, or None where that
    is all. The loads and repeats of a joint position stay together."""
    if len(campaign.poses) <= most:
        return campaign, None
    positions = campaign.poses.positions
    count = np.bincount(positions)
    if count.max() > FEW * most:
        positions, count = np.arange(len(positions)), np.ones(len(positions), np.int64)
    drawn = np.random.default_rng(seed).permutation(len(count))
    until = np.empty(len(count), np.int64)
    until[drawn] = np.cumsum(count[drawn])  # poses up to and with each position, in the order drawn
    part = np.ceil(until[positions] / most)
    own, other = np.flatnonzero(part == 1), np.flatnonzero(part == 2)
    rest = replace(campaign.some(other), title=f"{campaign.title} (poses that nothing was fitted on)")
    return campaign.some(own), rest
