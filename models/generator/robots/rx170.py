"""Stäubli RX170, with the spring that balances joint 2."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.arms import Sizes
from ..looks.heavy import heavy
from ..looks.paints import YELLOW

# All joints at 0: arm and forearm stand up. Arm and forearm are 70 mm beside axis 1.
KINEMATICS = Table(
    "modified",
    [
        (0, 0, 750, 0),
        (-90, 100, 70, -90),
        (0, 850, 0, -90),
        (-90, 0, 770, 0),
        (90, 0, 0, 0),
        (-90, 0, 115, 0),
    ],
)

# In the base frame at q = 0; 400 kg in all.
LINKS = [
    Mass(120, (30, -20, 690), box=(420, 420, 560)),
    Mass(120, (100, 20, 1130), box=(260, 240, 1100)),
    Mass(110, (95, 60, 1690), box=(300, 300, 420)),
    Mass(30, (100, 70, 2090), box=(180, 180, 560)),
    Mass(15, (100, 70, 2385), box=(140, 130, 190)),
    Mass(5, (100, 70, 2470), box=(110, 110, 40)),
]

LOOK = Sizes(
    paint=YELLOW,
    foot=300,
    waist=235,
    turntable=250,
    block=225,
    hub=205,
    elbow=150,
    near=-110,
    far=-250,
    cheek=180,
    forearm=140,
    tube=88,
    tube_start=330,
    wrist=66,
    flange=52,
)

RX170 = Design(
    name="rx170",
    title="Stäubli RX170",
    chain=chain_of(KINEMATICS),
    limits=[
        Limits(-180, 180, 180, 4000),
        Limits(-120, 120, 180, 4000),
        Limits(-145, 145, 180, 2500),
        Limits(-270, 270, 310, 400),
        Limits(-110, 130, 280, 400),
        Limits(-270, 270, 450, 150),
    ],
    masses=Masses(LINKS),
    base_mass=Mass(250, (0, 0, 220), box=(600, 600, 440)),
    joint_data={
        "stiffness": (0.204e6, 0.85e6, 0.57e6, 0.49e6, 0.12e6, 0.005e6),
        "gear_ratio": (134.0, 140.0, 127.0, 96.0, 88.0, 72.0),
        "rotor_inertia": (1.5e-3, 1.5e-3, 1.0e-3, 2.0e-4, 2.0e-4, 1.0e-4),
        "damping": (4.0e2, 6.0e2, 3.0e2, 8.0e1, 3.0e1, 2.0e0),
        "repeatability": (4e-6, 4e-6, 4e-6, 1.2e-5, 1.2e-5, 1.2e-5),
    },
    # The spring hangs in the column under joint 2 and pulls at the arm's tail: least stretched when the
    # arm stands, so it pulls the leaning arm back up.
    compensator={
        "kind": "spring",
        "joint": "joint_2",
        "body": "link_1",
        "arm": "link_2",
        "body_pivot": (0.1, 0.07, -0.30),
        "arm_pivot": (0.0, 0.0, -0.15),
        "rate": 5.0e4,
        "free_length": 0.03,
    },
    # The world stands at the height of joint 2; at zero the flange is turned as the world is.
    controller={
        "make": "Stäubli",
        "names": ("J1", "J2", "J3", "J4", "J5", "J6"),
        "world": {"xyz_mm": (0.0, 0.0, 750.0)},
        "flange": {"abc_deg": (180.0, 0.0, 0.0)},
    },
    source={
        "kinematics": "public modified DH table of the RX170HSM (robot kinematics catalogue); standard "
        "wrist (115 mm, recalled) instead of the spindle's 200 mm; base frame on the floor, 750 mm under "
        "joint 2",
        "limits": "range of joints 1..5: public table; joint 6, velocity and effort: assumed",
        "masses": "assumed: 400 kg moving, centres of mass and inertias (cuboids) from the shape",
        "stiffness": "Olabi et al. (2012), Table I",
        "gear_ratio": "assumed: helical stage (1.4 at joint_2) and harmonic-type stage (100 at joint_2)",
        "rotor_inertia": "assumed",
        "damping": "assumed",
        "repeatability": "assumed",
        "compensator": "assumed: sized so that joint 2 keeps 150 to 300 N·m of the gravity torque at the "
        "ends of the sweep of Olabi et al. (2012) (50 degrees either way, forearm in line with the upper "
        "arm)",
        "controller": "world and flange at zero as public URDFs of the family state them (RX160, "
        "ROS-Industrial)",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=lambda design: heavy(design, LOOK),
)
