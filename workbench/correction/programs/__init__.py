"""Robot programs in the controllers' own formats. One file per format."""

from __future__ import annotations

from .base import Program
from .catalogue import find_format, formats
from .files import LEAST_MM, RoundingEffect, rounding_effect, write_program
from .format import Format
from .measuring import measuring_program
from .shown import as_shown, as_urdf
from .thin import thinned

__all__ = [
    "LEAST_MM",
    "Format",
    "Program",
    "RoundingEffect",
    "as_shown",
    "as_urdf",
    "find_format",
    "formats",
    "measuring_program",
    "rounding_effect",
    "thinned",
    "write_program",
]
