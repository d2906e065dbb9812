"""The error to be expected at the tool: what an uncorrected program misses, and what correction leaves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign, Target
from ...campaign.flange_load import beyond_load
from ...campaign.measured_when import beyond_temperature, beyond_time, kelvin_beyond
from ...campaign.planned import planned
from ...campaign.problem import Problem, problem_of
from ...correction.extended_arm import extended_arm, parts
from ...effects import catalogue
from ...effects.acting import Acting
from ...files.faults import Fault, InputError
from ...robot.description import Robot, load_robot
from ...robot.kinematics import Array, frames
from ...robot.ranges import MARGIN, beyond_range
from ...robot.rotations import from_vectors
from ...robot.schema import stated_load
from ...robot.uncertainty import LEAST, Turning, Uncertainty
from .tempering import Tempering
from .tool import in_its_base, tool_motion, tool_points, tool_problem, turns_of

TOGETHER = "combination of joints"  # each of them inside of its range
LOAD, WARMTH, TIME = "load on the flange", "temperature", "time"


@dataclass(frozen=True, eq=False)
class ToolTurns:
    """How far the tool is turned off at N poses, [rad]. error: (N, 3) the corrected robot's tool from the
    nominal one's, a rotation vector in the nominal robot's base; nominal, corrected: (N,) angles that 95 % do
    not exceed without and with the correction."""

    error: Array
    nominal: Array
    corrected: Array

    @property
    def angle(self) -> Array:
        """(N,) [rad] by which the nominal robot's tool is turned off."""
        return np.asarray(np.linalg.norm(self.error, axis=1))


@dataclass(frozen=True, eq=False)
class ToolErrors:
    """What to expect at N poses, T points of the tool; lengths in m, the nominal robot's base frame.

    error: (N, T, 3) the corrected robot's point minus the nominal one's; nominal, corrected: (N, T) lengths
    that 95 % of the errors do not exceed without and with the correction; places: (N, T, 3) of the nominal
    robot. outside: (N) what of a pose lies outside of what was measured ("" inside). notes: what could not be
    taken into account. in_base: in the robot's base, as targets on it say where it is, and the nominal robot
    rigid, as its controller takes it; else base and tool are set up anew, for either robot, as well as the
    campaign allows.
    """

    campaign: Campaign
    error: Array
    nominal: Array
    corrected: Array
    places: Array
    outside: tuple[str, ...]
    notes: tuple[str, ...]
    in_base: bool
    turns: ToolTurns | None = None

    def __repr__(self) -> str:
        said = f"{len(self.outside)} poses, nominal error {1e3 * float(self.length.mean()):.3f} mm"
        return f"ToolErrors at {said}, after correction {1e3 * float(np.median(self.worst)):.3f} mm (95 %)"

    @property
    def length(self) -> Array:
        """(N, T) [m] of the nominal robot's error."""
        return np.asarray(np.linalg.norm(self.error, axis=2))

    @cached_property
    def worst(self) -> Array:
        """(N,) [m] largest bound of a pose's points after correction."""
        return np.asarray(self.corrected.max(axis=1))

    @property
    def measured(self) -> NDArray[np.bool_]:
        """(N,) the pose lies inside of what was measured."""
        return np.array([not said for said in self.outside])

    @cached_property
    def beyond_limits(self) -> tuple[str, ...]:
        """Joints that each pose has beyond their limits ("" none)."""
        joints = self.campaign.robot.joints
        beyond = [joint.beyond(q) for joint, q in zip(joints, self.campaign.poses.q.T, strict=True)]
        return tuple("; ".join(joints[j].name for j in np.flatnonzero(pose)) for pose in np.transpose(beyond))

    def some(self, poses: NDArray[np.bool_]) -> ToolErrors:
        """Some of the poses, (N,)."""
        return replace(
            self,
            campaign=self.campaign.some(np.flatnonzero(poses)),
            error=self.error[poses],
            nominal=self.nominal[poses],
            corrected=self.corrected[poses],
            places=self.places[poses],
            outside=tuple(said for said, kept in zip(self.outside, poses, strict=True) if kept),
            turns=self.turns
            and ToolTurns(self.turns.error[poses], self.turns.nominal[poses], self.turns.corrected[poses]),
        )

    def share_inside(self, tolerance: float) -> tuple[float, float]:
        """Share of the poses at which every point of the tool stays within `tolerance` [m] with 95 %:
        without and with the correction (guard band as in JCGM 106:2012)."""
        before = float(np.mean(self.nominal.max(axis=1) <= tolerance))
        return before, float(np.mean(self.worst <= tolerance))


def predict(
    model: Robot | str | Path,
    poses: Campaign | Array,
    payload: str | Sequence[str] = "",
    instrument: float = 0.0,
    own_frame: bool | None = None,
) -> ToolErrors:
    """The error to be expected at the tool, from the model.toml of a diagnosis.

    poses: (N, n) joints [rad, m], carrying the model's tool and its `payload` (one, or N names), or a
    campaign, whose points do not count. instrument: [m] one sigma per axis of who measures; 0: the tool
    itself. own_frame: whether the base is set up anew there, as for a campaign that finds its own frame
    (None: of a campaign that has points); else errors are those in the robot's base, where it was measured.
    Raises `InputError` for a model without `[prediction]`.
    """
    robot = model if isinstance(model, Robot) else load_robot(model)
    data = required_uncertainty(robot)
    campaign = poses if isinstance(poses, Campaign) else posed(robot, poses, payload)
    campaign = replace(campaign, robot=robot)
    targets = [Target(p.name, _metres(p.xyz_mm)) for p in data.points]
    told = tool_problem(problem_of(campaign), targets)
    arm = extended_arm(told)
    own_frame = campaign.n_points > 0 if own_frame is None else own_frame
    in_base = data.base_measured and not own_frame
    found = [_part(told, arm.acting, data, part, instrument, in_base) for part in _parts(told)]
    error, nominal, corrected, places, far, *turns = map(np.concatenate, zip(*found, strict=True))
    notes = [*arm.notes, *_sided(told, arm.acting), *_warm(told, data)]
    if data.instrument_inside:
        notes.append("nobody knows the instrument's noise: it is in the bounds as well")
    if not data.turn_measured and not in_base:
        notes.append(
            "all points were measured on one line or in one place: nothing says how the base stands turned "
            "about it, and the bounds do not have that; align base and instrument by other points"
        )
    outside = _outside(told, arm.acting, data, far)
    turned = ToolTurns(*turns) if turns else None
    said = outside, tuple(notes)
    return ToolErrors(told.campaign, error, nominal, corrected, places, *said, in_base, turned)


def required_uncertainty(robot: Robot) -> Uncertainty:
    """What a model knows of its errors; raises `InputError` where it does not say."""
    if robot.uncertainty is None:
        what = "has no [prediction]: it does not say how sure it is"
        mend = f"give the model.toml of a diagnosis by at least {LEAST} points of targets on the flange"
        raise InputError(Fault(str(robot.path or robot.name), what, mend))
    return robot.uncertainty


def posed(robot: Robot, q: Array, payload: str | Sequence[str] = "") -> Campaign:
    """Poses (N, n) [rad, m] with the model's tool, carrying a payload that it knows (one, or N names).

    Raises `InputError` for another."""
    carried = [payload] * len(q) if isinstance(payload, str) else list(payload)
    carried = [name or robot.mounted for name in carried]
    loads = {}
    for name in filter(None, dict.fromkeys(carried)):
        if name not in robot.payloads:
            known = ", ".join(robot.payloads) or "none"
            raise InputError(Fault(f"payload {name!r}", "is not in the model", f"known: {known}"))
        loads[name] = stated_load(robot.payloads[name])
    return planned(robot, q, payloads=loads, payload=carried, tool=stated_load(robot.tool))


def _parts(told: Problem) -> Iterator[NDArray[np.int64]]:
    for part in parts(len(told.q)):
        yield np.arange(part.start, part.stop)


def _part(
    told: Problem,
    acting: Acting,
    data: Uncertainty,
    part: NDArray[np.int64],
    instrument: float,
    in_base: bool,
) -> tuple[Array, ...]:
    """Error, bounds without and with correction, nominal places, the fitted numbers' spread (N,); and of the
    turns, where the model knows of them, error and both bounds."""
    here = replace(told, campaign=told.campaign.some(part))
    at = tool_motion(here, acting)
    rows = placed(data, at.names)
    beyond = acting.beyond(here)
    there = beyond.any(axis=0)
    ended = at.direct[..., there] * beyond[:, None, None, there]
    warm = _warmed(here, acting, at.direct, _kelvin(here, acting, data))
    seen = np.concatenate([at.J @ rows, ended, warm], axis=-1)
    unsure = np.concatenate([at.J @ in_its_base(rows), ended, warm], axis=-1) if in_base else seen
    fitted = unsure @ unsure.swapaxes(-1, -2)
    joint = at.joint * np.array(data.repeatability)
    play = _play(here, acting, at.points)
    other = joint @ joint.swapaxes(-1, -2) + play @ play.swapaxes(-1, -2) + instrument**2 * np.eye(3)
    places, error = (_rigid if in_base else _nominal)(here, data, at.points)
    tempering = Tempering(data.rest, data.tempering, data.growth)
    unit = np.where(told.arm.prismatic, 3.0, 1.0)
    beyond = (np.maximum(np.array(data.lower) - here.q, here.q - np.array(data.upper)) * unit).max(axis=1)
    beyond = np.maximum(beyond, 0.0)
    each = np.broadcast_to(beyond[:, None], error.shape[:2])
    corrected = tempering.bound(fitted, other, each)
    nominal = tempering.bound(fitted, other, each, error)
    spread = np.sqrt((seen**2).sum(axis=(2, 3)).max(axis=1))
    if data.turning is None:
        return error, nominal, corrected, places, spread
    turns = _turns(data.turning, at.points, error, (unsure, np.concatenate([joint, play], axis=-1)), beyond)
    return error, nominal, corrected, places, spread, *turns


def _turns(
    data: Turning, points: Array, error: Array, unsure: tuple[Array, Array], beyond: Array
) -> tuple[Array, Array, Array]:
    """Error (N, 3) of the tool's turn, and its bounds (N,) without and with correction. points, error: (N, T,
    3) [m]; unsure: (N, T, 3, k) one sigma of the points' motions by the fitted numbers, and by the joints."""
    turned = turns_of(points, np.ones(points.shape[:2], bool))

    def of(motions: Array) -> Array:
        return np.asarray(turned @ motions.reshape(len(points), -1, motions.shape[-1]))

    fitted, joint = (of(each) @ of(each).swapaxes(-1, -2) for each in unsure)
    turn = of(error[..., None])[..., 0]
    tempering = Tempering(data.rest, data.tempering, data.growth)
    return turn, tempering.bound(fitted, joint, beyond, turn), tempering.bound(fitted, joint, beyond)


def placed(data: Uncertainty, names: tuple[str, ...]) -> Array:
    """(P, k) rows of the covariance's factor in the order of `names` (the base first); zeros for what it does
    not have."""
    at = dict(zip(data.names, data.F, strict=True))
    none = np.zeros(data.F.shape[1])
    return np.array([at.get(name, none) for name in names])


def _nominal(here: Problem, data: Uncertainty, points: Array) -> tuple[Array, Array]:
    """Places (N, T, 3) of the nominal robot, and how far the corrected robot's are off, in its base frame."""
    bare = replace(here.campaign.robot, geometry={}, effects=())
    targets = [Target(p.name, _metres(p.nominal_xyz_mm)) for p in data.points]
    told = tool_problem(replace(here, robot=bare, arm=here.arm.with_geometry(0 * here.arm.geometry)), targets)
    places = tool_points(told)
    shift, turn = np.array(data.nominal_base[:3]), from_vectors(np.array(data.nominal_base[3:]))
    return places, (points - shift) @ turn - places


def _rigid(here: Problem, data: Uncertainty, points: Array) -> tuple[Array, Array]:
    """The same with the arm as its controller takes it, in the same base and with the same tool."""
    there = frames(here.arm.with_geometry(0 * here.arm.geometry), here.q)
    tool = np.array([_metres(p.xyz_mm) for p in data.points])
    places = there.p[-1][:, None] + tool @ (there.R[-1] @ here.arm.R_link[-1]).swapaxes(-1, -2)
    return places, points - places


def _kelvin(told: Problem, acting: Acting, data: Uncertainty) -> Array:
    """(N,) by how much poses are warmer than any that were measured, colder below zero."""
    return kelvin_beyond(told, data.temperature_degC, "temperature" in acting.uses)


def _warmed(here: Problem, acting: Acting, direct: Array, kelvin: Array) -> Array:
    """(N, T, 3, k) one sigma of the points' motions by what warms beyond what was measured; direct: (N, T, 3,
    6 S) how they move with the slots."""
    found = {effect.cause for effect, _ in acting if "temperature" in effect.uses}
    out = [np.zeros((*direct.shape[:3], 1))]
    for cause, kind in catalogue().items():
        motions = kind.unmeasured(here, kelvin, cause in found)
        moved = [direct[..., c, None] * way[:, None, None] for c, way in motions.items()]
        out += [np.sum(moved, axis=0)] if moved else []
    return np.concatenate(out, axis=-1)


def _warm(told: Problem, data: Uncertainty) -> Iterator[str]:
    """A note where either the poses or the measurement do not say how warm it was."""
    if data.temperature_degC and told.warmth is None:
        ends = "to".join(f" {t:.3g} " for t in data.temperature_degC)
        yield f"the poses have no temperature: the bounds are for{ends}°C, as it was measured"
    if told.warmth is not None and not data.temperature_degC:
        yield (
            "no temperature was recorded when the robot was measured: what it has grown by since nobody "
            "knows, and it is not in the bounds"
        )


def _sides(told: Problem) -> Array:
    """(N, n) sides from which the joints come, 0 where nobody says it."""
    side = told.campaign.poses.side
    return np.zeros_like(told.q) if side is None else side


def _play(here: Problem, acting: Acting, points: Array) -> Array:
    """(N, T, 3, n) how far the points move by the side from which each joint comes, where nobody says it."""
    said = _sides(here)
    if said.all() or "side" not in acting.uses:
        return np.zeros((*points.shape, 1))
    out = []
    for side in np.eye(here.arm.n):
        campaign = here.campaign.with_poses(side=np.where(said == 0, side, said))
        out.append(tool_points(replace(here, campaign=campaign), acting) - points)
    return np.stack(out, axis=-1)


def _sided(told: Problem, acting: Acting) -> Iterator[str]:
    """A note where the poses do not say from which side they are reached, and it matters."""
    unsaid = (_sides(told) == 0).sum(axis=0)
    for effect, _ in acting:
        if "side" not in effect.uses:
            continue
        if told.campaign.poses.side is None:
            yield f"{effect.label}: the poses have no dir columns; the bounds hold for either side"
        elif count := unsaid[told.joint(effect.where.joint)]:
            yield (
                f"{effect.label}: at {count} of {len(told.q)} poses nothing says from which side the joint "
                "comes; the bounds there hold for either side"
            )


def _outside(told: Problem, acting: Acting, data: Uncertainty, far: Array) -> tuple[str, ...]:
    """What of each pose lies outside of what was measured: joints beyond their ranges, the load on the
    flange, temperature, or time where something hangs on it; or the joints' combination, where the fitted
    numbers are less sure of the tool, far (N,) [m], than at any measured pose (hidden extrapolation:
    Montgomery et al. 2012)."""
    beyond = {
        LOAD: beyond_load(told, data.flange_load),
        WARMTH: beyond_temperature(_kelvin(told, acting, data), data.temperature_degC),
        TIME: beyond_time(told, data.time_s if "time" in acting.uses else ()),
    }
    joints = beyond_range(told.q, np.array(data.lower), np.array(data.upper))
    off = np.column_stack([joints, *beyond.values()])
    names = (*told.arm.names, *beyond)
    spread = far > (1 + MARGIN) * data.farthest
    return tuple(
        "; ".join(names[k] for k in np.flatnonzero(row)) or TOGETHER * bool(unsure)
        for row, unsure in zip(off, spread, strict=True)
    )


def _metres(place: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = place
    return 1e-3 * x, 1e-3 * y, 1e-3 * z
