"""KUKA KR 500 R2830."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.arms import Sizes
from ..looks.heavy import heavy
from ..looks.paints import ORANGE
from .kr210 import GAUGED, GAUGED_AREA, gas_spring

KINEMATICS = Table(
    "modified",
    [
        (0, 0, 1045, 0),
        (-90, 500, 0, 0),
        (0, 1300, 0, -90),
        (-90, -55, 1025, 0),
        (90, 0, 0, 0),
        (-90, 0, 290, 180),
    ],
)

# The masses are public in the frames of this standard table. It has its zero where the upper arm
# stands up and the forearm lies level, that is q = (0, -90, 90, 0, 0, 0) deg of the robot itself,
# and its axes 3 and 4 point back. A link's centre of mass goes from its table frame to the base
# frame in that pose, and from there into its URDF frame in the same pose. The source's last row ends
# 87 mm beyond the flange (a spindle plate); here it ends at the flange, which is what the 7 kg disc
# is stated about.
MASS_FRAMES = Table(
    "standard",
    [
        (500, -90, 1045, 0),
        (1300, 0, 0, -90),
        (55, -90, 0, 180),
        (0, 90, -1025, 0),
        (0, -90, 0, 0),
        (0, 180, -290, 180),
    ],
)

LINKS = [
    Mass(558, (-409, 205, 35), [[31.479, -11.062, 9.269], [-11.062, 59.845, 1.849], [9.269, 1.849, 65.161]]),
    Mass(
        485, (-847, 0, -310), [[13.322, 11.567, -0.293], [11.567, 113.722, -0.251], [-0.293, -0.251, 112.739]]
    ),
    Mass(311, (-33, -10, 43), [[27.449, -0.109, -0.301], [-0.109, 25.058, 0.98], [-0.301, 0.98, 10.561]]),
    Mass(86, (0, 266, -11), [[2.783, 0, 0.172], [0, 3.471, 0], [0.172, 0, 1.423]]),
    Mass(48, (0, -38, -52), [[0.7, 0, 0], [0, 0.684, 0.112], [0, 0.112, 0.438]]),
    Mass(7, (0, 0, -27), [[0.018, 0, 0], [0, 0.018, 0], [0, 0, 0.034]]),
]

LOOK = Sizes(
    paint=ORANGE,
    foot=540,
    waist=420,
    turntable=400,
    block=400,
    hub=300,
    elbow=240,
    near=-215,
    far=-430,
    cheek=360,
    forearm=235,
    tube=165,
    tube_start=560,
    wrist=125,
    flange=115,
    motor=110,
    cylinder=72,
)

KR500 = Design(
    name="kr500",
    title="KUKA KR 500 R2830",
    chain=chain_of(KINEMATICS),
    limits=[
        Limits(-185, 185, 84, 28000),
        Limits(-130, 20, 79, 28000),
        Limits(-100, 144, 73, 16000),
        Limits(-350, 350, 76, 4000),
        Limits(-120, 120, 76, 4000),
        Limits(-350, 350, 120, 2000),
    ],
    masses=Masses(LINKS, MASS_FRAMES, at=(0, -90, 90, 0, 0, 0)),
    base_mass=Mass(1000, (0, 0, 250), box=(1000, 1000, 500)),
    joint_data={
        "stiffness": (15.6e6, 6.12e6, 5.83e6, 0.459e6, 0.219e6, 0.479e6),
        "gear_ratio": (230.0, 247.0, 218.0, 100.0, 137.0, 113.0),
        "rotor_inertia": (2.0e-3, 2.0e-3, 2.0e-3, 6.0e-4, 6.0e-4, 4.0e-4),
        "damping": (1.9e3, 1.4e3, 0.6e3, 1.9e3, 1.4e3, 1.4e3),
        "repeatability": (4e-6, 4e-6, 4e-6, 12e-6, 12e-6, 12e-6),
    },
    compensator=gas_spring(joint_2_ahead=0.5, **GAUGED, piston_area=GAUGED_AREA),
    controller={
        "make": "KUKA",
        "names": ("A1", "A2", "A3", "A4", "A5", "A6"),
        "signs": (-1, 1, 1, -1, 1, -1),
    },
    pose_repeatability=0.08,
    source={
        "kinematics": "public modified DH table of the KR 500 R2830 (robot kinematics catalogue), its "
        "signs and zeros; a KUKA controller counts A1, A4 and A6 the other way",
        "limits": "range: public MATLAB model of the KR 500; velocity: recalled from the data sheet, "
        "unverified; effort: assumed",
        "masses": "links 1..6: public MATLAB model of the KR 500, from its standard DH frames; base: assumed",
        "stiffness": "“Variable Parameters Stiffness Identification and Modeling” (KR 500), equation (19)",
        "damping": "public MATLAB model of the KR 500, modal test",
        "gear_ratio": "assumed (KUKA publishes none; range of robots of this size)",
        "rotor_inertia": "assumed",
        "repeatability": "assumed per joint so that the pose scatters within the data sheet's 0.08 mm",
        "compensator": "pivots: geometry of the KR 210 R2700, put at this robot's joint 2 (assumed); "
        "charge, gas length and area: as gauged on a KR 300, a robot of this class (assumed to hold)",
        "controller": "A1, A4 and A6 count the other way than about z up and x forward: public URDFs of "
        "KUKA (ROS-Industrial)",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=lambda design: heavy(design, LOOK),
)
