"""Whether points of another scale are told from lengths that are off by all of themselves."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
from diagnosis_cases import measured
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from workbench.diagnosis.prepared import prepare
from workbench.robot.description import load_robot

BALL = np.array([0.0, 0.0, 0.166])
SOCKET = np.array([0.45, 0.2, 0.25])


def hand(joints, q):
    """(3,) where the ball is, by the URDF's own numbers: joints in the order of the file."""
    place, turned, moving = np.zeros(3), Rotation.identity(), iter(q)
    for joint in joints:
        origin, axis = joint.find("origin"), joint.find("axis")
        place = place + turned.apply([float(v) for v in origin.get("xyz").split()])
        turned = turned * Rotation.from_euler("xyz", [float(v) for v in origin.get("rpy").split()])
        if joint.get("type") == "revolute":
            turned = turned * Rotation.from_rotvec(
                next(moving) * np.array([float(v) for v in axis.get("xyz").split()])
            )
    return place + turned.apply(BALL)


def held(offset, tmp_path):
    """A ball at the hand of an iiwa held in one socket: `offset` is in the URDF twice, and not in the arm."""
    plan = measured("iiwa7", poses=60, loads=(), targets=1)
    true = list(ET.parse(plan.robot.urdf).getroot().iter("joint"))
    q = np.array([least_squares(lambda p: hand(true, p) - SOCKET, one).x for one in plan.poses.q])
    seen = SOCKET + np.random.default_rng(3).normal(0, 1e-4, (len(q), 3))
    robot = load_robot("iiwa7")
    for name in robot.urdf.parent.iterdir():
        (tmp_path / name.name).write_bytes(name.read_bytes())
    text = (tmp_path / robot.urdf.name).read_text(encoding="utf-8")
    shoulder, elbow = 'xyz="0 0 0.34"', 'xyz="0 0 0.4"'
    assert shoulder in text
    assert elbow in text
    text = text.replace(shoulder, f'xyz="{-offset} 0 0.34"').replace(elbow, f'xyz="{offset} 0 0.4"', 1)
    (tmp_path / robot.urdf.name).write_text(text, encoding="utf-8")
    ball = replace(plan.targets[0], xyz=tuple(BALL.tolist()))
    return replace(
        plan.with_poses(q=q), robot=load_robot(tmp_path / "iiwa7.toml"), points=seen[:, None], targets=(ball,)
    )


def test_short_lengths_that_are_not_there_are_no_scale(tmp_path):
    """A socket tells no scale. That two offsets of 0.4 mm in the URDF are not in the arm is no factor of all
    its lengths, as large as they are."""
    assert not [note for note in prepare([held(4e-4, tmp_path)]).notes if "All lengths" in note]
