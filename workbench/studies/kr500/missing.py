"""What constant stiffness lacks: what a diagnosis says, and how large each cause would have to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench import (
    Array,
    Campaign,
    Effect,
    Model,
    Outcome,
    Robot,
    Table,
    catalogue,
    diagnose,
    load_robot,
    loaded,
    numbers,
    problem_of,
    record,
    two_steps,
    write_model,
)

from .loads import Case
from .printed import ERRORS
from .protocol import at

TOO_LITTLE = 1e-6  # m: so little motion per typical size says nothing of a stiffness


def diagnosed(case: Mapping[str, Case], quick: bool, seed: int) -> dict[tuple[str, str], Outcome]:
    """By true robot and by the cells whose points are measured."""
    cuts = [("a", "2"), ("b", "2")] + ([] if quick else [("b", "constant"), ("b", "16")])
    return {(name, cut): diagnose(at(case[name].data, cut), seed=seed) for name, cut in cuts}


def extended(path: Path, found: Outcome) -> Robot:
    """The diagnosed robot, standing where the instrument is known to stand, written and read."""
    fit, problem = found.fit, found.problem
    records = [record(e, v) for e, v in zip(fit.model.effects, fit.state.values, strict=True)]
    write_model(
        path, loaded(problem.robot, problem.campaign), two_steps.seated(problem.arm, fit.state), records
    )
    return load_robot(path)


def diagnosis_table(outcomes: Mapping[tuple[str, str], Outcome]) -> Table:
    """Verdicts by true robot and by the cells whose points were measured."""
    lines = []
    for (case, _), one in outcomes.items():
        d = one.diagnosis
        known = [cause for cause in d.causes if not cause.label.startswith("unknown")]
        causes = [_named(c.label) + ("" if c.status == "named" else " (not alone)") for c in known]
        verdict, left = numbers.words(d.verdict), numbers.p_value(d.remainder_p)
        lines.append([f"({case})", str(d.n_poses), verdict, "; ".join(causes) or "none", left])
    head = ("Truth", "Records", "Verdict", "Causes found", "What is left")
    return Table("What a diagnosis says of the same measurements", head, lines, numbers=(1,))


@dataclass(frozen=True)
class Left:
    """An effect of the size that leaves a wanted mean error [m] beside refitted stiffness.

    size: of its first parameter; times: its typical size; raw: [m] mean deflection with it.
    """

    effect: Effect
    size: float
    times: float
    raw: float


def candidates(measured: Campaign, check: Campaign, most: int = 8) -> Table:
    """How large the causes that yield under load would have to be, to leave what the paper's fit leaves: each
    at its best form, first those that are least above their usual size."""
    floor = 1e-3 * ERRORS["128"][0]  # the paper's noise at the most
    wanted = float(np.sqrt((1e-3 * ERRORS["constant"][0]) ** 2 - floor**2))
    kinds = [k for k in catalogue().values() if k.acts == "yielding" and k.cause != "joint_compliance"]
    sites = [site for kind in kinds for site in kind.sites(problem_of(measured))]
    best: dict[str, Left] = {}
    for one in left_over(measured, check, sites, wanted):
        best.setdefault(one.effect.label, one)
    lines = [
        [
            _named(label),
            numbers.size(one.size, one.effect.params[0].unit),
            f"{numbers.significant(one.times, 2)} ×",
            numbers.mm(1e3 * one.raw),
        ]
        for label, one in list(best.items())[:most]
    ]
    head = ("Cause", "Size that leaves it", "Of its usual size", "Mean without model, mm")
    return Table(f"What would leave {numbers.mm(1e3 * wanted)} mm beside constant stiffness", head, lines)


def left_over(measured: Campaign, check: Campaign, effects: Sequence[Effect], wanted: float) -> list[Left]:
    """For each effect that leaves anything: linear, stiffness refitted on `measured`, error on `check`.

    measured, check: plans, all poses without load first and then all of them with it.
    """
    rows, probe = _moved(measured, effects), _moved(check, effects)
    springs, out = slice(len(effects), None), []
    A, B = rows.by[:, springs], probe.by[:, springs]
    firm = np.linalg.norm(A, axis=0) > TOO_LITTLE
    for i, effect in enumerate(effects):
        k = np.linalg.lstsq(A[:, firm], rows.by[:, i])[0]
        left = (probe.by[:, i] - B[:, firm] @ k).reshape(-1, 3)
        mean, typical = float(np.linalg.norm(left, axis=1).mean()), effect.params[0].typical
        if mean * typical < 1e-3 * TOO_LITTLE:
            continue
        value = wanted / mean
        raw = probe.nominal + value * probe.by[:, i].reshape(-1, 3)
        out.append(Left(effect, value, value / typical, float(np.linalg.norm(raw, axis=1).mean())))
    return sorted(out, key=lambda one: one.times)


@dataclass(frozen=True, eq=False)
class _Moved:
    """(M, 3) [m] what the load moves the first target by, and (3M, E + n) the change of that per unit."""

    nominal: Array
    by: Array


def _moved(plan: Campaign, effects: Sequence[Effect]) -> _Moved:
    problem = problem_of(replace(plan, points=plan.points[:, :1], targets=plan.targets[:1]))
    model, half = Model(problem), len(problem.q) // 2
    line = model.linearise(model.in_base())
    every = [*effects, *catalogue()["joint_compliance"].sites(problem)]
    one = [model.effect_jacobian(line, e, np.zeros(len(e.params)))[..., 0] for e in every]
    by = np.stack([(rows[half:] - rows[:half]).ravel() for rows in one], axis=1)
    points = line.prediction.base[:, 0]
    return _Moved(points[half:] - points[:half], by)


def _named(label: str) -> str:
    """`lost_motion(joint 2)` as people write it: `lost motion, joint 2`."""
    return numbers.words(label).replace("(", ", ").rstrip(")")
