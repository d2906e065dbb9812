"""How sure a comparison of two causes in one place can be: less than their likelihoods say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...effects.base import Effect
from ...robot.kinematics import Array
from ..priors import PRIORS
from .chosen import Chosen
from .components import Component, bare
from .forms import Forms
from .weight import Weight, likelihood

SURELY = 3.0  # standard deviations
TINY = 1e-9


def times_too_sure(one: Effect, other: Effect) -> float:
    """By how much log odds between two causes are too large where it is how they are likely to look that
    tells them apart, of which little is known. Two laws of one joint's yield are told apart by their
    freedom."""
    if one.cause == other.cause or one.kin is None or one.kin != other.kin:
        return 1.0
    if one.acts != "yielding":
        return PRIORS.kin
    same = one.axial and other.axial and one.where == other.where
    return 1.0 if same else PRIORS.yields


def believed_share(chosen: Chosen, i: int) -> float:
    """Of a difference in χ² in the i-th member's place, the share that is more than a form usually misses."""
    return 1 / (1 + PRIORS.form**2 * (chosen.explained - chosen.explained_without(i)))


def share_of_any(difference: float) -> float:
    """Of a difference in χ², the share that can be believed whatever forms miss: what they do lies in one of
    many directions, and one that misses far less by chance does so in all of them (the likelihood of a miss
    of a size that nobody knows, log-uniform, falls as that size to the power of the dimension)."""
    per_direction = difference / PRIORS.directions
    return float(np.log1p(per_direction) / per_direction) if per_direction > 0 else 1.0


class StandIns:
    """Components in each other's place at one linearisation.

    That one fits better than another says less than it seems to. No form is quite true: what a large
    effect's form misses is as large as a small effect (`PRIORS.form`, `PRIORS.directions`), and some odds are
    too large by a factor (`times_too_sure`) but for what a cause that may be true to its form wins without
    its companions.
    That excuses no spring that pushes back: no form that is missed turns its sign.
    Two orders of one gear are one form.
    """

    def __init__(self, forms: Forms, components: Sequence[Component]) -> None:
        self.forms, self.components = forms, components
        self.reduced = forms.reduced

    def believed(
        self, chosen: Chosen, i: int, weights: dict[int, Weight], logs: dict[int, float]
    ) -> dict[int, float]:
        """log odds of components in the i-th member's place, as far as they can be believed, without those
        that stand in by their companions alone. weights: of each by itself there, logs: its log odds."""
        own = chosen.members[i].component
        takes = {k: self._takes(chosen, i, k, weights[k]) for k in logs}
        logs = {
            k: v for k, v in logs.items() if k == own or self._of_itself(chosen, i, k, weights[k], takes[k])
        }
        rivals = [k for k in logs if self._differ(k, own)]
        excused = [k for k in rivals if not self._pushes(chosen, i, k, weights[k])]
        out = self._no_truer_than_forms(chosen, i, takes, weights, logs, excused)
        for k in rivals:
            times = self._times_too_sure(k, own)
            if times == 1:
                continue
            before = self.components[k].log_odds - self.components[own].log_odds
            odds = out[k] - logs[own] - before
            winner = k if odds > 0 else own
            by_itself = abs(odds) - weights[winner].by_companions if self.components[winner].pure else 0.0
            out[k] = logs[own] + before + np.sign(odds) * max(abs(odds) / times, by_itself)
        return out

    def _differ(self, k: int, own: int) -> bool:
        return bare(self.components[k].key) != bare(self.components[own].key)

    def _times_too_sure(self, k: int, own: int) -> float:
        one, other = (self.components[c] for c in (k, own))
        if one.nameless or other.nameless or one.effect is None or other.effect is None:
            return 1.0
        return times_too_sure(one.effect, other.effect) if one.group == other.group else 1.0

    def _no_truer_than_forms(
        self,
        chosen: Chosen,
        i: int,
        takes: dict[int, float],
        weights: dict[int, Weight],
        logs: dict[int, float],
        rivals: Sequence[int],
    ) -> dict[int, float]:
        """log odds by how much better or worse rivals fit as far as that can be believed; functions without a
        name, which have no form, may be worse. takes: what each takes off χ² there.

        Where the one of two fits better that has more freedom, that counts as little as what it brings: the
        other has none for what its form misses. Where it costs more than it brings, all counts."""
        own = chosen.members[i].component
        rest, mine, out = chosen.explained_without(i), takes[own], dict(logs)
        ours = float(likelihood(self.reduced, rest, np.array(mine)))
        for k in rivals:
            theirs, nameless = takes[k], self.components[k].nameless
            if nameless and theirs < mine:
                continue
            better = float(likelihood(self.reduced, rest, np.array(theirs))) - ours
            most = self._believed(chosen, i, theirs - mine)
            doubted = better - float(np.clip(better, -most, most))
            before = self.components[k].log_odds - self.components[own].log_odds
            odds = weights[k].log_odds - weights[own].log_odds - before
            if (odds - better) * better < 0 and not nameless:
                doubted *= max(odds / better, 0.0)
            out[k] -= doubted
        return out

    def _believed(self, chosen: Chosen, i: int, difference: float) -> float:
        """log odds that can be believed of a difference in χ² between two in the i-th member's place."""
        left = self.reduced
        noise = (left.noise_dof + left.chi2 - chosen.explained) / (left.noise_dof + left.dof)
        more = abs(difference) / max(noise, TINY)
        return 0.5 * more * max(believed_share(chosen, i), share_of_any(more))

    def _of_itself(self, chosen: Chosen, i: int, k: int, weight: Weight, takes: float) -> bool:
        """Whether enough of what a component takes off χ² is the effect's own, and not its companions'."""
        main, part = self.components[k].forms[weight.form].main, self.reduced.parts[k][weight.form]
        if not 0 < main < part.stop - part.start:  # no companions follow
            return True
        return self._takes(chosen, i, k, weight, main) >= PRIORS.itself * takes

    def _pushes(self, chosen: Chosen, i: int, k: int, weight: Weight) -> bool:
        """Whether a component is a spring that would surely push back in the i-th member's place."""
        if self.components[k].forms[weight.form].wrong_sign > PRIORS.pushes_back:
            return False
        S, u = self._left(chosen, i, k, weight)
        covariance = np.linalg.inv(S)
        return bool(covariance[0] @ u < -SURELY * np.sqrt(covariance[0, 0]))

    def _takes(self, chosen: Chosen, i: int, k: int, weight: Weight, first: int | None = None) -> float:
        """What a component takes off χ² in its likeliest form, or the first columns of that, in the i-th
        member's place."""
        S, u = self._left(chosen, i, k, weight, first)
        return float(u @ np.linalg.solve(S, u))

    def _left(
        self, chosen: Chosen, i: int, k: int, weight: Weight, first: int | None = None
    ) -> tuple[Array, Array]:
        """Equations of a component in its likeliest form, or of the first columns of that, in the i-th
        member's place."""
        part = self.reduced.parts[k][weight.form]
        columns = np.arange(part.start, part.stop)[None, :first]
        S, u = (x[0] for x in chosen.left_of(columns, i))
        S[np.diag_indices_from(S)] += weight.scale**-2
        return S, u
