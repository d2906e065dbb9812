"""Figures of a tool path: errors, R_a and R_z, ISO 9283's AT and RT, and the lines that are left in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import find_peaks

from ...robot.kinematics import Array
from .motion import interpolated

LEAST_SHARE = 0.3  # of what is left near a line, that a gear has to explain to be named
LEAST_CYCLES = 3.0  # of a gear along the path
MOST_LINES = 5


@dataclass(frozen=True)
class Figures:
    """Of one run, in mm. mean … largest: 3-D distance of the tool from where it should be at that instant.
    across_*: its distance from the path, whenever it passes (ISO 9283's AT of a single run is the largest).
    ra, rz: R_a and R_z of Olabi et al. (2012), of the error normal to the path's plane along the whole of it,
    nothing filtered (P_a and P_z of ISO 4287): mean of |z − z̄|, and highest peak minus deepest valley;
    offset: |z̄|, a height, no roughness."""

    mean_mm: float
    rms_mm: float
    p95_mm: float
    max_mm: float
    across_rms_mm: float
    across_max_mm: float
    ra_mm: float
    rz_mm: float
    offset_mm: float


@dataclass(frozen=True)
class Line:
    """One line of the error's spectrum; `cause`: the gear order that runs at this frequency, "" if none."""

    frequency_hz: float
    amplitude_mm: float
    cause: str


def figures(error: Array, across: Array, z: Array, time: Array) -> Figures:
    """From errors (N, 3), their part across the path (N, 3), and along the normal (N,) [m]; samples count by
    the time (N,) [s] of the path that each stands for."""
    size, beside = 1e3 * np.linalg.norm(error, axis=1), 1e3 * np.linalg.norm(across, axis=1)
    share = shares(time)
    height = float(share @ z)
    return Figures(
        float(share @ size),
        float(np.sqrt(share @ size**2)),
        float(np.quantile(size, 0.95, weights=share, method="inverted_cdf")),
        float(size.max()),
        float(np.sqrt(share @ beside**2)),
        float(beside.max()),
        float(1e3 * share @ np.abs(z - height)),
        float(1e3 * np.ptp(z)),
        1e3 * abs(height),
    )


def shares(time: Array) -> Array:
    """(N,) share of the path's time (N,) [s] that each sample stands for."""
    share = np.gradient(time)
    return np.asarray(share / share.sum())


def tangents(p: Array) -> Array:
    """(N, 3) unit tangents of a path p (N, 3); zero where it stands."""
    way = np.gradient(p, axis=0)
    length = np.linalg.norm(way, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-9, way / np.maximum(length, 1e-12), 0.0))


def beside(error: Array, tangent: Array) -> Array:
    """(N, 3) part of the errors across the path."""
    return error - np.einsum("ni,ni->n", error, tangent)[:, None] * tangent


def normal(p: Array) -> Array:
    """(3,) unit normal of the plane that a path lies in; the vertical where it lies in none, or on a line."""
    _, s, V = np.linalg.svd(p - p.mean(axis=0), full_matrices=False)
    flat = s[1] > 1e-3 * s[0] and s[2] < 1e-3 * s[1]
    n = V[2] if flat else np.array([0.0, 0.0, 1.0])
    n = n * np.sign(n[np.argmax(np.abs(n))])
    return np.asarray(np.where(np.abs(n) < 1e-9, 0.0, n))


def path_accuracy(runs: Sequence[Array]) -> tuple[float, float]:
    """ISO 9283 AT and RT [mm] of repeated runs, each the errors across the path (N, 3) [m].

    AT: largest distance of the runs' barycentre from the path. RT: largest l̄ + 3 S of the distances from
    the barycentre.
    """
    every = 1e3 * np.stack(runs)
    centre = every.mean(axis=0)
    away = np.linalg.norm(every - centre, axis=2)
    spread = away.std(axis=0, ddof=1) if len(every) > 1 else np.zeros(len(centre))
    return float(np.linalg.norm(centre, axis=1).max()), float((away.mean(axis=0) + 3 * spread).max())


def spectrum(time: Array, error: Array) -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitudes [mm] of an error (N, 3) [m] at times (N,) [s], slow trend taken out."""
    count = min(len(time), 8192)
    t = np.linspace(time[0], time[-1], count)
    even = interpolated(t, time, error)
    u = np.linspace(-1, 1, count)
    trend = np.polynomial.polynomial.polyfit(u, even, min(3, count - 1))
    even -= np.polynomial.polynomial.polyval(u, trend).T
    window = np.hanning(count)
    lines = np.abs(np.fft.rfft(even * window[:, None], axis=0)) * 2 / window.sum()
    rate = (count - 1) / max(float(t[-1] - t[0]), 1e-9)
    return np.asarray(np.fft.rfftfreq(count, 1 / rate), float), 1e3 * np.linalg.norm(lines, axis=1)


def main_lines(
    time: Array, error: Array, q: Array, orders: Sequence[tuple[str, int, float]]
) -> tuple[Line, ...]:
    """The highest lines of the error's spectrum. orders: (name, joint, cycles per joint turn) of known gears.

    A line is laid to a gear when the gear runs at that frequency and its sine takes most of the line away.
    """
    frequency, amplitude = spectrum(time, error)
    peaks = find_peaks(amplitude)[0]
    peaks = peaks[frequency[peaks] * (time[-1] - time[0]) > 3.5]
    chosen = peaks[np.argsort(-amplitude[peaks])][:MOST_LINES]
    found = []
    for k in chosen:
        if amplitude[k] > 0.02 * amplitude[chosen[0]]:
            cause = _cause(float(frequency[k]), time, error, q, orders)
            found.append(Line(float(frequency[k]), float(amplitude[k]), cause))
    return tuple(found)


def _cause(
    frequency: float, time: Array, error: Array, q: Array, orders: Sequence[tuple[str, int, float]]
) -> str:
    """The gear order that explains most of the error between half and twice the frequency."""
    t = np.linspace(time[0], time[-1], 8192)
    wanted = _band(t, interpolated(t, time, error), frequency)
    best, share = "", LEAST_SHARE
    for name, joint, order in orders:
        angle = order * np.interp(t, time, q[:, joint])
        cycles = np.abs(np.gradient(angle, t)) / (2 * np.pi)
        if np.ptp(angle) < 2 * np.pi * LEAST_CYCLES or not 0.5 * frequency < cycles.max():
            continue
        waves = _band(t, np.stack([np.sin(angle), np.cos(angle)], axis=1), frequency)
        fit = waves @ np.linalg.lstsq(waves, wanted, rcond=None)[0]
        explained = float((fit**2).sum() / max((wanted**2).sum(), 1e-300))
        if explained > share:
            best, share = name, explained
    return best


def _band(t: Array, values: Array, frequency: float) -> Array:
    """Values (K, m) between half and twice a frequency."""
    f = np.fft.rfftfreq(len(t), float(t[1] - t[0]))
    lines = np.fft.rfft(values - values.mean(axis=0), axis=0)
    lines[(f < 0.5 * frequency) | (f > 2 * frequency)] = 0.0
    return np.fft.irfft(lines, len(t), axis=0)
