"""The kinds of effects: one base class for each stretch of the way from a command to a measured point."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import reduce
from typing import ClassVar

import numpy as np

from ..campaign import drive_torque
from ..campaign.problem import Problem
from ..robot.kinematics import RX, RZ, TZ, Arm, Array, Frames
from ..robot.loads import Loads
from .base import Acts, Depends, Effect, Rest, Slopes
from .drawn import Drawn

GRID = 200  # points of a drawn curve
MOST_TURN, MOST_SHIFT = 6e-3, 2e-3  # rad, m: one sigma of how far a part of an arm gives way


class DirectEffect(Effect):
    """A motion of frames that does not depend on load and is linear in its parameters."""

    acts: ClassVar[Acts] = "geometry"
    in_drake: ClassVar[str] = "a joint for each component that moves, set to the motion"

    @abstractmethod
    def motion(self, problem: Problem) -> Mapping[int, Array]:
        """Column 6 · slot + component → (N, p) motion [m, rad] per unit of each parameter."""

    def jacobian(self, problem: Problem, line: Slopes, values: Array) -> Array:
        motion = self.motion(problem)
        if not motion:  # none at these poses
            return np.zeros((*line.direct.shape[:2], len(self.params)))
        return np.asarray(np.matmul(line.direct[:, :, list(motion)], np.stack([*motion.values()], axis=1)))


class TransmissionEffect(DirectEffect):
    """Commanded joint → joint angle without load, of the joint `where.joint`."""

    acts: ClassVar[Acts] = "transmission"
    depends: ClassVar[Depends] = frozenset({"joints"})
    axial: ClassVar[bool] = True
    in_drake: ClassVar[str] = "the joint's motor, set to the command plus the error"

    @abstractmethod
    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        """(N, p) joint motion [rad, m] per unit of each parameter, for joints q: (N, n)."""

    def beyond(self, q: Array, joints: tuple[str, ...]) -> Array:
        """(N,) one sigma of the joint's motion [rad, m] that the parameters do not have, where q (N, n) is
        beyond what was measured of a function that ends there."""
        return np.zeros(len(q))

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        joint, amount = self.of_joint(problem)
        return {int(problem.arm.axial[joint]): amount}

    def ends(self, problem: Problem) -> Mapping[int, Array]:
        column = int(problem.arm.axial[problem.joint(self.where.joint)])
        return {column: self.beyond(problem.q, problem.arm.names)}

    def of_joint(self, problem: Problem) -> tuple[int, Array]:
        amount = self.basis(problem.q, problem.campaign.poses.side, problem.arm.names)
        return problem.joint(self.where.joint), amount

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Over the side of approach, the phase of its order, or the joint that it depends on."""
        arm, q, side = problem.arm, problem.q, problem.campaign.poses.side
        j = problem.joint(self.where.joint)
        k = j if self.where.other is None else problem.joint(self.where.other)
        size = self.basis(q, side, arm.names) @ values
        unit, name = "m" if arm.prismatic[j] else "rad", f"error of {self.where.joint}"
        if "side" in self.uses and side is not None:
            return Drawn(
                side[:, j].astype(float), f"side of approach of {arm.names[j]}", "1", size, name, unit
            )
        order = self.where.order
        sweep = np.tile(q.mean(axis=0), (GRID, 1))
        if order is not None:
            sweep[:, k] = np.linspace(0, 2 * np.pi / order, GRID)
            x, factor, x_unit = np.degrees(np.mod(order * q[:, k], 2 * np.pi)), np.degrees(order), "deg"
            x_name = f"phase of order {order:g}"
        else:
            sweep[:, k] = np.linspace(q[:, k].min(), q[:, k].max(), GRID)
            factor, x_unit = (1e3, "mm") if arm.prismatic[k] else (np.degrees(1.0), "deg")
            x, x_name = q[:, k] * factor, arm.names[k]
        curve = sweep[:, k] * factor, self.basis(sweep, None, arm.names) @ values
        return Drawn(x, x_name, x_unit, size, name, unit, curve)


class YieldEffect(Effect):
    """What yields under the wrenches in the arm."""

    acts: ClassVar[Acts] = "yielding"
    by_loads: ClassVar[bool] = True
    depends: ClassVar[Depends] = frozenset({"load"})
    in_drake: ClassVar[str] = (
        "a joint for each component that gives way, with a RevoluteSpring or PrismaticSpring; "
        "where components are coupled or the law is not linear, SlotSprings at the plant's port"
    )

    @property
    def kin(self) -> Hashable:
        """Real arms yield in other forms than these, and everywhere a little."""
        return "yield"

    @property
    @abstractmethod
    def parts(self) -> Sequence[SlotYield]:
        """The slots that yield, each by the same parameters."""

    def prior(self, problem: Problem) -> Array:
        """Nothing in an arm turns by more than some mrad, or shifts by more than a millimetre, under the
        loads of a campaign; a coarse one gives way by more."""
        most, nothing = np.zeros(len(self.params)), np.zeros(len(self.params))
        for part in self.parts:
            wrench = problem.nominal_load.local[:, part.slot(problem.arm)]
            per_unit = np.abs(part.law(problem.arm, wrench, nothing)[2])
            share = per_unit / np.array([MOST_SHIFT] * 3 + [MOST_TURN] * 3)[:, None]
            most = np.maximum(most, share.max(axis=(0, 1), initial=0.0))
        return np.asarray(np.minimum(super().prior(problem), problem.coarse / np.maximum(most, 1e-300)))

    def jacobian(self, problem: Problem, line: Slopes, values: Array) -> Array:
        return self._under(line, line.prediction.load.local, values)

    def under(self, line: Slopes, wrench: Array, values: Array) -> Array | None:
        return self._under(line, wrench, values)

    def _under(self, line: Slopes, wrench: Array, values: Array) -> Array:
        return self._seen(line, lambda part, arm, k: part.law(arm, wrench[:, k], values)[2])

    def yields_to(self, line: Slopes, wrench: Array, values: Array) -> Array | None:
        local = line.prediction.load.local
        return self._seen(line, lambda part, arm, k: part.law(arm, local[:, k], values)[1] @ wrench[:, k])

    def _seen(self, line: Slopes, moved: Callable[[SlotYield, Arm, int], Array]) -> Array:
        """(N, R, p) what is observed of its parts, of which each is `moved` (N, 6, p) at its slot."""
        arm = line.prediction.arm
        at = [(part, part.slot(arm)) for part in self.parts]
        each = (line.direct[:, :, 6 * k : 6 * k + 6] @ moved(part, arm, k) for part, k in at)
        return reduce(np.add, each)


class SlotYield(YieldEffect):
    """A slot that yields under its own wrench."""

    @property
    def parts(self) -> Sequence[SlotYield]:
        return (self,)

    @abstractmethod
    def slot(self, arm: Arm) -> int:
        """Number of the slot that yields."""

    @abstractmethod
    def components(self, arm: Arm) -> tuple[int, ...]:
        """Which of the six components take part in the yield."""

    @abstractmethod
    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        """Motion (N, 6), its derivative by the wrench (N, 6, 6) and by the parameters (N, 6, p).

        wrench: (N, 6) [N, N·m] at the slot, on its own axes.
        """


class AxialYield(SlotYield):
    """A joint that yields about (or along) its own axis."""

    axial: ClassVar[bool] = True

    def slot(self, arm: Arm) -> int:
        return arm.names.index(str(self.where.joint)) + 1

    def components(self, arm: Arm) -> tuple[int, ...]:
        return (TZ if arm.prismatic[self.slot(arm) - 1] else RZ,)

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Over the joint's torque."""
        arm, k = rest.arm, self.slot(rest.arm)
        (axial,) = self.components(arm)
        local = rest.load.local[:, k]
        sweep = np.zeros((GRID, 6))
        sweep[:, axial] = np.linspace(local[:, axial].min(), local[:, axial].max(), GRID)
        size, curve = (self.law(arm, wrench, values)[0][:, axial] for wrench in (local, sweep))
        sliding, name = bool(arm.prismatic[k - 1]), str(self.where.joint)
        what, unit = ("force on", "N") if sliding else ("torque of", "N·m")
        return Drawn(local[:, axial], f"{what} {name}", unit, size, f"error of {name}",
                     "m" if sliding else "rad", (sweep[:, axial], curve))  # fmt: skip


class LinearYield(SlotYield):
    """A yield with one parameter: motion = value · C · wrench.

    shifts: its shift is drawn, not its turn; load_name, load_unit: what it is drawn against, C · wrench.
    """

    in_proportion: ClassVar[bool] = True
    shifts: ClassVar[bool] = False
    load_name: ClassVar[str] = "overturning moment"
    load_unit: ClassVar[str] = "N·m"

    @abstractmethod
    def compliance(self, arm: Arm) -> Array:
        """(6, 6) compliance of the slot per unit of the parameter."""

    def components(self, arm: Arm) -> tuple[int, ...]:
        C = self.compliance(arm)
        return tuple(int(i) for i in np.flatnonzero(C.any(axis=0) | C.any(axis=1)))

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        C = self.compliance(arm)
        unit = wrench @ C.T
        by_wrench = np.broadcast_to(values[0] * C, (len(wrench), 6, 6))
        return values[0] * unit, by_wrench, unit[:, :, None]

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Over the load that it answers to: a straight line through zero."""
        moved = rest.load.local[:, self.slot(rest.arm)] @ self.compliance(rest.arm).T
        load = np.linalg.norm(moved[:, :RX] if self.shifts else moved[:, RX:], axis=1)
        place = str(self.where) or "the base"
        what, unit = ("deflection", "m") if self.shifts else ("tilt", "rad")
        return Drawn(load, f"{self.load_name} at {place}", self.load_unit, values[0] * load,
                     f"{what} of {place}", unit)  # fmt: skip


class LoadEffect(Effect):
    """A change of what pulls on the arm."""

    acts: ClassVar[Acts] = "load"
    by_loads: ClassVar[bool] = True
    in_drake: ClassVar[str] = "a torque on the joint's motor and on its spring, at the plant's port"
    depends: ClassVar[Depends] = frozenset({"joints"})

    @abstractmethod
    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        """Arm and loads with the effect in them."""

    @abstractmethod
    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        """(N, S, 6, p) change of the local wrenches per unit of each parameter."""

    def pulled(self, problem: Problem, line: Slopes) -> Array:
        return self.wrench(problem, line.prediction.where, line.prediction.loads)

    def jacobian(self, problem: Problem, line: Slopes, values: Array) -> Array:
        rest = line.prediction
        change = self.pulled(problem, line)
        change = change.reshape(len(change), -1, change.shape[-1])
        out = np.asarray(line.torque @ change[:, line.rows])
        if problem.drives:
            out[:, -problem.drives :] = drive_torque.project(problem, -change[:, rest.arm.axial])
        return out

    def joint_torque(self, problem: Problem, rest: Rest, values: Array) -> tuple[int, Array]:
        """The joint that yields most to the effect, and the change of its torque (N,) [N·m, N]."""
        arm = rest.arm
        change = self.wrench(problem, rest.where, rest.loads) @ values
        torque = arm.own(change)
        slot, component = np.divmod(arm.axial, 6)
        soft = arm.compliance[slot, component, component]
        most = int(np.argmax((torque**2).mean(axis=0) * (soft**2 if soft.any() else 1.0)))
        return most, torque[:, most]

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Torque at the joint that yields most to it, over the torque that a unit makes there."""
        j, torque = self.joint_torque(problem, rest, values)
        size, unit = float(np.linalg.norm(values)) or 1.0, self.params[0].unit
        load, name = "N" if problem.arm.prismatic[j] else "N·m", problem.arm.names[j]
        per = "" if unit == "1" else f" per {unit}"
        unit = f"({unit})" if "·" in unit or "/" in unit else unit
        return Drawn(torque / size, f"load on {name}{per}", f"{load}/{unit}" if per else load, torque,
                     f"load on {name}", load)  # fmt: skip

    def drawn_over_joint(self, problem: Problem, j: int, torque: Array) -> Drawn:
        """Torque (N,) at joint j over the joint's own angle."""
        sliding, name = bool(problem.arm.prismatic[j]), problem.arm.names[j]
        x = problem.q[:, j] * (1e3 if sliding else np.degrees(1.0))
        return Drawn(x, name, "mm" if sliding else "deg", torque, f"load on {name}",
                     "N" if sliding else "N·m")  # fmt: skip


class InstrumentEffect(Effect):
    """How the points are seen; linear in its parameters, even in the points."""

    acts: ClassVar[Acts] = "instrument"
    in_drake: ClassVar[str] = "nothing: the measured points change"
    depends: ClassVar[Depends] = frozenset({"points"})

    @abstractmethod
    def seen(self, problem: Problem, points: Array) -> Array:
        """(N, T, 3, p) change of the points (N, T, 3) [m] in the instrument's frame."""

    def jacobian(self, problem: Problem, line: Slopes, values: Array) -> Array:
        seen = self.seen(problem, line.prediction.true)
        seen = seen.reshape(len(seen), -1, seen.shape[-1])
        drives = np.zeros((len(seen), problem.drives, seen.shape[-1]))
        return np.concatenate([seen, drives], axis=1) if problem.drives else seen
