"""Do these joints, points and this robot belong together? Asked before anything is fitted to explain them.

The nominal robot is placed so that it explains the points best, rigid as it is. What then is left is a few
thousandths of the spread of the points for the usual robot. Where more is left, the usual mistakes are undone
one by one, and one that brings the rest back to the usual is named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from ...campaign.problem import Problem
from ...campaign.standing_still import stands_still
from ...effects.base import short
from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from .conventions import counted_otherwise
from .exchanged import exchanged_names
from .hypotheses import LEFT_HANDED, Hypothesis, hypotheses, placed_elsewhere
from .in_part import Part, in_part, not_fitting
from .inaccurate import FARTHEST_TURN, inaccurate
from .misfit import BOUND, USUAL, Misfit, Sample, misfit, sample
from .turned_otherwise import turned_otherwise

FEWEST = 8  # poses: with fewer, frame and targets explain too much for a judgement
SUSPECT = 0.005  # of the spread, from which mistakes are looked for: honest campaigns mostly keep below
REFUSED = 0.02  # from which no campaign is accepted: a robot off by 1 mm and 1 mrad everywhere has 0.009
COARSE = 0.035  # to which robots go that are driven by cables, or put together by hand
SMALL = 1e-3  # m, misfit below which a campaign of small motions is not refused
CLEARER = 0.25  # of the misfit at most is left where the right mistake was undone
RIGHT = 0.012  # of the spread at most, then
SCALE = 0.02  # from which another size is no error of an instrument
ROUGHLY = 6  # iterations in which the
LIKELY = 12  # likeliest mistakes are told from the others
WITHIN = np.radians(1.0)  # rad or m, beyond a joint's limit that is none
HEAVY = 2.0  # times the moving links: no arm carries that
AS_GOOD = 1.3  # times the best misfit: mistakes that the data do not tell apart


Mistake = tuple[Hypothesis, ...]


@dataclass(frozen=True)
class Plausible:
    """misfit: of the robot as it is; mistakes: one or two at once that explain it, the likeliest first, each
    with what it leaves; scale: without these, how much larger the points are than the robot; zero: without
    these, a joint and how far its zero is off [rad], where that alone explains it; geometry: without these,
    how far the geometry is off, where that explains it; part: the poses that alone do not fit, if not all;
    strays: targets without which the others fit, where no majority of the points tells which are wild."""

    misfit: Misfit
    mistakes: tuple[tuple[Mistake, float], ...] = ()
    scale: float = 1.0
    zero: tuple[str, float] | None = None
    geometry: str | None = None
    part: str | None = None
    strays: tuple[int, ...] = ()

    @property
    def refused(self) -> bool:
        """The points are not of this robot in these poses, whatever the reason."""
        m = self.misfit
        off = m.middle > REFUSED and m.middle * m.spread > SMALL
        fitted = self.zero is not None or self.geometry is not None
        return bool(self.mistakes) or bool(self.strays) or (off and not fitted) or self.scale != 1.0


def believed(problem: Problem) -> tuple[Problem, list[str]]:
    """The problem with its targets where they are meant to be; remarks on loads, a joint's zero or stated
    places of targets that are wrong. Raises InputError where joints, points and robot do not belong together,
    with the mistake if one of the usual explains it."""
    placed, said = _placed(problem)
    return placed, [*_too_heavy(problem), *said]


def _too_heavy(problem: Problem) -> list[str]:
    """A remark on loads that no such arm carries: they are stated in another unit, or its links are."""
    load, arm = float(problem.loads.mass.max(initial=0.0)), float(problem.arm.mass[1:].sum())
    if not problem.arm.weighed or load <= HEAVY * arm:
        return []
    return [
        f"Tool and payload weigh {load:g} kg, all moving links of the URDF together {arm:.3g} kg: is mass_kg "
        "in kilograms, and are the masses of the URDF no placeholders?"
    ]


def _placed(problem: Problem) -> tuple[Problem, list[str]]:
    """As `believed`, but for loads."""
    found = judge(problem)
    m, campaign = found.misfit, problem.campaign
    if found.zero is not None:
        joint, off = found.zero
        told = (
            f"{joint} stands {np.degrees(off):+.2f}° from where its numbers say: its zero is fitted. It may"
        )
        return problem, [f"{told} be mastered wrong, or a belt or gear is some teeth off."]
    if found.geometry is not None:
        return problem, [found.geometry]
    if not found.refused:
        far = f"Targets are found up to {_length(m.displaced * m.spread + USUAL)} from where the campaign "
        return problem, [far + "states them: the measured places are used."] if m.displaced else []
    if found.strays:
        raise InputError(Fault(f"{campaign.path}: points", *_stray(problem, found)))
    share = f"{short(100 * m.middle)} % of their spread"
    size = f"the points are {_length(m.middle * m.spread)} off the robot ({share})"
    if m.share <= SUSPECT:
        size = f"targets are {_length(m.displaced * m.spread)} from where they are stated"
    if not found.mistakes:
        raise InputError(Fault(str(campaign.path), *_nothing_fits(problem, size, found)))
    (best, left), *others = found.mistakes
    if best[0].table == "targets" and not any(target.fixed for target in campaign.targets):
        return _restated(problem, best[0]), [f"{best[0].what[0].upper()}{best[0].what[1:]}: {best[0].mend}."]
    alike = "; ".join(" and ".join(one.what for one in other) for other, _ in others[:3])
    alike = f" (or: {alike})" if alike else ""
    told = f": {size}; so mended, {short(100 * left)} %"
    raise InputError([Fault(f"{campaign.path}: {h.table}", h.what + told, h.mend + alike) for h in best])


def _restated(problem: Problem, mistake: Hypothesis) -> Problem:
    """The problem with the targets stated where they are without the mistake."""
    mended = mistake.undo(sample(problem))
    return problem.stating(dict(zip(mended.targets, mended.stated, strict=True)))


def judge(problem: Problem) -> Plausible:
    """The misfit, and mistakes that would explain it."""
    data = sample(problem)
    if len(data.rows) < FEWEST:
        return Plausible(Misfit())
    now = misfit(data)
    if now.total > SUSPECT:
        now = min(now, misfit(data, turns=True), key=lambda one: one.total)
    if now.total > SUSPECT:
        without = _without_a_bad_target(data, now)
        if without and now.middle > BOUND:
            return Plausible(now, strays=tuple(without))
        now = next(iter(without.values()), now)
    if now.total <= SUSPECT:
        return Plausible(now)
    every, enough = list(hypotheses(problem)), min(CLEARER * now.total, RIGHT)
    if now.middle <= REFUSED:  # most poses fit: of the others a mistake may have been made
        part = not_fitting(problem, data, enough)
        fits = _there(problem, data, part, every, enough) if part else ()
        if part and fits:
            return Plausible(now, fits, part=part.where)
    tried = _tried(data, every)

    def unexplained() -> bool:
        return _least(tried) > enough and now.middle > REFUSED

    if unexplained():
        tried = [((h,), misfit(h.undo(data)).total) for h in placed_elsewhere(data)]
    if unexplained():
        tried = [((h,), misfit(h.undo(data), turns=True).total) for h in turned_otherwise(problem, data)]
    if unexplained() and _scale(data, enough) == 1.0:
        # no mistake leaves so little as a coarse robot: what its geometry leaves is the robot's
        off = inaccurate(problem, data, np.inf if now.middle <= COARSE else enough)
        if off is not None:
            zero = _zero(problem, data, enough)
            return Plausible(now, zero=zero, geometry=None if zero else off)
    if unexplained():
        tried = [((h,), misfit(h.undo(data)).total) for h in exchanged_names(problem)]
    if unexplained():
        part = not_fitting(problem, data, enough)
        if part:
            return Plausible(now, _there(problem, data, part, every, enough), part=part.where)
    if unexplained():
        tried = [((h,), left) for h, left in counted_otherwise(problem, data, enough)]
    if unexplained():
        tried = _two_at_once(data, every, enough)
    if unexplained() and not np.isfinite(data.stated).all():
        tried = [((h,), misfit(h.undo(data), turns=True).total) for h in every]
    fits = _likeliest(problem, data, tried, enough)
    if fits or max(now.middle, now.displaced) < REFUSED:
        return Plausible(now, fits)
    scale = _scale(data, enough)
    zero = _zero(problem, data, enough) if scale == 1.0 and now.middle > REFUSED else None
    return Plausible(now, (), scale, zero)


def _likeliest(
    problem: Problem, data: Sample, tried: list[tuple[Mistake, float]], enough: float
) -> tuple[tuple[Mistake, float], ...]:
    """Mistakes that leave `enough` at most and that the data do not tell apart: those whose mend leaves the
    fewest joints beyond their limits, the simplest and best first."""
    lower, upper = problem.robot.limits.T

    def rank(one: tuple[Mistake, float]) -> tuple[bool, int, int, float]:
        mended = data
        for h in one[0]:
            mended = h.undo(mended)
        # another robot has its own limits
        beyond = (mended.q < lower - WITHIN) | (mended.q > upper + WITHIN)
        outside = int(beyond.any(axis=0).sum()) if mended.arm is data.arm else 0
        # what only changes the stated places is no reason to send anyone away
        return one[0][0].table != "targets", outside, sum(h.parts for h in one[0]), one[1]

    fits = [one for one in tried if one[1] <= min(enough, AS_GOOD * _least(tried))]
    ranked = sorted(((rank(one), one) for one in fits), key=lambda pair: pair[0])
    return tuple(one for order, one in ranked if order[:2] == ranked[0][0][:2])


def _there(
    problem: Problem, data: Sample, part: Part, every: Sequence[Hypothesis], enough: float
) -> tuple[tuple[Mistake, float], ...]:
    """The likeliest mistakes of a part of the poses."""
    return _likeliest(problem, data, _tried(data, list(in_part(problem, data, part, every))), enough)


def _zero(problem: Problem, data: Sample, enough: float) -> tuple[str, float] | None:
    """A joint and how far its zero is off [rad], where that alone explains the points."""
    best, arm = (enough, "", 0.0), problem.arm
    for j in np.flatnonzero(~arm.prismatic):
        one = np.eye(arm.n)[j]
        found = minimize_scalar(
            partial(_left_at, data=data, one=one), bounds=(-FARTHEST_TURN, FARTHEST_TURN), method="bounded"
        )
        shift = float(found.x)
        best = min(best, (misfit(data.changed(q=data.q + shift * one)).total, arm.names[j], shift))
    return (best[1], best[2]) if best[1] else None


def _left_at(shift: float, data: Sample, one: Array) -> float:
    """What is left, roughly, with a joint that stands farther by a shift; one: (n,) 1 at that joint."""
    return misfit(data.changed(q=data.q + shift * one), rounds=ROUGHLY).total


def _scale(data: Sample, enough: float) -> float:
    """How much larger the points are than the robot where that alone explains them, else 1."""
    free = misfit(data, turns=True, scale=True)
    size = float(np.median([placed.scale for placed in free.placed]))
    return size if free.total < enough and abs(size - 1) > SCALE else 1.0


def _tried(data: Sample, every: Sequence[Hypothesis]) -> list[tuple[Mistake, float]]:
    """What is left under the likeliest mistakes: all are tried roughly, these to the end."""
    rough = sorted(every, key=lambda h: misfit(h.undo(data), rounds=ROUGHLY).total)
    return [((h,), misfit(h.undo(data)).total) for h in rough[:LIKELY]]


def _least(tried: list[tuple[Mistake, float]]) -> float:
    return min((total for _, total in tried), default=np.inf)


def _two_at_once(data: Sample, every: list[Hypothesis], enough: float) -> list[tuple[Mistake, float]]:
    """Something with the joints or the robot, and points in another unit or a left-handed frame besides."""
    both: list[tuple[Mistake, float]] = []
    frames = [h for h in every if h.frame]
    for first in (h for h in every if h.table in ("poses", "robot")):
        undone = first.undo(data)
        for mirrored in (False, True):
            turned = LEFT_HANDED.undo(undone) if mirrored else undone
            if misfit(turned, scale=True, rounds=2 * ROUGHLY).share > enough:
                continue
            both += [((first, h), misfit(h.undo(undone)).total) for h in frames]
    return both


def _without_a_bad_target(data: Sample, now: Misfit) -> dict[int, Misfit]:
    """Targets of which one's points are of another world, with the misfit of the others: these are wild
    points, not a wrong robot. Several, where it may be any of them."""
    found = {}
    for i in range(len(data.on)) if len(data.on) > 1 and now.middle > SUSPECT / 10 else ():
        kept = [j for j in range(len(data.on)) if j != i]
        on = tuple(data.on[j] for j in kept)
        rest = misfit(data.changed(points=data.points[:, kept], stated=data.stated[kept], on=on))
        if rest.total < min(CLEARER * now.total, SUSPECT):
            found[data.targets[i]] = rest
    return found


def _stray(problem: Problem, found: Plausible) -> tuple[str, str]:
    """What is wrong and how to mend it where the points of one target are not those of the robot's."""
    first, *more = [problem.campaign.targets[i].name for i in found.strays]
    off = _length(found.misfit.middle * found.misfit.spread)
    if more:
        what = f"the points of {' and '.join([first, *more])} fit the robot, but not together ({off})"
        return what, "are they in one frame? mend the columns of one, or leave it out"
    if mend := stands_still(problem.campaign, found.strays[0]):
        return f"the points of {first} stand still while the arm moves", mend
    what = f"the points of {first} do not fit the robot that the others fit ({off})"
    return (
        what,
        f"are its x, y, z those of a target, in the instrument's frame? mend them, or leave {first} out",
    )


def _nothing_fits(problem: Problem, size: str, found: Plausible) -> tuple[str, str]:
    """What is wrong and how to mend it where none of the usual mistakes explains it."""
    robot, scale = problem.robot, found.scale
    if found.part is not None:
        what = f"{size}: {found.part} do not fit the robot, all others do, and no usual mistake explains it"
        return (
            what,
            "mend what changed there (joints, rows, units, tool, instrument), or leave these poses out",
        )
    if scale != 1.0:
        what = f"{size}; they fit a robot of {scale:.4g} times its size: a wrong unit, or another robot"
        return what, f"check the unit of the points, and that this robot is the {robot.title}"
    what = (
        f"{size}, and none of the usual mistakes (units, signs, order, zeros, coupling, frames) explains it"
    )
    if by := _sorted_by(problem):
        what = f"{what}; the rows are sorted by {by}"
        return what, "if a table was sorted by some of its columns alone, take it as it was before"
    return what, f"is this robot the {robot.title}, and does each point belong to the pose that it names?"


def _sorted_by(problem: Problem) -> str | None:
    """A column whose numbers never fall, or never rise, from pose to pose: not by chance."""
    points = {
        f"{axis} of {target.name}": problem.campaign.points[:, i, k]
        for i, target in enumerate(problem.campaign.targets)
        for k, axis in enumerate("xyz")
    }
    joints = {f"q{j + 1}": column for j, column in enumerate(problem.q.T)}
    for name, column in (joints | points).items():
        steps = np.diff(column[np.isfinite(column)])
        if np.count_nonzero(steps) >= FEWEST and ((steps >= 0).all() or (steps <= 0).all()):
            return name
    return None


def _length(length: float) -> str:
    return f"{length * 1e3:.3g} mm" if length < 1.0 else f"{length:.3g} m"
