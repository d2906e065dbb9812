"""Free poses and the free ways between them: which poses hang together, and how to go round something.

A probabilistic roadmap (Kavraki et al. 1996). An arm that turns further than once about a level axis may
stand in poses that no way leads to without touching the floor: these are none to be measured in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, shortest_path

from ...robot.collisions import Collisions
from ...robot.kinematics import Array

NODES = 160  # free poses of the map
NEIGHBOURS = 7  # to which ways from each are tried
ENTRIES = 5  # nodes by which a pose may hang on the map
COARSE = 0.12  # rad (m) that the farthest joint goes between two coarse looks on a way

Time = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class Roadmap:
    """Nodes (V, n) that all hang together, and the time [s] of the free ways between them (V, V), inf where
    none is known. closely: whether every way was looked at closely, or in coarse steps."""

    collisions: Collisions
    time: Time
    nodes: Array
    ways: Array
    closely: bool

    def holds(self, q: Array) -> NDArray[np.bool_]:
        """(N,) which poses q: (N, n) hang on the map, by one of their nearest nodes."""
        out = np.zeros(len(q), dtype=bool)
        near = np.argsort(self.time(q[:, None], self.nodes), axis=1)[:, :ENTRIES]
        for k in range(near.shape[1]):
            left = np.flatnonzero(~out)
            out[left] = clear_ways(self.collisions, q[left], self.nodes[near[left, k]], self.closely)
        return out

    def path(self, start: Array, end: Array, clear: Callable[[Array, Array], bool]) -> list[Array] | None:
        """Nodes (n,) on the shortest way from start to end; None where there is none. clear: looks closely
        at a way."""
        V, nodes = len(self.nodes), np.concatenate([self.nodes, [start, end]])
        graph = np.full((V + 2, V + 2), np.inf)
        graph[:V, :V] = self.ways
        for k, to_end in ((V, self.time(start, self.nodes)), (V + 1, self.time(self.nodes, end))):
            near = np.argsort(to_end)[: 2 * ENTRIES]
            graph[k, near] = graph[near, k] = to_end[near]
        while True:
            _, before = shortest_path(graph, indices=V, return_predecessors=True)
            if before[V + 1] < 0:
                return None
            way = [V + 1]
            while way[-1] != V:
                way.append(int(before[way[-1]]))
            way = way[::-1]
            shut = [(a, b) for a, b in pairwise(way) if not clear(nodes[a], nodes[b])]
            if not shut:
                return [nodes[k] for k in way[1:-1]]
            for a, b in shut:
                graph[a, b] = graph[b, a] = np.inf


def roadmap(collisions: Collisions, time: Time, offered: Array, closely: bool) -> Roadmap:
    """The map of free poses offered (V, n): the largest part that hangs together."""
    times = time(offered[:, None], offered[None])
    near = np.argsort(times, axis=1)[:, 1 : NEIGHBOURS + 1]
    pairs = np.unique(np.sort([(a, b) for a, row in enumerate(near) for b in row], axis=1), axis=0)
    a, b = pairs[clear_ways(collisions, offered[pairs[:, 0]], offered[pairs[:, 1]], closely)].T
    ways = np.full(times.shape, np.inf)
    ways[a, b] = ways[b, a] = times[a, b]
    _, part = connected_components(np.isfinite(ways))
    main = np.flatnonzero(part == np.argmax(np.bincount(part)))
    return Roadmap(collisions, time, offered[main], ways[np.ix_(main, main)], closely)


def clear_ways(collisions: Collisions, start: Array, end: Array, closely: bool) -> NDArray[np.bool_]:
    """(N,) which straight ways between poses (N, n) are free, looked at in coarse steps, then `closely`."""
    out = np.ones(len(start), dtype=bool)
    if not len(start):
        return out
    looks = 2 + np.ceil(np.abs(end - start).max(axis=1) / COARSE).astype(int)
    way = np.repeat(np.arange(len(start)), looks)
    share = np.concatenate([np.linspace(0, 1, k) for k in looks])[:, None]
    free = collisions.free(start[way] * (1 - share) + end[way] * share)
    np.logical_and.at(out, way, free)
    for k in np.flatnonzero(out) if closely else ():
        out[k] = collisions.clear_way(start[k], end[k])
    return out
