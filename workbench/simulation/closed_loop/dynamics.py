"""The simulated robot's equations of motion and their step: implicit midpoint on Drake's terms.

Drake's plant gives mass matrix, Coriolis forces, gravity, springs, dampers, the compensator; what Drake has
no element for (gears, friction, springs that are not linear) is added here.
Springs, dampers and friction enter implicitly, so no stiffness, however high, bounds the step, and none is
softened or slowed for it. One linear solve per step:

(M + h D/2 + h² K/4) Δv = h f + (h D/2 + h² K/4) Δv₀,    f at q + h v/2 + h Δv₀/4, v + Δv₀/2,

Δv₀ the step before's. Second order; on a linear system it is the midpoint rule itself (Hairer et al. 2006).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import MultibodyForces
from scipy.linalg.lapack import dposv

from ...robot.kinematics import Array
from ...robot.loop import Loop
from ...robot.plant_parts import motion_transform, slot_pose
from .body_forces import BodyForces
from .drives import Drives
from .friction import Rubbing
from .gears import Gears
from .machine import Machine
from .mechanics import Mechanics
from .springs import Springs

PLACED = 0.05  # s between the instants at which frames are put where temperature and drift have them
CROSSED = 5e-3  # s in which a joint follows across its play; at once, a rigid one would throw its motor back
SEEN = 4e-3  # s between looks at the forces at bodies, which go on in between as they went


@dataclass(frozen=True, eq=False)
class Along:
    """What time alone decides, a row per step: wrench (K, 6), joint torque (K, n), charge of the
    compensator (K,); None where there is none. placed: (K, S, 6), None where nothing moves."""

    wrench: Array | None = None
    torque: Array | None = None
    charge: Array | None = None
    placed: Array | None = None


class Dynamics:
    """State of the simulated robot, and its step. Coordinates are the plant's.

    q, v: (V,); side: [n] from which each motor has come, −1 … 1, taken: [n] the same as the joints have it.
    Friction and gas keep states of their own.
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
        self.mechanics, self.machine, self.gears, self.along = mechanics, machine, gears, along
        self.plant, self.h = machine.plant, step
        self.context = self.plant.CreateDefaultContext()
        self.forces, self.size = MultibodyForces(self.plant), self.plant.num_velocities()
        self.bodies = BodyForces(machine, self.context, loop, along.wrench, along.charge)
        self.springs = Springs(mechanics, machine, drive, gears, reaction, step)
        self.extra = None if along.torque is None else self._at_joints(along.torque)
        self.rubbing = Rubbing(machine, drive, loop, step)
        self.none = np.zeros(self.size)
        self.pulled = self.trend = self.none
        self.side = [0.0] * mechanics.arm.n
        self.follow = 1 - np.exp(-step / CROSSED)
        self.places = machine.motors
        self.motors: list[int] = machine.motors.tolist()
        self.x = np.zeros(2 * self.size)
        self.often, self.seen = (max(1, round(T / step)) for T in (PLACED, SEEN))
        self.put(self.none[machine.motors])

    def put(self, q: Array) -> None:
        """Still, with the drives at q (n,) and the springs slack."""
        self.q, self.v, self.dv = self.none.copy(), self.none.copy(), self.none.copy()
        self.q[self.machine.motors] = q
        self.taken = list(self.side)

    def advance(self, torque: Array, k: int) -> None:
        """Step number k under the drives' torque (n,)."""
        h = self.h
        v = self.v + 0.5 * self.dv
        if k % self.often == 0:
            self.place(k)
        self.set(self.q + (h / 2) * v, v)
        M = self.plant.CalcMassMatrix(self.context)
        at, force = self.x.tolist(), self.drakes()
        if self.bodies.active:
            force += self._at_bodies(k)
        self.springs.add(v, at, self.taken, force)
        implicit = self.springs.implicit()
        if self.rubbing.active:
            implicit = implicit + self.rubbing.take(v, force)
        force[self.places] += torque
        if self.extra is not None:
            force += self.extra[k]
        right = h * force + implicit @ self.dv
        _, dv, failed = dposv((M.T + implicit).T, right, overwrite_a=True)
        if failed:
            raise ArithmeticError("the simulation diverged")
        self._go(dv)

    def _at_joints(self, torque: Array) -> Array:
        """(K, V) of torques (K, n) at motors and springs."""
        out = np.zeros((len(torque), self.size))
        out[:, self.machine.motors] = torque
        out[:, self.machine.own_at] = torque[:, self.machine.sprung]
        return out

    def _at_bodies(self, k: int) -> Array:
        """Compensator and process force in step k."""
        since = k % self.seen
        if since == 0:
            now = self.bodies.at(k, self.seen * self.h if k else None)
            self.trend = (now - self.pulled) / self.seen if k else self.none
            self.pulled = now
        return self.pulled + since * self.trend

    def set(self, q: Array, v: Array) -> None:
        """Puts the plant there."""
        self.x[: self.size], self.x[self.size :] = q, v
        self.plant.SetPositionsAndVelocities(self.context, self.x)

    def _go(self, dv: Array) -> None:
        """Ends the step with the velocities' change."""
        moved = self.h * (self.v + 0.5 * dv)
        self.q = self.q + moved
        self.v = self.v + dv
        self.dv = dv
        self.rubbing.go(moved)
        if self.gears.play:
            way = moved.tolist()
            self.side = self.gears.crossed(self.side, [way[at] for at in self.motors])
            self.taken = [t + self.follow * (s - t) for t, s in zip(self.taken, self.side, strict=True)]

    def place(self, k: int) -> None:
        """Puts the frames that temperature and drift move where they are at step k."""
        placed = self.along.placed
        if placed is None:
            return
        arm = self.mechanics.arm
        for slot in range(arm.slots):
            X = slot_pose(arm, slot, arm.geometry[slot]) @ motion_transform(placed[k, slot])
            self.machine.built.corrected[slot].SetPoseInParentFrame(self.context, X)

    def drakes(self) -> Array:
        """(V,) gravity, Coriolis forces and force elements of the plant."""
        self.plant.CalcForceElementsContribution(self.context, self.forces)
        return -np.asarray(self.plant.CalcInverseDynamics(self.context, self.none, self.forces))
