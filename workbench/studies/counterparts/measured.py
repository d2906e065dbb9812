"""A robot that was measured: its campaign, its parts that are fitted, how far a number can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ...campaign import load_campaign
from ...campaign.problem import Problem, problem_of
from ...effects import catalogue
from ...effects.base import Effect
from ...files.faults import Fault, InputError
from ...identification.fit import Fit, fit
from ...identification.model import Model, State
from ...identification.noise import Covariance
from ...identification.rows import moved
from ...robot.kinematics import Array
from .own_yield import OwnYield

BLOCKS = 20  # of poses measured one after the other: errors within a block may hang together
SCALE = 1e-4  # m, about what is left of a coordinate: how much the data weigh against the priors
WIDE = 100.0  # usual sizes of a function of a joint's angle that may be as large as any yield
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Known:
    """A campaign by the name of its folder. lift: the joint whose yield is asked for; carry: the joints that
    carry the arm's weight; noise: one sigma of a coordinate [m] as its publisher or the maker of the
    instrument states it, None where nobody does."""

    name: str
    words: str
    lift: str
    carry: tuple[str, ...]
    noise: float | None = None


UR = "shoulder_lift_joint", "elbow_joint"
CAMPAIGNS = (
    Known("ur10-ipa", "UR10", UR[0], UR, 1e-5),
    Known("ur5-tracker", "UR5", UR[0], UR, 3e-5),  # 15 µm + 6 µm/m at 2.5 m
    Known("iiwa7-payload0", "iiwa 7, two joints move", "joint_2", ("joint_2",)),
    Known("iiwa7-torque", "iiwa 7, all joints move", "joint_2", ("joint_2", "joint_4")),
)


@dataclass(frozen=True, eq=False)
class Estimate:
    """A fitted number. changes: (G,) of it where one block of poses is left out; std: by noise of `SCALE`;
    left: RMS of what the model leaves of a coordinate [m]."""

    value: float
    changes: Array
    std: float
    left: float

    def by(self, noise: float) -> float:
        """Half of its 95 % interval if nothing but noise [m] on a coordinate were the matter."""
        return 1.96 * self.std * noise / SCALE

    @property
    def half(self) -> float:
        """Half of its 95 % interval: from leaving out blocks, and not less than what is left would make."""
        return max(half_95(self.changes), self.by(self.left))

    def differs(self, other: Estimate) -> bool:
        """Whether another model of the same poses gives another value, by the blocks."""
        return abs(self.value - other.value) > half_95(self.changes - other.changes)


@dataclass(frozen=True, eq=False)
class Half:
    """A fit to half of the poses. out: (N,) the other half; residual: (M, T, 3) [m] of these."""

    state: State
    out: Mask
    residual: Array


@dataclass(frozen=True, eq=False)
class Measured:
    """A campaign that is known and was given."""

    known: Known
    problem: Problem

    @cached_property
    def block(self) -> NDArray[np.int64]:
        """(N,) number of each pose's block."""
        count = len(self.problem.q)
        return np.asarray(np.arange(count) * BLOCKS // count)

    @property
    def angle(self) -> Array:
        """(N,) [rad] of the joint that is asked for."""
        return self.problem.q[:, self.problem.joint(self.known.lift)]

    @property
    def yields(self) -> list[Effect]:
        """Of the joints that carry the arm's weight, that which is asked for first."""
        sites = {site.where.joint: site for site in OwnYield.sites(self.problem)}
        return [sites[joint] for joint in self.known.carry]

    def functions(self, wide: bool = False) -> list[Effect]:
        """A function of each joint's own angle, of a gear's usual size; wide: and one of any size of the
        joint that is asked for."""
        every = catalogue()["joint_map"].sites(self.problem)
        own = [s.sized(WIDE) for s in every if s.variant == "waves" and s.where.joint == self.known.lift]
        return [*(s for s in every if s.variant == "fine"), *(own if wide else [])]

    def fitted(self, effects: Sequence[Effect] = ()) -> Fit:
        """To all poses, all geometry free."""
        noise = Covariance(
            np.full(self.problem.seen.shape, SCALE), np.zeros(self.problem.arm.n), np.ones(len(self.block))
        )
        return fit(Model(self.problem, tuple(effects)), noise=noise)

    def halves(self, whole: Fit) -> tuple[Half, Half]:
        """What a fit to all poses becomes without the blocks of odd number, and without the others."""
        odd = self.block % 2 == 1
        first, second = (self._half(whole, ~kept) for kept in (~odd, odd))
        return first, second

    def _half(self, whole: Fit, out: Mask) -> Half:
        change = without(whole, out)
        state = moved(self.problem, whole.columns, whole.state, whole.line.centre, change)
        measured = np.where(self.problem.seen[..., None], self.problem.campaign.points, np.nan)
        return Half(state, out, (measured - whole.model.predict(state))[out])

    def estimate(self, whole: Fit, half: Half | None = None) -> Estimate:
        """The first number of the first effect, of the fit to all poses or to a half."""
        at = whole.columns.effect[0].start
        out = np.zeros(len(self.block), dtype=bool) if half is None else half.out
        value = float((whole if half is None else half).state.values[0][0])
        changes = [without(whole, out | (self.block == group))[at] for group in np.unique(self.block[~out])]
        std = float(np.sqrt(whole.effect_values(0)[1][0, 0] / (~out).mean()))
        left = float(np.sqrt(np.nanmean(whole.residual[~out] ** 2)))
        return Estimate(value, np.array(changes), std, left)

    def left_out(self, whole: Fit) -> Array:
        """(G, P) change of the fitted numbers where one block of poses is left out."""
        return np.array([without(whole, self.block == group) for group in range(BLOCKS)])


def without(whole: Fit, out: Mask) -> Array:
    """(P,) change of the fitted numbers where poses (N,) are left out: one linear step."""
    scale = whole.columns.prior
    part = (whole.J[out] * scale).reshape(-1, len(scale))
    H = whole.upper.T @ whole.upper - part.T @ part
    return np.asarray(-scale * np.linalg.solve(H, part.T @ whole.r[out].ravel()))


def held_out(halves: Sequence[Half]) -> float:
    """RMS error [mm] of the poses that each half leaves out."""
    return float(np.sqrt(np.mean([rms(half.residual) ** 2 for half in halves])))


def jackknife(changes: Array) -> Array:
    """(p, p) covariance of numbers from their changes (G, p) where one of G groups is left out: right also
    where errors within a group hang together (Kott 2001, Journal of Official Statistics 17, 521)."""
    count = len(changes)
    off = changes - changes.mean(axis=0)
    return np.asarray(off.T @ off * (count - 1) / count)


def half_95(changes: Array) -> float:
    """Half of the 95 % interval of a number from its changes (G,) where one of G groups is left out."""
    std = float(np.sqrt(jackknife(changes[:, None])[0, 0]))
    return float(stats.t.ppf(0.975, len(changes) - 1)) * std


def rms(error: Array) -> float:
    """[mm] of errors (N, T, 3) [m]."""
    return 1e3 * float(np.sqrt(np.nanmean((error**2).sum(axis=2))))


def load(folder: Path) -> tuple[list[Measured], list[str]]:
    """The campaigns that a folder holds, and the names of those that it lacks. Raises `InputError` where
    there is none."""
    files = {known: folder / known.name / "campaign.toml" for known in CAMPAIGNS}
    found = [Measured(k, problem_of(load_campaign(file))) for k, file in files.items() if file.is_file()]
    if not found:
        words = f"holds none of {', '.join(known.name for known in CAMPAIGNS)}"
        raise InputError(Fault(str(folder), words, "give the folder that does, or leave out --measured"))
    return found, [known.name for known, file in files.items() if not file.is_file()]
