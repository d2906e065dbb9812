"""One fault of a kind, drawn for a robot and its poses: its form, the largest fair size, and its names."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from arm import Arm, Array
from faults import (
    Azimuth,
    Backlash,
    BearingTilt,
    Bending,
    Compensator,
    Coupling,
    Drift,
    Eccentricity,
    Form,
    Foundation,
    GearLine,
    GearRatio,
    Hose,
    JointMap,
    LinkMass,
    Payload,
    Product,
    RunOut,
    ShortLeg,
    Slip,
    ThermalGrowth,
    Torsion,
)
from statics import Cell, Rest

Label = tuple[str | float, ...]  # a cause of `workbench`, where it is, and a line's order
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class Bench:
    """What a fault is drawn for; `rest`: the arm without faults."""

    arm: Arm
    cell: Cell
    rest: Rest
    payloads: list[str]

    @property
    def largest(self) -> Array:
        """(n,) torque of each joint, N·m."""
        return np.abs(self.rest.loads.torque).max(0)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A fault: `cap` is its largest fair amplitude; `signs`: those it may have.

    `names`: the labels that are right; `twins`: labels that are as fair; `parts`: labels of parts of the form
    that have a name of their own. A cause without a name has none.
    """

    form: Form
    cap: float
    names: list[Label]
    twins: list[Label]
    parts: list[Label]
    sign: float = 1.0
    either_sign: bool = False

    def of(self, amplitude: float) -> Form:
        return replace(self.form, amplitude=amplitude)


def drawn(
    form: Form,
    cap: float,
    *names: Label,
    twins: tuple[Label, ...] = (),
    parts: tuple[Label, ...] = (),
    sign: float = 1.0,
    either_sign: bool = False,
) -> Drawn:
    return Drawn(form, cap, list(names), list(twins), list(parts), sign, either_sign)


def _phase(rng: Rng) -> float:
    return rng.uniform(0, 2 * np.pi)


def _direction(rng: Rng) -> Array:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _loaded_joint(bench: Bench, rng: Rng) -> int:
    largest = bench.largest
    return int(rng.choice([j for j in range(bench.arm.count) if largest[j] > 0.03 * largest.max()]))


def _turning_joint(bench: Bench, rng: Rng) -> int:
    return int(rng.choice(bench.arm.turning))


def _compliance(law: str) -> Callable[[Bench, Rng], Drawn]:
    def draw(bench: Bench, rng: Rng) -> Drawn:
        arm, joint = bench.arm, _loaded_joint(bench, rng)
        torque, elastic = bench.largest[joint], np.isfinite(arm.stiffness[joint])
        cap = 0.45 * torque / arm.stiffness[joint] if elastic else 1.5e-3
        form = Torsion(joint=joint, law=law, largest=float(torque), shape=float(rng.uniform(0.8, 2)))
        compliance, lost = ("joint_compliance", arm.names[joint]), ("lost_motion", arm.names[joint])
        cap = cap * 0.5 if arm.sliding[joint] else cap
        return drawn(form, cap, compliance, lost, twins=(compliance,), either_sign=bool(elastic))

    return draw


def _lost_motion(bench: Bench, rng: Rng) -> Drawn:
    joint = _loaded_joint(bench, rng)
    largest, shape = float(bench.largest[joint]), float(rng.uniform(0.08, 0.2))
    form = Torsion(joint=joint, law="play", largest=largest, shape=shape)
    name = bench.arm.names[joint]
    cap = 1.5e-4 if bench.arm.sliding[joint] else 3e-4
    return drawn(form, cap, ("lost_motion", name), twins=(("joint_compliance", name),))


def _bending(bench: Bench, rng: Rng) -> Drawn:
    arm, loads = bench.arm, bench.rest.loads
    joint = int(
        rng.choice([j for j in arm.turning if j < arm.count - 1 and arm.lengths[j] > 0.12 * arm.reach])
    )
    moment = np.linalg.norm(loads.moment[:, joint + 1], axis=1).max()
    moment += np.linalg.norm(loads.force[0, joint + 1]) * arm.lengths[joint]
    form = Bending(joint=joint, unit=float(1 / (moment * arm.lengths[joint])))
    return drawn(form, 1.2e-3, ("link_bending", arm.links[joint]))


def _link_mass(bench: Bench, rng: Rng) -> Drawn:
    arm = bench.arm
    joint = int(rng.choice([j for j in range(1, arm.count) if arm.mass[j] > 0.05 * arm.mass.sum()]))
    direction, share = _direction(rng), rng.uniform(0, 1)
    mass = float(rng.choice([-1, 1]) * share)
    centre = (1 - share) * direction * 0.3 * max(arm.lengths[joint], 0.15)
    return drawn(LinkMass(joint=joint, mass=mass, centre=centre), 0.3, ("link_mass", arm.links[joint]))


def _payload(bench: Bench, rng: Rng) -> Drawn:
    number = int(rng.integers(len(bench.payloads)))
    direction, share = _direction(rng), rng.uniform(0, 1)
    mass = float(rng.choice([-1, 1]) * share)
    form = Payload(load=number + 1, mass=mass, centre=(1 - share) * direction * 0.3)
    return drawn(form, 0.3, ("payload", bench.payloads[number]))


def _eccentricity(bench: Bench, rng: Rng) -> Drawn:
    """What the sine at twice the order makes is a line in the gear too."""
    joint, order = _turning_joint(bench, rng), int(rng.choice([1, 1, 2]))
    form = Eccentricity(joint=joint, order=order, phase=_phase(rng), second_phase=_phase(rng))
    name = bench.arm.names[joint]
    lines = (("gear_kinematic_error", name, 2 * order), ("gear_kinematic_error", name, order))
    return drawn(form, 6e-4, ("gear_eccentricity", name), twins=(("joint_map", name),), parts=lines)


def _gear_line(bench: Bench, rng: Rng) -> Drawn:
    joint = _turning_joint(bench, rng)
    ratio, name = bench.arm.gear_ratio[joint], bench.arm.names[joint]
    order = float(2 * ratio if np.isfinite(ratio) and rng.random() < 0.5 else rng.uniform(12, 160))
    form = GearLine(joint=joint, order=order, phase=_phase(rng), second_phase=_phase(rng))
    return drawn(form, 3e-4, ("gear_kinematic_error", name, order))


def _backlash(bench: Bench, rng: Rng) -> Drawn:
    joint, largest = _turning_joint(bench, rng), bench.largest
    form = Backlash(joint=joint, torque=float(0.5 * largest[joint] + 1e-9 + 0.01 * largest.max()))
    return drawn(form, 2.5e-4, ("backlash", bench.arm.names[joint]))


def _compensator(bench: Bench, rng: Rng) -> Drawn:
    """More often a charge that was lost."""
    return drawn(Compensator(), 0.3, ("gravity_compensator",), sign=float(rng.choice([-1, -1, 1])))


def _coupling(bench: Bench, rng: Rng) -> Drawn:
    first, second, third = bench.arm.turning[-3:]
    pairs = [(second, first), (third, first), (third, second), (first, second)]
    joint, other = pairs[int(rng.integers(4))]
    name = ("wrist_coupling", bench.arm.names[joint], bench.arm.names[other])
    return drawn(Coupling(joint=joint, other=other, phase=_phase(rng)), 2e-3, name, either_sign=True)


def _joint_map(bench: Bench, rng: Rng) -> Drawn:
    joint = _turning_joint(bench, rng)
    angle, name = bench.cell.joints[:, joint], bench.arm.names[joint]
    width = float(rng.uniform(0.12, 0.35) * min(np.ptp(angle), 4))
    middles = np.arange(angle.min() - width, angle.max() + width, width)
    form = JointMap(joint=joint, width=width, middles=middles, heights=rng.normal(size=len(middles)))
    twins = (("gear_eccentricity", name), ("gear_kinematic_error", name))
    return drawn(form, 5e-4, ("joint_map", name), twins=twins)


def _foundation(bench: Bench, rng: Rng) -> Drawn:
    rest = bench.rest
    moment = rest.loads.moment[:, 0] + np.cross(rest.frames.origins[0], rest.loads.force[:, 0])
    largest = float(np.linalg.norm(moment[:, :2], axis=1).max())
    return drawn(Foundation(largest=largest, second=float(rng.uniform(0.6, 1.0))), 1e-3, ("foundation",))


def _bearing_tilt(bench: Bench, rng: Rng) -> Drawn:
    joint = int(rng.choice(bench.arm.turning[:-1]))
    moment = np.linalg.norm(bench.rest.loads.moment[:, joint], axis=1).max()
    form = BearingTilt(joint=joint, unit=float(1 / moment), second=float(rng.uniform(0.75, 1.0)))
    return drawn(form, 1e-3, ("bearing_tilt", bench.arm.names[joint]))


def _drift(bench: Bench, rng: Rng) -> Drawn:
    form = Drift(direction=_direction(rng), seconds=float(bench.cell.seconds[-1] * rng.uniform(0.3, 1.5)))
    return drawn(form, 6e-4, ("drift",))


def _thermal(bench: Bench, rng: Rng) -> Drawn:
    weights = rng.uniform(0.8, 1.2, bench.arm.count + 1)
    return drawn(ThermalGrowth(weights=weights), 2.5e-5, ("thermal_growth",))


def _hose(bench: Bench, rng: Rng) -> Drawn | None:
    arm = bench.arm
    elastic = [joint for joint in arm.turning[-3:] if np.isfinite(arm.stiffness[joint])]
    if not elastic or arm.count < 6:
        return None
    joint = int(rng.choice(elastic))
    name = arm.names[joint]
    return drawn(Hose(joint=joint), 6e-4, ("hose_torque", name), twins=(("gear_ratio", name),))


def _gear_ratio(bench: Bench, rng: Rng) -> Drawn:
    joint = _turning_joint(bench, rng)
    name = bench.arm.names[joint]
    twins = (("hose_torque", name),)
    return drawn(GearRatio(joint=joint), 5e-4, ("gear_ratio", name), twins=twins, either_sign=True)


def _product(bench: Bench, rng: Rng) -> Drawn:
    joint, other = (int(one) for one in rng.choice(bench.arm.turning, 2, replace=False))
    phases = {"phase": _phase(rng), "second_phase": _phase(rng)}
    return drawn(Product(joint=joint, other=other, order=float(rng.choice([1, 2])), **phases), 8e-4)


def _short_leg(bench: Bench, rng: Rng) -> Drawn:
    angle = _phase(rng)
    return drawn(ShortLeg(direction=np.array([np.cos(angle), np.sin(angle)])), 2e-3)


def _run_out(bench: Bench, rng: Rng) -> Drawn:
    turning = bench.arm.turning
    joint = int(rng.choice(turning[: max(2, len(turning) - 2)]))
    order = int(rng.choice([2, 3]))
    return drawn(RunOut(joint=joint, order=order, phase=_phase(rng), second_phase=_phase(rng)), 5e-4)


def _azimuth(bench: Bench, rng: Rng) -> Drawn:
    return drawn(Azimuth(order=int(rng.choice([4, 6, 8])), phase=_phase(rng)), 1.5e-4)


def _slip(bench: Bench, rng: Rng) -> Drawn:
    direction, seconds = _direction(rng), bench.cell.seconds
    since = float(seconds[int(len(seconds) * rng.uniform(0.3, 0.7))])
    return drawn(Slip(seconds=since, direction=direction, turn=rng.normal(size=3) * 1.5), 6e-4)


# the order of both is that in which the cases of a seed draw them
NAMED: dict[str, Callable[[Bench, Rng], Drawn | None]] = {
    "hardening": _compliance("hardening"),
    "bilinear": _compliance("bilinear"),
    "cubic": _compliance("cubic"),
    "play": _lost_motion,
    "bending": _bending,
    "link_mass": _link_mass,
    "payload": _payload,
    "eccentricity": _eccentricity,
    "gear_line": _gear_line,
    "backlash": _backlash,
    "compensator": _compensator,
    "coupling": _coupling,
    "joint_map": _joint_map,
    "foundation": _foundation,
    "bearing_tilt": _bearing_tilt,
    "drift": _drift,
    "thermal": _thermal,
    "hose": _hose,
    "gear_ratio": _gear_ratio,
}
NAMELESS: dict[str, Callable[[Bench, Rng], Drawn | None]] = {
    "product": _product,
    "short_leg": _short_leg,
    "run_out": _run_out,
    "azimuth": _azimuth,
    "slip": _slip,
}
