"""Measured campaigns from Drake: its kinematics, its torques, its loaded equilibrium, pose by pose.

What the simulated robot is really like stands in a `Truth`: geometry, effects of the catalogue, and
hooks for forms that the catalogue does not have. The batch model of `identification` takes no part in it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem, problem_of
from ..effects.acting import Acting
from ..effects.base import Effect
from ..effects.records import stated_effects
from ..files.faults import Fault, InputError
from ..robot.elastic_plant import elastic_twin
from ..robot.elastic_twin import ElasticTwin
from ..robot.kinematics import Arm, Array
from ..robot.loads import Loads
from ..robot.rotations import body_jacobian, rotation_about
from ..robot.yielding import Law

Values = tuple[Effect, Array]
IDLE = 1e-9  # m: what moves no point by that moves none


@dataclass(frozen=True)
class Truth:
    """What the simulated robot and its instrument are really like. N poses, n joints, S slots, T targets.

    geometry: (S, 6) [m, rad] corrections on top of the robot's own; effects: each with its values (p,).
    Hooks for other forms, each called with the problem:
      joints     → (N, n) joint errors [rad, m];
      motion     → column 6 · slot + component → (N,) motion of frames [m, rad];
      torque     → (N, n) further axial torques [N·m, N];
      yields     slot → law, a wrench (6,) on the slot's axes → its motion (6,);
      seen       points (N, T, 3) in the instrument's frame → the points as the instrument shows them.
    targets: (T, 3) [m] true places in the frames behind their slots; None: as stated. sigma: noise per
    axis and shot [m]; repeatability: (n,) one sigma of the joints per standstill; None: as the TOML says.
    """

    geometry: Array | None = None
    effects: tuple[Values, ...] = ()
    joints: Callable[[Problem], Array] | None = None
    motion: Callable[[Problem], Mapping[int, Array]] | None = None
    torque: Callable[[Problem], Array] | None = None
    yields: Mapping[int, Callable[[Array], Array]] = field(default_factory=dict)
    seen: Callable[[Problem, Array], Array] | None = None
    targets: Array | None = None
    sigma: float = 0.0
    repeatability: Array | None = None

    @property
    def acting(self) -> Acting:
        return Acting(self.effects)


def simulate(
    plan: Campaign,
    truth: Truth,
    *,
    seed: int = 0,
    shots: int = 1,
    instrument: tuple[Array, Array] | None = None,
    state_sigma: bool = True,
    torque_sigma: float | None = None,
) -> Campaign:
    """The plan's poses, measured on the true robot.

    plan: N poses without points (`planned`), or a campaign to be measured again. shots: readings of each
    point, whose mean is kept. instrument: R (K, 3, 3), t (K, 3) [m] of the base in the instrument's frame
    per set-up; None: drawn. state_sigma: the campaign says its noise. torque_sigma: adds the torques of the
    drives, with this noise as a share of each joint's largest torque. The robot's own effects (model.toml)
    act too.
    Raises `InputError` when an effect does nothing in these poses.

    >>> import numpy as np
    >>> from workbench import Truth, load_robot, planned, random_poses, simulate
    >>> robot = load_robot("cylindrical")
    >>> plan = planned(robot, random_poses(robot, 10, np.random.default_rng(0)))
    >>> measured = simulate(plan, Truth(sigma=3e-5), seed=1)  # an exact robot, 30 µm noise
    >>> measured.points.shape  # (N, T, 3) [m], in the instrument's frame
    (10, 3, 3)
    """
    problem = problem_of(plan)
    _check_acting(problem, truth)
    truth = replace(truth, effects=(*stated_effects(problem), *truth.effects))
    draw = _Draws(seed)
    direct = _direct(problem, truth) + draw.repeatability(problem, truth)
    base, torque = _settle(problem, truth, direct, torque_sigma is not None)
    R, t = instrument if instrument is not None else draw.instrument(problem)
    points = _see(
        problem, truth, np.einsum("nij,ntj->nti", R[plan.poses.setup], base) + t[plan.poses.setup][:, None]
    )
    shot = points[:, :, None] + draw.noise(points, truth.sigma, shots, plan.six_dof)
    mean = shot.mean(axis=2)
    return replace(
        plan.with_poses(
            torque=plan.poses.torque
            if torque is None or torque_sigma is None
            else draw.torque(torque, torque_sigma)
        ),
        points=mean,
        shots=np.full(points.shape[:2], shots, dtype=np.int64),
        shot_scatter=(float(((shot - mean[:, :, None]) ** 2).sum()), 3 * (shots - 1) * mean[..., 0].size),
        noise_sigma=truth.sigma if state_sigma and truth.sigma > 0 else plan.noise_sigma,
    )


def idle_effects(plan: Campaign, truth: Truth) -> tuple[Effect, ...]:
    """The effects of a truth without which every point of the plan stands where it stands with them: nothing
    loads what yields, say, or nothing yields to what pulls."""
    still = replace(truth, sigma=0.0)
    whole = simulate(plan, still).points if truth.effects else plan.points
    idle = []
    for item in truth.effects:
        rest = tuple(other for other in truth.effects if other is not item)
        without = simulate(plan, replace(still, effects=rest)).points
        if np.abs(whole - without).max() < IDLE:
            idle.append(item[0])
    return tuple(idle)


def random_geometry(arm: Arm, rng: np.random.Generator, length: float = 5e-4, angle: float = 5e-4) -> Array:
    """Corrections (S, 6) of the joints' frames, with standard deviations `length` [m] and `angle` [rad]."""
    geometry = rng.normal(size=(arm.slots, 6)) * ([length] * 3 + [angle] * 3)
    geometry[[0, -1]] = 0.0
    return geometry


@dataclass(frozen=True)
class _Draws:
    """Random parts, each from a stream of its own: more shots do not change the robot."""

    seed: int

    def _rng(self, stream: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, stream])

    def repeatability(self, problem: Problem, truth: Truth) -> Array:
        """(N, S, 6) joint errors of each standstill, common to its targets and shots."""
        stated = problem.robot.repeatability
        sigma = stated if truth.repeatability is None else truth.repeatability
        out = np.zeros((len(problem.q), 6 * problem.arm.slots))
        out[:, problem.arm.axial] = sigma * self._rng(0).normal(size=problem.q.shape)
        return out.reshape(len(problem.q), -1, 6)

    def instrument(self, problem: Problem) -> tuple[Array, Array]:
        """R (K, 3, 3), t (K, 3): on its tripod, 3–5 m away, turned about the vertical as it comes."""
        rng, count = self._rng(1), len(problem.campaign.setup_names)
        turn, bearing = rng.uniform(-np.pi, np.pi, (2, count))
        distance, height = rng.uniform(3, 5, count), rng.uniform(-1.5, 0, count)
        t = np.stack([distance * np.cos(bearing), distance * np.sin(bearing), height], axis=1)
        return rotation_about("z", turn), t

    def noise(self, points: Array, sigma: float, shots: int, six_dof: bool) -> Array:
        """(N, T, shots, 3) noise of the instrument."""
        n_poses, n_targets, _ = points.shape
        rng = self._rng(2)
        if not six_dof:
            return sigma * rng.normal(size=(n_poses, n_targets, shots, 3))
        # six independent errors of a rigid pose, as large at the targets as `sigma` says
        A = body_jacobian(points - points.mean(axis=1, keepdims=True))
        Q = np.linalg.qr(A.reshape(n_poses, -1, 6))[0]
        error = np.sqrt(n_targets) * sigma * Q @ rng.normal(size=(n_poses, 6, shots))
        return error.reshape(n_poses, n_targets, 3, shots).transpose(0, 1, 3, 2)

    def torque(self, torque: Array, share: float) -> Array:
        """(N, n) torques of the drives with noise."""
        return torque + share * np.abs(torque).max(axis=0) * self._rng(3).normal(size=torque.shape)


def _check_acting(problem: Problem, truth: Truth) -> None:
    """Raises `InputError` for effects that were asked for and do nothing here."""
    faults = []
    for effect, values in truth.effects:
        if effect.acts not in ("transmission", "geometry") or not values.any():
            continue
        if not any(basis.any() for basis in effect.motion(problem).values()):
            why = type(effect).needs(problem) or "it needs other poses"
            faults.append(Fault(effect.label, "does nothing in these poses", why))
    if faults:
        raise InputError(faults)


def _direct(problem: Problem, truth: Truth) -> Array:
    """(N, S, 6) motions that do not depend on load."""
    n_poses = len(problem.q)
    out = truth.acting.direct(problem).reshape(n_poses, -1)
    if truth.joints is not None:
        out[:, problem.arm.axial] += truth.joints(problem)
    if truth.motion is not None:
        for column, motion in truth.motion(problem).items():
            out[:, column] += motion
    return out.reshape(n_poses, -1, 6)


def true_robot(problem: Problem, truth: Truth, direct: Array) -> tuple[ElasticTwin, Loads]:
    """The true robot in Drake, with a joint for all that `direct` (N, S, 6) moves in N poses; its loads."""
    geometry = problem.arm.geometry if truth.geometry is None else problem.arm.geometry + truth.geometry
    arm, loads = truth.acting.loads(problem, problem.arm)
    if truth.torque is not None:
        loads = replace(loads, torque=loads.torque + truth.torque(problem))
    hidden = tuple((slot, tuple(range(6)), _with_slope(form)) for slot, form in truth.yields.items())
    stated = truth.acting.yielding(arm)
    yielding = replace(stated, bent=(*stated.bent, *hidden))
    moved = np.flatnonzero(direct.reshape(len(direct), -1).any(axis=0))
    places = [divmod(int(column), 6) for column in moved]
    twin = elastic_twin(problem.arm, problem.robot, yielding, places, loads.compensator)
    twin.set_geometry(geometry)
    twin.set_masses(arm)
    return twin, loads


def _settle(problem: Problem, truth: Truth, direct: Array, drives: bool) -> tuple[Array, Array | None]:
    """Targets (N, T, 3) [m] in the base frame and, if asked for, torques of the drives (N, n), from Drake."""
    twin, loads = true_robot(problem, truth, direct)
    targets = _targets(problem, truth)
    points = np.empty((len(direct), len(problem.on), 3))
    torque = np.empty(problem.q.shape) if drives else None
    for i in range(len(direct)):
        twin.equilibrium(problem.q[i], direct[i], pose_loads(loads, i))
        points[i] = twin.points(targets, problem.on)
        if torque is not None:
            torque[i] = twin.drive_torque()
    return points, torque


def _with_slope(form: Callable[[Array], Array]) -> Law:
    """A hook's law for a batch of wrenches (N, 6), with its slope by differences."""

    def law(wrench: Array) -> tuple[Array, Array]:
        step = 1e-4 * np.maximum(np.abs(wrench), 1.0)
        motion = np.array([form(one) for one in wrench])
        slope = np.empty((len(wrench), 6, 6))
        for c in range(6):
            there = wrench.copy()
            there[:, c] += step[:, c]
            slope[:, :, c] = (np.array([form(one) for one in there]) - motion) / step[:, c, None]
        return motion, slope

    return law


def _targets(problem: Problem, truth: Truth) -> Array:
    """True places of the targets (T, 3) in the frames behind their slots."""
    targets = problem.stated_targets if truth.targets is None else truth.targets
    faults = [
        Fault(f"target {target.name}", "has no place to simulate", "state its xyz_mm")
        for target, place in zip(problem.campaign.targets, targets, strict=True)
        if not np.isfinite(place).all()
    ]
    if faults:
        raise InputError(faults)
    return targets


def pose_loads(loads: Loads, i: int) -> Loads:
    """The loads of one pose."""
    law = loads.compensator
    if law is not None and np.ndim(law.charge):
        law = replace(law, charge=np.asarray(law.charge)[i : i + 1])
    here = slice(i, i + 1)
    return Loads(loads.mass[here], loads.moment[here], loads.wrench[here], loads.torque[here], law)


def _see(problem: Problem, truth: Truth, points: Array) -> Array:
    """The points as the instrument shows them, without noise."""
    out = truth.acting.seen(problem, points)
    return out if truth.seen is None else truth.seen(problem, out)
