"""The question of each study put to a robot that was measured: a UR10 and a 6-D tracker (Landgraf 2021).

The measurements are not part of the workbench: a folder of campaigns is given to a study, or it says that
none was. Each question takes fits on half of the poses, in blocks, and errors on the other half.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ..campaign import load_campaign
from ..campaign.problem import Problem, problem_of
from ..effects import catalogue
from ..effects.base import Effect
from ..files.faults import Fault, InputError
from ..identification.cells import cells
from ..identification.fit import Fit, fit
from ..identification.model import Model
from ..identification.noise import Covariance
from ..report.numbers import decimals, mm, percent, significant
from ..report.study import Table
from ..robot.kinematics import Array
from .study_run import StudyRun

CAMPAIGN = "ur10-ipa"
BLOCK = 138  # poses, measured one after the other
LIFT = "shoulder_lift_joint"
CARRY = LIFT, "elbow_joint"
TITLE = "The same question on a measured robot"
STATED = 1e-5  # m, scatter of a coordinate at standstill, as its publisher measured it
ZERO = 5  # of a slot's corrections: about its joint's axis
GROUPS = 6  # of the angle, as in the KR 120's paper
CUTS = (1, 2, 1), (2, 4, 2), (4, 8, 4)
SURE = 3.0  # standard deviations
CHI2_5 = float(stats.chi2.isf(0.01, 5))
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Halves:
    """A measured campaign. first: (N,) the poses of every other block."""

    problem: Problem
    first: Mask

    def fitted(self, effects: Sequence[Effect] = (), used: Mask | None = None) -> Fit:
        """To the first half, or other poses; intervals are those of `STATED` noise."""
        at = self.first if used is None else used
        noise = Covariance(
            np.full(self.problem.seen.shape, STATED), np.zeros(self.problem.arm.n), np.ones(len(at))
        )
        return fit(Model(self.problem, tuple(effects)), noise=noise.without(~at))

    @property
    def counts(self) -> str:
        fitted = int(self.first.sum())
        return f"{fitted} poses fitted, errors on {len(self.first) - fitted} others"


def counterpart(name: str, run: StudyRun) -> Table:
    """The table of a study by its name; where no measurements are given, how to give them. Raises
    `InputError` where the folder that is given does not hold them."""
    if run.measured is None:
        row = ["not asked", f"--measured DIR asks it, of a folder with the campaign {CAMPAIGN}"]
        return Table(TITLE, ("UR10", ""), [row], "The measurements are not part of the workbench.", ())
    file = run.measured / CAMPAIGN / "campaign.toml"
    if not file.is_file():
        raise InputError(
            Fault(str(file), "is not there", "give the folder that holds it, or leave out --measured")
        )
    problem = problem_of(load_campaign(file))
    return ASKED[name](Halves(problem, np.arange(len(problem.q)) // BLOCK % 2 == 0))


def compliances(problem: Problem) -> list[Effect]:
    """Of the joints that carry the arm's weight."""
    return [site for site in catalogue()["joint_compliance"].sites(problem) if site.where.joint in CARRY]


def maps(problem: Problem, without: str = "") -> list[Effect]:
    """A free function of each joint's own angle, in waves."""
    every = catalogue()["joint_map"].sites(problem)
    return [site for site in every if site.variant == "waves" and site.where.joint != without]


def compliance_of(found: Fit, used: Mask) -> tuple[float, float, float]:
    """[rad/(N·m)] of the shoulder lift: compliance, its standard deviation by the stated noise, and by what
    the fit leaves of a coordinate of the poses that were used."""
    [number] = [
        i
        for i, effect in enumerate(found.model.effects)
        if effect.cause == "joint_compliance" and effect.where.joint == LIFT
    ]
    value, covariance = found.effect_values(number)
    std = float(np.sqrt(covariance[0, 0]))
    left = float(np.sqrt(np.nanmean(found.residual[used] ** 2)))
    return float(value[0]), std, std * max(left / STATED, 1.0)


def rms(residual: Array) -> float:
    """[mm] of errors (N, T, 3) [m]."""
    return 1e3 * float(np.sqrt(np.nanmean((residual**2).sum(axis=2))))


def micro(value: float) -> str:
    """Three digits of a millionth."""
    return significant(1e6 * value, 3)


def stiffness_twice(data: Halves) -> Table:
    """Does a compliance come out again within what the stated noise allows?"""
    rows, found = [], []
    for words, used in (("every other block", data.first), ("the other blocks", ~data.first)):
        value, std, left = compliance_of(data.fitted(compliances(data.problem), used), used)
        found.append((value, std, left))
        rows.append([words, str(int(used.sum())), *map(micro, (value, 1.96 * std, 1.96 * left))])
    values, stated, left_over = np.array(found).T
    apart = abs(values[0] - values[1])
    by_noise, by_rest = (apart / float(np.hypot(*each)) for each in (stated, left_over))
    head = (
        "Poses",
        "Number",
        "Compliance, µrad/(N·m)",
        "95 % by the stated noise, ±",
        "95 % by what is left, ±",
    )
    limit = "is not" if by_noise > SURE else "may be"
    note = (
        "UR10, compliance of the shoulder lift from gravity alone, all geometry free. The halves differ by "
        f"{decimals(by_noise, 1)} standard deviations of the stated noise ({decimals(1e6 * STATED, 0)} µm at "
        f"standstill), by {decimals(by_rest, 1)} of what the model leaves: the noise of a reading {limit} "
        "what limits such a stiffness."
    )
    return Table(TITLE, head, rows, note)


def gain_of_cells(data: Halves) -> Table:
    """What cells gain over one model, and what a model that lacks less gains."""
    used, others = data.first, ~data.first
    one = data.fitted()
    place = data.problem.rigid.p[-1]
    box = np.array([place.min(axis=0) - 1e-6, place.max(axis=0) + 1e-6])
    alone = rms(one.residual[others])
    rows, gains = [["geometry alone", "1", mm(alone), ""]], []
    for cut in CUTS:
        of = cells(box, cut).of(place)
        offset = np.zeros((int(np.prod(cut)), *one.residual.shape[1:]))
        for k in set(of[used].tolist()):
            offset[k] = np.nanmean(one.residual[used & (of == k)], axis=0)
        left = rms((one.residual - offset[of])[others])
        gains.append(1 - left / alone)
        rows.append(
            ["and an offset of its own in each cell", str(len(offset)), mm(left), percent(gains[-1], 0)]
        )
    effects = [*compliances(data.problem), *maps(data.problem)]
    whole = rms(data.fitted(effects).residual[others])
    gain = 1 - whole / alone
    rows.append(["and a function of each joint’s angle, and compliances", "1", mm(whole), percent(gain, 0)])
    more = (
        "More than any cells: what cells gain is no proof that parameters vary." if gain > max(gains) else ""
    )
    note = (
        f"UR10, {data.counts}, mm. Cells gain {percent(max(gains), 0)} at the most, functions of the joints’ "
        f"angles {percent(gain, 0)}. {more}"
    ).strip()
    return Table(TITLE, ("Model", "Cells", "Error on other poses, RMS mm", "Gain"), rows, note)


def compliance_by_angle(data: Halves) -> Table:
    """A compliance of its own at each of six ranges of a joint's angle: is it the joint's?"""
    problem = data.problem
    angle = problem.q[:, problem.robot.joint_names.index(LIFT)]
    ends = np.quantile(angle, np.linspace(0, 1, GROUPS + 1))
    rows, six = [], []
    for low, high in pairwise(ends):
        used = np.asarray((angle >= low) & (angle <= high))
        value, _, std = compliance_of(data.fitted(compliances(problem), used), used)
        six.append((value, std))
        low_deg, high_deg = (decimals(float(np.degrees(end)), 0) for end in (low, high))
        rows.append([f"{low_deg} to {high_deg}°", str(int(used.sum())), micro(value), micro(1.96 * std)])
    value, std = np.array(six).T
    chi2 = float((((value - np.average(value, weights=std**-2)) / std) ** 2).sum())
    differ = "differ by more than their intervals" if chi2 > CHI2_5 else "agree within their intervals"
    note = (
        "UR10, whose joint has no gravity compensator: compliance of the shoulder lift from gravity, each "
        f"range with a geometry of its own, 95 % by what is left. The six {differ} "
        f"(χ² = {decimals(chi2, 0)}, 5 dof)."
    )
    return Table(TITLE, ("Shoulder lift", "Poses", "Compliance, µrad/(N·m)", "95 %, ±"), rows, note)


def yield_or_gear(data: Halves) -> Table:
    """Can poses under one load tell a joint's yield from its gear?"""
    problem = data.problem
    models: Mapping[str, list[Effect]] = {
        "geometry alone": [],
        "and compliances": compliances(problem),
        "and functions of all joints but the shoulder lift": [*compliances(problem), *maps(problem, LIFT)],
        "and of the shoulder lift": [*compliances(problem), *maps(problem)],
    }
    rows, half = [], []
    for words, effects in models.items():
        one = data.fitted(effects)
        row = [words, mm(rms(one.residual[~data.first])), "", ""]
        if effects:
            value, _, std = compliance_of(one, data.first)
            half.append(1.96 * std)
            row[2:] = [micro(value), micro(half[-1])]
        rows.append(row)
    head = ("Model", "Error on other poses, RMS mm", "Compliance, µrad/(N·m)", "95 %, ±")
    wider = half[-1] / half[-2]
    hard = ": under one load yield and gear are hard to tell apart here too" if wider > 2 else ""
    note = (
        f"UR10 with strain wave gears, compliance of the shoulder lift, {data.counts}. With a free function "
        f"of the shoulder lift’s own angle its interval is {decimals(wider, 1)} times as wide{hard}."
    )
    return Table(TITLE, head, rows, note)


def geometry_or_sag(data: Halves) -> Table:
    """Does a table of geometry hold sag?"""
    problem, others = data.problem, ~data.first
    alone, both = data.fitted(), data.fitted(compliances(problem))
    stiff = replace(both.state, values=tuple(np.zeros_like(value) for value in both.state.values))
    sag = both.model.predict(both.state) - both.model.predict(stiff)
    errors = [rms(one.residual[others]) for one in (alone, both)]
    moved, kept = rms(sag[others]), rms((alone.residual - both.residual)[others])
    shift = 1e3 * (alone.state.geometry - both.state.geometry)[1:-1, ZERO]
    rows = [
        ["error on other poses, geometry alone", f"{mm(errors[0])} mm"],
        ["… geometry and compliances", f"{mm(errors[1])} mm"],
        ["what the compliances move the points by", f"{mm(moved)} mm"],
        ["… of it not in the table of geometry alone", f"{mm(kept)} mm"],
        *(
            [f"zero of {name.replace('_', ' ')}, compliance left out", f"{decimals(float(s), 2)} mrad off"]
            for name, s in zip(problem.robot.joint_names, shift, strict=True)
            if name in CARRY
        ),
    ]
    taken = 1 - (kept / moved) ** 2
    holds = ": it holds sag" if taken > 0.5 else ""
    note = (
        f"UR10, {data.counts}; RMS. Of what the compliances move the points by, a table of geometry alone "
        f"takes up {percent(taken)} of the square{holds}."
    )
    return Table(TITLE, ("", "UR10"), rows, note)


ASKED: Mapping[str, Callable[[Halves], Table]] = {
    "cylindrical": stiffness_twice,
    "kr500": gain_of_cells,
    "kr120": compliance_by_angle,
    "rx170": yield_or_gear,
    "longlink": geometry_or_sag,
}
