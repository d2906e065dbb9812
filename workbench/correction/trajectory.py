"""A path made ready for an arm: what is wanted of the tool, nominal joints, the extended robot on it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..campaign.problem import Problem
from ..files.faults import InputError
from ..robot.compensator import compensator_law
from ..robot.description import Robot
from ..robot.kinematics import Arm, Array, frames
from ..robot.rigid_plant import arrays
from ..robot.rotations import tool_pose
from .check import check_path, reach
from .conditions import Conditions, path_campaign
from .extended_arm import ExtendedArm, extended_arm, parts
from .follow import Range, follow
from .inverse import Tip
from .paths import Path
from .trouble import Trouble, impossible, out_of_range, ranges_of, unreached

POSTURES = 8
NO_WAY = 1e-3  # of the largest motions [rad, lengths of the tip]: less is none


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A path of N samples, and all that its correction starts from.

    nominal: the rigid arm as the controller believes it. X: (N, 4, 4) wanted tool poses; q: (N, n) joints
    that the nominal arm takes there.
    """

    robot: Robot
    path: Path
    nominal: Arm
    tip: Tip
    X: Array
    q: Array
    extended: ExtendedArm

    def jacobian(self, part: slice) -> Array:
        """(K, 6, n) of some samples, as `Tip` makes it."""
        return self.tip.jacobian(self.nominal, frames(self.nominal, self.q[part]))

    def gain(self, part: slice) -> Array:
        """(K, n, 6) of some samples, as `Tip` makes it."""
        return self.tip.gain(self.nominal, self.jacobian(part))

    def forward(self, q: Array) -> Array:
        """(N, 4, 4) tool poses of the nominal arm."""
        X = np.empty((len(q), 4, 4))
        for part in parts(len(q)):
            X[part] = self.tip.pose(frames(self.nominal, q[part]))
        return X


def nominal_joints(
    robot: Robot, path: Path, tool: Array | None = None, start: Array | None = None, seed: int = 0
) -> Array:
    """(N, n) joints of the nominal rigid arm along a path, on one branch of elbow and wrist.

    tool: (4, 4) pose of the tool in the flange frame. start: (n,) joints near those of the first pose; by
    default the posture that serves the whole path and stays farthest from its limits. Raises
    `InputError` with the lines that are out of reach or out of range.
    """
    return _nominal(robot, arrays(robot), path, tool, start, seed)[3]


def trajectory_of(
    robot: Robot,
    path: Path,
    conditions: Conditions,
    tool: Array | None = None,
    start: Array | None = None,
    seed: int = 0,
) -> Trajectory:
    """The path made ready. Raises `InputError` with all that makes it impossible."""
    arm = arrays(robot)
    nominal, tip, X, q = _nominal(robot, arm, path, tool, start, seed)
    campaign = path_campaign(robot, path, q, conditions)
    extended = extended_arm(Problem(robot, arm, campaign, compensator_law(robot, arm)))
    return Trajectory(robot, path, nominal, tip, X, q, extended)


def _nominal(
    robot: Robot, arm: Arm, path: Path, tool: Array | None, start: Array | None, seed: int
) -> tuple[Arm, Tip, Array, Array]:
    """Rigid arm, tip, wanted poses and joints."""
    X_FT = tool_pose(tool)
    check_path(robot, arm, path, X_FT)
    limits = ranges_of(robot)
    nominal, tip = rigid(arm, X_FT, limits)
    troubles: list[Trouble] = []
    if path.q is not None:
        q = path.q
        X = np.concatenate([tip.pose(frames(nominal, q[part])) for part in parts(len(q))])
    else:
        assert path.X is not None
        X = path.X
        q, reached = follow(nominal, tip, X, limits, start, seed)
        troubles += unreached(reached, _reach_said(tip))
    troubles += out_of_range(robot, q, "the path itself")
    if faults := impossible(path, troubles):
        raise InputError(faults)
    return nominal, tip, X, q


def rigid(arm: Arm, X_FT: Array, limits: Range) -> tuple[Arm, Tip]:
    """The arm as the controller believes it, and its tip with a tool (4, 4) on the flange."""
    nominal = replace(
        arm.with_geometry(np.zeros_like(arm.geometry)), compliance=np.zeros_like(arm.compliance)
    )
    tip = Tip(X_FT[:3, :3], X_FT[:3, 3], 6, reach(arm, X_FT, limits.upper) / 3)
    return nominal, tip if _every_way(nominal, tip) else replace(tip, rows=3)


def _every_way(arm: Arm, tip: Tip) -> bool:
    """Whether the arm can move and turn its tool every way, in any of some postures at random: not with fewer
    than six joints, nor where axes are parallel as in a palletizer."""
    q = np.random.default_rng(arm.n).uniform(-1, 1, (POSTURES, arm.n))
    J = tip.jacobian(arm, frames(arm, np.where(arm.prismatic, tip.length, 1.0) * q)) / tip.length
    return arm.n >= 6 and float(np.linalg.svd(J, compute_uv=False)[:, 5].max()) > NO_WAY


def _reach_said(tip: Tip) -> str:
    if tip.rows == 3:
        return "the tool cannot get there, however it is turned"
    return "the tool cannot get there in this posture"
