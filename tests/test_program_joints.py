"""Poses whose joints stand in a robot program: RAPID's jointtargets, KRL's axes."""

from __future__ import annotations

import pytest
from campaign_example import faults, write_example

from workbench import InputError
from workbench.campaign import load_campaign
from workbench.campaign.exports import PROGRAM_EXPORTS
from workbench.campaign.guess import guess_poses
from workbench.campaign.program_joints import joint_table, program_of
from workbench.robot.chain import MovingJoint

TOML = """schema = 1
robot = "robot/tiny.toml"
[poses]
file = "poses.csv"
template = "{template}"
columns = {{ pose_id = 1, q1_deg = 2, q2_deg = 3, q3_mm = {third} }}
[points]
file = "points.csv"
"""
POINTS = "pose_id,x_mm,y_mm,z_mm\np1,1,2,3\np2,4,5,6\n"
NONE = ",".join(["9E9"] * 5)
RAPID = f"""MODULE Cal
  ! CONST jointtarget p0 := [[1,1,1,1,1,1],[{NONE},9E9]];
  CONST jointtarget p1 := [[10,20,0,0,0,0],[100,{NONE}]];
  PERS jointtarget p2:=[[-1.5E+01, 25, 0, 0, 0, 0],
      [200,{NONE}]];
  CONST robtarget far := [[1,2,3],[1,0,0,0],[0,0,0,0],[{NONE},9E9]];
ENDMODULE
"""
KRL = """DEFDAT CAL PUBLIC
;DECL E6AXIS P0={A1 1,A2 1,A3 1,A4 1,A5 1,A6 1,E1 1}
DECL E6AXIS P1={A1 10,A2 20,A3 0,A4 0,A5 0,A6 0,E1 100,E2 0}
DECL GLOBAL AXIS P2={A1 -15.0, A2 25, A3 0, A4 0, A5 0, A6 0, E1 200}
DECL E6POS FAR={X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 10}
ENDDAT
"""
SIX = [MovingJoint(f"joint_{j}", "revolute", "link", -3, 3, 1, 1) for j in range(1, 7)]


@pytest.mark.parametrize(
    ("template", "text", "names"),
    [("rapid", RAPID, ("p1", "p2")), ("krl", KRL, ("P1", "P2"))],
)
def test_joint_positions_of_a_program_are_poses(tmp_path, template, text, names):
    """With a rail, which is the example's third joint; what is commented out is no pose."""
    points = POINTS.replace("p1", names[0]).replace("p2", names[1])
    found = load_campaign(
        write_example(tmp_path, TOML.format(template=template, third=8), text, points)
    ).poses
    assert found.ids == names
    assert found.q[:, 0] == pytest.approx([0.17453, -0.2618], abs=1e-5)
    assert found.q[:, 2].tolist() == [0.1, 0.2]


def test_positions_without_names_are_numbered():
    text = "DEF CAL()\nPTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nWAIT SEC 2\nPTP {A1 7,A2 8,A3 9,A4 1,A5 2,A6 3}\n"
    lines = joint_table(text, "krl", "t.src").split("\n")
    assert lines[1] == "1,1,2,3,4,5,6"
    assert lines[3] == "2,7,8,9,1,2,3"
    moves = f"MoveAbsJ [[1,2,3,4,5,6],[{NONE},9E9]]\\NoEOffs, v100, fine, tool0;\n"
    assert joint_table(moves, "rapid", "t.mod") == "1,1,2,3,4,5,6\n"


def test_positions_of_fanuc_and_staubli():
    text = '/POS\nP[1:"a"]{\n GP1:\n UF : 0, UT : 1,\n J1= 10.000 deg, J2= 20.0 deg, J3= -3 deg,\n'
    text += " J4= 4 deg, J5= 5 deg, J6= 6 deg,\n E1= 100.0 mm\n};\nP[2]{\n GP1: X = 1 mm, Y = 2 mm\n};\n"
    assert program_of(text) == "ls"
    assert joint_table(text, "ls", "t.ls").split() == ["P1,10.000,20.0,-3,4,5,6,100.0"]
    text = '<Value key="0" j1="-84.1" j2="-55" j3="1" j4="2" j5="3" j6="4" />\n<Value key="1" x="1" y="2" />'
    assert program_of(text) == "val3"
    assert joint_table(text, "val3", "t.dtx").split() == ["1,-84.1,-55,1,2,3,4"]


def test_a_program_that_does_not_say_the_joints_is_told(tmp_path):
    with pytest.raises(InputError, match="has no joint positions as krl says them"):
        joint_table("PTP {X 1,Y 2,Z 3,A 0,B 0,C 0}\n", "krl", "t.src")
    with pytest.raises(InputError, match="line 1: has two joint positions"):
        joint_table("{A1 1,A2 2} {A1 1,A2 2}", "krl", "t.src")
    lacking = KRL.replace("A2 25, ", "")
    points = POINTS.replace("p", "P", 2).replace("Pose", "pose").replace("p2", "P2")
    told = faults(write_example(tmp_path, TOML.format(template="krl", third=8), lacking, points))
    assert len(told) == 1
    assert "line 4: q2_deg (column 3) is empty" in told[0]


def test_programs_are_known_by_their_text(tmp_path):
    assert (program_of(RAPID), program_of(KRL), program_of("pose_id,A1,A2\n1,2,3\n")) == (
        "rapid",
        "krl",
        None,
    )
    (tmp_path / "cal.mod").write_text(RAPID)
    assert guess_poses(tmp_path / "cal.mod", SIX).keys == {"template": "rapid"}
    rail = [*SIX, MovingJoint("rail", "prismatic", "link", 0, 1, 1, 1)]
    assert guess_poses(tmp_path / "cal.mod", rail).keys["columns"]["q7_mm"] == 8
    (tmp_path / "tool.mod").write_text("CONST robtarget p1 := [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9]];\n")
    tool = guess_poses(tmp_path / "tool.mod", SIX)
    assert tool.lacking == [f"joint {j}" for j in range(1, 7)]
    assert "its positions are the tool's" in tool.why


URSCRIPT = """def cal():
  # movej([9, 9, 9, 9, 9, 9])
  global P1_p = p[0.1, 0.2, 0.3, 0, 3.14, 0]
  global P1 = [0.5, -1.25, 1, 0, 1.5e-1, 0]
  movej([-0.1, -1.5, 1.5, 0, 1.57, 0], a=1.4, v=1.05)
  movel(p[0.1, 0.2, 0.3, 0, 3.14, 0], a=1.2)
end
"""


def test_positions_of_urscript_are_radians(tmp_path):
    assert program_of(URSCRIPT) == "urscript"
    assert joint_table(URSCRIPT, "urscript", "t.script").split() == [
        "1,0.5,-1.25,1,0,1.5e-1,0",
        "2,-0.1,-1.5,1.5,0,1.57,0",
    ]
    toml = TOML.format(template="urscript", third=4).replace("q1_deg", "q1_rad").replace("q3_mm", "q3_m")
    points = POINTS.replace("p1", "1").replace("p2", "2")
    found = load_campaign(write_example(tmp_path, toml, URSCRIPT, points)).poses
    assert found.q[:, 0].tolist() == [0.5, -0.1]
    assert PROGRAM_EXPORTS["urscript"]["columns"]["q6_rad"] == 7
    assert PROGRAM_EXPORTS["drl"]["columns"]["q6_deg"] == 7


def test_positions_of_drl():
    text = (
        "p1 = posj(0, 10, 20.5, 0, 30, 0)\nmovej(p1, vel=30)\np2=posj(1,2,3,4,5,6)\nx = posx(1,2,3,4,5,6)\n"
    )
    assert program_of(text) == "drl"
    assert joint_table(text, "drl", "t.drl").split() == ["p1,0,10,20.5,0,30,0", "p2,1,2,3,4,5,6"]


JBI = (
    "/JOB\n//NAME CAL\n//POS\n///TOOL 0\n///POSTYPE {}\n///{}\nC00000=1000,-2000,30,4,5,6\n//INST\nNOP\nEND\n"
)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (JBI.format("PULSE", "PULSE"), "pulses of the motors"),
        (JBI.format("BASE", "RECTAN"), "the tool's"),
        ("def cal():\n  movej(p[0.1, 0.2, 0.3, 0, 3.14, 0])\nend\n", "the tool's"),
        ("p1 = posx(100, 200, 300, 0, 180, 0)\n", "the tool's"),
    ],
)
def test_programs_without_joints_are_told_as_that(tmp_path, text, why):
    (tmp_path / "cal").write_text(text)
    assert why in guess_poses(tmp_path / "cal", SIX).why


@pytest.mark.parametrize(
    "text", ['<Rob Type="KUKA"><AIPos A1="1.0" A2="2"/></Rob>\n', '{"q": [1, 2]}\n', "[{}]"]
)
def test_what_is_no_table_is_told_as_that(tmp_path, text):
    """It was taken apart at its blanks, and its words offered as names of columns."""
    (tmp_path / "t").write_text(text)
    with pytest.raises(InputError, match="is XML or JSON, no table"):
        guess_poses(tmp_path / "t", SIX)
