"""What a diagnosis says besides its findings: the campaign's facts and the calibrated geometry."""

from __future__ import annotations

import numpy as np

from ...campaign.flange_load import external_forces
from ...campaign.problem import Problem
from ...effects.place import Parameter
from ...identification.fit import Fit
from ...identification.own_base import own_base
from ..found import OfCampaign
from ..prepared import Prepared
from .in_the_model import what_the_model_has

ALIKE = 1.05  # times: noises of set-ups that differ by less are one


def geometry(final: Fit) -> tuple[Parameter, ...]:
    """Corrections of the joint frames with standard deviations, of those that are fitted."""
    part, columns = final.columns.geometry_slice, final.columns.geometry
    std = np.sqrt(np.diag(final.covariance)[part])
    change = final.state.geometry.ravel()[columns]
    names = [name.removeprefix("geometry/") for name in final.columns.names[part]]
    stay = final.model.problem.flange_stays
    return tuple(
        Parameter(name, float(v), float(s), "rad" if name.rpartition("/")[2].startswith("r") else "m")
        for name, column, v, s in zip(names, columns.tolist(), change, std, strict=True)
        if column not in stay
    )


def unidentifiable(final: Fit) -> tuple[str, ...]:
    """Geometry that stays where it was because these data do not show it."""
    part, columns = final.columns.geometry_slice, final.columns.geometry.tolist()
    problem = final.model.problem
    std = np.sqrt(np.diag(final.covariance)[part]) / final.columns.prior[part]
    behind = 6 * (problem.arm.slots - 1)  # of the flange: where it stays, targets sit otherwise instead
    stays = {column for column in problem.flange_stays if column >= behind}
    hidden = [
        name.removeprefix("geometry/")
        for name, column, s in zip(final.columns.names[part], columns, std, strict=True)
        if s > 0.9 and column not in stays
    ]
    return tuple(hidden)


def _base(problem: Problem, final: Fit) -> str:
    """Whether the campaign says where the base is."""
    base, stated = own_base(problem, final.state.geometry), problem.arm.gravity
    if base.measured:
        return "measured by fixed targets on it"
    off, most = (float(np.linalg.norm(g)) for g in (base.gravity - stated, stated))
    tilt = 1e3 * off / max(most, 1e-12)
    return (
        f"not measured, axis 1 stands in it as stated; off level by {tilt:.1f} mrad, as far as gravity tells"
    )


def _model(problem: Problem, final: Fit) -> dict[str, str]:
    """What the model that was given has beyond the nominal robot."""
    robot = problem.robot
    if not robot.effects and not robot.geometry:
        return {}
    said = what_the_model_has(problem, final.model.known)
    return {"Model": f"extended before; causes in it: {said or 'none'}; what was found comes on top"}


def _set_ups(problem: Problem, final: Fit) -> str:
    """Set-ups, each of several with its poses, the RMS error that is left there, and the noise that was used
    where it is not the same in all."""
    setup, names = problem.campaign.poses.setup, problem.campaign.setup_names
    if len(names) == 1:
        return names[0] or "one"
    seen = {k: problem.seen & (setup == k)[:, None] for k in np.unique(setup).tolist()}
    noise = {k: 1e3 * float(np.sqrt(np.mean(final.noise.sigma[some] ** 2))) for k, some in seen.items()}
    alike = max(noise.values()) <= ALIKE * min(noise.values())
    said = []
    for k, some in seen.items():
        off = 1e3 * float(np.sqrt(np.sum(final.residual[some] ** 2, axis=-1).mean()))
        words = f"{names[k] or 'one'}: {(setup == k).sum()} poses, {off:.3f} mm RMS left"
        said.append(words if alike else f"{words}, noise {noise[k]:.3f} mm")
    return "; ".join(said)


def of_campaigns(prepared: Prepared, alone: Fit, final: Fit) -> tuple[OfCampaign, ...]:
    """Each of several campaigns that are fitted as one robot; none of a single one. alone: geometry alone."""
    problem = final.model.problem
    c = problem.campaign
    out = []
    for k, label in enumerate(c.labels):
        here = c.of_campaign == k
        seen = problem.seen & here[:, None]
        if not seen.any():
            continue
        nominal, geometry, after = (
            1e3 * float(np.sqrt(np.sum(result.residual[seen] ** 2, axis=-1).mean()))
            for result in (prepared.nominal, alone, final)
        )
        noise = 1e3 * float(np.sqrt(np.mean(final.noise.sigma[seen] ** 2)))
        source = "residual" if label in c.silent else "repeats" if label in c.shown else prepared.noise.source
        last = bool(k == c.of_campaign.max())
        counts = int(here.sum()), int(seen.sum())
        out.append(OfCampaign(label, *counts, noise, source, nominal, geometry, after, last))
    return tuple(out)


def facts(problem: Problem, final: Fit) -> dict[str, str]:
    """What was measured, in words."""
    c = problem.campaign
    said = {
        "Poses": str(len(c.poses.q)),
        "Points": str(int(problem.seen.sum())),
        "Targets": ", ".join(f"{t.name} (on {t.on})" if t.on != "flange" else t.name for t in c.targets),
        "Set-ups": _set_ups(problem, final),
        "Base": _base(problem, final),
        **_model(problem, final),
        "Payloads": ", ".join(
            f"{name or 'tool only'}: {c.tool_mass + m:g} kg"
            for i, (name, m) in enumerate(zip(c.payload_names, c.load_mass, strict=True))
            if (c.poses.payload == i).any()
        ),
    }
    if pulled := external_forces(c):
        said["External forces"] = pulled
    for j, name in enumerate(problem.arm.names):
        low, high = c.poses.q[:, j].min(), c.poses.q[:, j].max()
        said[f"Range of {name}"] = (
            f"{low * 1e3:.0f} … {high * 1e3:.0f} mm"
            if problem.arm.prismatic[j]
            else f"{np.degrees(low):.1f} … {np.degrees(high):.1f}°"
        ).replace("-", "−")
    if c.poses.temperature is not None and np.isfinite(c.poses.temperature).any():
        said["Temperature"] = (
            f"{np.nanmin(c.poses.temperature):.1f} … {np.nanmax(c.poses.temperature):.1f} °C"
        )
    extra = [
        ("side of approach", c.poses.side),
        ("time", c.poses.time),
        ("motor torque", c.poses.torque),
        ("read-back joints", c.poses.readback),
    ]
    said["Recorded besides"] = ", ".join(name for name, value in extra if value is not None) or "nothing"
    return said
