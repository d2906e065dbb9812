"""The closed loop in Drake: a simulated robot runs a path, commanded by what is believed of it."""

from .file import Verified, verify_file, write_verification
from .proof import verify
from .verification import Repeats, Series, Trial, Verification

__all__ = [
    "Repeats",
    "Series",
    "Trial",
    "Verification",
    "Verified",
    "verify",
    "verify_file",
    "write_verification",
]
