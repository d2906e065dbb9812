"""Loads and what they do to the arm: wrenches at every slot, their derivative, loaded equilibrium.

The wrench at slot k is what the part beyond the slot receives from gravity, payload, external
wrench and compensator, as generalised forces of the slot's six motions (N and N·m). The arm
rests where every yielding slot has moved by its law under its own wrench:

    motion = direct + law(wrench(motion)),        law = C · wrench, plus what effects add.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .description import Compensator
from .kinematics import Arm, Array, Frames, cross, frames

ATMOSPHERE = 101325.0  # Pa


@dataclass(frozen=True)
class CompensatorLaw:
    """Force of a compensator, F(s) in N > 0 when it pulls its pivots together; s in m.

    `charge` scales the absolute gas pressure, or the spring's rate (1 = nominal), for all poses or for
    each (N,); `preload` [N] adds to the force.
    """

    data: Compensator
    body: int
    arm: int
    body_pivot: Array
    arm_pivot: Array
    charge: float | Array = 1.0
    preload: float = 0.0

    def force(self, s: Array) -> tuple[Array, Array, Array]:
        """F, dF/ds and dF/dcharge at pivot distances s: (N,)."""
        d = self.data
        if d.kind == "spring":
            assert d.rate is not None
            assert d.free_length is not None
            pull = d.rate * (s - d.free_length)
            return self.charge * pull + self.preload, self.charge * np.full_like(s, d.rate), pull
        assert d.piston_area
        assert d.precharge
        assert d.gas_length
        assert d.reference is not None
        length = d.gas_length - (s - d.reference)
        gas = d.piston_area * d.precharge * (d.gas_length / length) ** d.exponent
        force = self.charge * gas - d.piston_area * ATMOSPHERE + self.preload
        return force, self.charge * gas * d.exponent / length, gas

    def ends(self, where: Frames) -> tuple[Array, Array, Array]:
        """Moving pivot (N, 3), unit vector from it to the fixed pivot (N, 3), distance (N,)."""
        a = where.p[self.arm] + where.R[self.arm] @ self.arm_pivot
        b = where.p[self.body] + where.R[self.body] @ self.body_pivot
        s = np.linalg.norm(b - a, axis=1)
        return a, (b - a) / s[:, None], s


@dataclass(frozen=True)
class Loads:
    """What pulls on the arm in N poses.

    mass: (N,) [kg], moment: (N, 3) [kg·m, flange frame] of tool and payload together; wrench:
    (N, 6) [N, N·m] on the robot at the flange origin, base frame; torque: (N, n) [N·m or N] extra
    axial torque on each joint (hose).
    """

    mass: Array
    moment: Array
    wrench: Array
    torque: Array
    compensator: CompensatorLaw | None = None


@dataclass(frozen=True)
class Wrenches:
    """Wrenches at all slots: local (N, S, 6), and the sums that their derivative needs.

    force, moment: (N, S, 3) in the base frame, the moment about the slot's origin. mass: (N, S),
    first: (N, S, 3) mass and first moment of mass about the slot's origin, of all beyond it.
    """

    local: Array
    force: Array
    moment: Array
    mass: Array
    first: Array


def wrenches(arm: Arm, where: Frames, loads: Loads) -> Wrenches:
    """Wrenches at all slots."""
    n_poses, slots = where.origin.shape[:2]
    # slot by slot in memory, as the frames are
    axes, origin = where.axes.transpose(1, 0, 2, 3), where.origin.transpose(1, 0, 2)
    mass, first = np.empty((slots, n_poses)), np.empty((slots, n_poses, 3))
    mass[-1] = loads.mass
    first[-1] = loads.mass[:, None] * where.p[-1] + (where.R[-1] @ loads.moment[..., None])[..., 0]
    for k in range(slots - 2, -1, -1):
        mass[k] = mass[k + 1] + arm.mass[k]
        turned = (where.R[k].reshape(-1, 3) @ arm.moment[k]).reshape(n_poses, 3)
        first[k] = first[k + 1] + arm.mass[k] * where.p[k] + turned
    first -= mass[..., None] * origin
    external = loads.wrench[:, :3]
    force = mass[..., None] * arm.gravity + external
    moment = cross(first, arm.gravity)
    if loads.wrench.any():
        moment += cross(where.p[-1] - origin, external) + loads.wrench[:, 3:]
    if (c := loads.compensator) is not None:
        a, u, s = c.ends(where)
        pull = c.force(s)[0][:, None] * u
        for k in range(c.body + 1, c.arm + 1):
            force[k] += pull
            moment[k] += cross(a - origin[k], pull)
    local = np.empty((slots, n_poses, 6))
    np.einsum("snci,sni->snc", axes[..., :3, :], force, out=local[..., :3])
    np.einsum("snci,sni->snc", axes[..., 3:, :], moment, out=local[..., 3:])
    slot, component = np.divmod(arm.axial, 6)
    local[slot, :, component] += loads.torque.T
    return Wrenches(*(x.swapaxes(0, 1) for x in (local, force, moment, mass, first)))


Law = Callable[[Array], Array]


def equilibrium(
    arm: Arm,
    q: Array,
    direct: Array,
    loads: Loads,
    law: Law,
    tolerance: float = 1e-13,
    near: Array | None = None,
    hasten: Law | None = None,
) -> tuple[Array, Frames, Wrenches]:
    """Loaded motions (N, S, 6), frames and wrenches.

    `direct`: (N, S, 6) motions that do not depend on load; `law` gives the motions (N, S, 6) under
    the local wrenches (N, S, 6). Fixed point; the load moves the wrenches by about 1e-3 of
    themselves, so each round gains three digits. An arm that is almost the same saves rounds: `near`, its
    motions, and `hasten`, which makes of a round's change (N, S, 6) the whole way to rest. Raises
    ArithmeticError when an arm is so soft that it does not come to rest.
    """
    motion, last = direct if near is None else near, np.inf
    for _ in range(60):
        where = frames(arm, q, motion)
        load = wrenches(arm, where, loads)
        change = direct + law(load.local) - motion
        step = float(np.abs(change).max(initial=0.0))
        if step < tolerance or (step < 1e3 * tolerance and step > 0.5 * last):  # as still as rounding allows
            return motion + change, where, load
        last = step
        motion = motion + (change if hasten is None else hasten(change))
    raise ArithmeticError("the loaded arm finds no rest: a stiffness is far too small for its load")


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
