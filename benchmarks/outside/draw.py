"""What a case is: robot, poses, loads, instrument, noise, and what is wrong, all by seed and number.

Of a hundred cases 13 are clean, 17 have a fault that `workbench` has no name for, 46 have one fault with a
name and 24 two. All but the clean ones also have a background: small compliances and eccentricities of the
joints and a link's mass, which are scaled for a λ between 2 and 25, and steel's growth where temperatures are
measured. A fault's size is drawn by its λ, 12 to 350, or such that it is 1.5 to 15 times the noise (RMS).
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from arm import Arm, Array, read_arm, roll_pitch_yaw, rotation
from draw_fault import NAMED, NAMELESS, Bench, Drawn, Label, Rng
from faults import COLD, Eccentricity, Form, LinkMass, ThermalGrowth, Torsion
from numpy.typing import NDArray
from robots import CHANGED, MADE
from statics import Cell, Deflection, Effect, Rest, frames, measured
from strength import Yardstick, yardstick

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
OFTEN = {"kr500": 1.5, "irb2600like": 1.5, "tx90like": 1.5, "ur16like": 1.5, "sevenlike": 1.5}
OFTEN |= {"kr120": 1.2, "scaralike": 0.4}
LEAST_STRENGTH = 8.0  # λ below which a case is drawn again


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


@dataclass(frozen=True, eq=False)
class Case:
    """`points`: (p, t, 3), m, in the instrument's frame."""

    plan: Plan
    points: Array
    stated_targets_mm: Array
    unknown_targets: bool
    truth: dict[str, Any]


def _kind(rng: Rng) -> tuple[str, list[str]]:
    """What sort of case it is, and the kinds of its faults."""
    share = rng.random()
    if share < 0.13:
        return "clean", []
    if share < 0.30:
        return "unknown", [str(rng.choice(list(NAMELESS)))]
    sort, count = ("single", 1) if share < 0.76 else ("double", 2)
    return sort, [str(kind) for kind in rng.choice(list(NAMED), count, replace=False)]


def _possible(arm: Arm, kinds: list[str]) -> bool:
    if "compensator" in kinds and not arm.compensator:
        return False
    if "hose" in kinds and not np.isfinite(arm.stiffness).any():
        return False
    return "coupling" not in kinds or arm.count >= 6


def _poses(arm: Arm, count: int, wide: bool, rng: Rng) -> Array:
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


def _repeated(joints: Array, rng: Rng) -> Array:
    """With an eighth of the poses three times, in any order."""
    again = rng.choice(len(joints), max(6, len(joints) // 8), replace=False)
    joints = np.vstack([joints, joints[again], joints[again]])
    return joints[rng.permutation(len(joints))]


def _temperatures(seconds: Array, warm: bool, rng: Rng) -> Array:
    """°C (p,): a rise of 4 to 12 K with a time constant and a wave, or hardly any."""
    rise = rng.uniform(4, 12) if warm else rng.uniform(-0.4, 0.4)
    start = COLD + rng.uniform(0, 2) * warm
    celsius = start + rise * (1 - np.exp(-seconds / (seconds[-1] * rng.uniform(0.2, 0.6))))
    if warm:
        celsius = celsius + 1.5 * np.sin(seconds / seconds[-1] * 7 + rng.uniform(0, 6))
    return np.round(celsius, 2)


def _directions(joints: Array, rng: Rng) -> Array:
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


def _on_flange(loading: Loading, poses: int) -> list[tuple[Array, Array]]:
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


def _background(arm: Arm, rest: Rest, warms: bool, rng: Rng) -> list[tuple[Form, Label]]:
    """Small effects that every machine has, with their labels and sizes relative to each other."""
    largest = np.abs(rest.loads.torque).max(0)
    found: list[tuple[Form, Label]] = []
    for joint, name in enumerate(arm.names):
        if largest[joint] > 1e-3 * largest.max():
            size = float(rng.lognormal(0, 0.6)) * 1e-5
            sign = rng.choice([-1, 1]) if np.isfinite(arm.stiffness[joint]) else 1
            torque = float(largest[joint])
            law = Torsion(joint=joint, law="linear", largest=torque, amplitude=float(size * sign))
            found.append((law, ("joint_compliance", name)))
        if not arm.sliding[joint]:
            order = int(rng.choice([1, 2]))
            phases = {"phase": rng.uniform(0, 6.3), "second_phase": rng.uniform(0, 6.3)}
            size = float(rng.lognormal(0, 0.6)) * 0.5e-5
            sine = Eccentricity(joint=joint, order=order, amplitude=size, **phases)
            found.append((sine, ("gear_eccentricity", name)))
    link = int(rng.integers(1, arm.count)) if arm.mass[1:].max() > 0 else None
    if link and np.isfinite(arm.stiffness).any():
        off = LinkMass(joint=link, mass=1.0, centre=np.zeros(3), amplitude=float(rng.normal() * 0.02))
        found.append((off, ("link_mass", arm.links[link])))
    if warms:
        found.append((ThermalGrowth(weights=np.ones(arm.count + 1), amplitude=1.15e-5), ("thermal_growth",)))
    return found


def _sized(
    effects: list[tuple[Form, Label]], bench: Bench, clean: Array, scale: Yardstick, rng: Rng
) -> list[tuple[Form, Label]]:
    """All but the growth times one number, by which their λ together is between 2 and 25."""
    wanted = np.exp(rng.uniform(np.log(2), np.log(25)))
    together = measured(bench.arm, bench.cell, [effect for effect, _ in effects])[0] - clean
    by = np.sqrt(wanted / max(scale.strength(together), 1e-9))
    return [
        (effect, label)
        if isinstance(effect, ThermalGrowth)
        else (replace(effect, amplitude=effect.amplitude * by), label)
        for effect, label in effects
    ]


@dataclass(frozen=True, eq=False)
class _Fault:
    """A fault of a size; `white`: its shift as the yardstick has it."""

    form: Form
    white: Array
    record: dict[str, Any]


def _fault(
    kind: str, bench: Bench, under: Sequence[Effect], before: Array, scale: Yardstick, rng: Rng
) -> _Fault | None:
    """Of a λ that is drawn, or none where it is too weak even at its largest fair size.

    `under`: the background, and `before` the points (p, t, 3) with it alone.
    """
    drawn: Drawn | None = (NAMED | NAMELESS)[kind](bench, rng)
    if drawn is None:
        return None
    numbers = before.size
    if rng.random() < 0.45:
        aim = float(np.exp(rng.uniform(np.log(12), np.log(350))))
    else:
        aim = float(np.exp(rng.uniform(np.log(1.5), np.log(15)))) ** 2 * numbers
    sign = drawn.sign * (float(rng.choice([-1, 1])) if drawn.either_sign else 1.0)

    def white(size: float) -> Array:
        shifted = measured(bench.arm, bench.cell, [*under, drawn.of(sign * size)])[0]
        return scale.white(shifted - before)

    size = drawn.cap * 0.1
    for _ in range(3):
        found = white(size)
        size = min(size * np.sqrt(aim / max(float(found @ found), 1e-12)), drawn.cap)
    found = white(size)
    strength = float(found @ found)
    if strength < LEAST_STRENGTH:
        return None
    form = drawn.of(sign * size)
    record = {
        "kind": kind,
        "names": drawn.names,
        "twins": drawn.twins,
        "parts": drawn.parts,
        "capped": bool(size >= drawn.cap * 0.999),
        "lambda": round(strength, 1),
        "rms_over_noise": round(float(np.sqrt(strength / numbers)), 3),
        "form": asdict(form),
    }
    return _Fault(form, found, record)


def _instrument(arm: Arm, targets: int, rng: Rng) -> tuple[float, Array, Array]:
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


def _instrument_place(arm: Arm, rng: Rng) -> tuple[Array, Array]:
    """Rotation (3, 3) and offset (3,) of the robot's base in the instrument's frame."""
    yaw = rng.uniform(0, 2 * np.pi)
    turn = rotation(rng.normal(size=3) * 0.01) @ roll_pitch_yaw(0, 0, yaw)
    distance, angle = arm.reach * rng.uniform(1.6, 2.6), rng.uniform(0, 6.3)
    offset = np.array([distance * np.cos(angle), distance * np.sin(angle), rng.uniform(-1, 0.5)])
    return turn, offset


def _plan(robot: str, arm: Arm, kinds: list[str], rng: Rng) -> Plan:
    """Where faults of these kinds can be seen."""
    count, targets = int(rng.integers(40, 121)), int(rng.integers(1, 4))
    wide = bool(rng.random() < 0.6)
    joints = _poses(arm, count, wide, rng)
    share = rng.random()
    noise = "stated" if share < 0.65 else "columns" if share < 0.75 else "repeats"
    if noise == "repeats":
        joints = _repeated(joints, rng)
    count, warm = len(joints), "thermal" in kinds
    columns = {
        "directions": bool(rng.random() < 0.4 or "backlash" in kinds),
        "times": bool(rng.random() < 0.5 or {"drift", "slip"} & set(kinds)),
        "temperatures": bool(rng.random() < 0.25 or warm),
    }
    seconds = np.cumsum(rng.uniform(20, 60, count))
    seconds -= seconds[0]
    celsius = _temperatures(seconds, warm, rng)
    directions = _directions(joints, rng)
    loading = _loading(arm, PAYLOAD_KG[robot], "payload" in kinds, count, rng)
    stated, sigma, places = _instrument(arm, targets, rng)
    geometry, scatter = _true_geometry(arm, rng)
    turn, offset = _instrument_place(arm, rng)
    carried = _on_flange(loading, count)
    cell = Cell(joints, seconds, celsius, directions, carried, places, geometry, turn, offset)
    repeatability = _repeatability(arm, rng)
    return Plan(arm, cell, loading, sigma, stated, repeatability, noise, columns, wide, scatter)


def _noise(plan: Plan, scale: Yardstick, rng: Rng) -> Array:
    """(p, t, 3), m: of the joints, which do not come back to the same angle, and of the instrument."""
    shape = (len(plan.cell.joints), len(plan.cell.targets), 3)
    joints = rng.normal(size=plan.cell.joints.shape) * plan.repeatability
    scatter = np.einsum("pij,pj->pi", scale.joints, joints).reshape(shape)
    return scatter + rng.normal(size=shape) * plan.sigma


def _conditions(plan: Plan, scale: Yardstick, noise: Array) -> dict[str, Any]:
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


def _attempt(number: int, robots: Path, models: Path, rng: Rng) -> Case | None:
    """A case, or none where what was drawn does not go together or is too weak."""
    names = list(PAYLOAD_KG)
    often = np.array([OFTEN.get(name, 1.0) for name in names])
    robot = str(rng.choice(names, p=often / often.sum()))
    arm = read_arm((models if robot in BROUGHT_KG else robots) / robot / f"{robot}.toml")
    sort, kinds = _kind(rng)
    if not _possible(arm, kinds):
        return None
    plan = _plan(robot, arm, kinds, rng)
    cell = plan.cell
    clean, rest = measured(arm, cell, [])
    scale = yardstick(arm, cell, rest.bent, plan.sigma, plan.repeatability)
    bench = Bench(arm, cell, rest, [payload.name for payload in plan.loading.payloads])
    background: list[tuple[Form, Label]] = []
    if sort != "clean":
        background = _background(arm, rest, plan.columns["temperatures"] and "thermal" not in kinds, rng)
        background = _sized(background, bench, clean, scale, rng)
    under = [effect for effect, _ in background]
    before = measured(arm, cell, under)[0]
    faults: list[_Fault] = []
    for kind in kinds:
        fault = _fault(kind, bench, under, before, scale, rng)
        if fault is None:
            return None
        faults.append(fault)
    noise = _noise(plan, scale, rng)
    truth = {
        "case": number,
        "robot": robot,
        "sort": sort,
        "faults": [fault.record for fault in faults],
        "background": [
            {"label": label, "lambda": round(scale.strength(measured(arm, cell, [effect])[0] - clean), 1)}
            for effect, label in background
        ],
        "background_lambda": round(scale.strength(before - clean), 1),
        **_conditions(plan, scale, noise),
    }
    if len(faults) == 2:
        one, other = (fault.white / np.linalg.norm(fault.white) for fault in faults)
        truth["cosine"] = round(float(one @ other), 3)
    points = measured(arm, cell, [*under, *(fault.form for fault in faults)])[0] + noise
    stated_targets = np.round((cell.targets + rng.normal(size=cell.targets.shape) * 0.002) * 1e3, 1)
    return Case(plan, points, stated_targets, bool(rng.random() < 0.2), truth)


def draw(seed: int, number: int, robots: Path, models: Path) -> Case:
    """The case of a number; `robots`: the folder of `write_robots`."""
    rng = np.random.default_rng([seed, number])
    while True:
        case = _attempt(number, robots, models, rng)
        if case is not None:
            return case
