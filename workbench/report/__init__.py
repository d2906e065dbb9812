"""The report of a diagnosis: page, PDF, scene and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from ..diagnosis.found import Array
from ..diagnosis.result import Diagnosis
from ..robot.description import Robot
from .folder import json_bytes, write_together


def write_all(
    diagnosis: Diagnosis,
    robot: Robot,
    folder: str | Path,
    q: Array,
    ghost_q: Array | None = None,
    ghost_label: str = "",
    beside: Mapping[str, bytes] = MappingProxyType({}),
) -> tuple[Path, ...]:
    """Write `result.json`, `index.html`, `report.pdf`, `scene.html` and `residuals.csv`; their paths.

    Everything is made before anything is written, so a failure leaves the folder as it was.
    `q`, `ghost_q`, `ghost_label`: of the scene, see `scene.Shown`. beside: more files, by name.
    """
    from .content import gather
    from .page import page
    from .pdf import pdf
    from .residuals import residuals
    from .scene import scene

    material = gather(diagnosis)
    made = {
        "result.json": json_bytes(diagnosis.to_json()),
        "index.html": page(material).encode(),
        "report.pdf": pdf(material),
        "scene.html": scene(diagnosis, robot, q, ghost_q, ghost_label).encode(),
        **residuals(diagnosis),
        **beside,
    }
    return write_together(Path(folder), made)
