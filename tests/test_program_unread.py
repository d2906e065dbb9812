"""Existing programs: a target that the program computes, shifts or sets elsewhere is told, never misread."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from test_program_in_place import CASES, KRL_DAT, KRL_SRC, RAPID, UR, bent

from workbench.cli.main import main
from workbench.correction.in_place import compensate_program
from workbench.correction.programs import find_format
from workbench.correction.programs.motions import Motions

KRL_POINTS = """DEFDAT A
DECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 10,E1 0}
DECL FDAT FP1={TOOL_NO 3,BASE_NO 2,IPO_FRAME #BASE}
DECL FDAT FP2={TOOL_NO 4,BASE_NO 5,IPO_FRAME #TCP}
ENDDAT
"""
FAR = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
RAPID_POINTS = f"""MODULE M
CONST robtarget p10:=[[1,2,3],[1,0,0,0],{FAR};
PERS robtarget p20:=[[4,5,6],[1,0,0,0],{FAR};
CONST jointtarget j1:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];
PERS tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[5,[0,0,50],[1,0,0,0],0,0,0]];
PERS wobjdata w1:=[FALSE,TRUE,"",[[10,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
PROC main(%s)
%s
ENDPROC
ENDMODULE
"""
LS_POINTS = """/POS
P[1]{
   GP1:
\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   400.0  mm,\tY =     0.0  mm,\tZ =   100.0  mm,
\tW =   180.0 deg,\tP =     0.0 deg,\tR =    30.0 deg
};
P[2]{
   GP1:
\tUF : F, UT : F,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   400.0  mm,\tY =     0.0  mm,\tZ =   100.0  mm,
\tW =   180.0 deg,\tP =     0.0 deg,\tR =    30.0 deg
};
/END
"""
POSE = "p[0.1,0.2,0.3,0,3,0]"


def krl(*lines: str) -> Motions:
    return find_format("krl").scan({"a.src": "\n".join(["DEF a()", *lines, "END", ""]), "a.dat": KRL_POINTS})


def rapid(*lines: str, takes: str = "") -> Motions:
    return find_format("rapid").scan({"m.mod": RAPID_POINTS % (takes, "\n".join(lines))})


def ls(*lines: str) -> Motions:
    numbered = [f"  {i}:{line} ;" for i, line in enumerate(lines, 1)]
    return find_format("ls").scan({"a.ls": "\n".join(["/PROG  A", "/MN", *numbered, LS_POINTS])})


def urscript(*lines: str) -> Motions:
    return find_format("urscript").scan({"a.script": "\n".join(["def p():", *lines, "end", ""])})


def only_told(motions: Motions, *what: str) -> None:
    """No motion was read, and each of them is told."""
    assert not motions.moves
    assert len(motions.faults) == len(what)
    for fault, words in zip(motions.faults, what, strict=True):
        assert words in str(fault)


@pytest.mark.parametrize(
    "line",
    ["LIN XP1 : {X 0,Y 0,Z 100,A 0,B 0,C 0}", "PTP $POS_ACT:OFF", "LIN P[3]", "SLIN above(XP1)", "LIN S.P"],
)
def test_krl_targets_that_are_computed_in_the_motion_are_told(line: str) -> None:
    only_told(krl(line), "a computed target cannot be read")


@pytest.mark.parametrize("line", ["XP1.Z = 500", "XP1=$POS_ACT", "xp1 = {X 9,Y 2,Z 3,A 4,B 5,C 6}"])
def test_krl_targets_that_the_program_sets_are_told(line: str) -> None:
    only_told(krl(line, "LIN XP1", "CIRC XP1, {X 1,Y 2,Z 3,A 4,B 5,C 6}"), *2 * ["XP1 is set in the program"])


@pytest.mark.parametrize(
    ("lines", "tool", "base"),
    [
        (["BAS(#BASE,1)", "BAS (#TOOL,2 )"], "TOOL_DATA[2]", "BASE_DATA[1]"),
        (["FDAT_ACT = {TOOL_NO 1,BASE_NO 6,IPO_FRAME #BASE}"], "TOOL_DATA[1]", "BASE_DATA[6]"),
        (["FDAT_ACT=FP1"], "TOOL_DATA[3]", "BASE_DATA[2]"),
        (["FDAT_ACT=FP9"], "FP9", "FP9"),
        (["BAS(#TOOL,1)", "$BASE=$NULLFRAME", "$BASE.X = 100"], "TOOL_DATA[1]", "$BASE.X = 100"),
        (["BAS(#TOOL,1)", "$BASE={X 0,Y 0,Z DZ,A 0,B 0,C 0}"], "TOOL_DATA[1]", "{X 0,Y 0,Z DZ,A 0,B 0,C 0}"),
    ],
)
def test_krl_frames_of_the_controller_are_named(lines: list[str], tool: str, base: str) -> None:
    (move,) = krl(*lines, "LIN XP1").moves
    assert (move.tool.X, move.tool.name, move.base.X, move.base.name) == (None, tool, None, base)


def test_krl_frames_after_with_hold_for_that_motion_and_those_of_a_block_in_it() -> None:
    frames = "$TOOL = STOOL2(FP1), $BASE = SBASE(FP1.BASE_NO), $IPO_MODE = SIPO_MODE(FP1.IPO_FRAME)"
    motions = krl(
        "$TOOL=$NULLFRAME",
        f"SLIN XP1 WITH $VEL = SVEL_CP(0.5, , L1), {frames}",
        "SLIN XP1",
        f"SPLINE WITH {frames}",
        "SPL XP1",
        "ENDSPLINE",
        "SLIN XP1",
    )
    assert [move.tool.name for move in motions.moves] == ["TOOL_DATA[3]", "", "TOOL_DATA[3]", ""]
    assert [move.base.name for move in motions.moves] == ["BASE_DATA[2]", "", "BASE_DATA[2]", ""]


@pytest.mark.parametrize("line", ["FDAT_ACT=FP2", "$IPO_MODE=#TCP"])
def test_krl_a_tool_that_stands_still_is_told(line: str) -> None:
    only_told(krl(line, "LIN XP1"), "the robot holds the work (#TCP)")
    assert krl(line, "$IPO_MODE=#BASE", "LIN XP1").moves


def test_krl_home_and_a_load_of_the_controller_are_told(tmp_path: Path) -> None:
    model, _ = bent("kr500", tmp_path)
    text = KRL_SRC.replace("  $OUT[3]=TRUE", "PTP XHOME\r\n$LOAD=LOAD_DATA[2]\r\n$LOAD_A3={M 9.0}")
    (tmp_path / "naht_3.src").write_bytes(text.encode())
    (tmp_path / "naht_3.dat").write_bytes(KRL_DAT.encode())
    notes = compensate_program(tmp_path / "naht_3.src", model).notes
    assert "naht_3.src line 9: XHOME stands on the controller: left alone" in notes
    assert [
        note for note in notes if "line 10: $LOAD =LOAD_DATA[2]: this load stands on the controller" in note
    ]


@pytest.mark.parametrize(
    "line",
    ["p20.trans.z:=100;", "p20:=Offs(p10,0,0,100);", "IF a THEN p20 := CRobT(); ENDIF", "IF a p20:=p10;"],
)
def test_rapid_targets_that_the_program_sets_are_told(line: str) -> None:
    only_told(rapid(line, "MoveL p20,v100,fine,t1;"), "'p20' is set in the program")


def test_rapid_targets_of_a_call_and_those_without_a_value_are_not_those_of_the_module() -> None:
    move = "MoveL p10,v100,fine,t1;"
    only_told(rapid(move, takes="robtarget p10,\\switch fast"), "no target 'p10' declared")
    only_told(rapid("VAR robtarget p10;", move), "no target 'p10' declared")


def test_rapid_numbers_that_are_computed_are_told() -> None:
    lines = [
        f"MoveL [[{place}],[1,0,0,0],{FAR},v100,fine,t1;" for place in ("1,2,x3", "x1,-y2,z3", "1,2,3+5")
    ]
    only_told(rapid(*lines), *3 * ["is computed; give its numbers"])


def test_rapid_frames_that_the_program_sets_are_told() -> None:
    move = "MoveL p10,v100,fine,t1\\WObj:=w1;"
    for line in ("w1.uframe.trans:=[5,5,5];", "t1.tframe := found;"):
        only_told(rapid(line, move), "is set in the program")


def test_rapid_shifted_targets_are_told() -> None:
    motions = rapid(
        "PDispSet [[0,0,9],[1,0,0,0]];",
        "MoveL p10,v100,fine,t1;",
        "MoveAbsJ j1,v100,fine,t1;",
        "PDispOff;",
        "MoveL p10,v100,fine,t1;",
    )
    assert [move.line for move in motions.moves] == [10, 12]
    assert [str(fault) for fault in motions.faults] == [
        "m.mod line 9: MoveL goes to a shifted target; export the path anew"
    ]
    assert "PDispSet shifts targets" in str(motions.remarks[0])


def test_rapid_motions_of_processes_are_told() -> None:
    names = ["TriggL", "TriggJ", "ArcLStart", "ArcL", "ArcLEnd", "SearchL", "SpotL", "MoveExtJ"]
    motions = rapid(
        *(f"{name} p10,v100,x,fine,t1\\WObj:=w1;" for name in names), "IF a ArcL p10,v100,x,fine,t1;"
    )
    only_told(motions, *(f"{name} cannot be read" for name in [*names, "ArcL"]))


def test_rapid_options_before_and_after_the_arguments_are_read() -> None:
    motions = rapid(
        "MoveL\\Conc,p10,v100,fine,t1;",
        "MoveJ \\Conc,p10,v100,fine,t1;",
        "MoveLDO p10,v100,fine,t1\\WObj:=w1,do1,1;",
        "GripLoad piece;",
    )
    assert not motions.faults
    assert [move.base.matrix[0, 3] for move in motions.moves] == pytest.approx([0.0, 0.0, 0.01])
    assert "GripLoad: this load is not counted" in str(motions.remarks[0])


@pytest.mark.parametrize(
    "shift", ["Offset,PR[1]", "Tool_Offset,PR[2]", "WKZ_Offset ,PR[1]", "INC", "VOFFSET,VR[1]"]
)
def test_ls_shifted_positions_are_told(shift: str) -> None:
    only_told(ls(f"L P[1] 100mm/sec CNT60 {shift}"), "L P[1] with an offset cannot be read")


def test_ls_positions_that_are_named_or_set_by_the_program_are_told() -> None:
    only_told(ls("L PR[R[98]] 300mm/sec FINE", "J P[R[1]] 5% FINE"), "PR[R[98]]", "P[R[1]]")
    only_told(ls("P[1:a]=PR[3]", "L P[1:a] 10mm/sec FINE"), "P[1] is set in the program")


def test_ls_positions_in_the_frames_in_force() -> None:
    motions = ls(
        "L P[2] 9mm/sec FINE", "UFRAME_NUM=3", "UTOOL_NUM=R[1]", "L P[2] 9mm/sec FINE", "L P[1] 9mm/sec FINE"
    )
    assert [move.base.name for move in motions.moves] == ["UFRAME in force", "UFRAME[3]", "UFRAME[1]"]
    assert [move.tool.name for move in motions.moves] == ["UTOOL in force", "UTOOL in force", "UTOOL[2]"]


@pytest.mark.parametrize(
    "lines",
    [
        [f"x={POSE}", "x[2] = 0.9", "movel(x)"],
        [f"global x = {POSE}", "x = pose_add(x, p[0,0,0.1,0,0,0])", "movel(x)"],
        [f"x={POSE}", "def go(x):", "movel(x)", "end"],
        ["q=[1,2,3,4,5,6]", "movej(q[1])"],
        ["movej([0,-pi/2,0,-pi/2,0,0])"],
        ["movej([x1,0,0,0,0,0])"],
        ["movel(p[x2,0.1,0,0,-z3,0])"],
    ],
)
def test_urscript_targets_that_are_computed_are_told(lines: list[str]) -> None:
    only_told(urscript(*lines), "cannot be read")


def test_urscript_tools_and_payloads_that_are_computed_are_not_known() -> None:
    motions = urscript("set_tcp(p[0,0,x1,0,0,0])", "set_payload(m, [0,0,0.1])", f"movel({POSE})")
    (move,) = motions.moves
    assert (move.tool.X, move.tool.name, move.load) == (None, "p[0,0,x1,0,0,0]", None)
    assert "this payload is computed" in str(motions.remarks[0])


def test_val3_points_that_a_program_sets_are_told_and_collections_are_no_points() -> None:
    texts = dict(CASES["val3"][1])
    texts["start.pgx"] = texts["start.pgx"].replace("begin", "begin\n  delay(nWait)\n  pEdge[0].trsf.z = 5")
    texts["Edge.dtx"] = texts["Edge.dtx"].replace(
        "  <Datas>", '  <Datas>\n<Data name="n" type="num"><Value key="STOP" value="1" /></Data>'
    )
    motions = find_format("val3").scan(texts)
    assert [move.kind for move in motions.moves] == ["joints"]
    assert sum("pEdge is set in a program" in str(fault) for fault in motions.faults) == 2


def test_what_is_told_is_no_more_than_once(tmp_path: Path) -> None:
    model, _ = bent("irb120", tmp_path)
    text = str(CASES["rapid"][1]["Seam.mod"]).replace("VAR num nCount", "PERS num nCount")
    call = "MoveL Offs(p10,0.0,10.0,0.0), v100, fine, tGun\\WObj:=wTable;"
    (tmp_path / "Seam.mod").write_text(text.replace(call, f"{call} {call}"))
    notes = compensate_program(tmp_path / "Seam.mod", model).notes
    assert len(set(notes)) == len(notes)
    assert np.any(["left alone" in note for note in notes])


@pytest.mark.parametrize(
    ("name", "file", "text"),
    [("ur10", "a.urscript", UR), ("irb120", "a.modx", RAPID), ("irb120", "a.PRG", RAPID)],
)
def test_other_extensions_of_programs_are_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, file: str, text: str
) -> None:
    model, _ = bent(name, tmp_path)
    (tmp_path / file).write_text(text)
    assert main(["compensate", str(tmp_path / file), "--model", str(model), "--json"]) == 0
    (written,) = json.loads(capsys.readouterr().out)["files"]
    assert written.endswith(file)
