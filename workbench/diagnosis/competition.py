"""From a prepared campaign to the causes that explain it: one competition of causes and free functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np

from ..effects import line as gear_line
from ..effects.base import UNKNOWN, Effect
from ..effects.unnamed import products, unnamed
from ..effects.unnamed.joints import Product
from ..identification.fit import ROUGH, Fit, refit
from ..identification.heldout import heldout
from ..identification.noise import Covariance
from ..robot.kinematics import Array
from .acts_through import needs_of
from .chosen import Chosen, Member, Shares
from .components import Component, Key, bare, cause_components, line_component, nameless_components
from .noise_choice import from_residual, known_dof
from .prepared import Prepared
from .priors import PRIORS
from .reduced import Index, Reduced, reduce
from .remainder import GLOBAL_LEVEL, Remainder, ordinary_mm, remainder, rp_mm
from .replication import Part, agreed, joined, power, renamed, replicated, searched_in_parts
from .scan import HIGHEST, LOWEST, Line, scan
from .scatter import POSES_PER_JOINT, alike, positions, with_scatter
from .sets import Competition
from .stages import Group, rms_mm

ROUNDS = 5
CLEARER = 4.0  # gain in χ² that moves a setting, or pays for a further number
BETTER = 0.99  # of the held-out error: what counts as an improvement of a round
LOOSE = 30.0  # usual sizes: a prior that holds nothing
MOST_SCATTERING = 2  # joints that are looked at for functions of two others
UNUSUAL = 0.1  # of the noise: what it may change by and still be the one that was known
LEAST_LINE = 12.0  # χ²(2) of a peak of the scan from which it may compete


@dataclass(frozen=True, eq=False)
class Selection:
    """The likeliest set, strongest member first. fit: with its effects; shares: per member, the
    probability of each component in its place, None: of nothing. unrepeated: members that one part of the
    data takes for something else: in the fit, but without a name; scatter: (n,) one sigma [rad, m] of the
    joints beyond the noise; faint: causes that bring too little to be named beside what has no name.
    misfit: the noise is none that was known, or something has no name: the likelihood is too sure; agreed:
    causes that parts of the data then find by themselves; gains_mm: what each cause brings on poses held out,
    once that was looked at."""

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

    def named(self, effect: Effect) -> bool:
        """Whether an effect of the fit stands for a member that has a name."""
        keys = [bare(self.components[m.component].key) for m in self.members]
        return effect.cause != UNKNOWN and effect.key in keys and effect.key not in self.faint

    @property
    def groups(self) -> list[Group]:
        """Named effects of one cause and place together, strongest first."""
        found: dict[Key, Group] = {}
        for i, effect in enumerate(self.fit.model.effects):
            if self.named(effect):
                found.setdefault(effect.key, (effect, []))[1].append(i)
        return list(found.values())

    @property
    def nameless(self) -> list[int]:
        """Numbers of the fit's effects that have no name."""
        return [i for i, effect in enumerate(self.fit.model.effects) if not self.named(effect)]

    def worth_mm(self, member: Member) -> float:
        """RMS length [mm] of what a member makes of the points."""
        chosen = Chosen(self.reduced, self.members if member in self.members else [member])
        own = chosen.own[chosen.members.index(member)]
        index, beta = chosen.index[own], chosen.beta[own]
        S = self.reduced.S[np.ix_(index, index)]
        return 1e3 * self.fit.usual * float(np.sqrt(3 * (beta @ S @ beta) / self.reduced.dof))


def compete(prepared: Prepared, candidates: Sequence[Effect]) -> Selection:
    """The likeliest set of causes, gear lines and free functions."""
    geometry, source = prepared.geometry, prepared.noise.source
    enough = positions(geometry) >= POSES_PER_JOINT * geometry.model.problem.arm.n

    def of_part(poses: Index) -> tuple[Sequence[Component], Sequence[Shares]]:
        own, _, found = _likeliest(prepared.some(poses), candidates)
        return own.competition.components, found

    with ExitStack() as stack:
        in_parts = searched_in_parts(prepared.problem, of_part)
        told = stack.enter_context(in_parts) if enough and source == "residual" else None
        best, members, shares = _likeliest(prepared, candidates)
        at, competition = best.found, best.competition
        reduced, components = competition.reduced, competition.components
        misfit = source == "residual" or not _as_known(at, geometry, reduced.noise_dof)
        misfit = misfit or any(components[m.component].nameless for m in members)
        at_stake = any(not components[m.component].nameless for m in members)
        parts = list[Part]()
        if misfit and at_stake and enough:
            parts = (told or stack.enter_context(in_parts))(components)

    def seen_in(poses: Index) -> list[float]:
        own = [components[member.component] for member in members]
        part = reduce(best.at, own, reduced.noise_dof, poses)
        return power(reduced, part, members, components)

    certain = dict[int, Shares]()
    if parts:
        shares = replicated(parts, components, members, shares, seen_in)
        members, shares = _renamed_at_no_loss(best, members, shares)
        certain = agreed(parts, components)
        members, shares = joined(competition, certain, members, shares)
    final = _sharpened(_refitted(at, _effects(competition, members)), candidates)
    if final.model.effects:
        final = refit(final, final.model.effects)  # the rounds' fits are rough
    shown = [
        share[m.component] == max(share.values()) and share[None] < PRIORS.absent
        for share, m in zip(shares, members, strict=True)
    ]
    unrepeated = [m for m, there in zip(members, shown, strict=True) if not there]
    members = [m for m, there in zip(members, shown, strict=True) if there]
    shares = [share for share, there in zip(shares, shown, strict=True) if there]
    scatter = np.sqrt(np.maximum(at.noise.joint**2 - geometry.noise.joint**2, 0.0))
    light = tuple(component.without_columns() for component in components)
    named, not_named = tuple(members), tuple(unrepeated)
    keys = frozenset(bare(components[k].key) for k in certain)
    return Selection(
        final, light, named, tuple(shares), reduced, not_named, scatter, misfit=misfit, agreed=keys
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
    best: _Round, members: list[Member], shares: list[Shares]
) -> tuple[list[Member], list[Shares]]:
    """The members with the names that the parts have for them, unless these predict worse what they did not
    see: then what is there without a name is better than another's."""

    def error(chosen: Sequence[Member]) -> float:
        return rms_mm(heldout(_refitted(best.found, _effects(best.competition, chosen))))

    new, theirs = renamed(best.competition, members, shares)
    if {m.component for m in new} == {m.component for m in members} or error(members) > BETTER * error(new):
        return new, theirs
    return members, shares


def _likeliest(prepared: Prepared, candidates: Sequence[Effect]) -> tuple[_Round, list[Member], list[Shares]]:
    """The likeliest set, strongest member first, without what is likelier not there."""
    geometry = prepared.geometry
    noise_dof = known_dof(prepared.noise, geometry.noise.dof)
    best = _converged(geometry, candidates, noise_dof, prepared.noise_known)
    members = list(best.members)
    shares = best.competition.shares(members)
    while members:
        least = max(range(len(members)), key=lambda i: shares[i][None])
        if shares[least][None] < PRIORS.absent:
            break
        del members[least]  # one at a time: two that stand in for each other are not both superfluous
        shares = best.competition.shares(members)
    members, shares = renamed(
        best.competition, members, shares
    )  # forms are not as true as the search takes them
    order = sorted(
        range(len(members)), key=lambda i: -Chosen(best.competition.reduced, [members[i]]).explained
    )
    return best, [members[i] for i in order], [shares[i] for i in order]


def _refitted(near: Fit, effects: Sequence[Effect]) -> Fit:
    """A fit with these effects; one that would make the arm too soft to stand is left out."""
    if tuple(effects) == near.model.effects:
        return near
    try:
        return refit(near, effects, ROUGH)
    except ArithmeticError:
        result, kept = refit(near, [], ROUGH), list[Effect]()
    for effect in effects:
        try:
            result = refit(result, [*kept, effect], ROUGH)
        except ArithmeticError:
            continue
        kept.append(effect)
    return result


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
    return _refitted(result, effects)


def _chi2_with(result: Fit, i: int, other: Effect) -> float:
    """χ² to first order with another form in the place of the model's i-th effect."""
    G = result.whitened(other).reshape(result.r.size, -1)
    part = result.columns.effect[i]
    J = result.J.reshape(result.r.size, -1)
    r = result.r.ravel() + J[:, part] @ result.state.values[i]
    rest = np.delete(J * result.columns.prior, np.r_[part], axis=1)
    A = np.concatenate([rest, G * [LOOSE * p.typical for p in other.params]], axis=1)
    g = A.T @ r
    normal = A.T @ A + np.eye(A.shape[1])
    return float(r @ r - g @ np.linalg.solve(normal, g))


def _of_scattering(at: Fit, base: Covariance) -> Iterator[Effect]:
    """Functions of two other joints: for the joints that scatter most, and those that have such a one."""
    extra = at.noise.joint**2 - base.joint**2
    most = [int(j) for j in np.argsort(-extra)[:MOST_SCATTERING] if extra[j] > 0]
    found = [at.model.problem.joint(e.where.joint) for e in at.model.effects if isinstance(e, Product)]
    for j in dict.fromkeys([*most, *found]):
        yield from products(at.model.problem, j)


def _converged(geometry: Fit, candidates: Sequence[Effect], noise_dof: float, noise_known: bool) -> _Round:
    """The likeliest set, found again at its own fit until it stays; of sets that do not stay, the one that
    predicts best what it did not see.

    The joints' scatter beside it is in the noise from the start, and shrinks as causes are found: a cause
    must stand out of it. So does a noise that nobody knows; and one that is known, where the best set leaves
    more than that, is what it leaves: else the data would be believed in what no member can say.
    A set that stays is judged at its own fit.
    """
    base, lines, errors = geometry.noise, list[Line](), list[float]()
    stated, labels, before = base, list[str](), set[Effect]()
    at, best = _fitted(geometry, [], base), None
    for _ in range(ROUNDS):
        lines = _with_lines(at, lines)
        competition = _competition(at, candidates, lines, base, noise_dof)
        members = competition.best(labels)
        effects = _effects(competition, members)
        labels = [competition.components[m.component].label for m in members]
        if not noise_known:
            at_base = _refitted(replace(at, noise=base), effects)
            base = from_residual(at_base)[0]
        after = found = _fitted(at if noise_known else at_base, effects, base)
        errors.append(rms_mm(heldout(found)))
        left = remainder(found, noise_known)
        if noise_known and (base is not stated or left.p < GLOBAL_LEVEL):
            base = stated.times(max(1.0, base.usual / stated.usual * _misfit(left, noise_dof)))
            after = refit(replace(found, noise=with_scatter(found, base)), found.model.effects, ROUGH)
        now = _Round(at, found, competition, members)
        if best is None or errors[-1] < min(errors[:-1]) or (now.at_home and now.is_of(best)):
            best = now
        same, before = set(effects) == before, set(effects)
        settled = same and alike(at.noise, after.noise)
        at = after
        del competition, now  # the columns of all components take much room
        if settled or _no_better(errors):
            break
    assert best is not None, "no round"
    return best


def _competition(
    at: Fit, candidates: Sequence[Effect], lines: Sequence[Line], base: Covariance, noise_dof: float
) -> Competition:
    """All that competes, at a fit."""
    functions = [*unnamed(at.model.problem), *_of_scattering(at, base)]
    components = [
        *cause_components(at, candidates),
        *(_line(at, line) for line in lines),
        *nameless_components(at, functions),
    ]
    return Competition(reduce(at, components, noise_dof), components, needs_of(at, components))


def _misfit(left: Remainder, noise_dof: float) -> float:
    """What a fit leaves, over its noise: as far as this is known with so many degrees of freedom."""
    return float(np.sqrt((noise_dof + left.chi2) / (noise_dof + left.dof)))


def _no_better(errors: Sequence[float]) -> bool:
    """Whether the last two rounds were no better than the best before them."""
    return len(errors) > 2 and min(errors[-2:]) > BETTER * min(errors[:-2])


@dataclass(frozen=True, eq=False)
class _Round:
    """One round: the fit that the components were compared at, the set that this found, the fit with it."""

    at: Fit
    found: Fit
    competition: Competition
    members: list[Member]

    @property
    def at_home(self) -> bool:
        """Whether the set was compared at its own fit, and not under what others left unexplained."""
        return set(self.at.model.effects) == set(self.found.model.effects)

    def is_of(self, other: _Round) -> bool:
        """Whether it found the same set."""
        return set(self.found.model.effects) == set(other.found.model.effects)


def _fitted(near: Fit, effects: Sequence[Effect], base: Covariance) -> Fit:
    """A fit with these effects, under the noise with the scatter that it leaves."""
    result = _refitted(near, effects)
    noise = with_scatter(result, base)
    if alike(noise, result.noise):
        return result
    return refit(replace(result, noise=noise), result.model.effects, ROUGH)


def _effects(competition: Competition, members: Sequence[Member]) -> list[Effect]:
    """The effects that stand for a set: of each cause the form that explains most without its companions, of
    free functions the likeliest, as large as it is likeliest."""
    out = list[Effect]()
    chosen = Chosen(competition.reduced, members)
    for i, member in enumerate(members):
        forms = competition.components[member.component].forms
        form = forms[member.form]
        if not form.held:
            parts = competition.reduced.parts[member.component]
            mains = [part.start + np.arange(f.main) for f, part in zip(forms, parts, strict=True)]
            worth = [worth_of(chosen, i, main) for main in mains]
            form = forms[int(np.argmax(worth))]
        out += [effect.sized(member.scale) for effect in form.effects]
    return out


def worth_of(chosen: Chosen, without: int, main: Index) -> float:
    """What a form's main numbers (its columns `main`) explain beside the others of a set, less a price for
    each."""
    S, u = (x[0] for x in chosen.left_of(main[None], without))
    S[np.diag_indices_from(S)] += LOOSE**-2
    return float(u @ np.linalg.solve(S, u)) - CLEARER * len(main)


def _with_lines(at: Fit, lines: list[Line]) -> list[Line]:
    """Further peaks of the scan, what is in the fit taken out."""
    out = list(lines)
    for line in scan(at):
        near = any(o.joint == line.joint and abs(o.order - line.order) < 0.5 for o in out)
        if line.statistic > LEAST_LINE and not near:
            out.append(line)
    return out


def _line(at: Fit, line: Line) -> Component:
    problem = at.model.problem
    spread = float(np.std(problem.q[:, line.joint]))
    width = np.sqrt(2 * np.pi) / (np.sqrt(line.statistic) * max(spread, 1e-3))
    sharpness = min(1.0, width / line.order / np.log(HIGHEST / LOWEST))
    return line_component(at, gear_line(problem.arm.names[line.joint], round(line.order, 3)), sharpness)
