"""The simulated robot's equations of motion and their step: implicit midpoint on Drake's terms.

Drake's plant gives mass matrix, Coriolis forces, gravity and springs; what Drake has no element for (gears,
friction, damping with the gear's slope, springs that are not linear, gas) is added here. Springs, dampers and
friction enter implicitly, so no stiffness, however high, bounds the step, and none is softened or slowed for
it. One linear solve per step:

(M + h D/2 + h² K/4) Δv = h f + (h D/2 + h² K/4) Δv₀,    f at q + h v/2 + h Δv₀/4, v + Δv₀/2,

Δv₀ the step before's. Second order; on a linear system it is the midpoint rule itself (Hairer et al. 2006).
"""

from __future__ import annotations

import math
from bisect import bisect
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces
from scipy.linalg.lapack import dposv

from ...robot.equilibrium import NoRest
from ...robot.kinematics import Array
from ...robot.loop import Loop
from ...robot.plant_parts import motion_transform, slot_pose
from .drives import Drives
from .friction import gone_over, mean_on_the_way, stribeck
from .gears import Gears, of_springs
from .machine import Machine
from .mechanics import Mechanics

PLACED = 0.05  # s between the instants at which frames are put where temperature and drift have them
HELD = 1e-3  # s for which compensator and process force stay as they are
SCREW_DAMPING = 6e-4  # s: damping of a yielding screw over its stiffness


@dataclass(frozen=True, eq=False)
class Along:
    """What time alone decides, a row per step: wrench (K, 6), joint torque (K, n), charge of the
    compensator (K,); None where there is none. placed: (K, S, 6), None where nothing moves."""

    wrench: Array | None = None
    torque: Array | None = None
    charge: Array | None = None
    placed: Array | None = None


class Dynamics:
    """State of the simulated robot, and its step. Coordinates here: the n motors, then the K springs.

    q, v: (n + K,); memory: (2 n,) friction of the drives and behind the gears, −1 … 1; side: (n,) from which
    each motor has come, −1 … 1; heat: relative surplus of the gas's temperature. order: (n + K,) place of the
    coordinates in the plant.
    """

    def __init__(
        self,
        mechanics: Mechanics,
        machine: Machine,
        drive: Drives,
        loop: Loop,
        gears: Gears,
        along: Along,
        step: float,
        reaction: bool = True,
    ) -> None:
        self.mechanics, self.machine, self.drive, self.loop = mechanics, machine, drive, loop
        self.gears, self.along, self.h, self.reaction = gears, along, step, reaction
        plant, n = machine.plant, mechanics.arm.n
        self.plant, self.context = plant, plant.CreateDefaultContext()
        self.forces, self.size, self.n = MultibodyForces(plant), plant.num_velocities(), n
        self.none = np.zeros(self.size)
        self.order = np.concatenate([machine.motors, machine.springs])
        self.state_order = np.concatenate([self.order, self.size + self.order])
        self.matrix_order = (self.order[:, None] * self.size + self.order).ravel()
        self.sprung = machine.sprung
        self.own = slice(n, n + len(self.sprung))
        self.extra = np.where(machine.native, machine.stiffness, 0.0)
        damping = [drive.damping[j] for j, law in enumerate(mechanics.axial) if law is not None]
        damping += [SCREW_DAMPING / screw.compliance for screw in mechanics.screws]
        self.damping = np.array(damping)
        self.damped = np.concatenate([drive.viscous, self.damping])
        self.bent = [
            (int(machine.own[j]), law.motion.tolist(), law.torque.tolist())
            for j, law in enumerate(mechanics.axial)
            if law is not None and law.torque is not None and law.motion is not None
        ]
        # sums over the pairs of gears: at springs (K, P) and at motors (n, P)
        pairs = np.arange(len(gears.by))
        self.of_pair = machine.own[gears.joint]
        self.at_springs, self.at_motors = np.zeros((self.size - n, len(pairs))), np.zeros((n, len(pairs)))
        self.at_springs[self.of_pair, pairs] = 1.0
        self.at_motors[gears.by, pairs] = 1.0
        self.dry = np.concatenate([(1 - loop.load_side) * drive.coulomb, loop.load_side * drive.coulomb])
        self.q, self.v, self.dv = np.zeros(self.size), np.zeros(self.size), np.zeros(self.size)
        self.memory, self.way, self.side = np.zeros(2 * n), np.full(2 * n, loop.presliding), np.zeros(n)
        self.heat, self.length = 0.0, math.nan
        self.x = np.zeros(2 * self.size)
        self.often, self.held = max(1, round(PLACED / step)), max(1, round(HELD / step))
        self.points = self.none
        self.diagonal = np.arange(self.size) * (self.size + 1)
        # behind the gear rubs what the joint does: motor and spring together
        spring = n + np.arange(len(self.sprung))
        self.coupled = np.concatenate([self.sprung * self.size + spring, spring * self.size + self.sprung])

    def advance(self, torque: Array, k: int) -> None:
        """Step number k under the drives' torque (n,)."""
        h, n = self.h, self.n
        q, v = self.q + (h / 2 * self.v + h / 4 * self.dv), self.v + self.dv / 2
        if k % self.often == 0:
            self.place(k)
        self._set(q, v)
        A = np.asarray(self.plant.CalcMassMatrix(self.context)).T.ravel().take(self.matrix_order)
        if k % self.held == 0:
            self.points = self._at_points(k)
        force = (self._drakes() + self.points).take(self.order)
        softness = np.zeros(self.size)
        force[:n] += torque - self.drive.viscous * v[:n]
        self.springs(q, v, force, softness)
        if self.along.torque is not None:
            extra = self.along.torque[k]
            force[:n] += extra
            force[self.own] += extra[self.sprung]
        cross = self._friction(v, force, softness)
        implicit = h / 2 * self.damped + h**2 / 4 * softness
        right = h * force + implicit * self.dv
        A[self.diagonal] += implicit
        right[self.sprung] += cross * self.dv[self.own]
        right[self.own] += cross * self.dv[self.sprung]
        A[self.coupled] += np.concatenate([cross, cross])
        _, dv, failed = dposv(A.reshape(self.size, self.size), right)
        if failed:
            raise ArithmeticError("the simulation diverged")
        self._go(dv)

    def _set(self, q: Array, v: Array) -> None:
        """Puts the plant there."""
        self.x[self.state_order] = np.concatenate([q, v])
        self.plant.SetPositionsAndVelocities(self.context, self.x)

    def _go(self, dv: Array) -> None:
        """Ends the step with the velocities' change."""
        moved = self.h * (self.v + dv / 2)
        self.q = self.q + moved
        self.v = self.v + dv
        self.dv = dv
        self.memory = gone_over(self.memory, self._rubbing(moved), self.way)
        if self.gears.sided:
            self.side = self.gears.crossed(self.side, moved[: self.n])

    def _rubbing(self, x: Array) -> Array:
        """(2 n,) of what the coordinates move at the drives, and behind the gears: motor and spring
        together."""
        out = np.concatenate([x[: self.n], x[: self.n]])
        out[self.n + self.sprung] += x[self.own]
        return out

    def place(self, k: int) -> None:
        """Puts the frames that temperature and drift move where they are at step k."""
        placed = self.along.placed
        if placed is None:
            return
        arm = self.mechanics.arm
        for slot in range(arm.slots):
            X = slot_pose(arm, slot, arm.geometry[slot]) @ motion_transform(placed[k, slot])
            self.machine.built.corrected[slot].SetPoseInParentFrame(self.context, X)

    def _drakes(self) -> Array:
        """Gravity, springs and Coriolis forces of the plant."""
        self.forces.SetZero()
        self.plant.CalcForceElementsContribution(self.context, self.forces)
        return -np.asarray(self.plant.CalcInverseDynamics(self.context, self.none, self.forces))

    def springs(self, q: Array, v: Array, force: Array, softness: Array) -> None:
        """Gears, dampers, and springs that are not Drake's; the motors feel the gears' slopes."""
        machine, gears, n = self.machine, self.gears, self.n
        if self.size == n:
            return
        side = gears.crossed(self.side, (q - self.q)[:n]) if gears.sided else self.side
        errors, slope = gears.errors(q[:n], side)
        stretch, speed = q[n:] - of_springs(machine, errors), v[n:]
        pull, stiffness = machine.stiffness * stretch, machine.stiffness
        if self.bent:
            stiffness = stiffness.copy()
            for i, way, torque in self.bent:
                pull[i], stiffness[i] = tabulated(float(stretch[i]), way, torque)
        if len(slope):
            speed = speed - self.at_springs @ (slope * v[gears.by])
        pull += self.damping * speed
        if len(slope) and self.reaction:
            force[:n] += self.at_motors @ (slope * pull[self.of_pair])
        force[n:] += self.extra * q[n:] - pull
        softness[n:] = stiffness

    def _friction(self, v: Array, force: Array, softness: Array) -> Array:
        """Dry friction of drives, and of joints behind their gears; its coupling of motor and spring.

        Its mean over the step is linearised about the way that the step before makes likely, whose slope by
        Δv is h/2, not h/4 as a spring's: twice as soft.
        """
        loop, n = self.loop, self.n
        moving = self._rubbing(v)
        mean, slope = mean_on_the_way(self.memory, self.h * moving, self.way)
        size = stribeck(moving, self.dry, loop.stiction, loop.stribeck_speed)
        felt, soft = size * mean, 2 * size * slope
        force[:n] -= felt[:n] + felt[n:]
        softness[:n] += soft[:n] + soft[n:]
        behind = soft[n:][self.sprung]
        force[self.own] -= felt[n:][self.sprung]
        softness[self.own] += behind
        return self.h**2 / 4 * behind

    def _at_points(self, k: int) -> Array:
        """Compensator and process force."""
        plant, context, slots = self.plant, self.context, self.machine.built.slots
        force = np.zeros(self.size)
        if (law := self.mechanics.compensator) is not None:
            body, moving = slots[law.body], slots[law.arm]
            X = plant.CalcRelativeTransform(context, body, moving).GetAsMatrix34()
            way = law.body_pivot - X[:, :3] @ law.arm_pivot - X[:, 3]
            s = math.sqrt(way @ way)
            gas = (1.0 if self.along.charge is None else self.along.charge[k]) * (1 + self._warmed(s))
            full, _, gradient = law.force(np.asarray(s))
            pull = (float(full) + (gas - 1) * float(gradient)) / s * way
            J = plant.CalcJacobianTranslationalVelocity(
                context, JacobianWrtVariable.kV, moving, law.arm_pivot, body, body
            )
            force += J.T @ pull
        if self.along.wrench is not None:
            world, flange = plant.world_frame(), self.machine.flange
            J = plant.CalcJacobianSpatialVelocity(
                context, JacobianWrtVariable.kV, flange, np.zeros(3), world, world
            )
            w = self.along.wrench[k]
            force += J.T @ np.concatenate([w[3:], w[:3]])
        return force

    def _warmed(self, s: float) -> float:
        """Relative surplus of the gas's temperature: a fast stroke heats it, and the heat leaves."""
        law = self.mechanics.compensator
        assert law is not None
        data = law.data
        if data.kind != "gas" or data.gas_length is None or data.reference is None:
            return 0.0
        length = data.gas_length - (s - data.reference)
        if not math.isnan(self.length):
            faster = max(self.loop.gas_exponent - data.exponent, 0.0)
            self.heat -= (
                faster * (length - self.length) / length + self.h * self.held / self.loop.gas_time * self.heat
            )
        self.length = length
        return self.heat

    def rest(self, q: Array) -> Array:
        """Puts the arm, drives at q (n,), in its loaded equilibrium; the torques (n,) that hold it there.

        Drake's own torques: e ← δ + yield(torque) until it stands.
        """
        machine, plant, n = self.machine, self.plant, self.n
        self.q, self.v, self.dv = np.zeros(self.size), np.zeros(self.size), np.zeros(self.size)
        self.q[:n] = q
        errors, slope = self.gears.errors(q, self.side)
        error, last = of_springs(machine, errors), np.inf
        wound = (self.dry * self.loop.stiction * self.memory)[n:]
        self.place(0)
        for _ in range(60):
            self._set(self.q, self.v)
            self.length = math.nan
            torque = self._at_points(0) + plant.CalcGravityGeneralizedForces(self.context)
            torque = torque[self.order]
            extra = -wound if self.along.torque is None else self.along.torque[0] - wound
            torque[:n] += extra
            torque[self.own] += extra[self.sprung]
            load = torque[n:]
            if not len(load):
                break
            yields = load / machine.stiffness
            for i, way, pulled in self.bent:
                yields[i] = np.interp(load[i], pulled, way)
            new = error + yields
            change = float(np.abs(new - self.q[n:]).max())
            self.q[n:] = new
            if change < 1e-14 or (change < 1e-10 and change > 0.5 * last):  # as still as rounding allows
                break
            last = change
        else:
            raise NoRest
        needed = -torque[:n]
        if len(slope) and self.reaction:
            needed -= self.at_motors @ (slope * load[self.of_pair])
        return np.asarray(needed)


def tabulated(x: float, way: list[float], torque: list[float]) -> tuple[float, float]:
    """Torque and stiffness at a motion x of a law given as a table."""
    i = min(max(bisect(way, x), 1), len(way) - 1)
    slope = (torque[i] - torque[i - 1]) / (way[i] - way[i - 1])
    return torque[i - 1] + slope * (x - way[i - 1]), slope
