"""How warm, and when, a robot was measured, and how far from that other poses are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array
from .problem import REFERENCE_TEMPERATURE, Problem

MARGIN = 0.1  # of what was measured
LIGHT = 0.5  # K: no less counts, thermometers differ by as much


def temperatures(problem: Problem) -> tuple[float, ...]:
    """Least and largest temperature [°C] of a campaign; empty where none was recorded."""
    return () if problem.warmth is None else _ends(problem.warmth + REFERENCE_TEMPERATURE)


def times(problem: Problem) -> tuple[float, ...]:
    """First and last instant [s] of a campaign; empty where none was recorded."""
    return () if problem.time is None else _ends(problem.time)


def kelvin_beyond(problem: Problem, measured: Sequence[float], reference: bool) -> Array:
    """(N,) [K] how much warmer than any of the `temperatures` measured poses are, or colder (below zero).
    reference: whether poses that do not say it are taken as at 20 °C; else it is 0, as where nothing was."""
    none = np.zeros(len(problem.q))
    if not measured or (problem.warmth is None and not reference):
        return none
    return _beyond((none if problem.warmth is None else problem.warmth) + REFERENCE_TEMPERATURE, measured)


def beyond_temperature(kelvin: Array, measured: Sequence[float]) -> NDArray[np.bool_]:
    """(N,) which of poses that are `kelvin_beyond` are by so much that it counts."""
    return np.asarray(np.abs(kelvin) > max(LIGHT, MARGIN * float(np.ptp(measured or 0.0))))


def beyond_time(problem: Problem, measured: Sequence[float]) -> NDArray[np.bool_]:
    """(N,) which poses are before or after the `times` measured; none where either does not say."""
    if not measured or problem.time is None:
        return np.zeros(len(problem.q), dtype=bool)
    return np.asarray(np.abs(_beyond(problem.time, measured)) > MARGIN * np.ptp(measured))


def _ends(values: Array) -> tuple[float, ...]:
    return float(values.min()), float(values.max())


def _beyond(values: Array, measured: Sequence[float]) -> Array:
    least, most = measured
    return np.asarray(values - np.clip(values, least, most))
