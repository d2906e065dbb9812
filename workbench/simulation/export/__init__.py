"""The corrected robot for other programs: `export` writes one format, and says what it leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...campaign import Campaign
from ...correction.conditions import Conditions, stated_conditions
from ...files.digest import digests
from ...report.folder import write_together
from ...robot.description import Robot, load_robot
from .content import content_of
from .formats import FORMATS, find_format
from .kept import kept_of, refitted
from .left_out import Cost, cost

__all__ = ["FORMATS", "Cost", "Exported", "export"]


@dataclass(frozen=True, eq=False)
class Exported:
    """What was written. header: what stands at the top of the files; inputs: "<folder>/<file>" → SHA-256."""

    format: str
    files: tuple[Path, ...]
    cost: Cost
    header: tuple[str, ...]
    inputs: Mapping[str, str]

    @property
    def text(self) -> str:
        """For the terminal."""
        return "\n".join([*self.header, *(str(file) for file in self.files)])

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        files = [str(file) for file in self.files]
        return {
            "schema": 1,
            "format": self.format,
            "files": files,
            **asdict(self.cost),
            "inputs": dict(self.inputs),
        }


def export(
    robot: Robot | str | Path,
    to: str,
    out: str | Path,
    *,
    campaign: Campaign | None = None,
    conditions: Conditions | None = None,
) -> Exported:
    """Writes the robot in the format `to` into the folder `out`.

    robot: loaded, by name, or the path of a TOML (a model.toml). campaign: in whose poses is weighed what the
    format leaves out; default: drawn ones. conditions: tool and payload; default: the model's tool alone.
    Raises `InputError` when the format cannot hold this robot; then nothing is written.

    >>> from tempfile import mkdtemp
    >>> from workbench import export
    >>> written = export("cylindrical", "sdf", mkdtemp())
    >>> written.files[0].name, written.cost.max_mm < 1e-6
    ('cylindrical.sdf', True)
    """
    chosen = find_format(to)
    loaded = robot if isinstance(robot, Robot) else load_robot(robot)
    content = content_of(loaded, campaign, stated_conditions(loaded) if conditions is None else conditions)
    kept = kept_of(content, chosen.carries)
    written = content if chosen.whole else refitted(content, kept, chosen.has_flange(content))
    near = chosen.flange(written) if chosen.flange else None
    lost = cost(content, kept, written, near)
    title = f"{loaded.title}: {chosen.title}; written by robot-workbench"
    header = [title, *lost.lines(), *_counted(loaded), *chosen.notes(written)]
    files = write_together(Path(out), chosen.write(written, header))
    read = {**digests(loaded.files), **({} if campaign is None else campaign.files)}
    return Exported(to, files, lost, tuple(header), read)


def _counted(robot: Robot) -> list[str]:
    """Whose base and joints the file has."""
    found = []
    if robot.uncertainty is not None and not robot.uncertainty.base_measured:
        found.append(
            "base: axis 1 stands in it as the nominal robot has it; no target on the base was measured"
        )
    if robot.uncertainty is not None and not robot.uncertainty.flange_measured:
        found.append(
            f"flange: how it stands about and along the axis of {robot.joint_names[-1]} nobody measured; no "
            "two targets on it are stated as calibrated (fixed = true)"
        )
    if robot.controller.model_dump(exclude_defaults=True):
        found.append(
            "joints: as the URDF counts them; the controller's own zeros, signs and couplings are others"
        )
    return found
