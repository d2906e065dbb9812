"""What is known by other means, held against the data: obeyed as a prior, or contradicted and told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from ..effects.given import CONTRADICTED, Exclusion, Given, exclusions, given_facts, may_be
from ..effects.place import NOWHERE, Parameter
from ..identification.fit import Fit
from ..identification.rows import offset_of
from .candidates import untold
from .found import GivenFact, NotTestable
from .prepared import Prepared, Progress
from .priors import PRIORS
from .search.competition import Selection
from .search.rounds import LOOSE
from .telling.standing import standing

SHARPER = 0.5  # of a given spread: the data know it that much better
SAID_IN = {  # unit → from which size on, times what, in which unit
    "1": ((2e-4, 100.0, "%"), (0.0, 1e6, "ppm")),
    "rad": ((5e-3, 1e3, "mrad"), (0.0, 1e6, "µrad")),
    "m": ((1e-4, 1e3, "mm"), (0.0, 1e6, "µm")),
}

Search = Callable[[Prepared, Sequence[Effect]], tuple[Prepared, Selection]]


@dataclass(frozen=True)
class Searched:
    """The finished search beside what was given: the candidates left, and what became of each fact."""

    prepared: Prepared
    selection: Selection
    candidates: Sequence[Effect]
    said: tuple[GivenFact, ...] = ()
    not_testable: tuple[NotTestable, ...] = ()


def search_with_given(
    prepared: Prepared, candidates: Sequence[Effect], search: Search, progress: Progress = lambda _: None
) -> Searched:
    """The search beside all that is given and not contradicted.

    Everything is searched without it first: a number that is `CONTRADICTED` off what the data say of it, one
    that says nothing, and an excluded cause that they name, are told and not obeyed. The rest becomes
    background, held by its spread. Should the search then pull a number that far, it is left out too.
    """
    problem = prepared.problem
    facts, excluded = given_facts(problem), exclusions(problem)
    free = search(prepared, candidates)
    if not facts and not excluded:
        return Searched(*free, candidates)
    progress("testing causes beside what is given")
    seen = {fact: _seen(free[1], fact) for fact in facts}
    obeyed = [fact for fact in facts if not fact.vague and _pull(fact, *seen[fact]) <= CONTRADICTED]
    named = {one: _named(free[1], one) for one in excluded}
    believed = [one for one in excluded if not named[one]]
    while True:
        left = [effect for effect in candidates if may_be(effect, obeyed, believed)]
        beside = prepared.with_given(tuple(obeyed))
        nothing = not obeyed and len(left) == len(candidates)
        found = free if nothing else search(beside, left)
        alone = {fact: _without_prior(found[1].fit, i) for i, fact in enumerate(obeyed)}
        worst = max(obeyed, key=lambda fact: _pull(fact, *alone[fact]), default=None)
        if worst is None or _pull(worst, *alone[worst]) <= CONTRADICTED:
            break
        seen[worst] = alone[worst]
        obeyed.remove(worst)
    result = found[1].fit
    # of what is kept to, as the data have it beside what was found; of what is not, beside all that may be
    seen |= {fact: value for fact, value in alone.items() if np.isfinite(value[1])}
    said = [_fact(fact, seen[fact], obeyed, result) for fact in facts]
    said += [_excluded(one, named[one], problem) for one in excluded]
    gone = {(e.cause, NOWHERE if one.text.strip() == e.cause else e.where): None
            for one in believed for e in candidates if one.covers(e)}  # fmt: skip
    missing = tuple(NotTestable(cause, "given: it is not there", where) for cause, where in gone)
    return Searched(*found, left, tuple(said), missing)


def _seen(free: Selection, fact: Given) -> tuple[float, float]:
    """Value and standard deviation of a number by the data alone, beside all causes that were found without
    it and whatever could stand in for them: one linear step, from the fit without it."""
    result = free.fit
    own = [i for i, effect in enumerate(result.model.effects) if fact.is_for(effect)]
    found = {effect: None for effect in result.model.effects}
    others = [e for e in _stand_ins(free) if e not in found and not fact.is_for(e)]
    J = result.J.reshape(result.r.size, -1)
    offset = offset_of(result.model, result.columns, result.state)
    r, kept = result.r.ravel(), np.ones(J.shape[1], bool)
    for i in own:
        part = result.columns.effect[i]
        r, kept[part] = r + J[:, part] @ result.state.values[i], False
    blocks = [(J * result.columns.prior)[:, kept]]
    for effect in (*others, fact.effect):
        G = result.whitened(effect).reshape(result.r.size, -1)
        blocks.append(G * [LOOSE * p.typical for p in effect.params])
    A = np.concatenate(blocks, axis=1)
    g = A.T @ r
    g[: int(kept.sum())] -= offset[kept]
    inverse = np.linalg.inv(A.T @ A + np.eye(A.shape[1]))
    size = LOOSE * fact.effect.params[0].typical
    return float(inverse[-1] @ g) * size, float(np.sqrt(inverse[-1, -1])) * size


def _stand_ins(free: Selection) -> dict[Effect, None]:
    """Effects that may be there in the place of those that were found and are not sure enough for a name."""
    unsure = [
        share
        for member, share in zip(free.members, free.shares, strict=True)
        if share[member.component] < PRIORS.named
    ]
    likely = {k for share in unsure for k, p in share.items() if p >= PRIORS.faintest_rival}
    return {e: None for k in likely if k is not None for e in free.components[k].forms[0].effects}


def _without_prior(result: Fit, i: int) -> tuple[float, float]:
    """Value and standard deviation of the i-th given number, what was given taken out again."""
    item = result.model.given[i]
    value, std = result.given_estimate(i)
    precision = std**-2 - item.std**-2
    if precision <= 1e-9 * item.std**-2:
        return item.value, np.inf
    return (value / std**2 - item.value / item.std**2) / precision, precision**-0.5


def _pull(fact: Given, value: float, std: float) -> float:
    """Distance of what was given from what is seen, in combined standard deviations."""
    return abs(value - fact.value) / float(np.hypot(fact.std, std))


def _named(free: Selection, one: Exclusion) -> float:
    """Probability of an excluded cause that the data name; 0 where they do not."""
    found = [e for e in free.fit.model.effects if one.covers(e) and free.named(e)]
    likely = max((standing(free, effect).probability for effect in found), default=0.0)
    return likely if likely >= PRIORS.named else 0.0


def _fact(fact: Given, seen: tuple[float, float], obeyed: Sequence[Given], result: Fit) -> GivenFact:
    given, alone = _parameter(fact, fact.value, fact.std), _parameter(fact, *seen)
    fitted, differs = None, ""
    said = f"{fact.effect.label}: {fact.fact.said}"
    if fact in obeyed:
        i = list(obeyed).index(fact)
        fitted = _parameter(fact, *result.given_estimate(i))
        differs = _differs(result, i)
        confirmed = f" The data confirm it: {differs}." if differs else ""
        sharper = f" With the data: {_plain(fitted)}." if fitted.std < SHARPER * given.std else ""
        silent = _silent(type(fact.effect), result.model.problem)
        sentence = f"Given and kept to: {said}.{confirmed or sharper}{silent}"
    elif fact.vague:
        sentence = (
            f"Given, but it leaves more open than is usual of any robot ({_plain(given)} to the model), so "
            f"the data decide as without it: {said}."
        )
    else:
        model = (
            "as the model has it" if not fact.value else f"{_plain(given, not fact.fact.std)} to the model"
        )
        sentence = (
            f"Given, but the data contradict it: {said} ({model}); the data alone say {_plain(alone)}, "
            f"{_pull(fact, *seen):.1f} standard deviations off. It was not kept to."
        )
    return GivenFact(
        fact.effect.cause, fact.effect.where, fact.fact.said, fact.fact.note, given, alone, fitted,
        fact in obeyed, sentence, differs, not fact.fact.std,
    )  # fmt: skip


def _differs(result: Fit, i: int) -> str:
    """What the i-th given number says, where that is not what the model has and the data say so as well."""
    fact = result.model.given[i]
    alone, spread = _without_prior(result, i)
    if min(abs(fact.value) / fact.std, abs(alone) / spread) <= CONTRADICTED:
        return ""
    value, _ = result.given_estimate(i)
    return fact.effect.sentence(np.array([value])).removesuffix(".")


def _silent(kind: type[Effect], problem: Problem) -> str:
    """A sentence where the data show nothing of a cause in any case; else nothing."""
    why = untold(kind, problem)
    return f" These data say nothing of it: {why}." if why else ""


def _excluded(one: Exclusion, probability: float, problem: Problem) -> GivenFact:
    said = f"no {one.text.strip()}"
    sentence = f"Given and kept to: {said}.{_silent(catalogue()[one.cause], problem)}"
    if probability:
        sentence = (
            f"Given, but the data contradict it: {said}; without it they name this cause with probability "
            f"{probability:.2f}. It was not kept to."
        )
    return GivenFact(one.cause, NOWHERE, said, obeyed=not probability, sentence=sentence)


def _parameter(fact: Given, value: float, std: float) -> Parameter:
    (found,) = fact.effect.report(np.array([value]), np.array([[std**2]]))
    return found


def _plain(p: Parameter, exact: bool = False) -> str:
    """A number with its spread, in a unit in which people say one of this size."""
    size = max(abs(p.value), 0.0 if exact else p.std)
    factor, unit = next(((f, u) for least, f, u in SAID_IN.get(p.unit, ()) if size >= least), (1.0, p.unit))
    value = f"{p.name} {_digits(factor * p.value, 3)}"
    return f"{value} {unit} exactly" if exact else f"{value} ± {_digits(factor * p.std, 2)} {unit}"


def _digits(value: float, digits: int) -> str:
    """So many significant digits, without an exponent where people write none."""
    text = f"{float(f'{value:.{digits}g}'):.10f}".rstrip("0").rstrip(".")
    return text if 1e-6 < abs(value) < 1e7 else f"{value:.{digits}g}"
