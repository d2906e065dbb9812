"""Can poses under one load tell a joint's yield from its gear?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...effects.acting import Acting
from ...identification.fit import Fit
from ...report.numbers import decimals, mm, percent
from ...report.study import Table
from .measured import Measured, held_out
from .own_yield import torque
from .words import TITLE, micro, within

WAVES = 12  # of the angle: what of a torque these cannot make is not the angle's
BLURRED = 2.0  # times, from where on an interval is blurred


def sag_or_gear(robots: Sequence[Measured]) -> Table:
    """How far a joint's compliance hangs on what its gear may do."""
    rows, wider, moved = [], [], 0
    for robot in robots:
        start = [robot.known.words, percent(free := free_share(robot), 0)]
        found = []
        for words, more, judged in (
            ("geometry", [], True),
            ("… functions of all joints’ angles", robot.functions(), True),
            ("… and one of any size", robot.functions(wide=True), False),
        ):
            whole = robot.fitted([*robot.yields, *more])
            found.append(robot.estimate(whole))
            left = mm(held_out(robot.halves(whole))) if judged else ""
            own = _own_function(robot, whole) if judged and more else ("", "")
            rows.append([*start, words, micro(found[-1].value), micro(found[-1].half), left, *own])
        wider.append((free, found[-1].half / found[0].half))
        moved += any(one.differs(found[0]) for one in found[1:])
    times = [factor for _, factor in wider]
    least = min(wider)
    note = (
        "Strain wave gears, one load. Compliance of the joint that lifts the arm, 95 % by leaving out blocks "
        "of poses, not less than by what is left. Free share: of its torque, what is no function of its own "
        "angle. Own function: what this joint errs by as a function of its angle, RMS, and the correlation "
        "of the functions that the two halves of the poses give. A function of any size beside makes the "
        "interval "
        f"{within(times, 1)} times as wide. Functions beside change the value, by more than the blocks "
        f"allow, in {moved} of {len(robots)} campaigns."
    )
    if len(wider) > 1 and least[1] == max(times):
        note += (
            f" It widens most, {decimals(least[1], 0)} times, where the free share is least "
            f"({percent(least[0], 0)}), as in a sweep of one joint."
        )
    if moved or max(times) > BLURRED:
        note += " Under one load yield and gear are hard to tell apart here too."
    head = (
        "Robot",
        "Free share",
        "Beside",
        "µrad/(N·m)",
        "95 %, ±",
        "Error on other poses, mm",
        "Own function, µrad",
        "Halves, r",
    )
    return Table(TITLE, head, rows, note, (1, 3, 4, 5, 6, 7))


def _own_function(robot: Measured, whole: Fit) -> tuple[str, str]:
    """Of the joint that is asked for: RMS [µrad] over the poses of the function of its angle, and the
    correlation of the two halves' functions."""
    names, drawn = robot.problem.arm.names, []
    for half in robot.halves(whole):
        acting = Acting(tuple(zip(whole.model.effects, half.state.values, strict=True)))
        total = acting.gear_error(robot.problem.q, None, names)[:, names.index(robot.known.lift)]
        drawn.append(total - total.mean())
    size = float(np.sqrt(np.mean(np.square(drawn))))
    return decimals(1e6 * size, 0), decimals(float(np.corrcoef(drawn)[0, 1]), 2)


def free_share(robot: Measured) -> float:
    """Of the scatter of a joint's torque, the share that is no smooth function of the joint's angle."""
    own = torque(robot.problem)[:, robot.problem.joint(robot.known.lift)]
    at = (robot.angle - robot.angle.min()) / np.ptp(robot.angle)
    waves = np.cos(np.pi * np.outer(at, np.arange(WAVES)))
    left = own - waves @ np.linalg.lstsq(waves, own, rcond=None)[0]
    return float(left.std() / own.std())
