"""Units that a column may be in, and what each is in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Unit:
    """SI value = factor · value in the file + offset."""

    dimension: str
    factor: float
    offset: float = 0.0


NO_UNIT = Unit("", 1.0)
CLOCK = Unit("time", 1.0, 0.0)  # a time of day, with the date or without
UNITS = {
    "mm": Unit("length", 1e-3),
    "m": Unit("length", 1.0),
    "um": Unit("length", 1e-6),
    "cm": Unit("length", 1e-2),
    "in": Unit("length", 0.0254),
    "deg": Unit("angle", math.pi / 180.0),
    "rad": Unit("angle", 1.0),
    "mrad": Unit("angle", 1e-3),
    "N": Unit("force", 1.0),
    "kN": Unit("force", 1e3),
    "daN": Unit("force", 10.0),
    "kgf": Unit("force", 9.80665),
    "lbf": Unit("force", 4.4482216152605),
    "Nm": Unit("torque", 1.0),
    "kNm": Unit("torque", 1e3),
    "Nmm": Unit("torque", 1e-3),
    "s": Unit("time", 1.0),
    "ms": Unit("time", 1e-3),
    "min": Unit("time", 60.0),
    "h": Unit("time", 3600.0),
    "clock": CLOCK,
    "degC": Unit("temperature", 1.0),
    "K": Unit("temperature", 1.0, -273.15),
}
# What messages propose; the other units are understood as well.
USUAL = {
    "length": ("mm", "m"),
    "angle": ("deg", "rad"),
    "force": ("N",),
    "torque": ("Nm",),
    "time": ("s",),
    "temperature": ("degC",),
}
