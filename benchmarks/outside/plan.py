"""What is measured: robot, poses, loads, instrument, noise and what the campaign tells of them."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from arm import Arm, Array, roll_pitch_yaw, rotation
from draw_fault import Rng
from faults import COLD
from numpy.typing import NDArray
from robots import CHANGED, MADE
from statics import Cell, Deflection, frames
from strength import Yardstick

BROUGHT_KG = {  # the models of the project, with the payload that each may carry
    "kr500": 250.0,
    "kr120": 100.0,
    "rx170": 25.0,
    "ur5": 4.0,
    "ur10": 8.0,
    "irb120": 2.5,
    "lrmate200id": 6.0,
    "iiwa7": 6.0,
    "longlink": 15.0,
    "ma1400-left": 5.0,
}
PAYLOAD_KG = BROUGHT_KG | {robot.name: robot.payload for robot in (*MADE, *CHANGED)}


@dataclass(frozen=True, eq=False)
class Payload:
    """In kg and m."""

    name: str
    mass: float
    centre: Array


@dataclass(frozen=True, eq=False)
class Loading:
    """A tool, always there, and the payloads; `which`: (p,) number of the payload, beyond the last: none."""

    tool: Payload
    payloads: list[Payload]
    which: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Plan:
    """What is measured. `sigma`: (3,) of the instrument, `stated_sigma`: what its maker says, m;
    `repeatability`: (n,) of the joints; `noise`: stated, columns or repeats, which the campaign tells it by;
    `columns`: which of directions, times and temperatures its tables hold; `wide`: poses all over the range.
    """

    arm: Arm
    cell: Cell
    loading: Loading
    sigma: Array
    stated_sigma: float
    repeatability: Array
    noise: str
    columns: dict[str, bool]
    wide: bool
    geometry: dict[str, float]


def poses_of(arm: Arm, count: int, wide: bool, rng: Rng) -> Array:
    """Joint positions over the whole range or half of it, above the floor and not close to the column."""
    share = 0.95 if wide else 0.5
    lower, upper = np.maximum(arm.lower, -3.05), np.minimum(arm.upper, 3.05)
    aside = rng.uniform(-0.2, 0.2, arm.count)
    middle = (lower + upper) / 2 + (0 if wide else 1) * aside * (upper - lower) / 2
    found: list[Array] = []
    while len(found) < count:
        joints = middle + share * (upper - lower) / 2 * rng.uniform(-1, 1, (400, arm.count))
        at = frames(arm, joints, Deflection.none(400, arm.count), np.zeros((arm.count, 6)))
        flange = at.flange_origin
        floor = -0.02 + min(0, at.link_origins[0][:, 2].min())
        above = (flange[:, 2] > 0.05 * arm.reach) & np.all([o[:, 2] > floor for o in at.link_origins], axis=0)
        fits = above & (np.hypot(flange[:, 0], flange[:, 1]) > 0.2 * arm.reach)
        found += list(joints[fits])
        if not fits.any():
            middle = (lower + upper) / 2 + rng.uniform(-0.3, 0.3, arm.count) * (upper - lower) / 2
            share = 0.6
    return np.round(np.array(found[:count]), 6)


def repeated(joints: Array, rng: Rng) -> Array:
    """With an eighth of the poses three times, in any order."""
    again = rng.choice(len(joints), max(6, len(joints) // 8), replace=False)
    joints = np.vstack([joints, joints[again], joints[again]])
    return joints[rng.permutation(len(joints))]


def temperatures(seconds: Array, warm: bool, rng: Rng) -> Array:
    """°C (p,): a rise of 4 to 12 K with a time constant and a wave, or hardly any."""
    rise = rng.uniform(4, 12) if warm else rng.uniform(-0.4, 0.4)
    start = COLD + rng.uniform(0, 2) * warm
    celsius = start + rise * (1 - np.exp(-seconds / (seconds[-1] * rng.uniform(0.2, 0.6))))
    if warm:
        celsius = celsius + 1.5 * np.sin(seconds / seconds[-1] * 7 + rng.uniform(0, 6))
    return np.round(celsius, 2)


def directions_of(joints: Array, rng: Rng) -> Array:
    """±1 (p, n): the way each joint last moved."""
    before = joints[:1] + rng.choice([-1, 1], joints.shape[1]) * 0.1
    directions = np.sign(np.diff(joints, axis=0, prepend=before))
    for pose in range(1, len(joints)):
        directions[pose] = np.where(directions[pose] == 0, directions[pose - 1], directions[pose])
    return directions


def _loading(arm: Arm, largest: float, needed: bool, poses: int, rng: Rng) -> Loading:
    count = int(rng.choice([0, 1, 2], p=[0.4, 0.4, 0.2]))
    count = 1 if needed and not count else count
    payloads = []
    for name, low, high in (("heavy", 0.6, 1), ("light", 0.2, 0.4))[:count]:
        mass = round(float(largest * rng.uniform(low, high)), 2)
        centre = rng.normal(size=3) * 0.03 * arm.reach / 1.5 + [0, 0, 0.04 * arm.reach]
        payloads.append(Payload(name, mass, np.round(centre, 4)))
    which = np.zeros(poses, int)
    if count:
        which = rng.integers(0, count + (1 if rng.random() < 0.7 else 0), poses)
    mass = round(float(largest * rng.uniform(0.02, 0.1)), 2)
    return Loading(Payload("tool", mass, np.round([0, 0, 0.03 * arm.reach], 4)), payloads, which)


def on_flange(loading: Loading, poses: int) -> list[tuple[Array, Array]]:
    """Mass (p,) and centre (3,) of the tool and each payload."""
    tool = (np.full(poses, loading.tool.mass), loading.tool.centre)
    return [tool, *((one.mass * (loading.which == i), one.centre) for i, one in enumerate(loading.payloads))]


def _repeatability(arm: Arm, rng: Rng) -> Array:
    """(n,), rad (sliding: m): the file's, or such that the flange scatters by some 0.01 mm."""
    each = arm.repeatability
    if not np.isfinite(each).all():
        turning = rng.uniform(5, 14) * 1e-6 / arm.reach * np.linspace(1, 2.5, arm.count)
        each = np.where(arm.sliding, 5e-6, turning)
    return each * rng.uniform(0.6, 1.3)


def instrument(arm: Arm, targets: int, rng: Rng) -> tuple[float, Array, Array]:
    """What its maker says of its noise, the noise (3,) of its axes, m, and the targets' places (t, 3)."""
    stated = float(rng.uniform(0.008, 0.025) if arm.reach < 1.8 else rng.uniform(0.015, 0.045)) * 1e-3
    uneven = rng.uniform(0.6, 1.4, 3)
    uneven /= np.sqrt(np.mean(uneven**2))
    places = rng.uniform(-1, 1, (targets, 3)) * 0.1 * arm.reach**0.5
    places[:, 2] = rng.uniform(0.02, 0.15, targets) * arm.reach**0.5
    return stated, stated * uneven, places


def _true_geometry(arm: Arm, rng: Rng) -> tuple[Array, dict[str, float]]:
    """(n, 6) offsets and turns, m and rad, and by how much they scatter: up to 1 mm and 1 mrad."""
    offset = 10 ** rng.uniform(np.log10(0.05), 0) * 1e-3 * min(1, arm.reach)
    turn = 10 ** rng.uniform(np.log10(0.1), np.log10(2)) * 1e-3 * 0.5
    parts = [rng.normal(size=(arm.count, 3)) * offset, rng.normal(size=(arm.count, 3)) * turn]
    said = {"geometry_mm": round(offset * 1e3, 3), "geometry_mrad": round(turn * 1e3, 3)}
    return np.concatenate(parts, 1), said


def instrument_place(arm: Arm, rng: Rng) -> tuple[Array, Array]:
    """Rotation (3, 3) and offset (3,) of the robot's base in the instrument's frame."""
    yaw = rng.uniform(0, 2 * np.pi)
    turn = rotation(rng.normal(size=3) * 0.01) @ roll_pitch_yaw(0, 0, yaw)
    distance, angle = arm.reach * rng.uniform(1.6, 2.6), rng.uniform(0, 6.3)
    offset = np.array([distance * np.cos(angle), distance * np.sin(angle), rng.uniform(-1, 0.5)])
    return turn, offset


def planned(robot: str, arm: Arm, kinds: list[str], rng: Rng) -> Plan:
    """Where faults of these kinds can be seen."""
    count, targets = int(rng.integers(40, 121)), int(rng.integers(1, 4))
    wide = bool(rng.random() < 0.6)
    joints = poses_of(arm, count, wide, rng)
    share = rng.random()
    noise = "stated" if share < 0.65 else "columns" if share < 0.75 else "repeats"
    if noise == "repeats":
        joints = repeated(joints, rng)
    count, warm = len(joints), "thermal" in kinds
    columns = {
        "directions": bool(rng.random() < 0.4 or "backlash" in kinds),
        "times": bool(rng.random() < 0.5 or {"drift", "slip"} & set(kinds)),
        "temperatures": bool(rng.random() < 0.25 or warm),
    }
    seconds = np.cumsum(rng.uniform(20, 60, count))
    seconds -= seconds[0]
    celsius = temperatures(seconds, warm, rng)
    directions = directions_of(joints, rng)
    loading = _loading(arm, PAYLOAD_KG[robot], "payload" in kinds, count, rng)
    stated, sigma, places = instrument(arm, targets, rng)
    geometry, scatter = _true_geometry(arm, rng)
    turn, offset = instrument_place(arm, rng)
    carried = on_flange(loading, count)
    cell = Cell(joints, seconds, celsius, directions, carried, places, geometry, turn, offset)
    repeatability = _repeatability(arm, rng)
    return Plan(arm, cell, loading, sigma, stated, repeatability, noise, columns, wide, scatter)


def noise_of(plan: Plan, scale: Yardstick, rng: Rng) -> Array:
    """(p, t, 3), m: of the joints, which do not come back to the same angle, and of the instrument."""
    shape = (len(plan.cell.joints), len(plan.cell.targets), 3)
    joints = rng.normal(size=plan.cell.joints.shape) * plan.repeatability
    scatter = np.einsum("pij,pj->pi", scale.joints, joints).reshape(shape)
    return scatter + rng.normal(size=shape) * plan.sigma


def conditions(plan: Plan, scale: Yardstick, noise: Array) -> dict[str, Any]:
    """What truth.json says of the plan."""
    each = np.einsum("pij,j->pi", scale.joints**2, plan.repeatability**2)
    return {
        "poses": len(plan.cell.joints),
        "targets": len(plan.cell.targets),
        "payloads": len(plan.loading.payloads),
        "wide": plan.wide,
        "noise": plan.noise,
        "sigma_um": round(plan.stated_sigma * 1e6, 1),
        "repeatability_um": round(1e6 * float(np.sqrt(np.mean(each))), 1),
        "columns": plan.columns,
        "noise_chi2": round(scale.strength(noise) / (noise.size - scale.taken.shape[1]), 3),
        **plan.geometry,
    }


def planned_again(plan: Plan, rng: Rng, anew: bool) -> Plan:
    """The same robot with the same loads on another day: other poses, another place of the instrument. anew:
    its targets are mounted anew, somewhere near."""
    arm, cell = plan.arm, plan.cell
    count = int(rng.integers(40, 121))
    joints = poses_of(arm, count, plan.wide, rng)
    seconds = np.cumsum(rng.uniform(20, 60, count))
    turn, offset = instrument_place(arm, rng)
    which = np.zeros(count, int)
    if plan.loading.payloads:
        which = rng.integers(0, int(plan.loading.which.max()) + 1, count)
    loading = replace(plan.loading, which=which)
    targets = cell.targets
    if anew:
        targets = targets @ rotation(rng.normal(size=3) * 0.02).T + rng.normal(size=3) * 0.003
    directions, celsius = directions_of(joints, rng), np.full(count, COLD)
    carried = on_flange(loading, count)
    other = Cell(
        joints, seconds - seconds[0], celsius, directions, carried, targets, cell.geometry, turn, offset
    )
    return replace(plan, cell=other, loading=loading)
