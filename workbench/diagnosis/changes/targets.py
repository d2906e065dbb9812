"""Where the targets sit, at one campaign against the first; and those that moved as one body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from ...robot.kinematics import Arm, Array
from ...robot.rotations import body_jacobian
from .covered import carried
from .found import TargetMoved, TargetsMoved, Together
from .occasions import Occasion
from .system import Solved, System

LEVEL = 1e-4  # of the test whether targets moved
GROWTH = 1e-3  # of its length: what aluminium grows by where it is 40 K warmer
SURE = 2.0  # standard deviations that a change may be less by
SAME = 1e-7  # m: stated places that are one


@dataclass(frozen=True, eq=False)
class _Target:
    """slot: behind which it sits; place, stated: (3,) [m] in its frame; part: its own columns of the
    occasion, None where it is fixed."""

    name: str
    slot: int
    place: Array
    stated: Array
    part: NDArray[np.int64] | None


def targets_moved(
    system: System,
    final: Sequence[Occasion],
    solved: Solved,
    k: int,
    without: Sequence[Array],
    hidden: Sequence[str],
) -> TargetsMoved:
    """Targets that occasion k and the first have in their first set-ups. without: of either, by how much all
    numbers move without each of its parts; hidden: joints whose zero may as well be a move of the targets."""
    there = {(target.name, target.slot): target for target in _own(final[k])}
    pairs = [(a, there[a.name, a.slot]) for a in _own(final[0]) if (a.name, a.slot) in there]
    found = list[TargetMoved]()
    arm = final[k].problem.arm
    for a, b in pairs:
        change, half = b.place - a.place, _difference(system, solved, k, [(a, b)], without)
        stated = np.nan_to_num(b.stated - a.stated)
        found.append(
            TargetMoved(
                a.name,
                _mm(change),
                _mm(np.linalg.norm(half, axis=1)),
                _off(change, half, len(pairs)),
                _mm(stated) if np.abs(stated).max() > SAME else None,
                not _off(change - stated, half, len(pairs)),
                _link(arm, a.slot),
                _may_be_warm(a.place, change, half),
            )
        )
    together = list[Together]()
    for slot in dict.fromkeys(a.slot for a, _ in pairs):
        own = [n for n, (a, _) in enumerate(pairs) if a.slot == slot]
        moved = any(found[n].moved and not found[n].restated for n in own)
        if moved and len(own) > 1 and all(part is not None for n in own for part in (pairs[n][0].part,)):
            half = _difference(system, solved, k, [pairs[n] for n in own], without)
            together += _together(arm, [pairs[n] for n in own], half, hidden)
    return TargetsMoved(tuple(found), tuple(together))


def _together(
    arm: Arm, pairs: Sequence[tuple[_Target, _Target]], half: Array, hidden: Sequence[str]
) -> Iterator[Together]:
    """The targets of one link, where what they moved by is the motion of one body; with the joint at that
    link whose zero would move them so, if it is among the `hidden`. half: as of `_difference`."""
    places = np.array([a.place for a, _ in pairs])
    change = np.concatenate([b.place - a.place for a, b in pairs])
    body = body_jacobian(places - places.mean(axis=0)).reshape(-1, 6)
    rank = int(np.linalg.matrix_rank(body))
    if _rest(body, change, half)[0] > chi2.isf(LEVEL, len(change) - rank):
        return
    slot = pairs[0][0].slot
    joint, axis, origin = _joint_at(arm, slot)
    turn = np.cross(axis, places - origin).reshape(-1, 1)
    left, angle, std = _rest(turn, change, half)
    about = joint in hidden and left <= chi2.isf(LEVEL, len(change) - 1)
    names = tuple(a.name for a, _ in pairs)
    yield Together(
        _link(arm, slot), names, joint if about else None, 1e3 * abs(angle) if about else 0.0, 1e3 * std
    )


def _rest(A: Array, change: Array, half: Array) -> tuple[float, float, float]:
    """χ² of a change (m,) that motions A (m, p) leave, and the last of their sizes with its one sigma."""
    W = np.linalg.pinv(half)
    N = np.linalg.pinv((W @ A).T @ (W @ A))
    size = N @ (W @ A).T @ (W @ change)
    return float(((W @ (change - A @ size)) ** 2).sum()), float(size[-1]), float(np.sqrt(N[-1, -1]))


def _joint_at(arm: Arm, slot: int) -> tuple[str, Array, Array]:
    """The joint nearest to the frame behind a slot, and its axis and a point of it there: the first for the
    base, else the last before it."""
    z = np.eye(3)[2]
    if slot == 0:
        return arm.names[0], arm.R[1] @ z, arm.p[1]
    if slot <= arm.n:
        return arm.names[slot - 1], z, np.zeros(3)
    return arm.names[-1], arm.R[slot].T @ z, -arm.R[slot].T @ arm.p[slot]


def _off(change: Array, half: Array, tests: int) -> bool:
    """Whether a change (3,) is none by chance, in one of so many tests."""
    if not half.any():
        return bool(np.abs(change).max() > SAME)
    return bool(((np.linalg.pinv(half) @ change) ** 2).sum() > chi2.isf(LEVEL / tests, len(change)))


def _may_be_warm(place: Array, change: Array, half: Array) -> bool:
    """Whether what carries a target from its link's frame may have grown by as much as surely changed."""
    sure = float(np.linalg.norm(change)) - SURE * float(np.linalg.norm(half))
    return sure < GROWTH * float(np.linalg.norm(place))


def _difference(
    system: System,
    solved: Solved,
    k: int,
    pairs: Sequence[tuple[_Target, _Target]],
    without: Sequence[Array],
) -> Array:
    """(3m, ·) half of the covariance of the targets' places at occasion k minus those at the first [m]: by
    the noise, carried to postures that only one of them has, and where that is too sure by as much as parts
    of either occasion say (jackknife: Efron & Stein 1981)."""

    def numbers(x: Array, of: int, part: NDArray[np.int64] | None) -> Array:
        if part is None:
            return np.zeros((3, x.shape[1]))
        at = system.local[of].start + part
        return np.asarray(x[at] * system.prior[at, None])

    def difference(x: Array) -> Array:
        return np.concatenate([numbers(x, k, b.part) - numbers(x, 0, a.part) for a, b in pairs])

    half = carried(system, k, [0]) * solved.factor * difference(solved.half)
    if not half.any():
        return half
    W = np.linalg.pinv(half)
    more = 0.0
    for each in (difference(one.T) for one in without):
        parts = each.shape[1]
        off = each - each.mean(axis=1, keepdims=True)
        more += (parts - 1) / parts * float(((W @ off) ** 2).sum()) / len(half)
    return half * np.sqrt(max(1.0, more))


def _own(one: Occasion) -> Iterator[_Target]:
    """Each target of the first set-up; a 6-D body by its middle. Names as the campaign has them: joined with
    others that state another place, they carry its label."""
    problem, places, stated = one.problem, one.fit.state.targets[0], one.problem.stated_targets
    fitted = {i: np.arange(part.start, part.start + 3) for k, i, part in one.fit.columns.targets if k == 0}
    if None in fitted:
        yield _Target("body", max(problem.on), places.mean(axis=0), stated.mean(axis=0), fitted[None])
        return
    here = problem.seen[problem.campaign.poses.setup == 0].any(axis=0)
    for i in np.flatnonzero(here).tolist():
        name = problem.campaign.targets[i].name.removesuffix(f" ({one.label})")
        yield _Target(name, problem.on[i], places[i], stated[i], fitted.get(i))


def _link(arm: Arm, slot: int) -> str:
    """As a campaign calls the link that carries a target."""
    return "base" if slot == 0 else "flange" if slot > arm.n else arm.links[slot]


def _mm(value: Array) -> tuple[float, float, float]:
    x, y, z = (1e3 * value).tolist()
    return x, y, z
