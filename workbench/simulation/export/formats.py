"""The formats that a robot can be exported to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from . import dh, drake_package, mjcf, opw, sdf, ur_kinematics, urdf
from .content import Content
from .simulated import assumed
from .urdf import Files


def nothing(_: Content) -> list[str]:
    return []


@dataclass(frozen=True)
class Format:
    """One format. carries: see `kept.kept_of`. write: (content, header) → file name → what is in it. whole:
    the model as it is; otherwise the geometry makes up for what is left out (`kept.refitted`).

    has_flange: whether it holds how the flange stands on the last axis; else the geometry makes up for that
    as well. notes: what else a reader must know, a line each; flange: (N, 3) [m] and its rotation
    (N, 3, 3), of a format that only comes near the geometry. All raise `InputError` for a robot that the
    format cannot hold.
    """

    title: str
    carries: frozenset[str]
    write: Callable[[Content, list[str]], Files]
    notes: Callable[[Content], list[str]] = nothing
    flange: Callable[[Content], tuple[Array, Array]] | None = None
    whole: bool = False
    has_flange: Callable[[Content], bool] = lambda _: True


ELASTIC = frozenset({"mass", "spring", "coil"})
WHOLE = frozenset({"mass", "spring", "gas", "gear", "torque", "compensator"})


def in_drake(content: Content) -> list[str]:
    """What a user of the SDF must do."""
    x, y, z = content.robot.gravity
    return [
        *assumed(content),
        f"gravity is the plant's: set_gravity_vector([{x}, {y}, {z}]); Drake's own is 9.81",
        *urdf.mesh_notes(content),
    ]


SIMULATOR = (
    "in motion: Drake's Simulator as it comes (Runge–Kutta 3, accuracy 1e-4) is exact to 0.1 µm at the "
    "tool, as `verify` is; a fixed step has to be 0.1 ms or less, since a light wrist on a stiff damper "
    "diverges at 0.2 ms; implicit Euler at 1 ms costs 0.01 mm"
)


def in_mujoco(content: Content) -> list[str]:
    """What a user of the MJCF must know."""
    return [
        *assumed(content),
        f"its steps are {1e3 * mjcf.TIMESTEP:g} ms: a light wrist on stiff springs diverges at MuJoCo's 2 ms",
    ]


def with_simulator(content: Content) -> list[str]:
    """What a user of the package must do."""
    return [*in_drake(content), SIMULATOR]


FORMATS = {
    "urdf": Format("URDF, rigid", frozenset(), urdf.write, urdf.notes, has_flange=urdf.has_flange),
    "sdf": Format("SDF for Drake, elastic", ELASTIC, sdf.write, in_drake),
    "drake": Format(
        "package for Drake, elastic, with its effects",
        WHOLE,
        drake_package.write,
        with_simulator,
        whole=True,
    ),
    "mjcf": Format("MJCF for MuJoCo, elastic", ELASTIC, mjcf.write, in_mujoco),
    "ur-kinematics": Format(
        "Universal Robots' kinematics file, rigid",
        frozenset(),
        ur_kinematics.write,
        ur_kinematics.notes,
        has_flange=ur_kinematics.has_flange,
    ),
    "dh": Format("Denavit-Hartenberg tables, rigid", frozenset(), dh.write, dh.notes),
    "opw": Format("ortho-parallel arm, rigid and nearest", frozenset(), opw.write, flange=opw.near),
}


def find_format(name: str) -> Format:
    """The format of that name. Raises `InputError` with the names that there are."""
    if name not in FORMATS:
        raise InputError(Fault(f"--to {name}", "no such format", f"one of {', '.join(FORMATS)}"))
    return FORMATS[name]
