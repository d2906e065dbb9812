"""a sin x + b cos x: fitted as two numbers, told as amplitude and phase."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..robot.kinematics import Array
from .kinds import TransmissionEffect

SIN_COS = ("amplitude", "phase", "sin", "cos")


def sin_cos(numbers: Mapping[str, float]) -> Array:
    """(a, b) of  a sin x + b cos x  from numbers by name: sin and cos, or amplitude and phase."""
    amplitude, phase = numbers.get("amplitude", 0.0), numbers.get("phase", 0.0)
    a, b = amplitude * np.cos(phase), amplitude * np.sin(phase)
    return np.array([numbers.get("sin", a), numbers.get("cos", b)])


def amplitude_phase(values: Array, covariance: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """(amplitude, std) and (phase, std) of  a sin x + b cos x = A sin(x + φ), from (a, b)."""
    a, b = values
    amplitude = float(np.hypot(a, b))
    if amplitude == 0:
        return (0.0, float(np.sqrt(covariance.trace() / 2))), (0.0, np.pi)
    along = np.array([a, b]) / amplitude
    across = np.array([-b, a]) / amplitude**2
    std = float(np.sqrt(along @ covariance @ along)), float(np.sqrt(across @ covariance @ across))
    return (amplitude, std[0]), (float(np.arctan2(b, a)), std[1])


@dataclass(frozen=True)
class Harmonic(TransmissionEffect):
    """Δq = a sin(k q) + b cos(k q): k `cycles` per joint turn, of a sliding joint per 2π m."""

    @property
    def form(self) -> str:
        return f"{self.cycles:g} {'cycle' if self.cycles == 1 else 'cycles'} per turn"

    @property
    @abstractmethod
    def cycles(self) -> float: ...

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        angle = self.cycles * q[:, joints.index(str(self.where.joint))]
        return np.stack([np.sin(angle), np.cos(angle)], axis=1)

    @property
    def names(self) -> tuple[str, ...]:
        return SIN_COS

    def given(self, numbers: Mapping[str, float]) -> Array:
        return sin_cos(numbers)
