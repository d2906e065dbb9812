"""The closed loop in Drake: the true robot runs a path, commanded by what is believed of it."""

from .control import Controller
from .verification import Repeats, Series, Trial, Verification
from .verify import verify

__all__ = ["Controller", "Repeats", "Series", "Trial", "Verification", "verify"]
