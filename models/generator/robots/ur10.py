"""Universal Robots UR10."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.ur import ur
from .ur5 import CONTROLLER, JOINTS

KINEMATICS = Table(
    "standard",
    [
        (0, 90, 127.3, 0),
        (-612, 0, 0, 0),
        (-572.3, 0, 0, 0),
        (0, 90, 163.941, 0),
        (0, -90, 115.7, 0),
        (0, 0, 92.2, 0),
    ],
)

# In DH frames 1..6; the cuboids are the links' outlines in the same frames.
LINKS = [
    Mass(7.778, (21, 0, 27), box=(150, 190, 170)),
    Mass(12.93, (380, 0, 158), box=(760, 145, 145)),
    Mass(3.87, (240, 0, 68), box=(680, 105, 105)),
    Mass(1.96, (0, 7, 18), box=(95, 95, 130)),
    Mass(1.96, (0, 7, 18), box=(95, 95, 130)),
    Mass(0.202, (0, 0, -26), box=(95, 95, 50)),
]

UR10 = Design(
    name="ur10",
    title="Universal Robots UR10",
    chain=chain_of(KINEMATICS),
    joints=JOINTS,
    limits=[
        *[Limits(-360, 360, 120, 330)] * 2,
        Limits(-360, 360, 180, 150),
        *[Limits(-360, 360, 180, 56)] * 3,
    ],
    masses=Masses(LINKS, KINEMATICS),
    base_mass=Mass(4.0, (0, 0, 50), box=(190, 190, 110)),
    joint_data={"gear_ratio": (101.0,) * 6},
    controller=CONTROLLER,
    pose_repeatability=0.1,
    source={
        "kinematics": "nominal standard DH table of the manufacturer, controller signs and zeros",
        "limits": "range: manufacturer's data sheet; velocity and torque: recalled from it, unverified",
        "masses": "mass of links 1..6: public URDF; centre of mass: manufacturer, who states 7.1, 12.7, "
        "4.27, 2, 2 and 0.365 kg beside it; inertia (cuboids) and base: assumed",
        "gear_ratio": "harmonic drives, 101 on all joints: literature, unverified",
        "stiffness": "not known, taken as rigid",
        "controller": "the manufacturer's table, which is the controller's: base and flange are its too",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=ur(beside=114.9, apart=171.9, size=1.25),
)
