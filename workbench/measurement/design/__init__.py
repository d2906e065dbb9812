"""The next measurements: records that make the model most accurate, or that discriminate between rivals."""

from .accuracy_plan import AccuracyPlan
from .decide import what_decides
from .discrimination_plan import DiscriminationPlan
from .fedorov import criterion, exchange
from .next_poses import follow_up, plan

__all__ = ["AccuracyPlan", "DiscriminationPlan", "criterion", "exchange", "follow_up", "plan", "what_decides"]
