"""Which changes, and which causes common to all occasions, explain the data: the competition."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...campaign.problem import Problem
from ...effects.base import UNKNOWN, Effect
from ...effects.place import Where
from ...robot.kinematics import Array
from ..noise.noise_choice import known_dof
from ..priors import PRIORS
from ..search.rounds import worth_of
from ..weighing.chosen import Chosen, Member, Shares
from ..weighing.reduced import Reduced
from ..weighing.sets import Competition
from .candidates import Candidate, Shape, candidates_of
from .covered import carried_change, covered
from .occasions import Occasion, with_same_effects
from .search import Search
from .steadiness import unsteady
from .system import Mask, Solved, System, reduced_of, relinearised, solve, system_of

SURVIVES = 1e-4  # share of a column's length² that frames, targets and all else must leave; loads leave less
SAME = 0.9999  # correlation of two numbers of the geometry from which they are one and the same
ROUNDS = 2


Quantity = tuple[str, Where, bool]
Witness = tuple[Mask, float, list[int]]  # rows, a factor on their noise, the members (by their numbers)


@dataclass(frozen=True, eq=False)
class Hidden:
    """A number of the geometry whose change cannot be seen, or is the same as another's."""

    candidate: Candidate
    shape: Shape
    same_as: str | None


@dataclass(frozen=True, eq=False)
class Instead:
    """All numbers with another candidate in a member's place, which has no numbers of its own then. odds:
    over the member's; values, half: as of `Solved`."""

    member: int
    odds: float
    values: Array
    half: Array


@dataclass(frozen=True, eq=False)
class Decided:
    """What the competition found. reduced: over all `candidates`; shares: per member, as in `sets`, with as
    much more noise as it is unsteady by, together: by all poses that can speak of it; solved: all numbers
    with the members' own, held loosely; mute: quantities that differ, but not in a pose that can speak of a
    change."""

    system: System
    candidates: tuple[Candidate, ...]
    reduced: Reduced
    members: tuple[Member, ...]
    shares: tuple[Shares, ...]
    together: tuple[Shares, ...]
    hidden: tuple[Hidden, ...]
    solved: Solved
    mute: frozenset[Quantity]

    def shape(self, member: Member) -> Shape:
        return self.candidates[member.component].shapes[member.form]

    @cached_property
    def chosen(self) -> Chosen:
        return Chosen(self.reduced, self.members)

    @cached_property
    def instead(self) -> list[Instead]:
        return list(_instead_of_members(self))

    def factor(self, pattern: Array) -> float:
        """On standard deviations of what differs between occasions, (K, c) by their shares of it: from what
        is left, and where that has a shape, from poses that only one side was in."""
        return self.solved.factor * carried_change(self.system, pattern)

    def part(self, i: int) -> slice:
        """Columns of the i-th member in `solved`."""
        lengths = [self.shape(m).width for m in self.members]
        return slice(sum(lengths[:i]), sum(lengths[: i + 1]))


def _instead_of_members(decided: Decided) -> Iterator[Instead]:
    """Everything that may as well stand in a member's place."""
    n, length = decided.solved.background, len(decided.solved.values)
    for i, (member, share) in enumerate(zip(decided.members, decided.shares, strict=True)):
        own = max(share.get(member.component, 0.0), PRIORS.faintest_rival)
        for k, p in share.items():
            if k is None or k == member.component or p < PRIORS.faintest_rival * own:
                continue
            shapes, scales = [decided.shape(m) for m in decided.members], [m.scale for m in decided.members]
            shapes[i] = _likeliest_form(decided, i, k)
            found = solve(decided.system, shapes, scales)
            ends = n + np.cumsum([0, *(shape.width for shape in shapes)])
            values, half = np.zeros(length), np.zeros((length, found.half.shape[1]))
            values[:n], half[:n] = found.values[:n], found.half[:n]
            for j in (j for j in range(len(shapes)) if j != i):
                at = slice(n + decided.part(j).start, n + decided.part(j).stop)
                values[at], half[at] = found.values[ends[j] : ends[j + 1]], found.half[ends[j] : ends[j + 1]]
            yield Instead(i, p / own, values, half)


def _likeliest_form(decided: Decided, i: int, k: int) -> Shape:
    """The form of a candidate that explains most in the place of the i-th member."""
    shapes, parts = decided.candidates[k].shapes, decided.reduced.parts[k]

    def worth(form: int) -> float:
        numbers = parts[form].start + np.arange(shapes[form].main * shapes[form].courses)
        return worth_of(decided.chosen, i, numbers)

    return shapes[max(range(len(shapes)), key=worth)]


def decide(occasions: Sequence[Occasion], whole: Problem, effects: Sequence[Effect]) -> Decided:
    """The likeliest changes, linearised anew at what the first round found. Until something is found all have
    the same effects: at each campaign's own, what is common to them would explain that these differ."""
    noise_dof = min(known_dof(one.prepared.noise, one.fit.noise.dof) for one in occasions)
    occasions = with_same_effects(occasions)
    for last in range(ROUNDS):
        system = system_of(occasions)
        every = candidates_of(occasions, whole, effects)
        reduced = reduced_of(system, every, noise_dof)
        candidates, reduced, hidden = _distinct(every, reduced)
        competition = Search(reduced, candidates)
        members = competition.best()
        together, shares = _shares(system, every, candidates, competition, members, noise_dof)
        of = [candidates[m.component] for m in members]
        there = [i for i, by in enumerate(zip(of, together, shares, strict=True)) if _is_there(*by)]
        gone = [candidates[m.component] for i, m in enumerate(members) if i not in there]
        mute = frozenset(one.quantity for one in gone if one.local)
        members, shares = [members[i] for i in there], [shares[i] for i in there]
        together = [together[i] for i in there]
        shapes = [candidates[m.component].shapes[m.form] for m in members]
        solved = solve(system, shapes, [m.scale for m in members])
        if last < ROUNDS - 1:
            occasions = relinearised(system, shapes, solved)
    return Decided(
        system, tuple(candidates), reduced, tuple(members), tuple(shares), tuple(together), tuple(hidden),
        solved, mute,
    )  # fmt: skip


def _shares(
    system: System,
    every: Sequence[Candidate],
    candidates: Sequence[Candidate],
    competition: Competition,
    members: Sequence[Member],
    noise_dof: float,
) -> tuple[list[Shares], list[Shares]]:
    """The probabilities, by all poses that can speak of each member, and with as much more noise as it is
    unsteady by. every: all candidates, candidates: those that compete."""

    def shares_of(some: Competition) -> list[Shares]:
        found = zip(members, some.shares(members), strict=True)
        return [_of_quantities(candidates, member, share) for member, share in found]

    def least(found: Sequence[Shares], witnesses: Iterable[Witness]) -> list[Shares]:
        out = list(found)
        for rows, factor, own in witnesses:
            if not rows.any():
                for i in own:
                    out[i] = {None: 1.0}
                continue
            reduced = replace(reduced_of(system, every, noise_dof, rows), parts=competition.reduced.parts)
            others = shares_of(Competition(_carried(reduced, factor), competition.components))
            for i in own:
                k = members[i].component
                if others[i].get(k, 0.0) < out[i].get(k, 0.0):
                    out[i] = others[i]
        return out

    together = least(shares_of(competition), _able(system, candidates, members))
    steady = least(together, _unsteady(system, candidates, members))
    return together, [_told(all_, some) for all_, some in zip(together, steady, strict=True)]


def _is_there(candidate: Candidate, together: Shares, least: Shares) -> bool:
    """Whether a member shows as unsteady as it is (`least`); or surely does by all poses, if it has a name:
    what has none differs where the model does not fit for that alone."""
    sure = together[None] < 1.0 - PRIORS.named and candidate.cause != UNKNOWN
    return sure or least[None] < PRIORS.absent


def _told(together: Shares, least: Shares) -> Shares:
    """Of a member, by all poses and as unsteady as it is: where that says that it may be nothing,
    what it is if it is something is told by all."""
    nothing = least[None]
    if nothing < PRIORS.absent or together[None] >= PRIORS.absent:
        return least
    there = (1.0 - nothing) / (1.0 - together[None])
    return {None: nothing, **{k: there * p for k, p in together.items() if k is not None}}


def _carried(reduced: Reduced, factor: float) -> Reduced:
    """What the data say where their noise is larger by a factor, and as many fewer of them show how large it
    is."""
    share = factor**-2
    return replace(
        reduced,
        S=reduced.S.times(share),
        u=share * reduced.u,
        chi2=share * reduced.chi2,
        dof=share * reduced.dof,
    )


def _able(system: System, candidates: Sequence[Candidate], members: Sequence[Member]) -> Iterator[Witness]:
    """What can speak of some members: all poses, their noise with what the model lacks in postures that one
    side of a change has alone; of what a joint does where it was measured alone (`Effect.local`), those where
    it was on either side."""
    every = np.ones(len(system.pose), dtype=bool)
    told: dict[tuple[bytes, float], Witness] = {}
    for i, member in enumerate(members):
        candidate = candidates[member.component]
        shape = candidate.shapes[member.form]
        if not candidate.change:
            continue
        ways = [(every, carried_change(system, shape.pattern))]
        if any(effect.local for effect in shape.effects):
            ways.append((covered(system, shape.pattern, candidate.where.joint), 1.0))
        for rows, factor in ways:
            if factor > 1.0 or not rows.all():
                told.setdefault((rows.tobytes(), factor), (rows, factor, []))[2].append(i)
    yield from told.values()


def _unsteady(
    system: System, candidates: Sequence[Candidate], members: Sequence[Member]
) -> Iterator[Witness]:
    """All poses, their noise as much larger as each member scatters more from posture to posture. Where the
    noise does not explain what is left, a change is one that all postures show alike: what only some show may
    be what the model lacks there."""
    if not system.misfit or not members:
        return
    shapes, scales = [candidates[m.component].shapes[m.form] for m in members], [m.scale for m in members]
    every = np.ones(len(system.pose), dtype=bool)
    for i, factor in enumerate(unsteady(system, shapes, scales, solve(system, shapes, scales))):
        if factor > 1.0:
            yield every, factor, [i]


def _of_quantities(candidates: Sequence[Candidate], member: Member, share: Shares) -> Shares:
    """A member's probabilities by what changed, whenever it did: of each quantity by its likeliest event, of
    the member's own by the member."""
    lead = {candidates[member.component].quantity: member.component}
    out: Shares = {None: share.get(None, 0.0)}
    for k in sorted((k for k in share if k is not None), key=lambda k: -share[k]):
        of = lead.setdefault(candidates[k].quantity, k)
        out[of] = out.get(of, 0.0) + share[k]
    return out


def _distinct(
    candidates: Sequence[Candidate], reduced: Reduced
) -> tuple[list[Candidate], Reduced, list[Hidden]]:
    """Without numbers of the geometry that cannot be seen, or that another number does already."""
    kept, parts, hidden = [], [], []
    lead: dict[bytes, list[tuple[str, int]]] = {}
    for candidate, own in zip(candidates, reduced.parts, strict=True):
        shapes, places = [], []
        for shape, part in zip(candidate.shapes, own, strict=True):
            if len(shape.geometry) == 1:
                length = float((shape.columns[:, 0] ** 2).sum())
                left = float(_between(reduced, part.start, part.start))
                if left < SURVIVES * max(length, 1e-12):
                    hidden.append(Hidden(candidate, shape, None))
                    continue
                seen = lead.setdefault(shape.pattern.tobytes(), [])
                twin = next((name for name, c in seen if _alike(reduced, part.start, c)), None)
                if twin is not None:
                    hidden.append(Hidden(candidate, shape, twin))
                    continue
                seen.append((label_of(candidate, shape), part.start))
            shapes.append(shape)
            places.append(part)
        if any(len(shape.geometry) < 2 for shape in shapes):  # else no number of it can be seen
            kept.append(replace(candidate, shapes=tuple(shapes)))
            parts.append(tuple(places))
    return kept, replace(reduced, parts=tuple(parts)), hidden


def _alike(reduced: Reduced, i: int, j: int) -> bool:
    lengths = _between(reduced, i, i) * _between(reduced, j, j)
    return abs(_between(reduced, i, j)) > SAME * np.sqrt(lengths)


def _between(reduced: Reduced, i: int, j: int) -> float:
    return float(reduced.S.between(np.array([i]), np.array([j]))[0, 0])


def form_of(candidate: Candidate, shape: Shape) -> str:
    """What changed, in words, and in which of its forms where there are several."""
    forms = {effect.form for one in candidate.shapes for effect in one.effects}
    form = shape.effects[0].form if len(forms) > 1 else ""
    return ", ".join(filter(None, [label_of(candidate, shape), form]))


def label_of(candidate: Candidate, shape: Shape | None = None) -> str:
    """What changed, in words; without a shape whatever form of it."""
    where, form = candidate.where, shape or candidate.shapes[0]
    if not form.geometry:
        return form.effects[0].label
    if form.zero:
        return f"{where.joint} zero"
    if shape is None or len(form.geometry) > 1:
        return f"{where.link} (where it carries {where.joint})"
    component = form.geometry[0] % 6
    kind = "tilt about" if component >= 3 else "offset along"
    return f"{where.link} ({kind} {'xyz'[component % 3]} of {where.joint})"
