"""The one preparation of campaigns: data faults out, noise chosen, geometry fitted.

Diagnosis and plan start here, and so does whatever else asks a campaign something: what two places prepare
on their own, they come to prepare differently.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..campaign import Campaign, calibrated, join, torque_columns
from ..campaign.other_tools import tool_as_modelled
from ..campaign.parted import parted
from ..campaign.problem import Problem, problem
from ..effects.given import Given, exclusions, given_facts
from ..effects.records import stated_effects
from ..files.faults import Fault, InputError
from ..identification.fit import Fit, fit, start_state
from ..identification.model import Model, State
from ..identification.noise import LEAST, Covariance
from ..identification.plausible import common_factor, enough_poses, plausible_geometry, too_few_alone
from ..identification.set_up import fit_set_up
from ..robot.kinematics import Array
from .data_faults.copies import without_copies
from .data_faults.moved_setup import Step, split_setup
from .data_faults.rounded_joints import all_rounding
from .data_faults.sound import Enough, Sound, each_alone, measured_only, noise_at, without_faults
from .data_faults.wild_points import Acting, Cleaned, least_sigma
from .found import FaultFound, Noise
from .noise.coarse import coarseness
from .noise.noise_choice import SILENT, as_left, from_residual, of_distances, rigid_targets, said_of_silent
from .noise.six_dof import of_repeats, of_turns, turn_rad
from .noise.torque_noise import torque_noise
from .weighing.places_of_steps import places
from .weighing.replication import enough_for_halves

ALIKE = 0.05  # of a noise: by less it is as it was taken for
ROUNDS = 3  # times a noise is taken from a fit under the one before
TURNS = "Turns of the 6-D measurement scatter"
MOST_POSES = 4000  # that a fit is made on: more say hardly more, and take room and time

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Prepared:
    """Campaigns of one robot, ready to be asked.

    problem: without the data faults, set-ups split where the instrument or the tool moved; covariance: the
    noise that the fits use, noise: the same for people; known_effects: those that the robot's own TOML
    states, with their values; geometry, nominal: fits of the whole geometry, of frames and targets only;
    spare: poses of a large campaign that nothing was fitted on.
    """

    problem: Problem
    covariance: Covariance
    noise: Noise
    known_effects: Acting
    geometry: Fit
    nominal: Fit
    faults: tuple[FaultFound, ...]
    notes: tuple[str, ...]
    spare: Campaign | None = None

    @property
    def noise_known(self) -> bool:
        """The noise was stated or measured: the residual can be judged by it."""
        return self.noise.source != "residual"

    @property
    def least(self) -> Array:
        """(N, T) [m] one sigma per axis that a point has in any case."""
        return least_sigma(self.problem, self.covariance if self.noise_known else None)

    def with_noise_of(self, result: Fit) -> Prepared:
        """The same with the noise that a better fit leaves, and geometry fitted to that."""
        covariance, noise = from_residual(result)
        geometry = _under(self.geometry, covariance)
        return replace(self, covariance=covariance, noise=noise, geometry=geometry)

    def with_turns_of(self, result: Fit) -> Prepared | None:
        """The same with the noise of a 6-D measurement's turns that a better fit leaves; None where that is
        as it was taken for; where repeats show it; and where nobody knows the noise: it has its part in
        that."""
        if not self.noise_known or not self.problem.campaign.six_dof:
            return None
        if of_repeats(self.problem, result.line) is not None:
            return None
        covariance = of_turns(result, self.covariance)
        if covariance is None:
            return None
        turn = f"{1e3 * turn_rad(result, covariance):.2g} mrad about each axis"
        before = [note for note in self.notes if not note.startswith(TURNS)]
        note = f"{TURNS} by {turn}: that is used, none is stated."
        return replace(self._under(covariance), notes=(*before, note))

    def with_silent(self, result: Fit) -> Prepared | None:
        """The same with the noise that a better fit leaves in campaigns that state none beside others that
        do; None where that is as it was taken for, or nobody knows any noise."""
        silent = self.problem.campaign.of_silent.values() if self.noise_known else ()
        covariance = self.covariance
        for _ in range(ROUNDS if silent else 0):
            result = _under(result, covariance)
            sigma = covariance.sigma.copy()
            for here in silent:
                sigma[here] *= as_left(result, here)
            covariance = replace(covariance, sigma=np.maximum(sigma, LEAST))
        if np.allclose(covariance.sigma, self.covariance.sigma, rtol=ALIKE, atol=0.0):
            return None
        before = [note for note in self.notes if not note.startswith(SILENT)]
        notes, usual = (*before, *said_of_silent(self.problem, covariance)), 1e3 * covariance.usual
        words = f"{usual:.4f} mm per axis, as stated where it is, elsewhere as the model leaves it."
        noise = replace(self.noise, sigma_mm=usual, sentence=words)
        return replace(self._under(covariance), noise=noise, notes=notes)

    def with_distances(self, result: Fit) -> Prepared | None:
        """The same with the noise that distances between targets show, where nobody stated one and a better
        fit leaves little more, of joint positions enough: at few, numbers take up what the robot does beside.
        None elsewhere."""
        if self.noise_known or not enough_for_halves(self.problem):
            return None
        shown = of_distances(result)
        if shown is None:
            return None
        covariance, noise = shown
        if self.covariance.torque is not None:
            covariance = replace(covariance, torque=self.covariance.torque)
        found = self._under(covariance)
        return replace(found, noise=noise, geometry=plausible_geometry(found.geometry))

    def _under(self, covariance: Covariance) -> Prepared:
        """The same fitted under another noise."""
        geometry = _under(self.geometry, covariance)
        nominal = fit_set_up(self.nominal.model, self.nominal.state, covariance)
        return replace(self, covariance=covariance, geometry=geometry, nominal=nominal)

    def some(self, poses: NDArray[np.int64]) -> Prepared:
        """Some of the poses as if there were no others: where nobody knows the noise, with their own."""
        problem = replace(self.problem, campaign=self.problem.campaign.some(poses))
        covariance = self.covariance.some(poses)
        geometry = fit(replace(self.geometry.model, problem=problem), self.geometry.state, covariance)
        part = replace(self, problem=problem, covariance=covariance, geometry=geometry)
        return part if self.noise_known else part.with_noise_of(geometry)

    def mended(self, found: Cleaned) -> Prepared:
        """The same without what was found to be wild beside causes."""
        return self._again(measured_only(found.problem), self.geometry.state, found.faults)

    def split(self, steps: Sequence[Step]) -> Prepared:
        """The same with the poses from each step in time on in a set-up of their own: the largest first, and
        where that leaves poses enough to place frame and targets."""
        problem, taken = self.problem, list[Step]()
        for step in steps:
            own = problem.campaign.poses.in_setup_of(step.first)
            if int(np.searchsorted(own, step.first)) in places(problem.positions[own]):
                problem = split_setup(problem, step.first)
                taken.append(step)
        problem = measured_only(problem)
        faults = [step.fault(self.problem) for step in sorted(taken, key=lambda step: step.first)]
        return self._again(problem, start_state(problem), tuple(faults))

    def counted(self, problem: Problem, faults: tuple[FaultFound, ...]) -> Prepared:
        """The same with joints counted otherwise in some of the poses."""
        return self._again(problem, self.geometry.state, faults)

    def _again(self, problem: Problem, start: State, faults: tuple[FaultFound, ...]) -> Prepared:
        """The same of the data without further faults."""
        covariance, noise, _ = noise_at(problem, self.known_effects, start)
        sound = Sound(problem, self.known_effects, start, covariance, noise, (*self.faults, *faults), ())
        return replace(_fitted(sound), notes=self.notes, spare=self.spare)

    def with_given(self, given: tuple[Given, ...]) -> Prepared:
        """The same with numbers that are known by other means, geometry fitted beside them."""
        if not given:
            return self
        model = replace(self.geometry.model, given=given)
        return replace(self, geometry=fit(model, self.geometry.state, self.covariance))


def prepare(
    campaigns: Campaign | Sequence[Campaign],
    progress: Progress = lambda _: None,
    enough: Enough = enough_poses,
) -> Prepared:
    """Campaigns of one robot, joined and prepared. enough: remarks on how many poses there are, `InputError`
    where too few. Raises InputError where the data are unusable: of several campaigns, with what is wrong in
    those that are unusable by themselves, where others are not."""
    if isinstance(campaigns, Campaign):
        return _prepared(campaigns, progress, enough)
    every = list(campaigns)
    whole = join(every)  # what is not one robot is refused as that
    try:
        return _prepared(whole, progress, enough)
    except InputError as refused:
        raise _of_its_own(every, refused) from refused


def _of_its_own(campaigns: Sequence[Campaign], refused: InputError) -> InputError:
    """What some of several campaigns are refused for by themselves; where that is none of them or all, what
    they are refused for together. Those of too few poses show nothing by themselves."""
    apart = list[InputError]()
    for campaign in campaigns if len(campaigns) > 1 else ():
        try:
            if too_few_alone(problem(campaign)):
                continue
            _prepared(campaign, lambda _: None, lambda _: [])
        except InputError as error:
            apart.append(error)
    if not 0 < len(apart) < len(campaigns):
        return refused
    return InputError([fault for error in apart for fault in error.faults])


def _prepared(campaign: Campaign, progress: Progress, enough: Enough) -> Prepared:
    """One campaign, prepared."""
    progress("loading the robot")
    campaign, spare = parted(tool_as_modelled(campaign.robot, campaign), MOST_POSES)
    campaign, faults = without_copies(campaign)
    read = problem(campaign)
    given_facts(read), exclusions(read)  # a fact that cannot be is told before the work begins
    progress("looking for data faults")
    if campaign.beside:
        campaign, moved = each_alone(campaign)
        read, faults = problem(campaign), (*faults, *moved)
    try:
        sound = without_faults(read, tuple(stated_effects(read)), enough)
        progress("fitting geometry")
        prepared = _fitted(replace(sound, faults=(*faults, *sound.faults)))
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        if os.environ.get("WORKBENCH_DEBUG"):  # it may be our own mistake
            raise
        what = f"no robot of this kind moves as these data say ({error})"
        raise InputError(Fault(str(campaign.path), what, "check loads, stiffness and points")) from error
    if spare is None or set(spare.setup_names) - set(prepared.problem.campaign.setup_names):
        return prepared
    note = (
        f"fitted on {len(campaign.poses)} poses, drawn at random; tried on {len(spare.poses)} of the others"
    )
    return replace(prepared, spare=spare, notes=(*prepared.notes, note))


def _fitted(sound: Sound) -> Prepared:
    """Geometry, and the noise from its residual where there is no other; then the nominal robot."""
    problem, covariance, noise = sound.problem, sound.covariance, sound.noise
    model = Model(problem, (), sound.known_effects)
    geometry = fit(model, sound.start, covariance)
    known = noise.source != "residual"
    if not known:
        covariance, noise = from_residual(geometry)
    if problem.drives:
        covariance = replace(covariance, torque=torque_noise(geometry))
    if not known or problem.drives:
        geometry = _under(geometry, covariance)
    geometry = plausible_geometry(geometry)
    coarse, rounded = coarseness(geometry), all_rounding(geometry)
    if coarse > 1 or rounded:
        problem = replace(problem, coarse=coarse, rounded=rounded)
        model = replace(model, problem=problem)
        geometry = replace(geometry, model=replace(geometry.model, problem=problem))
    as_stated = replace(sound.start, geometry=problem.arm.geometry)
    nominal = fit_set_up(model, as_stated, covariance)
    said = (*rigid_targets(geometry), *calibrated.remarks(problem), *common_factor(geometry))
    said = (*said, *said_of_silent(problem, covariance), *torque_columns.remarks(problem))
    notes = (*sound.notes, *said, *_coarse(coarse))
    return Prepared(problem, covariance, noise, sound.known_effects, geometry, nominal, sound.faults, notes)


def _under(result: Fit, noise: Covariance) -> Fit:
    """The same fitted under another noise."""
    return fit(result.model, result.state, noise, line=result.line)


def _coarse(times: float) -> list[str]:
    """A remark on a machine that is so many times as coarse as an industrial arm."""
    if times == 1:
        return []
    what = f"What geometry and compliance leave is some {times:.0f} times what an industrial arm of this size"
    return [f"{what} usually leaves: causes are sought that are as many times as large."]
