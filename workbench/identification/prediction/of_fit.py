"""What a fit knows of its own errors, as a model.toml keeps it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ...campaign import Target
from ...campaign.flange_load import flange_load
from ...campaign.measured_when import temperatures, times
from ...campaign.planned import joint_ranges
from ...campaign.problem import Problem
from ...effects.acting import Acting
from ...effects.base import Effect
from ...robot.equilibrium import NoRest
from ...robot.kinematics import Array
from ...robot.rotations import from_vectors, skew, vectors
from ...robot.uncertainty import DIGITS, LEAST, ToolPoint, Turning, Uncertainty, factor_lines
from ..fit import Fit, start_state
from ..model import Model
from ..noise import Covariance, stated_noise
from ..own_base import own_base
from ..parameters import body_motion
from ..set_up import fit_set_up
from .left_out import RIGID, Leaver, tempered
from .tempering import is_overstated, temper
from .tool import ToolMotion, in_its_base, tool_motion, tool_points, tool_problem
from .unsteady import unsteady

SAMPLES = 100  # poses within the limits that say which directions move the tool
FAINT = 0.01  # of the tool's spread at the measured poses: what leaving directions out may cost
SEED = 0
PLACES = 200  # measured ones that are kept for a map
ON_A_LINE = 1e-3  # of the distance from the base: points so near to a line show no turn about it
ITS_ERROR = 2.0  # times what the model leaves: so near it is where the model errs, and no place apart


_kept: WeakKeyDictionary[Fit, Uncertainty | None] = WeakKeyDictionary()


def uncertainty(result: Fit) -> Uncertainty | None:
    """How sure a fit is of the tool's place, worked out once; see `_uncertainty`."""
    if result not in _kept:
        _kept[result] = _uncertainty(result)
    return _kept[result]


def _uncertainty(result: Fit) -> Uncertainty | None:
    """Covariance of the numbers that last, in the robot's own base, reduced to what moves the tool; and the
    tempering of bounds.

    None where no target sits on the flange, or there are too few points to judge by.
    """
    problem = result.model.problem
    gauge = _gauge(result)
    if int(problem.seen[:, gauge.chosen].sum()) < LEAST:
        return None
    acting = result.model.acting(result.state).those(_own)
    kept = own_base(problem, result.state.geometry)
    told = tool_problem(replace(problem, arm=kept.arm(problem.arm)), gauge.targets)
    at = tool_motion(told, acting)
    known = stated_noise(problem) is not None or bool(np.isfinite(result.noise.dof))
    on_flange = np.isin(np.arange(problem.seen.shape[1]), gauge.chosen)
    leaver = Leaver(result, on_flange)
    known = known and not is_overstated(leaver)
    tempering, variance = temper(leaver, known)
    rows = _rows(result, gauge, at.names, variance)
    if not kept.measured:
        as_fitted = replace(problem, arm=problem.arm.with_geometry(result.state.geometry))
        moved = tool_motion(tool_problem(as_fitted, gauge.targets), acting).J
        rows = _without_axis_1(rows, kept.R.T @ moved, at.J)
    here = (problem.campaign.poses.setup == gauge.setup)[:, None] & problem.seen[:, gauge.chosen]
    left = float(np.sqrt(np.sum(result.residual[:, gauge.chosen][here] ** 2, axis=-1).mean()))
    idle = _idle_turns(at.points[here], ITS_ERROR * left)
    rows[:6] -= idle @ (idle[3:].T @ rows[3:6])
    factor = _reduced(rows, at.J, _far(told, acting, at).J, kept.measured)
    fitted = at.J @ factor
    base, nominal = _nominal(problem, told, at.points)
    places = [np.array(target.xyz) for target in gauge.targets]
    return Uncertainty(
        points=tuple(
            ToolPoint(name=target.name, xyz_mm=_mm(place), nominal_xyz_mm=_mm(other))
            for target, place, other in zip(gauge.targets, places, nominal, strict=True)
        ),
        nominal_base=_numbers(base),
        campaign=_called(problem, gauge.setup),
        base_measured=kept.measured,
        flange_measured=problem.flange_measured,
        turn_measured=not idle.size,
        names=at.names,
        factor=factor_lines(factor),
        rest=float(np.hypot(tempering.rest, unsteady(result, on_flange))),
        repeatability=_numbers(result.noise.joint),
        tempering=tempering.factor,
        growth=tempering.growth,
        turning=_turning(result, on_flange, known, variance),
        lower=tuple(problem.q.min(axis=0).tolist()),  # not rounded: a joint that was held still has no margin
        upper=tuple(problem.q.max(axis=0).tolist()),
        farthest=float(np.sqrt((fitted**2).sum(axis=(2, 3)).max())),
        flange_load=_numbers(np.array(flange_load(problem))),
        temperature_degC=_numbers(np.array(temperatures(problem))),
        time_s=_numbers(np.array(times(problem))),
        instrument_inside=not known,
        measured_mm=_some((at.points.mean(axis=1) - base[:3]) @ from_vectors(base[3:])),
    )


def _turning(
    result: Fit, on_flange: NDArray[np.bool_], instrument_known: bool, variance: float
) -> Turning | None:
    """What bounds of the tool's turns have, under the same variance of the fitted numbers; None where it was
    not measured as a pose."""
    if not result.model.problem.campaign.six_dof or on_flange.sum() < RIGID:
        return None
    found, _ = temper(Leaver(result, on_flange, turns=True), instrument_known, variance)
    return Turning(rest=found.rest, tempering=found.factor, growth=found.growth)


@dataclass(frozen=True)
class _Gauge:
    """The set-up in whose frame the base is known, and the targets on the flange that it saw."""

    setup: int
    chosen: list[int]
    targets: tuple[Target, ...]


def _gauge(result: Fit) -> _Gauge:
    """The set-up with most poses, of several campaigns of the last, whose tool is mounted now; of all where
    the last shows its tool too seldom to judge by."""
    problem = result.model.problem
    of = problem.campaign.of_campaign
    now = _most_measured(result, of == of[-1])
    enough = problem.seen[:, now.chosen].sum() >= LEAST
    return now if enough else _most_measured(result, np.ones_like(of, dtype=bool))


def _called(problem: Problem, setup: int) -> str:
    """What the campaign of a set-up is called, of several that are fitted together."""
    c = problem.campaign
    return c.labels[c.of_campaign[c.poses.setup == setup][0]] if c.labels else ""


def _most_measured(result: Fit, among: NDArray[np.bool_]) -> _Gauge:
    """The set-up that most of some poses (N,) are of."""
    problem, c = result.model.problem, result.model.problem.campaign
    setup = int(np.bincount(c.poses.setup[among]).argmax())
    seen = problem.seen[c.poses.setup == setup].any(axis=0)
    flange = problem.arm.slots - 1
    chosen = [i for i, slot in enumerate(problem.on) if slot == flange and seen[i]]
    targets = []
    for i in chosen:
        x, y, z = (problem.arm.R_link[flange].T @ result.state.targets[setup, i]).tolist()
        targets.append(Target(c.targets[i].name, (x, y, z)))
    return _Gauge(setup, chosen, tuple(targets))


def _rows(result: Fit, gauge: _Gauge, names: Sequence[str], variance: float) -> Array:
    """(M, P) square root of the covariance of the numbers `names` of the tool's motion: the base as seen from
    one set-up, the targets, geometry, and the effects (zero for those of the robot's own model)."""
    cols, state, k = result.columns, result.state, gauge.setup
    lower = np.linalg.cholesky(tempered(result.upper.T @ result.upper, variance))
    half = solve_triangular(lower, np.eye(len(lower)), lower=True).T * cols.prior[:, None]
    half = _with_passing(result, gauge, half)
    R, arm = state.R[k].T, skew(state.t[k] - result.line.centre[k])
    frame = half[6 * k : 6 * k + 6]
    out = [np.vstack([R @ (frame[:3] - arm @ frame[3:]), R @ frame[3:]])]
    places = np.zeros((*state.targets[k].shape, len(half)))
    for setup, i, part in cols.targets:
        if setup == k and i is not None:
            places[i] = half[part]
        elif setup == k:
            places = (body_motion(state.targets[k]) @ half[part]).reshape(places.shape)
    out.append(places[gauge.chosen].reshape(-1, len(half)))
    slots = np.zeros((state.geometry.size, len(half)))
    slots[cols.geometry] = half[cols.geometry_slice]
    out.append(slots[list(result.model.problem.corrections)])
    stated = sum(len(values) for effect, values in result.model.known if _own(effect))
    out.append(np.zeros((stated, len(half))))
    for item, row in zip(result.model.given, half[cols.given_slice], strict=True):
        if _own(item.effect):
            out.append(row[None])
    for effect, part in zip(result.model.effects, cols.effect, strict=True):
        if _own(effect):
            out.append(half[part])
    rows = np.vstack(out)
    assert len(rows) == len(names)
    return rows


def _without_axis_1(rows: Array, was: Array, J: Array) -> Array:
    """Rows (M, P) of the covariance's root with what axis 1 does in the base given to the base, which nothing
    that the arm carries tells from it: they are unsure together and cancel. was: (N, T, 3, M) how the tool
    moves in the base of the fit, J: the same in the robot's own."""
    first = J.shape[1] * 3 + 6  # behind base and targets
    axis, out = slice(first, first + 6), rows.copy()
    before, now = (each.reshape(-1, each.shape[3]) for each in (was, J))
    moved = before[:, :6] @ rows[:6] + before[:, axis] @ rows[axis]
    out[:6], out[axis] = np.linalg.lstsq(now[:, :6], moved)[0], 0.0
    return out


def _idle_turns(points: Array, error: float) -> Array:
    """(6, k) shift and turn, for a turn by 1 rad, of the turns of the base about its axes or lines that move
    none of a model's points (M, 3) [m] beyond its own error [m]: points held in two sockets do not say how
    the base stands turned about the line through these, nor points held in one how it stands turned at all.
    It is where the instrument's frame is, and no error of the robot: who sets a robot up there aligns it
    otherwise."""
    middle = points.mean(axis=0)
    variances, axes = np.linalg.eigh((points - middle).T @ (points - middle) / len(points))
    lever = np.sqrt(np.maximum(variances.sum() - variances, 0.0))
    far = np.sqrt((points**2).sum(axis=1).mean())
    idle = axes[:, lever < max(ON_A_LINE * far, error)]
    return np.vstack([np.cross(middle, idle.T).T, idle])


def _with_passing(result: Fit, gauge: _Gauge, half: Array) -> Array:
    """The square root (P, P) with base and targets where they were on the whole of the campaign: what moves
    them for a time, or as the instrument sees it, and what it hides of where they are, goes together."""
    cols, k = result.columns, gauge.setup
    effects = zip(result.model.effects, cols.effect, strict=True)
    passing = [np.arange(part.start, part.stop) for effect, part in effects if not _own(effect)]
    if not passing:
        return half
    rows = (3 * np.array(gauge.chosen)[:, None] + np.arange(3)).ravel()
    moved = result.motions.columns[result.model.problem.campaign.poses.setup == k][:, rows]
    moved = moved.reshape(-1, len(half))
    own = [np.arange(part.start, part.stop) for setup, _, part in cols.targets if setup == k]
    placing = np.concatenate([np.arange(6 * k, 6 * k + 6), *own])
    gone = np.concatenate(passing)
    out = half.copy()
    out[placing] += np.linalg.lstsq(moved[:, placing], moved[:, gone] @ half[gone], rcond=1e-9)[0]
    return out


def _own(effect: Effect) -> bool:
    """Whether it moves the tool in other campaigns as well."""
    return effect.lasting and effect.acts != "instrument"


def _anywhere(told: Problem) -> Problem:
    """Poses drawn at random within the limits, under the loads of measured ones."""
    rng = np.random.default_rng(SEED)
    lower, upper = joint_ranges(told.robot)
    some = rng.integers(len(told.q), size=SAMPLES)
    campaign = told.campaign.some(some).with_poses(q=rng.uniform(lower, upper, (SAMPLES, len(lower))))
    return replace(told, campaign=campaign)


def _far(told: Problem, acting: Acting, near: ToolMotion) -> ToolMotion:
    """How the tool moves in poses drawn anywhere. What was found may be so soft that the arm stands in the
    measured poses (`near`) and not in all others: those are left out."""
    anywhere = _anywhere(told)
    try:
        return tool_motion(anywhere, acting)
    except NoRest:
        each = (replace(anywhere, campaign=anywhere.campaign.some(np.array([n]))) for n in range(SAMPLES))
        standing = np.array([_stands(one, acting) for one in each])
    if not standing.any():
        return near
    some = anywhere.campaign.some(np.flatnonzero(standing))
    return tool_motion(replace(anywhere, campaign=some), acting)


def _stands(told: Problem, acting: Acting) -> bool:
    """Whether the arm finds a rest in the poses."""
    try:
        tool_points(told, acting)
    except NoRest:
        return False
    return True


def _reduced(rows: Array, near: Array, far: Array, base_measured: bool) -> Array:
    """(M, k) a factor of the covariance without what does not move the tool, by its motions (N, T, 3, M) at
    the measured poses and elsewhere; nor moves it in a base that was measured."""
    seen = [rows, in_its_base(rows)] if base_measured else [rows]
    moved = [J.reshape(-1, len(rows)) @ each for each in seen for J in (near, far)]
    least = FAINT**2 * float((moved[0] ** 2).mean(axis=0).sum())
    normal = sum(m.T @ m / len(m) for m in moved)
    size, way = np.linalg.eigh(normal)
    kept = np.cumsum(np.maximum(size, 0.0)) > least
    return np.asarray(rows @ way[:, kept])


def _nominal(problem: Problem, told: Problem, points: Array) -> tuple[Array, Array]:
    """Where the nominal robot's base (6,) and targets (T, 3) are best taken to be, by the corrected robot's
    points at the measured poses: what an uncorrected program works with."""
    c = told.campaign
    bare = replace(problem.robot, geometry={}, effects=())
    seen = replace(c, robot=bare, points=points, shots=np.ones(points.shape[:2], dtype=np.int64))
    nominal = Problem(bare, told.arm.with_geometry(0 * told.arm.geometry), seen, problem.compensator)
    noise = Covariance(np.full(points.shape[:2], 1e-4), np.zeros(problem.arm.n), np.ones(len(points)))
    state = fit_set_up(Model(nominal), start_state(nominal), noise).state
    return np.concatenate([state.t[0], vectors(state.R)[0]]), state.targets[0] @ problem.arm.R_link[-1]


def _some(places: Array) -> tuple[str, ...]:
    """At most `PLACES` of the places (N, 3) [m], evenly from first to last, in mm."""
    rows = np.unique(np.linspace(0, len(places) - 1, min(PLACES, len(places))).astype(int))
    return tuple(" ".join(f"{1e3 * value:.1f}" for value in row) for row in places[rows].tolist())


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(float(f"{value:.{DIGITS}g}") for value in values.tolist())


def _mm(place: Array) -> tuple[float, float, float]:
    x, y, z = (round(1e3 * value, DIGITS) for value in place.tolist())
    return x, y, z
