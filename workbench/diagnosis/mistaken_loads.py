"""Loads that are stated otherwise than they were: payloads exchanged, wrenches the other way round, in
another frame or unit, gravity of an arm that stands on no floor. Seen in how far the arm yields to them, by
the model's stiffnesses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ..campaign.problem import Problem
from ..files.faults import Fault, InputError
from ..identification.fit import Fit
from ..robot.kinematics import Array
from .other_loads import called

MOST = 4  # payloads that are tried in each other's places: 23 ways
AGAINST = 0.5  # of the squares at most is left where the arm yielded against its loads: it never does
ALONG = 0.25  # of the squares at most is left where they act along other axes
COSINE = 0.5  # of the angle between directions of gravity that are two
SO_LARGE = 0.1  # of the squares at most is left where they are of another size
UNITS = {9.80665: "kilograms for newtons", 1e3: "kilonewtons for newtons", 4.4482: "pounds for newtons"}


@dataclass(frozen=True)
class Mistake:
    """What the points say that the loads were, how to mend it, and the problem that says so. enough: of the
    squares at most is left without it; sure: no robot does the same."""

    what: str
    mend: str
    problem: Problem
    enough: float
    sure: bool = True


def mistaken_loads(result: Fit) -> list[str]:
    """A remark on wrenches in another unit, if the points fit these. Raises `InputError` where they fit
    payloads in each other's places, or wrenches or gravity that act the other way round or along other axes.
    result: a robust fit of the geometry."""
    problem = result.model.problem
    possible = list(_mistakes(problem))
    own = _left(result, problem) if possible else 0.0
    if own == 0.0:
        return []
    shares = [_left(result, one.problem) / own for one in possible]
    left, best = min(zip(shares, possible, strict=True), key=lambda pair: pair[0])
    if left > best.enough:
        return []
    said = f"{best.what}, which leaves {np.sqrt(left):.0%} of the error"
    if not best.sure:
        return [f"{said[0].upper()}{said[1:]}: {best.mend}"]
    raise InputError(Fault(str(problem.campaign.path), said, best.mend))


def _mistakes(problem: Problem) -> Iterator[Mistake]:
    yield from _gravity(problem)
    c = problem.campaign

    def stated(**poses: Array) -> Problem:
        return replace(problem, campaign=c.with_poses(**poses))

    used = np.unique(c.poses.payload)
    for order in permutations(used.tolist()) if 2 <= len(used) <= MOST else ():
        carried = np.array(order)[np.searchsorted(used, c.poses.payload)]
        if (carried == c.poses.payload).all():
            continue
        said = ", ".join(
            f"{called(c.payload_names[b])} where {called(c.payload_names[a])} is written"
            for a, b in zip(used, order, strict=True)
            if a != b
        )
        mend = "exchange the payloads' masses, or their names at the poses"
        yield Mistake(f"payload: the arm yields as under {said}", mend, stated(payload=carried), AGAINST)
    wrench = c.poses.wrench
    if not wrench.any():
        return
    what = "fx ... mz: the arm yields as under wrenches"
    turn = problem.rigid.R[-1]
    of_flange = np.concatenate(
        [(turn @ part[..., None])[..., 0] for part in (wrench[:, :3], wrench[:, 3:])], axis=1
    )
    for sign, opposite in ((1.0, ""), (-1.0, " the other way round")):
        there = f"{what} along the flange's axes{opposite}"
        mend = "give what acts on the robot, along the axes of its base"
        yield Mistake(there, mend, stated(wrench=sign * of_flange), ALONG)
    mend = "turn their signs: they are what acts on the robot, not what it does"
    yield Mistake(f"{what} the other way round", mend, stated(wrench=-wrench), AGAINST)
    for size, unit in UNITS.items():
        for factor, mistaken in ((size, unit), (1 / size, " for ".join(reversed(unit.split(" for "))))):
            mend = f"were {mistaken} written? If not, all that is stated to yield does so otherwise"
            many = f"{what} {factor:.3g} times as large"
            yield Mistake(many, mend, stated(wrench=factor * wrench), SO_LARGE, sure=False)


def _gravity(problem: Problem) -> Iterator[Mistake]:
    """Gravity the other way round, and along the base's axes that it is not stated to be along."""
    g = problem.arm.gravity
    size = float(np.linalg.norm(g))
    ways = [way for way in size * np.vstack([np.eye(3), -np.eye(3)]) if np.abs(way @ g) < COSINE * size**2]
    for way in [-g, *ways] if size else ():
        there, here = (" ".join(f"{value:.2f}" for value in vector + 0.0) for vector in (way, g))
        what = f"gravity: the arm yields as under {there} m/s² on the base's axes, not {here}"
        mend = "say in the robot's TOML which way is down: `gravity`; on a ceiling or a wall it is another"
        yield Mistake(what, mend, replace(problem, arm=replace(problem.arm, gravity=way)), ALONG)


def _left(result: Fit, problem: Problem) -> float:
    """Squares that the fit leaves, to first order, where the loads are those of another problem."""
    normal = result.normal
    try:
        points = result.at(problem)
    except ArithmeticError:
        return np.inf
    moved = np.where(problem.seen[..., None], result.line.prediction.points - points, 0.0)
    by_points = result.whitener[:, :, : moved[0].size]
    r = (result.r + np.matmul(by_points, moved.reshape(len(moved), -1, 1))[..., 0]).ravel()
    if not np.isfinite(r).all():
        return np.inf
    again = replace(normal, r=r, g=(normal.J.T @ r) * normal.prior - normal.offset)
    return float(r @ r + normal.offset @ normal.offset - again.gain(again.step(0.0).change))
