"""What an export starts from: the extended robot under its loads, and poses that weigh what is left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...campaign import Campaign
from ...campaign.planned import planned, random_poses
from ...campaign.problem import Problem, problem_of
from ...campaign.same_robot import check_same_robot
from ...correction.conditions import Conditions
from ...correction.extended_arm import ExtendedArm, extended_arm
from ...effects.acting import Acting
from ...effects.base import Effect
from ...robot.compensator import CompensatorLaw
from ...robot.description import Robot
from ...robot.equilibrium import equilibrium
from ...robot.kinematics import Arm, Array, frames
from ...robot.loads import Loads

GRID = 200  # poses that are drawn where no campaign says any
IDLE = 1e-6  # m at the flange, at most: a spring that might as well be stiff
Part = tuple[Effect, Array]


@dataclass(frozen=True, eq=False)
class Content:
    """The extended robot with one load, and N poses. `poses`: in words, which.

    A part is what one effect of the model adds; beside them stand the TOML's own springs and compensator.
    """

    robot: Robot
    extended: ExtendedArm
    poses: str

    @property
    def problem(self) -> Problem:
        return self.extended.problem

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """What each effect of the model is: see `kind_of`; "idle": a spring that moves the flange by next to
        nothing, which costs a simulator its step."""
        kinds = (kind_of(item, self.problem) for item in self.extended.acting)
        stiff = self.flange(Acting(()), rigid=True)[0]

        def idle(spring: Part) -> bool:
            soft = self.flange(Acting((spring,)), rigid=True)[0]
            return float(np.linalg.norm(soft - stiff, axis=1).max()) < IDLE

        pairs = zip(self.extended.acting, kinds, strict=True)
        return tuple("idle" if kind == "spring" and idle(item) else kind for item, kind in pairs)

    def acting(self, kinds: frozenset[str]) -> Acting:
        """The effects of some kinds."""
        items = zip(self.extended.acting, self.kinds, strict=True)
        return Acting(tuple(item for item, kind in items if kind in kinds))

    @cached_property
    def loaded(self) -> tuple[Arm, Loads]:
        """Arm with the model's masses, and its loads: those of the first pose stand for all."""
        return self.acting(frozenset({"mass", "compensator"})).loads(self.problem, self.problem.arm)

    @property
    def arm(self) -> Arm:
        """The calibrated arm, masses included."""
        return self.loaded[0]

    @property
    def compensator(self) -> CompensatorLaw | None:
        law = self.loaded[1].compensator
        return None if law is None else replace(law, charge=float(np.mean(law.charge)))

    @property
    def payload(self) -> tuple[float, Array]:
        """Mass [kg] and mass times place (3,) [kg·m, flange frame] of tool and payload."""
        loads = self.loaded[1]
        return float(loads.mass[0]), loads.moment[0]

    @cached_property
    def compliance(self) -> Array:
        """(S, 6, 6) what yields in proportion to its load, the model's effects included."""
        return self.acting(frozenset({"spring"})).yielding(self.problem.arm).linear

    def with_geometry(self, geometry: Array) -> Content:
        """The same with other corrections (S, 6) of the geometry."""
        problem = replace(self.problem, arm=self.problem.arm.with_geometry(geometry))
        return replace(self, extended=replace(self.extended, problem=problem))

    def flange(
        self, acting: Acting, *, rigid: bool = False, pulled: bool = True, by: CompensatorLaw | None = None
    ) -> tuple[Array, Array]:
        """Flange (N, 3) [m] and its rotation (N, 3, 3) in the poses under some effects.

        rigid: without the TOML's springs; pulled: with a compensator, the effects' own or `by`.
        """
        arm, loads = acting.loads(self.problem, self.problem.arm)
        if by is not None or not pulled:
            loads = replace(loads, compensator=by)
        arm = replace(arm, compliance=0 * arm.compliance) if rigid else arm
        direct, yielding = acting.direct(self.problem), acting.yielding(arm)
        if not yielding.columns.any():
            where = frames(arm, self.problem.q, direct)
        else:
            where = equilibrium(arm, self.problem.q, direct, loads, yielding.motion)[1]
        return where.p[-1], where.R[-1]


def kind_of(item: Part, problem: Problem) -> str:
    """What an effect does, as far as another program must know.

    "mass", "compensator", "torque": what pulls; "spring": yields in proportion to its load, "law": otherwise;
    "gear": error of a joint along its axis, a sum of functions of one joint each; "other": it hangs on side,
    time, temperature or two joints together, or moves a frame.
    """
    effect, _ = item
    alone = Acting((item,))
    if not effect.uses <= {"joints", "load"} or (effect.acts == "yielding" and effect.motion(problem)):
        return "other"
    if effect.acts == "yielding":
        return "law" if alone.yielding(problem.arm).bent else "spring"
    if effect.acts in ("transmission", "geometry"):
        return "gear" if effect.acts == "transmission" and effect.axial and effect.by_motor else "other"
    _, loads = alone.loads(problem, problem.arm)
    if loads.compensator is not problem.loads.compensator:
        return "compensator"
    return "torque" if (loads.torque != problem.loads.torque).any() else "mass"


def content_of(robot: Robot, campaign: Campaign | None, conditions: Conditions) -> Content:
    """The robot with these loads in the campaign's poses, or in drawn ones (seed 0)."""
    side = time = temperature = None
    if campaign is not None:
        check_same_robot(robot, campaign)
        poses = campaign.poses
        where = f"the {len(poses.q)} poses of {campaign.title or campaign.path.name}"
        q, side, time, temperature = poses.q, poses.side, poses.time, poses.temperature
    else:
        rng = np.random.default_rng(0)
        q = random_poses(robot, GRID, rng)
        side = rng.choice([-1.0, 1.0], q.shape)
        where = f"{GRID} poses drawn within the joints' limits, clear of what the base stands on (seed 0)"
    name = conditions.payload
    plan = planned(
        robot, q, targets=(),
        payloads={name: (conditions.payload_mass, conditions.payload_com)} if name else None,
        payload=[name] * len(q) if name else None,
        tool=(conditions.tool_mass, conditions.tool_com),
        direction=side, time=time, temperature=temperature,
    )  # fmt: skip
    mass = conditions.payload_mass + conditions.tool_mass
    return Content(robot, extended_arm(problem_of(plan)), f"{where}, {mass:g} kg at the flange")
