"""The bodies of a robot as convex hulls: of its collision shapes, or of what it looks like where it has
none."""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from .chain import Chain, read_chain
from .description import Robot
from .kinematics import Arm, Array
from .meshes import MeshPart, Pictures, mesh_files, mesh_key, pictures
from .plain_urdf import BONE
from .rotations import from_zyx
from .urdf import MOVING, Urdf, number, origin_of, read_urdf, vector

KINDS = ("collision", "visual")  # what a link is made of, the first that it has
STANDING = -1  # in place of a slot: what moves with nothing
ROUND = 16  # corners that stand for a circle, around it
PLATE = 1e-3  # m: what is thinner is taken as thick as this


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex body on the link behind a slot of the arm (0: base), or `STANDING`. vertices: (V, 3) [m] in
    the frame L of that slot (`kinematics`), in the world of what stands; normals: (F, 3), offsets: (F,) [m]:
    inside is normals · x <= offsets."""

    name: str
    slot: int
    vertices: Array
    normals: Array
    offsets: Array


def hull_of(name: str, slot: int, points: Array) -> Hull | None:
    """The hull of points (V, 3) [m]; a flat one gets `PLATE`; None for fewer than three points."""
    if len(points) < 3:
        return None
    try:
        found = ConvexHull(points)
    except QhullError:
        points = (points[:, None] + box_points([PLATE] * 3)).reshape(-1, 3)
        found = ConvexHull(points)
    planes = np.unique(found.equations.round(12), axis=0)
    return Hull(name, slot, points[found.vertices], planes[:, :3], -planes[:, 3])


def robot_hulls(robot: Robot, arm: Arm) -> list[Hull]:
    """A hull for every shape of the robot's links, base to flange. A link without any shape that can be read
    is a bar to the joint that it carries."""
    urdf = read_urdf(robot.urdf)
    chain = read_chain(urdf, robot.flange, robot.base)
    out: list[Hull] = []
    with tempfile.TemporaryDirectory(prefix="workbench-hulls-") as folder:
        shown = pictures(mesh_files(urdf, chain, kinds=KINDS), Path(folder))
        for link in urdf.below(chain.base):
            slot, R, p = _owner(urdf, chain, link)
            for i, points in enumerate(_shapes(urdf, link, shown)):
                turned = (points @ R.T + p) @ arm.R_link[slot].T
                if (hull := hull_of(f"{link}_{i}", slot, turned)) is not None:
                    out.append(hull)
    return out


def _owner(urdf: Urdf, chain: Chain, link: str) -> tuple[int, Array, Array]:
    """The slot that moves a link, and the link's pose R (3, 3), p (3,) [m] in the link of that slot; joints
    beside the arm stand at zero."""
    slots = {chain.base: 0} | {joint.link: i for i, joint in enumerate(chain.joints, 1)}
    R, p = np.eye(3), np.zeros(3)
    here = link
    while here not in slots:
        joint = urdf.joints[here]
        xyz, rpy = origin_of(joint, f"{urdf.path}: joint {joint.get('name')!r}")
        turn = from_zyx(np.array([rpy[::-1]]))[0]
        R, p = turn @ R, turn @ p + xyz
        here = urdf.parent(here) or chain.base
    return slots[here], R, p


def _shapes(urdf: Urdf, link: str, shown: Pictures) -> list[Array]:
    """Points (V, 3) [m] of each shape in the link's frame: collision shapes, else visuals, else a bar."""
    place = f"{urdf.path}: link {link!r}"
    for kind in KINDS:
        found = [points for body in urdf.links[link].findall(kind) for points in _body(body, shown, place)]
        if found:
            return found
    ends = [origin_of(urdf.joints[child], place)[0] for child in urdf.children(link)
            if urdf.kind(child) in MOVING]  # fmt: skip
    box = box_points([2 * BONE] * 3)
    return [np.concatenate([box, box + end]) for end in ends if np.linalg.norm(end) > 2 * BONE]


def _body(body: ET.Element, shown: Pictures, place: str) -> list[Array]:
    shape = next(iter(body.find("geometry") or ()), None)
    if shape is None:
        return []
    xyz, rpy = origin_of(body, place)
    R = from_zyx(np.array([rpy[::-1]]))[0]
    if shape.tag == "mesh":
        parts = [mesh_points(part) for part in shown.get(mesh_key(shape), ())]
    else:
        parts = [_primitive(shape, place)]
    return [points @ R.T + np.array(xyz) for points in parts if len(points)]


def mesh_points(part: MeshPart) -> Array:
    """(V, 3) [m] corners of the hull of a file that Drake reads; none where it does not."""
    from pydrake.geometry import Convex

    try:
        hull = Convex(part.file, np.array(part.scale)).GetConvexHull()
    except RuntimeError:
        return np.zeros((0, 3))
    return np.array([hull.vertex(i) for i in range(hull.num_vertices())])


def box_points(size: Sequence[float]) -> Array:
    """(8, 3) corners of a box of these edges about its middle."""
    return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(size) / 2


def _primitive(shape: ET.Element, place: str) -> Array:
    """Points whose hull holds a box, cylinder, capsule or sphere of a URDF."""
    if shape.tag == "box":
        return box_points(vector(shape, "size", place))
    radius, length = (number(shape, key, place) for key in ("radius", "length"))
    half = np.pi / ROUND
    angle = 2 * half * np.arange(ROUND)
    circle = radius / np.cos(half) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if shape.tag == "cylinder":
        return np.concatenate(
            [np.column_stack([circle, np.full(ROUND, z)]) for z in (-length / 2, length / 2)]
        )
    if shape.tag in ("sphere", "capsule"):
        latitude = np.linspace(-np.pi / 2, np.pi / 2, ROUND // 2 + 1)[:, None]
        size = radius / np.cos(half)
        flat = np.cos(latitude)[..., None] * circle / np.cos(half)
        high = np.broadcast_to(size * np.sin(latitude), flat.shape[:2])
        ball = np.concatenate([flat, high[..., None]], axis=2).reshape(-1, 3)
        end = np.array([0.0, 0.0, length / 2])
        return np.concatenate([ball - end, ball + end])
    return np.zeros((0, 3))
