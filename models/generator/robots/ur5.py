"""Universal Robots UR5."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.ur import ur

KINEMATICS = Table(
    "standard",
    [
        (0, 90, 89.159, 0),
        (-425, 0, 0, 0),
        (-392.25, 0, 0, 0),
        (0, 90, 109.15, 0),
        (0, -90, 94.65, 0),
        (0, 0, 82.3, 0),
    ],
)

# In DH frames 1..6; the cuboids are the links' outlines in the same frames.
LINKS = [
    Mass(3.7, (0, -25.61, 1.93), box=(120, 150, 130)),
    Mass(8.393, (212.5, 0, 113.36), box=(540, 115, 115)),
    Mass(2.33, (150, 0, 26.5), box=(470, 85, 85)),
    Mass(1.219, (0, -1.8, 16.34), box=(75, 75, 105)),
    Mass(1.219, (0, 1.8, 16.34), box=(75, 75, 105)),
    Mass(0.1879, (0, 0, -1.159), box=(75, 75, 40)),
]

# Of all robots of this make with six joints.
JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
CONTROLLER = {
    "make": "Universal Robots",
    "names": ("Base", "Shoulder", "Elbow", "Wrist 1", "Wrist 2", "Wrist 3"),
    "units": ("rad",) * 6,
}

UR5 = Design(
    name="ur5",
    title="Universal Robots UR5",
    chain=chain_of(KINEMATICS),
    joints=JOINTS,
    limits=[Limits(-360, 360, 180, 150)] * 3 + [Limits(-360, 360, 180, 28)] * 3,
    masses=Masses(LINKS, KINEMATICS),
    base_mass=Mass(4.0, (0, 0, 40), box=(150, 150, 90)),
    joint_data={"gear_ratio": (101.0,) * 6},
    controller=CONTROLLER,
    pose_repeatability=0.1,
    source={
        "kinematics": "nominal standard DH table of the manufacturer, controller signs and zeros",
        "limits": "manufacturer's data sheet: range, velocity, torque",
        "masses": "mass and centre of mass of links 1..6: manufacturer; inertia (cuboids) and base: assumed",
        "gear_ratio": "harmonic drives, 101 on all joints: literature, unverified",
        "stiffness": "not known, taken as rigid",
        "controller": "the manufacturer's table, which is the controller's: base and flange are its too",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=ur(beside=93.0, apart=119.7),
)
