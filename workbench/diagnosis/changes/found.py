"""What a comparison is made of: what changed, what did not, and what stands apart from the robot."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ...effects.place import Parameter, Where

POSSIBLE = "possible"  # status of a change that may be none
STEP, BACK, CREEP, LEVELS = "step", "back", "creep", "levels"  # courses of a change over the campaigns

PLACED = 0.5  # of the likeliest's probability
PHASE = "phase"  # a number that comes round


@dataclass(frozen=True)
class Rival:
    """What explains the data as well; change: of the robot between campaigns, else common to all."""

    label: str
    cause: str
    where: Where
    change: bool
    side: str
    probability: float


@dataclass(frozen=True)
class Change:
    """What changed.

    side: robot, load, instrument or surroundings; status: named (probability from 0.95 on, and no rival that
    fits as well, number for number), ambiguous (something changed here) or possible (from 0.2 on; or where
    all poses surely show it and a half of them does not, the noise not explaining what is left); since:
    label of the first campaign with it; alone: only that has it; course: a step that stays, off and back
    again, creeping evenly to the last campaign, or another level at each; levels: of each campaign that
    has it, its label and the numbers against the first campaign; parameters: the same where it is off by
    most; before, after: these numbers themselves, where a sum's are not the sums (an amplitude); probability:
    of this, by the surest of its events; any: that something of the robot changed here; moves_mm: RMS of what
    it makes of the points, the instrument's frame fitted anew; recheck_poses: how many poses would show it
    again with 80 % power (None: more than were measured), recheck_ids: which.
    """

    label: str
    cause: str
    where: Where
    side: str
    status: str
    since: str
    alone: bool
    probability: float
    any: float
    parameters: tuple[Parameter, ...]
    moves_mm: float
    rivals: tuple[Rival, ...]
    recheck_poses: int | None = None
    recheck_ids: tuple[str, ...] = ()
    course: str = STEP
    levels: tuple[tuple[str, tuple[Parameter, ...]], ...] = ()
    before: tuple[Parameter, ...] = ()
    after: tuple[Parameter, ...] = ()

    @property
    def placed(self) -> bool:
        """Whether nothing else is far likelier in its place: else its numbers are of something unlikely."""
        return all(self.probability >= PLACED * rival.probability for rival in self.rivals)

    @property
    def change(self) -> bool:
        """It is one, as not every rival is."""
        return True

    @property
    def ways(self) -> tuple[Change | Rival, ...]:
        """What it may be, the likeliest first."""
        return tuple(sorted((self, *self.rivals), key=lambda way: -way.probability))


def bounds(within_mm: float, nominal_mm: float, changes: Iterable[Change]) -> bool:
    """Whether the bound of all other changes is less than the largest change of the robot that was found, and
    than what the nominal robot is off: else it says nothing."""
    found = [change.moves_mm for change in changes if change.side == "robot"]
    return within_mm < min([nominal_mm, *([max(found)] if found else [])])


@dataclass(frozen=True)
class Unchanged:
    """A number without a change. number: difference of the last campaign from those before; detectable:
    size that would have been seen with 80 % power [unit of the number]; to be named it may have to be
    larger, where another number does nearly the same, detectable_mm: RMS of what that makes of the points
    once frame and targets are fitted anew."""

    label: str
    cause: str
    where: Where
    side: str
    number: Parameter
    detectable: float
    detectable_mm: float


@dataclass(frozen=True)
class Unseen:
    """A number whose change these data cannot show; same_as: what it looks exactly like."""

    label: str
    same_as: str


@dataclass(frozen=True)
class Repeats:
    """An error of a joint or link that the campaigns show. status: repeats, changed, or not decided; share:
    95 % bound of its change over its size (RMS of the points)."""

    label: str
    status: str
    share: float


@dataclass(frozen=True)
class TargetMoved:
    """A target's place after minus before, on the axes of its link, one sigma each [mm]. moved: by more than
    chance; stated_mm: the same as the campaigns state it, None where both state one place, as_stated: the
    data agree; on: its link; may_be_warm: what carries it may have grown by as much."""

    target: str
    by_mm: tuple[float, float, float]
    std_mm: tuple[float, float, float]
    moved: bool
    stated_mm: tuple[float, float, float] | None
    as_stated: bool
    on: str
    may_be_warm: bool = False

    @property
    def off_stated_mm(self) -> float:
        """How far from where it should have moved to, as stated; from where it was if nothing is stated."""
        return math.dist(self.by_mm, self.stated_mm or (0.0, 0.0, 0.0))

    @property
    def restated(self) -> bool:
        """Whether it moved as stated, or nearer to there than it was: places are not stated to what an
        instrument tells of them."""
        stated = self.stated_mm is not None and self.off_stated_mm < math.hypot(*self.by_mm)
        return self.moved and (self.as_stated or stated)


@dataclass(frozen=True)
class Together:
    """Targets of a link that moved as one body. joint: whose zero would turn them so, to these data, if there
    is one; turn_mrad: by how much, with one sigma."""

    link: str
    targets: tuple[str, ...]
    joint: str | None
    turn_mrad: float
    turn_std_mrad: float


@dataclass(frozen=True)
class TargetsMoved:
    """each: the targets that both campaigns have; together: those that moved as one body."""

    each: tuple[TargetMoved, ...]
    together: tuple[Together, ...]

    @property
    def moved(self) -> tuple[TargetMoved, ...]:
        return tuple(one for one in self.each if one.moved)

    @property
    def alone(self) -> tuple[TargetMoved, ...]:
        """Those that moved, otherwise than stated and not with all of their link."""
        names = {name for one in self.together for name in one.targets}
        return tuple(one for one in self.moved if not one.restated and one.target not in names)

    @property
    def restated(self) -> tuple[TargetMoved, ...]:
        """Those that moved as it was stated."""
        return tuple(one for one in self.each if one.restated)


@dataclass(frozen=True)
class Scatter:
    """How much a campaign's points scatter by what the model leaves, one sigma per axis; times: that over the
    first campaign's, p_value: of as much by chance; rms_mm: RMS length of what is left."""

    sigma_mm: float
    std_mm: float
    times: float
    p_value: float
    rms_mm: float


@dataclass(frozen=True)
class Apart:
    """What is not the robot, at one campaign against the first. frame_mm, frame_mrad: shift in the middle
    of the points and turn between instrument and base, with one sigma; moves: where targets sit on the
    robot; sigma_mm, source: the noise as known; scatter: as the points show it; temperature:
    mean [°C]."""

    label: str
    frame_mm: float
    frame_std_mm: float
    frame_mrad: float
    frame_std_mrad: float
    moves: TargetsMoved
    sigma_mm: float
    source: str
    scatter: Scatter
    temperature: float | None

    @property
    def targets(self) -> tuple[TargetMoved, ...]:
        """Those that the first campaign has too."""
        return self.moves.each

    @property
    def targets_moved(self) -> bool:
        """Whether any sits elsewhere on the robot, as stated or not."""
        return bool(self.moves.moved)


@dataclass(frozen=True)
class Track:
    """A number over all campaigns, as its difference from the first."""

    label: str
    unit: str
    values: tuple[float, ...]
    stds: tuple[float, ...]
    limit: float
