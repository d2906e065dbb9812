"""Gear errors faster than the controller can follow: what is not commanded, and what that leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..effects.acting import Shares
from ..effects.base import Effect
from ..robot.kinematics import Array
from .extended_arm import ExtendedArm


@dataclass(frozen=True)
class LeftOut:
    """An effect that is not corrected in full, and what is left of it at the tool.

    spans: first and last sample of each stretch where some of it is left out.
    """

    effect: str
    highest_hz: float
    rms_mm: float
    max_mm: float
    spans: tuple[tuple[int, int], ...]

    def __str__(self) -> str:
        where = ", ".join(f"{a}" if a == b else f"{a}–{b}" for a, b in self.spans[:5])
        more = ", ..." if len(self.spans) > 5 else ""
        return (
            f"{self.effect}: up to {self.highest_hz:.0f} Hz, not commanded at samples {where}{more}; "
            f"leaves {self.rms_mm:.3g} mm RMS, {self.max_mm:.3g} mm at most"
        )


def speeds(q: Array, time: Array) -> Array:
    """(N, n) joint speeds [rad/s, m/s]."""
    return np.asarray(np.gradient(q, time, axis=0))


def frequency(order: float, speed: Array) -> Array:
    """(N,) [Hz] of a gear error with `order` cycles per joint turn, at joint speeds (N,) [rad/s]."""
    return np.asarray(order * np.abs(speed) / (2 * np.pi))


def followed(frequency_hz: Array, bandwidth_hz: float) -> Array:
    """(N,) share that is commanded: all up to the bandwidth, nothing above twice of it, smooth between."""
    over = np.clip(frequency_hz / bandwidth_hz - 1, 0.0, 1.0)
    return np.asarray(0.5 + 0.5 * np.cos(np.pi * over))


def ripple_shares(arm: ExtendedArm, speed: Array, bandwidth_hz: float) -> dict[int, Array]:
    """Shares (N,) of those effects with an order that the controller cannot follow everywhere."""
    shares = {}
    for i, (effect, _) in enumerate(arm.acting):
        if effect.where.order is not None and effect.where.joint in arm.arm.names:
            joint = arm.problem.joint(effect.where.joint)
            share = followed(frequency(effect.where.order, speed[:, joint]), bandwidth_hz)
            if (share < 1).any():
                shares[i] = share
    return shares


def left_out(arm: ExtendedArm, q: Array, speed: Array, shares: Shares, J: Array) -> tuple[LeftOut, ...]:
    """What the shares leave at the tool. J: (N, 3, n) [m per rad or m] of the tool's position."""
    found = []
    for i, share in shares.items():
        effect, values = arm.acting.items[i]
        joint = arm.problem.joint(effect.where.joint)
        motion = effect.motion(arm.at(q, np.zeros_like(q), slice(0, len(q))))
        angle = motion[int(arm.arm.axial[joint])] @ values
        error = 1e3 * np.linalg.norm(J[:, :, joint], axis=1) * np.abs((1 - share) * angle)
        found.append(
            LeftOut(
                with_order(effect),
                float(frequency(effect.where.order or 0.0, speed[:, joint]).max()),
                float(np.sqrt((error**2).mean())),
                float(error.max()),
                spans(share < 1),
            )
        )
    return tuple(found)


def with_order(effect: Effect) -> str:
    """What an effect is called, with its cycles per joint turn where it has any: a joint may have several."""
    order = effect.where.order
    return effect.label if order is None else f"{effect.label} of order {order:g}"


def spans(marked: np.ndarray) -> tuple[tuple[int, int], ...]:
    """First and last index of each run of marked samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8)))
    return tuple((int(a), int(b) - 1) for a, b in edges.reshape(-1, 2))
