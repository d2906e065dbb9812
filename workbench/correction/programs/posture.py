"""Which of its postures a six-axis arm stands in: what the makers' files say of a pose beside its numbers.

FANUC's CONFIG and ABB's confdata are written and read, KUKA's S and T and Stäubli's configuration are read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...robot.convention import Convention
from ...robot.description import Robot
from ...robot.kinematics import Array, frames
from ...robot.rigid_plant import arrays

FULL = 2 * np.pi
AT_CHANGE = 1e-9  # an angle of zero counts as positive, rounding aside
SAME_AS_BEFORE = "the posture before, which the controller keeps where none is said"
NEAR = 0.01  # rad: so near to where a sign or a quadrant changes, an angle counts to both sides


Flags = tuple[bool | None, bool | None, bool | None]
Kept = tuple[bool, bool, bool]


@dataclass(frozen=True)
class Posture:
    """What a file says of the posture at a pose.

    said: as it stands there. flags: those of `posture`, None where it does not say. between: of a joint (0 to
    5, as the controller counts them) the angles [rad] between which the controller shows it. obeyed: whether
    the controller takes the arm there (RAPID's ConfJ and ConfL may switch that off). kept: flags that the
    controller leaves as they were before, where they do not say themselves.
    """

    said: str
    flags: Flags = (None, None, None)
    between: tuple[tuple[int, float, float], ...] = ()
    obeyed: bool = True
    kept: Kept = (False, False, False)

    @property
    def says(self) -> bool:
        """Whether it says anything without the posture before."""
        return bool(self.said)

    def after(self, margins: Array) -> Posture:
        """The same with the flags that are kept, of the joints before with these margins (3,)."""
        flags = [
            bool(margin >= -AT_CHANGE) if flag is None and kept else flag
            for flag, kept, margin in zip(self.flags, self.kept, margins, strict=True)
        ]
        return replace(self, said=self.said or SAME_AS_BEFORE, flags=(flags[0], flags[1], flags[2]))

    def against(self, margins: Array, shown: Array) -> NDArray[np.int64]:
        """(N, 2) how much of what is said does not hold: of all, and of the joints' angles.

        margins: (N, 3) as `margins` has them; shown: (N, 6) the controller's joints [rad].
        """
        flags = np.zeros(len(margins), dtype=np.int64)
        for k, flag in enumerate(self.flags):
            if flag is not None:
                flags += (margins[:, k] if flag else -margins[:, k]) < -NEAR
        angles = np.zeros(len(shown), dtype=np.int64)
        for joint, low, high in self.between:
            angles += (shown[:, joint] < low - NEAR) | (shown[:, joint] > high + NEAR)
        return np.stack([flags + angles, angles], axis=1)


def posture(robot: Robot, convention: Convention, q: Array) -> NDArray[np.bool_] | None:
    """(N, 3) flags of poses (N, 6): wrist centre in front of axis 1, elbow up, joint 5 shown positive.

    q: the URDF's joints. None for an arm that has not six turning joints. In front is where a positive turn
    about axis 2 leans an upright arm; the elbow is up when the forearm leans from the upper arm to that side.
    """
    if len(robot.joints) != 6 or any(robot.sliding):
        return None
    return margins(robot, convention, q) >= 0


def margins(robot: Robot, convention: Convention | None, q: Array) -> Array:
    """(N, 3) how far poses (N, 6) are from where each flag of `posture` changes: sines of angles, negative
    where the flag is False. convention: None where the URDF's joints count as they are."""
    arm = arrays(robot)
    where = frames(arm.with_geometry(np.zeros_like(arm.geometry)), q)
    signs = np.sign(convention.A[1, 1] or 1.0) if convention else 1.0
    axis2 = signs * where.axes[:, 2, arm.axial[1] % 6]
    up = where.axes[:, 1, arm.axial[0] % 6]
    up = up * np.where(up[:, 2:] < 0, -1.0, 1.0)
    shoulder, elbow = where.origin[:, 2], where.origin[:, 3]
    axis4, axis5 = (where.axes[:, slot, arm.axial[slot - 1] % 6] for slot in (4, 5))
    wrist = _nearest(where.origin[:, 5], axis5, where.origin[:, 4], axis4)
    out = wrist - where.origin[:, 1]
    reach = np.einsum("ij,ij->i", out, np.cross(axis2, up)) / _length(out)
    upper, fore = elbow - shoulder, wrist - elbow
    fold = np.einsum("ij,ij->i", np.cross(upper, fore), axis2) / (_length(upper) * _length(fore))
    fifth = np.sin((convention.shown(q) if convention else q)[:, 4])
    return np.stack([reach, fold, fifth], axis=1)


def _nearest(p: Array, a: Array, o: Array, b: Array) -> Array:
    """(N, 3) the point of the line through p along a that is nearest to the line through o along b."""
    slope = np.einsum("ij,ij->i", a, b)[:, None]
    part = np.einsum("ij,ij->i", o - p, a - slope * b)[:, None]
    return p + a * part / np.maximum(1 - slope**2, 1e-9)


def _length(v: Array) -> Array:
    """(N,) of (N, 3), never zero."""
    return np.maximum(np.linalg.norm(v, axis=1), 1e-9)


def turn_numbers(angles: Array) -> NDArray[np.int64]:
    """FANUC's turn numbers of joints [rad]: 0 within ±180°, 1 from 180° to 540°, −1 from −540° to −180°."""
    return np.asarray(np.floor((angles + np.pi) / FULL), dtype=np.int64)


def of_kuka(status: int | None, turn: int | None) -> Posture:
    """S: bit 0 wrist centre behind axis 1 (overhead), bit 1 elbow up (axis 3 from 0° on; with an offset
    between axes 3 and 4 from where the arm is stretched), bit 2 axis 5 negative. T: bit i axis i + 1
    negative. Without S the one before is kept, without T the way is the shortest. System Software, operating
    and programming instructions for system integrators."""
    said = [f"{name} {value}" for name, value in (("S", status), ("T", turn)) if value is not None]
    flags: Flags = (None, None, None)
    if status is not None:
        flags = (not status & 1, bool(status & 2), not status & 4)
    signs = [] if turn is None else [bool(turn & 1 << joint) for joint in range(6)]
    between = tuple((j, -np.inf, 0.0) if minus else (j, 0.0, np.inf) for j, minus in enumerate(signs))
    return Posture(", ".join(said), flags, between, kept=(True, True, True))


def of_abb(confdata: Sequence[float], obeyed: bool) -> Posture:
    """cf1, cf4, cf6: quarter turns of joints 1, 4 and 6; cfx: 4 behind axis 1, 2 behind the lower arm, 1 axis
    5 negative (RAPID reference manual, confdata)."""
    *quarters, kind = confdata
    between = tuple(
        (joint, quarter * np.pi / 2, (quarter + 1) * np.pi / 2)
        for joint, quarter in zip((0, 3, 5), quarters, strict=True)
        if abs(quarter) < 100  # 9E9: not said
    )
    said = f"[{','.join(f'{value:g}' for value in confdata)}]"
    if kind not in range(8):  # of other arms
        return Posture(said, between=between, obeyed=obeyed)
    behind = int(kind)
    return Posture(said, (not behind & 4, not behind & 2, not behind & 1), between, obeyed)


def of_fanuc(configuration: str) -> Posture:
    """N or F: joint 5 not positive or positive, U or D: elbow, T or B: in front of axis 1 or behind; turn
    numbers of joints 4, 5 and 6 (operator's manual). Left and right are of other arms."""
    letters, *numbers = configuration.split(",")
    words = letters.upper().replace(" ", "")  # N U T and NUT
    turns = [int(number) for number in numbers if number.strip().lstrip("+-").isdigit()]
    between = tuple(
        (joint, turn * FULL - np.pi, turn * FULL + np.pi)
        for joint, turn in enumerate(turns, 3)
        if len(turns) == 3
    )
    flags = (_either(words, "T", "B"), _either(words, "U", "D"), _either(words, "F", "N"))
    return Posture(f"CONFIG '{configuration.strip()}'", flags, between)


def of_staubli(words: Sequence[str]) -> Posture | None:
    """Of (3,) words: shoulder lefty or righty, elbow and wrist positive or negative; "same" is as before,
    "free" says nothing (VAL 3 reference manual). Lefty is in front of axis 1: an RX's or TX's shoulder is
    left of it."""
    shoulder, elbow = _either(words, "lefty", "righty"), _either(words, "epositive", "enegative")
    flags = (shoulder, elbow, _either(words, "wpositive", "wnegative"))
    said = [word for word, flag in zip(words, flags, strict=True) if flag is not None]
    kept = ("ssame" in words, "esame" in words, "wsame" in words)
    return Posture(", ".join(said), flags, kept=kept) if said or any(kept) else None


def _either(words: Sequence[str], yes: str, no: str) -> bool | None:
    return True if yes in words else False if no in words else None
