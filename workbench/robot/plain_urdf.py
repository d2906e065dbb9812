"""A URDF as Drake takes it: the tree that hangs on the base, and nothing that Drake would stumble over.

Joints beside the chain stand at zero. Inertias that no body can have become that of a point with the same
mass. Collision bodies, transmissions and extensions go: nothing here uses them. Visuals come only where
they are asked for, as files that Drake can show (`meshes`).
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from ..files.faults import Fault, InputError
from .chain import Chain, MovingJoint
from .meshes import Pictures, mesh_key
from .urdf import MOVING, Urdf, number, origin_of, vector

BONE = 0.035  # m, radius of the cylinder that stands for a link without a picture, at most
SLIM = 0.125  # and of its length: a small arm's links do not hide what it measures
GREY = "0.72 0.74 0.76 1"
LIGHTEST, HEAVIEST = 1e-3, 5e3  # kg of what moves with a joint: of a hobby servo, of the largest arms
FARTHEST = 5.0  # m from a link to its centre of mass, or as radius of gyration
SHOWN = 6  # of them are named
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def plain_text(urdf: Urdf, chain: Chain, pictures: Pictures | None = None, beside: Path | None = None) -> str:
    """The text of the plain URDF.

    pictures: what to show for each mesh (`meshes.pictures`); None: nothing is shown. beside: the
    folder from which mesh files are named; None: by their full path.
    """
    root = ET.Element("robot", name=urdf.path.stem)
    moving = {joint.link: joint for joint in chain.joints}
    for link in urdf.below(chain.base):
        body = ET.SubElement(root, "link", name=link)
        _add_inertial(body, urdf, link)
        if pictures is not None:
            _add_visuals(body, urdf, link, pictures, beside)
        if link == chain.base:
            continue
        source = urdf.joints[link]
        kind = _kind(moving[link]) if link in moving else "fixed"
        joint = ET.SubElement(root, "joint", name=source.get("name", ""), type=kind)
        ET.SubElement(joint, "parent", link=urdf.parent(link) or "")
        ET.SubElement(joint, "child", link=link)
        place = f"{urdf.path}: joint {source.get('name')!r}"
        _add_origin(joint, source, place)
        if link in moving:
            axis = vector(source.find("axis"), "xyz", place, (1.0, 0.0, 0.0))
            ET.SubElement(joint, "axis", xyz=_text(axis))
            _add_limit(joint, moving[link])
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def left_out(urdf: Urdf, chain: Chain) -> list[str]:
    """What of the URDF does not count as it says, a line each."""
    below = urdf.below(chain.base)
    own, notes = {joint.name for joint in chain.joints}, [*urdf.notes]
    moving = [urdf.joints[link].get("name", "") for link in below[1:] if urdf.kind(link) in MOVING]
    if still := [name for name in moving if name not in own]:
        notes.append(f"these joints beside the arm stand at 0: {', '.join(still)}")
    if bad := [link for link in below if _mass(urdf, link) > 0 and _inertia(urdf, link) is None]:
        notes.append(f"inertia that no body can have, taken as a point's: {', '.join(bad)}")
    if odd := _odd_weights(urdf, chain):
        more = f" and {len(odd) - SHOWN} more" if len(odd) > SHOWN else ""
        notes.append(
            f"weights that no arm has, taken as they are: {', '.join(odd[:SHOWN])}{more}; state what the "
            "links weigh, in kg and m, or no masses if that is unknown: how the arm sags follows from them"
        )
    return notes


def _odd_weights(urdf: Urdf, chain: Chain) -> list[str]:
    """What moves with a joint and weighs next to nothing or more than the largest arms, where the URDF has
    masses at all; and links whose mass is far from them."""
    ends = [*(joint.link for joint in chain.joints[1:]), None]
    masses = {}
    for joint, end in zip(chain.joints, ends, strict=True):
        behind = set() if end is None else set(urdf.below(end))
        masses[joint.link] = sum(_mass(urdf, link) for link in urdf.below(joint.link) if link not in behind)
    if not any(masses.values()):
        return []
    odd = [f"{link} with {kg:g} kg" for link, kg in masses.items() if not LIGHTEST <= kg <= HEAVIEST]
    for link in urdf.below(chain.base):
        if (mass := _mass(urdf, link)) > 0:
            place = f"{urdf.path}: link {link!r} inertial"
            inertial = urdf.links[link].find("inertial")
            assert inertial is not None
            away = float(np.linalg.norm(origin_of(inertial, place)[0]))
            spread = float(np.sqrt(max((_inertia(urdf, link) or [0.0])[:3]) / mass))
            odd += [f"{link} with its centre of mass {away:.3g} m away"] if away > FARTHEST else []
            odd += [f"{link} with a radius of gyration of {spread:.3g} m"] if spread > FARTHEST else []
    return odd


def _mass(urdf: Urdf, link: str) -> float:
    """[kg], 0 where none is stated. Raises `InputError`."""
    place = f"{urdf.path}: link {link!r} mass"
    mass = number(urdf.links[link].find("inertial/mass"), "value", place)
    if mass < 0:
        raise InputError(Fault(place, f"{mass:g} kg is no mass", "state what the link weighs, 0 if unknown"))
    return mass


def _inertia(urdf: Urdf, link: str) -> list[float] | None:
    """ixx iyy izz ixy ixz iyz [kg·m²], what digits lack for a rod or a disc added; None where no body can
    have it."""
    element = urdf.links[link].find("inertial/inertia")
    place = f"{urdf.path}: link {link!r} inertia"
    values = [number(element, key, place) for key in MOMENTS]
    xx, yy, zz, xy, xz, yz = values
    low, middle, high = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    short = float(high - low - middle)
    if low < 0 or short > 1e-6 * high:
        return None
    more = 2 * short if short > 1e-12 * high else 0.0  # of less Drake does not speak
    return [xx + more, yy + more, zz + more, xy, xz, yz]


def _add_inertial(body: ET.Element, urdf: Urdf, link: str) -> None:
    mass = _mass(urdf, link)
    if mass <= 0:
        return
    source = urdf.links[link].find("inertial")
    assert source is not None
    inertial = ET.SubElement(body, "inertial")
    _add_origin(inertial, source, f"{urdf.path}: link {link!r} inertial")
    ET.SubElement(inertial, "mass", value=repr(mass))
    values = _inertia(urdf, link) or [0.0] * 6
    ET.SubElement(inertial, "inertia", {key: repr(v) for key, v in zip(MOMENTS, values, strict=True)})


def _bounded(moving: MovingJoint) -> bool:
    return bool(np.isfinite(moving.upper - moving.lower))


def _kind(moving: MovingJoint) -> str:
    """Its type: a revolute joint has bounds, in ROS it is no joint without them."""
    return "continuous" if moving.kind == "revolute" and not _bounded(moving) else moving.kind


def _add_limit(joint: ET.Element, moving: MovingJoint) -> None:
    """Its limits. Effort and velocity belong to them in ROS, which refuses the file else: 0 where unknown."""
    bounds = {key: repr(getattr(moving, key)) for key in ("lower", "upper")}
    most = {key: getattr(moving, key) for key in ("effort", "velocity")}
    keys = {key: repr(value if np.isfinite(value) else 0.0) for key, value in most.items()}
    ET.SubElement(joint, "limit", {**(bounds if _bounded(moving) else {}), **keys})


def _add_visuals(body: ET.Element, urdf: Urdf, link: str, pictures: Pictures, beside: Path | None) -> None:
    """The link's visuals; its collision bodies where it has none that can be shown; else a bone."""
    place = f"{urdf.path}: link {link!r}"
    for kind in ("visual", "collision"):
        for source in urdf.links[link].findall(kind):
            _add_visual(body, urdf, source, pictures, beside, place)
        if body.find("visual") is not None:
            return
    for child in urdf.children(link):
        if urdf.kind(child) in MOVING:
            _add_bone(body, origin_of(urdf.joints[child], place)[0])


def _add_visual(
    body: ET.Element, urdf: Urdf, source: ET.Element, pictures: Pictures, beside: Path | None, place: str
) -> None:
    shape = next(iter(source.find("geometry") or ()), None)
    if shape is None:
        return
    material = source.find("material")
    colour = None if material is None else _rgba(urdf, material)
    if shape.tag != "mesh":
        if _is_a_body(shape, place):
            _visual(body, source, place, shape.tag, dict(shape.attrib), colour)
        return
    for part in pictures.get(mesh_key(shape), []):
        file = part.file
        name = f"file://{file.resolve()}" if beside is None else file.relative_to(beside).as_posix()
        keys = {"filename": name, "scale": _text(part.scale)}
        _visual(body, source, place, "mesh", keys, part.colour or colour)


def _is_a_body(shape: ET.Element, place: str) -> bool:
    """Whether a box, cylinder or sphere is more than nothing: some URDFs have one of size 0, which Drake
    refuses, where a link has no picture."""
    sizes = [number(shape, key, place) for key in ("radius", "length") if key in shape.attrib]
    return min([*sizes, *vector(shape, "size", place, (1.0, 1.0, 1.0))]) > 0


def _visual(
    body: ET.Element, source: ET.Element, place: str, shape: str, keys: dict[str, str], colour: str | None
) -> None:
    visual = ET.SubElement(body, "visual")
    _add_origin(visual, source, place)
    ET.SubElement(ET.SubElement(visual, "geometry"), shape, keys)
    if colour is not None:
        ET.SubElement(ET.SubElement(visual, "material", name=""), "color", rgba=colour)


def _rgba(urdf: Urdf, material: ET.Element) -> str | None:
    colour = material.find("color")
    return urdf.colours.get(material.get("name", "")) if colour is None else colour.get("rgba")


def _add_bone(body: ET.Element, end: tuple[float, float, float]) -> None:
    """A cylinder from the link's origin to a joint that it carries."""
    x, y, z = end
    length = float(np.linalg.norm(end))
    if not length:
        return
    visual = ET.SubElement(body, "visual")
    rpy = (0.0, float(np.arctan2(np.hypot(x, y), z)), float(np.arctan2(y, x)))
    ET.SubElement(visual, "origin", xyz=_text((x / 2, y / 2, z / 2)), rpy=_text(rpy))
    geometry = ET.SubElement(visual, "geometry")
    ET.SubElement(geometry, "cylinder", radius=repr(min(BONE, SLIM * length)), length=repr(length))
    ET.SubElement(ET.SubElement(visual, "material", name=""), "color", rgba=GREY)


def _add_origin(element: ET.Element, source: ET.Element, place: str) -> None:
    xyz, rpy = origin_of(source, place)
    if any(xyz) or any(rpy):
        ET.SubElement(element, "origin", xyz=_text(xyz), rpy=_text(rpy))


def _text(values: tuple[float, ...]) -> str:
    return " ".join(repr(value) for value in values)
