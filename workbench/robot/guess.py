"""Which link of a URDF is the flange, where nobody says it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..files.faults import Fault, InputError
from .urdf import MOVING, Urdf

ARM = 2  # joints from which a part is an arm, and what branches behind it a gripper; a tool has no more
WRIST = 5  # joints behind which a last one that slides is a finger: arms slide nearer to the base
GRIPPER = re.compile(r"(?!.*(wrist|roll|pitch|yaw|rot)).*(finger|gripper|jaw|knuckle|claw)", re.IGNORECASE)
NAMES = (r"(.*[_/-])?tool0", r"(.*[_/-])?flange(_link)?", r".*(link_ee|ee_link|tool_flange|mounting_plate)")


@dataclass(frozen=True)
class Guess:
    """The flange and why it is taken for it."""

    flange: str
    why: str


def guess_flange(urdf: Urdf, base: str | None = None) -> Guess:
    """The flange of the only arm in the URDF (on `base`, if given). Raises `InputError` where there are
    several arms, with the flange of each, or none."""
    roots = [base] if base is not None else [link for link in urdf.links if link not in urdf.joints]
    if base is not None and base not in urdf.links:
        raise InputError(
            Fault("--base", f"{urdf.path} has no link {base!r}", f"it has: {', '.join(urdf.links)}")
        )
    ends = [end for root in roots for end in _arms(urdf, root, 0)]
    if not ends:
        raise InputError(Fault(str(urdf.path), "has no moving joint", "name a robot's URDF"))
    if len(ends) > 1:
        choices = [_flange_behind(urdf, end).flange for end in ends]
        what = f"has {len(ends)} arms, to {', '.join(choices)}"
        raise InputError(
            Fault(str(urdf.path), what, f"say --flange {choices[0]}, and --base where it stands")
        )
    return _flange_behind(urdf, ends[0])


def _arms(urdf: Urdf, link: str, joints: int) -> list[str]:
    """The last moving links of the arms that begin at a link which already has so many joints above it."""
    here, group = link, _welded(urdf, link)
    moving = [
        child
        for member in group
        for child in urdf.children(member)
        if urdf.kind(child) in MOVING and any(_free(urdf, below) for below in urdf.below(child))
    ]
    flanged = [child for child in moving if any(map(_named, urdf.below(child)))]
    if joints >= ARM and len(flanged) == 1 and not any(map(_named, group)):
        moving = flanged  # the other branches are levers
    loose = [c for m in group for c in urdf.children(m) if urdf.kind(c) in ("floating", "planar")]
    if len(moving) > 1 and joints < ARM:
        found = [end for child in moving for end in _arms(urdf, child, 1)]
        most = max(_depth(urdf, end) for end in found)
        return [end for end in found if _depth(urdf, end) >= max(ARM + 1, most // 2)] or found
    if len(moving) == 1 and not _tool(urdf, moving[0], joints):
        return _arms(urdf, moving[0], joints + 1)
    if joints:
        return [here]
    return [end for child in loose for end in _arms(urdf, child, 0)]


def _free(urdf: Urdf, link: str) -> bool:
    """The link moves by a joint of its own."""
    return urdf.kind(link) in MOVING and urdf.joints[link].find("mimic") is None


def _tool(urdf: Urdf, link: str, joints: int) -> bool:
    """Whether what moves this link is no axis of the arm of so many joints before it: a joint that says so by
    its name, the last ones behind a link that is called a flange, and a last one that others follow or that
    slides behind a wrist."""
    if joints <= ARM:
        return False
    name, last = urdf.joints[link].get("name", ""), sum(_free(urdf, below) for below in urdf.below(link))
    mimics = (joint.find("mimic") for joint in urdf.joints.values())
    followed = any(mimic is not None and mimic.get("joint") == name for mimic in mimics)
    finger = followed or (urdf.kind(link) == "prismatic" and joints >= WRIST)
    return bool(GRIPPER.match(name)) or (last == 1 and finger) or (last <= ARM and _on_flange(urdf, link))


def _on_flange(urdf: Urdf, link: str) -> bool:
    """One of the links that are fixed together to carry this one is called a flange."""
    for carrier in list(urdf.above(link))[1:]:
        if _named(carrier):
            return True
        if carrier not in urdf.joints or urdf.kind(carrier) in MOVING:
            break
    return False


def _named(link: str) -> bool:
    return any(re.fullmatch(pattern, link, re.IGNORECASE) for pattern in NAMES)


def _depth(urdf: Urdf, link: str) -> int:
    return sum(name in urdf.joints and urdf.kind(name) in MOVING for name in urdf.above(link))


def _welded(urdf: Urdf, link: str) -> list[str]:
    """The link and all that is fixed to it, in the file's order."""
    out = [link]
    for child in urdf.children(link):
        if urdf.kind(child) == "fixed":
            out += _welded(urdf, child)
    return out


def _flange_behind(urdf: Urdf, last: str) -> Guess:
    """The controller's flange among what is welded to the last moving link."""
    group = _welded(urdf, last)
    for pattern in NAMES:
        for link in group:
            if re.fullmatch(pattern, link, re.IGNORECASE):
                return Guess(link, "by its name")
    for link in group[1:]:
        # a link that has a shape is a part or stands for one, as Franka's collision links do
        shaped = any(urdf.links[link].find(kind) is not None for kind in ("visual", "collision"))
        if urdf.parent(link) == last and not shaped:
            return Guess(link, f"the frame that is fixed to the last moving link {last!r}")
    tool = any(urdf.kind(link) in MOVING for link in urdf.below(last)[1:])
    return Guess(last, "the last link before what moves in a tool" if tool else "the last moving link")
