"""Targets that are points of one 6-D measurement, though nobody said so: their distances never change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .data import Campaign

RIGID = 0.1  # of the noise: targets that are measured one by one change their distances by more
FINEST = 1e-6  # m, where no noise is stated: no instrument measures a distance that well again and again
BODY = 1e-3  # m, across the line through the targets at least: points on a line are no 6-D measurement
TARGETS, POSES = 3, 10  # at least, to say so


def with_six_dof(campaign: Campaign) -> Campaign:
    """The campaign, with `pose = true` and a warning where its points can be nothing else."""
    c = campaign
    scatter = _scatter(c)
    if c.six_dof or scatter > RIGID * _noise(c):
        return c
    names = ", ".join(target.name for target in c.targets)
    said = (
        f"{c.path}: the distances between {names} never change ({1e3 * scatter:.1g} mm): they are points "
        "of one 6-D measurement, and taken as such; say pose = true under [noise]"
    )
    return replace(c, six_dof=True, warnings=(*c.warnings, said))


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
        scatter = float(apart.std(axis=0).max())
    return scatter if np.isfinite(scatter) else np.inf


def _noise(campaign: Campaign) -> float:
    """[m] per axis as stated; without it the finest that there is, over the share that tells."""
    if campaign.sigma is not None:
        return float(np.nanmedian(campaign.sigma))
    return FINEST / RIGID if campaign.noise_sigma is None else campaign.noise_sigma
