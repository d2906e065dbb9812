"""Hidden causes that come with time, warmth and the instrument."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...campaign.problem import Problem
from ...effects.drift import Drift
from ...effects.thermal_growth import ThermalGrowth
from ...effects.tracker_scale import TrackerScale
from ...robot.kinematics import Array
from ...simulation.virtual_campaign import Truth
from .hidden import Hidden, joint_error


def thermal_growth(problem: Problem, effect: ThermalGrowth, rng: np.random.Generator) -> Hidden:
    """Each link with a coefficient of its own, within 15 %; without thermometer over any time constant. Or a
    rack that is held somewhere, and warmer at one end."""
    if effect.of_scale:
        return _scale(problem, effect, rng)
    each = rng.uniform(0.85, 1.15, problem.arm.slots)
    timed = effect.variant.startswith("warmup")
    unit = effect.params[0].typical
    constant = rng.uniform(0.2, 0.8) * (0.0 if problem.time is None else float(np.ptp(problem.time)))

    def motion(problem: Problem) -> Mapping[int, Array]:
        span = problem.arm.span
        if timed:
            assert problem.time is not None
            warmth = 1 - np.exp(-problem.time / constant)
        elif problem.warmth is None:
            return {}
        else:
            warmth = problem.warmth
        return {
            6 * slot + c: unit * each[slot] * warmth * span[slot, c]
            for slot in range(problem.arm.slots)
            for c in range(3)
            if abs(span[slot, c]) > 1e-9
        }

    def form(size: float) -> Truth:
        return Truth(motion=lambda problem: {k: size * v for k, v in motion(problem).items()})

    return Hidden("thermal_growth", effect, np.array([unit]), form, 5.0 if timed else 2.5)


def _scale(problem: Problem, effect: ThermalGrowth, rng: np.random.Generator) -> Hidden:
    j, unit = problem.joint(effect.where.joint), effect.params[0].typical
    low, high = problem.q[:, j].min(), problem.q[:, j].max()
    held, uneven = rng.uniform(low, high), rng.uniform(-0.15, 0.15) / (high - low)

    def error(problem: Problem) -> Array:
        way = problem.q[:, j] - held
        return np.asarray(
            (0.0 if problem.warmth is None else problem.warmth) * unit * way * (1 + uneven * way)
        )

    return Hidden("thermal_growth", effect, unit * np.array([1.0, -held]), joint_error(j, error), 2.5)


def drift(problem: Problem, effect: Drift, rng: np.random.Generator) -> Hidden:
    """A way that is slightly curved in time."""
    assert problem.time is not None
    if effect.free:  # any course
        effect = Drift(variant=effect.variant.split(" ")[0], start=effect.start)
    span = float(np.ptp(problem.time))
    way, columns = rng.normal(size=len(effect.params)), list(effect.motion(problem))
    unit = 1e-8 * way / np.linalg.norm(way[:3])
    bend = rng.uniform(-0.4, 0.4)

    def form(size: float) -> Truth:
        def motion(problem: Problem) -> Mapping[int, Array]:
            assert problem.time is not None
            since = problem.time * (1 + bend * (problem.time / span - 0.5))
            return {c: size * v * since for c, v in zip(columns, unit, strict=True)}

        return Truth(motion=motion)

    return Hidden("drift", effect, unit, form, 20.0)


def tracker_scale(problem: Problem, effect: TrackerScale, rng: np.random.Generator) -> Hidden:
    """Refraction that is not quite the same at all heights."""
    unit, layer = float(rng.choice([-1e-5, 1e-5])), rng.uniform(-0.1, 0.1)

    def form(size: float) -> Truth:
        def seen(problem: Problem, points: Array) -> Array:
            height = points[..., 2:] - np.nanmean(points[..., 2])
            return points + size * unit * points * (1 + layer * height)

        return Truth(seen=seen)

    return Hidden("tracker_scale", effect, np.array([unit]), form, 50.0)
