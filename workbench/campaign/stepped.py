"""A set-up whose frame or tool steps in the course of a campaign: in two, and together again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .data import Campaign, IntArray, after


def split_campaign(c: Campaign, first: int, k: int = 0) -> Campaign:
    """The campaign with the poses of its set-up k from `first` on in one of their own, which is the next."""
    setup: IntArray = c.poses.setup.copy()
    own = np.flatnonzero(setup == k)
    last = c.poses.ids[own[own < first][-1]]
    setup[setup > k] += 1
    setup[own[own >= first]] = k + 1
    names = *c.setup_names[: k + 1], f"{after(c.setup_names[k])}{last}", *c.setup_names[k + 1 :]
    return replace(c.with_poses(setup=setup), setup_names=names)


def was_split(name: str, names: Sequence[str]) -> bool:
    """Whether a set-up of this name is one of two parts among these names: which one another campaign means
    by it cannot be known."""
    return any(other.startswith(after(name)) for other in names)


def together(c: Campaign) -> Campaign:
    """The campaign with the set-ups that were split in one again; itself where none was."""
    names = c.setup_names
    whole = [
        next((j for j, other in enumerate(names[:i]) if name.startswith(after(other))), i)
        for i, name in enumerate(names)
    ]
    kept = sorted(set(whole))
    if len(kept) == len(whole):
        return c
    setup = np.array([kept.index(k) for k in whole])[c.poses.setup]
    return replace(c.with_poses(setup=setup), setup_names=tuple(names[k] for k in kept))
