"""The forms of the faults: each is a textbook cause that is a little off its formula, as a machine would be.

`amplitude` is in rad where a joint turns (sliding: m), in m where something moves, else without unit; what
else a form holds is its shape. The last five are causes for which `workbench` has no name.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from arm import Array
from statics import Cell, Deflection, Effect, Machine, Rest, bending, tilting

COLD = 20.0  # °C at which a robot has its nominal lengths


def _hardening(load: Array, shape: float) -> Array:
    return load * (1 + shape) / (1 + shape * np.abs(load))


def _bilinear(load: Array, shape: float) -> Array:
    """Soft up to 0.3 of the largest torque, stiff beyond."""
    soft, stiff = np.minimum(np.abs(load), 0.3), np.maximum(np.abs(load) - 0.3, 0)
    return np.sign(load) * (soft * 2.2 + stiff * 0.5) / (0.66 + 0.35)


def _cubic(load: Array, shape: float) -> Array:
    return 0.65 * load + 0.35 * load**3


def _play(load: Array, shape: float) -> Array:
    return np.tanh(load / shape)


def _linear(load: Array, shape: float) -> Array:
    return load


LAWS: dict[str, Callable[[Array, float], Array]] = {
    "hardening": _hardening,
    "bilinear": _bilinear,
    "cubic": _cubic,
    "play": _play,
    "linear": _linear,
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Form(Effect):
    amplitude: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Torsion(Form):
    """A joint gives way to its torque, over the `largest` one, by a law that is not the model's."""

    joint: int
    law: str
    largest: float
    shape: float = 1.0

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        load = rest.loads.torque[:, self.joint] / self.largest
        bent.joints[:, self.joint] += self.amplitude * LAWS[self.law](load, self.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class Bending(Form):
    """A link bends; `unit`, 1/(N·m²), makes the amplitude about the turn at its end."""

    joint: int
    unit: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        bent.bend[:, self.joint] += bending(rest, self.joint, self.amplitude * self.unit)


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkMass(Form):
    """Mass (share) and centre (m) of a link are off."""

    joint: int
    mass: float
    centre: Array

    def alter(self, machine: Machine, cell: Cell) -> None:
        machine.mass[self.joint] *= 1 + self.amplitude * self.mass
        machine.centre[self.joint] = machine.centre[self.joint] + self.amplitude * self.centre


@dataclass(frozen=True, kw_only=True, eq=False)
class Payload(Form):
    """Mass (share) and centre (m) of a payload are off; `load`: its number on the flange."""

    load: int
    mass: float
    centre: Array

    def alter(self, machine: Machine, cell: Cell) -> None:
        mass, centre = machine.loads[self.load]
        changed = (mass * (1 + self.amplitude * self.mass), centre + self.amplitude * self.centre)
        machine.loads[self.load] = changed


@dataclass(frozen=True, kw_only=True, eq=False)
class Compensator(Form):
    """Charge and length of the gas are off, the exponent by 0.02; or rate and free length of the spring."""

    def alter(self, machine: Machine, cell: Cell) -> None:
        said = machine.compensator
        if said["kind"] == "gas":
            said["precharge"] *= 1 + self.amplitude
            said["gas_length"] *= 1 + 0.15 * self.amplitude
            said["exponent"] = said.get("exponent", 1.0) + 0.02
        else:
            said["rate"] *= 1 + self.amplitude
            said["free_length"] += 0.003 * self.amplitude / 0.1


@dataclass(frozen=True, kw_only=True, eq=False)
class Eccentricity(Form):
    """A sine of `order` periods a turn, with a fifth of it at twice the order."""

    joint: int
    order: int
    phase: float
    second_phase: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle = rest.cell.joints[:, self.joint]
        sines = np.sin(self.order * angle + self.phase) + 0.2 * np.sin(
            2 * self.order * angle + self.second_phase
        )
        bent.joints[:, self.joint] += self.amplitude * sines


@dataclass(frozen=True, kw_only=True, eq=False)
class GearLine(Form):
    """A line of the gear's error, of many periods a turn, that is stronger on one side of the turn."""

    joint: int
    order: float
    phase: float
    second_phase: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle = rest.cell.joints[:, self.joint]
        strength = self.amplitude * (1 + 0.3 * np.sin(angle + self.second_phase))
        bent.joints[:, self.joint] += strength * np.sin(self.order * angle + self.phase)


@dataclass(frozen=True, kw_only=True, eq=False)
class Backlash(Form):
    """A joint stays behind on the side it came from, by a quarter less under a torque above `torque`."""

    joint: int
    torque: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        free = 0.75 + 0.25 * np.exp(-((rest.loads.torque[:, self.joint] / self.torque) ** 2))
        bent.joints[:, self.joint] += -self.amplitude * rest.cell.directions[:, self.joint] * free


@dataclass(frozen=True, kw_only=True, eq=False)
class Coupling(Form):
    """A joint goes along with another, not quite evenly."""

    joint: int
    other: int
    phase: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle = rest.cell.joints[:, self.other]
        bent.joints[:, self.joint] += self.amplitude * (angle + 0.1 * np.sin(2 * angle + self.phase))


@dataclass(frozen=True, kw_only=True, eq=False)
class JointMap(Form):
    """A smooth curve over the joint's angle: bells of a `width` at `middles`."""

    joint: int
    width: float
    middles: Array
    heights: Array

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle = rest.cell.joints[:, self.joint]
        bells = sum(
            height * np.exp(-0.5 * ((angle - middle) / self.width) ** 2)
            for middle, height in zip(self.middles, self.heights, strict=True)
        )
        bent.joints[:, self.joint] += self.amplitude * bells


@dataclass(frozen=True, kw_only=True, eq=False)
class Foundation(Form):
    """The base gives way to the moment on it, over the `largest` (N·m), softer for small ones, in x and y."""

    largest: float
    second: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        at, load = rest.frames, rest.loads
        moment = load.moment[:, 0] + np.cross(at.origins[0], load.force[:, 0])
        share = np.linalg.norm(moment[:, :2], axis=1) / self.largest
        compliance = self.amplitude / self.largest * (1.15 - 0.15 * share)
        bent.base[:, 3] += compliance * moment[:, 0]
        bent.base[:, 4] += compliance * self.second * moment[:, 1]


@dataclass(frozen=True, kw_only=True, eq=False)
class BearingTilt(Form):
    """A bearing tilts, less in one direction; `unit`, 1/(N·m), makes the amplitude about the largest turn."""

    joint: int
    unit: float
    second: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        compliance = self.amplitude * self.unit
        bent.tilt[:, self.joint] += tilting(rest, self.joint, compliance, compliance * self.second)


@dataclass(frozen=True, kw_only=True, eq=False)
class Drift(Form):
    """The base creeps in a direction, with a time constant in s."""

    direction: Array
    seconds: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        crept = 1 - np.exp(-rest.cell.seconds / self.seconds)
        bent.base[:, :3] += self.amplitude * np.outer(crept, self.direction)


@dataclass(frozen=True, kw_only=True, eq=False)
class ThermalGrowth(Form):
    """Each offset grows with the temperature, 1/K, by weights (n + 1,)."""

    weights: Array

    def alter(self, machine: Machine, cell: Cell) -> None:
        machine.growth += self.amplitude * (cell.celsius - COLD)[:, None] * self.weights[None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Hose(Form):
    """A dress pack pulls an elastic joint back to zero, a little harder far out."""

    joint: int

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle = rest.cell.joints[:, self.joint]
        bent.joints[:, self.joint] += -self.amplitude * (angle + 0.1 * angle**3 / np.pi**2)


@dataclass(frozen=True, kw_only=True, eq=False)
class GearRatio(Form):
    """A joint turns too far, a little unevenly."""

    joint: int

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle = rest.cell.joints[:, self.joint]
        bent.joints[:, self.joint] += self.amplitude * (angle + 0.08 * angle**2 / np.pi)


@dataclass(frozen=True, kw_only=True, eq=False)
class Product(Form):
    """No name: a joint's error by the sines of two joints, multiplied."""

    joint: int
    other: int
    order: float
    phase: float
    second_phase: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle, second = rest.cell.joints[:, self.joint], rest.cell.joints[:, self.other]
        both = self.amplitude * np.sin(angle + self.phase) * np.sin(self.order * second + self.second_phase)
        bent.joints[:, self.joint] += both


@dataclass(frozen=True, kw_only=True, eq=False)
class ShortLeg(Form):
    """No name: the base tips when the flange reaches far out in one direction, as over a short leg."""

    direction: Array

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        out = (rest.frames.flange_origin[:, :2] @ self.direction) / rest.arm.reach
        across = [-self.direction[1], self.direction[0]]
        bent.base[:, 3:5] += self.amplitude * np.outer(np.maximum(out - 0.15, 0), across)


@dataclass(frozen=True, kw_only=True, eq=False)
class RunOut(Form):
    """No name: the axis wobbles `order` times a turn."""

    joint: int
    order: int
    phase: float
    second_phase: float

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        angle, axis = rest.cell.joints[:, self.joint], rest.arm.axes[self.joint]
        first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        first /= np.linalg.norm(first)
        second = np.cross(axis, first)
        one = np.outer(np.sin(self.order * angle + self.phase), first)
        other = np.outer(0.7 * np.sin(self.order * angle + self.second_phase), second)
        bent.tilt[:, self.joint] += self.amplitude * (one + other)


@dataclass(frozen=True, kw_only=True, eq=False)
class Azimuth(Form):
    """No name: the instrument's horizontal angle is off by a sine of `order` periods a turn."""

    order: int
    phase: float

    def misread(self, points: Array) -> Array:
        azimuth, radius = np.arctan2(points[..., 1], points[..., 0]), np.hypot(points[..., 0], points[..., 1])
        across = self.amplitude * radius * np.sin(self.order * azimuth + self.phase)
        return np.stack([-np.sin(azimuth) * across, np.cos(azimuth) * across, 0 * across], -1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Slip(Form):
    """No name: from a moment on, s, the plate with all targets has slipped on the flange and turned (1/m)."""

    seconds: float
    direction: Array
    turn: Array

    def shift_targets(self, cell: Cell, targets: Array) -> Array:
        since = (cell.seconds >= self.seconds).astype(float)
        slipped = self.direction[None, None] + np.cross(self.turn, cell.targets)[None]
        return self.amplitude * since[:, None, None] * slipped


@dataclass(frozen=True, kw_only=True, eq=False)
class Zero(Form):
    """A joint's encoder has lost its zero."""

    joint: int

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        bent.joints[:, self.joint] += self.amplitude


@dataclass(frozen=True, kw_only=True, eq=False)
class BentLink(Form):
    """A joint's link is bent for good: its end is shifted and turned by `way` (6,)."""

    joint: int
    way: Array

    def deflect(self, rest: Rest, bent: Deflection) -> None:
        bent.bend[:, self.joint] += self.amplitude * self.way
