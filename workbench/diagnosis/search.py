"""Which causes: the subset of candidates that explains the residual, and who could stand in for whom.

Cost of a set = misfit + a penalty per cause that a chance hit pays with probability `ALPHA_CAUSES` over the
whole catalogue. Additions, removals and exchanges until none helps; then a full nonlinear fit, and
again, because an accepted cause sharpens the view of the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import stats

from ..effects import line as gear_line
from ..effects.base import Effect
from ..effects.place import Where
from ..identification.fit import Fit, refit
from ..robot.kinematics import Array
from .rivals import Rivals
from .scan import Line, scan
from .screen import Screen, bounded, p_value, screen, tail

ALPHA_CAUSES = 0.004  # chance that clean data show some catalogue cause
ALPHA_LINES = 0.002  # and that they show some gear line of unknown order
CLEARER_BY = 4.0  # gain in misfit that moves a setting
MOST_CAUSES = 16
LARGEST_MOVE = 3.0  # a cause moves the points by no more than this times the nominal robot's error


@dataclass(frozen=True)
class Selection:
    """Accepted causes with their fit; the pool they were taken from, screened at the geometry fit.

    p_value: per accepted cause, look-elsewhere included. rivals: per accepted cause, indices into the
    pool. aliases: orders of a gear line that the poses cannot tell apart. tries: looks behind each.
    """

    fit: Fit
    effects: tuple[Effect, ...]
    pool: Screen
    chosen: tuple[int, ...]
    p_values: tuple[float, ...]
    rivals: tuple[tuple[int, ...], ...]
    aliases: dict[str, tuple[float, ...]]
    tries: tuple[int, ...]


@lru_cache(maxsize=1000)
def _gain_by_chance(alpha: float, rank: int, dof: float, noise_dof: float, known: bool) -> float:
    if known and np.isinf(noise_dof):
        return float(stats.chi2.isf(alpha, rank))
    if known:
        return float(rank * stats.f.isf(alpha, rank, noise_dof))
    F = stats.f.isf(alpha, rank, max(dof - rank, 2.0))
    return float(dof * np.log1p(rank * F / max(dof - rank, 2.0)))


class Search:
    """Subset search on one geometry fit."""

    def __init__(self, nominal: Fit, geometry: Fit, candidates: Sequence[Effect], known: bool) -> None:
        self.geometry, self.known, self.max_causes = geometry, known, MOST_CAUSES
        error = float(np.sqrt(np.nanmean(nominal.residual**2)))
        self.largest = LARGEST_MOVE * max(5e-4, error) / float(np.sqrt(np.mean(geometry.noise.sigma**2)))
        self.last = geometry
        self.candidates: list[Effect] = list(candidates)
        self.tries: dict[Effect, int] = {}
        self.aliases: dict[str, tuple[float, ...]] = {}
        self.sharpened: dict[tuple[str, Where], int] = {}
        self.regular = max(1, len(self.candidates))

    def run(self) -> Selection:
        """Search until nothing significant can be added."""
        current, chosen = self.geometry, list[int]()
        self._add_lines(current)
        pool = screen(self.geometry, self.candidates, self.known)
        for _ in range(self.max_causes):
            before = set(self._effects(pool, chosen))
            chosen = self._local(pool, chosen)
            current = self._fit(pool, chosen)
            grew = self._add_lines(current)
            fresh = self._next(current, pool, chosen)
            if self._sharpen(pool, chosen) or grew:
                grew = True
                pool = screen(self.geometry, self.candidates, self.known)  # indices stay as they were
            if fresh is not None and len(chosen) < self.max_causes:
                chosen.append(self.candidates.index(fresh))
                continue
            if not grew and set(self._effects(pool, chosen)) == before:
                break
        chosen = self._backward(pool, chosen)
        return self.select(pool, chosen)

    def select(self, pool: Screen, chosen: Sequence[int]) -> Selection:
        """The chosen causes, strongest first, with their fit, p-values and rivals."""
        worth = {a: pool.statistic([a], [c for c in chosen if c != a])[0] for a in chosen}
        chosen = sorted(chosen, key=lambda a: -worth[a])
        result = self._fit(pool, chosen)
        return Selection(
            result,
            tuple(self._effects(pool, chosen)),
            pool,
            tuple(chosen),
            tuple(self._p(pool, result, i) for i in range(len(chosen))),
            tuple(Rivals(pool, tuple(chosen), result, self.known).of(a) for a in chosen),
            self.aliases,
            tuple(self.tries.get(pool.candidates[a], self.regular) for a in chosen),
        )

    # ------------------------------------------------------------------ parts

    def _effects(self, pool: Screen, chosen: Sequence[int]) -> list[Effect]:
        return [pool.candidates[i] for i in chosen]

    def _fit(self, pool: Screen, chosen: Sequence[int]) -> Fit:
        effects = tuple(self._effects(pool, chosen))
        if effects == self.last.model.effects:
            return self.last
        self.last = refit(self.last, effects)
        return self.last

    def _add_lines(self, at: Fit) -> bool:
        """Puts significant lines of the order scan into the candidates."""
        grew = False
        for line in scan(at):
            p = max(line.p_value, tail(at, line.statistic, 2, self.known))
            if p * line.tries > ALPHA_LINES or self._is_known(line):
                continue
            name = at.model.problem.arm.names[line.joint]
            effect = gear_line(name, round(line.order, 3))
            self.candidates.append(effect)
            self.tries[effect] = line.tries
            self.aliases[effect.where.joint or ""] = line.aliases
            grew = True
        return grew

    def _sharpen(self, pool: Screen, chosen: Sequence[int]) -> bool:
        """Moves settings of accepted effects (a soft zone's width) where the data want them, twice at most:
        True when any moved."""
        changed = False
        for a in chosen:
            effect = pool.candidates[a]
            options = [effect, *effect.finer()]
            if len(options) == 1 or self.sharpened.get(effect.key, 0) >= 2:
                continue
            self.sharpened[effect.key] = self.sharpened.get(effect.key, 0) + 1
            rest = self._effects(pool, [c for c in chosen if c != a])
            there = screen(self.geometry, [*options, *rest], self.known)
            given = range(len(options), len(options) + len(rest))
            gains = np.array([there.statistic([k], given)[0] for k in range(len(options))])
            unit = 1.0 if self.known else (there.rss - gains.max()) / max(there.dof, 1.0)
            if gains.max() > gains[0] + CLEARER_BY * unit:
                self.candidates[a] = options[int(np.argmax(gains))]
                changed = True
        return changed

    def _is_known(self, line: Line) -> bool:
        """A candidate of (nearly) that order is there already."""
        problem = self.geometry.model.problem
        width = max(1.5 * np.pi / max(float(np.ptp(problem.q[:, line.joint])), 1e-3), 0.3)
        return any(
            effect.where.order is not None
            and effect.where.joint == problem.arm.names[line.joint]
            and abs(effect.where.order - line.order) < width
            for effect in self.candidates
        )

    def _penalty(self, effect: Effect, rank: int, dof: float) -> float:
        """Gain in misfit that a chance hit reaches with the family-wise probability."""
        tries = self.tries.get(effect)
        alpha = ALPHA_LINES / tries if tries else ALPHA_CAUSES / self.regular
        return _gain_by_chance(alpha, rank, dof, self.geometry.noise.dof, self.known)

    def _cost(self, pool: Screen, gain: float) -> float:
        """Misfit of a set that is `gain` below the geometry's, on the scale of the penalties."""
        if self.known:
            return pool.rss - gain
        return float(pool.dof * np.log(max(pool.rss - gain, 1e-12 * pool.rss)))

    def _strangeness(self, pool: Screen, chosen: Sequence[int]) -> float:
        """Penalty on sizes far beyond the typical (a Cauchy prior two typical sizes wide); infinite
        beyond physical bounds, or where causes move the points by far more than the robot errs (they
        then cancel each other). It decides between causes that fit alike."""
        if not chosen:
            return 0.0
        values, covariance = pool.solution(chosen)
        if not bounded([p for i in chosen for p in pool.candidates[i].params], values, covariance):
            return np.inf
        typical = values / pool.scale[pool.columns(chosen)]
        moves = np.abs(typical) * np.sqrt(pool.own[pool.columns(chosen)] / pool.dof)
        if moves.max() > self.largest:
            return np.inf
        total, at = 0.0, 0
        for i in chosen:
            effect = pool.candidates[i]
            size = typical[at : at + len(effect.params)]
            total += 2 * np.log1p(float(np.mean(size**2)) / 4)
            at += len(effect.params)
        return float(total)

    def _local(self, pool: Screen, chosen: list[int]) -> list[int]:
        """Additions while they pay, then removals and exchanges, until nothing lowers the cost."""
        penalty = np.array([self._penalty(e, len(e.params), pool.dof) for e in pool.candidates])
        plain = self._cost(pool, pool.statistic(chosen)[0]) + float(penalty[chosen].sum())
        for _ in range(4 * self.max_causes):
            better = self._best(pool, penalty, chosen, plain)
            if better is None:
                break
            plain, chosen = better
        return chosen

    def _best(
        self, pool: Screen, penalty: Array, chosen: list[int], plain: float
    ) -> tuple[float, list[int]] | None:
        """Plain cost and members of the best neighbouring set; None when none is better.

        An addition or removal must pay by misfit alone; among additions, and among exchanges, what is
        of a usual size wins. Additions first.
        """
        if len(chosen) < self.max_causes:
            moves = self._moves(pool, penalty, chosen)
            ranked = self._ranked(pool, [move for move in moves if move[0] < plain - 1e-6])
            if ranked:
                return ranked[0][1:]
        others: list[tuple[float, list[int]]] = []
        for a in chosen:
            others += self._moves(pool, penalty, [c for c in chosen if c != a])
        fewer = [move for move in others if len(move[1]) < len(chosen) and move[0] < plain - 1e-6]
        if fewer:
            return min(fewer)
        now = plain + self._strangeness(pool, chosen)
        same = [move for move in others if len(move[1]) == len(chosen) and move[0] < now - 1e-6]
        ranked = self._ranked(pool, same)
        return ranked[0][1:] if ranked and ranked[0][0] < now - 1e-6 else None

    def _moves(self, pool: Screen, penalty: Array, base: list[int]) -> list[tuple[float, list[int]]]:
        """Plain cost and members of a base, and of the base with the best candidates added."""
        gain, cost = pool.statistic(base)[0], float(penalty[base].sum())
        more, rank = pool.increments(base)
        return [
            (self._cost(pool, gain) + cost, base),
            *(
                (self._cost(pool, gain + more[k]) + cost + penalty[k], [*base, int(k)])
                for k in np.argsort(-more)[:12]
                if rank[k] and more[k] > 0 and int(k) not in base
            ),
        ]

    def _ranked(
        self, pool: Screen, moves: list[tuple[float, list[int]]]
    ) -> list[tuple[float, float, list[int]]]:
        """Possible sets with full cost (strangeness included), plain cost and members, best first."""
        near = sorted(moves, key=lambda move: move[0])[:10]
        full = [(cost + self._strangeness(pool, members), cost, members) for cost, members in near]
        return sorted((item for item in full if np.isfinite(item[0])), key=lambda item: item[0])

    def _next(self, at: Fit, pool: Screen, chosen: Sequence[int]) -> Effect | None:
        """A cause that is significant only now that the chosen ones are in the model."""
        rest = [effect for effect in self.candidates if effect not in self._effects(pool, chosen)]
        there = screen(at, rest, self.known)
        best: tuple[float, Effect] | None = None
        gains, ranks = there.increments([])
        for k, effect in enumerate(rest):
            gain, rank = float(gains[k]), int(ranks[k])
            if rank == 0 or gain < 8.0 or not there.possible([k]):
                continue
            loss = self._penalty(effect, rank, there.dof)
            value = (
                gain - loss if self.known else there.dof * -np.log(max(1 - gain / there.rss, 1e-12)) - loss
            )
            if value > 0 and (best is None or value > best[0]):
                best = value, effect
        return best[1] if best else None

    def _backward(self, pool: Screen, chosen: list[int]) -> list[int]:
        """Drops, the weakest first, what does not pay its penalty beside the others; where the noise is not
        known, nothing."""
        while chosen:
            worth = []
            for a in chosen:
                rest = [c for c in chosen if c != a]
                gain, rank = pool.statistic([a], rest)
                worth.append(
                    gain - self._penalty(pool.candidates[a], rank, pool.dof) if self.known else np.inf
                )
            weakest = int(np.argmin(worth))
            if worth[weakest] > 0:
                break
            chosen = [c for i, c in enumerate(chosen) if i != weakest]
        return chosen

    def _p(self, pool: Screen, result: Fit, i: int) -> float:
        """p-value of the fit's i-th cause given the others, times the number of looks."""
        wald = result.wald(i)
        tries = self.tries.get(result.model.effects[i], self.regular)
        rss = result.chi2 + wald
        return min(
            1.0,
            tries * p_value(wald, len(result.state.values[i]), rss, pool.dof, result.noise.dof, self.known),
        )
