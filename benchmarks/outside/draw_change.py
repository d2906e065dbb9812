"""What a pair of campaigns is: one robot measured twice, and what came between, by seed and number.

Every pair has the background of `draw.py`, two in five a fault too, the same in both. The second one has its
own poses, instrument's place and noise; in a quarter of them the reflectors are mounted anew. A change has
a λ of 15 to 3000: what it leaves where both campaigns share the robot's geometry, and neither frame nor
targets.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from arm import Arm, read_arm
from draw import Case, background_of, fault_of, robot_of, sized
from draw_fault import NAMED, Bench, Drawn, Label, Rng, drawn
from faults import COLD, BentLink, Compensator, Form, ThermalGrowth, Zero
from plan import BROUGHT_KG, Plan, conditions, noise_of, planned, planned_again
from statics import measured
from strength import strength_of_change, yardstick

KEPT = ("cubic", "eccentricity", "joint_map", "foundation", "bending", "link_mass", "gear_ratio", "gear_line")
LEAST_STRENGTH = 12.0  # λ below which a pair is drawn again


def _zero(bench: Bench, rng: Rng) -> Drawn:
    joint = int(rng.integers(bench.arm.count))
    return drawn(Zero(joint=joint), 5e-3, ("geometry", bench.arm.names[joint]), either_sign=True)


def _bent_link(bench: Bench, rng: Rng) -> Drawn:
    """Turned and shifted as a blow would: both across the link."""
    arm = bench.arm
    joint = int(rng.choice([j for j in range(arm.count - 1) if arm.lengths[j] > 0.12 * arm.reach]))
    way = rng.normal(size=6) * np.repeat([0.3 * arm.lengths[joint], 1.0], 3)
    name = ("geometry", arm.names[joint + 1])
    return drawn(BentLink(joint=joint, way=way), 3e-3, name, twins=(("geometry", arm.names[joint]),))


def _leak(bench: Bench, rng: Rng) -> Drawn:
    return drawn(Compensator(), 0.4, ("gravity_compensator",), sign=-1.0)


CHANGES: dict[str, Callable[[Bench, Rng], Drawn | None]] = {
    "zero": _zero,
    "bent_link": _bent_link,
    "leak": _leak,
    "gearbox": NAMED["eccentricity"],
    "worn_joint": NAMED["hardening"],
    "play": NAMED["play"],
    "backlash": NAMED["backlash"],
    "foundation": NAMED["foundation"],
    "bearing": NAMED["bearing_tilt"],
}
SAME = ("nothing", "nothing", "nothing", "targets", "instrument", "warmer", "warmer_untold")


@dataclass(frozen=True, eq=False)
class Pair:
    before: Case
    after: Case
    truth: dict[str, Any]


def _attempt(number: int, robots: Path, models: Path, rng: Rng) -> Pair | None:
    """A pair, or none where what was drawn does not go together or is too weak."""
    robot = robot_of(rng)
    arm = read_arm((models if robot in BROUGHT_KG else robots) / robot / f"{robot}.toml")
    kind = str(rng.choice(list(CHANGES) if rng.random() < 0.6 else SAME))
    if kind == "leak" and not arm.compensator:
        return None
    first = planned(robot, arm, [{"warmer": "thermal"}.get(kind, kind)], rng)
    first = replace(
        first, noise="stated", cell=replace(first.cell, celsius=np.full(len(first.cell.joints), 20.0))
    )
    second = planned_again(first, rng, anew=kind == "targets" or rng.random() < 0.25)
    if kind == "instrument":
        worse = rng.uniform(1.8, 3.5)
        second = replace(second, sigma=second.sigma * worse, stated_sigma=second.stated_sigma * worse)
    if kind.startswith("warmer"):
        celsius = COLD + rng.uniform(5, 15) + 0.3 * rng.normal(size=len(second.cell.joints))
        second = replace(second, cell=replace(second.cell, celsius=np.round(celsius, 2)))
    columns = first.columns | {"temperatures": kind != "warmer_untold" and first.columns["temperatures"]}
    first, second = replace(first, columns=columns), replace(second, columns=columns)
    clean, rest = measured(arm, first.cell, [])
    scale = yardstick(arm, first.cell, rest.bent, first.sigma, first.repeatability)
    bench = Bench(arm, first.cell, rest, [load.name for load in first.loading.payloads])
    under: list[Form] = []
    for form, _ in sized(background_of(arm, rest, False, rng), bench, clean, scale, rng):
        under.append(form)
    fault = None
    if rng.random() < 0.4:
        start = measured(arm, first.cell, under)[0]
        fault = fault_of(str(rng.choice(KEPT)), bench, under, start, scale, rng)
        under += [fault.form] if fault else []
    if kind.startswith("warmer"):
        under.append(ThermalGrowth(weights=rng.uniform(0.9, 1.1, arm.count + 1), amplitude=1.15e-5))
    truth: dict[str, Any] = {
        "pair": number,
        "robot": robot,
        "kind": kind,
        "changed": kind in CHANGES,
        "names": [],
    }
    after = list(under)
    if kind in CHANGES:
        found = _sized_change(CHANGES[kind](bench, rng), arm, first, second, under, rng)
        if found is None:
            return None
        after.append(found[0])
        truth |= found[1]
    truth["fault"] = fault.record | {"form": type(fault.form).__name__} if fault else None
    truth["remounted"] = not np.array_equal(first.cell.targets, second.cell.targets)
    places = first.cell.targets
    stated = np.round((places + rng.normal(size=places.shape) * 0.002) * 1e3, 1)  # nobody tells of new ones
    cases = []
    for plan, effects in ((first, under), (second, after)):
        own = yardstick(arm, plan.cell, measured(arm, plan.cell, [])[1].bent, plan.sigma, plan.repeatability)
        noise = noise_of(plan, own, rng)
        points = measured(arm, plan.cell, effects)[0] + noise
        said = {"case": number, "robot": robot, **conditions(plan, own, noise)}
        cases.append(Case(plan, points, stated, False, said))
    return Pair(cases[0], cases[1], truth)


def _sized_change(
    change: Drawn | None, arm: Arm, first: Plan, second: Plan, under: list[Form], rng: Rng
) -> tuple[Form, dict[str, Any]] | None:
    """A change of a λ that is drawn, with what is said of it; none where it is too weak."""
    if change is None:
        return None
    aim = float(np.exp(rng.uniform(np.log(15), np.log(3000))))
    sign = change.sign * (float(rng.choice([-1, 1])) if change.either_sign else 1.0)
    before, rest = measured(arm, second.cell, under)
    size, strength, shift = 0.1 * change.cap, 0.0, before
    for _ in range(4):
        shift = measured(arm, second.cell, [*under, change.of(sign * size)])[0] - before
        sigmas = (first.sigma, second.sigma)
        cells = (first.cell, second.cell)
        strength = strength_of_change(arm, cells, rest.bent, sigmas, second.repeatability, shift)
        if size == change.cap or abs(strength / aim - 1) < 0.05:
            break
        size = min(size * np.sqrt(aim / max(strength, 1e-9)), change.cap)
    if strength < LEAST_STRENGTH:
        return None
    labels: dict[str, list[Label]] = {"names": change.names, "twins": change.twins + change.parts}
    moved = 1e3 * float(np.sqrt((shift**2).sum(-1).mean()))
    return change.of(sign * size), {**labels, "lambda": round(strength, 1), "moves_mm": round(moved, 4)}


def draw_pair(seed: int, number: int, robots: Path, models: Path) -> Pair:
    """The pair of a number; `robots`: the folder of `write_robots`."""
    rng = np.random.default_rng([seed, number, 2])
    while True:
        pair = _attempt(number, robots, models, rng)
        if pair is not None:
            return pair
