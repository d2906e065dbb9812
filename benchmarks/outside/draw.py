"""What a case is: robot, poses, loads, instrument, noise, and what is wrong, all by seed and number.

Of a hundred cases 13 are clean, 17 have a fault that `workbench` has no name for, 46 have one fault with a
name and 24 two. All but the clean ones also have a background: small compliances and eccentricities of the
joints and a link's mass, which are scaled for a λ between 2 and 25, and steel's growth where temperatures are
measured. A fault's size is drawn by its λ, 12 to 350, or such that it is 1.5 to 15 times the noise (RMS).
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from arm import Arm, Array, read_arm
from draw_fault import NAMED, NAMELESS, Bench, Drawn, Label, Rng
from faults import Eccentricity, Form, LinkMass, ThermalGrowth, Torsion
from plan import BROUGHT_KG, PAYLOAD_KG, Plan, conditions, noise_of, planned
from statics import Effect, Rest, measured
from strength import Yardstick, yardstick

OFTEN = {"kr500": 1.5, "irb2600like": 1.5, "tx90like": 1.5, "ur16like": 1.5, "sevenlike": 1.5}
OFTEN |= {"kr120": 1.2, "scaralike": 0.4}
LEAST_STRENGTH = 8.0  # λ below which a case is drawn again


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


def possible(arm: Arm, kinds: list[str]) -> bool:
    if "compensator" in kinds and not arm.compensator:
        return False
    if "hose" in kinds and not np.isfinite(arm.stiffness).any():
        return False
    return "coupling" not in kinds or arm.count >= 6


def background_of(arm: Arm, rest: Rest, warms: bool, rng: Rng) -> list[tuple[Form, Label]]:
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


def sized(
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
class Fault:
    """A fault of a size; `white`: its shift as the yardstick has it."""

    form: Form
    white: Array
    record: dict[str, Any]


def to_strength(white: Callable[[float], Array], aim: float, cap: float) -> float:
    """The size, up to a cap, of which a fault has the λ aimed at. white: its shift at a size."""
    size = cap * 0.1
    for _ in range(3):
        found = white(size)
        size = min(size * np.sqrt(aim / max(float(found @ found), 1e-12)), cap)
    return size


def fault_of(
    kind: str, bench: Bench, under: Sequence[Effect], before: Array, scale: Yardstick, rng: Rng
) -> Fault | None:
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

    size = to_strength(white, aim, drawn.cap)
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
    return Fault(form, found, record)


def robot_of(rng: Rng) -> str:
    names = list(PAYLOAD_KG)
    often = np.array([OFTEN.get(name, 1.0) for name in names])
    return str(rng.choice(names, p=often / often.sum()))


def _attempt(number: int, robots: Path, models: Path, rng: Rng) -> Case | None:
    """A case, or none where what was drawn does not go together or is too weak."""
    robot = robot_of(rng)
    arm = read_arm((models if robot in BROUGHT_KG else robots) / robot / f"{robot}.toml")
    sort, kinds = _kind(rng)
    if not possible(arm, kinds):
        return None
    plan = planned(robot, arm, kinds, rng)
    cell = plan.cell
    clean, rest = measured(arm, cell, [])
    scale = yardstick(arm, cell, rest.bent, plan.sigma, plan.repeatability)
    bench = Bench(arm, cell, rest, [payload.name for payload in plan.loading.payloads])
    background: list[tuple[Form, Label]] = []
    if sort != "clean":
        background = background_of(arm, rest, plan.columns["temperatures"] and "thermal" not in kinds, rng)
        background = sized(background, bench, clean, scale, rng)
    under = [effect for effect, _ in background]
    before = measured(arm, cell, under)[0]
    faults: list[Fault] = []
    for kind in kinds:
        fault = fault_of(kind, bench, under, before, scale, rng)
        if fault is None:
            return None
        faults.append(fault)
    noise = noise_of(plan, scale, rng)
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
        **conditions(plan, scale, noise),
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
