"""What was decided, written down: changes, what repeats, and the tracks of single numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...effects.base import UNKNOWN
from ..priors import PRIORS
from ..search.rounds import CLEARER, LOOSE, worth_of
from ..weighing.chosen import Shares
from .before_after import numbers_at
from .candidates import numbers_of_shape
from .covered import carried_change, covered
from .decision import Decided, Hidden, label_of
from .found import POSSIBLE, Change, Repeats, Rival, Track, Unseen
from .levels import Levels, levels_of, together
from .occasions import Occasion
from .recheck import Known, recheck
from .system import System, solve

ROBOT = "robot"
STILL = 0.01  # of the way that a joint goes in another campaign: less is none
REPEATS = 0.5  # of its size: an error that changed by less, with 95 %, repeats


def changes_of(decided: Decided) -> Iterator[Change]:
    """The quantities that changed, or in whose place another did, if likely enough by all poses together; the
    largest first. All events of a quantity are its course, and the surest of them says how sure it is that
    it changed."""
    every = [i for i, m in enumerate(decided.members) if decided.candidates[m.component].change]
    found = []
    for own in together(decided, every):
        lead = max(own, key=lambda i: _own(decided, i))
        if sum(_changed(decided, decided.together[lead]).values()) >= PRIORS.absent:
            found.append(_change(decided, levels_of(decided, own), lead))
    yield from sorted(found, key=lambda change: -change.moves_mm)


def _own(decided: Decided, i: int) -> float:
    """Probability of the i-th member."""
    return decided.shares[i].get(decided.members[i].component, 0.0)


def _changed(decided: Decided, share: Shares) -> dict[int, float]:
    """Of what may stand in a place, what is a change."""
    return {k: p for k, p in share.items() if k is not None and decided.candidates[k].change}


def of_robot(decided: Decided, k: int) -> bool:
    """Whether a candidate says that the robot changed. Where the model does not fit to the noise, what has no
    name differs between campaigns for that alone, and so does what stood still in one: other poses show
    another part of it."""
    candidate = decided.candidates[k]
    if decided.system.misfit and candidate.cause == UNKNOWN:
        return False
    return candidate.side == ROBOT and not stood_still(decided, k)


def stood_still(decided: Decided, k: int) -> bool:
    """Whether a candidate sits at a joint, or on the link behind it, that stood still in some campaign, where
    the model does not fit to the noise: then what it explains may be what the model lacks in other poses."""
    if not decided.system.misfit:
        return False
    where, arm = decided.candidates[k].where, decided.system.occasions[0].problem.arm
    joint = where.joint
    if where.link in arm.links[1:]:
        joint = arm.names[arm.links.index(where.link) - 1]
    return any(joint in names for _, names in still_joints(decided.system))


def still_joints(system: System) -> list[tuple[Occasion, list[str]]]:
    """Campaigns with joints that stood still in them and not in another."""
    travel = np.array([np.ptp(one.problem.q, axis=0) for one in system.occasions])
    still = travel < STILL * travel.max(axis=0)
    names = system.occasions[0].problem.arm.names
    every = [
        (one, [name for name, stood in zip(names, row, strict=True) if stood])
        for one, row in zip(system.occasions, still, strict=True)
    ]
    return [(one, names) for one, names in every if names]


def _status(decided: Decided, i: int) -> str:
    """Of the i-th member: whether anything changed in its place, and whether that is it."""
    changed = _changed(decided, decided.shares[i])
    if sum(p for k, p in changed.items() if not stood_still(decided, k)) < PRIORS.named:
        return POSSIBLE
    return "named" if _own(decided, i) >= PRIORS.named and not _tied(decided, i) else "ambiguous"


def _change(decided: Decided, levels: Levels, lead: int) -> Change:
    """lead: the surest of its members."""
    member = decided.members[levels.members[0]]
    candidate, shape = decided.candidates[member.component], levels.shape
    labels = [one.label for one in decided.system.occasions]
    has = levels.places
    here = levels.furthest
    own = [_changed(decided, decided.shares[i]) for i in levels.members]
    one = len(levels.members) == shape.courses == 1
    off = shape if one else shape.at(np.arange(len(labels)) == here)
    before = _before(decided, levels.members, int(has[0]))
    poses, ids = recheck(decided.system, before, candidate, off, levels.mean[here])
    changed, then, now = numbers_at(decided, levels, here)
    return Change(
        label_of(candidate, shape),
        candidate.cause,
        candidate.where,
        candidate.side,
        _status(decided, lead),
        labels[has[0]],
        bool(len(has) == 1 and has[0] < len(labels) - 1),
        _own(decided, lead),
        max(sum(p for k, p in odds.items() if of_robot(decided, k)) for odds in own),
        changed,
        _moves_mm(decided, levels),
        tuple(_rivals(decided, lead)),
        poses,
        ids,
        levels.course,
        tuple((labels[k], numbers_at(decided, levels, k)[0]) for k in has),
        then,
        now,
    )


def _tied(decided: Decided, i: int) -> bool:
    """Whether a rival in the i-th member's place fits the data as well, number for number: then only its
    prior speaks against it."""
    member, share = decided.members[i], decided.shares[i]
    own = _worth(decided, i, member.component, member.form)
    rivals = [k for k, p in share.items() if k not in (None, member.component) and p >= PRIORS.faintest_rival]
    return any(
        _worth(decided, i, k, form) > own - CLEARER
        for k in rivals
        if k is not None
        for form in range(len(decided.candidates[k].shapes))
    )


def _worth(decided: Decided, i: int, component: int, form: int) -> float:
    """What the main numbers of a form explain beside all members but the i-th, less a price for each."""
    first, shape = decided.reduced.parts[component][form].start, decided.candidates[component].shapes[form]
    return worth_of(decided.chosen, i, first + np.arange(shape.main * shape.courses))


def _before(decided: Decided, members: Sequence[int], first: int) -> Known:
    """All numbers, the other members' among them, as the campaigns before the `first` with a change say."""
    system = decided.system
    counts = (system.own < first)[:, None]
    others = [m for j, m in enumerate(decided.members) if j not in members]
    shapes = [replace(shape, base=shape.base * counts) for shape in map(decided.shape, others)]
    known = replace(system, J=system.J * counts, e=system.e * counts[:, 0])
    numbers = solve(known, shapes, [m.scale for m in others])
    return Known(numbers, decided.solved.factor, any(one.misfit for one in system.occasions[:first]))


def _moves_mm(decided: Decided, levels: Levels) -> float:
    """RMS of what a change makes of the points of the occasions that have it, once the instrument's frames
    are fitted anew: what turns or shifts all of them moves none against another."""
    system, lengths = decided.system, []
    for k in levels.places.tolist():
        here = system.own == k
        motion = levels.shape.base[here] @ levels.mean[k]
        frames = system.J[here][:, system.frames(k)]
        left = motion - frames @ np.linalg.lstsq(frames, motion)[0]
        lengths.append(system.lengths(k, left))
    return 1e3 * float(np.sqrt(np.mean(np.concatenate(lengths) ** 2)))


def _rivals(decided: Decided, i: int) -> Iterator[Rival]:
    """What may stand in the place of the i-th member, whenever it changed, the likeliest first."""
    own, share = decided.members[i].component, decided.shares[i]
    least = PRIORS.faintest_rival * sum(p for k, p in share.items() if k is not None)
    for k, p in sorted(share.items(), key=lambda way: -way[1]):
        if k is None or k == own or p < least:
            continue
        candidate = decided.candidates[k]
        yield Rival(
            label_of(candidate),
            candidate.cause, candidate.where, candidate.change, candidate.side, p,
        )  # fmt: skip


def unseen(decided: Decided) -> Iterator[Unseen]:
    """Numbers of the geometry whose change looks exactly like something else's."""
    for hidden in _hidden_now(decided):
        label = label_of(hidden.candidate, hidden.shape)
        yield Unseen(label, hidden.same_as or "the instrument's frame or the targets")


def hidden_zeros(decided: Decided) -> list[str]:
    """Joints a change of whose zero looks like a move of the instrument or the targets."""
    found = [hidden for hidden in _hidden_now(decided) if hidden.shape.zero and hidden.same_as is None]
    return [str(hidden.candidate.where.joint) for hidden in found]


def _hidden_now(decided: Decided) -> list[Hidden]:
    """What cannot be seen at the last occasion."""
    last = decided.system.last
    return [hidden for hidden in decided.hidden if hidden.shape.is_at(last)]


def loads_off(decided: Decided) -> list[str]:
    """Payloads that are not as stated wherever they are: none of them changed."""
    found = zip(decided.members, decided.shares, strict=True)
    sure = [m.component for m, share in found if share.get(m.component, 0.0) >= PRIORS.named]
    own = [decided.candidates[k] for k in sure]
    return [label_of(one) for one in own if one.side == "load" and not one.change]


def repeats(decided: Decided, changes: Sequence[Change]) -> Iterator[Repeats]:
    """The named effects of the robot that the campaigns show: whether they repeat, and how closely."""
    said = {(change.cause, change.where): change.status for change in changes}
    result = decided.system.occasions[0].fit
    start = result.columns.geometry_slice.start
    common = (decided.solved.values[: decided.solved.background] * decided.system.prior)[
        decided.system.common
    ]
    last = decided.system.last
    for k, candidate in enumerate(decided.candidates):
        if not candidate.change or candidate.side != ROBOT or candidate.cause == UNKNOWN:
            continue
        for shape, part in zip(candidate.shapes, decided.reduced.parts[k], strict=True):
            known = [e for e in shape.effects if e in result.model.effects]
            if not known or not shape.is_at(last):
                continue
            columns = result.columns.effect[result.model.effects.index(known[0])]
            value = common[columns.start - start : columns.stop - start]
            p = len(value)
            S, u = (x[0] for x in decided.chosen.left_of(np.arange(part.start, part.start + p)[None]))
            held = S + np.eye(p)
            change, half = np.linalg.solve(held, u), np.linalg.cholesky(np.linalg.inv(held))
            size = float(np.linalg.norm(shape.columns[:, :p] @ (value / shape.sizes[:p])))
            spread = 1.96 * decided.factor(shape.pattern) * float(np.linalg.norm(shape.columns[:, :p] @ half))
            share = float(np.hypot(np.linalg.norm(shape.columns[:, :p] @ change), spread)) / max(size, 1e-12)
            status = said.get((candidate.cause, candidate.where))
            if status is not None:
                status = "not decided" if status == POSSIBLE else "changed"
            else:
                met = not known[0].local or covered(decided.system, shape.pattern, known[0].where.joint).any()
                status = "repeats" if share < REPEATS and met else "not decided"
            yield Repeats(label_of(candidate, shape), status, share)


def tracks(decided: Decided) -> Iterator[Track]:
    """Over all campaigns, against the first: each number that changed alone, and each joint's zero. limit:
    two-sided 99.7 % of the largest uncertainty."""
    system, last = decided.system, decided.system.last
    each = np.eye(system.count)[1:]
    for candidate in decided.candidates:
        shape = next((s for s in candidate.shapes if s.is_at(last)), None)
        if not candidate.change or shape is None:  # one event of each quantity has that
            continue
        mine = [m for m in decided.members if decided.candidates[m.component].quantity == candidate.quantity]
        bases = [decided.shape(m) for m in mine] or [shape]
        shape = bases[0]
        if shape.main > 1 or not (mine or shape.zero) or any(s.base is not shape.base for s in bases):
            continue
        beside = [m for m in decided.members if m not in mine]
        others, own = [decided.shape(m) for m in beside], [shape.at(pattern) for pattern in each]
        scale = max((m.scale for m in mine), default=LOOSE)
        solved = solve(system, [*others, *own], [*(m.scale for m in beside), *(scale for _ in own)])
        at, p = sum(s.width for s in others), len(shape.sizes)
        values, stds = [0.0], [0.0]
        for j in range(len(own)):
            mean, covariance = solved.of(slice(at + j * p, at + (j + 1) * p))
            values.append(float(mean[0] * shape.sizes[0]))
            carried = carried_change(system, own[j].pattern)
            stds.append(carried * float(np.sqrt(covariance[0, 0]) * shape.sizes[0]))
        unit = numbers_of_shape(shape)[0][1]
        yield Track(label_of(candidate, shape), unit, tuple(values), tuple(stds), 3 * max(stds))
