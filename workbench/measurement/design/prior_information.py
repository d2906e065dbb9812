"""Prior information on a robot, and what further records would add: whitened sensitivities.

A record is a pose with its load, its side of approach, its time and temperature. New records stand in a
set-up of their own, as `diagnose old.toml new.toml` takes them: its frame and targets are fitted anew, and
geometry and effects are what the records share with those that are there already.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign, drive_torque
from ...campaign.drives import ACCURACY
from ...campaign.payloads import with_payloads
from ...campaign.planned import TARGETS, planned
from ...campaign.problem import Problem, problem_of
from ...campaign.reflectors import place_of, with_reflectors
from ...diagnosis.found import FaultFound
from ...diagnosis.prepared import Prepared, prepare
from ...effects.base import Effect
from ...effects.given import Given, exclusions, given_facts, may_be
from ...effects.records import stated_effects
from ...identification.fit import Fit, fit, refit
from ...identification.model import Model, State
from ...identification.noise import Covariance
from ...identification.parameters import effect_names
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.loads import wrenches
from ...robot.schema import stated_load

ASSUMED_SIGMA = 3e-5  # m per axis, of a robot that nobody measured: a laser tracker
WIDE = 30.0  # prior of an effect's parameter, in its typical sizes: wide, but no arm is made of rubber
OFTEN = 0.5  # share of the poses that must show a target for a plan to count on it

ValuedEffects = tuple[tuple[Effect, Array], ...]


@dataclass(frozen=True)
class Sensitivity:
    """Whitened derivatives (N, D, P) of records by the parameters `names` (P): frames, targets and geometry
    in units of their priors, effects in typical sizes."""

    names: tuple[str, ...]
    values: Array

    def on(self, names: Sequence[str]) -> Array:
        """(N, D, len(names)) the rows by other parameters; those that they do not have move nothing."""
        out = np.zeros((*self.values.shape[:2], len(names)))
        column = {name: i for i, name in enumerate(names)}
        common = [(column[name], i) for i, name in enumerate(self.names) if name in column]
        to, of = np.array(common).T
        out[:, :, to] = self.values[:, :, of]
        return out


@dataclass(frozen=True)
class PriorInformation:
    """A robot with its loads and targets, and what was measured of it.

    problem: of the campaign (of one without points where nothing was measured: then `fit` is None);
    acting: effects with the values that the robot's own TOML states; sigma: (T,) [m] noise per axis,
    joint: (n,) one sigma of the joints, body: as in `Covariance`; noise: where that comes from; shown: (T,)
    the targets that the campaign, of several the last, shows often, which new records show too; places:
    (T, 3) [m] where these are behind their slots; further: how many of the last are still to be put on, about
    there; torques: new records have the drives' torques, though the campaign may have none;
    faults: of the campaign's data, as a diagnosis finds them; given: numbers known by other means.
    """

    problem: Problem
    acting: ValuedEffects
    fit: Fit | None
    sigma: Array
    joint: Array
    turn_ratio: float
    about: int
    noise: str
    shown: NDArray[np.bool_]
    places: Array
    faults: tuple[FaultFound, ...] = ()
    given: tuple[Given, ...] = ()
    body: tuple[float, float] = (0.0, 0.0)
    torques: bool = False
    further: int = 0

    def is_open(self, effect: Effect) -> bool:
        """Whether an effect may be there: it is neither given nor excluded."""
        return may_be(effect, self.given, exclusions(self.problem))

    @property
    def robot(self) -> Robot:
        return self.problem.robot

    def with_payloads(self, payloads: Mapping[str, tuple[float, Sequence[float]]]) -> PriorInformation:
        """With further loads that new records may carry, as `campaign.payloads.with_payloads`."""
        campaign = with_payloads(self.problem.campaign, payloads)
        return replace(self, problem=replace(self.problem, campaign=campaign))

    def with_reflectors(self, links: Sequence[str]) -> PriorInformation:
        """With a further target on each of these links, which new records show too, as
        `campaign.reflectors.with_reflectors`."""
        arm, own = self.problem.arm, np.sqrt(np.mean(self.sigma[self.shown] ** 2))
        campaign = with_reflectors(self.problem.campaign, links)
        return replace(
            self,
            problem=replace(self.problem, campaign=campaign),
            sigma=np.append(self.sigma, np.full(len(links), own)),
            shown=np.append(self.shown, np.ones(len(links), dtype=bool)),
            places=np.concatenate([self.places, *(place_of(arm, link)[None] for link in links)]),
            further=len(links),
        )

    @property
    def known_places(self) -> Array:
        """(T, 3) [m] of the targets, NaN of those that are still to be put on: where, is not the plan's."""
        known = np.arange(len(self.places)) < len(self.places) - self.further
        return np.where(known[:, None], self.places, np.nan)

    @property
    def mountable(self) -> NDArray[np.int64]:
        """Numbers of the payloads that new records may carry: all; where tools are payloads those with the
        one that is mounted now, and those that no pose has carried yet."""
        c = self.problem.campaign
        if not c.mounted:
            return np.arange(len(c.payload_names))
        now = c.poses.payload[c.of_campaign == c.of_campaign[-1]]
        other = np.setdiff1d(np.append(c.poses.payload, 0), [*now, c.payload_names.index(c.mounted)])
        return np.setdiff1d(np.arange(len(c.payload_names)), other)

    def records(self, q: Array, payload: NDArray[np.int64]) -> Campaign:
        """A campaign of N poses q: (N, n) with payloads (N,), without points."""
        c, n_poses = self.problem.campaign, len(q)
        targets = tuple(t for t, shown in zip(c.targets, self.shown, strict=True) if shown)
        return replace(
            c.with_poses(
                ids=tuple(str(i + 1) for i in range(n_poses)),
                q=q,
                payload=payload,
                wrench=np.zeros((n_poses, 6)),
                side=None,
                time=None,
                temperature=None,
                torque=None,
                readback=None,
                setup=np.zeros(n_poses, dtype=np.int64),
            ),
            title=f"{self.robot.title}, planned",
            setup_names=("",),
            targets=targets,
            points=np.full((n_poses, len(targets), 3), np.nan),
            shots=np.zeros((n_poses, len(targets)), dtype=np.int64),
            sigma=None,
            shot_scatter=(0.0, 0),
        )

    def of_campaign(self, effects: ValuedEffects) -> Sensitivity | None:
        """Sensitivity of what was measured; None where nothing was."""
        return None if self.fit is None else _sensitivity_of(self.fit, effects)

    def of_records(self, records: Campaign, effects: ValuedEffects) -> Sensitivity:
        """Sensitivity of new records, in a set-up of their own; where the campaign has drive torques (to
        record them takes no time), or these shall be recorded, they count as good as motor currents are."""
        if self.torques or self.problem.drives:
            records = records.with_poses(torque=np.zeros_like(records.poses.q))
        sigma = np.tile(self.sigma[self._targets(records)], (len(records.poses.q), 1))
        every = np.ones(len(records.poses.q))
        noise = Covariance(
            sigma, self.joint, every, turn_ratio=self.turn_ratio, about=self.about, body=self.body
        )
        if records.poses.torque is not None:
            noise = replace(noise, torque=self._torque_noise(records, effects))
        return self._sensitivity(records, noise, effects)

    def _targets(self, records: Campaign) -> list[int]:
        """Which of the campaign's targets records measure."""
        names = [target.name for target in self.problem.campaign.targets]
        return [names.index(target.name) for target in records.targets]

    def _torque_noise(self, records: Campaign, effects: ValuedEffects) -> Array:
        """(n,) one sigma of torques by motor currents [N·m, N]: a share of the largest that the stated loads
        and these effects, in their usual sizes, make at a joint; infinite where the stated loads alone would
        not have a column believed, so that one that stays quiet is no witness."""
        problem = replace(self.problem, campaign=records)
        nominal, own = problem.nominal_load.local, problem.arm.own
        stated = own(nominal)
        torque, least = np.abs(stated), drive_torque.axis_error(problem)
        for effect, _ in effects:
            typical = np.array([p.typical for p in effect.params])
            arm, loads = effect.apply(problem, problem.arm, problem.loads, typical)
            torque = torque + np.abs(own(wrenches(arm, problem.rigid, loads).local - nominal))
        alone = np.hypot(ACCURACY * np.abs(stated).max(axis=0), least)
        believed = drive_torque.shown(alone, np.hypot(alone, stated.std(axis=0)))
        return np.where(believed, np.hypot(ACCURACY * torque.max(axis=0), least), np.inf)

    def of_predictions(self, records: Campaign, effects: ValuedEffects) -> Array:
        """(D0, P) rows [m] of poses that will have to be right, by the names of `of_records`: what the
        targets move when their frame and places are fitted to these very poses. A pose's squared rows are
        the mean over its targets."""
        shape = (len(records.poses.q), len(records.targets))
        # the six rows of a 6-D measurement are means over the targets already
        size = 1.0 if records.six_dof else float(np.sqrt(shape[1]))
        noise = Covariance(np.full(shape, size), np.zeros(self.problem.arm.n), np.ones(shape[0]))
        rows = self._sensitivity(records, noise, effects)
        flat = rows.values.reshape(-1, len(rows.names))
        fitted = np.array([name.startswith(("frame/", "target/")) for name in rows.names])
        Q = _span(flat[:, fitted])
        return np.where(fitted, 0.0, flat - Q @ (Q.T @ flat))

    def _sensitivity(self, records: Campaign, noise: Covariance, effects: ValuedEffects) -> Sensitivity:
        name = "planned"
        while name in self.problem.campaign.setup_names:
            name += "+"
        records = replace(records, setup_names=(name,))
        problem = replace(self.problem, campaign=records)
        geometry = self.problem.arm.geometry if self.fit is None else self.fit.state.geometry
        # seen from the base: where the instrument stands makes no difference
        state = State(geometry, np.eye(3)[None], np.zeros((1, 3)), self.places[None, self._targets(records)])
        model = Model(problem, (), self.acting, self.given)
        line = model.linearise(state)
        points = line.prediction.points
        shots = np.ones(points.shape[:2], dtype=np.int64)
        problem = replace(problem, campaign=replace(records, points=points, shots=shots))
        # a fit to its own prediction: only its derivatives are wanted
        found = fit(replace(model, problem=problem), state, noise, max_iterations=1, line=line)
        return _sensitivity_of(found, effects)


def _span(columns: Array) -> Array:
    """Orthonormal basis of what the columns span."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    U, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(U[:, s > 1e-9 * s[0]])


def _sensitivity_of(result: Fit, effects: ValuedEffects) -> Sensitivity:
    """Sensitivity of a fit's poses by its own parameters and by those of effects besides."""
    names, blocks = list(result.columns.names), [result.J * result.columns.prior]
    for effect, values in effects:
        typical = np.array([p.typical for p in effect.params])
        names += parameter_names(effect)
        moved = result.model.effect_jacobian(result.line, effect, values) * typical
        blocks.append(np.matmul(result.whitener, moved))
    return Sensitivity(tuple(names), np.concatenate(blocks, axis=2))


def parameter_names(effect: Effect) -> list[str]:
    """Names of an effect's parameters, its form, order and settings included: a map of where a joint was and
    one of all its range are two."""
    settings = "".join(f" {name}={getattr(effect, name):.6g}" for name in effect.settings)
    return [f"effect/{name}{settings}" for name in effect_names(effect)]


def prior_precision(names: Sequence[str]) -> Array:
    """(P,) information on each parameter before anything is measured, in the units of `Sensitivity`."""
    return np.array([WIDE**-2 if name.startswith("effect/") else 1.0 for name in names])


def from_robot(robot: Robot, known: Sequence[str] = ()) -> PriorInformation:
    """A robot with the loads of its own TOML, three targets on its flange, and an assumed tracker; known: as
    `--known` says it. Raises InputError where that cannot be."""
    on, q = robot.mounted, np.zeros((1, len(robot.joints)))
    loads = {name: stated_load(load) for name, load in robot.payloads.items() if on in ("", name)}
    blank = planned(robot, q, payloads=loads, payload=[on], tool=stated_load(robot.tool))
    blank = replace(blank, mounted=on)
    nothing = problem_of(blank.with_known(known))
    given = given_facts(nothing)
    joint = np.array([item.data.repeatability or 0.0 for item in robot.joints])
    noise = f"{1e3 * ASSUMED_SIGMA:.3f} mm per axis assumed, and the joints' repeatability as stated"
    sigma = np.full(len(TARGETS), ASSUMED_SIGMA)
    effects = tuple(stated_effects(nothing))
    shown = np.ones(len(TARGETS), dtype=bool)
    places = nothing.stated_targets
    return PriorInformation(nothing, effects, None, sigma, joint, 1.0, -1, noise, shown, places, given=given)


def from_campaign(
    campaign: Campaign, found: Callable[[Problem], Sequence[Effect]] = lambda _: ()
) -> PriorInformation:
    """A robot with its campaign, as a diagnosis prepares it. found: the effects that it found; where nobody
    knows the noise, it is what geometry leaves beside these. Raises InputError where data are unusable."""
    prepared = prepare(campaign)
    if not prepared.noise_known and (effects := found(prepared.problem)):
        prepared = prepared.with_noise_of(refit(prepared.geometry, effects))
    return from_prepared(prepared.with_given(given_facts(prepared.problem)))


def from_prepared(prepared: Prepared) -> PriorInformation:
    """A robot with campaigns that are prepared, and with what is given beside them."""
    problem, covariance = prepared.problem, prepared.covariance
    of = problem.campaign.of_campaign
    share = problem.seen[of == of[-1]].mean(axis=0)  # of several campaigns the tool of the last is mounted
    shown = (share >= min(OFTEN, float(share.max()))) | problem.campaign.six_dof
    setups = range(len(problem.campaign.setup_names))
    where = [problem.seen[problem.campaign.poses.setup == k].sum(axis=0) for k in setups]
    places = prepared.geometry.state.targets[np.argmax(where, axis=0), np.arange(len(share))]
    sigma = np.sqrt(np.mean(covariance.sigma**2, axis=0))
    source = {"stated": "as stated", "repeats": "measured from repeats", "residual": "what the model leaves"}
    mm = 1e3 * float(np.sqrt(np.mean(sigma[shown] ** 2)))
    words = f"{mm:.4f} mm per axis, {source[prepared.noise.source]}"
    if covariance.joint.any():
        words += f", joints that repeat to {1e3 * float(covariance.joint.max()):.3g} mrad"
    return PriorInformation(
        problem,
        prepared.known_effects,
        prepared.geometry,
        sigma,
        covariance.joint,
        covariance.turn_ratio,
        covariance.about,
        words,
        shown,
        places,
        prepared.faults,
        prepared.geometry.model.given,
        covariance.body,
    )
