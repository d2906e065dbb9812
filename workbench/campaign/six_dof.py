"""Targets that are points of one 6-D measurement, though nobody said so: their distances never change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..files.faults import Fault, InputError
from .data import Array, Campaign
from .file import CampaignFile

RIGID = 0.1  # of the noise: targets that are measured one by one change their distances by more
ROUNDED = 6e-6  # m, by which a distance scatters that was written to 0.01 mm; what was measured scatters more
FINEST = 1e-6  # m, where no noise is stated: no instrument measures a distance that well again and again
BODY = 1e-3  # m, across the line through the targets at least: points on a line are no 6-D measurement
UNITS = 5.0  # times: no target sits as wrong as that, and no two units of length are closer
TARGETS, POSES = 3, 10  # at least, to say so


def with_six_dof(campaign: Campaign) -> Campaign:
    """The campaign, with `pose = true` and a warning where its points can be nothing else."""
    c = campaign
    scatter = _scatter(c)
    if c.six_dof or scatter > min(RIGID * _noise(c), ROUNDED):
        return c
    names = ", ".join(target.name for target in c.targets)
    said = (
        f"{c.path}: the distances between {names} never change ({1e3 * scatter:.1g} mm): they are points "
        "of one 6-D measurement, and taken as such; say pose = true under [noise]"
    )
    return replace(c, six_dof=True, warnings=(*c.warnings, said))


def check_one_body(campaign: Campaign, file: CampaignFile) -> None:
    """Raises `InputError` where targets of one 6-D measurement are said to be on several bodies."""
    bodies = dict.fromkeys(target.on for target in campaign.targets)
    if not campaign.six_dof or len(bodies) < 2:
        return
    what = f"the targets are on {' and '.join(bodies)}, but one 6-D measurement is of one body"
    turned = file.points.turned_mm is not None
    place, mend = (
        ("points.turned_mm", "take it out: all are read as points then, without turns; or")
        if turned
        else ("noise.pose", "take it out if the targets are measured one by one; or")
    )
    raise InputError(Fault(f"{campaign.path}: {place}", what, f"{mend} leave out those of the other body"))


def _scatter(campaign: Campaign) -> float:
    """[m] by which the distances of all targets change at most, where they are on one body that moves;
    else infinite."""
    bodies = {target.on for target in campaign.targets}
    points = campaign.points[campaign.seen.all(axis=1)]
    if len(bodies) > 1 or "base" in bodies or points.shape[1] < TARGETS or len(points) < POSES:
        return np.inf
    middle = points[len(points) // 2]
    if np.linalg.svd(middle - middle.mean(axis=0), compute_uv=False)[1] < BODY:
        return np.inf
    with np.errstate(over="ignore", invalid="ignore"):  # beyond all measure: left out later
        apart = np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)
        scatter, usual = float(apart.std(axis=0).max()), np.median(apart, axis=0)
    return scatter if np.isfinite(scatter) and not _in_other_units(campaign, usual) else np.inf


def _in_other_units(campaign: Campaign, apart: Array) -> bool:
    """Whether targets are stated some times as far from each other as they were seen (T, T) [m]: then so is
    the noise. In which units, the fit will say."""
    stated = np.array([(np.nan,) * 3 if t.xyz is None else t.xyz for t in campaign.targets])
    size = np.linalg.norm(stated[:, None] - stated, axis=-1)
    known = np.isfinite(size) & (size > BODY)
    return bool(known.any()) and not 1 / UNITS < np.median(apart[known] / size[known]) < UNITS


def _noise(campaign: Campaign) -> float:
    """[m] per axis as stated; without it the finest that there is, over the share that tells."""
    if campaign.sigma is not None:
        return float(np.nanmedian(campaign.sigma))
    return FINEST / RIGID if campaign.noise_sigma is None else campaign.noise_sigma
