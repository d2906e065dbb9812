"""From a prepared campaign to the causes that explain it: one competition of causes and free functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np

from ...effects.base import UNKNOWN, Effect
from ...effects.place import Where
from ...effects.unnamed.at_once import stands_anew
from ...identification.fit import Fit, refit
from ...identification.heldout import heldout
from ...robot.kinematics import Array
from ..data_faults.moved_setup import Step, moved_by
from ..noise.noise_choice import known_dof
from ..noise.scatter import beyond_all
from ..prepared import Prepared
from ..priors import PRIORS
from ..weighing.chosen import Chosen, Member, Shares
from ..weighing.components import Component, Key, bare, beside_forms
from ..weighing.reduced import Index, Reduced, reduce
from ..weighing.remainder import ordinary_mm, rp_mm
from ..weighing.replication import (
    InParts,
    Part,
    agreed,
    enough_for_halves,
    joined,
    power,
    renamed,
    replicated,
    searched_in_parts,
    shown_by,
)
from ..weighing.scan import Line
from .rounds import BETTER, CLEARER, LOOSE, Begun, Round, converged, effects_of, refitted, scaled_of, standing
from .stages import Group, rms_mm

SHOWS = 6.0  # χ²(2) of a gear's line: one of chance is as large once in twenty
UNUSUAL = 0.1  # of the noise: what it may change by and still be the one that was known


@dataclass(frozen=True, eq=False)
class Selection:
    """The likeliest set, strongest member first. fit: with its effects; shares: per member, the
    probability of each component in its place, None: of nothing. unrepeated: members that one part of the
    data takes for something else: in the fit, but without a name; scatter: (n,) one sigma [rad, m] of the
    joints beyond the noise; faint: causes that bring too little to be named beside what has no name.
    misfit: the noise is none that was known, or something has no name: the likelihood is too sure; agreed:
    causes that parts of the data then find by themselves; gains_mm: what each cause brings on poses held out,
    once that was looked at; beside: effects of the fit that a cause has beside its form, and whose; against:
    causes without a name that would be springs of less than no compliance, too large to be true, or nothing
    but what stands beside their form; in_parts: what parts of the data found by themselves, where these were
    searched."""

    fit: Fit
    components: tuple[Component, ...]
    members: tuple[Member, ...]
    shares: tuple[Shares, ...]
    reduced: Reduced
    unrepeated: tuple[Member, ...]
    scatter: Array
    faint: frozenset[Key] = frozenset()
    misfit: bool = False
    agreed: frozenset[Key] = frozenset()
    gains_mm: Mapping[Key, float] = field(default_factory=dict)
    beside: Mapping[Effect, Key] = field(default_factory=dict)
    against: frozenset[Key] = frozenset()
    in_parts: InParts | None = None

    def named(self, effect: Effect) -> bool:
        """Whether an effect of the fit stands for a member that has a name, and is not held by others."""
        keys = [bare(self.components[m.component].key) for m in self.members]
        named = effect.cause != UNKNOWN and effect.key in keys and effect.key not in self.faint
        return named and not effect.is_held

    @property
    def groups(self) -> list[Group]:
        """Named effects of one cause and place together, strongest first, and what they have beside them: of
        lines of a gear those that show first, the largest of them leading."""
        effects, found = self.fit.model.effects, dict[Key, list[int]]()
        for i, effect in enumerate(effects):
            if self.named(effect):
                found.setdefault(effect.key, []).append(i)
        for own in found.values():
            if effects[own[0]].ordered:
                own.sort(key=self._shown, reverse=True)
        lead = {key: effects[own[0]] for key, own in found.items()}
        for i, effect in enumerate(effects):
            if self.beside.get(effect) in found and not self.named(effect):
                found[self.beside[effect]].append(i)
        return [(lead[key], own) for key, own in found.items()]

    def without_step(self, near: Fit) -> Begun:
        """What a search may begin with once steps are set-ups of their own. near: a fit of these."""
        effects, names = self.fit.model.effects, near.model.problem.arm.names
        kept = [e for e in effects if e not in self.beside and stands_anew(e) is None]
        components = [self.components[member.component] for member in self.members]
        labels = [one.label for one in components if stands_anew(one.effect) is None]
        lines = [
            Line(names.index(str(e.where.joint)), e.where.order, self.fit.wald(i))
            for i, e in enumerate(effects)
            if e in kept and e.where.order is not None
        ]
        return Begun(standing(replace(near, noise=self.fit.noise), kept), labels, lines)

    @property
    def steps(self) -> list[Step]:
        """Steps in time that are as sure as what has a name, those first that make most of the points."""
        found = list[tuple[float, Step]]()
        for member, share in zip(self.members, self.shares, strict=True):
            for effect, worth_mm in self.each_of(member):
                step = stands_anew(effect)
                if step and share[member.component] >= PRIORS.named:
                    found.append((worth_mm, Step(step.kind, int(step.first), moved_by(self.fit, step))))
        return [step for _, step in sorted(found, key=lambda one: -one[0])]

    def each_of(self, member: Member) -> Iterator[tuple[Effect, float]]:
        """The effects of a member's form, as the fit has them, and the RMS length [mm] of what each makes of
        the points."""
        at = 0
        for effect in self.components[member.component].forms[member.form].effects:
            own = slice(at, at := at + len(effect.params))
            yield effect.sized(member.scale), self.worth_mm(member, own)

    def _shown(self, i: int) -> tuple[bool, float]:
        """Whether the fit's i-th effect shows, and how large it is."""
        return self.fit.wald(i) > SHOWS, float(np.linalg.norm(self.fit.state.values[i]))

    @property
    def nameless(self) -> list[int]:
        """Numbers of the fit's effects that have no name."""
        named = {i for _, own in self.groups for i in own}
        return [i for i in range(len(self.fit.model.effects)) if i not in named]

    def worth_mm(self, member: Member, part: slice = slice(None)) -> float:
        """RMS length [mm] of what a member, or a part of its numbers, makes of the points."""
        members = self.members if member in self.members else [member]
        chosen, i = Chosen(self.reduced, members), members.index(member)
        index, beta = chosen.index[chosen.own[i]][part], chosen.beta[chosen.own[i]][part]
        S = self.reduced.S.between(index, index)
        return 1e3 * self.fit.usual * float(np.sqrt(3 * (beta @ S @ beta) / self.reduced.dof))


def compete(prepared: Prepared, candidates: Sequence[Effect], since: Selection | None = None) -> Selection:
    """The likeliest set of causes, gear lines and free functions. since: what was found of the same poses
    before a step in time parted them: the search goes on from there, and what parts of them found by
    themselves stands."""
    geometry, source = prepared.geometry, prepared.noise.source
    problem = prepared.problem
    enough = enough_for_halves(problem)

    def of_part(poses: Index) -> tuple[Sequence[Component], Sequence[Shares]]:
        own, _, found = _likeliest(prepared.some(poses), candidates)
        return own.competition.components, found

    known = since.in_parts if since else None
    with ExitStack() as stack:
        in_parts = searched_in_parts(problem, of_part)
        fresh = enough and known is None
        told = stack.enter_context(in_parts) if fresh and source == "residual" else None
        best, members, shares = _likeliest(prepared, candidates, since)
        components = best.competition.components
        nameless = [components[m.component].nameless for m in members]
        as_known = _as_known(best.found, geometry, best.competition.reduced.noise_dof)
        misfit = source == "residual" or not as_known or any(nameless)
        if misfit and fresh and not all(nameless):
            known = (told or stack.enter_context(in_parts))()
    if not misfit or known is None:
        return _selected(best, members, shares, candidates, geometry, misfit)
    members, shares, certain = _as_parts_have_it(best, members, shares, known.told(components))
    selected = _selected(best, members, shares, candidates, geometry, misfit, certain)
    return replace(selected, in_parts=known)


def _as_parts_have_it(
    best: Round, members: list[Member], shares: list[Shares], parts: Sequence[Part]
) -> tuple[list[Member], list[Shares], frozenset[Key]]:
    """The members and their shares, no surer than parts of the data are, with the names that these have for
    them and with what they agree on; and the causes that they agree on."""
    competition = best.competition
    reduced, components = competition.reduced, competition.components

    def seen_in(poses: Index) -> list[tuple[float, float]]:
        own = [components[member.component] for member in members]
        part = reduce(best.at, own, reduced.noise_dof, poses)
        may = power(reduced, part, members, components)
        return list(zip(may, shown_by(part, own, members), strict=True))

    shares = replicated(parts, components, members, shares, seen_in)
    members, shares = _renamed_at_no_loss(best, members, shares)
    certain = agreed(parts, components)
    members, shares = joined(competition, certain, members, shares)
    return members, shares, frozenset(bare(components[k].key) for k in certain)


def _selected(
    best: Round,
    members: Sequence[Member],
    shares: Sequence[Shares],
    candidates: Sequence[Effect],
    geometry: Fit,
    misfit: bool,
    certain: frozenset[Key] = frozenset(),
) -> Selection:
    """The final fit with all members; those for which something elsewhere, or nothing, is there have no
    name."""
    competition = best.competition
    final = _sharpened(refitted(best.found, effects_of(competition, members)), candidates)
    if final.model.effects:
        final = refit(final, final.model.effects)  # the rounds' fits are rough

    def place(k: int) -> Where:
        return competition.components[k].key[1].any_order

    named, unrepeated, sure = list[Member](), list[Member](), list[Shares]()
    for member, share in zip(members, shares, strict=True):
        own, likeliest = member.component, max(share, key=lambda k: share[k])
        here = likeliest is not None and place(likeliest) == place(own)
        if share[None] < PRIORS.absent and (here or share[own] >= PRIORS.absent):
            named.append(member)
            sure.append(share)
        else:
            unrepeated.append(member)
    scatter = beyond_all(best.found, geometry.noise)
    light = tuple(component.without_columns() for component in competition.components)
    return Selection(
        final,
        light,
        tuple(named),
        tuple(sure),
        competition.reduced,
        tuple(unrepeated),
        scatter,
        misfit=misfit,
        agreed=certain,
    )


def _as_known(at: Fit, geometry: Fit, noise_dof: float) -> bool:
    """Whether the noise is the one that was known, or what a fit adds to it is no more than an ordinary
    robot's repeatability."""
    unusual = max(UNUSUAL, np.sqrt(2 / max(noise_dof, 1.0)))  # two sigma of a sigma by so few
    if np.isclose(at.usual, geometry.usual, rtol=unusual):
        return True
    added = at.usual**2 - geometry.usual**2
    return added > 0 and rp_mm(np.sqrt(added)) <= ordinary_mm(geometry.model.problem.robot)


def _renamed_at_no_loss(
    best: Round, members: list[Member], shares: list[Shares]
) -> tuple[list[Member], list[Shares]]:
    """The members with the likelier names of their shares, unless these, with what they have beside their
    forms, predict worse what they did not see: then what is there without a name is better than another's."""
    new, theirs = renamed(best.competition, members, shares)
    same = {m.component for m in new} == {m.component for m in members}
    if same or _heldout_mm(best, members) > BETTER * _heldout_mm(best, new):
        return new, theirs
    return members, shares


def _heldout_mm(best: Round, members: Sequence[Member]) -> float:
    """What members leave on poses held out, RMS, with all that they have beside their forms where that is
    less; once each, as several ask."""
    known, own = best.left_mm, tuple(members)
    if own not in known:
        effects = effects_of(best.competition, members)
        beside = beside_forms(scaled_of(best.competition, members), best.found.model.problem, effects)
        models = [effects, [*effects, *beside]] if beside else [effects]
        known[own] = min(rms_mm(heldout(refitted(best.found, model))) for model in models)
    return known[own]


def _likeliest(
    prepared: Prepared, candidates: Sequence[Effect], since: Selection | None = None
) -> tuple[Round, list[Member], list[Shares]]:
    """The likeliest set, strongest member first, without what is likelier not there."""
    geometry = prepared.geometry
    noise_dof = known_dof(prepared.noise, geometry.noise.dof)
    begin = since.without_step(geometry) if since else None
    best = converged(geometry, candidates, noise_dof, prepared.noise_known, begin)
    members = list(best.members)
    shares = best.competition.shares(members)
    while members:
        least = max(range(len(members)), key=lambda i: shares[i][None])
        if shares[least][None] < PRIORS.absent:
            break
        del members[least]  # one at a time: two that stand in for each other are not both superfluous
        shares = best.competition.shares(members)
    # forms are not as true as the search takes them: of two that may be, what predicts better decides
    members, shares = renamed(best.competition, members, shares, below=PRIORS.absent)
    members, shares = _renamed_at_no_loss(best, members, shares)
    order = sorted(
        range(len(members)), key=lambda i: -Chosen(best.competition.reduced, [members[i]]).explained
    )
    return best, [members[i] for i in order], [shares[i] for i in order]


def _sharpened(result: Fit, candidates: Sequence[Effect]) -> Fit:
    """The fit with settings (a soft zone's width) where the data want them, to first order."""
    effects = list(result.model.effects)
    for i, effect in enumerate(effects):
        related = [other for other in candidates if other.key == effect.key and other.finer()]
        others = list(dict.fromkeys([effect, *related, *(fine for one in related for fine in one.finer())]))
        if len(others) < 2:
            continue
        worth = [_chi2_with(result, i, other) for other in others]
        best = int(np.argmin(worth))
        if worth[best] < worth[0] - CLEARER:
            effects[i] = others[best]
    return refitted(result, effects)


def _chi2_with(result: Fit, i: int, other: Effect) -> float:
    """χ² to first order with another form in the place of the model's i-th effect."""
    loose = LOOSE * result.model.problem.coarse
    G = result.whitened(other).reshape(result.r.size, -1) * [loose * p.typical for p in other.params]
    J, prior, part = result.normal.J.rows, result.columns.prior, result.columns.effect[i]
    r = result.r.ravel() + J[:, part] @ result.state.values[i]
    rest = np.delete(np.arange(len(prior)), part)
    across = (J.T @ G * prior[:, None])[rest]
    g = np.concatenate([(J.T @ r * prior)[rest], G.T @ r])
    own = G.T @ G + np.eye(G.shape[1])
    normal = np.block([[result.normal.A[np.ix_(rest, rest)], across], [across.T, own]])
    return float(r @ r - g @ np.linalg.solve(normal, g))
