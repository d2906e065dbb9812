"""The numbers that a fit decides: their names, priors and places, and which are free at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..effects.base import Effect
from ..effects.given import Given
from ..robot.kinematics import Array
from ..robot.rotations import body_jacobian
from ..robot.schema import GEOMETRY
from .registration import STATED_TARGET, UNKNOWN_TARGET

GEOMETRY_PRIOR = (5e-3, 5e-3)  # m, rad
LEVER_PRIOR = (5e-4, 5e-4)  # m, rad, of a correction that no point shows: it changes levers of loads alone
AS_STATED = (1e-7, 1e-7)  # m, rad, of a correction that is not fitted
TARGET_PRIOR = 5e-3  # m, of a stated target, where it takes up nothing of what the geometry errs by
FRAME_PRIOR = 10.0  # m, rad: as good as none


@dataclass(frozen=True)
class Columns:
    """The fitted numbers: their names and prior standard deviations, in blocks.

    First the frames: shift and turn of each set-up. Then `targets`: (setup, target, columns), three
    columns for one target, or six (shift and turn, target None) for all of a 6-D measurement together.
    Then geometry: columns 6 · slot + component; then `given` numbers; then the effects' own parameters.
    """

    names: tuple[str, ...]
    prior: Array
    setups: int
    targets: tuple[tuple[int, int | None, slice], ...]
    geometry: NDArray[np.int64]
    effect: tuple[slice, ...]
    given: int = 0

    @property
    def background(self) -> int:
        """Number of columns before the effects'."""
        start = self.targets[-1][2].stop if self.targets else 6 * self.setups
        return int(start) + len(self.geometry) + self.given

    def index(self, name: str) -> int:
        """Number of a column by its name, or by a start that only this name has (`payload/heavy/mass`)."""
        if name in self.names:
            return self.names.index(name)
        found = [i for i, other in enumerate(self.names) if other.startswith(f"{name}/")]
        if len(found) != 1:
            raise KeyError(f"{name!r} names {len(found)} of the fitted numbers")
        return found[0]

    @property
    def geometry_slice(self) -> slice:
        stop = self.given_slice.start
        return slice(stop - len(self.geometry), stop)

    @property
    def given_slice(self) -> slice:
        return slice(self.background - self.given, self.background)


def columns(
    problem: Problem,
    effects: Sequence[Effect],
    geometry: bool | Sequence[int] = True,
    given: Sequence[Given] = (),
) -> Columns:
    """The numbers to fit: frames, targets, geometry (all, none, or these columns), given ones, and the
    effects' own."""
    campaign = problem.campaign
    names: list[str] = []
    prior: list[float] = []
    for setup in campaign.setup_names:
        names += [f"frame/{setup}/{key}" for key in GEOMETRY]
        prior += [FRAME_PRIOR] * 6
    targets: list[tuple[int, int | None, slice]] = []
    for k, setup in enumerate(campaign.setup_names):
        for i, label, keys, spread in _free_targets(
            problem, k, TARGET_PRIOR if geometry is True else STATED_TARGET
        ):
            targets.append((k, i, slice(len(names), len(names) + len(keys))))
            names += [f"target/{setup}/{label}/{key}" for key in keys]
            prior += spread
    arm = problem.arm
    chosen = (problem.corrections if geometry else ()) if isinstance(geometry, bool) else geometry
    which = np.array(chosen, dtype=np.int64)
    priors = dict.fromkeys(which.tolist(), GEOMETRY_PRIOR)
    if geometry is True:
        priors |= dict.fromkeys(problem.hidden_corrections, LEVER_PRIOR)
        priors |= dict.fromkeys(problem.flange_stays, AS_STATED)
    for column in which.tolist():
        slot, component = divmod(column, 6)
        names.append(f"geometry/{arm.slot_names[slot]}/{GEOMETRY[component]}")
        prior.append(priors[column][component // 3])
    for item in given:
        names += [f"given/{name}" for name in effect_names(item.effect)]
        prior.append(item.std)
    slices, start = [], len(names)
    for effect in effects:
        names += effect_names(effect)
        prior += effect.prior(problem).tolist()
        slices.append(slice(start, len(names)))
        start = len(names)
    setups = len(campaign.setup_names)
    return Columns(tuple(names), np.array(prior), setups, tuple(targets), which, tuple(slices), len(given))


def effect_names(effect: Effect) -> list[str]:
    """Names of an effect's parameters: cause, place, form, parameter (`gear_ratio/joint_3/relative`)."""
    where = [f"{part:g}" if isinstance(part, float) else part for part in effect.where.keys().values()]
    path = "/".join(part for part in (effect.cause, *where, effect.variant) if part)
    return [f"{path}/{p.name}" for p in effect.params]


def _free_targets(
    problem: Problem, setup: int, known_to: float
) -> list[tuple[int | None, str, tuple[str, ...], list[float]]]:
    """Targets of a set-up that are fitted: index (None: all as one body), name, keys, priors. known_to: [m]
    of those that are stated."""
    campaign = problem.campaign
    seen = problem.seen[campaign.poses.setup == setup].any(axis=0)
    free = [i for i, target in enumerate(campaign.targets) if seen[i] and not target.fixed]
    stated = [campaign.targets[i].xyz is not None for i in free]
    if campaign.six_dof and free:
        spread = [known_to] * 3 + [0.2] * 3 if all(stated) else [UNKNOWN_TARGET] * 3 + [FRAME_PRIOR] * 3
        return [(None, "body", GEOMETRY, spread)]
    return [
        (i, campaign.targets[i].name, ("x", "y", "z"), [known_to if known else UNKNOWN_TARGET] * 3)
        for i, known in zip(free, stated, strict=True)
    ]


def body_motion(places: Array) -> Array:
    """(3T, 6) motion of places (T, 3) by shift and turn of all about their centroid."""
    return body_jacobian(places - places.mean(axis=0)).reshape(-1, 6)
