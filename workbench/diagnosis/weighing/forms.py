"""All forms of all components: weighed at once beside a set, or in the places of its members."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from ...robot.kinematics import Array
from ..priors import PRIORS
from .chosen import Chosen, Member, columns_of
from .components import Component
from .reduced import Index, Reduced
from .weight import SCALES, Weight, most_of, table_of

TINY = 1e-9
SLACK = 1e-3  # log odds: far more than rounding

Asked = TypeVar("Asked")
Found = TypeVar("Found")


class Forms:
    """The forms of components, those with equally many columns weighed together."""

    def __init__(self, reduced: Reduced, components: Sequence[Component]) -> None:
        self.reduced, self.components = reduced, components
        forms = [(k, form) for k, component in enumerate(components) for form in component.forms]
        parts = [part for own in reduced.parts for part in own]
        self._start = np.array([part.start for part in parts], int)
        self._width = np.array([part.stop - part.start for part in parts], int)
        self._wrong_sign = np.array([form.wrong_sign for _, form in forms])
        self._log_share = np.concatenate([[], *(component.log_shares for component in components)])
        main = np.array([form.main for _, form in forms], int)
        self._own = np.where(main < self._width, main, 0)  # 0: no companions follow
        certain = np.array([components[k].certain for k, _ in forms], bool)[:, None]
        bends = np.array([components[k].by_loads for k, _ in forms], bool)[:, None]
        self._ruled_out = (bends & (PRIORS.largest < SCALES)) | (certain & (PRIORS.smallest > SCALES))
        self._weights = dict[tuple[frozenset[Member], int], Weight]()
        self._most = dict[tuple[frozenset[Member], Member, tuple[int, ...]], Array]()
        ends = np.cumsum([0, *(len(component.forms) for component in components)])
        self._of = [np.arange(a, b) for a, b in pairwise(ends.tolist())]

    def weigh(
        self, chosen: Chosen, numbers: Sequence[int], without: NDArray[np.int64] | None = None
    ) -> list[Weight]:
        """Weights of components, by their numbers (P,), beside a set, or each beside all of it but a member,
        by its number (P,); once each, as searches come back to the same sets."""
        every = frozenset(chosen.members)
        gone = [] if without is None else without.tolist()
        rest = {i: every - {chosen.members[i]} for i in set(gone)}
        asked = list(zip([rest[i] for i in gone] or [every] * len(numbers), numbers, strict=True))

        def weighed(new: list[int]) -> list[Weight]:
            some = [numbers[n] for n in new]
            return self._weighed(chosen, some, None if without is None else without[new])

        return _once(self._weights, asked, weighed)

    def _weighed(
        self,
        chosen: Chosen,
        numbers: Sequence[int],
        without: NDArray[np.int64] | None,
    ) -> list[Weight]:
        """As `weigh`."""
        rows, counts, first = self._rows(numbers)
        gone = None if without is None else np.repeat(without, counts)
        takes = [chosen.explained] if without is None else [chosen.explained_without(i) for i in without]
        explained = np.repeat(np.resize(takes, len(numbers)), counts)
        table = np.empty((len(rows), len(SCALES)))
        for here, block in self._alike(rows):
            S, u = chosen.left_of(block, None if gone is None else gone[here])
            own = self._wrong_sign[rows[here]], self._own[rows[here]]
            table[here] = table_of(self.reduced, S, u, explained[here], *own)
        table += self._log_share[rows, None]
        table[self._ruled_out[rows]] = -np.inf
        most = np.maximum.reduceat(table.max(axis=1), first)
        each = np.exp(table - np.repeat(most, counts)[:, None]).sum(axis=1)
        every = np.add.reduceat(each, first)
        alone = np.add.reduceat(np.where(self._own[rows] == 0, each, 0.0), first)
        more = np.full(len(numbers), np.inf)
        np.subtract(np.log(every), np.log(np.where(alone > 0, alone, 1.0)), where=alone > 0, out=more)
        out = []
        for i, (k, at, count) in enumerate(zip(numbers, first.tolist(), counts.tolist(), strict=True)):
            form, scale = divmod(int(table[at : at + count].argmax()), len(SCALES))
            odds = float(most[i] + np.log(every[i]) + self.components[k].log_odds)
            out.append(Weight(odds, form, float(SCALES[scale]), float(more[i])))
        return out

    def most(self, chosen: Chosen, numbers: Sequence[int], members: Sequence[int]) -> Array:
        """(P, M) log odds that components cannot exceed in the places of members of a set; once each."""
        every, others = frozenset(chosen.members), tuple(numbers)
        asked = [(every, chosen.members[i], others) for i in members]

        def limits(new: list[int]) -> Array:
            return self._limits(chosen, numbers, [members[n] for n in new]).T

        found = _once(self._most, asked, limits)
        return np.stack(found, axis=1)

    def _limits(self, chosen: Chosen, numbers: Sequence[int], members: Sequence[int]) -> Array:
        """As `most`.

        Without a member the others leave more of everything, u + v and S + H Hᵀ in the place of u and S: with
        S in that of S + H Hᵀ a component takes more off χ², and its freedom costs less.
        """
        rows, _, first = self._rows(numbers)
        rest = np.array([chosen.explained_without(i) for i in members])
        table = np.empty((len(rows), len(members)))
        for here, block in self._alike(rows):
            S, u = chosen.left_of(block)
            more = chosen.given_back(block, members)
            most = most_of(self.reduced, S, u, more, rest, self._own[rows[here]])
            most[self._ruled_out[rows[here]]] = -np.inf
            top = most.max(axis=1)
            table[here] = top + np.log(np.exp(most - top[:, None]).sum(axis=1))  # SciPy's takes far longer
        table += self._log_share[rows, None]
        prior = np.array([self.components[k].log_odds for k in numbers])
        return np.asarray(np.logaddexp.reduceat(table, first, axis=0) + prior[:, None] + SLACK)

    def together(self, chosen: Chosen, others: Sequence[Member]) -> tuple[Array, Array]:
        """(m,) what each of some components takes off χ² beside a set, in its form and scale, and (m, m) what
        each two take together, were each as large as by itself or smaller."""
        columns = [columns_of(self.reduced, other) for other in others]
        widths = np.array([len(own) for own in columns])
        v, q = [np.zeros(0)] * len(others), np.zeros(len(others))
        for width in np.unique(widths).tolist():
            here = np.flatnonzero(widths == width)
            S, u = chosen.left_of(np.stack([columns[i] for i in here]))
            precision = np.array([others[i].scale ** -2 for i in here.tolist()])
            held = S + precision[:, None, None] * np.eye(width)
            likeliest = np.linalg.solve(held, u[..., None])[..., 0]
            q[here] = (u * likeliest).sum(axis=1)
            for i, own in zip(here.tolist(), likeliest, strict=True):
                v[i] = own
        ends = np.cumsum([0, *widths])
        shape = len(self.reduced.S), len(others)
        s = chosen.products_of(csc_array((np.concatenate(v), np.concatenate(columns), ends), shape))
        alone = np.outer(q, q)
        return q, alone * (q[:, None] + q - 2 * s) / np.maximum(alone - s**2, TINY * (1 + alone))

    def _rows(self, numbers: Sequence[int]) -> tuple[Index, Index, Index]:
        """The forms of components, how many each has, and where its first stands among them."""
        counts = np.array([len(self._of[k]) for k in numbers])
        return np.concatenate([self._of[k] for k in numbers]), counts, np.cumsum(counts) - counts

    def _alike(self, rows: Index) -> Iterator[tuple[Index, Index]]:
        """Those with equally many columns, and their columns (F, p), one width after the other."""
        widths = self._width[rows]
        for width in np.unique(widths).tolist():
            here = np.flatnonzero(widths == width)
            yield here, self._start[rows[here], None] + np.arange(width)


def _once(
    known: dict[Asked, Found], asked: Sequence[Asked], work: Callable[[list[int]], Iterable[Found]]
) -> list[Found]:
    """What is asked for, of which `work` finds what is not known yet, by its numbers among all asked for."""
    new = [n for n, one in enumerate(asked) if one not in known]
    if new:
        known.update(zip([asked[n] for n in new], work(new), strict=True))
    return [known[one] for one in asked]
