"""From a path's file and a model's to a controller's program on disk."""

from __future__ import annotations

import pathlib
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import load_robot
from ..robot.kinematics import Array
from .command import BANDWIDTH_HZ, EXACT, Compensation, compensate
from .conditions import Conditions
from .paths import load_path
from .programs import RoundingEffect, find_format, rounding_effect, write_program


@dataclass(frozen=True, eq=False)
class Written:
    """A compensated program on disk. rounding: what the format's decimals do at the tool."""

    compensation: Compensation
    files: tuple[pathlib.Path, ...]
    rounding: RoundingEffect

    def lines(self) -> list[str]:
        """What a user should know, a line each."""
        return [*self.compensation.lines(), str(self.rounding)]

    @property
    def text(self) -> str:
        """For the terminal: what a user should know, and the files."""
        return "\n".join([*self.lines(), *(str(file) for file in self.files)])

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        done = self.compensation
        sizes = {
            f"{name}_{what}_mm": float(size)
            for name, error in (("before", done.before_mm), ("after", done.after_mm))
            for what, size in (("rms", np.sqrt((error**2).mean())), ("max", error.max()))
        }
        return {
            "schema": 1,
            "files": [str(file) for file in self.files],
            "samples": len(done.path),
            **sizes,
            "left_out": [str(item) for item in done.left_out],
            "troubles": [{"sample": t.index, "kind": t.kind, "what": t.what} for t in done.troubles],
            "notes": list(done.notes),
            "rounding": asdict(self.rounding),
        }


def compensate_file(
    path: str | pathlib.Path,
    model: str | pathlib.Path,
    format: str = "csv",
    out: str | pathlib.Path | None = None,
    *,
    conditions: Conditions | None = None,
    tool: Array | None = None,
    start: Array | None = None,
    method: str = EXACT,
    bandwidth_hz: float = BANDWIDTH_HZ,
    seed: int = 0,
) -> Written:
    """Reads a path, corrects it for the model's robot and writes the program.

    out: the file, or a folder; default: beside the path, with `_compensated` and the format's extension.
    Raises `InputError` with all faults, and then nothing is written.
    """
    chosen = find_format(format)
    robot = load_robot(model)
    turning = sum(joint.kind == "revolute" for joint in robot.joints)
    if chosen.arm_joints not in (None, turning):
        what = f"{turning} turning joints; poses in {chosen.title} say the posture of {chosen.arm_joints}"
        raise InputError(Fault(f"{model}: {robot.name}", what, "use csv"))
    wanted = load_path(path, robot)
    done = compensate(
        robot, wanted, conditions, tool=tool, start=start, method=method, bandwidth_hz=bandwidth_hz, seed=seed
    )
    source = pathlib.Path(path)
    place = pathlib.Path(out) if out else source.with_name(f"{source.stem}_compensated{chosen.extension}")
    name = chosen.legal_name(place.stem if not place.is_dir() else source.stem)
    # a table of joints says more than one of poses: the redundancy of seven joints, rails, few joints
    as_joints = chosen.name == "csv" and (wanted.q is not None or len(robot.joints) != 6)
    program = done.program(name, "joints" if as_joints else "poses")
    if wanted.dwell is not None:
        program = replace(program, dwell=wanted.dwell)
    files = write_program(program, chosen, place)
    return Written(done, tuple(files), rounding_effect(program, chosen, done.forward))
