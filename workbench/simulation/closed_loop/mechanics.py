"""What the simulated robot consists of: springs, gear errors, loads, taken from its model along a path.

Every slot that yields does so about a few hinges and along a few slides: its compliance C is a sum of λ ξ ξᵀ,
so a joint along each ξ with a spring of stiffness 1/λ yields by C · wrench. No constraint, no stiff dummy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...campaign.problem import Problem
from ...correction.conditions import Conditions, path_campaign
from ...correction.extended_arm import extended_arm
from ...correction.paths import Path
from ...effects.acting import Acting
from ...effects.base import Effect
from ...robot.compensator import CompensatorLaw, compensator_law
from ...robot.description import Robot
from ...robot.equilibrium import equilibrium
from ...robot.kinematics import Arm, Array
from ...robot.rigid_plant import arrays
from ...robot.yielding import Law as Law6
from ...robot.yielding import Yielding, own_compliance

NONE = 1e-9  # of a slot's largest: a compliance that is none
RIGID = 1e-10  # rad/(N·m), m/N: what a joint without compliance yields, where it needs a joint at all
TIPS = "what tips over in a bearing follows the loads at rest: what inertia adds does not move it"
TABLE = 8001  # torques at which a law that is not linear is tabulated, closest about
FINEST, FARTHEST = 0.01, 5e5  # N·m, N: as far from each other as there, and up to here


@dataclass(frozen=True)
class Give:
    """How a slot gives way: it turns about `axis` (3,), a unit vector, through `point` (3,) [m] on the slot's
    axes, or it shifts along it. compliance: rad or m per its own torque or force."""

    slot: int
    turns: bool
    axis: Array
    point: Array
    compliance: float


@dataclass(frozen=True, eq=False)
class Law:
    """Axial yield of a joint: linear with `compliance`, or tabulated (`motion`, `torque`) where it is not: as
    far as it rises."""

    compliance: float
    motion: Array | None = None
    torque: Array | None = None

    @property
    def ends(self) -> bool:
        """Whether it rises only so far."""
        return self.torque is not None and len(self.torque) < TABLE

    @property
    def stiffest(self) -> float:
        """Largest slope of the torque [N·m/rad, N/m]."""
        if self.motion is None or self.torque is None:
            return 1 / self.compliance
        return float((np.diff(self.torque) / np.diff(self.motion)).max())


@dataclass(frozen=True, eq=False)
class Mechanics:
    """The simulated robot on a path of N samples: geometry and masses in `arm`, and what moves.

    gives: of all slots; axial: law of each joint, None where it is rigid and its gear without error.
    placed: (N, S, 6) motions that neither a spring nor the drive makes (temperature, drift, what hangs
    on two joints together, a bearing that tips over).
    mass, moment: tool and payload [kg, kg·m, flange frame]; wrench: (N, 6), torque: (N, n) as `Loads` has
    them; stated: mass and moment without what was found of them. gear: the effects of the transmission.
    notes: what had to be assumed.
    """

    robot: Robot
    arm: Arm
    gives: tuple[Give, ...]
    axial: tuple[Law | None, ...]
    placed: Array
    mass: float
    moment: Array
    wrench: Array
    torque: Array
    compensator: CompensatorLaw | None
    gear: Acting
    notes: tuple[str, ...]
    stated: tuple[float, Array]

    def gear_error(self, q: Array, side: Array) -> Array:
        """(K, n) motion of each joint beyond its drive's, at joints q (K, n) reached from `side` (K, n)."""
        return self.gear.gear_error(q, side, self.arm.names)

    @property
    def sided(self) -> bool:
        """Whether a gear's error depends on the side of approach."""
        return "side" in self.gear.uses


def mechanics(robot: Robot, path: Path, q: Array, conditions: Conditions) -> Mechanics:
    """The robot as its model has it, along a path with commanded joints q (N, n)."""
    arm = arrays(robot)
    problem = Problem(robot, arm, path_campaign(robot, path, q, conditions), compensator_law(robot, arm))
    extended = extended_arm(problem)
    here = extended.at(q, np.zeros_like(q), slice(0, len(q)))
    loaded, loads = extended.loads(here)
    gear = extended.acting.those(_of_a_gear)
    others = extended.acting.those(lambda effect: not _of_a_gear(effect))
    yielding = extended.acting.yielding(arm)
    tips = _about_no_axis(arm, yielding)
    placed = others.direct(here)
    erring = {str(effect.where.joint) for effect, _ in gear}
    axial, gives = springs_of(arm, yielding, erring)
    notes = [*extended.notes, *_against(arm, yielding)]
    if tips or any(law is not None and law.ends for law in axial):
        _, _, load = equilibrium(loaded, q, extended.direct(here), loads, yielding.motion)
        for slot, bends in tips:
            placed[:, slot] += bends(load.local[:, slot])[0]
        notes += [*([TIPS] if tips else []), *_beyond(arm, axial, loaded.own(load.local))]
    return Mechanics(
        robot,
        loaded,
        gives,
        axial,
        placed,
        float(loads.mass.mean()),
        loads.moment.mean(axis=0),
        loads.wrench,
        loads.torque,
        loads.compensator,
        gear,
        tuple(notes),
        (float(problem.loads.mass.mean()), problem.loads.moment.mean(axis=0)),
    )


def _against(arm: Arm, yielding: Yielding) -> Iterator[str]:
    """A note on each slot that the model has yield against its load, which no spring does."""
    for slot, C in enumerate(yielding.linear):
        least = min(float(np.linalg.eigvalsh(block)[0]) for block in (C[:3, :3], C[3:, 3:]))
        if least < -NONE * float(np.abs(C).max()):
            yield (
                f"{arm.links[slot]}: the model has a compliance below zero, yielding against its load: the "
                "correction has it, the simulated arm does not"
            )


def _beyond(arm: Arm, axial: Sequence[Law | None], torque: Array) -> Iterator[str]:
    """A note on each joint that a path (torque: (N, n) [N·m, N] at rest) loads beyond where its law rises."""
    for law, name, own in zip(axial, arm.names, torque.T, strict=True):
        if law is None or law.torque is None or not law.ends:
            continue
        if own.min() < law.torque[0] or own.max() > law.torque[-1]:
            at = law.torque[-1] if own.max() > law.torque[-1] else law.torque[0]
            yield (
                f"{name}: beyond {at:.3g} the model's law turns back, which no spring does, and this path "
                f"loads it with up to {own[np.argmax(np.abs(own))]:.2g} (N·m, N): the correction follows the "
                "law, the simulated arm goes on straight"
            )


def _about_no_axis(arm: Arm, yielding: Yielding) -> list[tuple[int, Law6]]:
    """Laws that are not linear and of no joint's own axis, each with its slot: no spring stands for these."""
    own = {slot: (int(column) % 6,) for slot, column in enumerate(arm.axial, start=1)}
    return [(slot, law) for slot, components, law in yielding.bent if components != own.get(slot)]


def _of_a_gear(effect: Effect) -> bool:
    """Whether it is an error of one joint's drive train, which the loop simulates as such. What hangs on two
    joints together has no drive train; it is slow, and follows the command."""
    return effect.acts == "transmission" and effect.axial and effect.by_motor


def _along_axis(law: Law6, component: int) -> Callable[[Array], Array]:
    """A slot's law for a torque (K,) about (or a force along) one of its axes."""

    def axial(torque: Array) -> Array:
        wrench = np.zeros((len(torque), 6))
        wrench[:, component] = torque
        return law(wrench)[0][:, component]

    return axial


def springs_of(
    arm: Arm, yielding: Yielding, erring: set[str]
) -> tuple[tuple[Law | None, ...], tuple[Give, ...]]:
    """The joints' own springs, and how else the slots give way. erring: joints whose gear errs."""
    axial: list[Law | None] = []
    gives: list[Give] = []
    for slot in range(arm.slots):
        C = yielding.linear[slot].copy()
        if 1 <= slot <= arm.n:
            k = int(arm.axial[slot - 1]) % 6
            own = max(own_compliance(C, k), 0.0)
            C[k, k] -= own
            bent = (law for where, components, law in yielding.bent if (where, components) == (slot, (k,)))
            forms = [_along_axis(law, k) for law in bent]
            needed = own > 0 or forms or arm.names[slot - 1] in erring
            axial.append(_law(max(own, RIGID), forms) if needed else None)
        gives += _gives(slot, C)
    return tuple(axial), tuple(gives)


def _law(compliance: float, forms: list[Callable[[Array], Array]]) -> Law:
    """Linear, or a table torque → motion as far as the motion rises with it."""
    if not forms:
        return Law(compliance)
    reach = np.arcsinh(FARTHEST / FINEST)
    torque = FINEST * np.sinh(np.linspace(-reach, reach, TABLE))
    motion = compliance * torque + sum(form(torque) for form in forms)
    middle = TABLE // 2
    rises = np.diff(motion) > 0
    low = middle - int(np.argmin(np.append(rises[:middle][::-1], False)))
    high = middle + int(np.argmin(np.append(rises[middle:], False)))
    return Law(compliance, motion[low : high + 1], torque[low : high + 1])


def _gives(slot: int, C: Array) -> list[Give]:
    """A slot's compliance (6, 6) as hinges and slides.

    Turns about an axis e of the rotational part, with compliance λ, carry the slot along by C_tr e/λ, so
    about a point beside it; what is left of the translational part slides.
    """
    none = NONE * max(float(np.abs(C).max()), 1e-300)
    found: list[Give] = []
    left = C[:3, :3].copy()
    values, axes = np.linalg.eigh(C[3:, 3:])
    for value, axis in zip(values, axes.T, strict=True):
        if value > none:
            along = C[:3, 3:] @ axis / value
            left -= value * np.outer(along, along)
            found.append(Give(slot, True, axis, np.cross(axis, along), float(value)))
    values, axes = np.linalg.eigh(left)
    for value, axis in zip(values, axes.T, strict=True):
        if value > none:
            found.append(Give(slot, False, axis, np.zeros(3), float(value)))
    return sorted(found, key=lambda give: (give.turns, int(np.argmax(np.abs(give.axis)))))
