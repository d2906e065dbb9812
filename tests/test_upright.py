"""Scenes stand as robots do: what hangs is seen to hang, and the camera looks at it there."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.report.meshcat_page import ON_THE_BASE, look, upright
from workbench.robot.description import load_robot


class Seen:
    """What a viewer is told."""

    def __init__(self):
        self.turned, self.camera = {}, None

    def SetTransform(self, name, X):
        self.turned[name] = X.rotation().matrix()

    def SetCameraPose(self, eye, middle):
        self.camera = eye, middle

    def __getattr__(self, name):
        return lambda *args, **more: None


@pytest.mark.parametrize("gravity", [(0, 0, -9.81), (0, 0, 9.81), (9.81, 0, 0), (0, -3.0, -9.3), (0, 0, 0)])
def test_a_robot_is_seen_as_it_hangs_or_stands(gravity):
    robot = replace(load_robot("ur5"), gravity=gravity)
    view = upright(robot)
    assert np.allclose(view.T @ view, np.eye(3))
    assert np.linalg.det(view) == pytest.approx(1)
    base, flange = np.zeros(3), np.array([0.6, 0.1, 0.7])  # in the base's frame
    seen = Seen()
    look(seen, view, ((base + flange) / 2 @ view).tolist(), 1.0, (flange - base) @ view)
    assert set(seen.turned) == set(ON_THE_BASE)
    for turn in seen.turned.values():
        down = turn @ gravity
        assert np.allclose(down, [0, 0, -np.linalg.norm(gravity)])
        middle = turn @ (flange + base) / 2
        assert np.linalg.norm(seen.camera[1] - middle) < 0.2
    assert seen.camera[0][2] > seen.camera[1][2]  # from above
    if gravity[2] <= 0 and not any(gravity[:2]):
        assert np.allclose(view, np.eye(3))
