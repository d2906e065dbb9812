"""`[prediction]` of a model.toml: how sure the model is of the tool's place, and what was measured."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, FiniteFloat, ValidationInfo, field_validator

from ..files.section import Section

DIGITS = 6
ON_A_LINE = 12
LEAST = 20  # held-out points that can be said to hold in 95 %
Numbers = tuple[FiniteFloat, ...]
Place = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class Turning(Section):
    """In a model.toml: what bounds of the tool's turns have where it was measured as a pose, as those of its
    points in `prediction`."""

    rest: float = Field(ge=0)
    """rad, one sigma about each axis of what is left unknown"""
    tempering: float = Field(gt=0)
    """factor on the bounds, so that 95 % of held-out turns lie inside"""
    growth: float = Field(ge=0)
    """1/rad (3 m⁻¹ of a sliding joint): the bound's growth outside of the measured range"""


class ToolPoint(Section):
    """A target on the flange: where the errors are predicted."""

    name: str
    """as the campaign calls it"""
    xyz_mm: Place
    """in the flange's frame, as the corrected model has it"""
    nominal_xyz_mm: Place
    """where it is best taken to be with the nominal robot"""


class Uncertainty(Section):
    """In a model.toml: covariance of the fitted numbers, and bounds that held on poses held out."""

    points: tuple[ToolPoint, ...] = Field(min_length=1)
    """the targets on the flange"""
    campaign: str = ""
    """of several campaigns that were fitted together the one whose tool that is: the last"""
    nominal_base: Numbers = Field(min_length=6, max_length=6)
    """best base of the nominal robot in that of the corrected one: shift [m] and rotation vector [rad]"""
    base_measured: bool = True
    """fixed targets on the base said where it is; else it is where axis 1 stands in it as the model says"""
    flange_measured: bool = True
    """fixed targets said how the flange stands about the last axis; else nobody knows, since targets that are
    fitted go along with it"""
    turn_measured: bool = True
    """false: the points lie on one line or in one place, how the base stands turned about it in the
    instrument's frame nobody knows, and it is not in the bounds"""
    names: tuple[str, ...]
    """the fitted numbers"""
    factor: tuple[str, ...]
    """covariance = F Fᵀ, SI units: numbers of F, row after row, a row for each name"""
    rest: float = Field(ge=0)
    """m, one sigma per axis of what is left unknown"""
    repeatability: Numbers
    """rad or m by joint, one sigma"""
    tempering: float = Field(gt=0)
    """factor on the bounds, so that 95 % of held-out errors lie inside"""
    growth: float = Field(ge=0)
    """1/rad (3 m⁻¹ of a sliding joint): the bound's growth outside of the measured range"""
    turning: Turning | None = None
    """of the tool's turns; left out: it was not measured as a pose"""
    lower: Numbers
    """rad or m by joint: least measured angle"""
    upper: Numbers
    """rad or m by joint: largest measured angle"""
    farthest: float = Field(ge=0)
    """m: largest standard deviation at a measured pose that comes from the fitted numbers"""
    instrument_inside: bool
    """nobody knows the instrument's noise: it is in the bounds as well"""
    flange_load: Numbers = Field(default=(), min_length=0, max_length=3)
    """N, N, N·m: least and largest force, and largest moment, on the flange while it was measured"""
    temperature_degC: Numbers = Field(default=(), min_length=0, max_length=2)
    """least and largest temperature at which it was measured; left out: it was not recorded"""
    time_s: Numbers = Field(default=(), min_length=0, max_length=2)
    """first and last `t_s` at which it was measured; left out: it was not recorded"""
    measured_mm: tuple[str, ...] = ()
    """where the points' mean was measured, in the nominal robot's base: a place on each line, some of them"""

    @field_validator("temperature_degC", "time_s")
    @classmethod
    def _ends(cls, ends: Numbers) -> Numbers:
        if len(ends) == 1 or list(ends) != sorted(ends):
            raise ValueError("is not a least and a largest")
        return ends

    @field_validator("measured_mm")
    @classmethod
    def _places(cls, lines: tuple[str, ...]) -> tuple[str, ...]:
        numbers = [line.split() for line in lines]
        if any(len(one) != 3 for one in numbers) or not np.isfinite(np.array(numbers, dtype=float)).all():
            raise ValueError("has lines that are not three finite numbers")
        return lines

    @field_validator("factor")
    @classmethod
    def _whole(cls, lines: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        numbers, names = " ".join(lines).split(), info.data.get("names", ())
        if not names or not numbers or len(numbers) % len(names):
            raise ValueError(f"has {len(numbers)} numbers, for {len(names)} names")
        if not np.isfinite(np.array(numbers, dtype=np.float64)).all():
            raise ValueError("has numbers that are not finite")
        return lines

    @cached_property
    def F(self) -> NDArray[np.float64]:
        """(P, k) square root of the covariance of the P numbers `names`."""
        numbers = np.array(" ".join(self.factor).split(), dtype=np.float64)
        return numbers.reshape(len(self.names), -1)

    @cached_property
    def measured(self) -> NDArray[np.float64]:
        """(M, 3) [m] places where the tool was measured."""
        return 1e-3 * np.array(" ".join(self.measured_mm).split(), dtype=np.float64).reshape(-1, 3)


def factor_lines(F: NDArray[np.float64]) -> tuple[str, ...]:
    """A square root (P, k) of a covariance as `Uncertainty` keeps it."""
    rows = [[f"{value:.{DIGITS}g}" for value in row] for row in F.tolist()]
    return tuple(" ".join(row[i : i + ON_A_LINE]) for row in rows for i in range(0, len(row), ON_A_LINE))
