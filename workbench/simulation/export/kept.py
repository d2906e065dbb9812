"""What a format keeps of the extended robot, and the geometry that makes up for the rest.

A geometry that was fitted beside springs and gears is no good without them. So the lengths, offsets and
twists of a file that cannot say these are fitted once more, to where the whole model has the flange.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...effects.acting import Acting
from ...robot.compensator import CompensatorLaw
from ...robot.kinematics import Array, frames, twists
from ...robot.rotations import body_jacobian, vectors
from .coil import nearest_coil
from .content import Content

ROUNDS = 3  # of Gauss-Newton: what is left out is millimetres of metres
LEVER = 0.2  # m from the flange to a tool: how far a turn of the flange counts
NEAR, LIKELY = 1e-4, 1e-3  # m: what a fit leaves, and how far (m, rad) a geometry may go to come that near


@dataclass(frozen=True, eq=False)
class Kept:
    """acting: the effects; elastic: with the TOML's springs; law: the compensator, as the format has it."""

    acting: Acting
    elastic: bool
    law: CompensatorLaw | None

    def flange(self, content: Content) -> tuple[Array, Array]:
        """Flange (N, 3) [m] and its rotation (N, 3, 3) in the content's poses."""
        return content.flange(self.acting, rigid=not self.elastic, pulled=self.law is not None, by=self.law)


def kept_of(content: Content, carries: frozenset[str]) -> Kept:
    """What a format keeps that carries these kinds (`content.kind_of`; "spring": the TOML's own too).

    "coil" carries a compensator as a coil spring, "gas" as it is.
    """
    law = content.compensator
    if law is not None and "gas" not in carries:
        law = nearest_coil(content) if "coil" in carries else None
    return Kept(content.acting(carries | {"compensator"}), "spring" in carries, law)


def refitted(content: Content, kept: Kept, flange: bool) -> Content:
    """The content with the geometry that brings what is kept nearest to the whole model in the poses: least
    squares in the flange's place and turn, with a prior about the model's geometry. A robot that nothing
    was identified of stays as it is. flange: how that stands on the last axis is kept as well."""
    acting, own = content.extended.acting, content.problem.arm.geometry
    if not (own.any() or len(acting)):
        return content
    place, turn = content.flange(acting)
    if not flange:
        content = content.with_geometry(np.vstack([own[:-1], 0 * own[-1:]]))
    for _ in range(ROUNDS):
        p, R = kept.flange(content)
        left = np.concatenate([place - p, LEVER * vectors(turn @ R.transpose(0, 2, 1))], axis=1)
        if np.abs(left).max() < 1e-9:
            break
        arm = content.problem.arm
        where = frames(arm, content.problem.q)
        twist = twists(where.geometry_axes, where.geometry_origin)[:, :, 6:-6]  # of the joints' own
        shifts = body_jacobian(where.p[-1]) @ twist
        J = np.concatenate([shifts, LEVER * twist[:, 3:]], axis=1).reshape(left.size, -1) / NEAR
        gone = (arm.geometry - own)[1:-1].ravel() / LIKELY
        A = np.vstack([J, np.eye(J.shape[1]) / LIKELY])
        b = np.concatenate([left.ravel() / NEAR, -gone])
        geometry = arm.geometry.copy()
        geometry[1:-1] += np.linalg.lstsq(A, b, rcond=None)[0].reshape(-1, 6)
        content = content.with_geometry(geometry)
    return content
