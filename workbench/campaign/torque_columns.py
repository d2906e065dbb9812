"""Whether recorded drive torques are what the format asks for: what the drive exerts on the joint.

Controllers also write down the motor's torque before the gear, a current or a percentage, the torque of the
load instead of the drive's (the other sign), or that torque without the compensator's share. Such a column
follows the model's loads as well as any, or not at all, and would contradict the points. It is told by how
many times the model's torque it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..robot.kinematics import Array
from ..robot.loads import wrenches
from .drive_torque import FEWEST, SHOWS, axis_error, scatter, shown
from .drives import own_of_drive
from .problem import Problem

FACTOR = 10**0.5  # by which a scale is nearer to another unit's, ten times or more, than to one
SURELY = 3.0  # standard errors
COUNTED = 0.5  # share of the compensator's torque: with less the column is nearer to one without it

Doubt = Literal["turned", "scaled", "unrelated", "without compensator"]
SAID: dict[Doubt, str] = {
    "turned": "have the sign of what the loads do to the joint, not of what the drive exerts against them: "
    "turn the sign of the tau columns",
    "scaled": "are {scales} times what the stated loads ask of the drives: the motor's own, before the gear, "
    "a current, another unit? Convert the tau columns",
    "unrelated": "do not follow the load: leave the tau columns out, or record them again",
    "without compensator": "are those of an arm without its compensator: does the controller leave it out? "
    "Take its share off the tau columns. If not, it has lost most of its force",
}


@dataclass(frozen=True)
class Doubtful:
    """A joint whose torques mean something else. scale: how many times the model's they are."""

    joint: int
    doubt: Doubt
    scale: float


def doubtful(problem: Problem) -> list[Doubtful]:
    """The joints whose recorded torques surely mean something else; none without the columns."""
    measured = problem.campaign.poses.torque
    if measured is None:
        return []
    bare = wrenches(problem.arm, problem.rigid, replace(problem.loads, compensator=None))
    weight = -problem.arm.own(bare.local)
    balance = -problem.nominal_torque - weight
    found = []
    for j, least in enumerate(axis_error(problem)):
        seen = np.isfinite(measured[:, j])
        if seen.sum() < FEWEST:
            continue
        own, values = own_of_drive(problem.campaign.poses, problem.nominal_torque, j)[seen], measured[seen, j]
        loads = [weight[seen, j]]
        if balance[seen, j].std() > least:
            loads.append(balance[seen, j])
        if (told := _doubt(own, np.column_stack(loads), values, float(least))) is not None:
            found.append(Doubtful(j, *told))
    return found


def _doubt(own: Array, loads: Array, values: Array, least: float) -> tuple[Doubt, float] | None:
    """What a joint's torques (k,) mean instead, and how many times the weight's they are; None where they may
    be what is asked for. own: (k, r) the drive's own; loads: (k, 1 or 2) torques that the weight, and the
    compensator, ask of it."""

    def left(columns: Array) -> Array:
        return np.asarray(columns - own @ np.linalg.lstsq(own, columns, rcond=None)[0])

    loads, values = left(loads), left(values)
    normal = loads.T @ loads
    if loads[:, 0].std() < least or np.linalg.cond(normal) > 1 / np.finfo(float).eps:
        return None
    times = np.linalg.solve(normal, loads.T @ values)
    rest = values - loads @ times
    free = max(len(values) - own.shape[1] - len(times), 1)
    spread = np.linalg.inv(normal) * float(rest @ rest) / free
    scale, error = float(times[0]), SURELY * float(np.sqrt(spread[0, 0]))
    if scale - error > FACTOR or scale + error < 1 / FACTOR:
        if float(rest @ rest) >= (1 - SHOWS) * float(values @ values):
            return "unrelated", scale
        return ("turned" if 1 / FACTOR < -scale < FACTOR else "scaled"), scale
    if len(times) > 1:
        short = np.array([-COUNTED, 1.0])
        if short @ times + SURELY * float(np.sqrt(short @ spread @ short)) < 0:
            return "without compensator", scale
    return None


def noise(problem: Problem, moved: Array | None = None, largest: float = np.inf) -> Array:
    """(n,) one sigma of each joint's torque about the model [N·m, N], as `drive_torque.scatter`; infinite
    where that explains less than `SHOWS` of it (no load on that joint), or a column means something else."""
    measured = problem.campaign.poses.torque
    assert measured is not None
    rms = scatter(problem, moved, largest)
    total = np.array([np.nanstd(column) if np.isfinite(column).any() else 0.0 for column in measured.T])
    sigma = np.where(shown(rms, total), rms, np.inf)
    sigma[[one.joint for one in doubtful(problem)]] = np.inf
    return sigma


def remarks(problem: Problem) -> list[str]:
    """A line for each kind of doubt, with its joints and what to do."""
    found = doubtful(problem)
    alike = ([one for one in found if one.doubt == doubt] for doubt in SAID)
    return [_said(problem, some) for some in alike if some]


def _said(problem: Problem, some: Sequence[Doubtful]) -> str:
    names = ", ".join(problem.arm.names[one.joint] for one in some)
    scales = ", ".join(f"{one.scale:.2g}" for one in some)
    what = SAID[some[0].doubt].format(scales=scales)
    return f"Drive torques of {names} are not used: they {what}."
