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

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import logsumexp

from ...robot.kinematics import Array
from ..weighing.weight import SCALES, WEIGHTS
from .candidates import Candidate, Shape
from .decision import Decided

ALONG = 0.5  # probability that another error of a joint changed where one did


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
