"""Programs from the URDF's joints and frames to the controller's own, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...files.faults import Fault, InputError
from ...robot.convention import Convention
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.schema import LoadData
from .base import Program
from .posture import posture

AS_URDF = "As the URDF has joints and frames: not checked against the controller"


def as_shown(program: Program, robot: Robot, as_urdf: bool = False) -> Program:
    """A program of the URDF's joints and frames as the robot's controller counts them.

    Raises `InputError` where the robot's TOML does not say how that is, unless `as_urdf`: then nothing is
    changed, and the program says so in a comment.
    """
    if as_urdf:
        return replace(program, notes=(*program.notes, AS_URDF))
    convention = stated_convention(robot)
    order, sliding = rails_first(convention)
    q, flags = program.q, program.posture
    if q is not None:
        if program.kind == "poses" and flags is None:
            flags = posture(robot, convention, q)
        q = convention.shown(q)[:, order]
    return replace(
        program,
        X=None if program.X is None else convention.to_world(program.X),
        via=None if program.via is None else convention.to_world(program.via),
        q=q,
        sliding=sliding if q is not None else (),
        tool=convention.to_flange(program.tool),
        load=None if program.load is None else turned_load(program.load, convention.to_flange(np.eye(4))),
        base=program.base,
        posture=flags,
    )


def as_urdf(program: Program, robot: Robot) -> Program:
    """A program as read from a controller's file, in the URDF's joints and frames: the way back."""
    convention = stated_convention(robot)
    order, sliding = rails_first(convention)
    q = program.q
    if q is not None and q.shape[1] == len(order):
        shown = np.empty_like(q)
        shown[:, order] = q
        q = convention.joints(shown)
        sliding = robot.sliding
    return replace(
        program,
        X=None if program.X is None else convention.from_world(program.X),
        via=None if program.via is None else convention.from_world(program.via),
        q=q,
        sliding=sliding if q is not None and q.shape[1] == len(sliding) else program.sliding,
        tool=convention.from_flange(program.tool),
        load=None if program.load is None else turned_load(program.load, convention.flange),
        posture=None,
    )


def stated_convention(robot: Robot) -> Convention:
    """The convention that the robot's TOML states; `InputError` where it does not."""
    convention = robot.convention
    if convention is None:
        place = str(robot.path or robot.name)
        what = "does not say how the controller counts the joints: no [controller]"
        mend = "state names, signs, zeros and couplings there, or write the URDF's own with --as-urdf"
        raise InputError(Fault(place, what, mend))
    return convention


def rails_first(convention: Convention) -> tuple[list[int], tuple[bool, ...]]:
    """Order of a program's joints among the controller's: external axes, then the arm; and which slide."""
    n = len(convention.names)
    order = sorted(range(n), key=lambda k: not convention.external[k])
    return order, tuple(convention.sliding[k] for k in order)


def turned_load(load: LoadData, X: Array) -> LoadData:
    """The load with its centre of mass in the frame in which its own frame stands at X."""
    x, y, z = (X[:3, :3] @ load.com_mm + 1e3 * X[:3, 3]).tolist()
    return LoadData(mass_kg=load.mass_kg, com_mm=(x, y, z))
