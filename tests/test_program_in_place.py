"""Existing programs: targets corrected, read by Drake's own arm, and every other byte as it was."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from extended_example import extended
from test_controller import MAKERS

from workbench.campaign import Target
from workbench.campaign.planned import planned
from workbench.cli.main import main
from workbench.correction.in_place import compensate_program
from workbench.correction.paths import Path as JointPath
from workbench.correction.programs import find_format
from workbench.correction.trajectory import nominal_joints
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.place import Where
from workbench.files.faults import InputError
from workbench.identification.model_file import write_model
from workbench.robot import rotations
from workbench.robot.description import Robot, load_robot
from workbench.simulation.virtual_campaign import Truth, simulate

NUMBER = r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?"

KRL_SRC = """&ACCESS RVP\r
DEF naht_3( )  ; Schweißnaht\r
;FOLD INI;%{PE}\r
  BAS (#INITMOV,0 )\r
;ENDFOLD (INI)\r
$BASE={X 100.0, Y -50.0, Z 20.0, A 10.0, B 0.0, C 0.0}\r
$TOOL={X 120.5,Y 0,Z 310.25,A 0,B 90,C 0}\r
PTP {A1 -5.0, A2 -80.0, A3 100.0, A4 5.0, A5 40.0, A6 -5.0} ; Anfahrt\r
  $OUT[3]=TRUE\r
IF $IN[7] THEN\r
$VEL.CP = 0.2\r
LIN {E6POS: X 1700.000, Y 0.0000, Z 1300.0, A 180.0, B -60.0, C 180.0, S 22, T 35} C_DIS\r
CIRC {X 1750.0,Y 50.0,Z 1300.0,A 180.0,B -60.0,C 180.0},XP3\r
lin xp4\r
ENDIF\r
LIN_REL {Z 5.0}\r
WAIT SEC 0.5\r
END\r
"""
KRL_DAT = """DEFDAT NAHT_3\r
DECL E6POS XP3={X 1800.0,Y 0.0,Z 1300.0,A 180.0,B -60.0,C 180.0,S 22,T 35,E1 0.0}\r
DECL E6POS XP4={X 1800.0,Y 0.0,Z 1350.0,A 180.0,B -60.0,C 180.0,S 22,T 35}\r
DECL E6POS XP9={X 1.0,Y 2.0,Z 3.0,A 4.0,B 5.0,C 6.0}\r
ENDDAT\r
"""
RAPID = """MODULE Seam
  ! made by hand; do not touch
  PERS tooldata tGun:=[TRUE,[[31.8,0.0,129.6],[0.965925826,0.0,0.258819045,0.0]],
    [1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wTable:=[FALSE,TRUE,"a; b",[[300.0,-100.0,50.0],[1.0,0.0,0.0,0.0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget p10:=[[100.5,100.0,150.3],[0.0,0.0,1.0,0.0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]; ! start
  VAR num nCount:=3.25;
  PROC main()
    MoveAbsJ [[0.0,10.0,20.0,0.0,45.0,0.0],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v1000,z50,tGun;
    FOR i FROM 1 TO 4 DO
      MoveL p10, v100, z5, tGun\\WObj:=wTable;
    ENDFOR
    MoveL Offs(p10,0.0,10.0,0.0), v100, fine, tGun\\WObj:=wTable;
    MoveL [[100.5,150.0,150.3],[0.0,0.0,1.0,0.0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v50,
      fine,tGun\\WObj:=wTable;
  ENDPROC
ENDMODULE
"""
LS = """/PROG  CUT_12
/ATTR
COMMENT\t\t= "cutting";
/MN
   1:  UFRAME_NUM=0 ;
   2:  PR[5]=LPOS ;
   3:  PR[5,1]=0.000 ;
   4:  PR[5,2]=0.000 ;
   5:  PR[5,3]=100.000 ;
   6:  PR[5,4]=0.000 ;
   7:  PR[5,5]=0.000 ;
   8:  PR[5,6]=0.000 ;
   9:  UTOOL[2]=PR[5] ;
  10:  !approach ;
  11:J P[1:HOME] 20% FINE    ;
  12:L P[2] 250mm/sec CNT50 ACC80    ;
  13:  DO[12]=ON ;
  14:C P[3]
    :  P[4] 100mm/sec FINE    ;
/POS
P[1:"HOME"]{
   GP1:
\tUF : 0, UT : 2,\t
\tJ1=    10.000 deg,\tJ2=    10.000 deg,\tJ3=   -20.000 deg,
\tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=      .000 deg
};
P[2]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   400.000  mm,\tY =      .000  mm,\tZ =   100.000  mm,
\tW =   180.000 deg,\tP =     -.063 deg,\tR =    30.000 deg
};
P[3]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   420.000  mm,\tY =    20.000  mm,\tZ =   100.000  mm,
\tW =   180.000 deg,\tP =     -.063 deg,\tR =    30.000 deg
};
P[4]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   440.000  mm,\tY =      .000  mm,\tZ =   100.000  mm,
\tW =   180.000 deg,\tP =     -.063 deg,\tR =    30.000 deg
};
/END
"""
UR = """def polish():
  # made by hand, 2.5 mm tool
  set_tcp(p[0.0, 0.0, 0.15, 0.0, 0.0, 0.0])
  global wait_here = p[-0.7, 0.05, 0.45, 2.5, 1.9, 0.0]
  movej([-0.3, -1.57, 1.6, -1.6, -1.57, 0.0], a=1.2, v=0.75)
  movel(wait_here, a=1.2, v=0.25)
  set_digital_out(0, True)
  movel(p[-0.6,0.05,4.5e-1,2.5,1.9,0.0], a=1.2, v=0.25, r=0.001)
  movel(pose_add(wait_here, p[0.0,0.0,0.1,0.0,0.0,0.0]), a=1.2, v=0.25)
end
"""
VAL3 = {
    "Edge.pjx": '<Project><Database><Data file="Edge.dtx" /></Database></Project>\n',
    "Edge.dtx": """<?xml version="1.0" encoding="utf-8"?>
<Database xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <Datas>
    <!-- <Data name="pEdge"><Value key="0" x="1.5" /></Data> -->
    <Data name="jPark" xsi:type="array" type="jointRx" size="1">
      <Value key="0" j1="10.0" j2="20.0" j3="70.0" j4="5.0" j5="40.0" j6="10.0" />
    </Data>
    <Data name="mSlow" xsi:type="array" type="mdesc" size="1">
      <Value key="0" vel="100" tmax="50.0" rmax="99999" blend="off" />
    </Data>
    <Data name="pEdge" xsi:type="array" type="pointRx" size="3">
      <Value key="0" x="1311.247" y="321.927" z="617.522" rx="-166.26" ry="18.21" rz="176.47"
        fatherId="world[0]" />
      <Value key="1" x='1312.889' y='370.970' z='567.474' rx='-166.68' ry='13.89' rz='175.23'
        fatherId='world[0]' />
      <Value key="2" x="1337.977" y="451.579" z="582.771" rx="-165.34" ry="15.05" rz="171.74"
        fatherId="world[0]" />
    </Data>
    <Data name="tMill" xsi:type="array" type="tool" size="1">
      <Value key="0" x="20.0" z="145.0" ry="30.0" fatherId="flange[0]" />
    </Data>
  </Datas>
</Database>
""",
    "start.pgx": """<?xml version="1.0" encoding="utf-8"?>
<Programs><Program name="start"><Code><![CDATA[
begin
  movej(jPark,tMill,mSlow)
  movel(pEdge[0],tMill,mSlow)
  for i=1 to 2
    movel(pEdge[i],tMill,mSlow)
  endFor
  movel(appro(pEdge[2],trAway),tMill,mSlow)
end
]]></Code></Program></Programs>
""",
}
CASES = {
    "val3": ("rx170", VAL3, 4, "utf-8"),
    "krl": ("kr500", {"naht_3.src": KRL_SRC, "naht_3.dat": KRL_DAT}, 4, "latin-1"),
    "rapid": ("irb120", {"Seam.mod": RAPID}, 3, "utf-8"),
    "ls": ("lrmate200id", {"cut_12.ls": LS}, 3, "utf-8"),
    "urscript": ("ur10", {"polish.script": UR}, 3, "utf-8"),
}


def bent(name: str, folder: Path) -> tuple[Path, Robot]:
    """A model with wrong lengths and soft joints, as a file and as loaded."""
    effects = []
    for joint in load_robot(name).joints[1:3]:
        stated = joint.data.stiffness
        value = 0.3 if stated else 2e-6
        effects.append(
            (JointCompliance(Where(joint=joint.name), nominal=1 / stated if stated else 0.0), [value])
        )
    robot = extended(load_robot(name), effects, size=3e-4)
    path = folder / "model.toml"
    arm = np.zeros((8, 6))
    arm[1:7] = [list(robot.geometry[joint].values()) for joint in robot.joint_names]
    write_model(path, robot, arm, robot.effects)
    text = path.read_text() + "\n[tool]\nmass_kg = 2.0\ncom_mm = [0.0, 0.0, 50.0]\n"
    path.write_text(text)
    return path, load_robot(path)


def flanges(robot: Robot, form: str, texts: dict[str, str]) -> list[np.ndarray]:
    """Where the controller believes the URDF's flange to be at every target, by the maker's kinematics."""
    convention, found = robot.convention, []
    assert convention is not None
    for move in find_format(form).scan(texts).moves:
        if move.kind == "joints":
            shown = MAKERS[robot.name][1](np.degrees(move.arm))
            found.append(convention.from_world(shown) @ np.linalg.inv(convention.flange))
            continue
        assert move.X is not None
        tool = convention.from_flange(move.tool.matrix)
        for X in [move.via, move.X] if move.via is not None else [move.X]:
            assert X is not None
            found.append(convention.from_world(move.base.matrix @ X @ np.linalg.inv(tool)))
    return found


def start_of(robot: Robot, form: str, texts: dict[str, str]) -> np.ndarray:
    """(6,) the URDF's joints of the first target, whose posture the program keeps."""
    move = next(move for move in find_format(form).scan(texts).moves if move.kind == "joints")
    assert robot.convention is not None
    return robot.convention.joints(np.array([move.arm]))[0]


def in_drake(robot: Robot, wanted: list[np.ndarray], told: list[np.ndarray], start: np.ndarray) -> np.ndarray:
    """Distance [m] of three points of the true flange from where they should be, told to go to `told`."""
    nominal = load_robot(robot.name)
    q = [nominal_joints(nominal, JointPath(np.arange(2.0), X=np.array([X, X])), start=start)[0] for X in told]
    corners = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
    plan = planned(
        robot,
        np.array(q),
        targets=tuple(Target(f"T{i}", tuple(corner)) for i, corner in enumerate(corners.tolist())),
        tool=(2.0, (0.0, 0.0, 0.05)),
    )
    still = Truth(repeatability=np.zeros(6))
    seen = simulate(plan, still, instrument=(np.eye(3)[None], np.zeros((1, 3)))).points
    X = np.array(wanted)
    should = np.einsum("nij,tj->nti", X[:, :3, :3], corners) + X[:, None, :3, 3]
    return np.linalg.norm(seen - should, axis=2)


@pytest.mark.parametrize("form", CASES)
def test_targets_are_corrected_and_nothing_else_changes(form: str, tmp_path: Path) -> None:
    name, texts, count, codec = CASES[form]
    model, robot = bent(name, tmp_path)
    for file, text in texts.items():
        (tmp_path / file).write_bytes(text.encode(codec))
    done = compensate_program(tmp_path / next(iter(texts)), model)
    assert [file.name for file in done.files] == list(texts)
    after = {file.name: file.read_bytes().decode(codec) for file in done.files}
    assert done.targets == count + (form in ("krl", "ls"))  # and the circle's via point
    for file, text in texts.items():
        assert re.sub(NUMBER, "#", after[file]) == re.sub(NUMBER, "#", text)
        if Path(file).suffix in (".pjx", ".pgx"):  # the numbers stand in the data
            assert after[file] == text
            continue
        changed = [a != b for a, b in zip(after[file].splitlines(), text.splitlines(), strict=True)]
        assert 0 < sum(changed) < 12
    wanted, told = flanges(robot, form, texts), flanges(robot, form, after)
    start = start_of(robot, form, texts)
    before, left = in_drake(robot, wanted, wanted, start), in_drake(robot, wanted, told, start)
    assert before.max() > 2e-4
    assert left.max() < (2e-5 if form in ("ls", "krl") else 5e-6)
    turns = [
        rotations.angle_between(a[None, :3, :3], b[None, :3, :3])[0]
        for a, b in zip(wanted, told, strict=True)
    ]
    assert max(turns) < 0.02


def test_what_is_said_to_be_left_is_what_the_written_digits_leave(tmp_path: Path) -> None:
    """As Drake's arm has it, told the numbers in the file: three decimals of a degree leave micrometres."""
    model, robot = bent("lrmate200id", tmp_path)
    text = LS.replace("PR[5,3]=100.000", "PR[5,3]=0.000")
    (tmp_path / "cut_12.ls").write_text(text)
    done = compensate_program(tmp_path / "cut_12.ls", model)
    wanted, told = (flanges(robot, "ls", {"a.ls": said}) for said in (text, done.files[0].read_text()))
    left = 1e3 * in_drake(robot, wanted, told, start_of(robot, "ls", {"a.ls": text}))[:, 0]
    assert 1e-3 < left.max() < 1e-2
    np.testing.assert_allclose(done.compensation.after_mm, left, atol=2e-5)
    assert "less than 0.001 mm corrected" not in done.text


def test_what_is_computed_is_left_alone_and_told(tmp_path: Path) -> None:
    model, _ = bent("irb120", tmp_path)
    (tmp_path / "Seam.mod").write_text(RAPID)
    done = compensate_program(tmp_path / "Seam.mod", model)
    assert any("line 13: 'Offs(p10,0.0,10.0,0.0)' is computed" in note for note in done.notes)
    assert "MoveL Offs(p10,0.0,10.0,0.0), v100" in done.files[0].read_text()


def test_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, _ = bent("ur10", tmp_path)
    program = tmp_path / "polish.script"
    program.write_text(UR)
    call = ["compensate", str(program), "--model", str(model), "--json"]
    assert main([*call, "--out", str(tmp_path / "new.script")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["targets"] == 3
    assert told["files"] == [str(tmp_path / "new.script")]
    assert program.read_text() == UR
    assert main([*call, "--out", str(program)]) == 2
    assert (
        "is there already, with other content; name another with --out, or say --force"
        in capsys.readouterr().err
    )
    assert program.read_text() == UR
    assert main([*call, "--out", str(tmp_path / "new.txt")]) == 2
    assert "ends in .txt; URScript ends in .script" in capsys.readouterr().err


def test_a_frame_that_stands_on_the_controller_has_to_be_given(tmp_path: Path) -> None:
    model, _ = bent("kr500", tmp_path)
    lines = KRL_SRC.splitlines(keepends=True)
    lines[6] = "$TOOL=TOOL_DATA[2]\r\n"
    (tmp_path / "naht_3.src").write_bytes("".join(lines).encode())
    (tmp_path / "naht_3.dat").write_bytes(KRL_DAT.encode())
    with pytest.raises(
        InputError, match=r"line 7: TOOL_DATA\[2\]: this tool stands on the controller.*--tool"
    ):
        compensate_program(tmp_path / "naht_3.src", model)
    tool = rotations.pose(
        np.array([0.1205, 0.0, 0.31025]), rotations.from_zyx(np.radians([[0.0, 90.0, 0.0]]))[0]
    )
    assert compensate_program(tmp_path / "naht_3.src", model, tool=tool).targets == 5


def test_numbers_that_an_application_leaves_out_for_zero_are_put_in(tmp_path: Path) -> None:
    model, robot = bent("rx170", tmp_path)
    bare = {name: re.sub(r' (y="321.927"|j1="10.0")', "", text) for name, text in VAL3.items()}
    for name, text in bare.items():
        (tmp_path / name).write_text(text)
    done = compensate_program(tmp_path / "Edge.pjx", model, tmp_path / "new")
    assert done.targets == 4
    assert any("appro(pEdge[2],trAway)" in note for note in done.notes)
    after = {file.name: file.read_text() for file in done.files}
    old, new = flanges(robot, "val3", bare), flanges(robot, "val3", after)
    apart = [np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(old, new, strict=True)]
    assert 1e-5 < min(apart) < max(apart) < 5e-3
    assert re.search(r'<Value y="-?0?\d*\.\d+" key="0" x="131', after["Edge.dtx"])


def test_a_file_without_targets_is_refused(tmp_path: Path) -> None:
    model, _ = bent("rx170", tmp_path)
    (tmp_path / "a.pjx").write_text("<Project/>")
    with pytest.raises(InputError, match="has no target that could be corrected"):
        compensate_program(tmp_path / "a.pjx", model)
