"""The derivative of the wrenches at the slots by every small motion of every frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .compensator import CompensatorLaw
from .kinematics import Arm, Array, Frames
from .loads import Loads, Wrenches
from .rotations import cross


def wrench_jacobian(
    arm: Arm,
    where: Frames,
    loads: Loads,
    load: Wrenches,
    rows: NDArray[np.int64],
    axes: Array,
    origin: Array,
    before_joint: bool,
) -> Array:
    """Derivative of the local wrenches `rows` (columns 6 · slot + component) by slot motions.

    `axes`, `origin` are those of the motions (T's, or G's with before_joint=True: then the motion
    of a slot comes before all components of T at that slot). Returns (N, len(rows), 6 S).

    A motion beyond the row's axis shifts the masses that hang on it; a motion before it turns
    the axis and its whole load, while gravity and external wrench keep their direction.
    """
    n_poses, slots = origin.shape[:2]
    turn, bend, push = _row_vectors(arm, where, loads, load, rows)
    field = np.zeros((n_poses, slots, 6, 3))
    field[:, :, 3:] = axes[:, :, 3:]
    before = np.matmul(turn, field.reshape(n_poses, -1, 3).transpose(0, 2, 1))
    # motion of the masses beyond each slot; they are summed about T's origin, G pivots about its own
    first = load.first + load.mass[..., None] * (where.origin - origin)
    field[:, :, :3] = load.mass[..., None, None] * axes[:, :, :3]
    field[:, :, 3:] = cross(axes[:, :, 3:], first[:, :, None])
    beyond = np.matmul(bend, field.reshape(n_poses, -1, 3).transpose(0, 2, 1))
    if push is not None:
        field[:, :, :3] = axes[:, :, :3]
        field[:, :, 3:] = cross(axes[:, :, 3:], (where.p[-1][:, None] - origin)[:, :, None])
        beyond += np.matmul(push, field.reshape(n_poses, -1, 3).transpose(0, 2, 1))
    out = beyond
    np.copyto(out, before, where=~_beyond(arm, rows, before_joint))
    if loads.compensator is not None:
        parts = out.reshape(n_poses, len(rows), slots, 6)
        _compensator_jacobian(arm, where, loads.compensator, rows, axes, origin, before_joint, parts)
    return out


def _row_vectors(
    arm: Arm, where: Frames, loads: Loads, load: Wrenches, rows: NDArray[np.int64]
) -> tuple[Array, Array, Array | None]:
    """Vectors (N, rows, 3) whose products with a motion's field are the derivatives of the rows.

    turn: with the rotation of axis and load together; bend: with the shift of mass, beyond the axis;
    push: with the shift of the flange under an external force (None: no force). Compensator forces
    turn along with the axis, so they do not count.
    """
    slot, component = np.divmod(rows, 6)
    axis = where.axes[:, slot, component]
    rotary = (component >= 3)[:, None]
    gravity, external = arm.gravity, loads.wrench[:, None, :3]
    turn = cross(cross(axis, load.first[:, slot]), gravity)
    weight = load.mass[:, slot, None] * gravity
    if not loads.wrench.any():
        turn = turn if rotary.all() else np.where(rotary, turn, cross(axis, weight))
        return turn, np.where(rotary, cross(gravity, axis), 0.0), None
    lever = where.p[-1][:, None] - where.origin[:, slot]
    turn += cross(cross(axis, lever), external) + cross(axis, loads.wrench[:, None, 3:])
    turn = np.where(rotary, turn, cross(axis, weight + external))
    bend, push = cross(gravity, axis), cross(external, axis)
    return turn, np.where(rotary, bend, 0.0), np.where(rotary, push, 0.0)


def _beyond(arm: Arm, rows: NDArray[np.int64], before_joint: bool) -> NDArray[np.bool_]:
    """(rows, 6 S): the motion acts beyond the row's axis and does not turn it."""
    out = np.zeros((len(rows), arm.slots, 6), dtype=bool)
    for i, row in enumerate(rows):
        slot, component = divmod(int(row), 6)
        out[i, slot + 1 :] = True
        if not before_joint:
            sequence = _sequence(arm, slot)
            out[i, slot, list(sequence[sequence.index(component) :])] = True
    return out.reshape(len(rows), -1)


def _sequence(arm: Arm, slot: int) -> tuple[int, ...]:
    """Order in which a slot's components act."""
    sliding = 1 <= slot <= arm.n and bool(arm.prismatic[slot - 1])
    return (0, 1, 3, 4, 5, 2) if sliding else (0, 1, 2, 3, 4, 5)


def _compensator_jacobian(
    arm: Arm,
    where: Frames,
    law: CompensatorLaw,
    rows: NDArray[np.int64],
    axes: Array,
    origin: Array,
    before_joint: bool,
    out: Array,
) -> None:
    """Adds the compensator's part: motions between its two links stretch it.

    A motion that shifts the moving pivot by da changes the pull by −K da, and the row by w · da; v and t
    say what it does to the row by moving the row's own pivot and by turning its axis.
    """
    a, u, s = law.ends(where)
    force, rate, _ = law.force(s)
    pull, tight = force[:, None] * u, (force / s)[:, None]
    inside = range(law.body + 1, law.arm + 1)
    for i, row in enumerate(rows):
        slot, component = divmod(int(row), 6)
        if slot not in inside:
            continue
        axis, lever = where.axes[:, slot, component], a - where.origin[:, slot]
        rotary = component >= 3
        acts = cross(axis, lever) if rotary else axis
        along = np.sum(acts * u, axis=1, keepdims=True) * u
        w = -rate[:, None] * along - tight * (acts - along)
        v = cross(pull, axis) if rotary else np.zeros_like(w)
        t = cross(axis, cross(lever, pull) if rotary else pull)
        sequence = _sequence(arm, slot)
        for other in inside:
            # which of the other slot's motions carry the row's axis and pivot along
            carries = np.full(6, other < slot or (other == slot and before_joint))
            if other == slot and not before_joint:
                carries[list(sequence[: sequence.index(component)])] = True
            pivot = where.origin[:, slot] - origin[:, other]
            e = axes[:, other]
            out[:, i, other, :3] += _along(e[:, :3], w + v) - carries[:3] * _along(e[:, :3], v)
            out[:, i, other, 3:] += _along(e[:, 3:], cross(a - origin[:, other], w + v))
            out[:, i, other, 3:] += carries[3:] * _along(e[:, 3:], t - cross(pivot, v))


def _along(axes: Array, vector: Array) -> Array:
    """(N, 3) parts of vectors (N, 3) along three axes each (N, 3, 3)."""
    return np.einsum("nci,ni->nc", axes, vector)
