"""Wild points, swapped and frozen targets: found, mended or left out, and named.

First what is grossly off once the rigid robot was placed, so that no fit ever sees it (`without_gross`);
then, on a robust fit of the geometry, what is off by several times the noise (`clean`); and once more beside
the causes that were found, since what these explain hides what is less far off (`wild_beside`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...effects.base import Effect
from ...files.faults import Fault, InputError
from ...identification.fit import ROUGH, Fit, fit
from ...identification.model import Model, State
from ...identification.noise import Covariance
from ...identification.registration import register, spread_of
from ...robot.kinematics import Array
from ..found import FaultFound
from .off_together import no_outliers
from .other_loads import Predicts, carrying_what_fits
from .other_wrenches import pulled_as_fits
from .shifted_poses import shifted_poses, without_shifted

WILD = 6.0  # robust standard deviations per axis from which a point is wild
MIDDLE = 1.538  # the median of a 3-D normal's length, in its standard deviations per axis
NEIGHBOURS = 31  # poses that are next in a joint's angle
MANY = 2.0  # times the usual distance: half of the neighbours are off by more
ROUNDS = 6  # of a fit and a cleaning: what is farthest off goes first
GROSS = 10.0  # times what most points are off the rigid robot: no robot that is only inaccurate has that,
GROSS_SHARE = 0.1  # and of the spread of the points
FARTHEST = 1e6  # m, rad
MOST = 0.3  # of the points at least are right
ROUTINE = 0.1  # of the points: so many gross errors happen in good data (Hampel et al. 1986)
MAJORITY = 0.5  # of the points: without it nothing says which are right, and what they do is no fault

Acting = tuple[tuple[Effect, Array], ...]


@dataclass(frozen=True)
class Cleaned:
    """The problem without its data faults, the fit that showed them, and what was found."""

    problem: Problem
    fit: Fit
    faults: tuple[FaultFound, ...]


def clean(result: Fit, noise: Covariance, known_effects: Acting, least: Array) -> Cleaned:
    """Finds data faults and mends them or leaves the points out, from a `robust_fit`. least: (N, T) [m] one
    sigma per axis that a point has in any case: what is within it is not wild."""
    return _in_rounds(result, least, lambda problem, at: robust_fit(problem, at, noise, known_effects))


def wild_beside(result: Fit, least: Array) -> Cleaned:
    """The same beside the causes of a fit."""
    model, noise = result.model, result.noise
    return _in_rounds(
        result, least, lambda problem, at: fit(replace(model, problem=problem), at, noise, tolerance=ROUGH)
    )


def _in_rounds(result: Fit, least: Array, again: Callable[[Problem, State], Fit]) -> Cleaned:
    """What is wild at a fit, then at the fit without it, and so on."""
    problem, faults = result.model.problem, list[FaultFound]()
    for count in range(ROUNDS):
        if count:
            result = again(problem, result.state)
        found = mended(problem, result.line.prediction.points, _limit(result, least), result.at)
        if not found.faults:
            break
        problem, faults = found.problem, [*faults, *found.faults]
    return Cleaned(problem, result, tuple(faults))


def _limit(result: Fit, least: Array) -> Array:
    """(N, T) distance [m] from which a point is wild; infinite of poses that are off as a cause has it."""
    length = np.linalg.norm(result.residual, axis=2)
    limit = wild_limit(result.model.problem, length, least)
    limit[no_outliers(result, np.asarray((length > limit).any(axis=1)))] = np.inf
    return limit


def robust_fit(problem: Problem, start: State, noise: Covariance, known_effects: Acting) -> Fit:
    """Geometry fit in which a pose counts less the farther it is off (weights of Student's t, 4 dof)."""
    model = Model(problem, (), known_effects)
    line = model.linearise(start)
    off = np.where(problem.seen[..., None], problem.campaign.points - line.prediction.points, 0.0)
    size = np.sqrt((off**2).sum(axis=(1, 2)) / np.maximum(problem.seen.sum(axis=1), 1))
    counted = np.asarray(problem.seen.any(axis=1))
    weight = _student(size, counted, noise.weight)
    for _ in range(6):
        weighed = replace(noise, weight=weight)
        result = fit(model, start, weighed, tolerance=ROUGH, max_iterations=12, line=line)
        start, line = result.state, result.line
        new = _student(_pose_size(result, weight), counted, noise.weight)
        if float(np.abs(new - weight).max()) < 0.02:
            break
        weight = new
    return result


def _student(size: Array, counted: NDArray[np.bool_], weight: Array) -> Array:
    """(N,) weights of poses of which each is off by `size`; 4 degrees of freedom."""
    scale = float(np.median(size[counted])) + 1e-12 if counted.any() else 1.0
    return np.asarray(weight * np.sqrt(5 / (4 + (size / scale) ** 2)))


def _pose_size(result: Fit, weight: Array) -> Array:
    """(N,) rms of the whitened residual of each pose, weights taken out."""
    r = result.point_residual
    rows = np.maximum((np.abs(result.whitener[:, : r.shape[1]]).sum(axis=2) > 0).sum(axis=1), 1)
    size = np.sqrt((r**2).sum(axis=1) / rows)
    return np.asarray(size / np.where(weight > 0, weight, 1.0))


def wild_limit(problem: Problem, length: Array, least: Array) -> Array:
    """(N, T) distance [m] from which a point is wild. length: (N, T) [m] how far each is off, NaN where not
    seen: its robust scale per target counts, or that of its neighbours where many of them are off, or of its
    campaign where that alone states no noise, but no less than `least` (N, T) or (T,) [m], one sigma per
    axis."""
    middle = np.broadcast_to(_middle(length), length.shape).copy()
    for here in problem.campaign.of_silent.values():
        middle[here] = np.maximum(middle[here], _middle(length[here]))
    sigma = np.maximum(np.maximum(middle, _where_many_are_off(problem, length)) / MIDDLE, least)
    return np.asarray(WILD * np.sqrt(3) * sigma)


def _middle(length: Array) -> Array:
    """(T,) median of lengths (N, T) that are finite; infinite where none is."""
    columns = [column[np.isfinite(column)] for column in length.T]
    return np.array([np.median(column) if len(column) else np.inf for column in columns])


def _where_many_are_off(problem: Problem, length: Array) -> Array:
    """(N, T) median distance [m] of a point's neighbours in the angle of one joint, or of the points with its
    load, where these are off as well: what clusters there comes of the robot. 0 where they are not. Where a
    joint's range ends the neighbours are on one side, and the point counts once. The order in time counts for
    nothing here: an instrument that is disturbed for a while is no robot."""
    out, q = np.zeros(length.shape), problem.q
    chance = np.random.default_rng(len(q)).permutation(len(q))  # decides among equal angles
    for i, column in enumerate(length.T):
        seen = chance[np.isfinite(column[chance])]
        if len(seen) < 2 * NEIGHBOURS:
            continue
        usual = float(np.median(column[seen]))
        near = np.zeros(len(q))
        for angle in q.T:
            order = seen[np.argsort(angle[seen], kind="stable")]
            near[order] = np.maximum(near[order], _median_around(column[order]))
        for load in np.unique(problem.campaign.poses.payload[seen]):
            same = seen[problem.campaign.poses.payload[seen] == load]
            if len(same) >= NEIGHBOURS:
                near[same] = np.maximum(near[same], np.median(column[same]))
        out[:, i] = np.where(near > MANY * usual, near, 0.0)
    return out


def _median_around(column: Array) -> Array:
    """(N,) median of each number and its neighbours; where the column ends, of those on one side, twice."""
    around = np.pad(column, NEIGHBOURS // 2, mode="reflect")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(around, NEIGHBOURS), axis=1))


def least_sigma(problem: Problem, noise: Covariance | None) -> Array:
    """(N, T) one sigma per axis [m] of a usual point of its campaign, 0 where no noise is known."""
    least, of = np.zeros(problem.seen.shape), problem.campaign.of_campaign
    if noise is not None:
        for k in np.unique(of):
            least[of == k] = np.median(noise.sigma[of == k], axis=0)
    return least


@dataclass(frozen=True)
class Mended:
    """The problem with points put right or left out, and which."""

    problem: Problem
    faults: tuple[FaultFound, ...]


def mended(problem: Problem, predicted: Array, limit: Array, at: Predicts | None = None) -> Mended:
    """One round: points farther than `limit` (N, T) [m] from where they are predicted (N, T, 3) are taken
    under another payload or wrench, or exchanged with those of another target, where that puts them right,
    else left out. at: predicts them under other loads."""
    if at is not None:
        carrying, wrong = carrying_what_fits(problem, predicted, limit, at)
        if wrong:
            return Mended(carrying, wrong)
        pulled, wrong = pulled_as_fits(problem, predicted, limit, at)
        if wrong:
            return Mended(pulled, wrong)
    c = problem.campaign
    length = np.where(problem.seen, np.linalg.norm(c.points - predicted, axis=2), 0.0)
    wild = length > limit
    if not wild.any():
        return Mended(problem, ())
    usual = float(np.median(length[problem.seen]))
    points, faults = c.points.copy(), []
    # the worst first: a wild point pulls its neighbours, so only what is near the worst goes now
    worst = np.max(np.where(wild, length, 0.0) / limit, axis=1)
    for n in np.flatnonzero(worst > max(1.0, 0.25 * float(worst.max()))):
        order = _swap(predicted[n], c.points[n], limit[n])
        if order is not None:
            points[n] = points[n][list(order)]
            names = [c.targets[i].name for i in range(len(order)) if order[i] != i]
            faults.append(
                FaultFound(
                    "swapped_target",
                    c.poses.ids[n],
                    " and ".join(names),
                    "targets exchanged",
                    "exchanged back",
                )
            )
            continue
        for i in _leave_out(c, points[n], wild[n], length[n]):
            what = f"{millimetres(length[n, i])} off, others typically {millimetres(usual)}"
            faults.append(FaultFound("outlier", c.poses.ids[n], _name(c, i), what, "left out"))
    return Mended(replace(problem, campaign=replace(c, points=points)), tuple(faults))


def _leave_out(c: Campaign, points: Array, wrong: NDArray[np.bool_], size: Array | float = 1.0) -> list[int]:
    """Takes the wrong ones (T,) out of a pose's points (T, 3), all of a 6-D measurement. Returns which are
    told: each; of a 6-D measurement that of the largest size (T,)."""
    if not c.six_dof:
        points[wrong] = np.nan
        return np.flatnonzero(wrong).tolist()
    points[:] = np.nan
    return [int(np.argmax(np.where(wrong, size, -np.inf)))]


def _name(c: Campaign, i: int) -> str | None:
    """Whose a wrong point is, where that has to be said."""
    return None if c.six_dof or len(c.targets) == 1 else c.targets[i].name


def millimetres(length: float) -> str:
    """A length [m] for people."""
    return f"{length * 1e3:.2f} mm" if length < 10.0 else f"{length:.4g} m"


def _swap(predicted: Array, points: Array, limit: Array) -> Sequence[int] | None:
    """The order of the targets (T, 3) that makes a pose fit; None when no exchange does."""
    n_targets = len(points)
    if n_targets < 2 or n_targets > 5 or not np.isfinite(points).all():
        return None
    for order in permutations(range(n_targets)):
        if list(order) == list(range(n_targets)):
            continue
        if (np.linalg.norm(points[list(order)] - predicted, axis=1) < limit).all():
            return order
    return None


def without_gross(problem: Problem) -> Mended:
    """Without points that are off the placed rigid robot by more than any robot is: before anything is
    fitted."""
    frozen = _frozen(problem)
    problem = frozen.problem
    predicted, length, limit = _off_the_rigid(problem)
    target = _wild_targets(problem, length, limit)
    if target.faults:
        problem = target.problem
        predicted, length, limit = _off_the_rigid(problem)
    shifted = shifted_poses(problem, predicted, length, limit)
    problem = without_shifted(problem, shifted)
    gross = mended(problem, predicted, limit)
    faults = [*frozen.faults, *target.faults, *shifted, *gross.faults]
    for _ in range(ROUNDS):  # those that the worst ones hid
        if not gross.faults:
            break
        gross = mended(gross.problem, predicted, limit)
        faults += gross.faults
    return Mended(gross.problem, tuple(faults))


def _off_the_rigid(problem: Problem) -> tuple[Array, Array, Array]:
    """Points (N, T, 3) of the placed rigid robot, how far the measured ones are off (N, T; NaN: not seen) and
    the limit (N, T) of what an inaccurate robot may be off [m]."""
    R, t, targets = register(problem)
    setup = problem.campaign.poses.setup
    every = np.stack([problem.rigid.points(places, problem.on) for places in targets])
    base = every[setup, np.arange(len(setup))]
    predicted = np.einsum("nij,ntj->nti", R[setup], base) + t[setup][:, None]
    length = np.where(problem.seen, np.linalg.norm(problem.campaign.points - predicted, axis=2), np.nan)
    limit = np.full(length.shape, np.inf)
    moving = np.array(problem.on) > 0
    for k in np.unique(setup):
        off = length[setup == k][:, moving]
        off = off[np.isfinite(off)]
        if len(off):
            spread = spread_of(base[setup == k][:, moving].reshape(-1, 3))
            limit[setup == k] = max(GROSS * float(np.quantile(off, MOST)), GROSS_SHARE * spread)
    return predicted, length, limit


def without_impossible(problem: Problem) -> Mended:
    """Without what no instrument shows and no joint does: points at exactly 0 0 0, which instruments write
    where they saw nothing, half-written ones, distances and joints beyond all measure."""
    c = problem.campaign
    some, whole = np.isfinite(c.points).any(axis=2), np.isfinite(c.points).all(axis=2)
    with np.errstate(invalid="ignore"):
        far = some & (np.abs(c.points) > FARTHEST).any(axis=2)
    points, faults = c.points.copy(), []
    for kind, what in (
        (some & ~whole, "a coordinate is missing"),
        ((c.points == 0.0).all(axis=2), "exactly 0 0 0: not seen"),
        (far, f"farther than {FARTHEST / 1e3:g} km"),
    ):
        wrong = np.asarray(kind)
        for n in np.flatnonzero(wrong.any(axis=1)):
            for i in _leave_out(c, points[n], wrong[n]):
                faults.append(FaultFound("outlier", c.poses.ids[n], _name(c, i), what, "left out"))
    possible = np.asarray((np.abs(c.poses.q) <= FARTHEST).all(axis=1))
    for n in np.flatnonzero(~possible):
        faults.append(FaultFound("outlier", c.poses.ids[n], None, "a joint beyond all measure", "left out"))
    if not faults:
        return Mended(problem, ())
    c = replace(c, points=points).some(np.flatnonzero(possible))
    return Mended(replace(problem, campaign=c), tuple(faults))


def much_left_out(measured: Problem, left: Problem) -> list[str]:
    """A remark where more of the measured points are left out than is usual. Raises InputError where most
    are."""
    every, count = int(measured.seen.sum()), int(measured.seen.sum() - left.seen.sum())
    if count <= ROUTINE * every:
        return []
    said = f"{count} of {every} points ({count / every:.0%}) do not fit the robot that the others fit"
    if count > MAJORITY * every:
        mend = "look at joints, rows, units, tool and instrument of those poses"
        raise InputError(Fault(str(measured.campaign.path), f"{said}: which are right is not told", mend))
    return [f"{said}, and are left out. All that is said here is of the others: look for one reason first."]


def _wild_targets(problem: Problem, length: Array, limit: Array) -> Mended:
    """Without targets most of whose points are grossly off while another's are not."""
    c = problem.campaign
    wild = np.where(problem.seen, length > limit, False).sum(axis=0) / np.maximum(problem.seen.sum(axis=0), 1)
    if wild.max() < 0.5 or wild.min() > 0.1:
        return Mended(problem, ())
    points, faults = c.points.copy(), []
    for i in np.flatnonzero(wild >= 0.5):
        what = f"{wild[i]:.0%} of its points are grossly off, those of other targets are not"
        faults.append(FaultFound("outlier", None, c.targets[i].name, what, "all its points left out"))
        points[:, i] = np.nan
    return Mended(replace(problem, campaign=replace(c, points=points)), tuple(faults))


def _frozen(problem: Problem) -> Mended:
    """Points that repeat the pose before to the last digit although the joints have moved. A target most of
    whose points do so is held where it is, as a ball in a socket."""
    c = problem.campaign
    wrong = np.zeros(c.points.shape[:2], dtype=bool)
    expected = problem.rigid.points(np.nan_to_num(problem.stated_targets), problem.on)
    for t in np.flatnonzero(problem.on):
        still = np.all(np.abs(np.diff(c.points[:, t], axis=0)) < 1e-9, axis=1)
        moved = np.linalg.norm(np.diff(expected[:, t], axis=0), axis=1) > 1e-3
        if still.any() and still.mean() < MAJORITY:
            wrong[1:, t] = still & moved
    if not wrong.any():
        return Mended(problem, ())
    points, faults = c.points.copy(), []
    for n in np.flatnonzero(wrong.any(axis=1)):
        for i in _leave_out(c, points[n], wrong[n]):
            name = None if c.six_dof else c.targets[i].name
            what = "same numbers as the pose before"
            faults.append(FaultFound("frozen_target", c.poses.ids[n], name, what, "left out"))
    return Mended(replace(problem, campaign=replace(c, points=points)), tuple(faults))
