"""How sure a comparison of two causes in one place can be: less than their likelihoods say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .chosen import Chosen, Shares
from .components import Component, bare
from .priors import PRIORS
from .reduced import Reduced
from .weight import Weight, likelihood


class StandIns:
    """Components in each other's place at one linearisation.

    That one fits better than another says less than it seems to. No form is quite true: what a large
    effect's form misses is as large as a small effect (`PRIORS.form`). And what a map wins over its joint's
    run-out, or this by its companions, is won by how they are likely to look, of which little is known
    (`PRIORS.kin`). Two orders of one gear are one form.
    """

    def __init__(self, reduced: Reduced, components: Sequence[Component]) -> None:
        self.reduced, self.components = reduced, components

    def believed(self, chosen: Chosen, i: int, weights: dict[int, Weight], logs: Shares) -> Shares:
        """log odds of components in the i-th member's place, as far as they can be believed. weights: of each
        by itself there, logs: its log odds."""
        own = chosen.members[i].component
        rivals = [k for k in logs if k is not None and self._differ(k, own)]
        out = self._no_truer_than_forms(chosen, i, weights, logs, rivals)
        for k in (k for k in rivals if self._kin(k, own)):
            before = self.components[k].log_odds - self.components[own].log_odds
            odds = out[k] - logs[own] - before
            winner = k if odds > 0 else own
            by_itself = abs(odds) - weights[winner].by_companions if self.components[winner].pure else 0.0
            out[k] = logs[own] + before + np.sign(odds) * max(abs(odds) / PRIORS.kin, by_itself)
        return out

    def _differ(self, k: int, own: int) -> bool:
        return bare(self.components[k].key) != bare(self.components[own].key)

    def _kin(self, k: int, own: int) -> bool:
        return self.components[k].kin is not None and self.components[k].kin == self.components[own].kin

    def _no_truer_than_forms(
        self, chosen: Chosen, i: int, weights: dict[int, Weight], logs: Shares, rivals: Sequence[int]
    ) -> Shares:
        """log odds by how much better or worse rivals fit as far as that can be believed; functions without a
        name, which have no form, may be worse."""
        own, left = chosen.members[i].component, self.reduced
        rest = chosen.explained_without(i)
        too_sure = 1 + PRIORS.form**2 * (chosen.explained - rest)
        slope = 0.5 * (left.noise_dof + left.dof) / max(left.noise_dof + left.chi2 - chosen.explained, 1.0)
        mine, out = self._takes(chosen, i, own, weights[own]), dict(logs)
        for k in rivals:
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
