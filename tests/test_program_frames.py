"""Frames, loads and order of existing programs: what holds at a target, what is refused as not known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_program_in_place import LS, RAPID, UR, bent

from workbench.correction.command import compensate
from workbench.correction.conditions import stated_conditions
from workbench.correction.in_place import Corrected, compensate_program
from workbench.correction.paths import Path as JointPath
from workbench.correction.programs import find_format
from workbench.correction.programs.motions import Move
from workbench.files.faults import InputError
from workbench.robot import rotations
from workbench.robot.description import load_robot

UP = "X 1700.0,Y 0.0,Z 1300.0,A 180.0,B -60.0,C 180.0"
START = "PTP {A1 -5.0,A2 -80.0,A3 100.0,A4 5.0,A5 40.0,A6 -5.0}"
TOOL = "{X 120.0,Y 0.0,Z 300.0,A 0.0,B 90.0,C 0.0}"
GUN = rotations.pose(np.array([0.12, 0.0, 0.3]), rotations.from_zyx(np.radians([[0.0, 90.0, 0.0]]))[0])
KRL = f"DEF a( )\n$BASE=$NULLFRAME\n$TOOL={TOOL}\n{START}\nLIN {{{UP}}}\nEND\n"


def corrected(folder: Path, name: str, file: str, text: str, **options) -> tuple[Corrected, str]:
    """The program corrected for a bent robot, and its text."""
    model, _ = bent(name, folder)
    (folder / file).write_text(text)
    done = compensate_program(folder / file, model, folder / "new", **options)
    return done, done.files[0].read_text()


def moves(form: str, file: str, text: str) -> list[Move]:
    return find_format(form).scan({file: text}).moves


def test_a_tool_that_the_program_does_not_set_is_the_one_that_is_given(tmp_path: Path) -> None:
    """As where it is written there; and without any, none is taken and it is said."""
    bare = KRL.replace(f"$TOOL={TOOL}\n", "")
    _, stated = corrected(tmp_path, "kr500", "a.src", KRL)
    _, given = corrected(tmp_path, "kr500", "b.src", bare, tool=GUN)
    assert given.splitlines() == [line for line in stated.splitlines() if "$TOOL" not in line]
    up = UP.replace("B -60.0", "B -30.0")
    done, _ = corrected(tmp_path, "kr500", "c.src", bare.replace(UP, up))
    assert any("sets no tool: taken as none (--tool" in note for note in done.notes)
    assert not any("sets no base" in note for note in done.notes)


def test_a_target_of_two_tools_is_in_the_summary(tmp_path: Path) -> None:
    """One set of numbers corrects it for the first: what it leaves for the second is the error told."""
    at = "[[100.5,100.0,150.3],[0.0,0.0,1.0,0.0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    long = "PERS tooldata tLong:=[TRUE,[[0.0,0.0,250.0],[1.0,0.0,0.0,0.0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
    twice = RAPID.replace("  VAR num", f"  {long}\n  VAR num").replace(
        "    ENDFOR", "    ENDFOR\n    MoveL p10, v100, z5, tLong\\WObj:=wTable;"
    )
    done, _ = corrected(tmp_path, "irb120", "a.mod", twice)
    own, _ = corrected(
        tmp_path, "irb120", "b.mod", twice.replace("MoveL p10, v100, z5, tLong", f"MoveL {at}, v1, z5, tLong")
    )
    asked, first = own.compensation.X_command[2, :3, 3], done.compensation.X_command[1, :3, 3]
    missed = 1e3 * np.linalg.norm(asked - first)
    assert (done.shared, own.shared) == (1, 0)
    assert "3 targets corrected, 1 of them used again where another correction is right" in done.text
    assert missed > 0.02
    assert done.compensation.after_mm.max() == pytest.approx(missed, rel=0.02)
    assert done.to_json()["shared_targets"] == 1
    assert done.to_json()["after_max_mm"] == done.compensation.after_mm.max()
    assert own.compensation.after_mm.max() < 1e-3


def test_a_joint_target_before_two_tools_is_one(tmp_path: Path) -> None:
    """Its correction is that of its joints, whichever tool comes next."""
    home = "MoveAbsJ [[0.0,10.0,20.0,0.0,45.0,0.0],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs"
    named = RAPID.replace(home, "MoveAbsJ jPark").replace(
        "  VAR num", f"  CONST jointtarget jPark:={home[9:-8]};\n  VAR num"
    )
    named = named.replace("  ENDPROC", "    MoveAbsJ jPark,v1000,z50,tool0;\n  ENDPROC")
    done, _ = corrected(tmp_path, "irb120", "a.mod", named)
    assert done.shared == 0
    assert not any("used before" in note for note in done.notes)


def test_a_tool_of_the_installation_is_given(tmp_path: Path) -> None:
    tip = rotations.pose(np.array([0.0, 0.0, 0.15]), np.eye(3))
    _, stated = corrected(tmp_path, "ur10", "a.script", UR)
    line = "  set_tcp(p[0.0, 0.0, 0.15, 0.0, 0.0, 0.0])\n"
    _, given = corrected(tmp_path, "ur10", "b.script", UR.replace(line, ""), tool=tip)
    assert given == stated.replace(line, "")


def test_errors_are_those_of_the_tool_that_each_target_is_for(tmp_path: Path) -> None:
    """Not of the flange, which a tool far out leaves behind as it turns."""
    second = f"LIN {{{UP}}}\n$TOOL=$NULLFRAME\nLIN {{{UP}}}\nEND\n"
    found, _ = corrected(tmp_path, "kr500", "a.src", KRL.replace(f"LIN {{{UP}}}\nEND\n", second))
    done = found.compensation
    robot = load_robot(bent("kr500", tmp_path)[0])
    for tool, at in ((GUN, 1), (None, 2)):
        alone = compensate(robot, JointPath(done.path.time, q=done.q_nominal), tool=tool)
        assert done.before_mm[at] == pytest.approx(alone.before_mm[at], rel=1e-9)
        assert done.between[at - 1] == pytest.approx(alone.between[at - 1], abs=1e-6)  # digits written
        np.testing.assert_allclose(done.X_desired[at, :3, 3], [1.7, 0.0, 1.3], atol=1e-6)
    assert done.before_mm[1] != pytest.approx(done.before_mm[2], rel=0.02)


TWO_TOOLS = {
    "krl": (
        "kr500",
        "a.src",
        KRL.replace("END\n", "".join(f"$TOOL=TOOL_DATA[{k}]\nLIN {{{UP}}}\n" for k in (2, 3)) + "END\n"),
    ),
    "rapid": (
        "irb120",
        "a.mod",
        RAPID.replace("tooldata tGun", "tooldata tOther").replace("v50,\n      fine,tGun", "v50,fine,tNext"),
    ),
    "ls": (
        "lrmate200id",
        "a.ls",
        LS.replace("UTOOL[2]=PR", "UTOOL[4]=PR").replace("UT : 2,\t\tCONFIG", "UT : 3,\t\tCONFIG", 1),
    ),
}


@pytest.mark.parametrize(("name", "file", "text"), TWO_TOOLS.values(), ids=TWO_TOOLS)
def test_one_tool_is_not_two_of_the_controllers(tmp_path: Path, name: str, file: str, text: str) -> None:
    with pytest.raises(InputError, match=r"are not in the file, and one --tool is not all of them"):
        corrected(tmp_path, name, file, text, tool=GUN)


@pytest.mark.parametrize(("name", "file", "text"), TWO_TOOLS.values(), ids=TWO_TOOLS)
def test_each_tool_of_the_controller_is_given_by_its_name(
    tmp_path: Path, name: str, file: str, text: str
) -> None:
    form = {"src": "krl", "mod": "rapid"}.get(file[2:], file[2:])
    read = moves(form, file, text)
    names = sorted({move.tool.name for move in read if move.kind == "pose" and move.tool.X is None})
    tips = [rotations.pose(np.array([0.0, 0.0, z]), np.eye(3)) for z in (0.01, 0.02)]
    both = {key.lower(): tip for key, tip in zip(names, tips, strict=True)}
    done, _ = corrected(tmp_path, name, file, text, tool=both)
    assert done.compensation.after_mm.max() < 1e-2 < done.compensation.before_mm.max()
    with pytest.raises(InputError, match="no tool of this name stands on the controller"):
        corrected(tmp_path, name, file, text, tool=both | {"another": GUN})
    with pytest.raises(InputError, match=r"give each by its name|give it with --tool"):
        corrected(tmp_path, name, file, text, tool={names[0]: tips[0]})


def test_tools_that_are_given_are_those_that_the_program_would_set(tmp_path: Path) -> None:
    second = TOOL.replace("Z 300.0", "Z 350.0")
    twice = KRL.replace("END\n", f"$TOOL={{}}\nLIN {{{UP}}}\nEND\n".replace("{}", second))
    _, stated = corrected(tmp_path, "kr500", "a.src", twice)
    both = {"TOOL_DATA[2]": GUN, "TOOL_DATA[3]": GUN + 0.05 * np.eye(4)[:, 3] * np.eye(4)[2][:, None]}
    named = twice.replace(second, "TOOL_DATA[3]").replace(TOOL, "TOOL_DATA[2]")
    _, given = corrected(tmp_path, "kr500", "b.src", named, tool=both)
    assert [line for line in given.splitlines() if "$TOOL" not in line] == [
        line for line in stated.splitlines() if "$TOOL" not in line
    ]


def test_a_tool_beside_the_programs_own_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--tool is not that of the program"):
        corrected(tmp_path, "kr500", "a.src", KRL, tool=np.eye(4))
    assert corrected(tmp_path, "kr500", "b.src", KRL, tool=GUN)[0].targets == 2


def test_a_program_that_is_called_stands_in_the_frames_of_its_call() -> None:
    krl = (
        "DEF main( )\n$BASE={X 100.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}\n"
        f"sub( )\n$BASE=$NULLFRAME\nLIN {{{UP}}}\nEND\n"
        f"DEF sub( )\nLIN {{{UP}}}\nEND\nDEF other( )\nLIN {{{UP}}}\nEND\n"
    )
    inner, own, other = moves("krl", "a.src", krl)
    assert (inner.line, own.line, other.line) == (8, 5, 11)
    assert inner.base.matrix[0, 3] == pytest.approx(0.1)
    assert own.base.matrix[0, 3] == 0.0
    assert own.base.X is not None
    assert other.base.X is None
    ur = (
        "def job():\n  def sub():\n    if True:\n      movel(p[0.5,0,0,0,0,0])\n    end\n  end\n"
        "  set_tcp(p[0,0,0.1,0,0,0])\n  sub()\n  movel(p[0.6,0,0,0,0,0])\nend\n"
    )
    inner, own = moves("urscript", "a.script", ur)
    assert (inner.line, own.line) == (4, 9)
    assert inner.tool.matrix[2, 3] == own.tool.matrix[2, 3] == pytest.approx(0.1)


def test_external_axes_at_zero_are_none(tmp_path: Path) -> None:
    done, _ = corrected(tmp_path, "kr500", "a.src", KRL.replace(UP, f"{UP},E1 0.0,E2 0.0"))
    assert done.targets == 2
    with pytest.raises(InputError, match="line 5: has external axes that do not stand at 0"):
        corrected(tmp_path, "kr500", "b.src", KRL.replace(UP, f"{UP},E1 1500.0"))


@pytest.mark.parametrize("names", [True, False])
def test_the_load_that_the_program_states_is_carried(tmp_path: Path, names: bool) -> None:
    """Under the name that the model has for it, if it has one: as where that was said."""
    model, _ = bent("kr500", tmp_path)
    heavy = "\n[payloads.heavy]\nmass_kg = 198.0\ncom_mm = [0.0, 0.0, 150.0]\n"
    model.write_text(model.read_text() + heavy)
    com = (198 * 150 + 2 * 50) / 200
    at = f"CM {{X 0.0,Y 0.0,Z {com:.3f},A 0.0,B 0.0,C 0.0}},J {{X 0.0,Y 0.0,Z 0.0}}}}"
    (tmp_path / "plain.src").write_text(KRL)
    (tmp_path / "loaded.src").write_text(KRL.replace("$BASE", f"$LOAD={{M 200.0,{at}\n$BASE"))
    if not names:
        model.write_text(model.read_text().replace(heavy, ""))
        kept = tmp_path / "with_names.toml"
        kept.write_text(model.read_text() + heavy)
    robot = load_robot(model if names else kept)
    named = stated_conditions(robot, "heavy")
    wanted = compensate_program(tmp_path / "plain.src", robot.path, tmp_path / "x", conditions=named)
    done = compensate_program(tmp_path / "loaded.src", model, tmp_path / "y")
    told = [line for line in done.files[0].read_text().splitlines() if "$LOAD" not in line]
    assert told == wanted.files[0].read_text().splitlines()
    assert any("200 kg" in note and ("'heavy'" in note) == names for note in done.notes)
    unloaded = compensate_program(tmp_path / "plain.src", model, tmp_path / "z").files[0].read_text()
    assert unloaded.splitlines() != told


def test_loads_that_change_are_not_taken_for_one(tmp_path: Path) -> None:
    twice = UR.replace("  movel(wait_here", "  set_payload(8.0, [0,0,0.1])\n  movel(wait_here").replace(
        "  set_digital", "  set_payload(3.0, [0,0,0.1])\n  set_digital"
    )
    with pytest.raises(InputError, match="carries 8 kg at 0, 0, 100 mm, then 3 kg"):
        corrected(tmp_path, "ur10", "a.script", twice)


def test_a_target_is_reached_near_the_joints_that_it_names() -> None:
    near = "movej(get_inverse_kin(p[0.5,0,0.3,0,3.1,0], qnear=[1,2,3,4,5,6]))"
    text = f"def a():\n  {near}\n  movej(p[0.5,0,0.3,0,3,0])\nend\n"
    near, free = moves("urscript", "a.script", text)
    assert near.near == (1, 2, 3, 4, 5, 6)
    assert near.free
    assert free.near is None


def test_near_the_joints_that_it_names_other_postures_are_not_asked_for(tmp_path: Path) -> None:
    joints = "[-0.3, -1.57, 1.6, -1.6, -1.57, 0.0]"
    first = f"movej({joints}, a=1.2, v=0.75)\n  movel(wait_here"
    near = UR.replace(first, f"movej(get_inverse_kin(wait_here, qnear={joints})")
    assert near != UR
    done, told = corrected(tmp_path, "ur10", "a.script", near)
    _, stated = corrected(tmp_path, "ur10", "b.script", UR)
    assert not any("posture" in note for note in done.notes)
    assert told.splitlines()[3] == stated.splitlines()[3]  # wait_here


def test_data_of_a_routine_are_its_own() -> None:
    target = "[[{x}.0,0.0,400.0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    module = "MODULE m\n" + "".join(
        f"PROC {name}()\nVAR robtarget q:={target.format(x=x)}\nMoveL q,v100,fine,tool0;\nENDPROC\n"
        for name, x in (("a", 300), ("b", 400))
    )
    one, two = moves("rapid", "m.mod", module + "ENDMODULE\n")
    assert (one.X[0, 3], two.X[0, 3]) == (0.3, 0.4)
    assert one.spot != two.spot


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("tGun:=[TRUE", "tGun:=[FALSE", "stands still"),
        ("wTable:=[FALSE,TRUE", "wTable:=[FALSE,FALSE", "is moved by a robot or an axis"),
    ],
)
def test_what_the_robot_does_not_hold_or_stand_before_is_left_alone(old: str, new: str, what: str) -> None:
    assert old in RAPID
    read = find_format("rapid").scan({"a.mod": RAPID.replace(old, new)})
    assert sum(what in fault.what for fault in read.faults) >= 2
    assert not [move for move in read.moves if move.kind == "pose"]


def test_numbers_that_are_computed_are_no_numbers() -> None:
    read = find_format("krl").scan({"a.src": KRL.replace("X 1700.0", "X 1700.0+DX")})
    assert [move.kind for move in read.moves] == ["joints"]
    assert "no whole position" in read.faults[0].what
    said = 'def a():\n  textmsg("movel(p[1,2,3,4,5,6])")\n  movel(p[0.5,0,0,0,0,0])\nend\n'
    assert len(moves("urscript", "a.script", said)) == 1


def test_a_singular_home_is_left_alone(tmp_path: Path) -> None:
    home = "MoveAbsJ [[0.0,0.0,0.0,0.0,0.0,0.0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000,z50,tGun;\n    MoveAbsJ"
    done, text = corrected(tmp_path, "irb120", "a.mod", RAPID.replace("MoveAbsJ", home, 1))
    assert any("left alone" in note and "near-singular" in note for note in done.notes)
    assert "MoveAbsJ [[0.0,0.0,0.0,0.0,0.0,0.0]" in text
    _, without = corrected(tmp_path, "irb120", "b.mod", RAPID)
    assert text.replace(home[: home.index("MoveAbsJ", 5)], "", 1) == without


def test_a_line_that_cannot_be_reached_is_one_fault(tmp_path: Path) -> None:
    """Of however many samples on the way."""
    far = f"LIN {{{UP.replace('X 1700.0', 'X 4200.0')}}}\nEND\n"
    with pytest.raises(InputError, match="cannot get there") as caught:
        corrected(tmp_path, "kr500", "a.src", KRL.replace("END\n", far))
    assert [fault.place for fault in caught.value.faults] == ["a.src line 6"]
