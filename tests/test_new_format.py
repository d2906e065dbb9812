"""A new controller format is one new file: found, checked, written from the command line, and read back."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from program_paths import read_program

from workbench import compensate, load_path, load_robot
from workbench.cli.main import main
from workbench.correction import programs
from workbench.robot import rotations

GCODE = '''
"""G-code: straight lines of the tool in mm, turned by Rz(A) Ry(B) Rx(C) in degrees, F in mm/min."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from workbench.correction.programs.base import Program, legs_of
from workbench.correction.programs.format import NUMBER, Format
from workbench.correction.programs.motions import Motions
from workbench.files.faults import Fault
from workbench.robot import rotations

MM_PER_MIN = 6e4  # in a m/s


class GCode(Format):
    name, title, extension, newline = "gcode", "G-code", ".nc", "\\n"
    carries_tool = False

    def check(self, program: Program) -> list[Fault]:
        joints = Fault(f"program {program.name!r}", "has joint targets, G-code takes poses", "use csv")
        return [joints] if program.kind == "joints" else super().check(program)

    def write(self, program: Program) -> dict[str, str]:
        legs = legs_of(program)
        rows = np.hstack([1e3 * program.X[:, :3, 3], np.degrees(rotations.zyx_angles(program.X[:, :3, :3]))])
        lines = [f"({program.name})", "G21 G90"]
        for row, speed, pause in zip(rows, legs.speed, legs.pause, strict=True):
            words = " ".join(f"{axis}{value:.4f}" for axis, value in zip("XYZABC", row, strict=True))
            lines.append(f"G1 {words} F{MM_PER_MIN * speed:.4f}")
            lines += [f"G4 P{pause:.3f}"] if pause > 0 else []
        return {f"{program.name}{self.extension}": "\\n".join([*lines, "M30", ""])}

    def read(self, files: Mapping[str, str]) -> Program:
        place, text = next(iter(files.items()))
        motions = Motions(place)
        for number, line in enumerate(text.splitlines(), 1):
            if named := re.match(r"\\((\\w+)\\)", line):
                motions.name = named[1]
            words = {letter: float(value) for letter, value in re.findall(rf"([A-Z])({NUMBER})", line)}
            if words.get("G") == 4:
                motions.wait(words["P"])
            elif words.get("G") == 1 and not {*"XYZABCF"} <= words.keys():
                motions.fault(number, "a line without all of X Y Z A B C F", "give each in every line")
            elif words.get("G") == 1:
                place_mm, angles = ([[words[axis] for axis in axes]] for axes in ("XYZ", "ABC"))
                R = rotations.from_zyx(np.radians(angles))
                motions.pose(rotations.pose(np.array(place_mm) / 1e3, R)[0], speed=words["F"] / MM_PER_MIN)
        return motions.program()
'''


@pytest.fixture
def gcode(tmp_path, monkeypatch):
    folder = tmp_path / "formats"
    folder.mkdir()
    (folder / "gcode.py").write_text(GCODE)
    monkeypatch.setattr(programs, "__path__", [*programs.__path__, str(folder)])
    programs.formats.cache_clear()
    yield programs.find_format("gcode")
    programs.formats.cache_clear()
    sys.modules.pop("workbench.correction.programs.gcode", None)


def test_a_new_format_is_one_new_file(gcode, tmp_path, capsys):
    rows = [f"{0.1 * i:.1f},{0.2 * i - 5},-70,90,5,45,0" for i in range(20)]
    header = "t_s," + ",".join(f"q{j}_deg" for j in range(1, 7))
    table, program = tmp_path / "path.csv", tmp_path / "seam.nc"
    table.write_text("\n".join([header, *rows, ""]))
    robot = load_robot("kr500")
    arguments = ["compensate", table, "--model", robot.path, "--format", "gcode", "--out", program]
    assert main([str(word) for word in arguments]) == 0
    assert "rounding moves the tool by" in capsys.readouterr().out
    back = read_program(program, "gcode")
    wanted = compensate(robot, load_path(table, robot)).program("seam", "poses")
    assert back.name == "seam"
    np.testing.assert_allclose(back.X[:, :3, 3], wanted.X[:, :3, 3], atol=1e-7)
    assert rotations.angle_between(back.X[:, :3, :3], wanted.X[:, :3, :3]).max() < 1e-5
    np.testing.assert_allclose(back.time, wanted.time - wanted.time[0], atol=1e-4)


def test_a_format_that_is_not_there_is_a_fault_with_the_names(tmp_path, capsys):
    arguments = [
        "compensate",
        tmp_path / "path.csv",
        "--model",
        load_robot("kr500").path,
        "--format",
        "cobol",
    ]
    assert main([str(word) for word in arguments]) == 2
    assert (
        "format 'cobol': no such format; one of csv, krl, ls, rapid, urscript, val3"
        in capsys.readouterr().err
    )
