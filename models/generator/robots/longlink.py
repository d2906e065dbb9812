"""The seven-joint arm with long links of Liu, Song, Li, Pan, Yu (long-link flexible manipulators)."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.longlink import longlink

KINEMATICS = Table(
    "standard",
    [
        (340, -90, 0, 0),
        (1200, 0, 0, 0),
        (192.5, 90, 0, 0),
        (1020, -90, 0, 0),
        (138, 90, 0, 0),
        (0, 90, 0, 90),
        (0, 0, 965, -90),
    ],
)

# In the base frame at q = 0: the arm lies along x.
LINKS = [
    Mass(35, (170, 0, 0), box=(440, 220, 260)),
    Mass(30, (940, 0, 0), box=(1300, 160, 180)),
    Mass(20, (1640, 0, 0), box=(280, 150, 160)),
    Mass(15, (2240, 0, 0), box=(1100, 120, 130)),
    Mass(10, (2820, 0, 0), box=(220, 110, 120)),
    Mass(6, (2890, 0, 0), box=(130, 110, 110)),
    Mass(5, (3400, 0, 0), box=(960, 70, 70)),
]

TORSION = (2.0e5, 2.0e5, 1.5e5, 1.0e5, 8.0e4, 6.0e4, 5.0e4)

LONGLINK = Design(
    name="longlink",
    title="Seven-joint long-link arm",
    chain=chain_of(KINEMATICS),
    limits=[
        Limits(-170, 170, 60, 4000),
        Limits(-120, 120, 60, 4000),
        Limits(-120, 120, 60, 2500),
        Limits(-120, 120, 90, 1500),
        Limits(-120, 120, 90, 800),
        Limits(-120, 120, 120, 400),
        Limits(-170, 170, 120, 200),
    ],
    masses=Masses(LINKS),
    base_mass=Mass(150, (0, 0, -450), box=(500, 500, 800)),
    joint_data={
        "stiffness": TORSION,
        "tilt_stiffness": tuple(5 * value for value in TORSION),
        "repeatability": (2e-6, 2e-6, 2e-6, 2e-6, 4e-6, 4e-6, 4e-6),
    },
    # Table I calls them N·m/rad; equation (20) makes them EI in N·m². Link 6 (0.09e6) has no length.
    bending_stiffness={
        "link_1": 148.2e6,
        "link_2": 621.2e6,
        "link_3": 132.7e6,
        "link_4": 211.3e6,
        "link_5": 466.1e6,
        "link_7": 0.71e6,
    },
    source={
        "kinematics": "Liu et al., Table II (standard DH); base frame at the height of joint 2",
        "limits": "assumed",
        "masses": "assumed: 35 kg at the base to 5 kg at the hand, centres of mass and inertias (cuboids) "
        "too",
        "stiffness": "assumed: 2e5 to 5e4 N·m/rad",
        "tilt_stiffness": "assumed: five times the axial stiffness",
        "repeatability": "assumed",
        "bending_stiffness": "Liu et al., Table I, read as EI; implausibly stiff, the links bend by "
        "micrometres",
        "visuals": "own shapes drawn from the kinematics",
    },
    look=longlink,
)
