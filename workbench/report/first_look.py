"""The page of `workbench check`: what was read, drawn, before any fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..campaign.flange_load import external_forces
from ..campaign.standing_still import stands_still
from ..diagnosis.first_look import SUSPICIOUS, FirstLook
from ..files.digest import digests
from ..robot.description import Robot
from ..robot.kinematics import Array, Frames, frames
from ..robot.rigid_plant import arrays
from .drawing import AFTER, BEFORE, INK, MUTED, Figure, dots, drawing
from .folder import json_bytes, write_together
from .markup import render
from .numbers import decimals
from .scene import Shown, scene_of

NAMES = ("x", "y", "z", "out along the arm")  # of the axes
LISTED = 12  # suspicious points by name
MOSTLY = 0.5  # of a target's points


@dataclass(frozen=True)
class Checked:
    """What `check` found, ready to be said. sections: title → lines; facts: for programs."""

    title: str
    headline: str
    sections: Mapping[str, Sequence[str]]
    facts: Mapping[str, Any]
    robot: Robot
    shown: Shown

    @property
    def text(self) -> str:
        """For a terminal."""
        lines = [f"{self.title}: {self.headline}"]
        for title, said in self.sections.items():
            lines += ["", title, *(f"  {line}" for line in said)]
        return "\n".join(lines)


def check_robot(robot: Robot, notes: Sequence[str]) -> Checked:
    """A robot alone, at rest in the middle of its limits. notes: what of its URDF does not count."""
    bounded = [np.isfinite(joint.upper - joint.lower) for joint in robot.joints]
    middle = [(j.lower + j.upper) / 2 if ok else 0.0 for j, ok in zip(robot.joints, bounded, strict=True)]
    q = np.array(middle)
    none = np.zeros((0, 3))
    sections = {"What is known": _known(robot)} | ({"Worth a look": notes} if notes else {})
    count = len(robot.joints)
    headline = f"{count} joints from {robot.base} to {robot.flange}"
    facts = {
        "robot": robot.name,
        "joints": list(robot.joint_names),
        "warnings": list(notes),
        "inputs": digests(robot.files),
    }
    return Checked(robot.title, headline, sections, facts, robot, Shown(q, none, {"nominal": none}))


def check_campaign(look: FirstLook) -> Checked:
    """A campaign with its robot, its points registered."""
    campaign, mm, usual = look.campaign, 1e3 * look.distance, 1e3 * look.usual
    bad = np.flatnonzero(look.suspicious)
    bad = bad[np.argsort(-mm[bad])]
    listed = _listed(look, bad)
    targets = ", ".join(target.name for target in campaign.targets)
    calibrated = "no calibration mends that" if look.wrong else "calibration takes most of that"
    calibrated += " but for the suspicious ones" * (bool(listed) and not look.wrong)
    read = [
        f"{len(campaign.poses)} poses, {len(mm)} points of {targets}",
        f"after registration the points are {usual:.2f} mm (median), at most {mm.max():.1f} mm, from "
        f"where the URDF has them; {calibrated}",
        f"instrument: {_noise(look)}",
    ]
    if look.repeats:
        read.append(look.repeats.sentence)
    if pulled := external_forces(campaign):
        read.append(f"external forces {pulled}, on the base's axes as they act on the robot")
    sections: dict[str, Sequence[str]] = {"What was read": read}
    if look.wrong:
        sections["Joints, points and robot do not belong together"] = [str(fault) for fault in look.wrong]
    if listed:
        sections[f"Suspicious: more than {SUSPICIOUS:g} times the median off"] = listed
    if worth := [*look.remarks, *campaign.warnings]:
        sections["Worth a look"] = worth
    sections["What is known of the robot"] = _known(campaign.robot)
    sections["What such data cannot show"] = [f"{item.cause}: {item.why}" for item in look.not_testable]
    facts = {
        "robot": campaign.robot.name,
        "n_poses": len(campaign.poses),
        "n_points": len(mm),
        "median_mm": usual,
        "max_mm": float(mm.max()),
        "rp_mm": None if look.repeats is None else float(1e3 * look.repeats.rp.max()),
        "suspicious": [{"point": look.names[i], "off_mm": float(mm[i])} for i in bad],
        "warnings": [*look.remarks, *campaign.warnings],
        "wrong": [str(fault) for fault in look.wrong],
        "not_testable": [{"cause": item.cause, "why": item.why} for item in look.not_testable],
        "inputs": dict(campaign.files),
    }
    judged = "not of this robot in these poses" if look.wrong else f"{len(bad)} suspicious"
    headline = f"{len(mm)} points, {usual:.2f} mm from the nominal robot, {judged}"
    shown = Shown(
        look.q,
        look.points,
        {"Nominal model": look.error},
        look.pose,
        look.target,
        suspicious=look.suspicious,
    )
    return Checked(campaign.title, headline, sections, facts, campaign.robot, shown)


def _listed(look: FirstLook, bad: NDArray[np.int64]) -> list[str]:
    """Suspicious points, the farthest first; a target of which most are is one line."""
    mm, said = 1e3 * look.distance, list[str]()
    for i, target in enumerate(look.campaign.targets):
        own, all_of_it = bad[look.target[bad] == i], int((look.target == i).sum())
        if len(own) > max(MOSTLY * all_of_it, 1):
            mend = "are its x, y, z those of a target there? else mend its columns, or leave it out"
            if on_base := stands_still(look.campaign, i):
                mend = f"it stands still while the arm moves: {on_base}"
            said.append(
                f"{target.name}: {len(own)} of its {all_of_it} points, {mm[own].min():.1f} to "
                f"{mm[own].max():.1f} mm off; {mend}"
            )
            bad = bad[look.target[bad] != i]
    said += [f"pose {look.names[i]}: {mm[i]:.1f} mm off" for i in bad[:LISTED]]
    return said + ([f"and {len(bad) - LISTED} more"] if len(bad) > LISTED else [])


def _noise(look: FirstLook) -> str:
    campaign = look.campaign
    if campaign.sigma is not None:
        return "uncertainty stated point by point"
    if campaign.noise_sigma is not None:
        return f"{1e3 * campaign.noise_sigma:g} mm per axis, as stated"
    return "no noise stated: it is estimated from repeated poses, if there are any"


def _known(robot: Robot) -> list[str]:
    """What of the robot is stated, and what follows where it is not."""
    arm = arrays(robot)
    lines = [f"moving links weigh {arm.mass[1:].sum():.4g} kg; gravity {_vector(robot.gravity)} m/s²"]
    lacking = (
        ("stiffness", [j.data.stiffness for j in robot.joints], "rigid until loads say otherwise"),
        ("gear ratio", [j.data.gear_ratio for j in robot.joints], "gear errors are found by scan"),
    )
    for what, values, then in lacking:
        names = [joint.name for joint, value in zip(robot.joints, values, strict=True) if value is None]
        if names:
            which = "any joint" if len(names) == len(robot.joints) else ", ".join(names)
            lines.append(f"no {what} of {which}: {then}")
    free = [joint.name for joint in robot.joints if not np.isfinite(joint.upper - joint.lower)]
    if free:
        lines.append(f"without limits: {', '.join(free)}")
    if not arm.mass[1:].any():
        lines.append("the URDF states no masses: nothing that weighs can be told")
    return lines


def _vector(values: Sequence[float]) -> str:
    return " ".join(decimals(value, 2) for value in values)


def write_check(checked: Checked, folder: Path) -> None:
    """Writes `index.html`, `scene.html` and `check.json`, after all of them are made."""
    where = frames(arrays(checked.robot), np.atleast_2d(checked.shown.q))
    sections = [{"title": title, "lines": lines} for title, lines in checked.sections.items()]
    page = render(
        "check.html",
        title=checked.title,
        headline=checked.headline,
        sections=sections,
        figure=_picture(checked, where),
        points=len(checked.shown.points),
        inputs=checked.facts["inputs"].items(),
        version=version("robot-workbench"),
    )
    made = {
        "index.html": page.encode(),
        "scene.html": scene_of(checked.robot, checked.shown, checked.title).encode(),
        "check.json": json_bytes(checked.facts),
    }
    write_together(folder, made)


def _picture(checked: Checked, where: Frames) -> Figure:
    """The arm as a line through its joints, and the points, from the side and from above."""
    shown = checked.shown
    along = _along(where.p[:, 0])
    joints, points = where.p[:, 0] @ along, shown.points @ along
    bad = np.zeros(len(shown.points), dtype=bool) if shown.suspicious is None else shown.suspicious
    with drawing("check", 3.6, columns=2) as (axes, svg):
        for ax, (a, b) in zip(axes, ((3, 2), (0, 1)), strict=True):
            ax.plot(joints[:, a], joints[:, b], "-o", color=MUTED, lw=4, ms=6, mfc=INK, mec="none", zorder=1)
            _scatter(ax, points[~bad], a, b, AFTER, "measured")
            _scatter(ax, points[bad], a, b, BEFORE, "suspicious")
            ax.set_xlabel(f"{NAMES[a]}, m")
            ax.set_ylabel(f"{NAMES[b]}, m")
            ax.set_aspect("equal", adjustable="datalim")
        if len(shown.points):
            axes[0].legend()
    alt = f"The arm from the side and from above; {checked.headline}"
    return Figure("check", "The arm at one pose, from the side and from above", alt, svg[0])


def _along(joints: Array) -> Array:
    """(3, 4) that gives x, y, z and what a point is out from the base towards where the arm (joints, (n, 3))
    points: from that side it is seen in full."""
    far = joints[np.argmax(np.linalg.norm(joints[:, :2], axis=1)), :2]
    reach = float(np.linalg.norm(far))
    out = far / reach if reach > 1e-6 else np.array([1.0, 0.0])
    return np.column_stack([np.eye(3), [*out, 0.0]])


def _scatter(ax: Any, points: Array, a: int, b: int, colour: str, label: str) -> None:
    if len(points):
        dots(ax, points[:, a], points[:, b], colour, label)
