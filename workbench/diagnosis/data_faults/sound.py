"""A campaign without its data faults: wild points out, a set-up that moved is two, another load is told."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.problem import Problem, problem
from ...campaign.stepped import split_campaign
from ...effects.records import stated_effects
from ...files.faults import Fault, InputError
from ...identification.fit import Fit, fit, start_state
from ...identification.model import Model, State
from ...identification.noise import FEWEST_DOF, Covariance
from ...identification.plausible import believed, check_rest, too_few_alone
from ...robot.kinematics import Array
from ..found import FaultFound, Noise
from ..noise.noise_choice import choose, from_residual, of_distances, without_wild_repeats
from ..weighing.places_of_steps import DIFFERENT
from .frozen_joint import frozen_joints
from .mistaken_loads import mistaken_loads
from .moved_setup import jump, split_setup, step_in_time
from .moved_target import reseated
from .rarely_seen import without_rarely_seen
from .standstills import taken_together
from .wild_points import (
    Acting,
    Cleaned,
    clean,
    least_sigma,
    much_left_out,
    robust_fit,
    without_gross,
    without_impossible,
)

SIX_DOF = 3  # targets that make a 6-D measurement
MOST_MOVES = 6  # of single targets in a campaign: one with more has other faults

Enough = Callable[[Problem], list[str]]


@dataclass(frozen=True)
class Sound:
    """A problem without its data faults; where its fits start, and the noise before a residual is seen."""

    problem: Problem
    known_effects: Acting
    start: State
    covariance: Covariance
    noise: Noise
    faults: tuple[FaultFound, ...]
    notes: tuple[str, ...]


def without_faults(problem: Problem, known_effects: Acting, enough: Enough) -> Sound:
    """Wild points out; and a set-up that moved is two."""
    possible = without_impossible(problem)
    together, shots, of_rows = taken_together(possible.problem)
    told = without_rarely_seen(together)
    problem, faults = measured_only(told.problem), (*possible.faults, *shots, *told.faults)
    measured = problem
    enough(problem)  # what cannot be enough is not searched for mistakes
    far = jump(problem)
    if far is not None:
        problem, faults = split_setup(problem, far.first), (*faults, far.fault(problem))
    problem, said = believed(problem)
    gross = without_gross(problem)
    problem, faults = measured_only(gross.problem), (*faults, *gross.faults)
    start = start_state(problem)
    check_rest(Model(problem, (), known_effects), start)
    usual = without_wild_repeats(problem)
    covariance, noise, notes = noise_at(usual, known_effects, start)
    least = least_sigma(problem, covariance if noise.source != "residual" else None)
    robust, moved = _sitting_still(problem, start, covariance, known_effects)
    said = [*said, *mistaken_loads(robust)]
    problem, faults = robust.model.problem, (*faults, *moved)
    cleaned = _cleaned(robust, covariance, known_effects, least)
    problem, start, faults = cleaned.problem, cleaned.fit.state, (*faults, *cleaned.faults)
    step = step_in_time(cleaned.fit)
    if step is not None:
        problem, faults = split_setup(problem, step.first), (*faults, step.fault(problem))
    problem = measured_only(problem)
    many = [*much_left_out(measured, problem), *frozen_joints(measured, problem)]
    if step is not None or start.targets.shape[1] > len(problem.campaign.targets):
        start = start_state(problem)
    if faults or usual is not problem:
        covariance, noise, notes = noise_at(problem, known_effects, start)
    said = [*of_rows, *many, *said, *enough(problem)]
    return Sound(problem, known_effects, start, covariance, noise, faults, (*said, *notes))


def _cleaned(robust: Fit, noise: Covariance, known_effects: Acting, least: Array) -> Cleaned:
    """Wild points out (`clean`). Many may be all that came before a step in time, or after: then it is two
    set-ups that are cleaned."""
    problem, cleaned, step = robust.model.problem, clean(robust, noise, known_effects, least), None
    if len({fault.pose_id for fault in cleaned.faults if fault.kind == "outlier"}) >= DIFFERENT:
        with suppress(ArithmeticError):
            step = step_in_time(fit(Model(problem, (), known_effects), robust.state, noise))
    if step is None:
        return cleaned
    parts = split_setup(problem, step.first)
    cleaned = clean(robust_fit(parts, start_state(parts), noise, known_effects), noise, known_effects, least)
    return replace(cleaned, faults=(step.fault(problem), *cleaned.faults))


def _sitting_still(
    problem: Problem, start: State, noise: Covariance, known_effects: Acting
) -> tuple[Fit, tuple[FaultFound, ...]]:
    """A robust fit without the points of single targets where these sit elsewhere, before they are taken for
    wild ones; and what was found."""
    faults: list[FaultFound] = []
    while True:
        result = robust_fit(problem, start, noise, known_effects)
        start, moved = result.state, reseated(result)
        if moved is None or len(faults) == MOST_MOVES:
            return result, tuple(faults)
        faults.append(moved.fault(problem))
        problem = moved.left_out(problem)


def measured_only(problem: Problem) -> Problem:
    """The problem with the poses and targets of which something is left; `InputError` where nothing is."""
    c, seen = problem.campaign, problem.seen
    if c.six_dof and seen.sum(axis=1).max(initial=0) < SIX_DOF:
        what = f"no pose has {SIX_DOF} usable targets, which a 6-D measurement needs"
        raise InputError(Fault(str(c.path), what, "look at the points, or take out `pose = true`"))
    if seen.any(axis=1).all() and seen.any(axis=0).all():
        return problem
    if not seen.any():
        raise InputError(Fault(str(c.path), "no usable point is left", "look at the points"))
    return Problem(problem.robot, problem.arm, c.measured(), problem.compensator)


def noise_at(problem: Problem, known_effects: Acting, start: State) -> tuple[Covariance, Noise, list[str]]:
    """The noise as it is chosen (`choose`) at the state that fits start from."""
    return choose(problem, Model(problem, (), known_effects).linearise(start))


def each_alone(campaign: Campaign) -> tuple[Campaign, tuple[FaultFound, ...]]:
    """Several campaigns as one, with what each shows by itself: two set-ups for one whose instrument or tool
    moved, and that as a fault (beside others, these are poses that do not fit); and the noise of those that
    state none."""
    found = list[FaultFound]()
    for name in campaign.setup_names:
        k = campaign.setup_names.index(name)
        poses = np.flatnonzero(campaign.poses.setup == k)
        if not campaign.seen[poses].any():
            continue
        some = campaign.some(poses).with_poses(setup=np.zeros_like(poses))
        label = campaign.labels[campaign.of_campaign[poses[0]]]
        if label in campaign.silent:
            some = replace(some, sigma=None, noise_sigma=None)
        alone = problem(replace(some, setup_names=(name,), beside=(), labels=(), silent=()).measured())
        if too_few_alone(alone):
            continue
        try:
            sound = without_faults(alone, tuple(stated_effects(alone)), lambda _: [])
            campaign = _with_noise_of(sound, campaign, poses)
        except (InputError, ArithmeticError, np.linalg.LinAlgError):  # told of all of them
            continue
        for fault in (one for one in sound.faults if one.kind in ("moved_instrument", "changed_setup")):
            first = some.poses.ids.index(str(fault.pose_id))
            campaign = split_campaign(campaign, int(poses[first]), k)
            found.append(fault)
    return campaign, tuple(found)


def _with_noise_of(sound: Sound, campaign: Campaign, poses: NDArray[np.int64]) -> Campaign:
    """Several campaigns with the noise of a set-up, that states none, as it shows by itself: by repeats; or
    else, for the time being, by distances between targets or what geometry leaves."""
    label = campaign.labels[campaign.of_campaign[poses[0]]]
    if label not in campaign.silent or campaign.sigma is None:
        return campaign
    noise, measured = sound.covariance, sound.noise.source != "residual"
    if not measured:
        geometry = fit(Model(sound.problem, (), sound.known_effects), sound.start, noise)
        if geometry.point_rows - geometry.rank < FEWEST_DOF:
            return campaign
        noise = (of_distances(geometry) or from_residual(geometry))[0]
    seen = sound.problem.seen
    one_shot = np.sqrt(np.mean((noise.sigma**2 * sound.problem.campaign.shots)[seen]))
    sigma = campaign.sigma.copy()
    shots = np.where(campaign.seen[poses], campaign.shots[poses], np.nan)
    sigma[poses] = (one_shot / np.sqrt(shots))[..., None]
    campaign = replace(campaign, sigma=sigma)
    if not measured:
        return campaign
    what = f"{label} states no noise: {1e3 * one_shot:.4f} mm per axis of a shot, as it is measured there"
    silent = tuple(one for one in campaign.silent if one != label)
    warnings = (*campaign.warnings, what)
    return replace(campaign, silent=silent, shown=(*campaign.shown, label), warnings=warnings)
