"""What can be seen of something hidden: how far it stands out of the noise once geometry is fitted,
and how much of that other causes could take over. All of it without noise, on Drake's own points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.problem import problem_of
from ...diagnosis.candidates import testable
from ...diagnosis.weighing.screen import quadratic, reduce_columns
from ...effects.base import Effect
from ...effects.place import Where
from ...identification.fit import Fit, fit, start_state
from ...identification.model import Model
from ...identification.noise import Covariance
from ...robot.kinematics import Array
from ...simulation.virtual_campaign import Truth, simulate
from .designs import Design
from .hidden import Hidden, together

Key = tuple[str, Where]
TWINS = 1e-4  # share of an effect that its exact twin may leave


@dataclass(frozen=True)
class Sight:
    """A design's clean points with geometry fitted to them under the true noise. truth: what is wrong
    with the robot besides what is hidden."""

    design: Design
    truth: Truth
    seed: int
    fit: Fit

    def shift(self, hidden: Sequence[Hidden], sizes: Sequence[float]) -> Array:
        """(N, T, 3) [m] how what is hidden moves the measured points."""
        moved = clean(self.design.plan, self.truth, hidden, sizes, self.seed).points
        return np.asarray(moved - self.fit.model.problem.campaign.points)

    def products(self, shifts: Sequence[Array], effects: Sequence[Effect] = ()) -> Products:
        """Scalar products of shifts and effects' columns beyond geometry, in units of the noise."""
        columns = [d.reshape(len(d), -1, 1) for d in shifts]
        parts, at = [], len(columns)
        for effect in effects:
            typical = np.array([p.typical for p in effect.params])
            columns.append(
                self.fit.model.effect_jacobian(self.fit.line, effect, np.zeros(len(typical))) * typical
            )
            parts.append(np.arange(at, at + len(typical)))
            at += len(typical)
        G = np.matmul(self.fit.whitener, np.concatenate(columns, axis=2))
        S, _, own = reduce_columns(self.fit, G)
        return Products(S, own, len(shifts), tuple(effects), tuple(parts))

    def values(self, shift: Array, effects: Sequence[Effect]) -> list[Array]:
        """Parameters of effects, fitted together to a shift (N, T, 3): what data without noise would give.
        Held by the fit's priors: a free function without them would take what is the others'."""
        products = self.products([shift], effects)
        typical = [np.array([p.typical for p in effect.params]) for effect in effects]
        priors = [effect.prior(self.fit.model.problem) for effect in effects]
        S = products.S[1:, 1:].copy()
        S[np.diag_indices_from(S)] += (np.concatenate(typical) / np.concatenate(priors)) ** 2
        x = np.linalg.solve(S, products.S[1:, 0])
        return [x[part - 1] * t for part, t in zip(products.parts, typical, strict=True)]


@dataclass(frozen=True)
class Products:
    """S: (g, g); the first columns are shifts, then those of `effects` in units of their typical size."""

    S: Array
    own: Array
    shifts: int
    effects: tuple[Effect, ...]
    parts: tuple[NDArray[np.int64], ...]

    def strength(self, i: int = 0) -> float:
        """Non-centrality λ of a shift given the other shifts."""
        others = [k for k in range(self.shifts) if k != i]
        return float(self.S[i, i]) - self._taken(i, np.array(others, dtype=np.int64))

    def left(self, chosen: Sequence[int]) -> float:
        """λ of the first shift that the chosen effects, fitted freely, leave."""
        columns = [self.parts[k] for k in chosen]
        return float(self.S[0, 0]) - self._taken(0, np.concatenate([*columns, np.zeros(0, dtype=np.int64)]))

    def twins(self, chosen: Sequence[int], effect: Effect) -> bool:
        """Whether the chosen effects can do all that an effect does in these poses."""
        own = self.parts[self.effects.index(effect)]
        columns = np.concatenate([self.parts[k] for k in chosen])
        return all(self.S[i, i] - self._taken(i, columns) < TWINS * self.S[i, i] for i in own)

    def _taken(self, i: int, columns: NDArray[np.int64]) -> float:
        columns = columns[self.own[columns] > 1e-12 * self.own.max()]
        return quadratic(self.S[np.ix_(columns, columns)], self.S[columns, i], self.own[columns])[0]

    def keys(self) -> dict[Key, list[int]]:
        """Effects by cause and place."""
        out: dict[Key, list[int]] = {}
        for k, effect in enumerate(self.effects):
            out.setdefault(effect.key, []).append(k)
        return out


FREE = 12  # numbers of an effect from which it can draw nearly anything: no rival by itself


def look(design: Design, hidden: Sequence[Hidden], seed: int, even: bool = False) -> Sight:
    """The clean campaign of a design, its columns as the hidden causes want them at size 1, and its fit.

    even: the robot's repeatability is left out of the noise, so that strengths are mm at the tool.
    """
    truth = Truth(
        geometry=design.geometry, targets=design.targets, repeatability=np.zeros(len(design.repeatability))
    )
    campaign = clean(design.plan, truth, (), (), seed)
    noise = design.noise
    if even:
        noise = Covariance(noise.sigma, np.zeros_like(noise.joint), noise.weight)
    problem = problem_of(planned_for(campaign, hidden, [1.0] * len(hidden)))
    return Sight(design, truth, seed, fit(Model(problem), start_state(problem), noise))


def clean(
    plan: Campaign, truth: Truth, hidden: Sequence[Hidden], sizes: Sequence[float], seed: int
) -> Campaign:
    """A campaign without noise."""
    forms = [item.form(size) for item, size in zip(hidden, sizes, strict=True)]
    return simulate(planned_for(plan, hidden, sizes), together(truth, *forms), seed=seed)


def planned_for(campaign: Campaign, hidden: Sequence[Hidden], sizes: Sequence[float]) -> Campaign:
    """The campaign with its columns as the hidden causes want them."""
    for item, size in zip(hidden, sizes, strict=True):
        campaign = item.planned(campaign, size)
    return campaign


def seen_at(sight: Sight, hidden: Sequence[Hidden], sizes: Sequence[float]) -> Sight:
    """The same sight with the columns as they are at these sizes."""
    problem = sight.fit.model.problem
    problem = replace(problem, campaign=planned_for(problem.campaign, hidden, sizes))
    return replace(sight, fit=replace(sight.fit, model=replace(sight.fit.model, problem=problem)))


def candidates(sight: Sight, hidden: Sequence[Hidden]) -> list[Effect]:
    """The catalogue at every place, and the hidden causes' own parts where they are not in it."""
    found = testable(sight.fit.model.problem)[0]
    own = [e for item in hidden for e in (item.effect, *item.more) if e is not None]
    found = [effect for effect in found if len(effect.params) < FREE]
    return [*found, *(effect for effect in own if effect not in found)]
