"""How far the numbers of a change may be off by what is not found rightly beside it.

What was found elsewhere may be something else (`how_sure`): then the number is what it is beside that.

A joint of which one thing changed was mastered anew, taken apart or worn: each of its other errors may not be
what it was either, and what that is in the poses that were measured goes into the number that was found
(omitted variables). A gear that runs out is half a zero where its joint does not turn far: a zero that moved
along with it was told to a third of what it was off by. So each of them stands beside it, as likely as not,
and as large as changes are; what the data have of that counts, and a number is as far off as it then is in
the mean square (`unseen_beside`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import logsumexp

from ...robot.kinematics import Array
from ..priors import PRIORS
from ..search.rounds import worth_of
from ..weighing.weight import SCALES, WEIGHTS
from .candidates import Candidate, Shape
from .system import solve

if TYPE_CHECKING:
    from .decision import Decided

ALONG = 0.5  # probability that another error of a joint changed where one did


@dataclass(frozen=True, eq=False)
class Instead:
    """All numbers with another candidate in a member's place, which has no numbers of its own then. odds:
    over the member's; values, half: as of `Solved`."""

    member: int
    odds: float
    values: Array
    half: Array


def instead_of_members(decided: Decided) -> Iterator[Instead]:
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


def how_sure(decided: Decided, members: Sequence[int]) -> Array:
    """(n + g, ·) half of the covariance of all numbers about their values, for members (by their numbers)
    that change one quantity: by the noise, what may stand in other members' places, and `unseen_beside`."""
    others = [one for one in decided.instead if one.member not in members]
    weights = np.sqrt(
        np.array([1.0, *(one.odds for one in others)]) / (1.0 + sum(one.odds for one in others))
    )
    halves = [weights[0] * decided.solved.half]
    for weight, one in zip(weights[1:], others, strict=True):
        off = (one.values - decided.solved.values) / decided.solved.factor
        halves.append(weight * np.column_stack([one.half, off]))
    return np.concatenate([*halves, unseen_beside(decided, members)], axis=1)


def unseen_beside(decided: Decided, members: Sequence[int]) -> Array:
    """(n + g, ·) more of the half of the numbers' covariance, for members (by their numbers) that change one
    quantity."""
    system, solved = decided.system, decided.solved
    halves = [np.zeros((len(solved.values), 0))]
    fitted = np.concatenate([system.J, *(decided.shape(m).columns for m in decided.members)], axis=1)
    for G in (columns for i in members for columns in _unseen(decided, i)):
        Z = solved.half.T @ (fitted.T @ G)
        S, u = (G.T @ G - Z.T @ Z) / solved.factor**2, G.T @ solved.left / solved.factor**2
        taken = -solved.half @ Z
        odds, own = [np.log1p(-ALONG)], []
        for scale, prior in zip(SCALES, WEIGHTS, strict=True):
            factor = cho_factor(np.eye(len(S)) + scale**2 * S)
            mean = scale**2 * cho_solve(factor, u)
            spread = scale * solve_triangular(factor[0], taken.T, trans="T").T  # cho_factor: upper
            own.append(np.column_stack([spread, taken @ mean]))
            odds.append(np.log(ALONG) + prior + 0.5 * u @ mean - np.log(np.diag(factor[0])).sum())
        weights = np.exp(0.5 * (np.array(odds) - logsumexp(odds)))[1:]
        halves += [weight * half for weight, half in zip(weights, own, strict=True)]
    return np.concatenate(halves, axis=1)


def _unseen(decided: Decided, i: int) -> Iterator[Array]:
    """(R, p) each, in usual sizes, with the course of the i-th member: every other change at its joint."""
    member = decided.members[i]
    where, pattern = decided.candidates[member.component].where, decided.shape(member).pattern
    if where.joint is None or where.link is not None:
        return
    had = {decided.candidates[m.component].quantity for m in decided.members}
    for candidate in decided.candidates:
        here = candidate.where.joint == where.joint and candidate.where.link is None
        if candidate.change and here and candidate.quantity not in had:
            had.add(candidate.quantity)
            for shape in _forms(candidate):
                yield shape.at(pattern).columns[:, : shape.main * pattern.shape[1]]


def _forms(candidate: Candidate) -> Iterator[Shape]:
    """One form; all that come together."""
    had = set[str]()
    for shape in candidate.shapes:
        variant = shape.effects[0].variant if shape.effects and shape.effects[0].together else ""
        if not shape.free and variant not in had:
            had.add(variant)
            yield shape
