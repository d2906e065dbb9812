"""Who could stand in for an accepted cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..effects.place import Where
from ..identification.fit import Fit, refit
from .screen import Screen, screen, tail

ADDS = 1e-3  # a rival is dropped when the accepted cause still adds to it at this level
ALMOST = 0.1  # a rival that the linear pool drops is fitted in full if it leaves no more than this share
FAINTEST_RIVAL = 0.2  # share of an accepted cause's gain that a rival must reach alone
MOST_RIGID = 3  # joints that are named where all rigid ones together are the rival


@dataclass(frozen=True)
class Rivals:
    """Rivals of the causes `chosen` from a pool; fit: with these causes. known: the noise is."""

    pool: Screen
    chosen: tuple[int, ...]
    fit: Fit
    known: bool

    def of(self, a: int) -> tuple[int, ...]:
        """Causes that could stand in for an accepted one: beside them it adds nothing significant."""
        pool, rest = self.pool, [c for c in self.chosen if c != a]
        keys = {pool.candidates[c].key for c in self.chosen}
        base = pool.statistic(rest)[0]
        own = pool.statistic([a], rest)[0]
        alones, ranks = pool.increments(rest)
        found: dict[tuple[str, Where], tuple[float, int]] = {}
        for k, effect in enumerate(pool.candidates):
            alone = float(alones[k])
            if ranks[k] == 0 or alone < FAINTEST_RIVAL * own or effect.key in keys:
                continue
            if not pool.possible([*rest, k]):
                continue
            more, extra = pool.statistic([a], [*rest, k])
            worse = extra and pool.p_value(more, extra, base + alone) < ADDS
            if worse and (more > ALMOST * own or not self._stands_in(rest, [k], a)):
                parts = self._parts(k)
                if not parts or not self._stands_in(rest, parts, a):
                    continue
            if effect.key not in found or alone > found[effect.key][0]:
                found[effect.key] = alone, k
        return tuple(k for _, k in sorted(found.values(), reverse=True)) or self._rigid_joints(rest, a)

    def _rigid_joints(self, rest: Sequence[int], a: int) -> tuple[int, ...]:
        """Joints that the model has rigid, where `a` adds nothing to their yielding all together.

        Every joint yields. Where no stiffness at all is stated, axial yield and tilt of all these joints are
        as likely as whatever single yield draws the same: then they are its rivals, the strongest first.
        """
        pool, problem = self.pool, self.fit.model.problem
        effect, candidates = pool.candidates[a], pool.candidates
        if (effect.always and effect.axial) or effect.acts not in ("yielding", "load"):
            return ()
        stated = {joint.name for joint in problem.robot.joints if joint.data.stiffness}
        along = [k for k, e in enumerate(candidates) if e.always and e.axial]
        rigid = {candidates[k].where.joint for k in along} - stated
        group = [
            k for k, e in enumerate(candidates) if e.always and e.where.joint in rigid and k not in (*rest, a)
        ]
        axial = [k for k in along if k in group]
        base = pool.statistic([*rest, *group])[0]
        more, extra = pool.statistic([a], [*rest, *group])
        if not axial or (extra and pool.p_value(more, extra, base) < ADDS):
            return ()
        alones = pool.increments(rest)[0]
        return tuple(sorted(axial, key=lambda k: -alones[k])[:MOST_RIGID])

    def _parts(self, k: int) -> list[int]:
        """All parts of the law that a candidate is a part of; none where it is a law by itself."""
        effect = self.pool.candidates[k]
        parts = [i for i, other in enumerate(self.pool.candidates) if other.key == effect.key]
        return parts if effect.together and len(parts) > 1 else []

    def _stands_in(self, rest: Sequence[int], instead: Sequence[int], a: int) -> bool:
        """Candidate `a` adds nothing to a full fit with others in its place: large effects are not linear,
        and the pool is."""
        pool, others = self.pool, [*rest, *instead]
        if not pool.possible(others):
            return False
        there = refit(self.fit, [pool.candidates[k] for k in others])
        gain, rank = screen(there, [pool.candidates[a]], self.known).statistic([0])
        return tail(there, gain, rank, self.known) >= ADDS
