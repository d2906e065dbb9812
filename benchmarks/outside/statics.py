"""An arm at rest: gravity, elastic joints, bearings and links, for all poses at once.

Own equations in NumPy, nothing of `workbench`. SI units and radians; in shapes p are poses, n joints and t
targets. A link's vectors stand in its own frame, which is its joint's after the joint has moved.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from arm import Arm, Array, dot, rotation, turned

ROUNDS = 5  # of deflection and load: each leaves less than a hundredth of the error before it
AIR_PA = 101325.0


@dataclass(frozen=True, eq=False)
class Cell:
    """What is measured, and how the robot truly stands: its geometry and the instrument's frame.

    `joints`, `directions` of approach (±1): (p, n); `seconds`, `celsius`: (p,); `loads`: mass (p,) and centre
    (3,) on the flange, tool first; `geometry`: (n, 6) offset and turn before each joint; `targets`: (t, 3).
    """

    joints: Array
    seconds: Array
    celsius: Array
    directions: Array
    loads: list[tuple[Array, Array]]
    targets: Array
    geometry: Array
    instrument_turn: Array
    instrument_offset: Array


@dataclass(eq=False)
class Machine:
    """What a fault may change before anything is computed; `growth`: share by which each offset is longer."""

    mass: Array
    centre: Array
    loads: list[tuple[Array, Array]]
    compensator: dict[str, Any] | None
    growth: Array  # (p, n + 1)


@dataclass(eq=False)
class Deflection:
    """`joints`: (p, n); `tilt`: (p, n, 3) turn behind each joint; `bend`: (p, n, 6) shift and turn at the end
    of each link, `base`: (p, 6) of the base; `growth`: that of the machine.
    """

    joints: Array
    tilt: Array
    bend: Array
    base: Array
    growth: Array

    @classmethod
    def none(cls, poses: int, joints: int, growth: Array | None = None) -> "Deflection":
        growth = np.zeros((poses, joints + 1)) if growth is None else growth
        turn, both = np.zeros((poses, joints, 3)), np.zeros((poses, joints, 6))
        return cls(np.zeros((poses, joints)), turn, both, np.zeros((poses, 6)), growth)


@dataclass(frozen=True, eq=False)
class Frames:
    """In the base frame: per joint its origin and axis (p, 3), and origin and rotation of the moved link."""

    origins: list[Array]
    axes: list[Array]
    link_origins: list[Array]
    link_turns: list[Array]
    flange_origin: Array
    flange_turn: Array


@dataclass(frozen=True, eq=False)
class Loads:
    """By gravity: `torque` (p, n) about each axis (sliding: force along it), with the compensator's; `force`
    and `moment` (p, n, 3) of all beyond a joint, at its origin; `tool_force`, `tool_moment`: at the flange.
    """

    torque: Array
    force: Array
    moment: Array
    tool_force: Array
    tool_moment: Array


@dataclass(frozen=True, eq=False)
class Rest:
    """The arm at rest."""

    arm: Arm
    cell: Cell
    mass: Array
    frames: Frames
    loads: Loads
    bent: Deflection


class Effect:
    """Where a fault may take hold; it overrides what it needs."""

    def alter(self, machine: Machine, cell: Cell) -> None:
        """Changes masses, loads, the compensator or the growth."""

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        """Adds to the deflection of the arm as `rest` has it."""

    def shift_targets(self, cell: Cell, targets: Array) -> Array:
        """What is added to the places (p, t, 3) of the targets on the flange."""
        return np.zeros_like(targets)

    def misread(self, points: Array) -> Array:
        """What is added to the points (p, t, 3) in the instrument's frame."""
        return np.zeros_like(points)


def frames(arm: Arm, joints: Array, bent: Deflection, geometry: Array) -> Frames:
    """Forward kinematics: per joint its offset, what the link before it bends, geometry, motion and tilt."""
    poses = len(joints)
    place = np.zeros((poses, 3)) + bent.base[:, :3]
    turn = np.broadcast_to(np.eye(3), (poses, 3, 3)) @ rotation(bent.base[:, 3:])
    origins, axes, link_origins, link_turns = [], [], [], []
    offsets, turns = [*arm.offsets, arm.flange_offset], [*arm.turns, arm.flange_turn]
    for joint in range(arm.count + 1):
        place = place + turned(turn, offsets[joint] * (1 + bent.growth[:, joint, None]))
        turn = turn @ turns[joint]
        if joint > 0:
            place = place + turned(turn, bent.bend[:, joint - 1, :3])
            turn = turn @ rotation(bent.bend[:, joint - 1, 3:])
        if joint == arm.count:
            break
        place = place + turned(turn, geometry[joint, :3])
        turn = turn @ rotation(geometry[joint, 3:])
        origins.append(place)
        axes.append(turned(turn, arm.axes[joint]))
        moved = joints[:, joint] + bent.joints[:, joint]
        if arm.sliding[joint]:
            place = place + turned(turn, arm.axes[joint]) * moved[:, None]
        else:
            turn = turn @ rotation(arm.axes[joint] * moved[:, None])
        turn = turn @ rotation(bent.tilt[:, joint])
        link_origins.append(place)
        link_turns.append(turn)
    return Frames(origins, axes, link_origins, link_turns, place, turn)


def _compensator_torque(arm: Arm, said: dict[str, Any], at: Frames) -> tuple[int, Array]:
    """Its joint and its torque there, N·m: a spring, or a gas that obeys p·Vᵏ = const, between two pivots."""
    joint = arm.names.index(said["joint"])
    body, moved = arm.links.index(said["body"]), arm.links.index(said["arm"])
    body_pivot = at.link_origins[body] + turned(at.link_turns[body], np.array(said["body_pivot"]))
    arm_pivot = at.link_origins[moved] + turned(at.link_turns[moved], np.array(said["arm_pivot"]))
    between = body_pivot - arm_pivot
    length = np.linalg.norm(between, axis=1)
    if said["kind"] == "gas":
        gas = said["gas_length"]
        pressed = (gas / (gas - (length - said["reference"]))) ** said.get("exponent", 1.0)
        pull = said["piston_area"] * (said["precharge"] * pressed - AIR_PA)
    else:
        pull = said["rate"] * (length - said["free_length"])
    lever = np.cross(arm_pivot - at.origins[joint], between / length[:, None] * pull[:, None])
    return joint, dot(at.axes[joint], lever)


def loads(arm: Arm, machine: Machine, at: Frames) -> Loads:
    """Weights beyond each joint, summed: a static arm's forces and moments."""
    poses = len(at.flange_origin)
    links = [
        (machine.mass[k], at.link_origins[k] + turned(at.link_turns[k], machine.centre[k]))
        for k in range(arm.count)
    ]
    carried = [(mass, at.flange_origin + turned(at.flange_turn, centre)) for mass, centre in machine.loads]

    def weight(mass: Array) -> Array:
        return np.multiply.outer(np.broadcast_to(mass, (poses,)), arm.gravity)

    torque = np.zeros((poses, arm.count))
    force, moment = np.zeros((poses, arm.count, 3)), np.zeros((poses, arm.count, 3))
    for joint in range(arm.count):
        for mass, centre in links[joint:] + carried:
            force[:, joint] += weight(mass)
            moment[:, joint] += np.cross(centre - at.origins[joint], weight(mass))
        along = force if arm.sliding[joint] else moment
        torque[:, joint] = dot(at.axes[joint], along[:, joint])
    tool_force, tool_moment = np.zeros((poses, 3)), np.zeros((poses, 3))
    for mass, centre in carried:
        tool_force += weight(mass)
        tool_moment += np.cross(centre - at.flange_origin, weight(mass))
    if machine.compensator:
        joint, balance = _compensator_torque(arm, machine.compensator, at)
        torque[:, joint] += balance
    return Loads(torque, force, moment, tool_force, tool_moment)


def tilting(rest: Rest, joint: int, one: float, other: float) -> Array:
    """Turn (p, 3) of a bearing by the moment across its axis, with a compliance, rad/(N·m), each way."""
    axis = rest.arm.axes[joint]
    moment = np.einsum("pij,pi->pj", rest.frames.link_turns[joint], rest.loads.moment[:, joint])
    moment = moment - np.outer(moment @ axis, axis)
    first = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = first - axis * (first @ axis)
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    return one * np.outer(moment @ first, first) + other * np.outer(moment @ second, second)


def bending(rest: Rest, joint: int, compliance: float) -> Array:
    """Shift and turn (p, 6) at the end of a joint's link, a cantilever of 1/(E·I) = `compliance`.

    Euler–Bernoulli beam under an end force F, an end moment M and its own weight q per metre:
    deflection F·L³/3 + M·L²/2 + q·L⁴/8, slope F·L²/2 + M·L + q·L³/6, each over E·I.
    """
    arm, at, load = rest.arm, rest.frames, rest.loads
    if joint + 1 < arm.count:
        end, outer = at.origins[joint + 1], arm.turns[joint + 1]
        end_force, end_moment = load.force[:, joint + 1], load.moment[:, joint + 1]
    else:
        end, outer = at.flange_origin, arm.flange_turn
        end_force, end_moment = load.tool_force, load.tool_moment
    along = end - at.link_origins[joint]
    length = np.linalg.norm(along, axis=1)[:, None]
    unit = along / length

    def across(vectors: Array) -> Array:
        return vectors - unit * dot(vectors, unit)[:, None]

    force, moment = across(end_force), across(end_moment)
    own = across(rest.mass[joint] * arm.gravity[None] / length)
    shift = force * length**3 / 3 + np.cross(moment, unit) * length**2 / 2 + own * length**4 / 8
    turn = np.cross(unit, force) * length**2 / 2 + moment * length + np.cross(unit, own) * length**3 / 6
    end_turn = at.link_turns[joint] @ outer
    parts = [np.einsum("pij,pi->pj", end_turn, compliance * part) for part in (shift, turn)]
    return np.concatenate(parts, 1)


def _stated_deflection(rest: Rest, growth: Array) -> Deflection:
    """By the stiffnesses that the robot's own file states."""
    arm = rest.arm
    bent = Deflection.none(len(rest.cell.joints), arm.count, growth)
    elastic = np.isfinite(arm.stiffness)
    bent.joints[:, elastic] = rest.loads.torque[:, elastic] / arm.stiffness[elastic]
    for joint in range(arm.count):
        if np.isfinite(arm.tilt_stiffness[joint]):
            compliance = 1 / arm.tilt_stiffness[joint]
            bent.tilt[:, joint] += tilting(rest, joint, compliance, compliance)
        if np.isfinite(arm.bending_stiffness[joint]):
            bent.bend[:, joint] += bending(rest, joint, 1 / arm.bending_stiffness[joint])
    return bent


def _on_flange(at: Frames, targets: Array) -> Array:
    """Places (p, t, 3) in the base frame of targets (p, t, 3) or (t, 3)."""
    targets = np.broadcast_to(targets, (len(at.flange_origin), *targets.shape[-2:]))
    return at.flange_origin[:, None] + np.einsum("pij,ptj->pti", at.flange_turn, targets)


def measured(arm: Arm, cell: Cell, effects: Sequence[Effect]) -> tuple[Array, Rest]:
    """The points (p, t, 3) in the instrument's frame without noise, and the arm at rest under `effects`."""
    poses = len(cell.joints)
    growth = np.zeros((poses, arm.count + 1))
    compensator = dict(arm.compensator) if arm.compensator else None
    machine = Machine(arm.mass.copy(), arm.centre.copy(), list(cell.loads), compensator, growth)
    for effect in effects:
        effect.alter(machine, cell)
    bent = Deflection.none(poses, arm.count, machine.growth)
    for _ in range(ROUNDS):
        at = frames(arm, cell.joints, bent, cell.geometry)
        rest = Rest(arm, cell, machine.mass, at, loads(arm, machine, at), bent)
        bent = _stated_deflection(rest, machine.growth)
        for effect in effects:
            effect.deflect(rest, bent)
    rest = replace(rest, frames=frames(arm, cell.joints, bent, cell.geometry), bent=bent)
    targets = np.broadcast_to(cell.targets[None], (poses, *cell.targets.shape)).copy()
    for effect in effects:
        targets += effect.shift_targets(cell, targets)
    points = _on_flange(rest.frames, targets) @ cell.instrument_turn.T + cell.instrument_offset
    for effect in effects:
        points = points + effect.misread(points)
    return points, rest


def points(arm: Arm, cell: Cell, bent: Deflection) -> Array:
    """The points (p, t, 3) in the instrument's frame for a deflection that is known."""
    at = frames(arm, cell.joints, bent, cell.geometry)
    return _on_flange(at, cell.targets) @ cell.instrument_turn.T + cell.instrument_offset
