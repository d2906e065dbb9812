"""A robot of which its TOML said something else: ratios unknown, joints rigid, stiffness as identified."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..robot.description import Robot, load_robot
from ..robot.schema import EffectRecord
from .model_file import write_model


def restated(robot: Robot, joints: Iterable[str] | None = None, **data: float | None) -> Robot:
    """The robot with other data of its joints (of all, or of those named): `stiffness=None`, say."""
    named = robot.joint_names if joints is None else tuple(joints)
    return replace(
        robot,
        joints=tuple(
            replace(joint, data=joint.data.model_copy(update=data)) if joint.name in named else joint
            for joint in robot.joints
        ),
    )


def stored(path: str | Path, robot: Robot, effects: Sequence[EffectRecord] = ()) -> Robot:
    """The robot with these effects and without corrections of its geometry, written and read again."""
    write_model(path, robot, np.zeros((len(robot.joints) + 2, 6)), effects)
    return load_robot(path)
