"""Triangle meshes by lofting rings, smooth where the surface is, and glTF text with them inside.

Lengths in mm until the file is written (m). The numbers are put on a grid before they are
written, off the middle between two grid points, so that every machine writes the same bytes.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

CREASE = np.cos(np.radians(58.0))
POSITION_GRID, NORMAL_GRID = 5e-5, 2e-3


@dataclass(frozen=True)
class Paint:
    """A colour (sRGB, 0..255) and how it shines."""

    rgb: tuple[int, int, int]
    metallic: float = 0.0
    roughness: float = 0.75

    def material(self) -> dict[str, object]:
        linear = [round((c / 255) ** 2.2, 4) for c in self.rgb]
        surface = {"baseColorFactor": [*linear, 1.0], "metallicFactor": self.metallic}
        return {"pbrMetallicRoughness": {**surface, "roughnessFactor": self.roughness}}


@dataclass(frozen=True)
class Mesh:
    """A closed surface: vertices (v, 3) [mm], faces (f, 3), counter-clockwise from outside.

    The last `flat` faces are its flat ends.
    """

    vertices: Array
    faces: NDArray[np.int64]
    flat: int

    def moved(self, rotation: Array, origin: ArrayLike) -> Mesh:
        moved = np.einsum("ij,vj->vi", rotation, self.vertices) + np.asarray(origin)
        return Mesh(moved, self.faces, self.flat)


Shape = list[tuple[Paint, Mesh]]


def loft(rings: Sequence[Array]) -> Mesh:
    """Closed surface through rings of equally many points, with flat ends; each ring (n, 3)."""
    m, n = len(rings), len(rings[0])
    vertices = np.vstack([*rings, rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    faces = []
    for i in range(m - 1):
        for j in range(n):
            a, b = i * n + j, i * n + (j + 1) % n
            faces += [(a, b, b + n), (a, b + n, a + n)]
    for j in range(n):
        k = (j + 1) % n
        faces += [(m * n, k, j), (m * n + 1, (m - 1) * n + j, (m - 1) * n + k)]
    made = np.array(faces)
    p, q, r = (vertices[made[:, i]] for i in range(3))
    volume = np.sum(np.cross(p, q) * r)
    return Mesh(vertices, made if volume > 0 else made[:, ::-1], 2 * n)


def gltf(shape: Shape) -> str:
    """glTF 2.0 text of a shape in link coordinates; its buffer stands inside."""
    blob = b""
    views: list[dict[str, object]] = []
    accessors: list[dict[str, object]] = []
    primitives: list[dict[str, object]] = []
    materials: list[dict[str, object]] = []
    paints = list(dict.fromkeys(paint for paint, _ in shape))
    for paint in paints:
        positions, normals, indices = _surface([mesh for other, mesh in shape if other == paint])
        start = len(accessors)
        for data, kind in ((positions, "VEC3"), (normals, "VEC3"), (indices, "SCALAR")):
            views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": data.nbytes})
            accessor: dict[str, object] = {"bufferView": len(views) - 1, "count": len(data), "type": kind}
            accessor["componentType"] = 5123 if kind == "SCALAR" else 5126
            accessors.append(accessor)
            blob += data.tobytes() + b"\0" * (-data.nbytes % 4)
        accessors[start] |= {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
        primitives.append(
            {
                "attributes": {"POSITION": start, "NORMAL": start + 1},
                "indices": start + 2,
                "material": len(materials),
            }
        )
        materials.append(paint.material())
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob), "uri": _data_uri(blob)}],
    }
    return json.dumps(content, separators=(",", ":")) + "\n"


def _data_uri(blob: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(blob).decode()


def _surface(meshes: Sequence[Mesh]) -> tuple[NDArray, NDArray, NDArray]:
    """Positions and normals (float32) and indices (uint16) of several meshes as one, y up as in glTF."""
    corners: dict[tuple[int, ...], int] = {}
    indices = []
    for mesh in meshes:
        places = _on_grid(mesh.vertices / 1000, POSITION_GRID)
        normals = _on_grid(_corner_normals(mesh), NORMAL_GRID)
        for face, face_normals in zip(mesh.faces, normals, strict=True):
            if len({tuple(places[v]) for v in face}) < 3:
                continue
            for vertex, normal in zip(face, face_normals, strict=True):
                key = (*places[vertex].tolist(), *normal.tolist())
                indices.append(corners.setdefault(key, len(corners)))
    table = np.array(list(corners), dtype=float)
    y_up = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    positions = (table[:, :3] @ y_up.T * POSITION_GRID).astype("<f4")
    normals = table[:, 3:] @ y_up.T
    length = np.sqrt(np.sum(normals**2, axis=1, keepdims=True))
    return positions, (normals / length).astype("<f4"), np.array(indices, dtype="<u2")


def _on_grid(values: Array, grid: float) -> NDArray[np.int64]:
    return np.floor(values / grid + 0.5 + 1e-4).astype(np.int64)


def _corner_normals(mesh: Mesh) -> Array:
    """(f, 3, 3): at each corner the mean of the faces there that meet it smoothly, by area squared.

    A flat end keeps its own normal, so that it looks flat.
    """
    p, q, r = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    areas = np.cross(q - p, r - p)
    size = np.sqrt(np.sum(areas**2, axis=1, keepdims=True))
    units = areas / np.maximum(size, 1e-12)
    weighted = areas * size / np.max(size)
    weighted[len(weighted) - mesh.flat :] *= 1e3
    around: dict[int, list[int]] = {}
    for f, face in enumerate(mesh.faces):
        for vertex in face:
            around.setdefault(int(vertex), []).append(f)
    normals = np.empty((len(mesh.faces), 3, 3))
    for f, face in enumerate(mesh.faces):
        for corner, vertex in enumerate(face):
            near = np.array(around[int(vertex)])
            smooth = near[np.sum(units[near] * units[f], axis=1) > CREASE]
            total = weighted[smooth].sum(axis=0) if len(smooth) else units[f]
            normals[f, corner] = total / max(np.sqrt(np.sum(total**2)), 1e-12)
    return normals
