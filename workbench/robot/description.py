"""A robot: its URDF (the nominal rigid arm) and its TOML (what URDF cannot say).

The same loader reads the models that come with the workbench, a user's own robot by path, and
the `model.toml` that a diagnosis writes: that is a robot TOML with `[geometry]` and `[[effects]]`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.faults import Fault, InputError
from ..files.toml_place import with_lines
from .chain import MovingJoint, read_chain
from .convention import Controller, Convention, convention_of
from .find import find_robot
from .loop import Loop
from .schema import (
    FLANGE,
    GEOMETRY,
    STANDARD_GRAVITY,
    Compensator,
    EffectRecord,
    JointData,
    LoadData,
    Vector3,
    parse_robot,
    unknown_names,
)
from .uncertainty import Uncertainty
from .urdf import read_urdf


@dataclass(frozen=True)
class Joint(MovingJoint):
    """One moving joint of the chain from base to flange, with what the TOML says of it."""

    data: JointData


@dataclass(frozen=True)
class Robot:
    """A robot as loaded and checked. `joints` run from the base to the flange.

    controller: how the robot's controller counts the joints, as stated; `convention` as arrays.
    tool, payloads: what the campaign behind a model.toml carried; they count only where nobody states
    other loads (a campaign always does). pose_repeatability_mm: ISO 9283 RP by the maker's data sheet.
    """

    name: str
    title: str
    urdf: Path
    flange: str
    gravity: Vector3
    base: str
    joints: tuple[Joint, ...]
    compensator: Compensator | None = None
    bending_stiffness: dict[str, float] = field(default_factory=dict)
    controller: Controller = field(default_factory=Controller)
    source: dict[str, Any] = field(default_factory=dict)
    tool: LoadData | None = None
    payloads: dict[str, LoadData] = field(default_factory=dict)
    mounted: str = ""
    geometry: dict[str, dict[str, float]] = field(default_factory=dict)
    effects: tuple[EffectRecord, ...] = ()
    path: Path | None = None
    loop: Loop = field(default_factory=Loop)
    uncertainty: Uncertainty | None = None
    pose_repeatability_mm: float | None = None

    def __repr__(self) -> str:
        joints = ", ".join(f"{joint.name} ({joint.kind})" for joint in self.joints)
        return f"Robot {self.name}: {self.title}, from {self.base} to {self.flange} by {joints}"

    @property
    def files(self) -> tuple[Path, ...]:
        """What it was read from: its TOML, where there is one, and its URDF."""
        return (self.urdf,) if self.path is None else (self.path, self.urdf)

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    @property
    def corrected_frames(self) -> tuple[str, ...]:
        """What `[geometry]` corrects: the joints' frames, then the flange (unless a joint is called so)."""
        return tuple(dict.fromkeys((*self.joint_names, FLANGE)))

    def corrected(self, geometry: NDArray[np.float64]) -> Robot:
        """The same with corrections (S, 6) of the arm's slots [m, rad] as its `[geometry]`."""
        rows = zip(self.corrected_frames, geometry[1:].tolist(), strict=False)
        found = {name: dict(zip(GEOMETRY, row, strict=True)) for name, row in rows}
        return replace(self, geometry=found)

    @property
    def links(self) -> tuple[str, ...]:
        """The moving links, base to flange: `links[i]` is carried by `joints[i]`."""
        return tuple(joint.link for joint in self.joints)

    @property
    def sliding(self) -> tuple[bool, ...]:
        """Which joints slide, base to flange; the others turn."""
        return tuple(joint.kind == "prismatic" for joint in self.joints)

    @property
    def limits(self) -> NDArray[np.float64]:
        """(n, 2) lower and upper limit of each joint [rad, m], infinite where there is none."""
        return np.array([(joint.lower, joint.upper) for joint in self.joints])

    @property
    def repeatability(self) -> NDArray[np.float64]:
        """(n,) of the joints, one sigma [rad, m]; zero where the TOML states none."""
        return np.array([joint.data.repeatability or 0.0 for joint in self.joints])

    @property
    def convention(self) -> Convention | None:
        """How the controller counts the joints; None where the TOML does not say."""
        said = self.controller
        return convention_of(said, self.joint_names, self.sliding) if said.names else None

    def joint(self, name: str) -> Joint:
        """The joint of that name. Raises KeyError when there is none."""
        return {joint.name: joint for joint in self.joints}[name]


def load_robot(robot: str | Path) -> Robot:
    """Load a robot by name or by path and check it.

    robot: a name that `list_robots` has, or the path of a robot's TOML, a model.toml included. Raises
    `InputError` with every fault of the TOML and the URDF.

    >>> from workbench import load_robot
    >>> robot = load_robot("cylindrical")
    >>> [(joint.name, joint.kind) for joint in robot.joints]
    [('joint_1', 'revolute'), ('joint_2', 'prismatic'), ('joint_3', 'prismatic')]
    >>> robot.joint("joint_1").data.stiffness  # N·m/rad
    1000000.0
    """
    path = find_robot(robot)
    file = parse_robot(path)
    urdf = path.parent / file.urdf
    found = read_chain(read_urdf(urdf), file.flange, file.base)
    base, chain = found.base, found.joints
    said = {joint.name: joint for joint in file.joints}
    names = [moving.name for moving in chain]
    faults = [
        Fault(
            f"{path}: joints.{name}", "no moving joint of the URDF between base and flange", f"has: {names}"
        )
        for name in said
        if name not in names
    ]
    faults += unknown_names(path, file, names, {base, *(moving.link for moving in chain)})
    sliding = [moving.kind == "prismatic" for moving in chain]
    faults += file.controller.faults(f"{path}: controller", names, sliding)
    if faults:
        raise InputError(with_lines(faults, path))
    return Robot(
        name=file.name,
        title=file.title or file.name,
        urdf=urdf,
        flange=file.flange,
        gravity=file.gravity or _along(found.down),
        base=base,
        joints=tuple(
            Joint(**vars(moving), data=said.get(moving.name, JointData(name=moving.name))) for moving in chain
        ),
        compensator=file.compensator,
        bending_stiffness={
            link.name: link.bending_stiffness for link in file.links if link.bending_stiffness is not None
        },
        controller=file.controller,
        source=file.source,
        tool=file.tool,
        payloads=file.payloads,
        mounted=file.mounted,
        geometry=file.geometry,
        effects=file.effects,
        path=path,
        loop=file.controller.loop,
        uncertainty=file.prediction,
        pose_repeatability_mm=file.pose_repeatability_mm,
    )


def _along(down: Vector3) -> Vector3:
    """Standard gravity [m/s²] along a unit vector."""
    x, y, z = (STANDARD_GRAVITY * value for value in down)
    return x, y, z
