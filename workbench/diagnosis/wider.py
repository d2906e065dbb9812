"""How much less sure a yield's size is where a robot yields in more places than were found.

A fit's covariance takes the set that was found for the whole truth. Where three yields or more were found,
others of the robot are as likely to be off, and what they do goes into those that were found.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import numpy as np

from ..robot.kinematics import Array
from .chosen import Chosen
from .competition import Selection
from .components import Component, Key, bare
from .priors import PRIORS

MANY = 3  # of one kind that were found: not a few faults, but a robot that yields


def widened(selection: Selection) -> Mapping[Key, float]:
    """By how much the standard deviations of causes are larger with others of their kind beside them, which
    were not found: each of `PRIORS.others` of the size that those have which were."""
    components, reduced = selection.components, selection.reduced
    members = (*selection.members, *selection.unrepeated)
    chosen = Chosen(reduced, members)
    own = [components[member.component] for member in members]
    mains = [
        part.start + np.arange(one.forms[member.form].main)
        for one, member, part in zip(own, members, chosen.own, strict=True)
    ]
    sizes: dict[Hashable, list[float]] = {}
    for one, main in zip(own, mains, strict=True):
        if (kin := _kin(one)) is not None:
            sizes.setdefault(kin, []).append(float((chosen.beta[main] ** 2).mean()))
    usual = {kin: float(np.sqrt(np.mean(some))) for kin, some in sizes.items() if len(some) >= MANY}
    found = {bare(one.key) for one in own}
    columns, precision = list[Array](), list[Array]()
    for k, other in enumerate(components):
        kin = _kin(other)
        if kin not in usual or bare(other.key) in found:
            continue
        main = other.forms[0].main
        columns.append(reduced.parts[k][0].start + np.arange(main))
        precision.append(np.full(main, (PRIORS.others * usual[kin]) ** -2))
    if not columns:
        return {}
    index = np.concatenate([chosen.index, *columns])
    S = reduced.S.between(index, index)
    S[np.diag_indices_from(S)] += np.concatenate([chosen.precision, *precision])
    times = np.sqrt(np.diag(np.linalg.inv(S))[: len(chosen.index)] / np.diag(chosen.inverse))
    return {bare(one.key): float(times[main].max()) for one, main in zip(own, mains, strict=True)}


def _kin(component: Component) -> Hashable:
    """What kind of yield a cause is; None of what is none."""
    effect = component.effect
    return None if component.nameless or effect is None or effect.acts != "yielding" else effect.kin
