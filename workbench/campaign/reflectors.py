"""Campaigns with further reflectors, on links of the arm or on its base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..files.faults import Fault, InputError
from ..files.tables import suggest
from ..robot.kinematics import Arm, Array
from .data import Campaign, Target

BESIDE = 0.1  # m from the line between two joints: about where a link's surface is
ALONG = 0.2  # of that line, from its joint: near it, where the link itself hardly bends


def with_reflectors(campaign: Campaign, links: Sequence[str]) -> Campaign:
    """The campaign with a target more on each of these links (or "base"), which no pose has shown yet and
    whose place nobody knows. Raises InputError where there is no such link, or the instrument sees one
    body."""
    known = ("base", *campaign.robot.links)
    what = f"{campaign.robot.name} has no such link"
    faults = [
        Fault(f"--reflector {link}", what, suggest(link, known) or f"one of {', '.join(known)}")
        for link in links
        if link not in known
    ]
    if links and campaign.six_dof:
        faults.append(Fault("--reflector", "the instrument measures one body in 6-D", "leave it out"))
    if faults:
        raise InputError(faults)
    had = {target.name for target in campaign.targets}
    more = tuple(Target(_other(f"on_{link}", had), on=link) for link in links)
    blank = np.full((len(campaign.poses), len(more), 3), np.nan)
    none = np.zeros(blank.shape[:2], dtype=np.int64)
    return replace(
        campaign,
        targets=(*campaign.targets, *more),
        points=np.concatenate([campaign.points, blank], axis=1),
        shots=np.concatenate([campaign.shots, none], axis=1),
        sigma=None if campaign.sigma is None else np.concatenate([campaign.sigma, blank], axis=1),
    )


def place_of(arm: Arm, link: str) -> Array:
    """(3,) [m] where a reflector on a link may sit, in the frame behind its slot: near its joint, beside the
    line to the next."""
    way = arm.p[arm.slot_of_link(link) + 1]
    across = np.cross(way, np.eye(3)[np.argmin(np.abs(way))])
    length = float(np.linalg.norm(across))
    return np.asarray(ALONG * way + BESIDE * (across / length if length > 0 else np.array([1.0, 0.0, 0.0])))


def _other(name: str, had: set[str]) -> str:
    while name in had:
        name += "_new"
    return name
