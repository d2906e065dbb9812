"""The campaign as arrays: what the robot was told, beside what the instrument saw. SI units."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from shlex import quote

import numpy as np
from numpy.typing import NDArray

from ..robot.description import Robot
from .cell import CellData
from .known import KnownData, and_told
from .poses import Array, Column, IntArray, Poses


@dataclass(frozen=True)
class Target:
    """What the instrument looks at. `xyz`: nominal place in the frame of `on`, None = unknown.

    `on` is "flange", "base" or the name of a link; `fixed`: the place is not re-fitted.
    opens: direction into which its reflector opens, in that frame; None = not said.
    """

    name: str
    xyz: tuple[float, float, float] | None = None
    on: str = "flange"
    fixed: bool = False
    opens: tuple[float, float, float] | None = None


TOOL = "tool"
SAME = 1e-6  # m, and share of a mass: to which a tool is the same one


def after(setup: str) -> str:
    """How the name begins that the later part of a set-up has."""
    return f"{setup or 'setup'} after pose "


def begins(setup: str, label: str) -> bool:
    """Whether a set-up is of the campaign with that label; of a campaign without one it is."""
    return not label or setup == label or setup.startswith((f"{label}/", after(label)))


@dataclass(frozen=True, eq=False)
class Campaign:
    """Measured or simulated data of one robot. N poses, n joints, T targets, P payloads.

    Every pose has at least one measured target, and every target was measured at least once.

    poses             what the robot was told
    payload_names     "" (the tool only) and the payloads
    load_mass         (P,), load_com (P, 3): the payload itself without the tool, flange frame
    tool_mass         always mounted, tool_com (3,) in the flange frame
    setup_names       ("" when the file names none)
    points            (N, T, 3) mean of the shots, instrument frame; NaN = not seen
    shots             (N, T) number of shots behind each mean
    sigma             (N, T, 3) one sigma of the mean, NaN where not seen; None: not stated per
                      point. Where given it counts, not noise_sigma
    shot_scatter      sum of squares of the shots about their means over all axes [m²], and its
                      degrees of freedom
    of_rows           the shots had rows of poses of their own: the arm may have gone away between them
    noise_sigma       one sigma per axis of one shot, stated for all; None: not stated
    six_dof           the targets of a pose are points of one 6-D measurement
    files             "<folder>/<file>" -> sha256
    known             facts of other sources, not yet looked up in the robot; its scale is in the points
    cell              what stands around the robot, for plans
    beside            the files of further campaigns that are in it; told: facts that its file does not have,
                      as `--known` takes them
    labels            what several campaigns that are in it are called, as their set-ups begin; silent: of
                      those that state no noise beside others that do, whose sigma is a guess;
                      shown: of such whose sigma is measured
    mounted           the payload that is the tool mounted now, where tools are payloads; "": `tool_mass`
    """

    title: str
    path: Path
    robot: Robot
    poses: Poses
    payload_names: tuple[str, ...]
    load_mass: Array
    load_com: Array
    tool_mass: float
    tool_com: Array
    setup_names: tuple[str, ...]
    targets: tuple[Target, ...]
    points: Array
    shots: IntArray
    sigma: Array | None = None
    shot_scatter: tuple[float, int] = (0.0, 0)
    of_rows: bool = False
    noise_sigma: float | None = None
    six_dof: bool = False
    warnings: tuple[str, ...] = ()
    files: dict[str, str] = field(default_factory=dict)
    known: KnownData = field(default_factory=KnownData)
    cell: CellData = field(default_factory=CellData)
    beside: tuple[Path, ...] = ()
    told: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    silent: tuple[str, ...] = ()
    shown: tuple[str, ...] = ()
    mounted: str = ""

    @property
    def arguments(self) -> str:
        """The campaign as a command names it: its files, and what was said besides."""
        files = [str(path) for path in (self.path, *self.beside)]
        return " ".join(quote(one) for one in [*files, *(x for fact in self.told for x in ("--known", fact))])

    @property
    def tool_name(self) -> str:
        """What is always mounted, stated or not, as a place of causes; a payload may have the name."""
        name = TOOL
        while name in self.payload_names:
            name += " (always mounted)"
        return name

    @property
    def payloads(self) -> dict[str, tuple[float, Array]]:
        """Mass [kg] and centre of mass (3,) [m, flange frame] of each payload, as stated."""
        loads = zip(self.load_mass.tolist(), self.load_com, strict=True)
        return dict(zip(self.payload_names[1:], list(loads)[1:], strict=True))

    def load(self, name: str) -> tuple[float, Array] | None:
        """Mass [kg] and centre of mass (3,) [m, flange frame] of a payload or the tool, as stated."""
        tool = (self.tool_mass, self.tool_com) if name == self.tool_name else None
        return self.payloads.get(name, tool)

    def has_load(self, name: str, mass: float, com: Sequence[float] | Array) -> bool:
        """Whether what was found of a load holds here: of the payload or the tool of this name that has this
        mass [kg] and centre of mass (3,) [m, flange frame]; of a payload, alone or with the tool, as
        campaigns with other tools are joined."""
        own = self.load(name)
        if own is None:
            return False
        loads = [own]
        if name != self.tool_name and self.tool_mass > 0:
            total = own[0] + self.tool_mass
            loads.append((total, (own[0] * own[1] + self.tool_mass * self.tool_com) / total))
        return any(
            abs(mass - one) <= SAME * mass and (not mass or np.allclose(com, place, rtol=0, atol=SAME))
            for one, place in loads
        )

    def has_as_in(self, other: Campaign, payload: str | None) -> bool:
        """Whether what was found of a load in another campaign holds here (`has_load`); of none it does."""
        if payload is None:
            return True
        load = other.load(payload)
        return load is not None and self.has_load(payload, *load)

    def __repr__(self) -> str:
        loads = f", payloads {', '.join(self.payload_names[1:])}" if len(self.payload_names) > 1 else ""
        noise = "" if self.noise_sigma is None else f", noise {1e3 * self.noise_sigma:g} mm"
        targets = ", ".join(target.name for target in self.targets)
        seen = f"{self.n_poses} poses, {self.n_points} points of {targets}"
        return f"Campaign {self.title!r} of {self.robot.name}: {seen}{loads}{noise}"

    @cached_property
    def of_campaign(self) -> IntArray:
        """(N,) number of the campaign that each pose is of, where several are in it."""
        labels, of = self.labels or ("",), []
        for name in self.setup_names:
            own = [k for k, label in enumerate(labels) if begins(name, label)]
            of.append(max(own, key=lambda k: len(labels[k]), default=0))
        return np.array(of, dtype=np.int64)[self.poses.setup]

    @property
    def of_silent(self) -> dict[str, NDArray[np.bool_]]:
        """Of each campaign that states no noise beside others that do (N,) which poses are of it."""
        each = {label: self.of_label(label) for label in self.silent}
        return {label: here for label, here in each.items() if here.any()}

    def of_label(self, label: str) -> NDArray[np.bool_]:
        """(N,) whether each pose is of the campaign of that label."""
        return np.asarray(self.of_campaign == self.labels.index(label))

    @property
    def n_poses(self) -> int:
        return len(self.poses)

    @property
    def n_points(self) -> int:
        """Measured points, shots counted once."""
        return int(np.count_nonzero(self.shots))

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(N, T) which target was measured at which pose."""
        return self.shots > 0

    def some(self, chosen: NDArray[np.int64]) -> Campaign:
        """Only these poses, in this order."""
        return replace(
            self,
            poses=self.poses.some(chosen),
            points=self.points[chosen],
            shots=self.shots[chosen],
            sigma=None if self.sigma is None else self.sigma[chosen],
        )

    def looking_at(self, names: Collection[str]) -> Campaign:
        """Of its targets these alone."""
        kept = [t for t, target in enumerate(self.targets) if target.name in names]
        return replace(
            self,
            targets=tuple(self.targets[t] for t in kept),
            points=self.points[:, kept],
            shots=self.shots[:, kept],
            sigma=None if self.sigma is None else self.sigma[:, kept],
        )

    def measured(self) -> Campaign:
        """Of its poses, set-ups and targets those that have whole points, in their order."""
        seen = np.asarray(np.isfinite(self.points).all(axis=2))
        poses, targets = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
        out = self.some(poses).looking_at([self.targets[t].name for t in targets])
        setups, numbers = np.unique(out.poses.setup, return_inverse=True)
        names = tuple(self.setup_names[k] for k in setups)
        return replace(out.with_poses(setup=numbers.ravel().astype(np.int64)), setup_names=names)

    def with_known(self, texts: Sequence[str]) -> Campaign:
        """The campaign with what `--known` says besides. Raises InputError."""
        return replace(self, known=and_told(self.known, texts), told=(*self.told, *texts))

    def with_poses(self, **columns: Column) -> Campaign:
        """The campaign with other columns of its poses, by their names in `Poses`."""
        return replace(self, poses=replace(self.poses, **columns))  # type: ignore[arg-type]
