"""Yaskawa Motoman MA1400, the two arms of a robot on a turntable. They lean 15 degrees outwards."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.ma1400 import ma1400_look

ROWS = [
    (150, -90, 1415.9, 0),
    (614, 180, 0, -90),
    (200, -90, 0, 0),
    (0, 90, -640, 0),
    (30, 90, 0, -90),
    (0, 0, 200, 0),
]
LEAN = {"right": 15.0, "left": -15.0}
KINEMATICS = {side: Table("standard", ROWS, mount=(0, lean, -263, -90)) for side, lean in LEAN.items()}

# At q = 0 in the arm's own frame: x forward, z along S, from where S meets the turntable's axis.
LINKS = [
    Mass(38, (60, 0, 1330), box=(380, 300, 350)),
    Mass(21, (150, 0, 1720), box=(180, 200, 800)),
    Mass(22, (170, 0, 2190), box=(360, 260, 260)),
    Mass(9, (520, 0, 2229.9), box=(560, 140, 140)),
    Mass(3, (790, 0, 2215), box=(130, 110, 150)),
    Mass(1, (820, 0, 2060), box=(90, 90, 60)),
]
LIMITS = [
    Limits(-170, 170, 220, 800),
    Limits(-155, 155, 200, 800),
    Limits(-190, 190, 220, 500),
    Limits(-150, 150, 410, 60),
    Limits(-180, 180, 410, 60),
    Limits(-200, 200, 610, 30),
]


def ma1400(side: str) -> Design:
    """The right or the left arm; `side` is "right" or "left"."""
    lean = LEAN[side]
    return Design(
        name=f"ma1400-{side}",
        title=f"Yaskawa Motoman MA1400, {side} arm on a turntable",
        chain=chain_of(KINEMATICS[side]),
        joints=("S", "L", "U", "R", "B", "T"),
        mount=(lean, 0.0, -90.0),
        limits=LIMITS,
        masses=Masses(LINKS, start=-263.0),
        base_mass=Mass(250, (0, 0, 300), box=(800, 800, 600)),
        pose_repeatability=0.08,
        source={
            "kinematics": "nominal standard DH table of the public data set, with the turntable row at E "
            "= 0; base = turntable, z up; flange = DH frame of T",
            "limits": "assumed: range as in the data sheet but the same to both sides, as the signs are "
            "not documented; velocity recalled from the data sheet, unverified; effort assumed",
            "masses": "assumed: masses, centres of mass and inertias (cuboids) of an arm of 130 kg in all",
            "stiffness": "not known, taken as rigid",
            "gear_ratio": "not known",
            "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
            "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
        },
        look=ma1400_look,
    )


MA1400_RIGHT, MA1400_LEFT = ma1400("right"), ma1400("left")
