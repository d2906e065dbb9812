"""The cylindrical robot of a homework on calibration (2020): one revolute and two prismatic joints."""

import numpy as np

from ..design import Design, Limits, Mass, Masses
from ..kinematics import chain_along, pose
from ..looks.cylindrical import cylindrical

LIFT, REACH = 500.0, 500.0  # l1, l2 [mm]

# T = Rz(q1) Tz(l1 + q2) Tx(l2 + q3)
KINEMATICS = chain_along(
    [
        ("revolute", (0, 0, 0), (0, 0, 1)),
        ("prismatic", (0, 0, LIFT), (0, 0, 1)),
        ("prismatic", (0, 0, LIFT), (1, 0, 0)),
    ],
    flange=pose(np.eye(3), (REACH, 0, LIFT)),
)

# In the base frame at q = 0.
LINKS = [
    Mass(60, (0, 0, 600), box=(260, 260, 1100)),
    Mass(30, (0, 0, LIFT), box=(320, 320, 240)),
    Mass(15, (100, 0, LIFT), box=(900, 90, 90)),
]

CYLINDRICAL = Design(
    name="cylindrical",
    title="Cylindrical robot",
    chain=KINEMATICS,
    limits=[
        Limits(-180, 180, 120, 2000),
        Limits(0, 500, 1000, 5000),
        Limits(0, 500, 1000, 3000),
    ],
    masses=Masses(LINKS),
    base_mass=Mass(80, (0, 0, -40), box=(500, 500, 80)),
    joint_data={"stiffness": (1.0e6, 2.0e6, 0.5e6)},
    source={
        "kinematics": "homework on calibration (2020); l1 = l2 = 0.5 m assumed (not given)",
        "limits": "range: homework on calibration (2020), Table 1; velocity and effort: assumed",
        "masses": "assumed",
        "stiffness": "homework on calibration (2020), Table 1 (its unit for joint_1 read as N·m/rad)",
        "visuals": "own shapes drawn from the kinematics",
    },
    look=cylindrical,
)
