"""The next measurements: records that make the model most accurate, or that tell rival causes apart."""

from .accuracy import AccuracyPlan
from .command import plan
from .fedorov import criterion, exchange
from .tell import TellPlan

__all__ = ["AccuracyPlan", "TellPlan", "criterion", "exchange", "plan"]
