"""What an effect is: one cause at one place, and what the rest of the program may ask of it.

On the way from a command to a measured point an effect acts at one of these (`acts`):

    transmission   commanded joint → joint angle without load
    load           what pulls on the arm
    yielding       what gives way under the loads
    geometry       where the frames are, without load
    instrument     how the points are seen

`kinds.py` has one base class for each. Everything else that other rooms decide by is data of the effect:
what it depends on, whether it is smooth, always there, along its joint's own axis. Nobody asks for names.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads, Wrenches
from .drawn import Drawn
from .place import NOWHERE, Parameter, Where
from .recorded import Recorded

Acts = Literal["transmission", "load", "yielding", "geometry", "instrument"]
Depends = frozenset[
    str
]  # of "joints", "load", "side", "time", "temperature", "torque", "readback", "points", "payload", "setup"
NOTHING: Depends = frozenset()
UNKNOWN = "unknown"  # the cause of what has no name
SURELY = 3.0  # standard deviations of a prior at the bounds of what physics allows: nothing is beyond them
LARGE = 5e-3  # rad or m, from which a motion is said in thousandths


def short(size: float) -> str:
    """A size in a sentence: whole from 10 on, two digits below."""
    return f"{size:.0f}" if abs(size) >= 9.95 else f"{size:.2g}"


def grouped(size: float, digits: int) -> str:
    """A large size of so many digits, thousands apart, as tables of stiffness have it: `4 660 000`."""
    return f"{float(f'{size:.{digits}g}'):,.0f}".replace(",", "\N{NO-BREAK SPACE}")


def motion_said(size: float, sliding: bool = False) -> str:
    """A joint's motion [rad; sliding: m] in a sentence: `60 µrad`, from five thousandths on `16.4 mrad`."""
    unit = "m" if sliding else "rad"
    return f"{short(1e6 * size)} µ{unit}" if abs(size) < LARGE else f"{1e3 * size:.3g} m{unit}"


@dataclass(frozen=True)
class Param:
    """A parameter that is fitted. `typical` is its usual size, `lower`, `upper` what physics allows;
    `spread`: prior standard deviation of a weight of a free function, which nothing else holds."""

    name: str
    unit: str
    typical: float
    meaning: str = ""
    lower: float = -np.inf
    upper: float = np.inf
    spread: float | None = None


class Rest(Protocol):
    """The arm at rest under its loads: its frames, loads, wrenches and points (N, T, 3) [m] in the
    instrument's frame: true, and as this shows them."""

    @property
    def arm(self) -> Arm: ...
    @property
    def where(self) -> Frames: ...
    @property
    def loads(self) -> Loads: ...
    @property
    def load(self) -> Wrenches: ...
    @property
    def true(self) -> Array: ...
    @property
    def points(self) -> Array: ...


class Slopes(Protocol):
    """Derivatives of what is observed, R rows a pose, at rest: direct (N, R, 6 S) by slot motions, torque
    (N, R, E) by the local wrenches `rows`."""

    @property
    def prediction(self) -> Rest: ...
    @property
    def direct(self) -> Array: ...
    @property
    def torque(self) -> Array: ...
    @property
    def rows(self) -> NDArray[np.int64]: ...


@dataclass(frozen=True)
class Effect(ABC):
    """One cause at one place.

    cause: id of the cause. title: for people. called: what the field calls it, where its id does not say it
    (`called`). equation: typst mathematics. separate: rival cause → the
    measurement that tells it apart (in words, with the {fields} of `words`; `separation` reads both sides).
    variant: forms of the same cause share cause and place and differ in this; they are never each other's
    rivals. settings: names of
    the fields that are numbers but not fitted (a time constant, say); they are kept with the values in
    model.toml. ordered: `where` needs an order. together: the variants are parts of one law that may be
    off at once. pure: some are quite true to their form, as a wrong number in a controller is: they
    compete without companions as well. nearly: some are nearly that: they compete with a fraction of them as
    well. depends: what any form of it depends on (one form: `uses`). smooth: a smooth function of its joint's
    angle, so that several of them can draw any such function.
    always: every machine has it, whether its model states it or not. axial: it moves its joint along the
    joint's own axis, and nothing else. by_motor: of that, it is a sum of functions of one motor's angle each.
    as_rounded: the rounding of a joint's written values may look like it.
    by_loads: it is how an arm bends under its loads, or may be;
    in_proportion: to them, by one number. held: prior standard deviation of its numbers, where what was found
    elsewhere in the arm holds them.
    dated: a state of the robot in earlier campaigns, nothing in the last.
    in_drake: how a campaign simulated in Drake has it. wholes: what other instruments measure of it, the
    whole of a quantity from which the parameter is the model's difference → its unit (`of_whole`); reading:
    how that is done, as `separate` has it, which is not asked for where it was done.
    """

    where: Where = NOWHERE
    variant: str = ""
    held: float = field(default=np.inf, kw_only=True, compare=False, repr=False)

    cause: ClassVar[str]
    title: ClassVar[str]
    called: ClassVar[str] = ""
    equation: ClassVar[str] = ""
    separate: ClassVar[Mapping[str, str]] = {}
    settings: ClassVar[tuple[str, ...]] = ()
    ordered: ClassVar[bool] = False
    pure: ClassVar[bool] = False
    nearly: ClassVar[bool] = False
    together: ClassVar[bool] = False
    acts: ClassVar[Acts]
    depends: ClassVar[Depends]
    smooth: ClassVar[bool] = False
    always: ClassVar[bool] = False
    axial: ClassVar[bool] = False
    by_motor: ClassVar[bool] = True
    by_loads: ClassVar[bool] = False
    as_rounded: ClassVar[bool] = False
    in_proportion: ClassVar[bool] = False
    dated: ClassVar[bool] = False
    in_drake: ClassVar[str]
    wholes: ClassVar[Mapping[str, str]] = {}
    reading: ClassVar[str] = ""

    @property
    @abstractmethod
    def params(self) -> tuple[Param, ...]:
        """The fitted parameters, in the order of `values`."""

    @property
    def local(self) -> bool:
        """Whether it says nothing of its joint beyond where that was measured: no law carries it there."""
        return False

    @property
    def uses(self) -> Depends:
        """What this form depends on."""
        return self.depends

    @property
    def form(self) -> str:
        """What tells it from the other forms of its cause, in words."""
        return self.variant

    @property
    def shape(self) -> str:
        """Its form without the number behind it: settings of one shape share what is likely of it."""
        name, _, number = self.variant.rpartition(" ")
        return name or number

    @property
    def kin(self) -> Hashable:
        """What it has in common with other causes that differ from it by how they are likely to look alone;
        None: nothing."""
        return None

    @property
    def stated(self) -> bool:
        """Whether the robot's model has a number for it, from which this one differs."""
        return False

    @property
    def is_held(self) -> bool:
        """Whether it is there because of others of its kind, which hold its numbers."""
        return bool(np.isfinite(self.held))

    @property
    def free(self) -> bool:
        """Whether it is a free function: its numbers are weights, each held by a spread."""
        return all(p.spread is not None for p in self.params)

    @property
    def rare(self) -> bool:
        """Whether only some machines have it."""
        return False

    @property
    def whole(self) -> bool:
        """Whether it may be there without the other forms that it comes together with."""
        return True

    @property
    def part(self) -> str:
        """Of forms that come together, those of one part of the machine may be off without the others."""
        return ""

    def as_it_was(self, problem: Problem, values: Array, std: Array) -> Recorded | None:
        """The campaign as it was with weights (p,) of it, known to std (p,), where it is how things were
        written down and nothing of the arm; None elsewhere."""
        return None

    @property
    def lasting(self) -> bool:
        """Whether it is the robot's own, and there in other campaigns as well."""
        return True

    def prior(self, problem: Problem) -> Array:
        """(p,) prior standard deviations of the parameters: their spread, a third (`SURELY`) of what physics
        allows, or else a thousand usual sizes. Parts that the data do not show stay where a machine can be, a
        coarse one farther off."""
        allowed = np.array([max(-p.lower, p.upper) for p in self.params]) / SURELY
        typical = np.array([p.typical for p in self.params])
        spread = np.array([np.nan if p.spread is None else p.spread for p in self.params])
        sized = np.where(np.isfinite(spread), spread, 1e3 * typical) * problem.coarse
        usual = np.where(np.isfinite(spread) | ~np.isfinite(allowed), sized, allowed)
        return np.asarray(np.minimum(usual, self.held))

    @classmethod
    def unmeasured(cls, problem: Problem, kelvin: Array, found: bool) -> Mapping[int, Array]:
        """Column 6 · slot + component → (N, k) one sigma of k motions [m, rad] that nothing measured says, in
        poses `kelvin` (N,) warmer than any that were. found: what one number says of it is known."""
        return {}

    def finer(self) -> Sequence[Effect]:
        """The same effect with other settings, to choose from once it is accepted."""
        return ()

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """How far a real machine may be off the form: further effects, each with its share of this one (of
        their own usual size)."""
        return ()

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """The same of what only some machines have besides: a form of its own of the cause."""
        return ()

    def sized(self, scale: float) -> Effect:
        """The same effect, `scale` times as large as usual: matters where weights have a spread."""
        return self

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        """Why this campaign cannot show the cause at all; None when it can."""
        return None

    @classmethod
    @abstractmethod
    def sites(cls, problem: Problem) -> Sequence[Effect]:
        """Every place (and variant) that may be tested on this problem."""

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Effect]:
        """Every place where it can sit, whether this campaign would show it or not."""
        return cls.sites(problem)

    # ------------------------------------------------ what it does, N poses, S slots, p parameters

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        """Column 6 · slot + component → (N, p) motion without load [m, rad] per unit of each parameter."""
        return {}

    def ends(self, problem: Problem) -> Mapping[int, Array]:
        """Column 6 · slot + component → (N,) one sigma of the motion [m, rad] that the parameters do not
        have, where a pose is beyond what was measured of a function that ends there."""
        return {}

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        """Arm and loads with the effect in them."""
        return arm, loads

    def seen(self, problem: Problem, points: Array) -> Array:
        """(N, T, 3, p) change of the points (N, T, 3) [m] in the instrument's frame per unit."""
        return np.zeros((*points.shape, len(self.params)))

    @abstractmethod
    def jacobian(self, problem: Problem, line: Slopes, values: Array) -> Array:
        """(N, R, p) change of what is observed per unit of each parameter."""

    def of_joint(self, problem: Problem) -> tuple[int, Array] | None:
        """Of an error of one joint's angle without load: the joint's number, and (N, p) its motion [rad, m]
        per unit of each parameter. None of other effects."""
        return None

    def pulled(self, problem: Problem, line: Slopes) -> Array | None:
        """Of a load: (N, S, 6, p) change of the local wrenches per unit of each parameter. None of others."""
        return None

    def under(self, line: Slopes, wrench: Array, values: Array) -> Array | None:
        """Of what yields: (N, R, p) motion of what is observed per unit of each parameter, were the local
        wrenches (N, S, 6) these. None of others."""
        return None

    def yields_to(self, line: Slopes, wrench: Array, values: Array) -> Array | None:
        """Of what yields: (N, R, p) motion of what is observed by its yield to more wrenches (N, S, 6, p), to
        first order. None of others."""
        return None

    def lever(self, arm: Arm) -> float:
        """Of what yields across its joint: how far it moves, as drawn, where it is as usual of robots as a
        tilt by 1 rad is of a bearing."""
        return 1.0

    @abstractmethod
    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """The effect over what it depends on."""

    # ------------------------------------------------------------------ how it is said

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        """The parameters as people know them, from the fitted ones (p,), (p, p)."""
        std = np.sqrt(np.diag(covariance))
        return tuple(
            Parameter(p.name, float(v), float(s), p.unit, p.meaning)
            for p, v, s in zip(self.params, values, std, strict=True)
        )

    def reported_size(self, size: float) -> tuple[float, str]:
        """A size of the first parameter [its unit], and its unit, as `report` has them."""
        return size, self.params[0].unit

    def beside(self, others: Iterable[tuple[Effect, Array]]) -> Effect:
        """The same effect as it is said where these, each with its values (p,), were found as well."""
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The names that `given` understands."""
        return tuple(p.name for p in self.params)

    def given(self, numbers: Mapping[str, float]) -> Array:
        """The fitted parameters (p,) from numbers by name: `report` the other way round."""
        return np.array([numbers.get(p.name, 0.0) for p in self.params])

    def of_whole(self, problem: Problem, name: str, value: float, warmth: float) -> float | None:
        """The parameter from one of `wholes`, measured `warmth` [K] over 20 °C; None where the model has no
        such number to differ from."""
        return None

    def sentence(self, values: Array) -> str:
        """What was found, for a busy engineer."""
        return ""

    @classmethod
    def words(cls, where: Where, problem: Problem | None) -> Mapping[str, str]:
        """What the {fields} of `separate` are at a place of a robot (None: of any)."""
        if problem is None or where.joint is None:
            return {"range": "its whole range, a full turn where it can"}
        data = problem.robot.joints[problem.joint(where.joint)]
        if data.kind == "prismatic" or not np.isfinite(data.upper - data.lower):
            return {"range": "its whole range"}
        low, high = np.degrees([data.lower, data.upper])
        ends = f"{low:.0f} … {high:.0f}°".replace("-", "\N{MINUS SIGN}")
        return {"range": f"its whole range, {ends}"}

    @property
    def bounded(self) -> bool:
        """Whether a number surely outside its lower and upper is no such cause, whatever it is."""
        return False

    @property
    def key(self) -> tuple[str, Where]:
        """Cause and place, without form: what the verdict is about."""
        return self.cause, self.where.any_order

    @property
    def heading(self) -> str:
        """Its title at its place."""
        return self.title

    @property
    def label(self) -> str:
        where = str(self.where)
        return f"{self.cause}({where})" if where else self.cause
