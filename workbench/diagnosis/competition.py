"""From a prepared campaign to the causes that explain it: one competition of causes and free functions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..campaign.poses import Poses
from ..effects import line as gear_line
from ..effects.base import Effect
from ..identification.fit import Fit, fit, refit
from ..identification.noise import Covariance
from ..robot.kinematics import Array
from .components import Component, cause_components, free_components, line_component
from .families import Family, families, product_families
from .prepared import Prepared
from .priors import PRIORS
from .reduced import Index, Reduced, reduce
from .scan import HIGHEST, LOWEST, Line, scan
from .scatter import POSES_PER_JOINT, alike, positions, with_scatter
from .sets import Competition, Member, Shares

ROUNDS = 5
CLEARER = 4.0  # gain in χ² that moves a setting, or pays for a further number
LOOSE = 30.0  # usual sizes: a prior that holds nothing
MOST_SCATTERING = 2  # joints that are looked at for functions of two others
LEAST_LINE = 12.0  # χ²(2) of a peak of the scan from which it may compete


@dataclass(frozen=True, eq=False)
class Selection:
    """The likeliest set, strongest member first. fit: with its effects; shares: per member, the
    probability of each component in its place, None: of nothing. unrepeated: members that one half of the
    poses does not show; scatter: (n,) one sigma [rad, m] of the joints beyond the noise."""

    fit: Fit
    components: tuple[Component, ...]
    members: tuple[Member, ...]
    shares: tuple[Shares, ...]
    reduced: Reduced
    unrepeated: tuple[Member, ...]
    scatter: Array

    def worth_mm(self, member: Member) -> float:
        """RMS length [mm] of what a member makes of the points."""
        part = self.reduced.parts[member.component][member.form]
        index = np.arange(len(self.reduced.u))[part]
        S = self.reduced.S[np.ix_(index, index)]
        beta = np.linalg.solve(S + np.eye(len(index)) * member.scale**-2, self.reduced.u[index])
        sigma = float(np.sqrt(np.mean(self.fit.noise.sigma**2)))
        return 1e3 * sigma * float(np.sqrt(3 * (beta @ S @ beta) / self.reduced.dof))


def compete(prepared: Prepared, candidates: Sequence[Effect]) -> Selection:
    """The likeliest set of causes, gear lines and free functions."""
    geometry = prepared.geometry
    source = prepared.noise.source
    noise_dof = {"stated": PRIORS.noise_dof, "repeats": geometry.noise.dof, "residual": 0.0}[source]
    if not np.isfinite(noise_dof):
        noise_dof = PRIORS.noise_dof
    at, competition, members = _converged(geometry, candidates, noise_dof)
    reduced, components = competition.reduced, competition.components
    shares = competition.shares(members)
    sure = [i for i, share in enumerate(shares) if share[None] < PRIORS.absent]
    sure.sort(key=lambda i: -_size(reduced, members[i]))
    members, shares = [members[i] for i in sure], [shares[i] for i in sure]
    misfit = source == "residual" or not alike(at.noise, geometry.noise)
    misfit = misfit or any(components[m.component].family is not None for m in members)
    if misfit and positions(geometry) >= 2 * POSES_PER_JOINT * geometry.model.problem.arm.n:
        shares = _in_both_halves(at, components, members, shares, noise_dof)
    shown = [share[m.component] >= PRIORS.absent for share, m in zip(shares, members, strict=True)]
    unrepeated = [m for m, there in zip(members, shown, strict=True) if not there]
    members = [m for m, there in zip(members, shown, strict=True) if there]
    shares = [share for share, there in zip(shares, shown, strict=True) if there]
    effects = _effects(competition, members)
    final = _sharpened(_refitted(at, effects), candidates)
    scatter = np.sqrt(np.maximum(at.noise.joint**2 - geometry.noise.joint**2, 0.0))
    return Selection(
        final, tuple(components), tuple(members), tuple(shares), reduced, tuple(unrepeated), scatter
    )


def _in_both_halves(
    at: Fit,
    components: Sequence[Component],
    members: Sequence[Member],
    shares: list[Shares],
    noise_dof: float,
) -> list[Shares]:
    """The shares where the model does not fit to the noise, and the likelihood is far too sure: a member is
    as probable as in that half of the poses (in the order of measurement) which says least for it."""
    out = [dict(share) for share in shares]
    for poses in _halves(at.model.problem.campaign.poses):
        half = Competition(reduce(at, components, _explained(at), noise_dof, poses), components)
        for share, other, member in zip(out, half.shares(members), members, strict=True):
            if components[member.component].family is not None:
                continue  # no name is at stake
            share[member.component] = min(share[member.component], other[member.component])
    return out


def _refitted(near: Fit, effects: Sequence[Effect]) -> Fit:
    """A fit with these effects; one that would make the arm too soft to stand is left out."""
    if tuple(effects) == near.model.effects:
        return near
    try:
        return refit(near, effects)
    except ArithmeticError:
        result, kept = refit(near, []), list[Effect]()
    for effect in effects:
        try:
            result = refit(result, [*kept, effect])
        except ArithmeticError:
            continue
        kept.append(effect)
    return result


def _sharpened(result: Fit, candidates: Sequence[Effect]) -> Fit:
    """The fit with settings (a soft zone's width) moved to where the data want them."""
    for i, effect in enumerate(result.model.effects):
        related = [other for other in candidates if other.key == effect.key and other.finer()]
        for other in dict.fromkeys([*related, *(fine for one in related for fine in one.finer())]):
            effects = list(result.model.effects)
            effects[i] = other
            try:
                moved = refit(result, effects)
            except ArithmeticError:
                continue
            if moved.chi2 < result.chi2 - CLEARER:
                result = moved
    return result


def _halves(poses: Poses) -> tuple[Index, Index]:
    """The earlier and the later half of the poses of every set-up and payload."""
    early, late = list[Index](), list[Index]()
    groups = np.unique(np.column_stack([poses.setup, poses.payload]), axis=0, return_inverse=True)[1].ravel()
    for group in range(int(groups.max()) + 1):
        own = np.flatnonzero(groups == group)
        early.append(own[: len(own) // 2])
        late.append(own[len(own) // 2 :])
    return np.sort(np.concatenate(early)), np.sort(np.concatenate(late))


def _of_scattering(at: Fit, base: Covariance) -> Iterator[Family]:
    """Functions of two other joints, for the joints that scatter most."""
    extra = at.noise.joint**2 - base.joint**2
    for j in np.argsort(-extra)[:MOST_SCATTERING]:
        if extra[j] > 0:
            yield from product_families(at, int(j))


def _converged(
    geometry: Fit, candidates: Sequence[Effect], noise_dof: float
) -> tuple[Fit, Competition, list[Member]]:
    """The likeliest set, found again at its own fit until it stays.

    The joints' scatter beside it is in the noise from the start, and shrinks as causes are found:
    a cause must stand out of it.
    """
    base, lines, last = geometry.noise, list[Line](), None
    at = _fitted(geometry, [], base)
    for _ in range(ROUNDS):
        lines = _with_lines(at, lines)
        components = [
            *cause_components(at, candidates),
            *(_line(at, line) for line in lines),
            *free_components(at, [*families(at), *_of_scattering(at, base)]),
        ]
        competition = Competition(reduce(at, components, _explained(at), noise_dof), components)
        members = competition.best()
        effects, noise = _effects(competition, members), at.noise
        at = _fitted(at, effects, base)
        if last is not None and set(effects) == set(last) and alike(noise, at.noise):
            break
        last = effects
    return at, competition, members


def _fitted(near: Fit, effects: Sequence[Effect], base: Covariance) -> Fit:
    """A fit with these effects, under the noise with the scatter that it leaves."""
    result = _refitted(near, effects)
    noise = with_scatter(result, base)
    if alike(noise, result.noise):
        return result
    return fit(result.model, result.state, noise, max_iterations=12)


def _effects(competition: Competition, members: Sequence[Member]) -> list[Effect]:
    """The effects that stand for a set: of each cause the form that explains most without its companions."""
    out = list[Effect]()
    for member in members:
        forms = competition.components[member.component].forms
        if not forms[member.form].effects:
            continue
        left = competition.left_by([m for m in members if m is not member])
        worth = []
        for form, part in zip(forms, left.parts[member.component], strict=True):
            main = np.arange(part.start, part.start + sum(len(e.params) for e in form.effects))
            worth.append(left.explained(main, np.full(len(main), LOOSE**-2)) - CLEARER * len(main))
        out += forms[int(np.argmax(worth))].effects
    return out


def _explained(at: Fit) -> Array | None:
    """(N, D) what the fit's effects explain of the whitened data, to first order."""
    if not at.model.effects:
        return None
    out = np.zeros_like(at.r)
    for part, values in zip(at.columns.effect, at.state.values, strict=True):
        out += at.J[:, :, part] @ values
    return out


def _with_lines(at: Fit, lines: list[Line]) -> list[Line]:
    """Further peaks of the scan, what is in the fit taken out."""
    out = list(lines)
    for line in scan(at):
        near = any(o.joint == line.joint and abs(o.order - line.order) < 0.5 for o in out)
        if line.statistic > LEAST_LINE and not near:
            out.append(line)
    return out


def _line(at: Fit, line: Line) -> Component:
    problem = at.model.problem
    spread = float(np.std(problem.q[:, line.joint]))
    width = np.sqrt(2 * np.pi) / (np.sqrt(line.statistic) * max(spread, 1e-3))
    sharpness = min(1.0, width / line.order / np.log(HIGHEST / LOWEST))
    return line_component(at, gear_line(problem.arm.names[line.joint], round(line.order, 3)), sharpness)


def _size(reduced: Reduced, member: Member) -> float:
    part = reduced.parts[member.component][member.form]
    index = np.arange(len(reduced.u))[part]
    return reduced.explained(index, np.full(len(index), member.scale**-2))
