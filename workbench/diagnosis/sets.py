"""The search for the set of components with the highest posterior odds, and what could stand in for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from ..robot.kinematics import Array
from .acts_through import Needs
from .components import Component, bare
from .priors import PRIORS
from .reduced import Index, Reduced
from .weight import Forms, Weight, likelihood, prior_weight

MOST = 24
EXPLAINS = 1.0  # log Bayes factor from which a component explains anything at all
EXCHANGES = 4  # rounds of them

Shares = dict[int | None, float]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Member:
    component: int
    form: int
    scale: float


class Chosen:
    """A set of members in the reduced equations: what it explains, and what it leaves of everything.

    With C the set's columns and P their prior precisions: K = S_C (S_CC + P)⁻¹, left S − K S_Cᵀ. One member
    less gives back K_m (M_mm)⁻¹ K_mᵀ, M = (S_CC + P)⁻¹: no need to solve again. about: columns that will be
    asked for; default: all.
    """

    def __init__(self, reduced: Reduced, members: Sequence[Member], about: Index | None = None) -> None:
        self.reduced, self.members = reduced, tuple(members)
        self._about = slice(None) if about is None else about
        self._back = dict[int, tuple[Array, Array]]()
        every = np.arange(len(reduced.u))
        index = [every[reduced.parts[m.component][m.form]] for m in members]
        self.index: Index = np.concatenate(index) if index else np.zeros(0, int)
        ends = np.cumsum([0, *(len(i) for i in index)])
        self.own = [slice(a, b) for a, b in pairwise(ends)]
        precision = [np.full(len(i), m.scale**-2) for i, m in zip(index, members, strict=True)]
        self.precision = np.concatenate(precision) if index else np.zeros(0)

    @cached_property
    def _factor(self) -> tuple[Array, bool]:
        S = self.reduced.S[np.ix_(self.index, self.index)] + np.diag(self.precision)
        return cho_factor(S, check_finite=False)

    @cached_property
    def inverse(self) -> Array:
        return np.asarray(cho_solve(self._factor, np.eye(len(self.index)), check_finite=False))

    @cached_property
    def cross(self) -> Array:
        """(g, c), zero but for the columns that will be asked for."""
        if isinstance(self._about, slice):
            return np.asarray(self.reduced.S[:, self.index])
        out = np.zeros((len(self.reduced.u), len(self.index)))
        out[self._about] = self.reduced.S[np.ix_(self._about, self.index)]
        return out

    @cached_property
    def K(self) -> Array:
        """(g, c), zero as `cross` is."""
        if isinstance(self._about, slice):
            return np.asarray(self.cross @ self.inverse)
        out = np.zeros(self.cross.shape)
        out[self._about] = self.cross[self._about] @ self.inverse
        return out

    @cached_property
    def beta(self) -> Array:
        return np.asarray(self.inverse @ self.reduced.u[self.index])

    @cached_property
    def explained(self) -> float:
        """What the set takes off χ²."""
        return float(self.reduced.u[self.index] @ self.beta) if len(self.index) else 0.0

    def left_of(self, index: NDArray[np.int64], without: int | None = None) -> tuple[Array, Array]:
        """S (F, p, p) and u (F, p) of blocks of columns (F, p) beside the set, or beside all but a member."""
        S = self.reduced.S[index[:, :, None], index[:, None, :]]
        u = self.reduced.u[index]
        if not len(self.index):
            return S, u
        K = self.K[index]
        S = S - K @ self.cross[index].swapaxes(1, 2)
        u = u - K @ self.reduced.u[self.index]
        if without is not None:
            half, back = self._given_back(without)
            Kh = K[:, :, self.own[without]] @ half
            S = S + Kh @ Kh.swapaxes(1, 2)
            u = u + Kh @ back
        return S, u

    def _given_back(self, member: int) -> tuple[Array, Array]:
        """Of a member H with H Hᵀ = (M_mm)⁻¹, and Hᵀ beta_m."""
        if member not in self._back:
            own = self.own[member]
            lower = np.linalg.cholesky(self.inverse[own, own])
            half = solve_triangular(lower, np.eye(len(lower)), lower=True, check_finite=False).T
            self._back[member] = half, half.T @ self.beta[own]
        return self._back[member]

    def explained_without(self, member: int) -> float:
        back = self._given_back(member)[1]
        return self.explained - float(back @ back)

    def price(self, i: int, component: Component) -> tuple[Array, float]:
        """S (p, p) that the other members leave of the i-th, of that component, and what its freedom and its
        prior cost, in χ²."""
        member, own = self.members[i], self.index[self.own[i]]
        S = self.left_of(own[None], i)[0][0]
        freedom = float(np.linalg.slogdet(np.eye(len(S)) + member.scale**2 * S)[1])
        return S, freedom - 2 * prior_weight(component, member.scale)

    @property
    def log_determinant(self) -> float:
        """log |1 + S P⁻¹|: what the set's freedom costs."""
        if not len(self.index):
            return 0.0
        diagonal = np.diag(self._factor[0])
        return float(2 * np.log(np.abs(diagonal)).sum() - np.log(self.precision).sum())


class Competition:
    """The search over sets of components at one linearisation. needs: of a component, those beside which
    alone it competes."""

    def __init__(self, reduced: Reduced, components: Sequence[Component], needs: Needs | None = None) -> None:
        self.reduced, self.components, self.needs = reduced, components, needs or {}
        self.forms = Forms(reduced, components)

    def beside(
        self, chosen: Chosen, without: int | None = None, among: Mask | None = None
    ) -> dict[int, Weight]:
        """Weights of the other components beside a set, or beside all of it but one member."""
        taken = {m.component for i, m in enumerate(chosen.members) if i != without}
        allowed = np.ones(len(self.components), bool) if among is None else among.copy()
        allowed[list(taken)] = False
        for k, needed in self.needs.items():
            allowed[k] &= needed <= taken
        return self._weighed(chosen, without, allowed)

    def _weighed(self, chosen: Chosen, without: int | None, allowed: Mask) -> dict[int, Weight]:
        explained = chosen.explained if without is None else chosen.explained_without(without)
        return self.forms.weigh(lambda index: chosen.left_of(index, without), explained, allowed)

    def score(self, members: Sequence[Member]) -> float:
        """log posterior odds of a set against the empty one."""
        chosen = Chosen(self.reduced, members)
        gained = float(likelihood(self.reduced, 0.0, np.array(chosen.explained)))
        prior = sum(prior_weight(self.components[m.component], m.scale) for m in members)
        return gained - 0.5 * chosen.log_determinant + prior

    def best(self, before: Sequence[str] = ()) -> list[Member]:
        """The better of two searches: everything at once; or causes first, then everything. Where a set was
        found before (labels of its components), the search goes on from there. In the order of the
        components: two searches that end at one set are one, and what follows does not hang on rounding."""
        everything = np.ones(len(self.components), bool)
        if before:
            return self._in_order(self.search(self._again(before), everything))
        causes = np.array([not c.nameless for c in self.components])
        found = [self.search([], everything)]
        if causes.any() and not all(causes[m.component] for m in found[0]):
            found.append(self.search(self.search([], causes), everything))
        return max(map(self._in_order, found), key=self.score)

    @staticmethod
    def _in_order(members: list[Member]) -> list[Member]:
        return sorted(members, key=lambda member: member.component)

    def _again(self, labels: Sequence[str]) -> list[Member]:
        """The components with these labels, each in its likeliest form beside the others."""
        known = {component.label: k for k, component in enumerate(self.components)}
        here = [known[label] for label in labels if label in known]
        own = np.zeros(len(self.components), bool)
        own[here] = True
        weights = self._weighed(Chosen(self.reduced, []), None, own)
        members = [Member(k, weights[k].form, weights[k].scale) for k in here]
        return self.exchanged(members, own)

    def search(self, start: list[Member], among: Mask) -> list[Member]:
        """Additions while any helps, then exchanges, and again until neither does."""
        members = self.grown(list(start), among)
        for _ in range(EXCHANGES):
            better = self.exchanged(members, among)
            if better == members:
                break
            members = self.grown(better, among)
        return members

    def grown(self, members: list[Member], among: Mask) -> list[Member]:
        """The likeliest additions one by one, the members' own forms and scales kept up to date."""
        for _ in range(MOST):
            weights = self.beside(Chosen(self.reduced, members), among=among)
            k = max(weights, key=lambda i: weights[i].log_odds, default=None)
            if k is None or weights[k].log_odds <= 0:
                break
            members.append(Member(k, weights[k].form, weights[k].scale))
            own = np.zeros(len(self.components), bool)
            own[[m.component for m in members]] = True
            members = self.exchanged(members, own)
        return members

    def exchanged(self, members: list[Member], among: Mask) -> list[Member]:
        """Each member again, the others kept: in its best form, exchanged for a better one, or dropped."""
        about = self._columns(among)
        for _ in range(2):
            before = list(members)
            chosen = Chosen(self.reduced, members, about)
            for member in before:
                i = members.index(member)
                weights = self.beside(chosen, i, among)
                k = max(weights, key=lambda i: weights[i].log_odds, default=None)
                if k is None or weights[k].log_odds <= 0:
                    members = [m for m in members if m is not member]
                else:
                    own = weights.get(member.component)  # None: what it needs is gone
                    if own is not None and weights[k].log_odds < own.log_odds + 0.5:
                        k = member.component
                    new = Member(k, weights[k].form, weights[k].scale)
                    if new == member:
                        continue
                    members = [new if m is member else m for m in members]
                chosen = Chosen(self.reduced, members, about)
            if members == before:
                break
        return members

    def _columns(self, among: Mask) -> Index:
        """Of some components, in all their forms."""
        forms = [part for k in np.flatnonzero(among) for part in self.reduced.parts[k]]
        return np.concatenate([np.arange(part.start, part.stop) for part in forms] or [np.zeros(0, int)])

    def shares(self, members: Sequence[Member]) -> list[Shares]:
        """For each member: probability of it, of each stand-in, and of nothing (None) in its place.

        What would help beside the whole set as well stands in for nobody by that.
        """
        out = []
        chosen = Chosen(self.reduced, members)
        anyway = {k: max(w.log_odds, 0.0) for k, w in self.beside(chosen).items()}
        for i, member in enumerate(members):
            weights = self.beside(chosen, i)
            if member.component not in weights:  # what it needs is gone
                out.append({member.component: 0.0, None: 1.0})
                continue
            logs: Shares = {}
            for k, w in weights.items():
                value = w.log_odds - anyway.get(k, 0.0)
                if k == member.component or value - self.components[k].log_odds > EXPLAINS:
                    logs[k] = value
            logs = self._no_truer_than_forms(chosen, i, weights, logs)
            logs[None] = 0.0
            top = max(logs.values())
            mass = {k: float(np.exp(v - top)) for k, v in logs.items()}
            total = sum(mass.values())
            out.append({k: v / total for k, v in mass.items()})
        return out

    def _no_truer_than_forms(
        self, chosen: Chosen, i: int, weights: dict[int, Weight], logs: Shares
    ) -> Shares:
        """log odds of stand-ins for the i-th member, by how much better or worse they fit than it as far as
        that can be believed: no form is quite true, and what a large effect's form misses is as large as a
        small effect. Two orders of one gear are one form; functions without a name have none."""
        own = chosen.members[i].component
        rest = chosen.explained_without(i)
        too_sure = 1 + PRIORS.form**2 * (chosen.explained - rest)
        left = self.reduced
        slope = 0.5 * (left.noise_dof + left.dof) / max(left.noise_dof + left.chi2 - chosen.explained, 1.0)
        mine = self._takes(chosen, i, own, weights[own])
        out = dict(logs)
        for k in logs:
            if k is None or bare(self.components[k].key) == bare(self.components[own].key):
                continue
            theirs = self._takes(chosen, i, k, weights[k])
            if self.components[k].nameless and theirs < mine:
                continue
            better = float(likelihood(left, rest, np.array(theirs)) - likelihood(left, rest, np.array(mine)))
            most = slope * abs(theirs - mine) / too_sure
            out[k] += float(np.clip(better, -most, most)) - better
        return out

    def _takes(self, chosen: Chosen, i: int, k: int, weight: Weight) -> float:
        """What a component takes off χ² in its likeliest form, in the i-th member's place."""
        part = self.reduced.parts[k][weight.form]
        S, u = (x[0] for x in chosen.left_of(np.arange(part.start, part.stop)[None], i))
        S[np.diag_indices_from(S)] += weight.scale**-2
        return float(u @ np.linalg.solve(S, u))
