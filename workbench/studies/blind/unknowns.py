"""Errors that no cause of the catalogue has: the diagnosis shall say that it does not know them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ...simulation.virtual_campaign import Truth
from .hidden import Hidden, axial_torque, joint_error

LARGEST = 1e6  # the size is set by what is seen at the tool


def product(problem: Problem, rng: np.random.Generator) -> Hidden:
    """A joint errs with the product of two other joints' angles."""
    j, a, b = rng.permutation(problem.arm.n)[:3]
    middle = problem.q.mean(axis=0)
    return _joint("product", int(j), lambda p: (p.q[:, a] - middle[a]) * (p.q[:, b] - middle[b]))


def other_torque(problem: Problem, rng: np.random.Generator) -> Hidden:
    """A joint yields to the torque of another one."""
    torque = axial_torque(problem)
    loaded = np.flatnonzero(np.ptp(torque, axis=0) > 1e-3 * np.ptp(torque))
    other = int(rng.choice(loaded))
    j = int(rng.choice([i for i in range(problem.arm.n) if i != other]))
    most = float(np.abs(torque[:, other]).max())
    return _joint("other_torque", j, lambda p: axial_torque(p)[:, other] / most)


def memory(problem: Problem, rng: np.random.Generator) -> Hidden:
    """A joint rests on either side, as where it came from, which nobody recorded."""
    j, seed = _joint_of(problem, rng), int(rng.integers(1_000_000))

    def side(p: Problem) -> Array:
        return np.random.default_rng([seed, len(p.q)]).choice([-1.0, 1.0], len(p.q))

    return _joint("memory", j, side)


def slip(problem: Problem, rng: np.random.Generator) -> Hidden:
    """The tool slips on the flange whenever the hand points one way, and back."""
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    column, axis = 6 * (problem.arm.n + 1), int(rng.integers(3))

    def form(size: float) -> Truth:
        def motion(p: Problem) -> Mapping[int, Array]:
            side = np.tanh(8 * p.rigid.R[-1][:, 2, axis])
            return {column + c: size * 1e-4 * way[c] * side for c in range(3)}

        return Truth(motion=motion)

    return Hidden("slip", None, np.zeros(0), form, LARGEST)


def tracker_angle(problem: Problem, rng: np.random.Generator) -> Hidden:
    """The instrument's bearing circle is out of centre: it turns by a sine of the bearing, twice as fast."""
    phase = rng.uniform(-np.pi, np.pi)

    def form(size: float) -> Truth:
        def seen(p: Problem, points: Array) -> Array:
            x, y = points[..., 0], points[..., 1]
            turn = size * 1e-5 * np.sin(5 * np.arctan2(y, x) + phase)
            return points + np.stack([-turn * y, turn * x, np.zeros_like(x)], axis=-1)

        return Truth(seen=seen)

    return Hidden("tracker_angle", None, np.zeros(0), form, LARGEST)


UNKNOWNS: dict[str, Callable[[Problem, np.random.Generator], Hidden]] = {
    form.__name__: form for form in (product, other_torque, memory, slip, tracker_angle)
}


def _joint_of(problem: Problem, rng: np.random.Generator) -> int:
    return int(rng.integers(problem.arm.n))


def _joint(name: str, joint: int, error: Callable[[Problem], Array]) -> Hidden:
    form = joint_error(joint, lambda problem: 1e-4 * error(problem))
    return Hidden(name, None, np.zeros(0), form, LARGEST)
