"""What stands apart from the robot: where the instrument stands, where the targets sit, the noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.stats import chi2

from ...robot.kinematics import Array
from .decision import Decided
from .occasions import Occasion
from .result import Apart, TargetMoved
from .scatter import scatters
from .system import Solved, System, moved_without_parts

LEVEL = 1e-4  # of the test whether targets moved


def apart(decided: Decided, final: Sequence[Occasion]) -> Iterator[Apart]:
    """Each occasion against the first. final: the occasions at what was solved for."""
    system, solved = decided.system, decided.solved
    shapes, scales = [decided.shape(m) for m in decided.members], [m.scale for m in decided.members]
    without = moved_without_parts(system, shapes, scales, solved)
    scattered = scatters(system, shapes, solved)
    for k, one in enumerate(final):
        shift, turn, std = _frame(system, solved, final[0], one, k)
        targets, moved = _targets(system, final, solved, k, (without[0], without[k]))
        noise, temperature = one.prepared.noise, one.problem.campaign.poses.temperature
        warm = temperature is not None and np.isfinite(temperature).any()
        yield Apart(
            one.label,
            1e3 * shift,
            1e3 * std[0],
            1e3 * turn,
            1e3 * std[1],
            targets,
            moved,
            noise.sigma_mm,
            noise.source,
            scattered[k],
            float(np.nanmean(temperature)) if warm and temperature is not None else None,
        )


def _frame(
    system: System, solved: Solved, first: Occasion, one: Occasion, k: int
) -> tuple[float, float, tuple[float, float]]:
    """Shift [m] of the middle of the first occasion's points and turn [rad] between the first set-ups, and
    one sigma of each: of the one instrument in the other, which no choice of the base changes."""
    middle = first.fit.line.prediction.base.mean(axis=(0, 1))
    a, b = first.fit.state, one.fit.state
    turn = b.R[0] @ a.R[0].T
    shift = (b.R[0] @ middle + b.t[0]) - (a.R[0] @ middle + a.t[0])
    angle = np.arctan2(np.linalg.norm(turn - turn.T) / np.sqrt(8), (np.trace(turn) - 1) / 2)
    if k == 0:
        return 0.0, 0.0, (0.0, 0.0)
    half = _at(system, solved, one, k, middle)
    half = half - np.kron(np.eye(2), turn) @ _at(system, solved, first, 0, middle)
    std = solved.factor * np.linalg.norm(half, axis=1)
    return (
        float(np.linalg.norm(shift)),
        float(angle),
        (float(np.linalg.norm(std[:3])), float(np.linalg.norm(std[3:]))),
    )


def _at(system: System, solved: Solved, one: Occasion, k: int, middle: Array) -> Array:
    """(6, ·) half of the covariance of a first set-up's shift at `middle` (base frame) and turn."""
    part = slice(system.local[k].start, system.local[k].start + 6)
    half = solved.half[part] * system.prior[part, None]
    lever = one.fit.state.R[0] @ middle + one.fit.state.t[0] - one.fit.line.centre[0]
    return np.concatenate([half[:3] + np.cross(half[3:].T, lever).T, half[3:]])


def _difference(
    system: System, solved: Solved, k: int, there: slice, here: slice, without: Sequence[Array]
) -> Array:
    """Covariance of own numbers `there` of occasion k minus `here` of the first [m, rad]: by the noise, and
    where that is too sure by as much as parts of either occasion say (jackknife: Efron & Stein 1981).
    without: of either, by how much all numbers move without each of its parts."""
    a, b = system.local[0].start, system.local[k].start
    first, last = slice(a + here.start, a + here.stop), slice(b + there.start, b + there.stop)

    def difference(x: Array) -> Array:
        return np.asarray(x[last] * system.prior[last, None] - x[first] * system.prior[first, None])

    half = difference(solved.half)
    covariance = solved.factor**2 * half @ half.T
    each = [difference(one.T) for one in without]
    shown = sum((d.shape[1] - 1) ** 2 / d.shape[1] * np.atleast_2d(np.cov(d)) for d in each)
    more = float(np.trace(np.linalg.solve(covariance, shown))) / len(covariance)
    return np.asarray(covariance * max(1.0, more))


def _targets(
    system: System, final: Sequence[Occasion], solved: Solved, k: int, without: Sequence[Array]
) -> tuple[tuple[TargetMoved, ...], bool]:
    """Targets that both occasions have in their first set-ups, and whether any moved."""
    first, one = final[0], final[k]
    if k == 0:
        return (), False
    found, moved = list[TargetMoved](), False
    there = {name: (place, part) for name, place, part in _own(one)}
    both = [(name, place, part, *there[name]) for name, place, part in _own(first) if name in there]
    for name, place, part, place_now, part_now in both:
        change = place_now - place
        covariance = _difference(system, solved, k, part_now, part, without)
        std = np.sqrt(np.diag(covariance))
        moved |= bool(change @ np.linalg.solve(covariance, change) > chi2.isf(LEVEL / len(both), len(change)))
        by, sigma = 1e3 * change[:3], 1e3 * std[:3]
        found.append(TargetMoved(name, tuple(by.tolist()), tuple(sigma.tolist())))
    return tuple(found), moved


def _own(one: Occasion) -> Iterator[tuple[str, Array, slice]]:
    """Name, place and columns of each target fitted in the first set-up; a 6-D body by its middle."""
    for setup, i, part in one.fit.columns.targets:
        if setup != 0:
            continue
        places = one.fit.state.targets[0]
        if i is None:
            yield "body", places.mean(axis=0), slice(part.start, part.start + 3)
        else:
            yield one.problem.campaign.targets[i].name, places[i], part
