"""From chosen records to a day of measuring: blocks of load, a short tour in each, check poses, a clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...files.faults import Fault, InputError
from ...robot.kinematics import Array, frames
from .block import Block, Drive, state_of, work_between
from .tour import shortest
from .ways import Ways

ROUNDS = 6  # tours that are tried before a colliding way is gone round
FAR = 300.0  # s that a colliding way counts for in a tour: longer than any other


class NoWay(InputError):
    """To a pose of a plan leads no way that is known to be free."""


def drive(plan: Campaign, ways: Ways, dwell: float) -> Drive:
    """The records of a plan as they are driven. dwell: [s] of a standstill with one target, each further one
    takes the cell's `reflector_s`. Raises `NoWay` where a pose cannot be reached."""
    plan = _reachable(plan, ways)
    check = _check_pose(plan, ways) if ways.reach.cell.driving.check_every else None
    stops: list[tuple[int, bool]] = []  # number of the record, is it a return
    blocks: list[Block] = []
    names: dict[str, int] = {}
    for rows in _blocks(plan):
        state = state_of(plan, int(rows[0]))
        start = len(stops)
        stops += _block(plan, ways, rows, check)
        stem = state.payload
        names[stem] = names.get(stem, 0) + 1
        again = f"_{names[stem]}" if names[stem] > 1 else ""
        blocks.append(Block(f"{stem}{again}".strip("_"), state, start, len(stops)))
    further = 0 if plan.six_dof else len(plan.targets) - 1
    return _timed(plan, ways, stops, blocks, dwell + further * ways.reach.cell.driving.reflector_s)


def _blocks(plan: Campaign) -> list[NDArray[np.int64]]:
    """Rows of each session and load and pull; loads of every second session in turned order, so that what is
    mounted last stays on."""
    session = sessions(plan)
    out: list[NDArray[np.int64]] = []
    for k, start in enumerate(np.unique(session)):
        here = np.flatnonzero(session == start)
        loads = np.column_stack([plan.poses.payload[here], plan.poses.wrench[here]])
        _, which = np.unique(loads, axis=0, return_inverse=True)
        groups = [here[which.ravel() == g] for g in range(which.max() + 1)]
        out += groups if k % 2 == 0 else groups[::-1]
    return out


def sessions(plan: Campaign) -> Array:
    """(N,) [s] when the session of each record begins."""
    return np.zeros(len(plan.poses)) if plan.poses.time is None else plan.poses.time


def _sides(plan: Campaign) -> Array:
    return np.ones_like(plan.poses.q) if plan.poses.side is None else plan.poses.side


def _reachable(plan: Campaign, ways: Ways) -> Campaign:
    """The plan, every pose from a side from which it is free; from below where none was said."""
    sides, q = _sides(plan).copy(), plan.poses.q
    for i in range(len(q)):
        for side in (sides[i], np.ones_like(q[i]), -np.ones_like(q[i])):
            if ways.clear(ways.reach.approaches(q[i], side), q[i]):
                sides[i] = side
                break
        else:
            what = "cannot be reached from either side"
            raise NoWay(Fault(f"pose {plan.poses.ids[i]}", what, "say another --seed"))
    return plan.with_poses(side=sides)


def _check_pose(plan: Campaign, ways: Ways) -> int:
    """The record that reaches out farthest: there most shows of links that grow and of a base that drifts."""
    where = frames(ways.reach.arm, plan.poses.q)
    return int(np.argmax(np.linalg.norm(where.p[-1] - where.p[1], axis=1)))


def _block(plan: Campaign, ways: Ways, rows: NDArray[np.int64], check: int | None) -> list[tuple[int, bool]]:
    """Stops of one load in the order of a short tour, with returns to the check pose at both ends and
    between."""
    places = rows if check is None else np.concatenate([[check], rows])
    q, sides = plan.poses.q[places], _sides(plan)[places]
    approach = ways.reach.approaches(q, sides)
    time = ways.time(q[:, None], approach[None]) + ways.time(approach, q)
    checked = np.zeros(time.shape, dtype=bool)
    for _ in range(ROUNDS):
        order = shortest(time)
        legs = [(a, b) for a, b in zip(order, np.roll(order, -1), strict=True) if not checked[a, b]]
        hit = [(a, b) for a, b in legs if not ways.clear(q[a], approach[b])]
        for a, b in legs:
            checked[a, b] = True
        if not hit:
            break
        for a, b in hit:
            time[a, b] += FAR
    if check is None:
        return [(int(places[i]), False) for i in order]
    every = ways.reach.cell.driving.check_every
    found = [(check, True)]
    for n, i in enumerate(order[1:], 1):  # the tour begins at place 0
        found.append((int(places[i]), False))
        if n % every == 0 and len(order) - 1 - n >= every / 2:
            found.append((check, True))
    return [*found, (check, True)]


def _timed(
    plan: Campaign, ways: Ways, stops: Sequence[tuple[int, bool]], blocks: Sequence[Block], still: float
) -> Drive:
    """The stops with the ways to them and a clock; still: [s] of a standstill."""
    driving = ways.reach.cell.driving
    rows = np.array([row for row, _ in stops])
    check = np.array([back for _, back in stops])
    records = plan.some(rows)
    like = rows.copy()  # the record whose load and session each stop has
    for block in blocks:
        inside = slice(block.start, block.stop)
        like[inside] = rows[inside][~check[inside]][0]
    with_load = plan.poses.some(like)
    payload, wrench, starts = with_load.payload, with_load.wrench, sessions(plan)[like]
    q, sides = records.poses.q, _sides(records)
    approach = ways.reach.approaches(q, sides)
    via: list[tuple[Array, ...]] = [()]
    clock, moving, times = 0.0, 0.0, [0.0]
    number = {block.start: k for k, block in enumerate(blocks)}
    driven = list(blocks)
    for i in range(1, len(rows)):
        clock += still
        if (k := number.get(i)) is not None:
            later = starts[i] - clock if starts[i] > starts[i - 1] else 0.0
            before = work_between(blocks[k - 1].state, blocks[k].state, driving, later)
            driven[k] = replace(blocks[k], before=before)
            clock += sum(seconds for _, seconds in before)
        between = ways.to(q[i - 1], approach[i], q[i])
        if between is None:
            what = (
                f"no free way leads from pose {plan.poses.ids[rows[i - 1]]} to pose {plan.poses.ids[rows[i]]}"
            )
            raise NoWay(Fault(records.robot.name, what, "say another --seed, or a smaller clearance_mm"))
        via.append(tuple(between))
        leg = [q[i - 1], *between, approach[i], q[i]]
        taken = sum(float(ways.time(a, b)) for a, b in pairwise(leg))
        clock, moving = clock + taken, moving + taken
        times.append(clock)
    numbers = np.cumsum(~check)
    returns = np.cumsum(check)
    ids = tuple(f"check_{returns[i]}" if check[i] else str(numbers[i]) for i in range(len(rows)))
    records = records.with_poses(
        ids=ids, payload=payload, wrench=wrench, time=np.array(times), temperature=with_load.temperature
    )
    own = plan.some(rows[~check])
    return Drive(
        own.with_poses(ids=tuple(str(i + 1) for i in range(len(own.poses)))),
        replace(records, title=plan.title),
        check,
        tuple(via),
        tuple(driven),
        moving,
        still * len(rows),
        still,
        sum(bool(way) for way in via),
    )
