"""What may explain that campaigns differ: a number that changed, or a cause that all of them have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...effects import catalogue
from ...effects.base import Effect
from ...effects.place import Where
from ...robot.kinematics import Array
from ...robot.schema import GEOMETRY
from ..priors import PRIORS
from ..search.rounds import LOOSE
from ..weighing.components import EVERY_FINER, Component, Form, form_of, log_odds_of
from .courses import any_course, courses
from .occasions import Occasion, with_same_effects

USUAL = 2e-4  # m, rad: usual size of a change of geometry
PLACED = "geometry"  # cause of a number of the geometry


@dataclass(frozen=True, eq=False)
class Shape:
    """One form of a change or of a common cause. base: (R, g) whitened, in prior sizes, over the rows of
    all occasions one after the other; own: (R,) occasion of each; pattern: (K, c) share of it at each
    occasion, of each of the c columns that it has of each number; geometry: columns 6 · slot + component that
    it moves, zero: it is a joint's own; named: name and unit of the numbers where they are not the effects'
    own."""

    base: Array
    own: NDArray[np.int64]
    sizes: Array
    pattern: Array
    effects: tuple[Effect, ...] = ()
    geometry: tuple[int, ...] = ()
    zero: bool = False
    wrong_sign: float = 0.5
    named: tuple[tuple[str, str], ...] = ()

    @property
    def columns(self) -> Array:
        """(R, g · c) where the occasions have it."""
        each = self.base[:, :, None] * self.pattern[self.own][:, None, :]
        return np.asarray(each.reshape(len(self.base), -1))

    @property
    def courses(self) -> int:
        """c: columns of each number; of more than one, each occasion has its own level."""
        return self.pattern.shape[1]

    @property
    def width(self) -> int:
        """g · c: all columns."""
        return len(self.sizes) * self.courses

    def levels(self, values: Array) -> Array:
        """(K, g, ...) at each occasion, of values (g · c, ...) of the columns."""
        each = values.reshape(len(self.sizes), self.courses, *values.shape[1:])
        return np.asarray(np.einsum("kc,gc...->kg...", self.pattern, each))

    @property
    def main(self) -> int:
        """Numbers that count; behind them come companions."""
        return len(self.geometry) or sum(len(effect.params) for effect in self.effects)

    @property
    def free(self) -> bool:
        """Whether its numbers are the weights of a free function."""
        return any(effect.free for effect in self.effects)

    def held(self, scale: float) -> Array:
        """(g · c,) in prior sizes, how its numbers are held where it was found at a scale: an effect's own
        loosely; its companions, and the weights of a free function, as they were found."""
        out = np.full(len(self.sizes), scale)
        if not self.free:
            out[: self.main] = LOOSE
        return np.repeat(out, self.courses)

    def at(self, pattern: Array) -> Shape:
        """The same with other shares of the occasions, (K,) or (K, c)."""
        return replace(self, pattern=np.asarray(pattern, dtype=np.float64).reshape(len(pattern), -1))

    def is_at(self, pattern: Array) -> bool:
        """Whether it has these shares (K,)."""
        return self.courses == 1 and np.array_equal(self.pattern[:, 0], pattern)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A cause at one place: common to all occasions, or changed: by one event between them, or to a level of
    its own at each. side: whose it is."""

    cause: str
    where: Where
    change: bool
    side: str
    shapes: tuple[Shape, ...]
    log_odds: float

    @property
    def quantity(self) -> tuple[str, Where, bool]:
        """What several events may change."""
        return self.cause, self.where, self.change

    @property
    def local(self) -> bool:
        """Whether it is of what a joint does where it was measured alone."""
        return any(effect.local for shape in self.shapes for effect in shape.effects)

    @property
    def any_course(self) -> bool:
        """Whether it says all that events may do."""
        return self.shapes[0].courses > 1

    @property
    def component(self) -> Component:
        forms = [
            Form((), np.repeat(s.sizes, s.courses), s.effects * s.courses, s.wrong_sign) for s in self.shapes
        ]
        return Component((self.cause, self.where), tuple(forms), self.log_odds, self.change)


def candidates_of(
    occasions: Sequence[Occasion], whole: Problem, effects: Sequence[Effect]
) -> list[Candidate]:
    """All of them. effects: of the catalogue, at every place that the joined campaigns can show."""
    alike = with_same_effects(occasions)
    shared, may_be = occasions[0].fit.model.effects, occasions[0].may_be
    out = list(_geometry(occasions, whole))
    places: dict[object, list[Effect]] = {}
    seen = [e for kind in catalogue().values() for e in kind.places(whole) if e.acts == "instrument"]
    every = [*effects, *(one for one in (*shared, *seen) if one not in effects)]
    for effect in filter(may_be, every):
        places.setdefault(effect.key, []).append(effect)
    counts: dict[str, int] = {}
    for own in places.values():
        counts[own[0].cause] = counts.get(own[0].cause, 0) + 1
    known = {effect.key for effect in shared}
    for own in places.values():
        effect, sites = own[0], counts[own[0].cause]
        together = [tuple(own)] if effect.together and len(own) > 1 else []
        if effect.key not in known and effect in effects and not _later_load(effect, occasions[0]):
            finer = [fine for one in own for fine in one.finer()[::EVERY_FINER]]
            shapes = [
                *(_shape(alike, (e,)) for e in (*own, *finer) if e.whole),
                *(_shape(alike, t) for t in together),
            ]
            out += _common(effect, shapes, log_odds_of(effect, sites))
        shapes = [replace(_shape(occasions, (e,)), wrong_sign=0.5) for e in own if e.whole]
        shapes = [shape for shape in shapes if shape.base.any()]
        if shapes:
            out += _changes(effect.key, side_of(effect), shapes, whole.arm.n)
    if any(one.problem.warmth is None for one in occasions):
        out += _growth(occasions, whole)
    return out


def _later_load(effect: Effect, first: Occasion) -> bool:
    """Whether an effect is of a payload that the first campaign does not have: what it is off its statement
    came with the campaign that states it."""
    payload, c = effect.where.payload, first.problem.campaign
    there = {c.tool_name, *(c.payload_names[i] for i in c.poses.payload)}
    return payload is not None and payload not in there


def own_of(occasions: Sequence[Occasion]) -> NDArray[np.int64]:
    """(R,) occasion of each whitened row."""
    return np.repeat(np.arange(len(occasions)), [one.fit.r.size for one in occasions])


def side_of(effect: Effect) -> str:
    """Whose an effect is: the robot's, the load's, the instrument's, or the surroundings'."""
    if effect.acts == "instrument":
        return "instrument"
    if effect.where.payload is not None:
        return "load"
    return "surroundings" if effect.uses & {"time", "temperature"} else "robot"


def _changes(key: tuple[str, Where], side: str, shapes: Sequence[Shape], sites: int) -> Iterator[Candidate]:
    """A change by each of the events that may have made it, since a quantity may change more than once; and
    of what is one number, to any level at each occasion. sites: joints, for every cause: no cause gains by
    sitting at few places, since it is a place that something happens to."""
    count = len(shapes[0].pattern)
    single = [shape for shape in shapes if len(shape.sizes) == 1] if count > 2 else []
    p = PRIORS.cause / sites / (count - 1 + bool(single))
    log_odds = float(np.log(p / (1 - p)))
    for first in range(1, count):
        forms = [
            shape.at(course)
            for shape in shapes
            for course in courses(first, count, len(shape.sizes), shape.free)
        ]
        yield Candidate(*key, True, side, tuple(forms), log_odds)
    if single:
        forms = [shape.at(any_course(count)) for shape in single]
        yield Candidate(*key, True, side, tuple(forms), log_odds)


def _common(effect: Effect, shapes: Sequence[Shape], odds: float) -> Iterator[Candidate]:
    shapes = tuple(shape for shape in shapes if shape.base.any())
    if shapes:
        yield Candidate(effect.key[0], effect.key[1], False, side_of(effect), shapes, odds)


def _shape(occasions: Sequence[Occasion], effects: tuple[Effect, ...]) -> Shape:
    """Effects over the rows of all occasions, in the sizes of where they show most."""
    forms = [form_of(one.fit, effects, occasions[0].fit.model.problem) for one in occasions]
    sizes = np.min([form.sizes for form in forms], axis=0)
    columns = [form.columns.reshape(-1, len(sizes)) * sizes for form in forms]
    pattern = np.ones((len(occasions), 1))
    wrong_sign = forms[0].wrong_sign
    return Shape(np.concatenate(columns), own_of(occasions), sizes, pattern, effects, wrong_sign=wrong_sign)


def _geometry(occasions: Sequence[Occasion], whole: Problem) -> Iterator[Candidate]:
    """The zero of each joint; and where each joint sits on the link before it, one number or all."""
    arm = whole.arm
    for j, axial in enumerate(arm.axial):
        zero = replace(moved(occasions, (int(axial),)), zero=True)
        yield from _changes((PLACED, Where(joint=arm.names[j])), "robot", [zero], arm.n)
        every = tuple(range(6 * (j + 1), 6 * (j + 2)))
        single = [moved(occasions, (c,)) for c in every if c != axial]
        where = Where(joint=arm.names[j], link=arm.links[j])
        yield from _changes((PLACED, where), "robot", [*single, moved(occasions, every)], arm.n)


def moved(occasions: Sequence[Occasion], columns: tuple[int, ...]) -> Shape:
    """Corrections of the geometry, 6 · slot + component each, at all occasions."""
    blocks = []
    for one in occasions:
        own = one.fit.J[:, :, one.fit.columns.geometry_slice]
        at = [int(np.flatnonzero(one.fit.columns.geometry == c)[0]) for c in columns]
        blocks.append(own[:, :, at].reshape(-1, len(columns)) * USUAL)
    sizes, every = np.full(len(columns), USUAL), np.ones((len(occasions), 1))
    return Shape(np.concatenate(blocks), own_of(occasions), sizes, every, geometry=columns)


def _growth(occasions: Sequence[Occasion], whole: Problem) -> Iterator[Candidate]:
    """A warmer arm where nobody wrote the temperature down: all links longer by the same share. A rack or
    scale that is longer is as another ratio of its joint."""
    warm = [_at(one.problem, 21.0) for one in occasions]
    kinds = [effect for kind in catalogue().values() for effect in kind.places(warm[0])]
    warmed = [e for e in kinds if e.uses == {"temperature"} and e.where == Where()]
    for effect in filter(occasions[0].may_be, warmed):
        blocks = []
        for one, problem in zip(occasions, warm, strict=True):
            G = effect.jacobian(problem, one.fit.line, np.zeros(1)) * effect.params[0].typical
            blocks.append(np.matmul(one.fit.whitener, G).reshape(-1, 1))
        sizes = np.array([effect.params[0].typical])
        named = (("growth", "1"),)
        every = np.ones((len(occasions), 1))
        shape = Shape(np.concatenate(blocks), own_of(occasions), sizes, every, (effect,), named=named)
        if shape.base.any():
            yield from _changes(effect.key, side_of(effect), [shape], whole.arm.n)


def _at(problem: Problem, temperature: float) -> Problem:
    c = problem.campaign
    return replace(problem, campaign=c.with_poses(temperature=np.full(c.n_poses, temperature)))


def numbers_of_shape(shape: Shape) -> tuple[tuple[str, str], ...]:
    """Name and unit of each main number."""
    if shape.named:
        return shape.named
    if shape.effects:
        return tuple((p.name, p.unit) for effect in shape.effects for p in effect.params)
    names = [GEOMETRY[c % 6] for c in shape.geometry]
    return tuple((name, "rad" if name.startswith("r") else "m") for name in names)
