"""Meshes of a URDF in a form that Drake shows: OBJ by colour, few enough faces that a scene stays small.

Whatever is missing or cannot be read is left out of the picture, and said; nothing else depends on it.
"""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .chain import Chain
from .packages import Given, finder, in_package, mesh_file
from .urdf import Urdf, vector

FACES = 24_000  # of a whole robot: a scene with its loaded twin and many points stays under 5 MB
GRIDS = (100, 60, 40, 25)  # cells along a mesh
SHOWN_AS_IS = (".gltf", ".obj")  # by Drake's Meshcat
SMALL = 1_000_000  # bytes of a file that needs no fewer faces
CONVERTED = (".stl", ".dae", ".obj", ".gltf", ".glb", ".ply")
GLTF = (".gltf", ".glb")  # few loaders of URDF and SDF read it
ROOT_OF_GLTF = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # its y is up
HOW = "pip install 'robot-workbench[robots]'"

Key = tuple[str, str]  # filename and scale as the URDF has them


@dataclass(frozen=True)
class MeshPart:
    """A file that Drake shows, its scale, and its colour (r g b a) where the mesh itself has one."""

    file: Path
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    colour: str | None = None


Pictures = Mapping[Key, list[MeshPart]]
MeshFiles = Sequence[tuple[Key, Path | None]]


def mesh_key(mesh: ET.Element) -> Key:
    """How a `<mesh>` is known here."""
    return mesh.get("filename", ""), mesh.get("scale", "1 1 1")


def mesh_files(
    urdf: Urdf, chain: Chain, given: Given | None = None, kinds: Sequence[str] = ("visual", "collision")
) -> list[tuple[Key, Path | None]]:
    """The files of all meshes of the links, as often as they are; None where there is none.

    Of a link with shapes of the first of `kinds` these count; where their files lack, the next as well.
    """
    out: list[tuple[Key, Path | None]] = []
    beside = urdf.path.parent
    find = finder(beside, given)
    for link in urdf.below(chain.base):
        for kind in kinds:
            shapes = urdf.links[link].findall(f"{kind}/geometry/*")
            keys = [mesh_key(shape) for shape in shapes if shape.tag == "mesh"]
            found = [mesh_file(key[0], beside, find) for key in keys]
            out += zip(keys, found, strict=True)
            if shapes and None not in found:
                break
    return out


def mesh_notes(meshes: MeshFiles) -> list[str]:
    """What will not be seen in pictures, and what to do about it."""
    files, notes = dict(meshes), []
    missing = [name for (name, _), file in files.items() if file is None]
    if missing:
        packages = [in_package(name)[0] for name in missing]
        there = {in_package(name)[0] for (name, _), file in files.items() if file is not None}
        lacking = dict.fromkeys(package for package in packages if package and package not in there)
        each = " ".join(f"--package {package}=DIR" for package in lacking)
        mend = f"; say {each}, or set ROS_PACKAGE_PATH" if lacking else ""
        of = f"{len(missing)} of {len(files)} meshes" if len(files) > 1 else "the only mesh"
        what = f"{of} {'is' if len(missing) == 1 else 'are'} not there ({missing[0]}"
        notes.append(f"{what}{', ...' if len(missing) > 1 else ''}); only pictures need them{mend}")
    kinds = {file.suffix.lower() for file in files.values() if file is not None}
    strange = sorted(kinds - {*CONVERTED})
    if strange:
        notes.append(f"{', '.join(strange)} meshes cannot be shown; {', '.join(CONVERTED)} can")
    if not _library() and (unseen := sorted(kinds & {*CONVERTED} - {*SHOWN_AS_IS})):
        notes.append(f"{', '.join(unseen)} meshes are shown after {HOW}")
    return notes


def pictures(meshes: MeshFiles, folder: Path, as_is: bool = True) -> dict[Key, list[MeshPart]]:
    """What to show for each mesh; converted files go into `folder`.

    as_is: small files that Drake shows itself stay where they are.
    """
    found = {key: file for key, file in meshes if file is not None}
    share = FACES // max(1, sum(file is not None for _, file in meshes))
    out: dict[Key, list[MeshPart]] = {}
    for index, ((name, scale), file) in enumerate(found.items()):
        factors = vector(ET.Element("mesh", scale=scale), "scale", name)
        if as_is and file.suffix.lower() in SHOWN_AS_IS and file.stat().st_size <= SMALL:
            out[name, scale] = [MeshPart(file, factors)]
        elif _library() and file.suffix.lower() in CONVERTED:
            stem = folder / f"{index:02d}_{file.stem}"
            out[name, scale] = _converted(file, factors, stem, share)
    return out


def unreadable(meshes: MeshFiles, shown: Pictures) -> list[str]:
    """A line on the meshes that are there but came to nothing."""
    files = dict(meshes)
    broken = sorted({str(files[key]) for key, parts in shown.items() if not parts})
    many = f"{len(broken)} meshes are" if len(broken) > 1 else "a mesh is"
    return [f"{many} empty or cannot be read ({broken[0]})"] if broken else []


def _library() -> bool:
    return importlib.util.find_spec("trimesh") is not None


def _converted(file: Path, scale: tuple[float, float, float], stem: Path, faces: int) -> list[MeshPart]:
    """The mesh as OBJ files of one colour each, of about `faces` faces; none where it is unreadable."""
    import trimesh

    try:
        scene = trimesh.load_scene(file)
        if file.suffix.lower() in GLTF:
            scene.apply_transform(ROOT_OF_GLTF)
        bodies = _by_colour(scene, np.array(scale) * _metres(scene.units))
        share = min(1.0, faces / max(1, sum(len(mesh.faces) for _, mesh in bodies)))
        parts = []
        stem.parent.mkdir(parents=True, exist_ok=True)
        for number, (colour, mesh) in enumerate(bodies):
            mesh = _coarser(mesh, max(int(share * len(mesh.faces)), 24))
            path = stem.with_name(f"{stem.name}_{number}.obj")
            path.write_text(trimesh.exchange.obj.export_obj(
                mesh, include_normals=False, include_color=False, include_texture=False, header=None, digits=5
            ))  # fmt: skip
            parts.append(MeshPart(path, colour=colour))
    except Exception:  # whatever is wrong with a mesh, it is only a picture
        return []
    return parts


def obj_of_gltf(file: Path, mtl: str) -> tuple[str, str] | None:
    """A glTF mesh as OBJ, its z up, and its colours, without textures, as the OBJ's MTL, a file of the name
    `mtl`. None where the library lacks or the file is unreadable."""
    if not _library():
        return None
    import trimesh

    try:
        scene = trimesh.load_scene(file)
        scene.apply_transform(ROOT_OF_GLTF)
        for mesh in scene.geometry.values():
            material = getattr(mesh.visual, "material", None)
            if material is not None:
                rgba = np.asarray(material.main_color, dtype=float) / 255
                rgba[:3] = np.where(
                    rgba[:3] > 0.0031308, 1.055 * rgba[:3] ** (1 / 2.4) - 0.055, 12.92 * rgba[:3]
                )
                plain = trimesh.visual.material.SimpleMaterial(diffuse=np.rint(255 * rgba).astype(np.uint8))
                mesh.visual = trimesh.visual.TextureVisuals(material=plain)
        text, beside = trimesh.exchange.obj.export_obj(
            scene, include_normals=False, return_texture=True, mtl_name=mtl, header=None, digits=6
        )
    except Exception:  # whatever is wrong with a mesh, it is only a picture
        return None
    return text, beside.get(mtl, b"").decode()


def _coarser(mesh: Any, faces: int) -> Any:
    """The mesh with about so many faces at most: quadric decimation, or, where that gets stuck, its vertices
    drawn together on a grid."""
    if len(mesh.faces) <= faces:
        return mesh
    coarse = mesh.simplify_quadric_decimation(face_count=faces)
    for cells in GRIDS:
        if len(coarse.faces) <= 1.3 * faces:
            break
        coarse = mesh.copy()
        cell = float(max(mesh.extents)) / cells
        coarse.vertices = np.round(coarse.vertices / cell) * cell
        coarse.merge_vertices()
        coarse.update_faces(coarse.nondegenerate_faces() & coarse.unique_faces())
        coarse.remove_unreferenced_vertices()
    return coarse


def _by_colour(scene: Any, scale: np.ndarray) -> list[tuple[str | None, Any]]:
    """The scene's bodies in place, those of one colour as one mesh with its vertices merged."""
    import trimesh

    bodies: dict[str | None, list[Any]] = {}
    whole: Any
    for mesh in scene.dump():
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            material = getattr(mesh.visual, "material", None)
            rgba = None if material is None else np.asarray(material.main_color, dtype=float) / 255
            colour = None if rgba is None else " ".join(f"{value:.3g}" for value in rgba)
            bodies.setdefault(colour, []).append(trimesh.Trimesh(mesh.vertices, mesh.faces))
    out = []
    for colour, meshes in bodies.items():
        whole = trimesh.util.concatenate(meshes)
        whole.merge_vertices()
        whole.apply_transform(np.diag([*scale, 1.0]))
        out.append((colour, whole))
    return out


def _metres(units: str | None) -> float:
    """Metres of a unit as trimesh says it of a COLLADA file: "0.0254 * meters"."""
    factor, star, _ = (units or "").partition(" * meters")
    return float(factor) if star else 1.0
