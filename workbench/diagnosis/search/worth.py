"""What causes bring on poses that were held out: none stays that brings nothing, and where the likelihood is
too sure, none is surer than by that."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit, stdtr

from ...effects.base import UNKNOWN, Effect
from ...identification.fit import Fit, refit
from ...identification.heldout import heldout
from ...robot.kinematics import Array
from ..priors import PRIORS
from ..weighing.chosen import Chosen
from ..weighing.components import Key, bare
from ..weighing.remainder import remainder
from ..weighing.replication import enough_for_halves
from .competition import Selection
from .stages import Group, rms_mm, without

FAINT = 0.1  # of the noise, or of what is left per axis: a gain that decides nothing
NOTHING = 1e-30  # m²
VOUCHED = 5 / 6  # of a fifth part of the data by four that agree (Laplace's rule of succession)


def worth_it(selection: Selection, noise_known: bool, seed: int) -> Selection:
    """Without effects that bring the tool no nearer to its place on poses that they were not fitted on. Where
    something is left without a name, or to these effects alone, causes that bring less than a tenth of that,
    or of the noise, keep none either.

    Causes that can stand in for each other each bring next to nothing beside the others. So each counts by
    what it brings beside these, or by what it brings to those that are stronger, whichever is more. Those
    that all parts of the data found by themselves stay in the fit, and count as the strongest."""
    kept, error = _pruned(selection, seed)
    kept, error = _without_chance(kept, error, seed)
    left = kept.fit is not selection.fit and remainder(kept.fit, noise_known).scatter
    kept = replace(kept, misfit=kept.misfit or left)
    if kept.misfit:
        kept = as_sure_as_its_gain(kept, seed)
    rest = left or bool(kept.nameless)  # what loses its name below was none: nothing stands beside it
    least = FAINT * max(1e3 * kept.fit.noise.usual, error / np.sqrt(3))
    if rest:
        kept = _without_faint(kept, least, seed)
    kept = _that_bring_something(more_than_a_form(kept), least if rest else 0.0, seed)
    return no_shadow(_that_stand_alone(_sure_together(kept, seed), seed), error, seed)


def _pruned(selection: Selection, seed: int) -> tuple[Selection, float]:
    """Without effects that bring nothing, the least first, as long as nothing else hangs on them; and its RMS
    [mm] on poses held out."""
    kept, error = selection, rms_mm(heldout(selection.fit, seed=seed))
    while kept.fit.model.effects:
        gains = _gains(kept, error, seed)
        for i, effect in enumerate(kept.fit.model.effects):
            if effect.key in kept.agreed:
                gains[i] = np.inf
        worst = int(np.argmin(gains))
        if gains[worst] > 0:
            break
        rest = [effect for i, effect in enumerate(kept.fit.model.effects) if i != worst]
        fit = refit(kept.fit, rest)
        after = rms_mm(heldout(fit, seed=seed))
        if after > error:
            break  # it holds others in place
        kept, error = replace(kept, fit=fit), after
    return kept, error


def _without_chance(kept: Selection, error: float, seed: int) -> tuple[Selection, float]:
    """Without functions that have no name where they bend to a few joint positions alone, of which repeats
    make no more: what lasts is kept if it brings something without what passes (functions of time and order),
    as it is used without it; and all together, if they surely bring most positions nearer. Where there are
    positions enough for parts of the data to be searched alone, no few decide."""
    if enough_for_halves(kept.fit.model.problem):
        return kept, error
    nameless, effects = kept.nameless, kept.fit.model.effects
    passing = [i for i in nameless if effects[i].cause == UNKNOWN and not effects[i].lasting]
    lasting = [i for i in nameless if i not in passing]
    if passing and lasting and without(kept.fit, passing, seed) >= without(kept.fit, nameless, seed):
        kept, error = _left_out(kept, lasting, seed)
    if kept.nameless and _nearer(kept.fit, kept.nameless, seed) < PRIORS.named:
        kept, error = _left_out(kept, kept.nameless, seed)
    return kept, error


def _nearer(fit: Fit, own: Sequence[int], seed: int) -> float:
    """How surely effects bring a position that is held out nearer to its place: by the mean of the logarithm
    of its error over that without them, and its standard error (Student 1908). A position that is far off, as
    at the end of a range, is one among many so; it is most of a mean of squares."""
    with_it, without_it = (_of_positions(fit, seed, out) for out in ((), own))
    less = 0.5 * np.log(np.maximum(without_it, NOTHING) / np.maximum(with_it, NOTHING))
    return float(stdtr(len(less) - 1, _in_errors(less)))


def _of_positions(fit: Fit, seed: int, out: Sequence[int]) -> Array:
    """(K,) [m²] mean over its poses of a joint position's square error, held out, without some effects."""
    position = fit.model.problem.positions
    each = np.nansum(heldout(fit, seed=seed, without=out) ** 2, axis=(1, 2))
    return np.asarray(np.bincount(position, each) / np.bincount(position))


def _in_errors(values: Array) -> float:
    """The mean of values (K,), in its standard errors."""
    return float(values.mean() / max(values.std(ddof=1) / np.sqrt(len(values)), NOTHING))


def _left_out(kept: Selection, out: Sequence[int], seed: int) -> tuple[Selection, float]:
    """Without some of the fit's effects, and its RMS [mm] on poses held out."""
    fit = refit(kept.fit, [effect for i, effect in enumerate(kept.fit.model.effects) if i not in out])
    return replace(kept, fit=fit), rms_mm(heldout(fit, seed=seed))


def _that_bring_something(kept: Selection, least: float, seed: int) -> Selection:
    """With what each cause brings [mm], and without names of those that, of the causes that have one in the
    end, bring nothing, or less than the least; the weakest first."""
    while gains_mm := _gains_mm(kept, seed):
        weakest = min(gains_mm, key=lambda key: gains_mm[key])
        if gains_mm[weakest] > 0 and gains_mm[weakest] >= least:
            break
        kept = replace(kept, faint=kept.faint | {weakest})
    return replace(kept, gains_mm=gains_mm)


def _without_faint(kept: Selection, least: float, seed: int) -> Selection:
    """Beside what has no name, without names of what brings less than the least [mm]."""
    result, nameless = kept.fit, kept.nameless
    together = without(result, range(len(result.model.effects)), seed) - without(result, nameless, seed)
    faint = frozenset(key for key, gain in _gains_mm(kept, seed).items() if min(gain, together) < least)
    return replace(kept, faint=kept.faint | faint)


def _sure_together(kept: Selection, seed: int) -> Selection:
    """No name surer than that it and all weaker ones, or a stronger one and these, together bring poses that
    were held out nearer to their places: two that each bring something beside the other alone prop each
    other up."""
    surest, least = dict[Key, float](), 1.0
    for effect, own, weaker in _one_by_one(kept.groups):
        least = min(least, max(_chance(kept.fit, out, [*own, *weaker], seed) for out in ([], kept.nameless)))
        if effect.key not in kept.agreed:
            surest[effect.key] = least
    return no_surer(kept, surest)


def _that_stand_alone(kept: Selection, seed: int) -> Selection:
    """No name surer than four parts of the data can make it where all that have one, without what has none,
    bring poses that were held out no nearer to their places: a load that shows by what yields to it may be
    sure, and this not be known."""
    fit, named = kept.fit, [i for _, own in kept.groups for i in own]
    if not kept.nameless or not named:
        return kept
    none, alone = (refit(fit, [fit.model.effects[i] for i in some]) for some in ([], named))
    if rms_mm(heldout(alone, seed=seed)) < rms_mm(heldout(none, seed=seed)):
        return kept
    return no_surer(kept, {effect.key: VOUCHED for effect, _ in kept.groups})


def no_shadow(kept: Selection, error: float, seed: int) -> Selection:
    """No name of what bends the arm under its loads surer than four parts of the data can make it, unless it
    makes `PRIORS.shadow` times as much of points held out as what bends it without a name: it may be a part
    of that, as far as anybody knows how arms bend, and parts of one campaign share what it is. error: RMS
    [mm] with all."""
    fit, nameless = kept.fit, kept.nameless
    bends = [i for i in nameless if fit.model.effects[i].by_loads]
    beyond = _made(without(fit, bends, seed), error) if bends else 0.0
    surest = dict[Key, float]()
    for effect, own, weaker in _one_by_one(kept.groups):
        makes = max(
            _made(without(fit, [*beside, *own], seed), without(fit, beside, seed))
            for beside in (nameless, [*nameless, *weaker])
        )
        if effect.by_loads and makes < PRIORS.shadow * beyond:
            surest[effect.key] = VOUCHED
    return no_surer(kept, surest)


def _made(without_it: float, with_it: float) -> float:
    """RMS [mm] of what something makes of the points, of those without it and with it."""
    return float(np.sqrt(max(without_it**2 - with_it**2, 0.0)))


def _by_strength(selection: Selection) -> Iterator[tuple[Effect, list[int], list[int]]]:
    """Each named cause, those that the parts agree on first, then the strongest: one of its effects, the
    numbers of all of these in the fit, and those of the causes that come after it."""
    yield from _one_by_one(sorted(selection.groups, key=lambda group: group[0].key not in selection.agreed))


def _one_by_one(groups: Sequence[Group]) -> Iterator[tuple[Effect, list[int], list[int]]]:
    for k, (effect, own) in enumerate(groups):
        yield effect, own, [i for _, others in groups[k + 1 :] for i in others]


def _gains_mm(selection: Selection, seed: int) -> dict[Key, float]:
    """What each cause takes off the held-out RMS [mm] beside the others that have a name, or to those that
    are stronger, if that is more: causes that can stand in for each other bring nothing beside each other."""
    fit, nameless = selection.fit, selection.nameless
    return {
        effect.key: max(
            without(fit, [*beside, *own], seed) - without(fit, beside, seed)
            for beside in ([], nameless, [*nameless, *weaker])
        )
        for effect, own, weaker in _by_strength(selection)
    }


def as_sure_as_its_gain(selection: Selection, seed: int) -> Selection:
    """No name surer than that it brings poses that were held out nearer to their places than the best of as
    many causes would by chance, if none of them did anything (Šidák 1967); but for those that parts of the
    data found by themselves. What has no name, or else nothing, gets the rest; a cause that leaves nearly all
    of it is faint."""
    fit = selection.fit
    tried = sum(not component.nameless for component in selection.components)
    surest = dict[Key, float]()
    for effect, own, weaker in _by_strength(selection):
        if effect.key in selection.agreed:
            continue
        alone = [*selection.nameless, *weaker]
        surest[effect.key] = max(_chance(fit, beside, own, seed) for beside in ([], alone)) ** (2 * tried)
    return no_surer(selection, surest)


def more_than_a_form(selection: Selection) -> Selection:
    """No name surer than by what it makes of the points beyond the form of any other cause: the share of what
    that makes, whichever in each pose, by which no form is truer."""
    fit, groups = selection.fit, selection.groups
    if len(groups) < 2:
        return selection
    each = [
        np.einsum("ndp,p->nd", fit.J[:, :, part], values)
        for part, values in zip(fit.columns.effect, fit.state.values, strict=True)
    ]
    made = [*fit.beyond_background(np.array([np.sum([each[i] for i in own], axis=0) for _, own in groups]))]
    prices, surest = _prices(selection), dict[Key, float]()
    for k, (effect, _) in enumerate(groups):
        beyond = min(_beyond(made[k], other) for other in [*made[:k], *made[k + 1 :]])
        surest[effect.key] = float(expit(0.5 * (beyond - prices[effect.key])))
    return no_surer(selection, surest)


def _beyond(its: Array, other: Array) -> float:
    """χ² of one thing made of the points (N, D) that a share of another, in each pose, does not make."""
    share = np.sum(its * other, axis=1) / np.maximum(np.sum(other**2, axis=1), NOTHING)
    share = np.clip(share, -PRIORS.form, PRIORS.form)
    return float(((its - share[:, None] * other) ** 2).sum())


def _prices(selection: Selection) -> dict[Key, float]:
    """What the freedom and the prior of each cause cost beside the others, in χ²; of lines the least."""
    chosen, out = Chosen(selection.reduced, selection.members), dict[Key, float]()
    for i, member in enumerate(selection.members):
        component = selection.components[member.component]
        _, price = chosen.price(i, component)
        out[bare(component.key)] = min(price, out.get(bare(component.key), np.inf))
    return out


def no_surer(
    selection: Selection, surest: Mapping[Key, float], instead: Mapping[Key, int] | None = None
) -> Selection:
    """With these probabilities for causes that are surer. What stands for a cause `instead`, of the
    components, gets the rest, or else what has no name, or nothing; a cause that leaves nearly all of it is
    faint."""
    components, instead = selection.components, instead or {}
    nameless = next((m.component for m in selection.members if components[m.component].nameless), None)
    shares = [dict(share) for share in selection.shares]
    for share, member in zip(shares, selection.members, strict=True):
        k = member.component
        most, rest = surest.get(bare(components[k].key), 1.0), instead.get(bare(components[k].key), nameless)
        if share[k] > most:
            share[rest] = share.get(rest, 0.0) + share[k] - most
            share[k] = most
    faint = {key for key, most in surest.items() if most < PRIORS.absent}
    return replace(selection, shares=tuple(shares), faint=selection.faint | faint)


def _chance(fit: Fit, beside: Sequence[int], own: Sequence[int], seed: int) -> float:
    """That effects which do nothing would bring less on poses held out, without those `beside`: by what they
    take off the square error, over its standard error.

    What is left at a position without them is b times what they make there, and a rest; they bring as much as
    b exceeds a half. Its standard error is of the rests (White 1980), each by the b of all other positions
    (MacKinnon & White 1985): that effects do more at one position than at another is no doubt of theirs, and
    that one alone says it is one."""
    rest, without_it = (heldout(fit, seed=seed, without=out) for out in (beside, [*beside, *own]))
    made, position = without_it - rest, fit.model.problem.positions
    its = np.bincount(position, np.nansum(made * without_it, axis=(1, 2)))
    square = np.bincount(position, np.nansum(made**2, axis=(1, 2)))
    others = (its.sum() - its) / np.maximum(square.sum() - square, NOTHING)
    spread = max(float(np.linalg.norm(its - others * square)), NOTHING)
    return float(stdtr(max(len(its) - 1, 1), (its.sum() - 0.5 * square.sum()) / spread))


def _gains(selection: Selection, whole: float, seed: int) -> list[float]:
    """What each effect brings [mm] on poses held out: one without a name beside all, one with a name beside
    the others that have one, or to those that are stronger, if that is more. whole: RMS [mm] with all."""
    fit, nameless = selection.fit, selection.nameless
    named = without(fit, nameless, seed)
    gains = [0.0] * len(fit.model.effects)
    for i in nameless:
        gains[i] = without(fit, [i], seed) - whole
    for _, own, weaker in _by_strength(selection):
        out = [*nameless, *weaker]
        for i in own:
            gains[i] = without(fit, [*nameless, i], seed) - named
            if gains[i] <= 0:
                gains[i] = max(gains[i], without(fit, [*out, i], seed) - without(fit, out, seed))
    return gains
