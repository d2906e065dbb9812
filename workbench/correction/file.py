"""From a path's file and a model's to a controller's program on disk."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..files.digest import digests
from ..files.faults import Fault, InputError
from ..robot.description import load_robot
from ..robot.kinematics import Array
from .command import Compensation, compensate
from .conditions import Conditions, carried, stated_conditions
from .paths import load_path
from .programs import (
    Format,
    Program,
    RoundingEffect,
    as_shown,
    as_urdf,
    find_format,
    formats,
    rounding_effect,
    thinned,
    write_program,
)
from .programs.files import is_folder

TOLERANCE_MM = 0.01  # of thinning on the command line: what a robot repeats to, and less

UNSTATED = (
    "joints and frames are as the URDF has them, not checked against the controller; state names, "
    "signs, zeros and couplings there before an arm is driven by this program"
)


@dataclass(frozen=True, eq=False)
class Written:
    """A compensated program on disk. rounding: what the format's decimals do at the tool; points: of the
    program, fewer than samples where legs were put together; inputs: "<folder>/<file>" → SHA-256; warnings:
    what the program is not checked against."""

    compensation: Compensation
    files: tuple[pathlib.Path, ...]
    rounding: RoundingEffect
    points: int
    inputs: Mapping[str, str]
    warnings: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """What a user should know, a line each."""
        fewer = self.points < len(self.compensation.path)
        thinned = [f"{len(self.compensation.path)} samples in {self.points} points"] if fewer else []
        return [*self.compensation.lines(), *thinned, str(self.rounding)]

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
            "points": self.points,
            **sizes,
            "between_max_mm": done.between_mm,
            "left_out": [str(item) for item in done.left_out],
            "troubles": [{"sample": t.index, "kind": t.kind, "what": t.what} for t in done.troubles],
            "notes": [*done.notes, *self.warnings],
            "rounding": asdict(self.rounding),
            "inputs": dict(self.inputs),
        }


@dataclass(frozen=True)
class Export:
    """How a program is to be written.

    base: (4, 4) frame in the controller's world in which the poses are stated; joints: targets of joints in
    place of poses; tolerance_mm: how far the fewest lines and circles may leave the path's points, 0 keeps
    them all; as_urdf: joints and frames as the URDF has them, whatever the controller counts; keep: files
    that are there already are not replaced.
    """

    base: Array | None = None
    joints: bool = False
    tolerance_mm: float = 0.0
    as_urdf: bool = False
    keep: bool = False


def compensate_file(
    path: str | pathlib.Path,
    model: str | pathlib.Path,
    format: str = "csv",
    out: str | pathlib.Path | None = None,
    *,
    conditions: Conditions | None = None,
    tool: Array | None = None,
    start: Array | None = None,
    seed: int = 0,
    export: Export | None = None,
) -> Written:
    """Reads a path, corrects it for the model's robot and writes the program.

    out: a file with the format's extension, or a folder; default: beside the path, with `_compensated`.
    Where the robot does not state how its controller counts, a program is as the URDF has it, with a
    warning. Raises `InputError` with all faults, and then nothing is written.
    """
    chosen, export = find_format(format), export or Export()
    robot = load_robot(model)
    turning = sum(joint.kind == "revolute" for joint in robot.joints)
    if chosen.arm_joints not in (None, turning):
        what = f"{turning} turning joints; poses in {chosen.title} say the posture of {chosen.arm_joints}"
        raise InputError(Fault(f"{model}: {robot.name}", what, "use csv"))
    unstated = chosen.own_joints and not export.as_urdf and robot.convention is None
    if unstated:
        export = replace(export, as_urdf=True)
    wanted = load_path(path, robot)
    conditions = conditions or stated_conditions(robot)
    done = compensate(robot, wanted, conditions, tool=tool, start=start, seed=seed)
    source = pathlib.Path(path)
    read = digests([source, *robot.files])  # before the program is written, which may replace the path
    place = pathlib.Path(out) if out else source.with_name(f"{source.stem}_compensated{chosen.extension}")
    name = chosen.legal_name(source.stem if is_folder(place, chosen) else place.stem)
    program = _program(done, chosen, export, conditions, name)
    if chosen.own_joints:
        program = as_shown(program, robot, export.as_urdf)
    files = write_program(program, chosen, place, export.keep)

    def forward(q: Array) -> Array:
        """The controller's joints → tool poses."""
        if not chosen.own_joints or export.as_urdf:
            return done.trajectory.forward(q)
        told = as_urdf(Program("", q=q, kind="joints", sliding=program.sliding), robot).q
        assert told is not None
        return done.trajectory.forward(told)

    effect = rounding_effect(program, chosen, forward)
    warnings = [f"{model}: no [controller]: {UNSTATED}"] if unstated else []
    if _of_another_maker(chosen, robot.controller.make):
        warnings.append(
            f"{model}: the controller is of {robot.controller.make}, the program is {chosen.title}"
        )
    return Written(done, tuple(files), effect, program.count, read, tuple(warnings))


def _of_another_maker(format: Format, make: str) -> bool:
    """Whether the controller's maker, as the robot's TOML states it, has another format."""
    said = f" {make.casefold()} "
    owners = [other for other in formats().values() if any(f" {name} " in said for name in other.makers)]
    return bool(owners and format.makers) and format not in owners


def _program(
    done: Compensation, format: Format, export: Export, conditions: Conditions, name: str
) -> Program:
    """The command as it is to be written, in the URDF's joints and frames."""
    # a table of joints says more than one of poses: the redundancy of seven joints, rails, few joints
    as_joints = export.joints or (format.samples and (done.path.q is not None or len(done.sliding) != 6))
    program = done.program(name, "joints" if as_joints else "poses")
    if done.path.dwell is not None:
        program = replace(program, dwell=done.path.dwell)
    if export.base is not None:
        program = replace(program, base=export.base)
    program = replace(program, load=carried(conditions))
    if as_joints or format.samples:
        return program
    return thinned(program, 1e-3 * export.tolerance_mm, format.circles)
