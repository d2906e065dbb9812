"""Poses to measure, and a campaign that is told but not yet measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.kinematics import Arm, Array, frames
from ..robot.rigid_plant import arrays
from . import Campaign, Target
from .poses import Poses

# three targets that show all six motions of the hand
TARGETS = (
    Target("T1", (0.15, 0.00, 0.05)),
    Target("T2", (-0.08, 0.14, 0.08)),
    Target("T3", (-0.06, -0.16, 0.12)),
)


def joint_ranges(robot: Robot) -> tuple[Array, Array]:
    """Least and largest joints (n,) [rad, m]: the limits, ±π where there are none."""
    limit = [(j.lower, j.upper) if np.isfinite(j.upper - j.lower) else (-np.pi, np.pi) for j in robot.joints]
    lower, upper = np.array(limit).T
    return lower, upper


def random_poses(
    robot: Robot,
    count: int,
    rng: np.random.Generator,
    share: float = 0.9,
    floor: float | None = None,
    clear: float | None = None,
) -> Array:
    """Random joints (count, n) [rad, m] in the middle `share` of the limits (±π where there are none).

    All joints but the first, and the flange, stay above `floor` (z [m] in the base frame, by default
    5 % of the arm's reach) and the flange `clear` [m] (10 % of the reach) off the first axis. Raises
    `InputError` when hardly any pose does.

    >>> import numpy as np
    >>> from workbench import load_robot, random_poses
    >>> q = random_poses(load_robot("cylindrical"), 20, np.random.default_rng(0), share=0.5)
    >>> q.shape, bool((np.abs(q[:, 0]) <= np.pi / 2).all())
    ((20, 3), True)
    """
    arm = arrays(robot)
    lower, upper = joint_ranges(robot)
    middle, half = (lower + upper) / 2, share * (upper - lower) / 2
    reach = _reach(arm, lower, upper)
    floor = 0.05 * reach if floor is None else floor
    clear = 0.1 * reach if clear is None else clear
    kept: list[Array] = []
    for _ in range(50):
        q = middle + half * rng.uniform(-1, 1, (4 * count, arm.n))
        where = frames(arm, q)
        height = where.p[3:, :, 2]  # what never moves stands where it stands: a shoulder in the base's origin
        low = np.where(np.ptp(height, axis=1, keepdims=True) > 1e-9, height, np.inf).min(
            axis=0, initial=np.inf
        )
        radius = np.hypot(*where.p[-1, :, :2].T)
        kept.extend(q[(np.minimum(low, where.p[-1, :, 2]) > floor) & (radius > clear)])
        if len(kept) >= count:
            return np.array(kept[:count])
    what = f"hardly any pose keeps the flange above {floor:.2f} m and {clear:.2f} m off the first axis"
    raise InputError(Fault(robot.name, what, "check the joint limits, or give the poses"))


def _reach(arm: Arm, lower: Array, upper: Array) -> float:
    """[m] of the stretched arm; with joints that slide, how far off the first axis they get the flange: a
    lift does not reach farther."""
    if not arm.prismatic.any():
        return float(np.linalg.norm(arm.p[2:], axis=1).sum())
    anywhere = np.random.default_rng(0).uniform(lower, upper, (1000, arm.n))
    return float(np.hypot(*frames(arm, anywhere).p[-1, :, :2].T).max())


def planned(
    robot: Robot,
    q: Array,
    *,
    targets: Sequence[Target] = TARGETS,
    payloads: Mapping[str, tuple[float, Sequence[float]]] | None = None,
    payload: Sequence[str] | None = None,
    tool: tuple[float, Sequence[float]] = (0.0, (0.0, 0.0, 0.0)),
    wrench: Array | None = None,
    direction: Array | None = None,
    time: Array | None = None,
    temperature: Array | None = None,
    readback: Array | None = None,
    setup: Sequence[str] | None = None,
    title: str = "",
) -> Campaign:
    """A campaign without points: what the robot is told, in N poses q: (N, n) [rad, m].

    payloads: name → mass [kg] and centre of mass [m, flange frame]; payload: (N) names ("": none);
    tool: mass and centre of mass, always mounted. wrench: (N, 6) [N, N·m] on the robot at the flange
    origin, base frame; direction: (N, n) sign of the last motion; time: (N,) [s]; temperature: (N,) [°C];
    readback: (N, n) [rad, m]; setup: (N) names of the instrument's set-ups.

    >>> import numpy as np
    >>> from workbench import load_robot, planned
    >>> q = np.array([[0.0, 0.1, 0.2], [0.5, 0.2, 0.1]])
    >>> plan = planned(load_robot("cylindrical"), q, payloads={"heavy": (8.0, (0.0, 0.0, 0.1))},
    ...                payload=["", "heavy"])
    >>> plan.n_poses, plan.n_points, [plan.payload_names[i] for i in plan.poses.payload]
    (2, 0, ['', 'heavy'])
    """
    n_poses = len(q)
    loads = {"": (0.0, (0.0, 0.0, 0.0)), **(payloads or {})}
    load_names, setup_names = list(loads), list(dict.fromkeys(setup or [""]))
    return Campaign(
        title=title or f"{robot.title}, {n_poses} poses",
        path=Path("campaign.toml"),
        robot=robot,
        payload_names=tuple(load_names),
        load_mass=np.array([mass for mass, _ in loads.values()]),
        load_com=np.array([list(com) for _, com in loads.values()], dtype=np.float64),
        tool_mass=tool[0],
        tool_com=np.array(tool[1], dtype=np.float64),
        setup_names=tuple(setup_names),
        targets=tuple(targets),
        points=np.full((n_poses, len(targets), 3), np.nan),
        shots=np.zeros((n_poses, len(targets)), dtype=np.int64),
        poses=Poses(
            ids=tuple(str(i + 1) for i in range(n_poses)),
            q=np.asarray(q, dtype=np.float64),
            payload=np.array([load_names.index(name) for name in payload or [""] * n_poses], dtype=np.int64),
            wrench=np.zeros((n_poses, 6)) if wrench is None else wrench,
            side=direction,
            time=time,
            temperature=temperature,
            torque=None,
            readback=readback,
            setup=np.array([setup_names.index(name) for name in setup or [""] * n_poses], dtype=np.int64),
        ),
    )
