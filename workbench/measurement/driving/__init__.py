"""A plan that can be driven: poses that are free, seen and reached, in an order that takes little time."""

from .drive import Drive, drive
from .reach import Reach, reach

__all__ = ["Drive", "Reach", "drive", "reach"]
