"""The likeliest set of components at its own fit: found, fitted, found again, until it stays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...effects import line as gear_line
from ...effects.base import Effect
from ...effects.unnamed import products, unnamed
from ...effects.unnamed.joints import Product
from ...identification.fit import ROUGH, Fit, refit
from ...identification.heldout import heldout
from ...identification.noise import Covariance, log_precision
from ..candidates import ways_to_wander
from ..noise.noise_choice import from_residual
from ..noise.scatter import CLEAR, alike, beyond_all, with_scatter
from ..weighing.acts_through import needs_of
from ..weighing.by_itself import worth_offering
from ..weighing.chosen import Chosen, Member
from ..weighing.components import (
    Component,
    beside_forms,
    cause_components,
    line_component,
    nameless_components,
    step_components,
)
from ..weighing.places_of_steps import likely_steps
from ..weighing.reduced import Index, reduce
from ..weighing.remainder import GLOBAL_LEVEL, Remainder, remainder
from ..weighing.replication import enough_for_halves
from ..weighing.scan import HIGHEST, LOWEST, Line, scan
from ..weighing.screen import chance_of
from ..weighing.sets import Competition
from .stages import rms_mm

ROUNDS = 5
CLEARER = 4.0  # gain in χ² that moves a setting, or pays for a further number
BETTER = 0.99  # of the held-out error: what counts as an improvement of a round
LOOSE = 30.0  # usual sizes: a prior that holds nothing
MOST_SCATTERING = 2  # joints that are looked at for functions of two others
LIKELIER = 3.0  # log evidence, twenty times: what a search from elsewhere has to find more
BY_CHANCE = 0.05  # of as much by a function that does nothing: what wanders so little hides in no scatter
FEWEST = 10  # poses among which something that wanders in time is looked for
LEAST_LINE = 12.0  # χ²(2) of a peak of the scan from which it may compete


@dataclass(frozen=True, eq=False)
class Round:
    """One round: the fit that the components were compared at, the set that this found, the fit with it, and
    `whole`, the one with what its causes have beside their forms as well. left_mm: what sets leave on poses
    held out, as far as somebody asked."""

    at: Fit
    found: Fit
    whole: Fit
    competition: Competition
    members: list[Member]
    left_mm: dict[tuple[Member, ...], float] = field(default_factory=dict, repr=False)

    @property
    def at_home(self) -> bool:
        """Whether the set was compared at its own fit, and not under what others left unexplained."""
        return set(self.at.model.effects) == set(self.found.model.effects)

    def evidence(self, stated: Covariance) -> float:
        """log evidence of the data, up to what is the same for every set and every scatter beyond what was
        `stated`: the likelihood of its own fit, and what members and scatter cost."""
        more = np.count_nonzero(beyond_all(self.found, stated))
        own = log_precision(self.whole.whitener) - 0.5 * self.whole.chi2
        cost = self.competition.cost(Chosen(self.competition.reduced, self.members))
        return own + cost - 0.5 * CLEAR * more

    @property
    def in_time(self) -> bool:
        """Whether anything of its set goes with time."""
        return any("time" in effect.uses for effect in self.found.model.effects)

    def is_of(self, other: Round) -> bool:
        """Whether it found the same set."""
        return set(self.found.model.effects) == set(other.found.model.effects)


@dataclass(frozen=True, eq=False)
class Begun:
    """What a search goes on from: a fit, labels of the components of a set, gear lines."""

    at: Fit
    labels: Sequence[str] = ()
    lines: Sequence[Line] = ()


def converged(
    geometry: Fit,
    candidates: Sequence[Effect],
    noise_dof: float,
    noise_known: bool,
    since: Begun | None = None,
) -> Round:
    """The likeliest set (`_converged`); since: what was found already. Under the scatter of a few poses of a
    joint no gear would show that made it: where these scatter, causes alone are tried as well, and the
    likelier of both is it. Nor would what wanders in time, which is much of a scatter that is estimated
    without it: where less is left beyond that, the search begins there as well, and what it finds so, in time
    too, is it where that is clearly likelier."""
    stated = geometry.noise
    sided = [effect for effect in candidates if effect.uses == {"side"}]
    begun = _begun(geometry, sided)
    found = _converged(geometry, since or Begun(begun), candidates, noise_dof, noise_known)
    if not noise_known or begun is geometry:  # nothing scatters that could hide anything
        return found
    if not enough_for_halves(geometry.model.problem) and beyond_all(begun, stated).any():
        alone = _converged(geometry, Begun(geometry), candidates, noise_dof, noise_known, scatters=False)
        found = max(found, alone, key=lambda one: one.evidence(stated))
    enough = len(geometry.model.problem.q) >= FEWEST
    for wandering in ways_to_wander(geometry.model.problem, candidates) if enough else []:
        if chance_of(begun, wandering) > BY_CHANCE:
            continue
        less = _begun(geometry, [*sided, wandering])
        if alike(less.noise, begun.noise):
            continue
        other = _converged(geometry, Begun(less), candidates, noise_dof, noise_known, wanders=True)
        if other.in_time and other.evidence(stated) > found.evidence(stated) + LIKELIER:
            found = other
    return found


def _converged(
    geometry: Fit,
    begun: Begun,
    candidates: Sequence[Effect],
    noise_dof: float,
    noise_known: bool,
    scatters: bool = True,
    wanders: bool = False,
) -> Round:
    """The likeliest set, found again at its own fit until it stays; of sets that do not stay,
    or predict clearly worse than another did, the one that predicts best what it did not see, its causes by
    their own forms. scatters: joints may; wanders: it ends with the first round where
    that finds nothing in time: most of what wanders is seen at once where nothing hides it.

    The joints' scatter beside it is in the noise from the start, and shrinks as causes are found: a cause
    must stand out of it. So does a noise that nobody knows; and one that is known, where the best set leaves
    more than that, is what it leaves: else the data would be believed in what no member can say. What causes
    have beside their forms is no scatter, no noise and no other line: of a large one it would hide all that
    is there beside it.
    A set that stays is judged at its own fit.
    """
    at, labels, lines = begun.at, begun.labels, begun.lines
    base, whole, errors, before = geometry.noise, at, list[float](), set(at.model.effects)
    stated = base
    best = None
    for _ in range(ROUNDS):
        lines = _with_lines(whole, lines)
        steps = list(likely_steps(whole.lasting))
        competition = _competition(at, candidates, lines, steps, base, noise_dof)
        members = competition.best(labels)
        effects = effects_of(competition, members)
        scaled = scaled_of(competition, members)
        beside = list(beside_forms(scaled, at.model.problem, effects))
        bands = list(beside_forms([one for one in scaled if one[0].ordered], at.model.problem, effects))
        labels = [competition.components[m.component].label for m in members]
        if not noise_known:
            at_base = refitted(replace(at, noise=base), [*effects, *beside])
            base = from_residual(at_base)[0]
        found, whole = _fitted(at if noise_known else at_base, effects, beside, base, scatters)
        after, with_all = found, whole
        errors.append(rms_mm(heldout(_with_more(found, bands))))
        left = remainder(whole, noise_known)
        if noise_known and (base is not stated or left.p < GLOBAL_LEVEL):
            base = stated.times(max(1.0, base.usual / stated.usual * _misfit(left, noise_dof)))
            noise = _scattering(whole, base, scatters)
            after = standing(replace(found, noise=noise), found.model.effects)
            whole = _with_more(after, beside)
        now = Round(at, found, with_all, competition, members)
        same, before = set(effects) == before, set(effects)
        settled = same and alike(at.noise, after.noise)
        stays = settled and BETTER * errors[-1] < min(errors)
        if best is None or errors[-1] < min(errors[:-1]) or stays or (now.at_home and now.is_of(best)):
            best = now
        at = after
        del competition, now  # the columns of all components take much room
        nothing = wanders and len(errors) == 1 and not best.in_time
        if settled or nothing or _no_better(errors):
            break
    assert best is not None, "no round"
    return best


def refitted(near: Fit, effects: Sequence[Effect]) -> Fit:
    """A fit with these effects; one that would make the arm too soft to stand is left out."""
    return near if tuple(effects) == near.model.effects else standing(near, effects)


def standing(near: Fit, effects: Sequence[Effect]) -> Fit:
    """As `refitted`, fitted anew under the noise of `near` whatever effects it has."""
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


def _scattering(result: Fit, base: Covariance, scatters: bool) -> Covariance:
    """A noise with the scatter that a fit leaves; without that of joints, unless these may."""
    noise = with_scatter(result, base)
    return noise if scatters else replace(noise, joint=base.joint)


def _fitted(
    near: Fit, effects: Sequence[Effect], beside: Sequence[Effect], base: Covariance, scatters: bool
) -> tuple[Fit, Fit]:
    """A fit with these effects, and one with what stands `beside` their forms as well, under the noise with
    the scatter that the latter leaves: what that moves scatters by no chance."""
    result = refitted(near, effects)
    whole = _with_more(result, beside)
    noise = _scattering(whole, base, scatters)
    if alike(noise, result.noise):
        return result, whole
    result = standing(replace(result, noise=noise), result.model.effects)
    return result, _with_more(result, beside)


def _with_more(result: Fit, beside: Sequence[Effect]) -> Fit:
    """A fit with what stands beside its effects' forms as well."""
    return refitted(result, [*result.model.effects, *beside])


def _begun(geometry: Fit, explained: Sequence[Effect]) -> Fit:
    """The fit to begin with, under the scatter that is left beyond what some effects explain: neither a play
    nor what wanders in time may hide in the scatter that it makes."""
    noise = with_scatter(refitted(geometry, explained), geometry.noise)
    if alike(noise, geometry.noise):
        return geometry
    return refit(replace(geometry, noise=noise), [], ROUGH)


def _of_scattering(at: Fit, base: Covariance) -> Iterator[Effect]:
    """Functions of two other joints: for the joints that scatter most, and those that have such a one."""
    extra = beyond_all(at, base)
    most = [int(j) for j in np.argsort(-extra)[:MOST_SCATTERING] if extra[j] > 0]
    found = [at.model.problem.joint(e.where.joint) for e in at.model.effects if isinstance(e, Product)]
    for j in dict.fromkeys([*most, *found]):
        yield from products(at.model.problem, j)


def _competition(
    at: Fit,
    candidates: Sequence[Effect],
    lines: Sequence[Line],
    steps: Sequence[Sequence[tuple[Effect, float]]],
    base: Covariance,
    noise_dof: float,
) -> Competition:
    """All that competes, at a fit: an instrument's own errors where they show there, or are in it."""
    functions = [*unnamed(at.model.problem), *_of_scattering(at, base)]
    components = [
        *cause_components(at, candidates),
        *(_line(at, line) for line in lines),
        *step_components(at, steps),
        *worth_offering(at, nameless_components(at, functions), noise_dof),
    ]
    return Competition(reduce(at, components, noise_dof), components, needs_of(at, components))


def _misfit(left: Remainder, noise_dof: float) -> float:
    """What a fit leaves, over its noise: as far as this is known with so many degrees of freedom."""
    return float(np.sqrt((noise_dof + left.chi2) / (noise_dof + left.dof)))


def _no_better(errors: Sequence[float]) -> bool:
    """Whether the last two rounds were no better than the best before them."""
    return len(errors) > 2 and min(errors[-2:]) > BETTER * min(errors[:-2])


def effects_of(competition: Competition, members: Sequence[Member]) -> list[Effect]:
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


def scaled_of(competition: Competition, members: Sequence[Member]) -> list[tuple[Effect, float]]:
    """The effects of members' forms, each in its member's scale."""
    parts = competition.components
    return [(e, m.scale) for m in members for e in parts[m.component].forms[m.form].effects]


def worth_of(chosen: Chosen, without: int, main: Index) -> float:
    """What a form's main numbers (its columns `main`) explain beside the others of a set, less a price for
    each."""
    S, u = (x[0] for x in chosen.left_of(main[None], without))
    S[np.diag_indices_from(S)] += LOOSE**-2
    return float(u @ np.linalg.solve(S, u)) - CLEARER * len(main)


def _with_lines(at: Fit, lines: Sequence[Line]) -> list[Line]:
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
    effect = gear_line(problem, problem.arm.names[line.joint], round(line.order, 3))
    return line_component(at, effect, sharpness)
