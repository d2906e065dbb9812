"""What runs say: errors and figures of each, accuracy of all."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ...robot.description import Robot
from ...robot.kinematics import Array
from .measures import beside, figures, main_lines, normal, path_accuracy, tangents
from .runs import Outcome
from .verification import Repeats, Series, Trial


def trial(done: Outcome, p: Array, time: Array, lines: Sequence[tuple[str, int, float]]) -> Trial:
    """A run judged at the path's places p (N, 3) [m], at its own times (N,) [s]."""
    error = done.tool[:, :3, 3] - p
    across = beside(error, tangents(p))
    return Trial(
        error,
        across,
        done.links,
        done.motor,
        figures(error, across, error @ normal(p), time),
        main_lines(done.time, across, done.q, lines),
    )


def orders(truth: Robot, belief: Robot) -> list[tuple[str, int, float]]:
    """Gear orders that may show: of the effects of truth and belief."""
    names = truth.joint_names
    stated = {(i.joint, i.order) for i in (*truth.effects, *belief.effects) if i.order and i.joint in names}
    return [
        (f"{joint}, {order:g} per joint turn", names.index(joint), order)
        for joint, order in sorted(stated)
        if joint is not None and order is not None
    ]


def accuracy(series: Series, repeated: list[Outcome], p: Array) -> tuple[Repeats, ...]:
    """AT and RT at the series' speed; RT is unknown without repeated runs."""
    names, count = ("uncorrected", "corrected"), len(repeated) // 2
    if not count:
        single = [path_accuracy([series.trials[name].across])[0] for name in names]
        return tuple(Repeats(name, 1, series.speed, at, None) for name, at in zip(names, single, strict=True))
    across = [beside(outcome.tool[:, :3, 3] - p, tangents(p)) for outcome in repeated]
    return tuple(
        Repeats(name, count, series.speed, *path_accuracy(across[a:b]))
        for name, (a, b) in zip(names, pairwise((0, count, 2 * count)), strict=True)
    )
