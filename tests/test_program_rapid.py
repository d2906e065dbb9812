"""RAPID as it is written in shops: order of calls, arrays, loops, options, and what has to be told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_program_in_place import bent
from test_program_unread import only_told, rapid

from workbench.correction.in_place import compensate_program
from workbench.correction.programs import find_format
from workbench.correction.programs.motions import Motions

FAR = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
END = "v100,fine,t1"


def at(x: float) -> str:
    return f"[[{x},0,0],[1,0,0,0],{FAR}"


def module(*parts: str) -> Motions:
    return find_format("rapid").scan({"m.mod": "\n".join(["MODULE m", *parts, "ENDMODULE", ""])})


def places(motions: Motions) -> list[float]:
    """x of every pose [mm]."""
    return [round(1e3 * move.X[0, 3], 6) for move in motions.moves if move.X is not None]


def test_routines_are_read_where_they_are_called() -> None:
    motions = module(
        f"PROC weld()\nMoveL {at(2)},v9,fine,tool0;\nENDPROC",
        f"PROC idle()\nMoveL {at(9)},v9,fine,tool0;\nENDPROC",
        f"PROC main()\nMoveJ {at(1)},v9,fine,tool0;\nIF di1=1 THEN\nweld;\nENDIF\nWeld;",
        f"MoveL {at(3)},v9,fine,tool0;\nENDPROC",
    )
    assert places(motions) == [9, 1, 2, 2, 3]
    assert [move.line for move in motions.moves] == [6, 9, 3, 3, 14]
    assert [move.anew for move in motions.moves] == [False, True, False, False, False]


def test_a_trap_that_is_connected_is_not_run_there() -> None:
    motions = module(
        f"PROC main()\nCONNECT n1 WITH tStop;\nMoveJ {at(1)},v9,fine,tool0;\nENDPROC",
        f"TRAP tStop\nMoveL {at(2)},v9,fine,tool0;\nENDTRAP",
    )
    assert places(motions) == [1, 2]
    assert [move.anew for move in motions.moves] == [False, True]


def test_routines_that_call_each_other_are_read() -> None:
    motions = module(
        "PROC main()\nservice;\nENDPROC", f"PROC service()\nMoveL {at(1)},v9,fine,tool0;\nmain;\nENDPROC"
    )
    assert places(motions) == [1]


def test_shifts_and_switches_hold_in_what_is_called() -> None:
    motions = module(
        f"PROC seam()\nMoveL {at(1)},v9,fine,tool0;\nENDPROC",
        "PROC main()\nConfL\\Off;\nseam;\nPDispSet [[0,0,9],[1,0,0,0]];\nseam;\nPDispOff;\nseam;\nENDPROC",
    )
    assert places(motions) == [1, 1]
    assert [move.posture.obeyed for move in motions.moves if move.posture] == [False, False]
    assert ["goes to a shifted target" in str(fault) for fault in motions.faults] == [True]


def test_arrays_and_loops_over_them_are_read() -> None:
    rows = ",\n".join(f"[{at(10 * i + 1)},{at(10 * i + 2)}]" for i in (1, 2))
    motions = module(
        f"CONST robtarget p{{3}}:=[{at(1)},{at(2)},\n{at(3)}];",
        f"PERS robtarget g{{2,2}}:=[{rows}];",
        "PROC main()\nMoveJ p{ 3 },v9,fine,tool0;",
        "FOR i FROM 1 TO 2 DO\nMoveL p{i},v9,fine,tool0;\nFOR k FROM 2 TO 1 DO\nMoveL g{i,k},v9,z1,tool0;",
        "ENDFOR\nMoveL p{i+1},v9,fine,tool0;\nENDFOR",
        "FOR i FROM 1 TO n DO\nMoveL p{i},v9,fine,tool0;\nENDFOR\nMoveL p{4},v9,fine,tool0;\nENDPROC",
    )
    assert places(motions) == [3, 1, 12, 11, 2, 2, 22, 21, 3]
    first = motions.moves[1].spot
    assert first is not None
    assert motions.moves[5].spot == motions.moves[4].spot != first
    computed, absent = motions.faults
    assert "line 16: 'p{i}' is computed" in str(computed)
    assert "line 18: no target 'p{4}' declared" in str(absent)


def test_an_entry_that_is_set_makes_the_array_computed() -> None:
    motions = module(
        f"VAR robtarget p{{2}}:=[{at(1)},{at(2)}];",
        "PROC main()\np{n}.trans.z:=5;\nMoveL p{1},v9,fine,tool0;\nENDPROC",
    )
    only_told(motions, "'p{1}' is set in the program")


@pytest.mark.parametrize(
    "line", ["VAR robtarget p10:=p20;", "VAR robtarget p10:=Offs(p20,0,0,5);", "VAR robtarget p10{3};"]
)
def test_data_of_the_routine_hide_those_of_the_module(line: str) -> None:
    only_told(rapid(line, f"MoveL p10,{END};"), "no target 'p10' declared")


def test_blanks_where_the_language_has_them() -> None:
    motions = rapid(
        "MoveL p10\\ID:=10,v100\\V:=20,z10 \\ Inpos:=inpos50,t1 \\ WObj := w1 ;",
        f"MoveL[[1,2,3],[1,0,0,0],{FAR},{END};",
    )
    assert not motions.faults
    assert [move.base.matrix[0, 3] for move in motions.moves] == [0.01, 0.0]


@pytest.mark.parametrize("number", ["- 5", "5-3", "-(5)", "2*3"])
def test_numbers_of_targets_and_tools_are_numbers(number: str) -> None:
    only_told(rapid(f"MoveL [[1,2,{number}],[1,0,0,0],{FAR},{END};"), "m.mod line 8: ")
    tool = f"PERS tooldata t2:=[TRUE,[[0,0,{number}],[1,0,0,0]],[5,[0,0,50],[1,0,0,0],0,0,0]];"
    (move,) = rapid(tool, "MoveL p10,v100,fine,t2;").moves
    assert (move.tool.X, move.tool.name) == (None, "t2")


def test_what_a_call_or_a_search_sets_is_told() -> None:
    motions = module(
        f"PERS robtarget pFound:=[[1,2,3],[1,0,0,0],{FAR};\nPERS robtarget pSeam:=[[1,2,3],[1,0,0,0],{FAR};",
        "PROC find(INOUT robtarget p)\np:=CRobT();\nENDPROC",
        "PROC main()\nfind pSeam;\nSearchL\\Stop,di1,pFound,pTo,v10,tool0;",
        "MoveL pSeam,v9,fine,tool0;\nMoveL pFound,v9,fine,tool0;\nENDPROC",
    )
    only_told(motions, "SearchL", "'pSeam' is set in the program", "'pFound' is set in the program")


def test_an_instruction_that_takes_a_target_is_told() -> None:
    motions = rapid("IF go THEN\nGlueOn p10,v9,glue1,t1;\nENDIF", "StudWeld\\Test,stud1,p20;", "RETURN p10;")
    only_told(motions, "m.mod line 9: GlueOn takes the target 'p10'", "m.mod line 11: StudWeld takes")


def test_the_total_load_of_a_motion_counts_in_place_of_the_tools() -> None:
    part = "PERS loaddata lPart:=[40,[10,0,90],[1,0,0,0],0,0,0];"
    motions = rapid(
        part,
        f"MoveL p10,{END}\\WObj:=w1\\TLoad:=lPart;",
        f"MoveL p10,{END}\\TLoad:=load0;",
        f"MoveL p10,{END}\\TLoad:=lOther;",
    )
    loads = [move.load for move in motions.moves]
    assert loads[0] is not None
    assert (loads[0].mass_kg, loads[0].com_mm) == (40.0, (10.0, 0.0, 90.0))
    assert loads[1] is not None
    assert loads[1].mass_kg == 5.0
    assert loads[2] is None
    assert ["TLoad 'lother'" in str(remark) for remark in motions.remarks] == [True]


def test_a_routine_that_nothing_calls_begins_in_its_own_posture(tmp_path: Path) -> None:
    """Whatever stands before it in the file: the text order of two routines is no path of the arm."""
    model, _ = bent("irb120", tmp_path)
    line = "MoveL [[300.0,{y},400.0],[0,0,1,0],[{c},0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v9,fine,tool0;"
    front, side = line.format(y="10.0", c=0), line.format(y="-10.0", c=-1)
    behind = "MoveAbsJ [[150.0,10.0,20.0,0.0,45.0,0.0],[9E9,9E9,9E9,9E9,9E9,9E9]],v9,fine,tool0;"
    alone = f"MODULE m\nPROC b()\n{side}\n{front}\nENDPROC\nENDMODULE\n"
    both = alone.replace("PROC b", f"PROC a()\n{behind}\nENDPROC\nPROC b")
    told = []
    for name, text in (("x.mod", alone), ("y.mod", both)):
        (tmp_path / name).write_text(text)
        done = compensate_program(tmp_path / name, model)
        told.append([row for row in done.files[0].read_text().splitlines() if row.startswith("MoveL")])
        np.testing.assert_array_less(done.compensation.after_mm, 1e-3 + 2e-3 * (name == "y.mod"))
    assert told[0] == told[1]
