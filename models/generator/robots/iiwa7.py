"""KUKA LBR iiwa 7 R800."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.iiwa import iiwa

KINEMATICS = Table(
    "standard",
    [
        (0, -90, 340, 0),
        (0, 90, 0, 0),
        (0, -90, 400, 180),
        (0, 90, 0, 0),
        (0, -90, 400, 180),
        (0, 90, 0, 0),
        (0, 0, 126, 0),
    ],
)

# In DH frames 1..7; the cuboids are the links' outlines in the same frames.
LINKS = [
    Mass(2.7, (0.160, -25.669, -80.369), box=(140, 240, 180)),
    Mass(2.7, (-0.034, 88.843, -27.726), box=(140, 240, 180)),
    Mass(2.7, (-0.054, 27.708, -80.387), box=(140, 240, 180)),
    Mass(2.7, (0.027, 88.916, 25.711), box=(140, 240, 180)),
    Mass(1.7, (0.034, -25.357, -95.635), box=(130, 230, 160)),
    Mass(1.6, (0.211, -5.791, -8.801), box=(110, 150, 140)),
    Mass(1.4, (-6.324, -0.545, 60.415), box=(100, 100, 60)),
]

IIWA7 = Design(
    name="iiwa7",
    title="KUKA LBR iiwa 7 R800",
    chain=chain_of(KINEMATICS),
    limits=[
        Limits(-170, 170, 98, 176),
        Limits(-120, 120, 98, 176),
        Limits(-170, 170, 100, 110),
        Limits(-120, 120, 130, 110),
        Limits(-170, 170, 140, 110),
        Limits(-120, 120, 180, 40),
        Limits(-175, 175, 180, 40),
    ],
    masses=Masses(LINKS, KINEMATICS),
    base_mass=Mass(4.0, (0, 0, 80), box=(180, 180, 160)),
    pose_repeatability=0.1,
    source={
        "kinematics": "nominal standard DH table of the public data set; flange = DH frame 7",
        "limits": "recalled from the data sheet, unverified",
        "masses": "mass and centre of mass of links 1..7: public MATLAB model beside the data set, DH "
        "frames; inertia: assumed (cuboids); base: assumed",
        "stiffness": "not known, taken as rigid",
        "gear_ratio": "harmonic drives, ratios not known",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=iiwa,
)
