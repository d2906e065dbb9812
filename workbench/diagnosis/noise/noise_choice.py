"""Which noise the tests use: stated, measured from repeats, or, where there is neither, the residual's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import chdtrc

from ...campaign.problem import Problem
from ...identification.fit import Fit
from ...identification.model import Linearisation
from ...identification.noise import (
    FEWEST_DOF,
    LEAST,
    Covariance,
    MeasuredNoise,
    body_motion,
    measure_noise,
    repeat_chi2,
    stated_noise,
)
from ...identification.repeats import repeat_groups, within
from ...robot.kinematics import Array
from ..found import Noise
from ..priors import PRIORS
from .distances import Shown, shown_by_distances
from .likeliest import with_more
from .six_dof import of_poses, of_repeats

BELIEVED_DOF = 60  # degrees of freedom from which measured noise stands in for stated noise

SILENT = "Taken for noise where none is stated"  # how a remark begins
RIGID = 0.1  # of the noise: measured targets change their distances by more
WILD_REPEAT = 15.0  # times the usual deviation from the mean of its repeats: no noise


def provisional(problem: Problem) -> Covariance:
    """A first guess for the geometry fit where no noise is stated: only its ratios matter."""
    return Covariance(np.full(problem.seen.shape, 1e-4), np.zeros(problem.arm.n), np.ones(len(problem.q)))


def choose(problem: Problem, line: Linearisation) -> tuple[Covariance, Noise, list[str]]:
    """Noise before the residual is seen: stated or measured; else provisional, source "residual"."""
    axial = line.by_joint
    said = stated_noise(problem)
    notes = _too_fine(problem)
    if problem.campaign.six_dof and (repeated := of_repeats(problem, line)) is not None:
        covariance, noise, said_so = _of_repeated_poses(said, repeated)
        return covariance, noise, [*notes, *said_so]
    measured = None if problem.campaign.six_dof else measure_noise(problem, axial)
    if measured is not None and (said is None or measured.dof >= BELIEVED_DOF):
        if said is not None:
            disagree = _disagree(problem, said, measured, axial)
            if disagree is None:
                return said, _figures(said, "stated", axial, measured), notes
            notes.append(disagree)
        shots = np.maximum(problem.campaign.shots, 1)
        found = Covariance(
            measured.sigma / np.sqrt(shots), measured.joint, np.ones(len(problem.q)), dof=measured.dof
        )
        return found, _figures(found, "repeats", axial, measured), notes
    if said is not None:
        found, more = _at_least_of_distances(problem, said)
        if more:
            return found, _figures(found, "repeats", axial, None), [*notes, *more]
        return said, _figures(said, "stated", axial, measured), notes
    shown_by_rows = _of_rows(problem)
    if shown_by_rows is not None:
        return *shown_by_rows, notes
    return provisional(problem), Noise(0.1, "residual"), notes


def _of_repeated_poses(said: Covariance | None, found: Covariance) -> tuple[Covariance, Noise, list[str]]:
    """Noise of a 6-D measurement whose poses were repeated: its shifts as stated, where these agree or few
    were repeated, and its turns as they scatter."""
    shown = f"repeated poses scatter by {1e3 * found.usual:.4f} mm per axis"
    if said is not None:
        chi2 = found.dof * (found.usual / said.usual) ** 2
        agree = 1e-4 < chdtrc(found.dof, chi2) < 1 - 1e-4
        if agree or found.dof < BELIEVED_DOF:
            kept = replace(said, turn_ratio=found.turn_ratio * found.usual / said.usual)
            words = f"{1e3 * said.usual:.4f} mm per axis, as stated in the campaign ({shown})."
            return kept, Noise(1e3 * said.usual, "stated", words), []
    notes = []
    if said is not None:
        what = f"{shown[0].upper()}{shown[1:]}, stated is {1e3 * said.usual:.4f} mm"
        notes = [f"{what}: the measured noise is used."]
    words = f"{1e3 * found.usual:.4f} mm per axis, measured from repeated poses."
    return found, Noise(1e3 * found.usual, "repeats", words), notes


def _of_rows(problem: Problem) -> tuple[Covariance, Noise] | None:
    """Noise by how rows on end scatter that are shots of one pose now; None where there are none. What the
    arm is off by alike in all of them is not in it: that is its joints' scatter, which a fit shows."""
    (square, dof), shots = problem.campaign.shot_scatter, np.maximum(problem.campaign.shots, 1)
    if not problem.campaign.of_rows or dof < FEWEST_DOF:
        return None
    sigma = max(float(np.sqrt(square / dof)), LEAST) / np.sqrt(shots)
    found = replace(provisional(problem), sigma=sigma, dof=float(dof))
    words = "by how rows on end scatter, of which a pose is the mean"
    figure = 1e3 * found.usual
    return found, Noise(figure, "repeats", f"{figure:.4f} mm per axis, {words}.")


def of_distances(result: Fit) -> tuple[Covariance, Noise] | None:
    """Noise that the distances between targets show, where nobody stated one; None where there are none, or
    where most of what a fit leaves is not the instrument's."""
    problem, guess = result.model.problem, provisional(result.model.problem)
    shown = shown_by_distances(problem, guess, farthest=True)
    if shown is None or shown.times * guess.usual < _left(result) / np.sqrt(2):
        return None
    found = replace(guess, sigma=np.maximum(shown.times * guess.sigma, LEAST), dof=shown.dof)
    return found, _figures(found, "repeats", result.line.by_joint, None)


def _too_fine(problem: Problem) -> list[str]:
    """A note where the campaign states less noise than any instrument has."""
    stated = problem.campaign.noise_sigma
    if stated is None or stated >= LEAST:
        return []
    taken = f"taken for {LEAST * 1e3:g} mm"
    return [f"No instrument sees a robot to {stated * 1e3:g} mm, as [noise] says: {taken}. Is it in mm?"]


def _at_least_of_distances(problem: Problem, said: Covariance) -> tuple[Covariance, list[str]]:
    """The stated noise, and a sentence, where distances between targets scatter more: of several campaigns in
    each that they do so in, else in all together."""
    c, setup = problem.campaign, problem.campaign.poses.setup
    sigma, dof, notes = said.sigma.copy(), 0.0, []
    for k, name in enumerate(c.setup_names if c.beside else ()):
        poses = np.flatnonzero(setup == k)
        some = said.some(poses)
        shown = shown_by_distances(replace(problem, campaign=c.some(poses)), some)
        if shown is not None and shown.more:
            sigma[poses] *= shown.times
            dof += shown.dof
            notes.append(_shown(some, shown, f" in {name}"))
    if not notes:
        shown = shown_by_distances(problem, said)
        if shown is None or not shown.more:
            return said, []
        sigma, dof, notes = shown.times * said.sigma, shown.dof, [_shown(said, shown)]
    return replace(said, sigma=sigma, dof=dof), notes


def _shown(said: Covariance, shown: Shown, where: str = "") -> str:
    """A sentence where distances between targets scatter more than stated."""
    scatter = shown.times * said.usual
    return (
        f"Distances between targets{where}, which no robot changes, scatter as by {scatter * 1e3:.4f} mm per "
        f"axis, stated is {said.usual * 1e3:.4f} mm: what they show is used. If no target is loose, the "
        "stated noise is too small."
    )


def without_wild_repeats(problem: Problem) -> Problem:
    """The problem without points that are off their repeats by far more than usual: one such would make the
    noise of all."""
    deviation, weight, dof = within(problem.campaign.points, repeat_groups(problem))
    length = np.linalg.norm(deviation, axis=2)
    repeated = weight > 0
    if not dof or not repeated.any():
        return problem
    wild = repeated & (length > WILD_REPEAT * float(np.median(length[repeated])) + 1e-6)
    if not wild.any():
        return problem
    if problem.campaign.six_dof:  # it is one measurement
        wild |= wild.any(axis=1)[:, None]
    points = np.where(wild[..., None], np.nan, problem.campaign.points)
    return replace(problem, campaign=replace(problem.campaign, points=points))


def known_dof(noise: Noise, dof: float) -> float:
    """Degrees of freedom behind a noise that was measured with `dof`; 0 where it is the residual's own."""
    if noise.source == "residual":
        return 0.0
    return dof if noise.source == "repeats" and np.isfinite(dof) else PRIORS.noise_dof


def _disagree(problem: Problem, said: Covariance, measured: MeasuredNoise, axial: Array) -> str | None:
    """A sentence when repeats scatter otherwise than stated (robot's part included)."""
    chi2, dof = repeat_chi2(problem, said, axial)
    if 1e-4 < chdtrc(dof, chi2) < 1 - 1e-4:
        return None
    return (
        f"Repeated poses scatter {measured.total * 1e3:.4f} mm per axis, stated is "
        f"{measured.total * np.sqrt(dof / max(chi2, 1e-9)) * 1e3:.4f} mm: the measured noise is used."
    )


def _figures(noise: Covariance, source: str, axial: Array, measured: MeasuredNoise | None) -> Noise:
    sigma, robot = noise.usual, _shared(axial, noise)
    words = {"stated": "as stated in the campaign", "repeats": "measured from repeated poses"}[source]
    if source == "repeats" and measured is None:
        words = "shown by the distances between targets"
    sentence = f"{sigma * 1e3:.4f} mm per axis, {words}"
    if robot > 0:
        sentence += f"; the robot's own repeatability adds {robot * 1e3:.4f} mm per axis"
    if measured is not None and source == "stated":
        sentence += f" (repeats agree: {measured.total * 1e3:.4f} mm)"
    return Noise(
        sigma * 1e3,
        source,  # type: ignore[arg-type]
        sentence + ".",
        robot * 1e3 if robot > 0 else None,
    )


def from_residual(result: Fit) -> tuple[Covariance, Noise]:
    """Noise from the residual of a fit: one sigma, and, with several targets or a 6-D measurement, further
    parts (the robot's repeatability, the body's; the turning part of the measurement)."""
    problem = result.model.problem
    if problem.campaign.six_dof:
        new = of_poses(result)
    elif problem.seen.sum(axis=1).max() > 1:
        new = _parts(result)
    else:
        new = replace(result.noise, sigma=np.full_like(result.noise.sigma, _left(result)))
    sigma, shared = 1e3 * new.usual, 1e3 * _shared(result.line.by_joint, new, body_motion(problem))
    also = f", and {shared:.4f} mm per axis that the points of a pose share," if shared else ""
    repeated = "repeated" if problem.campaign.poses.side is None else "repeated from the same sides"
    sentence = (
        f"No noise was stated and no pose {repeated}: {sigma:.4f} mm per axis{also} is what the model "
        "leaves. Whether that is noise cannot be judged; only what depends on something can be found."
    )
    return new, Noise(sigma, "residual", sentence, shared or None)


def _shared(axial: Array, noise: Covariance, body: Array | None = None) -> float:
    """[m] per axis, rms, that a noise makes the points of a pose share: by the joints, and by the body."""
    square = (axial * noise.joint) ** 2
    if body is not None:
        square = np.concatenate([square, (body * np.repeat(noise.body, 3)) ** 2], axis=2)
    return float(np.sqrt(np.mean(square.sum(axis=2))))


def _left(result: Fit) -> float:
    """[m] per axis, root mean square: what a fit leaves, were it all noise of single points."""
    rows = result.model.problem.seen.sum() * 3
    return float(np.sqrt(np.nansum(result.residual**2) / max(rows - result.rank, 1)))


def as_left(result: Fit, poses: NDArray[np.bool_]) -> float:
    """By how much the noise of some poses (N,) is larger than it was taken for, as a fit's residual has it
    there; what the fit has taken of these very poses (its leverage) counts as no row."""
    r, prior = result.point_residual[poses], result.columns.prior
    J = (result.J[poses, : r.shape[1]] * prior).reshape(-1, len(prior))
    used = np.abs(result.whitener[poses, : r.shape[1]]).sum(axis=2) > 0
    taken = float((solve_triangular(result.upper, J.T, trans=1) ** 2).sum())
    return float(np.sqrt((r**2).sum() / max(used.sum() - taken, 1.0)))


def said_of_silent(problem: Problem, noise: Covariance) -> list[str]:
    """A remark where campaigns state no noise beside others that do."""
    silent, sigma = problem.campaign.of_silent, 1e3 * noise.sigma
    each = {label: float(np.sqrt(np.mean(sigma[here] ** 2))) for label, here in silent.items()}
    said = ", ".join(f"{mm:.4f} mm per axis in {label}" for label, mm in each.items())
    return [f"{SILENT}: {said}, which the model leaves there; the others count as stated."] if said else []


def _parts(result: Fit) -> Covariance:
    """Maximum likelihood, from the residual, of the instrument's variance and the joints' common one; and of
    what moves a pose's points as one body, where that is clearly there: no joint moves a reflector's seat,
    the floor or the air, and what they do must not count as surely none of the joints'."""
    problem = result.model.problem
    mask = np.repeat(problem.seen, 3, axis=1)
    turning = np.where(problem.arm.prismatic, 0.0, 1.0)
    J = result.line.by_joint * turning
    B = body_motion(problem)
    moved = [np.where(mask[..., None], A, 0.0) for A in (J, B[:, :, :3], B[:, :, 3:])]
    parts = [mask[:, :, None] * np.eye(mask.shape[1]), *(A @ A.transpose(0, 2, 1) for A in moved)]
    d = np.nan_to_num(result.residual).reshape(len(mask), -1)
    lost = mask.sum() / max(mask.sum() - result.rank, 1)
    sigma, joint, shift, turn = with_more(d, mask, parts, 2, lost)
    every = np.full(problem.seen.shape, sigma)
    return replace(result.noise, sigma=every, joint=joint * turning, body=(shift, turn))


def rigid_targets(geometry: Fit) -> list[str]:
    """A remark where targets keep their distances far better than the points their places, as by the noise
    and by what a fit leaves: they are points of one 6-D measurement, which was not said."""
    problem = geometry.model.problem
    c = problem.campaign
    on = np.array(problem.on)
    moving = [i for i in range(len(on)) if on[i] == on.max()]
    whole = problem.seen[:, moving].all(axis=1)
    if c.six_dof or len(moving) < 3 or whole.sum() < 10:
        return []
    points = c.points[whole][:, moving]
    sides = np.linalg.norm(points - np.roll(points, 1, axis=1), axis=2)
    scatter = 1e3 * float(np.max(sides.std(axis=0)))
    left = float(np.sqrt(np.mean(geometry.residual[problem.seen] ** 2)))
    usual = 1e3 * min(geometry.noise.usual, left)
    if scatter > RIGID * usual:
        return []
    names = ", ".join(c.targets[i].name for i in moving)
    return [
        f"The distances between {names} never change ({scatter:.1g} mm, noise {usual:.1g} mm): they "
        "are points of one 6-D measurement. Say pose = true under [noise]; else one error counts as several."
    ]
