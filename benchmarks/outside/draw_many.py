"""What a robot with many faults is: its campaign, and other poses of it, by seed and number.

Three to seven faults beside the background of `draw.py`, each of 0.05 to 30 times the noise (RMS,
log-uniform, as far as is fair), three targets. λ of a fault is what stands out beside geometry and all other
faults, these in their own shapes and of any size. The other poses are of another day and place of the
instrument: without what goes with time, and with an instrument that does not err.
"""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from arm import Array, read_arm
from draw import Case, background_of, possible, robot_of, sized, to_strength
from draw_fault import NAMED, NAMELESS, Bench, Drawn, Rng
from faults import Azimuth, Drift, Form, Slip
from plan import BROUGHT_KG, conditions, instrument, noise_of, planned, planned_again
from statics import measured
from strength import yardstick

OFTEN = (  # one of these kinds is a fault so often
    (3.0, ("hardening", "bilinear", "cubic")),
    (2.0, ("eccentricity", "joint_map", "gear_line")),
    (1.0, ("bending", "bearing_tilt", "foundation")),
    (1.0, ("payload", "link_mass", "compensator")),
    (1.2, ("play", "backlash", "coupling", "hose", "gear_ratio")),
    (0.8, ("drift", "thermal")),
    (0.5, tuple(NAMELESS)),
)
PASSES = (Azimuth, Drift, Slip)  # no part of the robot on another day


def _kinds(rng: Rng) -> list[str]:
    often = np.array([weight for weight, _ in OFTEN])
    groups = rng.choice(len(OFTEN), int(rng.integers(3, 8)), p=often / often.sum())
    return [str(rng.choice(OFTEN[group][1])) for group in groups]


def _faults(kinds: list[str], bench: Bench, rng: Rng) -> list[tuple[str, Drawn]]:
    """Of these kinds; none that another could be called by, and one without a name at most."""
    found: list[tuple[str, Drawn]] = []
    for kind in kinds:
        one = (NAMED | NAMELESS)[kind](bench, rng)
        had = [label for _, other in found for label in other.names + other.twins]
        if one is None or set(had) & set(one.names + one.twins):
            continue
        if one.names or all(other.names for _, other in found):
            found.append((kind, one))
    return found


def _beyond(own: Array, others: Array) -> float:
    """λ of a white shift (k,) beyond those of others (k, m)."""
    basis, singular, _ = np.linalg.svd(others / np.linalg.norm(others, axis=0), full_matrices=False)
    basis = basis[:, singular > 1e-6 * singular[0]]
    left = own - basis @ (basis.T @ own)
    return float(left @ left)


def _attempt(number: int, robots: Path, models: Path, rng: Rng) -> tuple[Case, Case] | None:
    """A case, and other poses of its robot; None where what was drawn does not go together."""
    robot = robot_of(rng)
    arm = read_arm((models if robot in BROUGHT_KG else robots) / robot / f"{robot}.toml")
    kinds = [kind for kind in _kinds(rng) if possible(arm, [kind])]
    plan = planned(robot, arm, kinds, rng)
    plan = replace(plan, cell=replace(plan.cell, targets=instrument(arm, 3, rng)[2]))
    cell = plan.cell
    clean, rest = measured(arm, cell, [])
    scale = yardstick(arm, cell, rest.bent, plan.sigma, plan.repeatability)
    bench = Bench(arm, cell, rest, [payload.name for payload in plan.loading.payloads])
    labelled = background_of(arm, rest, plan.columns["temperatures"] and "thermal" not in kinds, rng)
    labelled = sized(labelled, bench, clean, scale, rng)
    under = [effect for effect, _ in labelled]
    before = measured(arm, cell, under)[0]
    faults = _faults(kinds, bench, rng)
    if len(faults) < 3:
        return None
    forms: list[Form] = []
    for _, fault in faults:
        sign = fault.sign * (float(rng.choice([-1, 1])) if fault.either_sign else 1.0)

        def white(size: float, fault: Drawn = fault, sign: float = sign) -> Array:
            return scale.white(measured(arm, cell, [*under, fault.of(sign * size)])[0] - before)

        aim = float(np.exp(rng.uniform(np.log(0.05), np.log(30)))) ** 2 * before.size
        forms.append(fault.of(sign * to_strength(white, aim, fault.cap)))
    points = measured(arm, cell, [*under, *forms])[0]
    without = [[*under, *forms[:i], *forms[i + 1 :]] for i in range(len(forms))]
    shifts = np.stack([scale.white(points - measured(arm, cell, some)[0]) for some in without], 1)
    records = [
        {"kind": kind, "names": fault.names, "twins": fault.twins, "parts": fault.parts}
        | {"lambda": round(_beyond(shifts[:, i], np.delete(shifts, i, 1)), 1), "form": asdict(forms[i])}
        for i, (kind, fault) in enumerate(faults)
    ]
    each = [scale.strength(measured(arm, cell, [effect])[0] - clean) for effect in under]
    noise = noise_of(plan, scale, rng)
    truth = {"case": number, "robot": robot, "sort": "many", "faults": records}
    truth["background"] = [
        {"label": label, "lambda": round(strength, 1)}
        for (_, label), strength in zip(labelled, each, strict=True)
    ]
    truth |= conditions(plan, scale, noise)
    stated = np.round(cell.targets * 1e3, 1)
    lasting = [effect for effect in (*under, *forms) if not isinstance(effect, PASSES)]
    other = planned_again(plan, rng, anew=False)
    other = replace(other, columns=plan.columns | {"times": False})
    there, rest = measured(arm, other.cell, lasting)
    again = yardstick(arm, other.cell, rest.bent, plan.sigma, plan.repeatability)
    there = there + noise_of(other, again, rng)
    same = {"case": number, "robot": robot}
    return Case(plan, points + noise, stated, False, truth), Case(other, there, stated, False, same)


def draw_many(seed: int, number: int, robots: Path, models: Path) -> tuple[Case, Case]:
    """The case of a number, and other poses of its robot; `robots`: the folder of `write_robots`."""
    rng = np.random.default_rng([seed, number])
    while True:
        cases = _attempt(number, robots, models, rng)
        if cases is not None:
            return cases
