"""Hidden causes that are loads, or yield to them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...campaign.problem import Problem
from ...effects.bearing_tilt import BearingTilt
from ...effects.foundation import Foundation
from ...effects.gravity_compensator import GravityCompensator
from ...effects.hose_torque import HoseTorque
from ...effects.joint_compliance import JointCompliance
from ...effects.kinds import LinearYield
from ...effects.link_bending import LinkBending
from ...effects.link_mass import LinkMass
from ...effects.lost_motion import LostMotion
from ...effects.payload import Payload
from ...robot.kinematics import RX, RY, Array
from ...simulation.virtual_campaign import Truth
from .hidden import Hidden, largest_torque, slot_yield


def joint_compliance(problem: Problem, effect: JointCompliance, rng: np.random.Generator) -> Hidden:
    """c τ that saturates or hardens by a tenth."""
    axial = int(problem.arm.axial[problem.joint(effect.where.joint)] % 6)
    down = effect.nominal > 0 and rng.random() < 0.4
    unit = -0.1 if down else effect.params[0].typical
    c, bend = unit * (effect.nominal or 1.0), rng.uniform(-0.1, 0.1)
    most = largest_torque(problem, problem.joint(effect.where.joint))

    def law(wrench: Array) -> Array:
        out, tau = np.zeros(6), wrench[axial]
        out[axial] = c * tau * (1 + bend * (2 * abs(tau) / most - 1))
        return out

    form = slot_yield(effect.slot(problem.arm), law)
    return Hidden("joint_compliance", effect, np.array([unit]), form, 5.0)


def lost_motion(problem: Problem, effect: LostMotion, rng: np.random.Generator) -> Hidden:
    """A soft zone as an arctan of any width, play with soft edges, or hardening with the power 2.6."""
    j = problem.joint(effect.where.joint)
    axial = int(problem.arm.axial[j] % 6)
    most = largest_torque(problem, j)
    kind = str(rng.choice(["soft", "play", "power"], p=[0.5, 0.25, 0.25]))
    width = most * float(np.exp(rng.uniform(np.log(0.05), np.log(0.4)))) * (0.3 if kind == "play" else 1.0)
    amplitude = 5e-5 * (float(rng.choice([-1.0, 1.0])) if kind == "power" else 1.0)

    def law(wrench: Array) -> Array:
        out, tau = np.zeros(6), wrench[axial]
        if kind == "power":
            out[axial] = amplitude * np.sign(tau) * (abs(tau) / most) ** 2.6
        else:
            out[axial] = amplitude * 2 / np.pi * np.arctan(0.5 * np.pi * tau / width)
        return out

    variant = {"soft": "soft 0.15", "play": "play", "power": "cubic"}[kind]
    same = (e for e in LostMotion.sites(problem) if e.key == effect.key and e.variant == variant)
    named = next(same, effect)
    form = slot_yield(effect.slot(problem.arm), law)
    return Hidden("lost_motion", named, np.array([amplitude]), form, 20.0)


def gravity_compensator(problem: Problem, effect: GravityCompensator, rng: np.random.Generator) -> Hidden:
    """A gas whose loss follows a polytrope, warm gas and another exponent likewise; friction that grows with
    the stroke."""
    law = problem.compensator
    assert law is not None
    sign = -1.0 if effect.variant == "charge" and rng.random() < 0.75 else 1.0
    unit = sign * effect.params[0].typical
    if effect.variant == "preload":
        law = replace(law, data=law.data.model_copy(update={"exponent": 1.0}))
    else:
        law = replace(law, data=law.data.model_copy(update={"exponent": float(rng.uniform(1.2, 1.3))}))
    grow = rng.uniform(-0.3, 0.3)  # of the preload, per 0.1 m of stroke

    def torque(problem: Problem) -> Array:
        changed = replace(problem.loads, compensator=law)
        wrench = effect.wrench(problem, problem.rigid, changed)[..., 0]
        column = problem.arm.own(wrench)
        if effect.variant == "preload":
            s = law.ends(problem.rigid)[2]
            column = column * (1 + grow * (s - s.mean()) / 0.1)[:, None]
        return np.asarray(unit * column)

    def form(size: float) -> Truth:
        return Truth(torque=lambda problem: size * torque(problem))

    largest = 3.0 if effect.variant == "exponent" else 8.0  # no gas is beyond adiabatic
    return Hidden("gravity_compensator", effect, np.array([unit]), form, largest)


def payload(problem: Problem, effect: Payload, rng: np.random.Generator) -> Hidden:
    """Mostly a mass, or mostly a centre of mass, and a little of the other."""
    return _mass_and_place("payload", problem, effect, rng, 6.0)


def link_mass(problem: Problem, effect: LinkMass, rng: np.random.Generator) -> Hidden:
    """Mostly a mass, or mostly a centre of mass, and a little of the other."""
    return _mass_and_place("link_mass", problem, effect, rng, 10.0)


def _mass_and_place(
    name: str, problem: Problem, effect: Any, rng: np.random.Generator, largest: float
) -> Hidden:
    way = rng.normal(size=3)
    shift = way / np.linalg.norm(way)
    mass = float(rng.choice([-1.0, 1.0]))
    sites = type(effect).sites(problem)
    other = next(e for e in sites if e.key == effect.key and e.variant != effect.variant)
    by_mass, by_place = (effect, other) if effect.variant == "mass" else (other, effect)
    (param,) = by_mass.params
    if mass * largest * param.typical < param.lower:  # lighter than nothing is no tool
        mass = 1.0
    m = mass * np.array([param.typical]) * (1.0 if effect is by_mass else 0.15)
    d = shift * by_place.params[0].typical * (1.0 if effect is by_place else 0.15)

    def form(size: float) -> Truth:
        return Truth(effects=((by_mass, size * m), (by_place, size * d)))

    unit = m if effect is by_mass else d
    return Hidden(name, effect, unit, form, largest, more=(other,))


def hose_torque(problem: Problem, effect: HoseTorque, rng: np.random.Generator) -> Hidden:
    """−k q that stiffens towards the ends of the joint's range."""
    j, bend = problem.joint(effect.where.joint), rng.uniform(0.0, 0.2)
    far = float(np.abs(problem.q[:, j]).max())

    def torque(problem: Problem) -> Array:
        out, q = np.zeros_like(problem.q), problem.q[:, j]
        out[:, j] = -10.0 * q * (1 + bend * (2 * (q / far) ** 2 - 1))
        return out

    def form(size: float) -> Truth:
        return Truth(torque=lambda problem: size * torque(problem))

    return Hidden("hose_torque", effect, np.array([10.0]), form, 30.0)


def link_bending(problem: Problem, effect: LinkBending, rng: np.random.Generator) -> Hidden:
    """Timoshenko rather than Bernoulli, and not equally stiff both ways."""
    C = effect.compliance(problem.arm)
    stretch = np.diag(rng.uniform(0.9, 1.1, 6))  # of the axes: stays symmetric and positive
    C = stretch @ C @ stretch
    C[:3, :3] *= rng.uniform(1.0, 1.15)  # shear
    return _yields("link_bending", effect, C, problem, 100.0)


def bearing_tilt(problem: Problem, effect: BearingTilt, rng: np.random.Generator) -> Hidden:
    """Not equally stiff about both axes, a little of one moment turns the other axis, and rolling contacts
    stiffen as they are pressed (Hertz)."""
    return _yields("bearing_tilt", effect, _uneven(rng), problem, 100.0, rng.uniform(0.0, 0.15))


def foundation(problem: Problem, effect: Foundation, rng: np.random.Generator) -> Hidden:
    """A floor that is stiffer one way than the other, and under a larger moment."""
    return _yields("foundation", effect, _uneven(rng), problem, 100.0, rng.uniform(0.0, 0.15))


def _uneven(rng: np.random.Generator) -> Array:
    C = np.zeros((6, 6))
    C[RX, RX], C[RY, RY] = 1 + rng.uniform(-0.12, 0.12) * np.array([1.0, -1.0])
    C[RX, RY] = C[RY, RX] = rng.uniform(-0.06, 0.06)
    return C


def _yields(
    name: str, effect: LinearYield, C: Array, problem: Problem, largest: float, power: float = 0.0
) -> Hidden:
    """Softer by the `power` of how much smaller an overturning moment is than the campaign's largest."""
    slot, unit = effect.slot(problem.arm), effect.params[0].typical
    moments = np.linalg.norm(problem.nominal_load.local[:, slot, RX : RX + 2], axis=1)
    most = max(float(moments.max(initial=0.0)), 1e-6)

    def law(wrench: Array) -> Array:
        share = np.hypot(np.linalg.norm(wrench[RX : RX + 2]) / most, 0.05)
        return np.asarray(unit * share**-power * C @ wrench)

    return Hidden(name, effect, np.array([unit]), slot_yield(slot, law), largest)
