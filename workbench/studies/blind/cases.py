"""A case of the study from its key alone: robot, campaign, and what is hidden in it.

Keys: `<cause>/<number>`, `pair/<number>`, `unknown-<kind>/<number>`, `clean-stated/<number>`,
`clean-repeats/<number>`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import Problem, problem_of
from ...effects import catalogue
from ...effects.base import Effect
from ...effects.place import ALL
from ...simulation.virtual_campaign import Truth, simulate
from . import loads, surroundings, transmission
from .designs import ROBOTS, Design, draw_design, draw_robot
from .hidden import Hidden, together
from .sight import Key, Products, Sight, candidates, clean, look, planned_for, seen_at
from .unknowns import UNKNOWNS

FORMS: dict[str, Callable[[Problem, Any, np.random.Generator], Hidden]] = {
    cause: getattr(file, cause)
    for cause in catalogue()
    for file in (transmission, loads, surroundings)
    if hasattr(file, cause)
}
NEEDS: dict[str, Set[str]] = {
    "backlash": {"direction"},
    "drift": {"time"},
    "payload": {"payload"},
    "readback_joints": {"readback"},
    "thermal_growth": {"temperature"},
    "tracker_scale": {"scale bar"},
}
NEED_COMPLIANCE = {"payload", "link_mass", "hose_torque"}  # seen only where joints yield
WEAKEST, STRONGEST = 20.0, 2000.0  # λ of one cause
WEAKEST_OF_TWO = 40.0
UNKNOWN_MM = (0.04, 0.12)  # rms at the tool that an unknown leaves after geometry
SCATTER = 0.45  # λ per coordinate from which scatter is more than a σ stated 10 % too small makes
ALIKE = 0.3  # share of λ that the catalogue's form may leave; mostly it is a few per cent
ATTEMPTS = 60


@dataclass(frozen=True)
class Case:
    """A case. judge: other poses of the true robot without noise. sight, products: what of it can be
    seen, by what (None where nothing is hidden); strength: λ of each thing hidden, given the others."""

    key: str
    design: Design
    hidden: tuple[Hidden, ...]
    sizes: tuple[float, ...]
    campaign: Campaign
    judge: Campaign
    sight: Sight
    products: Products | None
    strength: tuple[float, ...]
    robot: str
    unknown_mm: float | None = None

    @property
    def truths(self) -> list[Key]:
        """Cause and place of what is hidden, as far as it is in the catalogue."""
        return [item.effect.key for item in self.hidden if item.effect is not None]

    @property
    def form_left(self) -> float:
        """λ that the true causes leave in the catalogue's forms; all where there are none."""
        if self.products is None:
            return 0.0
        keys = self.products.keys()
        return self.products.left([k for key in self.truths for k in keys[key]])


def draw_case(key: str, seed: int, folder: Path) -> Case:
    """The case of a key. `folder` takes the files of a random robot, which must stay while it is used."""
    what, _, number = key.partition("/")
    if not number.isdigit() or not _known(what):
        raise ValueError(f"no case {key!r}: like gear_ratio/3, pair/0, unknown-slip/1, clean-stated/2")
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, crc32(key.encode()), attempt])
        case = _draw(key, what, rng, folder)
        if case is not None:
            return case
    raise RuntimeError(f"{key}: no design in {ATTEMPTS} shows it")


def _known(what: str) -> bool:
    kind, _, rest = what.partition("-")
    return what in FORMS or what == "pair" or (kind, rest in UNKNOWNS) == ("unknown", True) or kind == "clean"


def _draw(key: str, what: str, rng: np.random.Generator, folder: Path) -> Case | None:
    causes = [what] if what in FORMS else []
    stated = None
    if what == "pair":
        causes = [
            str(cause) for cause in rng.choice(sorted(set(FORMS) - {"tracker_scale"}), 2, replace=False)
        ]
    if what.startswith("clean"):
        stated = what == "clean-stated"
    if what == "unknown-memory":
        stated = True  # repeats would take it for noise
    possible = [kind for kind in ROBOTS if _can(kind, causes)]
    kind = str(rng.choice(possible))
    needs = {need for cause in causes for need in NEEDS.get(cause, ())}
    if causes == ["thermal_growth"] and rng.random() < 0.3:
        needs = {"clock only"}
    design = draw_design(draw_robot(kind, folder, rng), kind, needs, rng, stated)
    problem = problem_of(design.plan)
    hidden = _hide(problem, causes, what, rng)
    if hidden is None:
        return None
    seed = int(rng.integers(2**31))
    if what.startswith("unknown"):
        return _unknown(key, kind, design, hidden, seed, rng)
    return _case(key, kind, design, hidden, seed, rng)


def _can(robot: str, causes: list[str]) -> bool:
    if "gravity_compensator" in causes and robot != "kr500":
        return False
    return robot != "ur5" or not NEED_COMPLIANCE & set(causes)


def _hide(
    problem: Problem, causes: list[str], what: str, rng: np.random.Generator
) -> tuple[Hidden, ...] | None:
    """What is hidden, at any of its places; None where a cause has no place in this design."""
    if what.startswith("unknown"):
        return (UNKNOWNS[what.partition("-")[2]](problem, rng),)
    found = []
    for cause in causes:
        by_key: dict[Any, list[Effect]] = {}
        for effect in catalogue()[cause].sites(problem):
            if effect.variant == ALL or (cause == "bearing_tilt" and effect.rare):
                continue  # all masses of an arm, play of a bearing: robots drawn here have none such
            by_key.setdefault(effect.key, []).append(effect)
        if not by_key:
            return None
        places = list(by_key.values())[int(rng.integers(len(by_key)))]
        found.append(FORMS[cause](problem, places[int(rng.integers(len(places)))], rng))
    return tuple(found)


def _case(
    key: str, robot: str, design: Design, hidden: tuple[Hidden, ...], seed: int, rng: np.random.Generator
) -> Case | None:
    """A case whose hidden causes have the strengths that are drawn; None where they cannot."""
    sight = look(design, hidden, seed)
    sizes: list[float] = []
    if hidden:
        shifts = [sight.shift([item], [1.0]) for item in hidden]
        products = sight.products(shifts)
        weakest = WEAKEST if len(hidden) == 1 else WEAKEST_OF_TWO
        for i, item in enumerate(hidden):
            most = products.strength(i) * item.largest**2
            if not most > 1.2 * weakest or products.S[i, i] < 1e-6 * products.own[i]:
                return None
            strength = np.exp(rng.uniform(np.log(weakest), np.log(min(STRONGEST, most))))
            sizes.append(float(np.sqrt(strength / products.strength(i))))
    case = _measured(key, robot, design, hidden, sizes, seed, sight)
    return case if case.form_left < ALIKE * sum(case.strength) + 1e-9 else None


def _unknown(
    key: str, robot: str, design: Design, hidden: tuple[Hidden, ...], seed: int, rng: np.random.Generator
) -> Case | None:
    """A case with an unknown of a size that is drawn; None where a cause is like it, or noise hides it."""
    sight = look(design, hidden, seed, even=True)
    products = sight.products([sight.shift(hidden, [1.0])], candidates(sight, hidden))
    points = design.plan.points[..., 0].size
    mm = float(np.exp(rng.uniform(*np.log(UNKNOWN_MM))))
    strength = (mm * 1e-3 / design.sigma) ** 2 * points
    if products.S[0, 0] < 1e-6 * products.own[0] or strength < 150.0:
        return None
    if hidden[0].name == "memory" and strength < SCATTER * 3 * points:
        return None
    if min(products.left(k) for k in products.keys().values()) < 0.3 * products.S[0, 0]:
        return None
    size = float(np.sqrt(strength / products.S[0, 0]))
    return _measured(key, robot, design, hidden, [size], seed, look(design, hidden, seed), mm)


def _measured(
    key: str,
    robot: str,
    design: Design,
    hidden: tuple[Hidden, ...],
    sizes: list[float],
    seed: int,
    sight: Sight,
    mm: float | None = None,
) -> Case:
    """Measures the true robot, and looks at what can be seen of it."""
    plan = planned_for(design.plan, hidden, sizes)
    truth = true_robot(design, hidden, sizes)
    campaign = simulate(plan, truth, seed=seed, state_sigma=design.stated)
    judge = clean(design.judge, sight.truth, hidden, sizes, seed)
    products, strength = None, tuple[float, ...]()
    if hidden:
        sight = seen_at(sight, hidden, sizes)
        whole = sight.shift(hidden, sizes)
        each = zip(hidden, sizes, strict=True)
        single = [whole] if len(hidden) == 1 else [sight.shift([item], [size]) for item, size in each]
        strength = tuple(sight.products(single).strength(i) for i in range(len(hidden)))
        products = sight.products([whole], candidates(sight, hidden))
    return Case(key, design, hidden, tuple(sizes), campaign, judge, sight, products, strength, robot, mm)


def true_robot(design: Design, hidden: Sequence[Hidden], sizes: Sequence[float]) -> Truth:
    """What the robot of a design with something hidden in it is really like, and its instrument."""
    forms = [item.form(size) for item, size in zip(hidden, sizes, strict=True)]
    base = Truth(
        geometry=design.geometry,
        targets=design.targets,
        sigma=design.sigma,
        repeatability=design.repeatability,
    )
    return together(base, *forms)
