"""What a format keeps of the extended robot, what it leaves out, and what that costs at the tool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...correction.ripple import with_order
from ...effects.acting import Acting
from ...robot.kinematics import Array, frames
from ...robot.rotations import vectors
from .content import Content
from .hinges import off_by_hinges
from .kept import Kept

LEAST = 1e-7  # mm: below, it is rounding
HINGES = "that a bending link's end shifts and turns at once: hinges here, of second order in the bend"


@dataclass(frozen=True)
class Item:
    """One part of the model. mean_mm, max_mm: what the flange moves without it; None where it is carried."""

    what: str
    carried: bool
    mean_mm: float | None = None
    max_mm: float | None = None

    def __str__(self) -> str:
        if self.carried:
            return f"carried: {self.what}"
        return f"left out: {self.what} (moves the flange by {_far(self.mean_mm, self.max_mm)})"


@dataclass(frozen=True)
class Cost:
    """All parts of the model, and how far the flange of the exported robot is from it and turned against it,
    and that of the nominal one, rigid as it is. poses: in words."""

    items: tuple[Item, ...]
    mean_mm: float
    max_mm: float
    nominal_mean_mm: float
    nominal_max_mm: float
    turn_mean_mrad: float
    turn_max_mrad: float
    nominal_turn_mean_mrad: float
    nominal_turn_max_mrad: float
    poses: str
    notes: tuple[str, ...]

    def lines(self) -> list[str]:
        """For a file's header."""
        return [
            *(str(item) for item in self.items),
            f"flange against the whole model: {_far(self.mean_mm, self.max_mm)}, at {self.poses} "
            f"(of the nominal robot: {_far(self.nominal_mean_mm, self.nominal_max_mm)})",
            f"turned against it: {_turned(self.turn_mean_mrad, self.turn_max_mrad)} "
            f"(the nominal robot: {_turned(self.nominal_turn_mean_mrad, self.nominal_turn_max_mrad)})",
            *self.notes,
        ]


def cost(
    content: Content, kept: Kept, written: Content, approximated: tuple[Array, Array] | None = None
) -> Cost:
    """What a format leaves out that keeps `kept` and has the geometry of `written`.

    approximated: flange (N, 3) [m] and its rotation (N, 3, 3) in the poses of a format that only comes near
    that geometry.
    """
    law, acting = content.compensator, content.extended.acting
    whole, turn = content.flange(acting)
    items = [_geometry(content, written)]
    if content.problem.arm.compliance.any():
        without = content.flange(acting, rigid=True)[0]
        items.append(_item("springs of joints, bearings and links", kept.elastic, whole, without))
    if law is not None:
        exact = kept.law is not None and (kept.law is law or law.coil is not None)
        what = "compensator"
        if kept.law is not None and not exact:
            what = "compensator's difference from the nearest coil spring"
        without = content.flange(acting, pulled=False, by=None if exact else kept.law)[0]
        items.append(_item(what, exact, whole, without))
    for item, kind in zip(acting, content.kinds, strict=True):
        rest = Acting(tuple(other for other in acting if other is not item))
        there = any(item is one for one in kept.acting) and (kind != "compensator" or kept.law is not None)
        items.append(_item(with_order(item[0]), there, whole, content.flange(rest)[0]))
    place, turned = kept.flange(written) if approximated is None else approximated
    if kept.elastic and (off := off_by_hinges(written)) is not None:
        items.append(_item(HINGES, False, whole, whole + off))
        place = place + off
    arm = content.problem.arm
    nominal = frames(arm.with_geometry(np.zeros_like(arm.geometry)), content.problem.q)
    mean, most = _sizes(place - whole)
    plain_mean, plain_most = _sizes(nominal.p[-1] - whole)
    turn_mean, turn_most = _sizes(vectors(turned @ turn.transpose(0, 2, 1)))
    plain_turn_mean, plain_turn_most = _sizes(vectors(nominal.R[-1] @ turn.transpose(0, 2, 1)))
    return Cost(
        tuple(items),
        mean_mm=mean,
        max_mm=most,
        nominal_mean_mm=plain_mean,
        nominal_max_mm=plain_most,
        turn_mean_mrad=turn_mean,
        turn_max_mrad=turn_most,
        nominal_turn_mean_mrad=plain_turn_mean,
        nominal_turn_max_mrad=plain_turn_most,
        poses=content.poses,
        notes=content.extended.notes,
    )


def _geometry(content: Content, written: Content) -> Item:
    if written is not content:
        return Item("geometry, fitted to the whole model in these poses: it makes up for the rest", True)
    word = "calibrated" if content.arm.geometry.any() else "nominal (the model states no corrections)"
    return Item(f"geometry, {word}", True)


def _item(what: str, carried: bool, whole: Array, without: Array) -> Item:
    return Item(what, True) if carried else Item(what, False, *_sizes(without - whole))


def _sizes(off: Array) -> tuple[float, float]:
    """Mean and largest length of vectors (N, 3), in thousandths of their unit."""
    far = 1e3 * np.linalg.norm(off, axis=1)
    return float(far.mean()), float(far.max())


def _turned(mean: float, most: float) -> str:
    """Both [mrad] in words."""
    return f"{mean:.3f} mrad on average, {most:.3f} mrad at most"


def _far(mean: float | None, most: float | None) -> str:
    """Both [mm] in words; micrometres where they are few."""
    said = []
    for value in (mean or 0.0, most or 0.0):
        few = LEAST <= value < 1e-3
        said.append(f"{1e3 * value:.2g} µm" if few else f"{value:.3f} mm")
    return f"{said[0]} on average, {said[1]} at most"
