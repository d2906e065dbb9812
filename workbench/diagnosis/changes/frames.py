"""What stands apart from the robot: where the instrument stands, the noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...robot.kinematics import Array
from .covered import carried
from .decision import Decided
from .findings import hidden_zeros
from .found import Apart
from .occasions import Occasion
from .scatter import scatters
from .system import Solved, System, moved_without_parts, parts_in_order
from .targets import targets_moved


def apart(decided: Decided, final: Sequence[Occasion]) -> Iterator[Apart]:
    """Each occasion against the first. final: the occasions at what was solved for."""
    system, solved = decided.system, decided.solved
    shapes, scales = [decided.shape(m) for m in decided.members], [m.scale for m in decided.members]
    hidden = hidden_zeros(decided)
    without = moved_without_parts(system, shapes, scales, solved, parts_in_order(system))
    scattered = scatters(system, shapes, solved)
    for k, one in enumerate(final):
        shift, turn, std = _frame(system, solved, final[0], one, k)
        targets = targets_moved(system, final, solved, k, (without[0], without[k]), hidden)
        noise, temperature = one.prepared.noise, one.problem.campaign.poses.temperature
        warm = temperature is not None and np.isfinite(temperature).any()
        yield Apart(
            one.label,
            1e3 * shift,
            1e3 * std[0],
            1e3 * turn,
            1e3 * std[1],
            targets,
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
    std = carried(system, k, [0]) * solved.factor * np.linalg.norm(half, axis=1)
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
