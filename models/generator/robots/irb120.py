"""ABB IRB 120-3/0.6."""

from ..design import Design, Limits, Mass, Masses
from ..kinematics import Table, chain_of
from ..looks.arms import Sizes
from ..looks.heavy import heavy
from ..looks.paints import GREY, WHITE

KINEMATICS = Table(
    "standard",
    [
        (0, -90, 290, 0),
        (270, 0, 0, -90),
        (70, -90, 0, 0),
        (0, 90, 302, 0),
        (0, -90, 0, 0),
        (0, 0, 72, 180),
    ],
)

# In the base frame at q = 0 (arm up, forearm level).
LINKS = [
    Mass(3.067, (0, 0, 228), box=(170, 190, 190)),
    Mass(3.909, (0, 0, 391), box=(130, 150, 380)),
    Mass(2.944, (23, 0, 618), box=(210, 150, 180)),
    Mass(1.328, (225, 0, 630), box=(240, 110, 110)),
    Mass(0.547, (302, 0, 630), box=(110, 70, 70)),
    Mass(0.0137, (367, 0, 630), box=(12, 40, 40)),
]

LOOK = Sizes(
    paint=WHITE,
    cover=GREY,
    foot=104,
    waist=78,
    turntable=125,
    block=84,
    hub=76,
    elbow=58,
    near=-42,
    far=-92,
    cheek=80,
    forearm=54,
    tube=40,
    tube_start=125,
    wrist=31,
    flange=24,
)

IRB120 = Design(
    name="irb120",
    title="ABB IRB 120-3/0.6",
    chain=chain_of(KINEMATICS),
    limits=[
        Limits(-165, 165, 250, 90),
        Limits(-110, 110, 250, 90),
        Limits(-110, 70, 250, 60),
        Limits(-160, 160, 320, 20),
        Limits(-120, 120, 320, 20),
        Limits(-400, 400, 420, 10),
    ],
    masses=Masses(LINKS),
    base_mass=Mass(6.215, (-40, 0, 80), box=(280, 180, 160)),
    controller={"make": "ABB", "names": ("J1", "J2", "J3", "J4", "J5", "J6")},
    pose_repeatability=0.01,
    source={
        "kinematics": "nominal standard DH table, signs and zeros of the ABB controller; flange = tool0",
        "limits": "range and velocity: recalled from the data sheet, unverified; effort: assumed",
        "masses": "mass of links: public URDF (base 6.215 kg); centre of mass: rough places in the base "
        "frame at q = 0; inertia: assumed (cuboids)",
        "stiffness": "not known, taken as rigid",
        "gear_ratio": "not known",
        "controller": "the URDF's own signs and zeros; no parallelogram, so joint 3 is counted alone",
        "pose_repeatability": "manufacturer's data sheet, recalled, unverified",
        "visuals": "own shapes drawn from the kinematics, not the manufacturer's",
    },
    look=lambda design: heavy(design, LOOK),
)
