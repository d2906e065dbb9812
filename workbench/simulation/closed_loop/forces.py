"""Everything that acts on the plant beside gravity, in one Python system: a call costs tens of µs, so one.

Of a transmission with error δ(q_m), V = U(e − δ): the spring pulls back with U′(e − δ) at its own
coordinate, and the motor feels δ′ᵀ U′. Without that reaction the tool is wrong by nearly the effect itself.
δ is tabulated along the command with its slope: q_m follows to a few µrad, which leaves nothing to see.
"""

from __future__ import annotations

import math

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from ...robot.equilibrium import NoRest
from ...robot.kinematics import Array
from .control import Drives
from .machine import Machine
from .mechanics import Mechanics
from .motion import Motion, interpolated

SLOPE = 1e-6  # rad, m: half the step of the numerical slope of gear errors


class Forces(LeafSystem):
    """Drives, controller, springs, gears, friction, compensator, process force → generalised forces.

    Inputs: the plant's state; the integral of the motors' positions. `torque`: (K, n) feed-forward.
    """

    def __init__(
        self,
        mechanics: Mechanics,
        machine: Machine,
        drive: Drives,
        motion: Motion,
        torque: Array,
        wrench: Array | None = None,
        joint_torque: Array | None = None,
        reaction: bool = True,
    ) -> None:
        super().__init__()
        self.mechanics, self.machine, self.drive, self.motion = mechanics, machine, drive, motion
        plant, n = machine.plant, mechanics.arm.n
        self.state = self.DeclareVectorInputPort("state", plant.num_multibody_states())
        self.travel = self.DeclareVectorInputPort("travel", n)
        self.DeclareVectorOutputPort("force", plant.num_velocities(), self._calc)
        self.scratch = plant.CreateDefaultContext()
        self.reaction = reaction
        self._gear()
        self._tables(torque, joint_torque)
        self.wrench = wrench if wrench is not None and wrench.any() else None
        damping = [drive.damping[j] for j, law in enumerate(mechanics.axial) if law is not None]
        damping += [6e-4 / screw.compliance for screw in mechanics.screws]  # 30 % of the fastest mode
        self.damping = np.array(damping)
        self.bent = [
            (int(machine.own[j]), law.motion, law.torque)
            for j, law in enumerate(mechanics.axial)
            if law is not None and law.torque is not None and law.motion is not None
        ]
        self.sprung = np.flatnonzero(machine.own >= 0)
        self.bias = np.zeros(n)

    def _gear(self) -> None:
        """Errors (K, springs) and slopes (K) of each gear along the command."""
        motion, mechanics = self.motion, self.mechanics
        n = mechanics.arm.n
        error = mechanics.gear_error(motion.q, motion.side)
        self.error = np.zeros((len(error), len(self.machine.springs)))
        sprung = np.flatnonzero(self.machine.own >= 0)
        self.error[:, self.machine.own[sprung]] = error[:, sprung]
        self.pairs: list[tuple[int, int]] = []  # spring, motor
        slopes = []
        for j in range(n) if mechanics.gear else ():
            ahead, behind = motion.q.copy(), motion.q.copy()
            ahead[:, j] += SLOPE
            behind[:, j] -= SLOPE
            change = mechanics.gear_error(ahead, motion.side) - mechanics.gear_error(behind, motion.side)
            for i in np.flatnonzero(change.any(axis=0)):
                self.pairs.append((int(self.machine.own[i]), j))
                slopes.append(change[:, i] / (2 * SLOPE))
        self.slopes = np.stack(slopes, axis=1) if slopes else np.zeros((len(error), 0))
        self.spring_of = np.array([i for i, _ in self.pairs], dtype=np.int64)
        self.motor_of = np.array([j for _, j in self.pairs], dtype=np.int64)

    def _tables(self, torque: Array, joint_torque: Array | None) -> None:
        """Everything that time alone decides, a row per instant: so a call is one look-up."""
        drive, motion = self.drive, self.motion
        travelled = np.zeros_like(motion.q)
        middle = motion.period * (motion.q[1:] + motion.q[:-1]) / 2
        middle -= motion.period**2 * (motion.v[1:] - motion.v[:-1]) / 12
        np.cumsum(middle, axis=0, out=travelled[1:])
        self.position, self.integral = drive.kp * drive.kv + drive.ki, drive.ki * drive.kv
        self.commanded = torque + drive.kp * motion.v + self.integral * travelled + self.position * motion.q
        self.quantised = bool(drive.count.any())
        self.joint_torque = joint_torque if joint_torque is not None and joint_torque.any() else None

    def _calc(self, context: Context, output: BasicVector) -> None:
        """Generalised forces at an instant."""
        drive, machine, pairs = self.drive, self.machine, len(self.pairs)
        k = min(int(context.get_time() / self.motion.period + 0.5), len(self.commanded) - 1)
        x: Array = self.state.Eval(context)  # type: ignore[assignment]
        half = len(x) // 2
        at, along = machine.motors, machine.springs
        q, v = x[at], x[half:][at]
        force = np.zeros(half)
        seen = drive.count * np.round(q / drive.count) if self.quantised else q
        motor = self.commanded[k] + self.bias - self.position * seen - (drive.kp + drive.viscous) * v
        travelled: Array = self.travel.Eval(context)  # type: ignore[assignment]
        motor -= self.integral * travelled + drive.coulomb * np.tanh(v / drive.sliding)
        if len(along):
            stretch, speed = x[along] - self.error[k], x[half:][along]
            if pairs:
                slope = self.slopes[k]
                np.subtract.at(speed, self.spring_of, slope * v[self.motor_of])
            pull = machine.stiffness * stretch
            for i, way, torque in self.bent:
                pull[i] = np.interp(stretch[i], way, torque)
            pull += self.damping * speed
            if pairs and self.reaction:
                np.add.at(motor, self.motor_of, slope * pull[self.spring_of])
            force[along] = -pull
        if self.joint_torque is not None:
            extra = self.joint_torque[k]
            motor += extra
            force[along[machine.own[self.sprung]]] += extra[self.sprung]
        force[at] = motor
        if self.mechanics.compensator is not None or self.wrench is not None:
            force += self.at_points(x[:half], k)
        output.SetFromVector(force)

    def at_points(self, positions: Array, k: int) -> Array:
        """Generalised forces of compensator and process force."""
        plant, context, slots = self.machine.plant, self.scratch, self.machine.built.slots
        plant.SetPositions(context, positions)
        force = np.zeros(plant.num_velocities())
        if (law := self.mechanics.compensator) is not None:
            body, moving = slots[law.body], slots[law.arm]
            X = plant.CalcRelativeTransform(context, body, moving).GetAsMatrix34()
            way = law.body_pivot - X[:, :3] @ law.arm_pivot - X[:, 3]
            s = math.sqrt(way @ way)
            pull = float(law.force(s)[0]) / s * way
            J = plant.CalcJacobianTranslationalVelocity(
                context, JacobianWrtVariable.kV, moving, law.arm_pivot, body, body
            )
            force += J.T @ pull
        if self.wrench is not None:
            world, flange = plant.world_frame(), self.machine.flange
            J = plant.CalcJacobianSpatialVelocity(
                context, JacobianWrtVariable.kV, flange, np.zeros(3), world, world
            )
            w = self.wrench[k]
            force += J.T @ np.concatenate([w[3:], w[:3]])
        return force

    def rest(self) -> Array:
        """Positions of the plant in static equilibrium at the first instant; sets the drives' torque there.

        Drake's own torques: e ← δ + yield(torque) until it stands.
        """
        plant, machine = self.machine.plant, self.machine
        positions = np.zeros(plant.num_positions())
        positions[machine.motors] = self.motion.q[0]
        last = np.inf
        for _ in range(60):
            torque = self.at_points(positions, 0)
            torque += plant.CalcGravityGeneralizedForces(self.scratch)
            if self.joint_torque is not None:
                torque[machine.motors] += self.joint_torque[0]
                torque[machine.springs[machine.own[self.sprung]]] += self.joint_torque[0, self.sprung]
            if not len(machine.springs):
                break
            load = torque[machine.springs]
            yields = load / machine.stiffness
            for i, way, pulled in self.bent:
                yields[i] = np.interp(load[i], pulled, way)
            new = self.error[0] + yields
            change = float(np.abs(new - positions[machine.springs]).max())
            positions[machine.springs] = new
            if change < 1e-14 or (change < 1e-10 and change > 0.5 * last):  # as still as rounding allows
                break
            last = change
        else:
            raise NoRest
        needed = -torque[machine.motors]
        if len(self.pairs) and self.reaction:
            np.subtract.at(needed, self.motor_of, self.slopes[0] * load[self.spring_of])
        self.bias = needed - (self.commanded[0] - self.position * self.motion.q[0])
        return positions


def table_at(motion: Motion, values: Array) -> Array:
    """Values (N, m) at the path's samples as a table (K, m) at the motion's instants."""
    return interpolated(motion.times, motion.sample_times, values)
