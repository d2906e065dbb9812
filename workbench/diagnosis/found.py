"""What a diagnosis is made of: stages, findings and what would decide them, faults, noise, figures."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..effects.place import NOWHERE, Parameter, Where
from ..effects.recorded import DataFault

Array = NDArray[np.float64]
NAMELESS, GIVEN = "what has no name", "what was given"  # in a stage's name


@dataclass(frozen=True)
class Stage:
    """Errors of one stage, 3-D norms in mm. Held-out: on poses that it was not fitted on."""

    name: str
    parameters: int
    heldout_rms_mm: float
    heldout_mean_mm: float
    heldout_max_mm: float
    fit_rms_mm: float
    note: str = ""


@dataclass(frozen=True)
class Evidence:
    """What makes a cause visible: the residual against the variable that shows it.

    `x` (k,) in `x_unit`; `before` and `after` (k,) in `y_unit`: the part of the residual along the
    effect's own direction, without and with the cause in the model. `curve_x`, `curve_y`: the
    fitted effect as a line.
    """

    x_name: str
    x_unit: str
    y_name: str
    y_unit: str
    x: Array
    before: Array
    after: Array
    curve_x: Array
    curve_y: Array


@dataclass(frozen=True)
class Rival:
    """Another explanation of the same, with its probability. called: as of a finding."""

    cause: str
    where: Where
    probability: float
    called: str = ""


@dataclass(frozen=True)
class Decision:
    """What would decide between a finding and its rivals. command: ready to run; poses: how many settle it,
    or tell it from some of its rivals ("some_rivals"); lambda_before, lambda_after: how far apart the rivals
    are now, and after it (`measurement.design`)."""

    kind: Literal["poses", "drive_torque", "some_rivals", "reflectors", "reading", "other"]
    words: str
    command: str | None
    poses: int | None
    lambda_before: float
    lambda_after: float | None


@dataclass(frozen=True)
class Finding:
    """One cause of the verdict (or "unknown", then `structure` says what is left). probability: that it is
    this one, of all that competed; variant: its form, of several the one that shows most, where
    place and order do not say it; called: what the field calls it, where its cause does not say it; faint:
    rivals that are not worth a word, but would stand in the way of its name were the others gone;
    taken_back: it undoes what the robot's own model has of it; like: of what has no name, what it looks like
    in words, where that is known; of_campaigns: by the campaign, of several that are fitted as one robot."""

    cause: str
    title: str
    where: Where
    status: Literal["named", "ambiguous"]
    gain_mm: float
    probability: float
    variant: str = ""
    parameters: tuple[Parameter, ...] = ()
    rivals: tuple[Rival, ...] = ()
    faint: tuple[Rival, ...] = ()
    separate_by: str | None = None
    decide: tuple[Decision, ...] = ()
    structure: str | None = None
    sentence: str = ""
    taken_back: bool = False
    like: str = ""
    of_campaigns: bool = False
    equation: str = ""
    evidence: Evidence | None = None
    called: str = ""

    @property
    def ready(self) -> Decision | None:
        """Of what would decide the first that can be run."""
        return next((one for one in self.decide if one.command), None)

    @property
    def label(self) -> str:
        """As it stands in a stage's name: `gear_kinematic_error(joint_4)`."""
        where = str(self.where)
        return f"{self.cause}({where})" if where else self.cause


@dataclass(frozen=True)
class NotTestable:
    """A cause that this campaign cannot show, and why."""

    cause: str
    why: str
    where: Where = NOWHERE


@dataclass(frozen=True)
class GivenFact:
    """What `[known]` said, and what became of it. said: as it was said; given, seen, fitted: the parameter as
    given, by the data alone, and by both (None of a cause that was excluded); obeyed: kept to; differs: in
    words, where it is not what the model has and the data confirm that; exact: said without any spread."""

    cause: str
    where: Where
    said: str
    note: str = ""
    given: Parameter | None = None
    seen: Parameter | None = None
    fitted: Parameter | None = None
    obeyed: bool = True
    sentence: str = ""
    differs: str = ""
    exact: bool = False


@dataclass(frozen=True)
class Detectable:
    """Smallest size of a cause that this campaign would have shown with 80 % power.

    `name`: the parameter whose size it is; with the unit it says how people write the number.
    """

    cause: str
    where: Where
    size: float
    unit: str
    name: str = ""


@dataclass(frozen=True)
class FaultFound:
    """A data fault: its kind, the pose, and what was done about it."""

    kind: DataFault
    pose_id: str | None
    target: str | None = None
    what: str = ""
    done: str = ""

    def to_json(self) -> dict[str, Any]:
        """As it stands in JSON."""
        optional = {"target": self.target, "what": self.what, "done": self.done}
        return {
            "kind": self.kind,
            "pose_id": self.pose_id,
            **{key: value for key, value in optional.items() if value},
        }


@dataclass(frozen=True)
class Noise:
    """Noise that the tests used, one sigma per axis. `source`: stated, repeats or residual.
    repeatability_mm: what the points of a pose share, None where nothing; left_mm: what the fit leaves, where
    far more was stated."""

    sigma_mm: float
    source: Literal["stated", "repeats", "residual"]
    sentence: str = ""
    repeatability_mm: float | None = None
    left_mm: float | None = None

    @property
    def alone_mm(self) -> float:
        """What a point is off by in any case, one sigma per axis: its own noise, and what its pose shares."""
        return hypot(self.sigma_mm, self.repeatability_mm or 0.0)


@dataclass(frozen=True)
class OfCampaign:
    """One of several campaigns that are fitted as one robot: what it is called, RMS errors of its points in
    mm, 3-D norms, which the models were fitted on, and the noise that was used there, mm per axis.
    of_model: whose tool, zeros and scale the model has."""

    label: str
    n_poses: int
    n_points: int
    noise_mm: float
    noise_source: Literal["stated", "repeats", "residual"]
    nominal_mm: float
    geometry_mm: float
    after_mm: float
    of_model: bool


@dataclass(frozen=True)
class TestFigures:
    """Errors on the campaign of --test, in mm, 3-D norms; without its data faults, `all_`: with them.

    notes: what to know before they are believed; moved: set-ups that stand elsewhere than the fit has them,
    by how much, and the mean error that is left with their frame fitted anew.
    """

    __test__ = False  # not a pytest class

    campaign: str
    before_mean_mm: float
    after_mean_mm: float
    after_rms_mm: float
    after_max_mm: float
    before_max_mm: float
    n_points: int
    all_mean_mm: float
    all_rms_mm: float
    faults: tuple[FaultFound, ...] = ()
    notes: tuple[str, ...] = ()
    moved: tuple[tuple[str, float, float], ...] = ()


@dataclass(frozen=True)
class PoseErrors:
    """Per measured point, for figures and the scene. All in the robot's base frame, metres.

    `points`: (k, 3) measured places; `error_nominal`, `error_geometry`, `error_final`: (k, 3)
    measured minus predicted; `pose`: (k,) index of the pose; `target`: (k,) index of the target;
    `pose_ids`, `target_names`: what they are called in the campaign, by that index.
    """

    points: Array
    error_nominal: Array
    error_geometry: Array
    error_final: Array
    pose: NDArray[np.int64]
    target: NDArray[np.int64]
    pose_ids: tuple[str, ...] = ()
    target_names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Revealed:
    """What a simulation had hidden, and what was said of it. follow_up: what was measured after the first
    campaign, command: that planned it, a line for each follow-up, first: the page of what the first campaign
    had said; rows: hidden, said first, said at the end."""

    follow_up: str
    command: str
    first: str
    rows: tuple[tuple[str, str, str], ...]
