"""VAL 3 as it is written in shops: calls, frames on frames, loops, and what has to be told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from test_program_in_place import VAL3, bent, flanges, in_drake, start_of
from test_program_unread import only_told

from workbench.cli.main import main
from workbench.correction.in_place import compensate_program
from workbench.correction.programs import find_format
from workbench.correction.programs.motions import Motions
from workbench.files.faults import InputError

DATA = """<Database xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><Datas>
<Data name="p" type="pointRx" size="4">
<Value key="0" x="1" fatherId="world[0]"/><Value key="1" x="2" fatherId="fPart[0]"/>
<Value key="2" x="3" fatherId="world[0]"/><Value key="3" x="4" fatherId="world[0]"/></Data>
<Data name="fCell" type="frame" size="1"><Value key="0" x="100" rz="90" fatherId="world[0]"/></Data>
<Data name="fPart" type="frame" size="1"><Value key="0" y="10" fatherId="fCell[0]"/></Data>
<Data name="tHead" type="tool" size="1"><Value key="0" z="200" ry="90" fatherId="flange[0]"/></Data>
<Data name="tMill" type="tool" size="1"><Value key="0" z="30" fatherId="tHead[0]"/></Data>
<Data name="tBare" type="tool" size="1"><Value key="0" z="30"/></Data>
<Data name="m" type="mdesc" size="1"><Value key="0" vel="50"/></Data>
</Datas></Database>"""


def program(name: str, *lines: str, own: str = "") -> str:
    code = "\n".join(["begin", *lines, "end"])
    return f'<Programs><Program name="{name}">{own}\n<Code><![CDATA[{code}]]></Code></Program></Programs>'


def val3(*lines: str, own: str = "", unit: str = "true", **others: str) -> Motions:
    files = {"a.pjx": f'<Project><Parameters millimeterUnit="{unit}"/></Project>', "a.dtx": DATA}
    files["start.pgx"] = program("start", *lines, own=own)
    return find_format("val3").scan(files | {f"{name}.pgx": text for name, text in others.items()})


def entries(motions: Motions) -> list[int]:
    """Numbers of the points of p."""
    return [round(1e3 * move.X[0, 3]) - 1 for move in motions.moves if move.X is not None]


def test_programs_are_read_where_they_are_called_and_lines_are_those_of_their_files() -> None:
    motions = val3(
        "movel(p[0],tBare,m)",
        "call weld()",
        "movel(p[3],tBare,m)",
        weld=program("weld", 'put("// no comment")', "movel(p[2],tBare,m)"),
        stop=program("stop", "movel(p[0],tBare,m)"),
    )
    assert entries(motions) == [0, 2, 3, 0]
    places = ["start.pgx line 3", "weld.pgx line 4", "start.pgx line 5", "stop.pgx line 3"]
    assert [move.place for move in motions.moves] == places
    assert [move.anew for move in motions.moves] == [False, False, False, True]


def test_frames_and_tools_stand_on_others() -> None:
    """By hand: fPart is at (100, 0) + Rz(90) (0, 10) = (90, 0), so that x = 2 is (90, 2) in the world; the
    mill's tip is 30 along the head's z, which is the flange's x."""
    (move,) = val3("movel(p[1],tMill,m)").moves
    assert move.X is not None
    np.testing.assert_allclose((move.base.matrix @ move.X)[:3, 3], [0.09, 0.002, 0.0], atol=1e-12)
    np.testing.assert_allclose(move.tool.matrix[:3, 3], [0.03, 0.0, 0.2], atol=1e-12)


@pytest.mark.parametrize(
    ("line", "move", "what"),
    [
        ("tMill.trsf.z=5", "movel(p[0],tMill,m)", "the tool tMill is no data alone"),
        ("tHead.trsf={0,0,1,0,0,0}", "movel(p[0],tMill,m)", "the tool tMill is no data alone"),
        ("fCell.trsf.x=5", "movel(p[1],tBare,m)", "stands in fPart[0], which is no frame of the data alone"),
        ("nErr=setFrame(p[0],p[2],p[3],fPart)", "movel(p[1],tBare,m)", "stands in fPart[0]"),
        ("link(p[0],fCell)", "movel(p[0],tBare,m)", "p is set in a program"),
        ("p[n[1]].trsf.z=5", "movel(p[0],tBare,m)", "p is set in a program"),
        ("call find(p[0])", "movel(p[0],tBare,m)", "p is set in a program"),
        ("", "alterMovel(p[0],tBare,m)", "alterMovel cannot be read"),
        ("", "movejf(p[0],tBare,m)", "movejf cannot be read"),
        ("", "movel(x_p,tBare,m)", "movel(x_p, ...) cannot be read"),
        ("", "movel(p[nNow],tBare,m)", "movel(p[nNow], ...) cannot be read"),
    ],
)
def test_what_programs_set_or_cannot_be_read_is_told_with_its_line(line: str, move: str, what: str) -> None:
    takes = '<Parameters><Parameter name="x_pOut" type="pointRx" use="reference"/></Parameters>'
    motions = val3(line, move, find=program("find", "x_pOut=here(tBare,world)", own=takes))
    only_told(motions, what)
    assert motions.faults[0].place == "start.pgx line 4"


def test_local_data_hide_those_of_the_application() -> None:
    local = '<Locals><Local name="p" type="pointRx" size="1"/></Locals>'
    only_told(val3("movel(p[0],tBare,m)", own=local), "cannot be read")


def test_a_movement_that_gives_its_number_back_is_one() -> None:
    assert entries(val3("nId=movel(p[0],tBare,m)", "l_n[2] = movej(p[2],tBare,m)")) == [0, 2]


@pytest.mark.parametrize(
    ("loop", "which"),
    [
        ("for i=0 to 3 step 3", [0, 3]),
        ("for i = 3 to 2 step -1", [3, 2]),
        ("for i=2 to size(p)-1", [2, 3]),
        ("for i=0 to nLast", []),
    ],
)
def test_loops_go_where_they_say(loop: str, which: list[int]) -> None:
    motions = val3(loop, "movel(p[i],tBare,m)", "endFor")
    assert entries(motions) == which
    assert len(motions.faults) == (not which)


def test_loops_stand_within_loops() -> None:
    lines = [
        "for i=2 to 3",
        "for k=0 to 1",
        "movel(p[k+2],tBare,m)",
        "endFor",
        "movel(p[i],tBare,m)",
        "endFor",
    ]
    assert entries(val3(*lines)) == [2, 3, 2, 2, 3, 3]


def test_inches_are_refused() -> None:
    with pytest.raises(InputError, match=r"a\.pjx: is in inches"):
        val3("movel(p[0],tBare,m)", unit="false")


def test_what_is_wrong_is_refused_with_file_and_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, _ = bent("rx170", tmp_path)
    far = VAL3["Edge.dtx"].replace('x="1337.977"', 'x="9337.977"')
    for name, text in {**VAL3, "Edge.dtx": far}.items():
        (tmp_path / name).write_text(text)
    assert main(["compensate", str(tmp_path / "Edge.pjx"), "--model", str(model)]) == 2
    assert "start.pgx line 7: the tool cannot get there" in capsys.readouterr().err
    assert not (tmp_path / "Edge_compensated").exists()


def test_points_in_frames_of_frames_are_right_in_drake(tmp_path: Path) -> None:
    """Told the numbers of the new files, the true arm's flange is where the old ones meant it to be."""
    model, robot = bent("rx170", tmp_path)
    cell = '<Data name="fCell" type="frame" size="1"><Value key="0" x="50" z="-40" rz="12" ry="3"/></Data>'
    part = '<Data name="fPart" type="frame" size="1"><Value key="0" y="20" fatherId="fCell[0]"/></Data>'
    data = VAL3["Edge.dtx"].replace("  <Datas>", f"  <Datas>{cell}{part}")
    texts = {**VAL3, "Edge.dtx": data.replace('fatherId="world[0]"', 'fatherId="fPart[0]"')}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    done = compensate_program(tmp_path / "Edge.pjx", model)
    new = {file.name: file.read_text() for file in done.files}
    start = start_of(robot, "val3", texts)
    old, told = flanges(robot, "val3", texts), flanges(robot, "val3", new)
    assert in_drake(robot, old, old, start).max() > 2e-4
    assert in_drake(robot, old, told, start).max() < 5e-6
    assert json.dumps(done.to_json())
