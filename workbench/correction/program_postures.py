"""The joints in which an arm takes the targets of a program, in the posture that the file says of them.

Along a line the joints follow on from those before. Where the joints move freely, or none come before, the
file says in which posture the arm stands (KUKA's S and T, ABB's confdata, FANUC's CONFIG, Stäubli's
configuration), and all postures of the arm are tried on that.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from ..files.faults import InputError
from ..robot import rotations
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.rigid_plant import arrays
from .follow import SAME, start_postures
from .inverse import newton
from .paths import Path
from .program_targets import Frames, Target
from .programs.posture import FULL, Posture, margins
from .trajectory import nominal_joints, rigid
from .trouble import ranges_of

STEP, TURN = 0.02, np.radians(5)  # m and rad between the samples that follow the arm from target to target
ROUNDS = 2  # sets of random starts, until a posture agrees with the file; one finds all, as a rule
MOST_TURNED = 3 * np.pi  # rad, of joints without limits
AT_A_LIMIT = 1e-9  # rad, by which a joint may be beyond it
TRIES = 4  # postures that agree equally well, until one serves a whole run
MOST_NOTES = 5
AT_HAND = np.pi / 4  # rad: joints so near to those before need no comparison with other postures
NOTHING = Posture("")


def joints_at(
    robot: Robot, frames: Frames, targets: Sequence[Target], start: Array | None = None
) -> tuple[Array, list[str]]:
    """(M, 6) the URDF's joints at every target, and notes on postures that the file does not settle. start:
    (6,) those before the first."""
    q: list[Array] = []
    run: list[Target] = []
    postures = _Postures(robot, frames)

    def follow() -> None:
        """The poses collected so far, from the last joints known."""
        if run:
            before = None if run[0].move.anew else q[-1] if q else start
            q.extend(postures.along(run, before))
            run.clear()

    for target in targets:
        if target.X is None:
            follow()
            q.append(frames.joints(target.move.arm))
            continue
        if target.move.free or target.move.anew:  # not along a line from the pose before
            follow()
        run.append(target)
    follow()
    notes = list(dict.fromkeys(postures.notes))
    if len(notes) > MOST_NOTES:
        notes[MOST_NOTES:] = [f"the same holds for {len(notes) - MOST_NOTES} targets more"]
    return np.array(q), notes


class _Postures:
    """The postures of the nominal arm, and notes on those that were taken."""

    def __init__(self, robot: Robot, frames: Frames) -> None:
        self.robot, self.frames, self.limits = robot, frames, ranges_of(robot)
        self.arm, self.tip = rigid(arrays(robot), np.eye(4), self.limits)
        self.notes: list[str] = []

    def along(self, run: Sequence[Target], before: Array | None) -> Array:
        """(K, 6) joints at the targets of a run, of which only the first may be reached freely. before: (6,)
        the joints that the arm comes from."""
        X = np.array([self.frames.flange(target.move, _pose(target)) for target in run])
        said, free, near = run[0].posture, run[0].move.free, run[0].move.near
        if near is not None:
            before, said = self.frames.joints(near), NOTHING
        if before is None and (said is None or not said.says):
            return self._unsaid(run, X)
        if before is not None and not free:
            return self._follow(run, X, before)
        if said is None or (before is not None and not said.obeyed):
            said = NOTHING
        if before is not None and any(said.kept):
            said = said.after(margins(self.robot, self.frames.convention, before[None])[0])
        starts, agrees = self._stated(X[0], said, before)
        q = self._first(run, X, starts)
        if not agrees:
            what = f"no posture of this arm within its limits has {said.said}; taken: the nearest"
            self._note(run[0], what, q[0])
        elif not said.obeyed:
            what = f"the controller does not obey {said.said} here, but no joints come before; taken"
            self._note(run[0], what, q[0])
        return q

    def _unsaid(self, run: Sequence[Target], X: Array) -> Array:
        """(K, 6) joints at the poses X: (K, 4, 4), from the posture that serves them all best."""
        q = self._follow(run, X, None)
        every = start_postures(self.arm, self.tip, X[0], self.limits, None, 0)
        if sum(len(self._turned(one[None])) > 0 for one in every) > 1:
            what = "the file does not say the posture of the arm, and other postures need other corrections"
            self._note(run[0], f"{what}; taken", q[0])
        return q

    def _stated(self, X: Array, said: Posture, before: Array | None) -> tuple[Sequence[Array], bool]:
        """Postures at a pose (4, 4) that agree best with what the file says, those near the joints before (or
        far from the limits) first, and whether they agree with all of it."""
        if before is not None:
            near, solved = newton(self.arm, self.tip, X[None], before[None], rounds=40, refresh=1)
            near = near[solved & (self.limits.margin(near) >= -AT_A_LIMIT)]
            at_hand = bool(said.between) or np.abs(near - before).max(initial=0.0) < AT_HAND
            if len(near) and at_hand and not self._against(said, near)[0, 0]:
                return list(near), True
        found = np.zeros((0, self.arm.n))
        for seed in range(ROUNDS):
            more = start_postures(self.arm, self.tip, X, self.limits, None, seed)
            found = np.concatenate([found, *(q[None] for q in more if not _among(found, q))])
            turned = self._turned(found)
            against = self._against(said, turned)
            if (against[:, 0] == 0).any():
                break
        if not len(turned):
            return [], True
        ways = np.zeros_like(turned) if before is None else np.abs(turned - before)
        away = -self.limits.margin(turned) if before is None else ways.max(axis=1).round(9)
        order = np.lexsort([ways.sum(axis=1), away, against[:, 1], against[:, 0]])  # every joint's turn
        equal = (against[order] == against[order[0]]).all(axis=1)
        return list(turned[order[equal]]), bool(against[order[0], 0] == 0)

    def _against(self, said: Posture, q: Array) -> NDArray[np.int64]:
        """(N, 2) how much of what is said does not hold of joints (N, 6)."""
        shown = np.array([self.frames.shown(joints) for joints in q]).reshape(-1, self.arm.n)
        return said.against(margins(self.robot, self.frames.convention, q), shown)

    def _turned(self, q: Array) -> Array:
        """(K, 6) all of the postures (N, 6) that keep to the limits, with whole turns of the joints."""
        low = np.maximum(self.limits.lower, -MOST_TURNED) - AT_A_LIMIT
        high = np.minimum(self.limits.upper, MOST_TURNED) + AT_A_LIMIT
        found = []
        for joints in q:
            first, last = np.ceil((low - joints) / FULL), np.floor((high - joints) / FULL)
            turns = product(*(range(int(a), int(b) + 1) for a, b in zip(first, last, strict=True)))
            found += [joints + FULL * np.array(turn) for turn in turns]
        return np.array(found).reshape(-1, self.arm.n)

    def _first(self, run: Sequence[Target], X: Array, starts: Sequence[Array]) -> Array:
        """Joints along the run from the first of the starts from which the arm gets through it."""
        for start in starts[: TRIES if len(run) > 1 else 0]:
            try:
                return self._follow(run, X, start)
            except InputError:
                continue
        return self._follow(run, X, starts[0] if starts else None)

    def _follow(self, run: Sequence[Target], X: Array, start: Array | None) -> Array:
        """(K, 6) joints at the poses X: (K, 4, 4), straight from each to the next."""
        dense, at = _between(X)
        dense = dense if len(dense) > 1 else np.repeat(dense, 2, axis=0)  # a path has two samples at least
        ends = np.minimum(np.searchsorted(at, np.arange(len(dense))), len(run) - 1)
        lines = tuple(run[i].move.line for i in ends)
        files = tuple(run[i].move.file for i in ends)
        told = Path(np.arange(float(len(dense))), X=dense, lines=lines, files=files)
        return nominal_joints(self.robot, told, start=start)[at]

    def _note(self, target: Target, what: str, q: Array) -> None:
        convention = self.frames.convention
        names = convention.names if convention else self.robot.joint_names
        shown = np.degrees(self.frames.shown(q))
        joints = ", ".join(f"{name} {value:z.1f}" for name, value in zip(names, shown, strict=True))
        self.notes.append(f"{target.move.place}: {what}: {joints} deg")


def _pose(target: Target) -> Array:
    assert target.X is not None
    return target.X


def _among(found: Array, q: Array) -> bool:
    return bool(len(found)) and bool((np.abs(found - q).max(axis=1) < SAME).any())


def _between(X: Array) -> tuple[Array, Array]:
    """Poses (K, 4, 4) with steps of `STEP` and `TURN` between them, and where the given ones stand."""
    poses, at = [X[:1]], [0]
    for start, end in pairwise(X):
        way = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
        whole = float(rotations.angle_between(start[None, :3, :3], end[None, :3, :3])[0])
        count = int(max(way / STEP, whole / TURN)) + 1
        poses.append(rotations.straight(start, end, np.linspace(0, 1, count + 1)[1:]))
        at.append(at[-1] + count)
    return np.concatenate(poses), np.array(at)
