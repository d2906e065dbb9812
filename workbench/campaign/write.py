"""Write a campaign as `campaign.toml`, `poses.csv` and `points.csv`."""

from __future__ import annotations

from pathlib import Path

from .data import Campaign


def write_campaign(folder: Path, campaign: Campaign) -> Path:
    raise NotImplementedError
