"""What is otherwise in each of several campaigns that are fitted as one robot: it was mastered anew, hit
something, was repaired, is another specimen; another tool was mounted than is stated; lengths are in another
scale.

Places and scales are zero in the last of the campaigns: a model that leaves them out is the robot as that
found it. Loads differ from the stated, in any campaign: a model without them is the robot under the stated
ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Arm, Array, Frames
from ...robot.loads import Loads
from ..base import SURELY, Depends, Param, motion_said, short
from ..kinds import DirectEffect, InstrumentEffect, LoadEffect
from ..masses import mass_wrench, usually_mounted
from ..place import Parameter, Where
from ..recorded import Recorded
from .base import Unnamed, each, moving

COUNTED = "counted there as in the last campaign, whose zeros the model has"
SCALED = "scaled there as in the last campaign; a known distance tells which is right"
CARRIED = "taken to carry that there; state it in that campaign"
LEVER = 0.1  # m: a usual mass has its first moment at this distance from where it is stated
FARTHEST = 10 * LEVER  # m from the flange: nobody mounts a load with its centre there
MOST = 4  # further set-ups that may each have a geometry of its own: more of them have too few poses


@dataclass(frozen=True)
class BySetup(Unnamed):
    """Something that goes with the set-up, and stays in its campaigns."""

    depends: ClassVar[Depends] = frozenset({"setup"})
    dated: ClassVar[bool] = True
    unit: ClassVar[str] = "1"

    def x(self, problem: Problem) -> Array:
        return problem.campaign.poses.setup.astype(float)


@dataclass(frozen=True)
class Anew(BySetup):
    """One place of the robot, or one instrument, for each set-up but the last. others: number of these."""

    size: float = 3e-4
    others: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "others")

    @property
    def functions(self) -> int:
        return int(self.others)

    def _before_last(self, problem: Problem) -> Array:
        """(N, others) 1 in the poses of each set-up but the last."""
        return (problem.campaign.poses.setup[:, None] == np.arange(int(self.others))).astype(float)


def _surely(values: Array, std: Array) -> Array:
    """Values (p,), those that may be zero as zero: a campaign stays as it is where others alone are off."""
    return np.where(np.abs(values) > SURELY * std, values, 0.0)


@dataclass(frozen=True)
class ZeroAnew(Anew, DirectEffect):
    """A joint's zero stands elsewhere in each campaign: it was mastered anew."""

    variant: str = "zero anew"

    @property
    def variable(self) -> str:
        return f"the campaign: the zero of {self.where.joint} is not the same in all"

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        column = int(problem.arm.axial[problem.joint(self.where.joint)])
        return {column: self._before_last(problem)}

    def as_it_was(self, problem: Problem, values: Array, std: Array) -> Recorded:
        """With joints counted in all campaigns as in the last."""
        j, names = problem.joint(self.where.joint), problem.campaign.setup_names
        moved = _surely(values, std)

        def said(k: int, value: float, spread: float) -> str:
            size, error = (motion_said(v, bool(problem.arm.prismatic[j])) for v in (value, spread))
            size = size.replace("-", "\N{MINUS SIGN}")
            where = f"the zero of {self.where.joint} in {names[k]}"
            return f"{where} is {size} (± {error}) from that in {names[-1]}"

        q = problem.q.copy()
        q[:, j] += self._before_last(problem) @ moved
        found = [(k, said(k, float(values[k]), float(std[k]))) for k in np.flatnonzero(moved).tolist()]
        return Recorded("moved_zero", problem.campaign.with_poses(q=q), found, COUNTED)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        others, names = _others(problem), problem.arm.names
        return [cls(Where(joint=names[j]), others=others) for j in moving(problem)] if others else []


@dataclass(frozen=True)
class ScaleAnew(Anew, InstrumentEffect):
    """All lengths are in another scale in each campaign: the instrument's is another, or the whole arm is
    warmer."""

    variant: str = "scale anew"
    size: float = 1e-5

    variable: ClassVar[str] = "the campaign: the scale of all lengths is not the same in all"

    def seen(self, problem: Problem, points: Array) -> Array:
        return np.asarray(points[..., None] * self._before_last(problem)[:, None, None])

    def as_it_was(self, problem: Problem, values: Array, std: Array) -> Recorded:
        """With points in the scale of the last campaign."""
        names = problem.campaign.setup_names
        moved = _surely(values, std)

        def said(k: int, value: float, spread: float) -> str:
            size = f"{1e6 * abs(value):.0f} ppm (± {short(1e6 * spread)} ppm)"
            longer, warmer = ("longer", "warmer") if value > 0 else ("shorter", "colder")
            what = f"lengths in {names[k]} are {size} {longer} than in {names[-1]}"
            return f"{what}: the instrument's scale, or a {warmer} arm"

        found = [(k, said(k, float(values[k]), float(std[k]))) for k in np.flatnonzero(moved).tolist()]
        scale = 1 + self._before_last(problem) @ moved
        campaign = replace(problem.campaign, points=problem.campaign.points / scale[:, None, None])
        return Recorded("changed_scale", campaign, found, SCALED)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        others = _others(problem)
        return [cls(others=others)] if others else []


@dataclass(frozen=True)
class GeometryAnew(Anew, DirectEffect):
    """Every campaign has a geometry of its own: it is another robot, or one that was taken apart. motions:
    those of all its joints' frames."""

    variant: str = "geometry anew"
    motions: float = 36.0

    settings: ClassVar[tuple[str, ...]] = ("size", "others", "motions")
    variable: ClassVar[str] = "the campaign: the geometry of the robot is not the same in all"

    @property
    def functions(self) -> int:
        return int(self.others * self.motions)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        return each(range(6, 6 + int(self.motions)), self._before_last(problem))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        others = _others(problem)
        return [cls(others=others, motions=6.0 * problem.arm.n)] if 0 < others <= MOST else []


def _centre(mass: Array, error: float, moment: Array, std: Array, stated: Array) -> tuple[Array, Array]:
    """Centres of mass (k, 3) [m] and their standard deviations, of masses (k, 1) ± error [kg] with first
    moments (k, 3) ± std (3,) [kg·m], by what is usual: within `LEVER` of where they are stated. What the data
    do not determine stays there."""
    seen, usual = std**-2.0, (LEVER * mass) ** -2.0
    best = (seen * moment + usual * mass * stated) / (seen + usual) / mass
    return best, np.hypot((seen + usual) ** -0.5, best * error) / mass


def _others(problem: Problem) -> float:
    """Number of set-ups but the last; 0 of a single campaign, whose robot stays what it is."""
    campaign = problem.campaign
    return float(len(campaign.setup_names) - 1) if campaign.beside else 0.0


@dataclass(frozen=True)
class CarriedAnew(BySetup, LoadEffect):
    """In one of several campaigns the arm carries something else than is stated there: mass and first moment
    at the flange, in all its poses. usual: [kg] that such an arm carries; size: over that."""

    variant: str = "carried anew"
    size: float = 1.0
    usual: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "usual")
    functions: ClassVar[int] = 4

    @property
    def params(self) -> tuple[Param, ...]:
        mass = self.size * self.usual
        first = [Param(f"moment_{a}", "kg·m", LEVER * mass, spread=LEVER * mass) for a in "xyz"]
        return (Param("mass", "kg", mass, "added to the stated mass", spread=mass), *first)

    @property
    def variable(self) -> str:
        return f"the campaign: what the arm carries in {self.where.payload} is not what is stated"

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        std = float(np.sqrt(covariance[0, 0]))
        return (Parameter("mass", float(values[0]), std, "kg", "over the stated mass"),)

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        here = self._here(problem)
        moment = loads.moment + np.outer(here, values[1:])
        return arm, replace(loads, mass=loads.mass + here * values[0], moment=moment)

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        here, flange = self._here(problem), problem.arm.slots - 1
        unit = np.eye(4)[:, None] * here[:, None]
        return np.stack([mass_wrench(problem, where, flange, one[:, 0], one[:, 1:]) for one in unit], axis=-1)

    def as_it_was(self, problem: Problem, values: Array, std: Array) -> Recorded | None:
        """With what the arm carried in the set-up, each of its loads as one named after it. None where that
        would be less than nothing, farther from the flange than anything is mounted, or nothing as stated."""
        c = problem.campaign
        there, setup = self._here(problem) > 0, str(self.where.payload)
        old = np.unique(c.poses.payload[there])
        mass = np.maximum(c.load_mass[old] + values[0], 0.0)
        less = c.load_mass[old] + values[0] < -SURELY * std[0]
        if less.any() or np.array_equal(mass, c.load_mass[old]):
            return None
        seen = c.load_mass[old, None] * c.load_com[old] + values[1:]
        com, off = _centre(np.maximum(mass, 1e-9)[:, None], std[0], seen, std[1:], c.load_com[old])
        com = np.where(mass[:, None] > 0, com, 0.0)
        if (np.linalg.norm(com, axis=1) > FARTHEST + SURELY * np.linalg.norm(off, axis=1)).any():
            return None
        names = [f"{name} ({setup})" if (name := c.payload_names[i]) else f"load ({setup})" for i in old]
        new = len(c.payload_names) + np.searchsorted(old, c.poses.payload)
        campaign = replace(
            c,
            payload_names=(*c.payload_names, *names),
            load_mass=np.append(c.load_mass, mass),
            load_com=np.vstack([c.load_com, com]),
            poses=replace(c.poses, payload=np.where(there, new, c.poses.payload)),
        )
        if len(old) > 1:
            kg = f"{abs(values[0]):.3g} kg (± {std[0]:.2g} kg) {'less' if values[0] < 0 else 'more'}"
            what = f"with each of its loads the arm carries {kg} than stated in {setup}"
        else:
            said = f"{mass[0]:.3g} kg (± {std[0]:.2g} kg)"
            if mass[0] > SURELY * std[0] and (std[1:] < LEVER * mass[0]).all():
                centre = ", ".join(f"{round(1e3 * along)}" for along in com[0].tolist())
                said += f", centred {centre} mm from the flange,".replace("-", "\N{MINUS SIGN}")
            beside = " beside its tool" if c.tool_mass > 0 else ""
            stated = f"{c.load_mass[old[0]]:g} kg are stated{beside}"
            what = f"the arm carries {said} in {setup}, where {stated}"
        return Recorded("changed_load", campaign, [(c.setup_names.index(setup), what)], CARRIED)

    def _here(self, problem: Problem) -> Array:
        """(N,) 1 in the poses of the set-up."""
        names, setup = problem.campaign.setup_names, problem.campaign.poses.setup
        return np.asarray(setup == names.index(str(self.where.payload)), dtype=float)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        """Every set-up of several campaigns, but those whose poses are just those of a stated load: then that
        load is not as stated. Of arms with masses: others yield to none."""
        c = problem.campaign
        if not _others(problem) or not problem.arm.weighed:
            return []
        usual = max(usually_mounted(problem), float(c.load_mass.max(initial=0.0)))
        of_loads = [c.poses.payload == i for i in np.unique(c.poses.payload) if c.load_mass[i] > 0]
        out = []
        for k, name in enumerate(c.setup_names):
            here = c.poses.setup == k
            if here.any() and not any(np.array_equal(here, carried) for carried in of_loads):
                out.append(cls(Where(payload=name), usual=usual))
        return out
