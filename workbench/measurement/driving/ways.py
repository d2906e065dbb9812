"""The ways between poses: how long they take, whether they are free, and how to go round what is not."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...robot.kinematics import Array
from .reach import Reach

TRIED = 40  # detours by a single pose, the shortest


@dataclass(frozen=True, eq=False)
class Ways:
    """Straight joint motions of one robot in its cell."""

    reach: Reach
    _known: dict[tuple[bytes, bytes], bool] = field(default_factory=dict, init=False, repr=False)

    def time(self, start: Array, end: Array) -> Array:
        """[s] from poses start (..., n) to end (..., n)."""
        return self.reach.time(start, end)

    def clear(self, *stops: Array) -> bool:
        """Whether the straight ways through these poses (n,) are free."""
        return all(self._clear(a, b) for a, b in pairwise(stops))

    def _clear(self, start: Array, end: Array) -> bool:
        """Looked at once: plans of one campaign are tried by the dozen, and have most of their ways in
        common."""
        key = (start.tobytes(), end.tobytes())
        if key not in self._known:
            self._known[key] = self.reach.collisions.clear_way(start, end)
        return self._known[key]

    def to(self, start: Array, approach: Array, end: Array) -> list[Array] | None:
        """Poses (n,) by which the way from start to where the last motion to `end` begins is free; over `end`
        itself where nothing else leads there; None where none is known."""
        if self.clear(start, approach):
            return []
        found = self.round(start, approach)
        if found is None and self.clear(end, approach):
            found = [] if self.clear(start, end) else self.round(start, end)
            return None if found is None else [*found, end]
        return found

    def round(self, start: Array, end: Array) -> list[Array] | None:
        """Poses (n,) between two by which the way is free: one, or nodes of the map; None where none is
        known."""
        nodes = self.reach.map.nodes
        both = self.time(start, nodes) + self.time(nodes, end)
        for k in np.argsort(both)[:TRIED]:
            if self.clear(start, nodes[k], end):
                return [nodes[k]]
        found = self.reach.map.path(start, end, self.clear)
        return None if found is None else self._shortened([start, *found, end])[1:-1]

    def _shortened(self, path: list[Array]) -> list[Array]:
        """The path without the poses that it can do without."""
        out, here = [path[0]], 0
        while here < len(path) - 1:
            ahead = len(path) - 1
            while ahead > here + 1 and not self.clear(path[here], path[ahead]):
                ahead -= 1
            out.append(path[ahead])
            here = ahead
        return out
