"""A campaign: what the robot was told and what the instrument saw."""

from .data import Campaign, Target
from .joined import join
from .load import load_campaign
from .write import write_campaign

__all__ = ["Campaign", "Target", "join", "load_campaign", "write_campaign"]
