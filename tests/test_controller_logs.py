"""Joint positions as controllers log them: what their columns are called, and in which order they stand."""

from __future__ import annotations

import numpy as np
import pytest
from test_instrument_files import ANGLES, ARM, JOINTS, cells, joint_columns, numbered

from workbench.campaign.guess import guess_poses

OTHERS = ANGLES[:, ::-1] / 7
LACKING = numbered("joint {}", 1)


@pytest.mark.parametrize(
    ("names", "columns", "wanted"),
    [
        ([*numbered("MACur.A{}"), *numbered("AIPos.A{}"), *numbered("ASPos.A{}")], (OTHERS, ANGLES, ANGLES),
         numbered("ASPos.A{}")),
        (["t [s]", *numbered("$AXIS_ACT.A{}")], (ANGLES[:, 0], ANGLES), numbered("$AXIS_ACT.A{}")),
        ([*numbered("Istposition A{} [°]"), *numbered("Sollposition A{} [°]")], (ANGLES, ANGLES),
         numbered("Sollposition A{} [°]")),
        (numbered("Controller1/ROB_1/J{}"), (ANGLES,), numbered("Controller1/ROB_1/J{}")),
        ([*numbered("Axis {} Torque"), *numbered("Axis {} Position")], (OTHERS, ANGLES),
         numbered("Axis {} Position")),
        ([*numbered("Joint{}_Torque"), *numbered("Joint{}_Angle")], (OTHERS, ANGLES),
         numbered("Joint{}_Angle")),
        ([*numbered("Joint_Torque[{}]", 0), *numbered("Joint_Angle[{}]", 0)], (OTHERS, ANGLES),
         numbered("Joint_Angle[{}]", 0)),
        ([*numbered("Position error J{}"), *numbered("Current position J{}")], (OTHERS, ANGLES),
         numbered("Current position J{}")),
        ([*numbered("/vel_controller/joint_{}/effort"), *numbered("/vel_controller/joint_{}/position")],
         (OTHERS / 60, ANGLES / 60), numbered("/vel_controller/joint_{}/position")),
        (numbered("θ{}"), (ANGLES,), numbered("θ{}")),
        ([*numbered("Gelenk {} [A]"), *numbered("Gelenk {} [Grad]")], (OTHERS, ANGLES),
         numbered("Gelenk {} [Grad]")),
        (["S", "L", "U", "R", "B", "T"], (ANGLES,), ["S", "L", "U", "R", "B", "T"]),
        (["S", "L", "U", "R", "B", "time"], (ANGLES,), LACKING),
        (numbered("Torque J{}"), (OTHERS,), LACKING),
        (numbered("/joint_states/position[{}]", 0), (ANGLES / 60,), LACKING),
    ],
)  # fmt: skip
def test_what_controllers_call_their_joints(tmp_path, names, columns, wanted):
    """Torques and currents of the joints are called alike; positions by number alone may be in any order."""
    assert joint_columns(tmp_path, names, columns) == wanted


def test_positions_by_number_are_said_to_have_an_order_of_their_own(tmp_path):
    rows = [cells(row / 60) for row in ANGLES]
    head = ",".join(numbered("/joint_states/position[{}]", 0))
    (tmp_path / "poses.csv").write_text("\n".join([head, *rows, ""]))
    assert "in the order of the message's names" in guess_poses(tmp_path / "poses.csv", ARM).why


@pytest.mark.parametrize("header", [True, False])
@pytest.mark.parametrize("gripper", [[], ["finger_joint"]])
def test_joint_states_stand_in_the_order_of_their_names(tmp_path, header, gripper):
    """A message has them in the order of the alphabet: the shoulder was read as the elbow."""
    names = sorted([*JOINTS, *gripper])
    kinds = ("name", "position", "velocity")
    head = ["sec", *(f"{kind}[{k}]" for kind in kinds for k in range(len(names)))]
    at = {name: ANGLES[:, j] / 60 for j, name in enumerate(JOINTS)} | {"finger_joint": np.zeros(12)}
    rows = [f"{i},{','.join(names)},{cells([at[n][i] for n in names])},{cells(0 * np.arange(len(names)))}"
            for i in range(12)]  # fmt: skip
    (tmp_path / "poses.csv").write_text("\n".join([*([",".join(head)] * header), *rows, ""]))
    found = guess_poses(tmp_path / "poses.csv", ARM).keys["columns"]
    behind = [1 + len(names) + names.index(name) for name in JOINTS]
    assert [found[f"q{j}_rad"] for j in range(1, 7)] == [head[i] if header else i + 1 for i in behind]
