"""Small programs in the style of the real controllers, written by hand, are read as they are meant."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.correction.programs import find_format
from workbench.files.faults import InputError

KRL_SRC = """&ACCESS RVP
&REL 3
DEF weld_7( )
;FOLD INI;%{PE}
  ;FOLD BASISTECH INI
    GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )
    INTERRUPT ON 3
    BAS (#INITMOV,0 )
  ;ENDFOLD (BASISTECH INI)
;ENDFOLD (INI)
$BASE=$NULLFRAME
$TOOL={X 120.5,Y 0,Z 310.25,A 0,B 90,C 0}
PTP $AXIS_ACT ; skip the start run
PTP {A1 5, A2 -90, A3 100, A4 5, A5 10, A6 -5, E1 0, E2 0}
$VEL.CP = 0.2
$APO.CDIS=0.5
LIN {X 1000.000,Y 0.000,Z 1000.000,A 90.0000,B 0.0000,C 90.0000} C_DIS
LIN {E6POS: X 1100, Y 0, Z 1000, A 90, B 0, C 90, S 22, T 35} C_DIS
;FOLD LIN P3 Vel=0.05 m/s CPDAT1 Tool[1] Base[0];%{PE}
BAS(#CP_PARAMS,0.05)
LIN XP3
;ENDFOLD
WAIT SEC 0.5
PTP XHOME
END
"""
KRL_DAT = """DEFDAT WELD_7
DECL E6POS XP3={X 1100.0,Y 50.0,Z 1000.0,A 90.0,B 0.0,C 90.0,S 22,T 35}
DECL FDAT FP3={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}
ENDDAT
"""
RAPID = """%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE MainModule
  PERS tooldata tGripper:=[TRUE,[[31.8,0,229.6],[0.945518576,0,0.325568154,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  CONST robtarget p10:=[[600.5,500,225.3],[1,0,0,0],[1,1,0,0],[11,12.3,9E9,9E9,9E9,9E9]]; ! start
  CONST robtarget p20:=[[700.5,500,225.3],[0.707107,0,0.707107,0],[1,1,0,0],
                        [11,12.3,9E+09,9E+09,9E+09,9E+09]];
  VAR speeddata vSlow:=[20,500,5000,1000];
  PROC main()
    ! MoveL p99,v10,fine,tGripper;
    MoveAbsJ [[0,10,0,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v1000,z50,tGripper;
    MoveJ p10, v1000, fine, tGripper \\WObj:=wobj0;
    MoveL p20, v100, z5, tGripper\\WObj:=wobj0;
    WaitTime 0.25;
    MoveL [[700.5,600,225.3],[0,0,0,1],[0,0,0,0],[11,12.3,9E9,9E9,9E9,9E9]], vSlow, fine, tGripper;
  ENDPROC
ENDMODULE
"""
LS = """/PROG  CUT_12
/ATTR
OWNER\t\t= MNEDITOR;
COMMENT\t\t= "cutting";
LINE_COUNT\t= 7;
PROTECT\t\t= READ_WRITE;
DEFAULT_GROUP\t= 1,*,*,*,*;
CONTROL_CODE\t= 00000000 00000000;
/APPL
/MN
   1:  UFRAME_NUM=0 ;
   2:  UTOOL_NUM=2 ;
   3:  !approach ;
   4:J P[1:HOME] 20% FINE    ;
   5:L P[2] 250mm/sec CNT50 ACC80    ;
   6:L P[3] 2.0sec FINE    ;
   7:  WAIT    .50(sec) ;
   8:L P[4] 600cm/min CNT100    ;
/POS
P[1:"HOME"]{
   GP1:
\tUF : 0, UT : 2,\t
\tJ1=     0.000 deg,\tJ2=   -30.000 deg,\tJ3=    30.000 deg,
\tJ4=      .000 deg,\tJ5=   -90.000 deg,\tJ6=     0.000 deg
};
P[2]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'F U T, 0, 0, 0',
\tX =  1680.082  mm,\tY =  -315.778  mm,\tZ =   423.048  mm,
\tW =   180.000 deg,\tP =     -.063 deg,\tR =    30.000 deg
};
P[3]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'F U T, 0, 0, 0',
\tX =  1780.082  mm,\tY =  -315.778  mm,\tZ =   423.048  mm,
\tW =   180.000 deg,\tP =     -.063 deg,\tR =    30.000 deg
   GP2:
\tUF : 0, UT : 1,\t
\tJ1=    45.000 deg
};
P[4]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'F U T, 0, 0, 0',
\tX =  1780.082  mm,\tY =  -215.778  mm,\tZ =   423.048  mm,
\tW =   180.000 deg,\tP =     -.063 deg,\tR =    30.000 deg
};
/END
"""
SPACE = "http://www.staubli.com/robotics/VAL3"
VAL3 = {
    "deburr.pjx": f"""<?xml version="1.0" encoding="utf-8"?>
<Project xmlns="{SPACE}/Project/3">
  <Parameters version="s7.3.1" stackSize="5000" millimeterUnit="true" />
  <Programs><Program file="start.pgx" /></Programs>
  <Database><Data file="deburr.dtx" /></Database>
</Project>""",
    "deburr.dtx": f"""<?xml version="1.0" encoding="utf-8"?>
<Database xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns="{SPACE}/Data/2">
  <Datas>
    <Data name="jPark" access="public" xsi:type="array" type="jointRx" size="1">
      <Value key="0" j3="90" j5="90" />
    </Data>
    <Data name="mSlow" access="private" xsi:type="array" type="mdesc" size="1">
      <Value key="0" accel="100" vel="100" decel="100" tmax="50" rmax="99999" blend="off" />
    </Data>
    <Data name="pEdge" access="private" xsi:type="array" type="pointRx" size="3">
      <Value key="0" x="800" z="500" rx="20" ry="30" rz="40" fatherId="world[0]" />
      <Value key="1" x="900" z="500" rx="20" ry="30" rz="40" fatherId="world[0]" />
      <Value key="2" x="900" y="50" z="500" rx="20" ry="30" rz="40" fatherId="world[0]" />
    </Data>
    <Data name="tMill" access="private" xsi:type="array" type="tool" size="1">
      <Value key="0" z="145.5" fatherId="flange[0]" ioLink="valve1" />
    </Data>
  </Datas>
</Database>""",
    "start.pgx": f"""<?xml version="1.0" encoding="utf-8"?>
<Programs xmlns="{SPACE}/Program/2">
  <Program name="start" access="public">
    <Code><![CDATA[
begin
  // park first
  movej(jPark,tMill,mSlow)
  movel(pEdge[0], tMill, mSlow)
  movel(pEdge[1], tMill, mSlow)
  waitEndMove()
  delay(0.5)
  movel(pEdge[2], tMill, mSlow)
end
]]></Code>
  </Program>
</Programs>""",
}
UR = """def polish():
  # made by hand
  set_tcp(p[0, 0, 0.15, 0, 0, 0])
  movej([-0.3, -1.57, 1.6, -1.6, -1.57, 0], a=1.2, v=0.75)
  movej(p[0.4, -0.2, 0.3, 0, 3.1415927, 0], a=1.2, v=0.75)
  movel(p[0.5, -0.2, 0.3, 0, 3.1415927, 0], a=1.2, v=0.25, r=0.001)
  sleep(0.5)
  movel(p[0.5,-0.1,3e-1,0,3.1415927,0], a=1.2, v=0.25, t=2.5, r=0)
end
"""


def test_krl() -> None:
    program = find_format("krl").read({"weld_7.src": KRL_SRC, "weld_7.dat": KRL_DAT})
    assert program.name == "weld_7"
    assert program.X is not None
    assert program.X[:, :3, 3] == pytest.approx(np.array([[1, 0, 1], [1.1, 0, 1], [1.1, 0.05, 1]]))
    want = Rotation.from_euler("z", 90, degrees=True) * Rotation.from_euler("x", 90, degrees=True)
    assert program.X[0, :3, :3] == pytest.approx(want.as_matrix(), abs=1e-12)
    assert program.time == pytest.approx([0, 0.5, 1.5])
    assert program.dwell == pytest.approx([0, 0, 0.5])
    assert program.tool[:3, 3] == pytest.approx([0.1205, 0, 0.31025])
    assert program.tool[:3, 2] == pytest.approx([1, 0, 0], abs=1e-12)
    assert program.blend == pytest.approx(5e-4)


def test_rapid() -> None:
    program = find_format("rapid").read({"MainModule.mod": RAPID})
    assert program.name == "MainModule"
    assert program.X is not None
    assert program.X[:, 0, 3] == pytest.approx([0.6005, 0.7005, 0.7005])
    assert program.X[1, :3, :3] == pytest.approx(
        Rotation.from_euler("y", 90, degrees=True).as_matrix(), abs=1e-6
    )
    assert program.time == pytest.approx([0, 1.0, 1.0 + 0.25 + 5.0])
    assert program.rails == pytest.approx(np.tile([0.011, 0.0123], (3, 1)))
    assert program.tool[:3, 3] == pytest.approx([0.0318, 0, 0.2296])
    assert program.blend == pytest.approx(5e-3)


def test_fanuc() -> None:
    program = find_format("ls").read({"cut_12.ls": LS})
    assert program.name == "CUT_12"
    assert program.X is not None
    assert program.X[:, 0, 3] == pytest.approx([1.680082, 1.780082, 1.780082])
    want = Rotation.from_euler("xyz", [180, -0.063, 30], degrees=True)  # about fixed axes
    assert program.X[0, :3, :3] == pytest.approx(want.as_matrix(), abs=1e-12)
    assert program.time == pytest.approx([0, 2, 3.5])
    home = find_format("ls").read({"home.ls": LS.replace("L P[", "!L P[")})
    assert home.q is not None
    assert np.degrees(home.q) == pytest.approx(
        np.array([[0, -30, 30, 0, -90, 0]])
    )  # as the controller shows them


def test_val3() -> None:
    program = find_format("val3").read(VAL3)
    assert program.name == "deburr"
    assert program.X is not None
    assert program.X[:, :3, 3] == pytest.approx(np.array([[0.8, 0, 0.5], [0.9, 0, 0.5], [0.9, 0.05, 0.5]]))
    turns = [
        Rotation.from_euler(axis, angle, degrees=True) for axis, angle in (("x", 20), ("y", 30), ("z", 40))
    ]
    assert program.X[0, :3, :3] == pytest.approx((turns[0] * turns[1] * turns[2]).as_matrix())
    assert program.time == pytest.approx([0, 2, 3.5])
    assert program.tool[2, 3] == pytest.approx(0.1455)


def test_urscript() -> None:
    program = find_format("urscript").read({"polish.script": UR})
    assert program.name == "polish"
    assert program.X is not None
    assert program.X[:, :3, 3] == pytest.approx(
        np.array([[0.4, -0.2, 0.3], [0.5, -0.2, 0.3], [0.5, -0.1, 0.3]])
    )
    assert program.X[0, :3, :3] == pytest.approx(np.diag([-1.0, 1.0, -1.0]), abs=1e-6)
    assert program.time == pytest.approx([0, 0.4, 0.4 + 0.5 + 2.5])
    assert program.tool[2, 3] == pytest.approx(0.15)


def test_csv_with_kuka_angles_and_with_joints() -> None:
    text = "t_s, x_mm, y_mm, z_mm, a_deg, b_deg, c_deg\n0,1000,0,500,90,0,90\n\n2.5,1100,0,500,90,0,90\n"
    program = find_format("csv").read({"path.csv": text})
    assert program.X is not None
    assert program.X[1, 0, 3] == pytest.approx(1.1)
    assert program.X[0, :3, 2] == pytest.approx([1, 0, 0], abs=1e-12)
    joints = find_format("csv").read({"path.csv": "t_s,q3_rad,q1_mm,q2_deg\n0,1,500,90\n"})
    assert joints.q == pytest.approx(np.array([[0.5, np.pi / 2, 1.0]]))
    assert joints.sliding == (True, False, False)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (
            "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,1,2,n/a,1,0,0,0\n",
            "path.csv line 2: z_mm is 'n/a', not a number",
        ),
        ("t_s,q1_deg\n0,1\n1,nan\n", "path.csv line 3: q1_deg is 'nan', not a finite number"),
        ("t_s,q1_deg\n0,1\n1,2\n0.5,3\n", "path.csv line 4: t_s is 0.5 s, after 1 s; time has to rise"),
        ("t_s;q1_deg\n0;1\n", "path.csv line 1: columns are separated by ';'; say separator"),
        ("t_s,q1_deg,q1_deg\n0,1,1\n", "path.csv line 1: column 'q1_deg' twice, columns 2 and 3"),
        ("t_s,q1_deg\n0,1,2\n", "path.csv line 2: has 3 columns, not 2"),
        ("t_s,q1_grad\n0,1\n", "column 'q1_grad': 'grad' is not a unit of it; name it q1_deg or q1_rad"),
        ("q1_deg\n1\n", "path.csv line 1: no column t_s"),
        ("t_s,x_mm,y_mm\n0,1,2\n", "path.csv: no column z_mm; a tool pose needs place and orientation"),
        ("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,1,2,3,0,0,0,0\n", "path.csv line 2: qw qx qy qz has length 0"),
        ("t_s,q1_deg,dwell_s\n0,1,-2\n", "path.csv line 2: dwell_s is negative; write 0"),
        ("", "path.csv: is empty"),
    ],
)
def test_faulty_tables(text: str, what: str) -> None:
    with pytest.raises(InputError) as caught:
        find_format("csv").read({"path.csv": text})
    assert what in str(caught.value)


@pytest.mark.parametrize(
    ("name", "file", "text", "what"),
    [
        ("krl", "a.src", "DEF a( )\nCIRC XP1, XP2\nEND", "a.src line 2: no position 'XP2' declared"),
        ("krl", "a.src", "DEF a( )\nCIRC {X 1,Y 1,Z 1}\nEND", "a.src line 2: CIRC cannot be read"),
        (
            "krl",
            "a.src",
            "DEF a( )\nLIN XP1\nEND",
            "line 2: no position 'XP1' declared; give the .dat as well",
        ),
        ("krl", "a.src", "DEF a( )\nLIN {X 5}\nEND", "line 2: no whole position"),
        (
            "krl",
            "a.src",
            "$BASE=BASE_DATA[3]\nLIN {X 1,Y 1,Z 1,A 0,B 0,C 0}",
            "BASE_DATA[3]: the base of the path stands on the controller, not in the file",
        ),
        ("krl", "a.src", "DEF a( )\nEND", "has no motion"),
        ("rapid", "a.mod", "MODULE a\nMoveC p1,p2,v10,fine,tool0;", "a.mod line 2: no target 'p1' declared"),
        ("rapid", "a.mod", "MODULE a\n\n MoveL p1,v10,fine,tool0;", "a.mod line 3: no target 'p1' declared"),
        ("ls", "a.ls", "/MN\n 1:C P[1] 5mm/sec FINE ;\n/POS\n/END", "a.ls line 2: C P[1] cannot be read"),
        ("ls", "a.ls", "/MN\n 1:L P[7] 5mm/sec FINE ;\n/POS\n/END", "L P[7] has no position cannot be read"),
        ("val3", "a.pjx", "<Project", "a.pjx: is not XML"),
        (
            "urscript",
            "a.script",
            "def a():\n movec(p[1,2,3,4,5,6],p[1,2,3])",
            "line 2: movec cannot be read",
        ),
        (
            "urscript",
            "a.script",
            "def a():\n movel(p_1, a=1)",
            "line 2: a motion without numbers cannot be read",
        ),
    ],
)
def test_what_cannot_be_read_is_said_by_line(name: str, file: str, text: str, what: str) -> None:
    with pytest.raises(InputError) as caught:
        find_format(name).read({file: text})
    assert what in str(caught.value)
