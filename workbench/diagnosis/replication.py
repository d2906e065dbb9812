"""Whether parts of the data that know nothing of each other name the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.problem import Problem
from ..identification.fit import Fit
from .components import Component
from .reduced import Index, reduce
from .scatter import POSES_PER_JOINT
from .sets import Competition, Member, Shares


def replicated(
    at: Fit,
    components: Sequence[Component],
    members: Sequence[Member],
    shares: Sequence[Shares],
    noise_dof: float,
) -> list[Shares]:
    """The shares where the model does not fit to the noise, and the likelihood is far too sure: those of
    searches that each see one part of the data and nothing of the others' sets, averaged, for members of
    which these say less."""
    parts = list[list[Shares]]()
    for poses in parts_of(at.model.problem):
        part = Competition(reduce(at, components, noise_dof, poses), components)
        parts.append(part.shares(part.best()))
    out = [dict(share) for share in shares]
    for i, member in enumerate(members):
        k = member.component
        if components[k].nameless:
            continue  # no name is at stake
        every = [max(part, key=lambda share: share.get(k, 0.0), default={}) for part in parts]
        every = [share if k in share else {None: 1.0} for share in every]
        keys = set[int | None]().union(*every)
        mean = {key: sum(share.get(key, 0.0) for share in every) / len(every) for key in keys}
        if mean.get(k, 0.0) < out[i][k]:
            out[i] = {**mean, k: mean.get(k, 0.0)}
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
