"""KUKA KR 120 R2500 pro with a gas gravity compensator."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_along, pose, rotation_y
from ..looks.arms import Sizes
from ..looks.heavy import heavy
from ..looks.paints import ORANGE
from .kr210 import GAUGED, gas_spring

# Arm level and forwards at q = 0, as in the controller, which turns A1, A4 and A6 the other way round.
KINEMATICS = chain_along(
    [
        ("revolute", (0, 0, 675), (0, 0, -1)),
        ("revolute", (350, 0, 675), (0, 1, 0)),
        ("revolute", (1500, 0, 675), (0, 1, 0)),
        ("revolute", (2500, 0, 634), (-1, 0, 0)),
        ("revolute", (2500, 0, 634), (0, 1, 0)),
        ("revolute", (2500, 0, 634), (-1, 0, 0)),
    ],
    flange=pose(rotation_y(90), (2715, 0, 634)),
)

# Masses of the KR 210 R2700, which has the same column and upper arm, in its standard DH frames with the
# arm up and the forearm level, q = (0, -90, 90, 0, 0, 0) deg, as for the KR 500. Its forearm is 200 mm
# longer; its link 6 carries a spindle and is not used.
MASS_FRAMES = Table(
    "standard",
    [
        (350, -90, 675, 0),
        (1150, 0, 0, -90),
        (41, -90, 0, 180),
        (0, 90, -1000, 0),
        (0, -90, 0, 0),
        (0, 180, -215, 180),
    ],
)
LINKS = [
    Mass(
        259.85,
        (-364.93, 220.28, 4.34),
        [[8.8821, -0.4015, 1.0397], [-0.4015, 13.7205, -0.3202], [1.0397, -0.3202, 16.266]],
    ),
    Mass(
        334.71,
        (-717.93, 27.87, -235.73),
        [[6.1923, -1.6859, -6.1251], [-1.6859, 55.8635, 0.2354], [-6.1251, 0.2354, 55.1699]],
    ),
    Mass(
        217.46,
        (-25.58, 21.89, -311.08),
        [[25.4402, -0.0781, 0.0171], [-0.0781, 25.9246, 1.1022], [0.0171, 1.1022, 2.3116]],
    ),
    Mass(12.17, (0, 123.43, 1.35), [[0.1285, 0, 0], [0, 0.0298, -0.0028], [0, -0.0028, 0.1302]]),
    Mass(
        29.53,
        (0.05, -24.0, -46.7),
        [[0.4021, -0.0001, -0.0001], [-0.0001, 0.2383, -0.0463], [-0.0001, -0.0463, 0.2879]],
    ),
    Mass(4.0, (0, 0, -20), box=(160, 160, 40)),
]

LOOK = Sizes(
    paint=ORANGE,
    foot=390,
    waist=300,
    turntable=260,
    block=285,
    hub=235,
    elbow=180,
    near=-165,
    far=-320,
    cheek=265,
    forearm=175,
    tube=112,
    tube_start=480,
    wrist=88,
    flange=80,
    motor=82,
    cylinder=58,
)

KR120 = Design(
    name="kr120",
    title="KUKA KR 120 R2500 pro",
    chain=KINEMATICS,
    limits=[
        Limits(-185, 185, 156, 12000),
        Limits(-155, 35, 156, 12000),
        Limits(-130, 154, 156, 8000),
        Limits(-350, 350, 330, 1500),
        Limits(-130, 130, 330, 1500),
        Limits(-350, 350, 615, 800),
    ],
    masses=Masses(LINKS, MASS_FRAMES, at=(0, -90, 90, 0, 0, 0)),
    base_mass=Mass(240, (0, 0, 180), box=(750, 750, 400)),
    joint_data={
        "stiffness": (8.85e5, 3.14e6, 2.33e6, 1.05e6, 2.62e5, 2.49e5),
        "gear_ratio": (230.0, 251.0, 239.0, 189.0, 143.0, 119.0),
        "rotor_inertia": (1.2e-3, 1.2e-3, 1.0e-3, 3.0e-4, 3.0e-4, 2.0e-4),
        "damping": (1.0e3, 1.0e3, 6.0e2, 3.0e2, 1.0e2, 1.0e2),
        "repeatability": (3e-6, 3e-6, 3e-6, 9e-6, 9e-6, 9e-6),
    },
    compensator=gas_spring(joint_2_ahead=0.35, piston_area=1.0e-3, **GAUGED),
    controller={"make": "KUKA", "names": ("A1", "A2", "A3", "A4", "A5", "A6")},
    pose_repeatability=0.06,
    source={
        "kinematics": "public URDF of the KR 120 R2500 pro (ROS-Industrial), controller signs and zeros; "
        "flange x down, z out as the controller has it",
        "limits": "range and velocity: the same public URDF; effort: assumed",
        "masses": "links 1..5: public MATLAB model of the KR 210 R2700, which shares column and upper "
        "arm; link 6 and base: assumed",
        "stiffness": "Klimchik et al. (2017), Table I, one over the compliance; joint_2: mean of its six "
        "values (0.318e-6)",
        "gear_ratio": "assumed; joint_4: near the published 188.85 of the KR 120 R3900",
        "rotor_inertia": "assumed",
        "damping": "assumed",
        "repeatability": "assumed per joint so that the pose scatters within the data sheet's 0.06 mm",
        "compensator": "pivots: public URDF of the KR 210 R2700, same column and upper arm (assumed to "
        "hold); charge and gas length: as gauged on a KR 300, a robot of this class (assumed to hold); area: "
        "assumed, so that the stretched, unloaded arm is nearly balanced",
        "controller": "the URDF's own signs and zeros",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=lambda design: heavy(design, LOOK),
)
