"""Whether parts of the data, each searched by itself from the beginning, name the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..campaign.problem import Problem
from .components import Component, Key, bare
from .reduced import Index
from .scatter import POSES_PER_JOINT
from .sets import Member, Shares

Search = Callable[[Index], tuple[Sequence[Component], Sequence[Shares]]]


def replicated(
    problem: Problem,
    components: Sequence[Component],
    members: Sequence[Member],
    shares: Sequence[Shares],
    search: Search,
) -> list[Shares]:
    """The shares where the model does not fit to the noise, and the likelihood is far too sure: those of
    searches that each see one part of the data and nothing of what the others found, averaged, for members
    of which these say less. search: of some poses, components and shares of what it finds."""
    if all(components[m.component].nameless for m in members):
        return list(shares)  # no name is at stake
    known = {bare(component.key): k for k, component in reversed([*enumerate(components)])}
    parts = list[list[Shares]]()
    for poses in parts_of(problem):
        theirs, found = search(poses)
        parts.append([_translated(share, theirs, known) for share in found])
    out = [dict(share) for share in shares]
    for i, member in enumerate(members):
        if components[member.component].nameless:
            continue
        k = known[bare(components[member.component].key)]  # of a line it does not matter which
        every = [max(part, key=lambda share: share.get(k, 0.0), default={}) for part in parts]
        every = [share if k in share else {None: 1.0} for share in every]
        keys = set[int | None]().union(*every)
        mean = {key: sum(share.get(key, 0.0) for share in every) / len(every) for key in keys}
        own = mean.pop(k, 0.0)
        if own < out[i][member.component]:
            out[i] = {**mean, member.component: own}
    return out


def _translated(share: Shares, theirs: Sequence[Component], known: dict[Key, int]) -> Shares:
    """A share by the numbers of other components; what these do not have counts as nothing."""
    out: Shares = {None: 0.0}
    for k, p in share.items():
        key = None if k is None else known.get(bare(theirs[k].key))
        out[key] = out.get(key, 0.0) + p
    return out


def parts_of(problem: Problem) -> list[Index]:
    """Poses of each set-up, where two or more have poses enough to show a cause; else the earlier and the
    later half, and two halves drawn at random, of every set-up and payload."""
    setup = problem.campaign.poses.setup
    each = [np.flatnonzero(setup == k) for k in range(int(setup.max(initial=0)) + 1)]
    enough = POSES_PER_JOINT * problem.arm.n
    large = [poses for poses in each if len(np.unique(problem.positions[poses])) >= enough]
    if len(large) > 1:
        return large
    poses = problem.campaign.poses
    which = np.unique(np.column_stack([poses.setup, poses.payload]), axis=0, return_inverse=True)[1].ravel()
    groups = [np.flatnonzero(which == group) for group in range(int(which.max()) + 1)]
    early, late = [own[: len(own) // 2] for own in groups], [own[len(own) // 2 :] for own in groups]
    mixed = [own[np.argsort(poses.drawn()[own], kind="stable")] for own in groups]
    one, other = [own[: len(own) // 2] for own in mixed], [own[len(own) // 2 :] for own in mixed]
    return [np.sort(np.concatenate(part)) for part in (early, late, one, other)]
