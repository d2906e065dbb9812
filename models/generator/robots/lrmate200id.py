"""FANUC LR Mate 200iD."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import chain_along, pose, rotation_x, rotation_y
from ..looks.arms import Sizes
from ..looks.heavy import heavy
from ..looks.paints import YELLOW

# Arm up and forearm level at q = 0. The URDF's joint 3 turns the forearm against the upper arm; the
# controller shows it against the horizontal.
KINEMATICS = chain_along(
    [
        ("revolute", (0, 0, 330), (0, 0, 1)),
        ("revolute", (50, 0, 330), (0, 1, 0)),
        ("revolute", (50, 0, 660), (0, -1, 0)),
        ("revolute", (50, 0, 695), (-1, 0, 0)),
        ("revolute", (385, 0, 695), (0, -1, 0)),
        ("revolute", (465, 0, 695), (-1, 0, 0)),
    ],
    flange=pose(rotation_y(-90) @ rotation_x(180), (465, 0, 695)),
)

# In the base frame at q = 0; 25 kg in all.
LINKS = [
    Mass(4.0, (15, 0, 290), box=(180, 190, 200)),
    Mass(4.5, (50, 10, 495), box=(130, 130, 420)),
    Mass(4.0, (75, 0, 690), box=(190, 150, 150)),
    Mass(2.0, (240, 0, 695), box=(260, 100, 100)),
    Mass(1.0, (385, 0, 695), box=(90, 70, 70)),
    Mass(0.1, (457, 0, 695), box=(16, 45, 45)),
]

LOOK = Sizes(
    paint=YELLOW,
    foot=120,
    waist=88,
    turntable=130,
    block=92,
    hub=82,
    elbow=62,
    near=-44,
    far=-98,
    cheek=84,
    forearm=58,
    tube=42,
    tube_start=140,
    wrist=33,
    flange=25,
)

LRMATE200ID = Design(
    name="lrmate200id",
    title="FANUC LR Mate 200iD",
    chain=KINEMATICS,
    limits=[
        Limits(-170, 170, 450, 100),
        Limits(-100, 145, 380, 100),
        Limits(-140, 213, 520, 60),
        Limits(-190, 190, 550, 20),
        Limits(-125, 125, 545, 20),
        Limits(-360, 360, 1000, 10),
    ],
    masses=Masses(LINKS),
    base_mass=Mass(9.4, (-20, 0, 90), box=(260, 200, 180)),
    controller={
        "make": "FANUC",
        "names": ("J1", "J2", "J3", "J4", "J5", "J6"),
        "couplings": [{"joint": "J3", "on": "J2", "factor": -1.0}],
        "world": {"xyz_mm": (0.0, 0.0, 330.0)},
    },
    pose_repeatability=0.02,
    source={
        "kinematics": "public URDF of the LR Mate 200iD (ROS-Industrial), its signs and zeros; flange = "
        "tool0",
        "limits": "range and velocity: the same public URDF (joint 3 against the upper arm: 140 degrees "
        "down, 213 up); effort: assumed",
        "masses": "25 kg in all: recalled from the data sheet, unverified; shares, centres of mass and "
        "inertias (cuboids): assumed",
        "stiffness": "not known, taken as rigid",
        "gear_ratio": "not known",
        "controller": "joint 3 against the horizontal, world at the height of joint 2: the same public URDF",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=lambda design: heavy(design, LOOK),
)
