"""The command that puts the extended robot's tool on the path.

Per sample, the loaded equilibrium and the joints are found together. A round moves the arm to the present
joints under the present sag, takes the sag that the wrenches there make, and corrects the joints by the
nominal inverse Jacobian. The extended robot differs from the nominal one by a thousandth, so each round
gains about three digits (a fast gear ripple: one or two); the frames are the exact ones in every round.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..effects.acting import Shares
from ..robot.kinematics import Array
from .extended_arm import parts
from .inverse import PLACE_ROUNDS, limited
from .trajectory import Trajectory

TOLERANCE = 1e-10  # m, turns with the tip's length
STILL = 1e-11  # rad, m: a smaller change under load is rest
ROUNDS = 60
REFRESH = 4  # rounds after which samples that are slow get a Jacobian of their own
STANDING = 1e-6  # rad, m: a joint that has not gone so far has not turned round


@dataclass(frozen=True, eq=False)
class Rest:
    """The extended robot in N samples: joints q (N, n), motions (N, S, 6) under load, error (N, 6) from the
    tool to the path [m, rad], whether it is at rest `there`, and the most rounds that any sample took."""

    q: Array
    sag: Array
    error: Array
    there: NDArray[np.bool_]
    rounds: int


def settle(
    trajectory: Trajectory, q: Array, direction: Array | None, sag: Array | None = None, still: float = STILL
) -> Rest:
    """Where the extended robot's tool comes to rest at commanded joints (N, n), from a guess of the sag that
    is written over."""
    return _run(trajectory, q, direction, sag, {}, still, None)


def first_step(trajectory: Trajectory, rest: Rest, direction: Array | None, shares: Shares) -> Array:
    """(N, n) joints that take the error at rest off, to first order; `shares` of effects."""
    q = rest.q.copy()
    for part in parts(len(q)):
        some = np.arange(part.start, part.stop)
        problem = trajectory.extended.at(q[part], None if direction is None else direction[part], some)
        here = {i: share[part] for i, share in shares.items()}
        scaled = trajectory.tip.scaled(rest.error[part])
        q[part] += _step(trajectory, problem, trajectory.gain(part), scaled, here)
    return q


def correct(trajectory: Trajectory, q: Array, direction: Array | None, sag: Array, shares: Shares) -> Rest:
    """Joints that put the extended robot's tool on the path, from a guess of joints and of the sag, which is
    written over."""
    return _run(trajectory, q, direction, sag, shares, STILL, TOLERANCE)


def _step(trajectory: Trajectory, problem: Problem, gain: Array, scaled: Array, shares: Shares) -> Array:
    """(K, n) change of the command that takes the scaled error (K, 6) [m] off."""
    slope = trajectory.extended.acting.ripple_slope(problem, shares)
    step = np.einsum("kij,kj->ki", gain, scaled) / (1 + slope)
    return limited(trajectory.nominal, trajectory.tip, step)


def _run(
    trajectory: Trajectory,
    q: Array,
    direction: Array | None,
    sag: Array | None,
    shares: Shares,
    still: float,
    tolerance: float | None,
) -> Rest:
    """All parts; without a tolerance the joints stay."""
    count, slots = len(q), trajectory.nominal.slots
    sag = np.zeros((count, slots, 6)) if sag is None else sag
    out = Rest(q.copy(), sag, np.empty((count, 6)), np.ones(count, bool), 0)
    rounds = [_part(trajectory, out, part, direction, shares, still, tolerance) for part in parts(count)]
    return replace(out, rounds=max(rounds))


def _part(
    trajectory: Trajectory,
    out: Rest,
    part: slice,
    direction: Array | None,
    shares: Shares,
    still: float,
    tolerance: float | None,
) -> int:
    """Rounds on one part until all its samples are at rest (and on the path); writes into `out`."""
    tip, nominal = trajectory.tip, trajectory.nominal
    active, gain = np.arange(part.start, part.stop), np.zeros((0, 0, 0))
    if tolerance is not None:
        gain = trajectory.gain(part)
    for count in range(1, ROUNDS + 1):
        q, sag = out.q[active], out.sag[active]
        problem = trajectory.extended.at(q, None if direction is None else direction[active], active)
        here = {i: share[active] for i, share in shares.items()}
        where, new = trajectory.extended.move(problem, sag, here)
        error = tip.error(where, trajectory.X[active])
        out.sag[active], out.error[active] = new, error
        change = (new - sag).reshape(len(q), -1)
        there = np.abs(change).max(axis=1) <= still
        busy = ~there
        if tolerance is not None:
            scaled = tip.scaled(error)
            if count % REFRESH == 0:
                gain = tip.gain(nominal, tip.jacobian(nominal, where), count < ROUNDS - PLACE_ROUNDS)
            # what the joints yield more than they did is taken off before it shows
            step = _step(trajectory, problem, gain, scaled, here)
            there &= np.abs(scaled[:, : tip.rows]).max(axis=1) <= tolerance
            busy |= tip.left(nominal, scaled, step) > tolerance
            step -= change[:, nominal.axial]
            out.q[active[busy]] += step[busy]
            gain = gain[busy]
        out.there[active] = there
        active = active[busy]
        if not len(active):
            return count
    return ROUNDS


def turning_sides(q: Array) -> Array:
    """(N, n) sides of approach of joints (N, n): the sign of each joint's last motion, 0 if it never moves.

    A joint has turned round when it has gone back by more than `STANDING`; standing still it keeps its
    side. Before its first motion it counts as coming from behind.
    """
    return np.stack([_sides(column) for column in q.T], axis=1)


def _sides(q: Array) -> Array:
    """(N,) sides of one joint. Only the samples at which it stops or turns are looked at."""
    moves = np.flatnonzero(np.diff(q))
    ends = moves[1:][np.diff(q)[moves][1:] * np.diff(q)[moves][:-1] < 0]
    out = np.zeros(len(q))
    side, extreme, at = 0.0, float(q[0]), 0
    for i in [*ends.tolist(), len(q) - 1]:
        value = float(q[i])
        if abs(value - extreme) > STANDING and side * (value - extreme) <= 0:
            now = 1.0 if value > extreme else -1.0
            out[at + 1 if side else 0 :] = now
            side, extreme, at = now, value, i
        elif side * (value - extreme) >= 0:
            extreme, at = (value, i) if side else (extreme, at)
    return out
