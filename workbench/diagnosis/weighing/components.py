"""What competes to explain what geometry leaves: causes in their forms, gear lines, functions without a name.

A component is a prior for a pattern in the data: columns with prior sizes. The main columns have size one
(in the effect's usual size), its companions less: how far a real machine may be off the form.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import accumulate, pairwise
from operator import mul

import numpy as np

from ...campaign.problem import Problem
from ...effects.base import UNKNOWN, Effect
from ...effects.place import NOWHERE, Where
from ...identification.fit import Fit
from ...identification.patterns import Pattern
from ...robot.kinematics import Array
from ..priors import PRIORS

Key = tuple[str, Where]
NO_LOAD = 1e-6  # of the largest load in the arm: what bears less does so by rounding, or by a turn of µrad
LITTLE = 1e-2  # of the largest load on a joint: none is so soft that it needs less for its usual motion
UNSEEN = 1e-6  # of the noise: a form that moves no point by more, in its usual size, shows nothing
EVERY_FINER = 3  # of an effect's finer settings, every third is a form of its own


@dataclass(frozen=True, eq=False)
class Form:
    """One form of a component: patterns with g columns together, main columns first, in prior sizes (g,).

    effects: what stands for it in the model. wrong_sign: probability that its first number is negative.
    weight: before the data, over that of other forms.
    """

    patterns: tuple[Pattern, ...]
    sizes: Array
    effects: tuple[Effect, ...]
    wrong_sign: float = 0.5
    weight: float = 1.0

    @property
    def main(self) -> int:
        """Number of its main columns."""
        return sum(len(effect.params) for effect in self.effects)

    @property
    def alone(self) -> Form:
        """Without companions."""
        return replace(self, patterns=self.patterns[: len(self.effects)], sizes=self.sizes[: self.main])

    @property
    def nearly_alone(self) -> Form:
        """With companions in a fraction of their sizes: nobody knows how true a cause is to its form."""
        share = np.where(np.arange(len(self.sizes)) < self.main, 1.0, PRIORS.nearly)
        return replace(self, sizes=share * self.sizes)

    @property
    def columns(self) -> Array:
        """(N, D, g) whitened."""
        return np.concatenate([pattern.columns for pattern in self.patterns], axis=2)

    @property
    def sized(self) -> list[tuple[Pattern, Array]]:
        """Its patterns, each with its prior sizes."""
        ends = accumulate((pattern.amount.shape[-1] for pattern in self.patterns), initial=0)
        parts = (self.sizes[a:b] for a, b in pairwise(ends))
        return list(zip(self.patterns, parts, strict=True))

    @property
    def shows(self) -> bool:
        """Whether any point is moved by it."""
        return any(pattern.most(sizes) > UNSEEN for pattern, sizes in self.sized)

    @property
    def held(self) -> bool:
        """Whether its prior sizes hold its weights in the fit as well: a free function."""
        return all(effect.free for effect in self.effects)


def sized(forms: Iterable[Form]) -> list[tuple[Pattern, Array]]:
    """The patterns of forms, each with its prior sizes."""
    return [pair for form in forms for pair in form.sized]


@dataclass(frozen=True, eq=False)
class Component:
    """A cause at one place, a gear line, or a function without a name. log_odds: before the data; group: kin
    are those of one group alone."""

    key: Key
    forms: tuple[Form, ...]
    log_odds: float
    group: Hashable = None

    @property
    def log_shares(self) -> Array:
        """(F,) log probability of its forms before the data, were it there."""
        weights = np.array([form.weight for form in self.forms])
        return np.asarray(np.log(weights / weights.sum()))

    @property
    def nameless(self) -> bool:
        return self.key[0] == UNKNOWN

    @property
    def alike(self) -> bool:
        """As `is_alike`."""
        return self.effect is not None and is_alike(self.effect)

    @property
    def yields(self) -> bool:
        """Whether it gives in proportion to its load."""
        return any(effect.in_proportion for form in self.forms for effect in form.effects)

    @property
    def loads(self) -> bool:
        """Whether it is a cause that loads an arm otherwise: a mass, a spring, a hose."""
        return self.effect is not None and not self.nameless and self.effect.acts == "load"

    @property
    def by_loads(self) -> bool:
        """Whether it is a cause by which an arm bends under its loads."""
        return not self.nameless and any(effect.by_loads for form in self.forms for effect in form.effects)

    @property
    def certain(self) -> bool:
        """Whether no machine is without it, whatever its size: what has no name, but is always there."""
        return self.nameless and self.effect is not None and self.effect.always

    @property
    def effect(self) -> Effect | None:
        """One of its effects; None of a change of geometry."""
        return next((effect for form in self.forms for effect in form.effects), None)

    @property
    def called(self) -> str:
        """What the field calls it, where its cause does not say it."""
        return self.effect.called if self.effect else ""

    @property
    def pure(self) -> bool:
        """Whether some of its kind are quite true to their form."""
        return any(effect.pure for form in self.forms for effect in form.effects)

    def without_columns(self) -> Component:
        """What stays when its weight is known: the columns take much room."""
        return replace(self, forms=tuple(replace(form, patterns=()) for form in self.forms))

    @property
    def label(self) -> str:
        effect = self.forms[0].effects[0]
        order = "" if self.key[1].order is None else f" {self.key[1].order:g}"
        return f"{effect.label}{order}" + (f" ({effect.variant})" if self.nameless else "")


def is_alike(effect: Effect) -> bool:
    """Whether it is off in all joints alike what the model states of each."""
    return effect.stated and effect.where == NOWHERE


def bare(key: Key) -> Key:
    """A key without the order: what a finding is about."""
    return key[0], key[1].any_order


def by_key(effects: Iterable[Effect]) -> dict[Key, list[Effect]]:
    """Effects by cause and place, in their order."""
    places: dict[Key, list[Effect]] = {}
    for effect in effects:
        places.setdefault(effect.key, []).append(effect)
    return places


def at_once(effects: Sequence[Effect]) -> list[tuple[Effect, ...]]:
    """Of one cause at one place those that may be off together, as one form: all, all but those that only
    some machines have, and those of one part; none where they may not."""
    parts = [tuple(e for e in effects if e.part == part) for part in dict.fromkeys(e.part for e in effects)]
    forms = dict.fromkeys([tuple(e for e in effects if not e.rare), tuple(effects), *parts])
    return [some for some in forms if len(some) > 1] if effects[0].together else []


def cause_components(fit: Fit, candidates: Sequence[Effect]) -> list[Component]:
    """One component for each cause and place; its variants are its forms. What forms share is there once."""
    places, pattern = by_key(candidates), cache(fit.pattern)
    sites = Counter(cause for cause, _ in places)
    out = []
    for key, effects in places.items():
        finer = [other for effect in effects for other in effect.finer()[::EVERY_FINER]]
        forms = [form_of(fit, (e,), pattern=pattern) for e in (*effects, *finer) if e.whole]
        forms += [form_of(fit, some, pattern=pattern) for some in at_once(effects)]
        if effects[0].pure:
            forms += [form.alone for form in forms]
        elif effects[0].nearly:
            forms += [form.nearly_alone for form in forms]
        rarer = [e for e in effects if e.rarer(fit.model.problem)]
        forms += [form_of(fit, (e,), rarer=True, pattern=pattern) for e in rarer]
        forms = _shared([form for form in forms if form.shows])
        if forms:
            out.append(Component(key, tuple(forms), log_odds_of(effects[0], sites[key[0]])))
    return out


def _shared(forms: Sequence[Form]) -> list[Form]:
    """Forms of one shape share its weight: finer settings do not make it more likely than another."""

    def kind(form: Form) -> Hashable:
        return tuple(effect.shape for effect in form.effects), len(form.patterns), form.weight

    alike = Counter(map(kind, forms))
    return [replace(form, weight=form.weight / alike[kind(form)]) for form in forms]


def line_component(fit: Fit, effect: Effect, sharpness: float) -> Component:
    """A gear line of unknown order; sharpness: width of its peak over the whole range (log)."""
    joints = fit.model.problem.arm.n
    odds = PRIORS.line / joints * sharpness
    form = form_of(fit, (effect,))
    forms = (form, form.alone) if effect.pure else (form,)
    return Component((effect.cause, effect.where), forms, float(np.log(odds)))


def step_components(fit: Fit, steps: Sequence[Sequence[tuple[Effect, float]]]) -> list[Component]:
    """Steps at the places where each explains most beside those before it, with the share of all places that
    these are: of a kind, which shares its probability with those like it, the first, and forms with more."""
    counts = Counter(type(own[0][0]) for own in steps)
    out = []
    for own in steps:
        each = [step for step, _ in own]
        more = accumulate((PRIORS.free * share for _, share in own[1:]), mul, initial=1.0)
        forms = [replace(form_of(fit, (*each[: k + 1],)), weight=w) for k, w in enumerate(more)]
        odds = PRIORS.free * own[0][1] / counts[type(each[0])]
        out.append(Component(each[0].key, tuple(forms), float(np.log(odds))))
    return out


def nameless_components(fit: Fit, functions: Iterable[Effect]) -> list[Component]:
    """Functions without a name; those of one kind share its probability, but for what every arm has."""
    every = list(functions)
    counts = Counter(type(one) for one in every)
    out = []
    for one in every:
        form = form_of(fit, (one,))
        if form.shows:
            p = PRIORS.unstated if one.always else PRIORS.free / counts[type(one)]
            out.append(Component(one.key, (form,), float(np.log(p))))
    return out


def log_odds_of(effect: Effect, sites: int) -> float:
    """log odds before the data of a cause at one of its places: more of one that may have any shape. A joint
    for which the model has no stiffness yields, and some of these out of proportion to their load."""
    p = PRIORS.cause * (PRIORS.any_shape if effect.free else 1.0) / sites
    if effect.axial and effect.acts == "yielding" and not effect.stated:
        p = PRIORS.unstated * (1.0 if effect.always else PRIORS.rarer)
    return float(np.log(p / (1 - p)))


def form_of(
    fit: Fit,
    effects: tuple[Effect, ...],
    about: Problem | None = None,
    rarer: bool = False,
    pattern: Callable[[Effect], Pattern] | None = None,
) -> Form:
    """Effects together as one form, each parameter in its usual size; with the companions that they have in a
    problem (default: the fit's own), or with the rarer ones too. pattern: of an effect at the fit."""
    every = with_companions(fit, effects, about or fit.model.problem, rarer)
    patterns = tuple((pattern or fit.pattern)(effect) for effect, _ in every)
    weight = PRIORS.rarer if rarer or any(effect.rare for effect in effects) else 1.0
    return Form(patterns, np.concatenate([own for _, own in every]), effects, _wrong_sign(effects), weight)


def _wrong_sign(effects: Sequence[Effect]) -> float:
    first = effects[0]
    if len(effects) > 1 or len(first.params) > 1 or first.params[0].lower != 0.0:
        return 0.5
    if "side" in first.depends:
        return PRIORS.other_side
    return PRIORS.pushes_back if first.acts == "yielding" else PRIORS.wrong_sign


def with_companions(
    fit: Fit, effects: Sequence[Effect], about: Problem, rarer: bool = False
) -> list[tuple[Effect, Array]]:
    """Effects and behind them their companions in a problem, each with its prior sizes (p,); the rarer ones
    too, if asked for."""
    shares = [(1.0, effect) for effect in effects]
    shares += [pair for effect in effects for pair in effect.companions(about)]
    shares += [pair for effect in effects if rarer for pair in effect.rarer(about)]
    return [(effect, share * usual(fit, effect)) for share, effect in shares]


def beside_forms(
    scaled: Iterable[tuple[Effect, float]], about: Problem, there: Iterable[Effect]
) -> dict[Effect, Key]:
    """What effects in their scales have beside their forms, further parts of their own law and what none
    names, and whose it is: of each function the first, and none that is there already."""

    def place(one: Effect) -> tuple[str, str, Where]:
        return one.cause, "" if one.local and one.cause != UNKNOWN else one.variant, one.where

    found, had = dict[Effect, Key](), {place(e) for e in there}
    for effect, scale in scaled:
        for share, companion in (*effect.companions(about), *effect.rarer(about)):
            of_it = companion.local or companion.cause in (UNKNOWN, effect.cause)
            if of_it and place(companion) not in had:
                found[companion.sized(scale * share)] = effect.key
                had.add(place(companion))
    return found


def usual(fit: Fit, effect: Effect) -> Array:
    """(p,) usual sizes of an effect's parameters at a fit's loads, in a machine as coarse as its own."""
    size = np.array([p.typical for p in effect.params])
    if effect.acts == "yielding":
        size = usual_yield(fit, effect, size)
    return size * fit.model.problem.coarse


def usual_yield(fit: Fit, effect: Effect, typical: Array) -> Array:
    """A yield's usual size: a usual motion at the campaign's largest load, not a number per N·m. A joint
    that bears next to nothing, as an upright one, moves less: else a tilt of the base would show in it."""
    if effect.params[0].unit in ("rad", "m", "1"):
        return typical
    rest = fit.line.prediction
    drawn = effect.drawn(fit.model.problem, rest, np.ones(1))
    most, arm = float(np.abs(drawn.size).max(initial=0.0)), float(np.abs(rest.load.local).max(initial=0.0))
    usual = PRIORS.joint_yields if effect.axial else PRIORS.tilt_yields * effect.lever(rest.arm)
    if most <= NO_LOAD * arm:
        return typical
    if effect.axial:
        loads = rest.arm.own(rest.load.local)
        most = max(most, LITTLE * float(np.abs(loads).max(initial=0.0)))
    return np.array([usual / most])
