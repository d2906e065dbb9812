"""Make one campaign of several of the same robot."""

from __future__ import annotations

from collections.abc import Sequence

from .data import Campaign


def join(campaigns: Sequence[Campaign]) -> Campaign:
    """One campaign of several."""
    if len(campaigns) == 1:
        return campaigns[0]
    raise NotImplementedError
