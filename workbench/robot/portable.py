"""A robot's URDF that goes with a result, so that the folder can be moved."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from pathlib import Path

from .packages import finder, mesh_file
from .urdf import read_root

FOLDER = "urdf"  # beside the file that names it


def carried(urdf: Path, folder: Path) -> tuple[str, str]:
    """The URDF's name and text as it stands in a folder that other files name it from.

    Meshes stay where they are, named from there: they are for pictures alone, and a folder that was moved
    away from them is shown with plain links. Raises `InputError` where the URDF cannot be read.
    """
    name = f"{FOLDER}/{urdf.name}"
    root = read_root(urdf)
    place, find = (folder / name).parent.resolve(), finder(urdf.parent)
    for mesh in root.iter("mesh"):
        if (file := mesh_file(mesh.get("filename", ""), urdf.parent, find)) is not None:
            mesh.set("filename", Path(os.path.relpath(file.resolve(), place)).as_posix())
    return name, ET.tostring(root, encoding="unicode") + "\n"
