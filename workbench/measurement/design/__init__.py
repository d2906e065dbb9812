"""The next measurements: records that make the model most accurate, or that tell rival causes apart."""

from .accuracy import AccuracyPlan
from .fedorov import criterion, exchange
from .next_poses import plan
from .tell import TellPlan

__all__ = ["AccuracyPlan", "TellPlan", "criterion", "exchange", "plan"]
